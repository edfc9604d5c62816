//! Dropouts and rates of a channel, from the times of its samples in order.
//!
//! Consumes times, s, one by one; produces [`Dropout`]s and [`RateChange`]s. The usual interval T is the mean of those that are
//! between [`SHORT`] and [`LONG`] medians of the first [`LEARNED`], and then follows those between [`SHORT`] T and [`LONG`] T as
//! the mean of about the last [`FOLLOWED`]: a median alone is biased where stamps jitter to one side. A longer interval is
//! a dropout of round(interval/T) - 1 samples, unless [`CONFIRMING`] such intervals in a row agree with each other: then the rate
//! has changed where the first of them begins. What lies before the rate is known is judged when it is, and at the end.
//! Memory: [`LEARNED`] intervals a channel, nothing is allocated.

/// Intervals from which the rate is learned.
pub const LEARNED: usize = 16;
/// Intervals in a row that confirm another rate.
pub const CONFIRMING: usize = 8;
/// Shorter and longer intervals, in usual ones, are odd.
pub const SHORT: f64 = 0.6;
/// From here on at least one sample is missing.
pub const LONG: f64 = 1.6;
/// Intervals agree within this part of their median.
const AGREE: f64 = 0.25;
/// Intervals that the usual one is the mean of.
pub const FOLLOWED: u32 = 256;

/// A time without samples of a channel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Dropout {
    /// Which channel.
    pub channel: usize,
    /// Last sample before, s.
    pub from_s: f64,
    /// First sample after, s.
    pub to_s: f64,
    /// Samples that are missing, at the channel's own rate.
    pub missing: u64,
}

impl Dropout {
    /// Time between the samples, s.
    pub fn duration_s(&self) -> f64 {
        self.to_s - self.from_s
    }
}

/// A new rate of a channel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RateChange {
    /// Which channel.
    pub channel: usize,
    /// Where it begins, s.
    pub at_s: f64,
    /// Rate before, Hz.
    pub from_hz: f64,
    /// Rate from there on, Hz.
    pub to_hz: f64,
}

/// What the monitor found.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum IntervalFinding {
    /// Samples are missing.
    Dropout(Dropout),
    /// The rate is another one.
    RateChange(RateChange),
}

/// The times of one channel.
#[derive(Clone, Copy, Debug)]
pub struct IntervalMonitor {
    channel: usize,
    last_s: Option<f64>,
    usual_s: Option<f64>,
    /// Intervals that it is the mean of.
    averaged: u32,
    /// Intervals that wait for a judgement, each with its begin: all until the rate is known, then the odd ones.
    waiting: [(f64, f64); LEARNED],
    count: usize,
}

impl IntervalMonitor {
    /// Of that channel.
    pub fn new(channel: usize) -> Self {
        IntervalMonitor { channel, last_s: None, usual_s: None, averaged: 0, waiting: [(0.0, 0.0); LEARNED], count: 0 }
    }

    /// The rate, Hz; `None` until it is known.
    pub fn rate_hz(&self) -> Option<f64> {
        self.usual_s.map(f64::recip)
    }

    /// Takes the next sample's time, s; one that does not go forward means nothing.
    pub fn take(&mut self, time_s: f64, put: &mut impl FnMut(IntervalFinding)) {
        let Some(last_s) = self.last_s else {
            self.last_s = Some(time_s);
            return;
        };
        let interval_s = time_s - last_s;
        if !(interval_s > 0.0) {
            return;
        }
        self.last_s = Some(time_s);
        let Some(usual_s) = self.usual_s else {
            self.wait(last_s, interval_s);
            if self.count == LEARNED {
                self.learn(put);
            }
            return;
        };
        if interval_s > SHORT * usual_s && interval_s < LONG * usual_s {
            self.settle(usual_s, put);
            self.averaged = (self.averaged + 1).min(FOLLOWED);
            self.usual_s = Some(usual_s + (interval_s - usual_s) / f64::from(self.averaged));
            return;
        }
        self.wait(last_s, interval_s);
        if self.count < CONFIRMING {
            return;
        }
        let (median_s, mean_s, averaged) = self.median_and_mean_s();
        let agree = self.waiting().iter().filter(|(_, interval)| libm::fabs(interval - median_s) <= AGREE * median_s).count();
        if 4 * agree >= 3 * CONFIRMING {
            let at_s = self.waiting().first().map_or(last_s, |(from_s, _)| *from_s);
            let (from_hz, to_hz) = (usual_s.recip(), mean_s.recip());
            put(IntervalFinding::RateChange(RateChange { channel: self.channel, at_s, from_hz, to_hz }));
            (self.usual_s, self.averaged) = (Some(mean_s), averaged);
            self.settle(mean_s, put);
        } else {
            // Irregular: the oldest is judged by the rate that was, the others wait on.
            if let Some(&(from_s, interval_s)) = self.waiting().first() {
                self.judge(from_s, interval_s, usual_s, put);
            }
            self.waiting.copy_within(1..self.count, 0);
            self.count -= 1;
        }
    }

    /// The silence from the last sample to where another clock begins is no dropout: that is not known.
    pub fn restart(&mut self, put: &mut impl FnMut(IntervalFinding)) {
        self.finish(put);
        self.last_s = None;
    }

    /// No more will come.
    pub fn finish(&mut self, put: &mut impl FnMut(IntervalFinding)) {
        match self.usual_s {
            Some(usual_s) => self.settle(usual_s, put),
            None if self.count > 0 => self.learn(put),
            None => {}
        }
    }

    fn wait(&mut self, from_s: f64, interval_s: f64) {
        if let Some(place) = self.waiting.get_mut(self.count) {
            *place = (from_s, interval_s);
            self.count += 1;
        }
    }

    fn waiting(&self) -> &[(f64, f64)] {
        self.waiting.get(..self.count).unwrap_or(&[])
    }

    /// Of what waits: the median, and the mean of those near it with their number.
    fn median_and_mean_s(&self) -> (f64, f64, u32) {
        let mut sorted = [f64::INFINITY; LEARNED];
        sorted.iter_mut().zip(self.waiting()).for_each(|(place, (_, interval))| *place = *interval);
        sorted.sort_unstable_by(f64::total_cmp);
        let median_s = sorted.get(self.count.saturating_sub(1) / 2).copied().unwrap_or(f64::INFINITY);
        let usual = |interval: &&f64| **interval > SHORT * median_s && **interval < LONG * median_s;
        let (sum, count) = sorted.iter().filter(usual).fold((0.0, 0), |(sum, count), interval| (sum + interval, count + 1));
        (median_s, if count > 0 { sum / f64::from(count) } else { median_s }, count.max(1))
    }

    fn learn(&mut self, put: &mut impl FnMut(IntervalFinding)) {
        let (_, mean_s, averaged) = self.median_and_mean_s();
        (self.usual_s, self.averaged) = (Some(mean_s), averaged);
        self.settle(mean_s, put);
    }

    /// Judges all that waits.
    fn settle(&mut self, usual_s: f64, put: &mut impl FnMut(IntervalFinding)) {
        for k in 0..self.count {
            if let Some(&(from_s, interval_s)) = self.waiting.get(k) {
                self.judge(from_s, interval_s, usual_s, put);
            }
        }
        self.count = 0;
    }

    fn judge(&self, from_s: f64, interval_s: f64, usual_s: f64, put: &mut impl FnMut(IntervalFinding)) {
        let ratio = interval_s / usual_s;
        if ratio >= LONG {
            #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "at least one; saturates")]
            let missing = (libm::round(ratio) - 1.0).max(1.0) as u64;
            put(IntervalFinding::Dropout(Dropout { channel: self.channel, from_s, to_s: from_s + interval_s, missing }));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn found(times: impl IntoIterator<Item = f64>) -> (Vec<Dropout>, Vec<RateChange>) {
        let (mut dropouts, mut changes) = (Vec::new(), Vec::new());
        let mut put = |finding| match finding {
            IntervalFinding::Dropout(dropout) => dropouts.push(dropout),
            IntervalFinding::RateChange(change) => changes.push(change),
        };
        let mut monitor = IntervalMonitor::new(3);
        times.into_iter().for_each(|time_s| monitor.take(time_s, &mut put));
        monitor.finish(&mut put);
        (dropouts, changes)
    }

    #[test]
    fn missing_samples_are_counted_at_the_channels_own_rate_with_their_place() {
        // 10 Hz with 5 lost while the rate is learned, one lost later, and the last 20 before the end.
        let lost = |k: &u32| !(6..11).contains(k) && *k != 60 && !(80..100).contains(k);
        let (dropouts, changes) = found((0..=100).filter(lost).map(|k| 0.1 * f64::from(k) + 0.01 * f64::from(k % 3)));
        assert!(changes.is_empty());
        let table: Vec<(f64, u64)> = dropouts.iter().map(|row| ((100.0 * row.from_s).round() / 100.0, row.missing)).collect();
        assert_eq!(table, [(0.52, 5), (5.92, 1), (7.91, 20)]);
        assert!((dropouts[0].duration_s() - 0.6).abs() < 0.03 && dropouts[0].channel == 3);
    }

    #[test]
    fn another_rate_is_no_dropout() {
        for (before, after) in [(0.02, 0.1), (0.1, 0.02)] {
            let from = |k: u32| if k < 200 { before * f64::from(k) } else { before * 199.0 + after * f64::from(k - 199) };
            let (dropouts, changes) = found((0..400).filter(|k| *k != 300).map(from));
            let [change] = changes[..] else { panic!("{changes:?}") };
            assert!((change.at_s - before * 199.0).abs() < 1e-9, "{change:?}");
            assert!((change.from_hz * before - 1.0).abs() < 1e-6 && (change.to_hz * after - 1.0).abs() < 1e-6, "{change:?}");
            let [dropout] = dropouts[..] else { panic!("{dropouts:?}") };
            assert!(dropout.missing == 1 && (dropout.duration_s() - 2.0 * after).abs() < 1e-9);
        }
    }

    #[test]
    fn few_samples_are_judged_at_the_end_and_irregular_ones_by_the_rate_that_was() {
        let (dropouts, _) = found([0.0, 1.0, 2.0, 5.0, 6.0]);
        assert_eq!(dropouts, [Dropout { channel: 3, from_s: 2.0, to_s: 5.0, missing: 2 }]);
        assert_eq!(found([4.0]), (vec![], vec![]));
        let mut time_s = 2.0;
        let irregular = (0..40).map(|k| {
            time_s += [0.3, 1.1, 0.5, 2.0, 0.25][k % 5];
            time_s
        });
        let regular: Vec<f64> = (0..=20).map(|k| 0.1 * f64::from(k)).collect();
        let (dropouts, changes) = found(regular.into_iter().chain(irregular));
        assert!(changes.is_empty());
        assert_eq!(dropouts.len(), 40);
        // 3, 11, 5, 20 and 2.5 (to the even or odd) intervals.
        assert_eq!(dropouts.iter().take(4).map(|row| row.missing).collect::<Vec<_>>(), [2, 10, 4, 19]);
    }
}
