//! What was seen in the rows of a recording: counts, ranges, rates, gaps.
//!
//! Consumes rows one by one; produces counts and order statistics of the times between samples, in bounded memory.
//! The rate is 1 / the median interval. A gap is an interval longer than five medians and than half a second.

use sideslip::flight::channel::Channel;
use sideslip::flight::file::run_file::{RecordingColumn, RecordingTarget};
use sideslip::flight::signal::GAP_S;
use sideslip::io::telemetry::record::RecordingRow;
use std::collections::BTreeMap;

/// Shorter intervals are no gaps, median intervals.
const GAP_MEDIANS: f64 = 5.0;
/// Different intervals kept apart; any further one counts as its nearest shorter neighbour.
const INTERVALS_MAX: usize = 1 << 16;
/// Intervals over half a second that are remembered with their place.
const LONG_MAX: usize = 10_000;

/// A time without samples, s.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Gap {
    pub(super) from_s: f64,
    /// The first sample after it.
    pub(super) to_s: f64,
}

/// The times of a series of samples.
#[derive(Debug, Default)]
pub(super) struct Times {
    last_s: Option<f64>,
    /// Earliest and latest, s.
    pub(super) range_s: Option<(f64, f64)>,
    /// How often the time stood still.
    pub(super) duplicates: u64,
    pub(super) went_back: u64,
    /// How often it was no number.
    pub(super) not_finite: u64,
    /// How many intervals there are of each length in ns.
    intervals: BTreeMap<u64, u64>,
    long: Vec<Gap>,
}

impl Times {
    fn add(&mut self, time_s: f64) {
        if !time_s.is_finite() {
            self.not_finite += 1;
            return;
        }
        self.range_s = Some(self.range_s.map_or((time_s, time_s), |(from, to)| (from.min(time_s), to.max(time_s))));
        if let Some(last_s) = self.last_s.replace(time_s) {
            let interval_s = time_s - last_s;
            if interval_s > 0.0 {
                self.add_interval(interval_s);
                if interval_s > GAP_S && self.long.len() < LONG_MAX {
                    self.long.push(Gap { from_s: last_s, to_s: time_s });
                }
            } else if interval_s < 0.0 {
                self.went_back += 1;
            } else {
                self.duplicates += 1;
            }
        }
    }

    fn add_interval(&mut self, interval_s: f64) {
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "positive; saturates at 584 years")]
        let mut key = (libm::round(interval_s * 1e9) as u64).max(1);
        if self.intervals.len() >= INTERVALS_MAX && !self.intervals.contains_key(&key) {
            key = self.intervals.range(..key).next_back().or(self.intervals.first_key_value()).map_or(key, |(&near, _)| near);
        }
        *self.intervals.entry(key).or_default() += 1;
    }

    /// The median interval, s (of an even number the shorter of the middle two); `None` of fewer than two samples.
    pub(super) fn median_s(&self) -> Option<f64> {
        let half = self.intervals.values().sum::<u64>().div_ceil(2);
        let mut below = 0;
        self.intervals.iter().find_map(|(&key, &count)| {
            below += count;
            #[expect(clippy::cast_precision_loss, reason = "below 2^53 ns, 104 days")]
            (below >= half).then(|| key as f64 / 1e9)
        })
    }

    /// 1 / the median interval, Hz.
    pub(super) fn rate_hz(&self) -> Option<f64> {
        self.median_s().map(f64::recip)
    }

    /// The gaps in order.
    pub(super) fn gaps(&self) -> impl Iterator<Item = Gap> {
        let least = self.median_s().map_or(GAP_S, |median| GAP_S.max(GAP_MEDIANS * median));
        self.long.iter().copied().filter(move |gap| gap.to_s - gap.from_s > least)
    }

    /// The longest gap, s.
    pub(super) fn longest_gap_s(&self) -> Option<f64> {
        self.gaps().map(|gap| gap.to_s - gap.from_s).reduce(f64::max)
    }
}

/// What was seen in one column.
#[derive(Debug)]
pub(super) struct ColumnSurvey {
    pub(super) column: RecordingColumn,
    /// How many cells were not empty.
    pub(super) samples: u64,
    /// How many of them were NaN or infinite.
    pub(super) not_finite: u64,
    /// Least and greatest of the finite ones, SI (as it came where the column is not known).
    pub(super) range: Option<(f64, f64)>,
    pub(super) times: Times,
}

impl ColumnSurvey {
    fn add(&mut self, time_s: f64, value: f64) {
        self.samples += 1;
        if time_s.is_finite() {
            self.times.add(time_s);
        }
        if value.is_finite() {
            self.range = Some(self.range.map_or((value, value), |(least, greatest)| (least.min(value), greatest.max(value))));
        } else {
            self.not_finite += 1;
        }
    }

    /// Whether two finite values differ.
    pub(super) fn moves(&self) -> bool {
        self.range.is_some_and(|(least, greatest)| least < greatest)
    }

    /// The channel, where the column is known.
    pub(super) fn channel(&self) -> Option<Channel> {
        match self.column.target {
            RecordingTarget::Known { channel, .. } => Some(channel),
            RecordingTarget::Time { .. } | RecordingTarget::Other => None,
        }
    }
}

/// What was seen in a whole recording.
#[derive(Debug)]
pub(super) struct Survey {
    /// How many rows could be read.
    pub(super) rows: u64,
    pub(super) times: Times,
    /// The columns in the order of the file, without the time.
    pub(super) columns: Vec<ColumnSurvey>,
}

impl Survey {
    pub(super) fn new(columns: &[RecordingColumn]) -> Self {
        let survey = |column: &RecordingColumn| ColumnSurvey {
            column: column.clone(),
            samples: 0,
            not_finite: 0,
            range: None,
            times: Times::default(),
        };
        let columns =
            columns.iter().filter(|column| !matches!(column.target, RecordingTarget::Time { .. })).map(survey).collect();
        Survey { rows: 0, times: Times::default(), columns }
    }

    pub(super) fn add(&mut self, row: &RecordingRow) {
        let time_s = row.sample.time_s;
        self.rows += 1;
        self.times.add(time_s);
        let mut others = row.others.iter().copied();
        for column in &mut self.columns {
            let value = match column.channel() {
                Some(channel) => row.sample.get(channel),
                None => others.next().flatten(),
            };
            if let Some(value) = value {
                column.add(time_s, value);
            }
        }
    }

    /// What was seen of a channel, where at least one value of it is a number.
    pub(super) fn of(&self, channel: Channel) -> Option<&ColumnSurvey> {
        self.columns.iter().find(|column| column.channel() == Some(channel) && column.range.is_some())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn median_rate_gaps_and_disorder_are_those_counted_by_hand() {
        let mut times = Times::default();
        // Intervals: 0.1 three times, 0.6 (a gap: over 0.5 and over five medians), back by 0.2, still, no number, 0.1.
        for time_s in [0.0, 0.1, 0.2, 0.3, 0.9, 0.7, 0.7, f64::NAN, 0.8] {
            times.add(time_s);
        }
        assert_eq!((times.duplicates, times.went_back, times.not_finite), (1, 1, 1));
        assert_eq!((times.median_s(), times.rate_hz()), (Some(0.1), Some(10.0)));
        assert_eq!(times.gaps().collect::<Vec<_>>(), [Gap { from_s: 0.3, to_s: 0.9 }]);
        assert_eq!(times.range_s, Some((0.0, 0.9)));
    }

    #[test]
    fn a_slow_channel_has_no_gap_at_its_own_rate() {
        let mut times = Times::default();
        (0..50).map(f64::from).for_each(|time_s| times.add(time_s));
        times.add(54.0);
        assert_eq!((times.rate_hz(), times.longest_gap_s()), (Some(1.0), None));
        times.add(60.0);
        assert_eq!(times.longest_gap_s(), Some(6.0));
    }

    #[test]
    fn intervals_take_bounded_memory_and_keep_their_median() {
        let mut times = Times::default();
        let mut time_s = 0.0;
        for step in 0..200_000_u32 {
            time_s += 0.01 + 1e-9 * f64::from(step % 100_000);
            times.add(time_s);
        }
        assert!(times.intervals.len() <= INTERVALS_MAX);
        assert!((times.median_s().unwrap() - 0.010_05).abs() < 1e-6);
    }
}
