//! One channel of a run over time, with its white noise: values between samples, local lines, means over intervals.
//!
//! Consumes samples of increasing time at any rate; those that are no number or go back in time are left out.

use super::GAP_S;
use super::series::Series;
use super::white_noise::white_noise_std_trimmed;
use crate::flight::channel::Channel;
use crate::flight::sample::Sample;

/// Fewer readings are no channel.
const READINGS_MIN: usize = 20;

/// A channel's readings.
#[derive(Clone, Debug, PartialEq)]
pub struct Trace {
    series: Series,
    noise: f64,
    interval_s: f64,
}

/// A straight line through readings about one time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LocalLine {
    /// Value there.
    pub value: f64,
    /// Slope there, a second.
    pub slope: f64,
    /// Standard error of the value by white noise.
    pub value_std: f64,
    /// Standard error of the slope by white noise.
    pub slope_std: f64,
}

impl Trace {
    /// The channel, where it was sampled often enough.
    pub fn of(samples: &[Sample], channel: Channel) -> Option<Trace> {
        Trace::through(samples.iter().filter_map(|sample| Some((sample.time_s, sample.get(channel)?))))
    }

    /// Readings as such.
    pub fn through(readings: impl IntoIterator<Item = (f64, f64)>) -> Option<Trace> {
        let series = Series::of(readings);
        if series.len() < READINGS_MIN {
            return None;
        }
        let mut intervals: Vec<f64> = series.times_s().array_windows().map(|[before_s, after_s]| after_s - before_s).collect();
        intervals.sort_by(f64::total_cmp);
        let interval_s = median_of_sorted(&intervals);
        let noise = white_noise_std_trimmed(series.values());
        Some(Trace { series, noise, interval_s })
    }

    /// The readings.
    pub fn readings(&self) -> impl Iterator<Item = (f64, f64)> + '_ {
        self.series.samples()
    }

    /// Standard deviation of its white noise, by the smaller nine tenths of its third differences.
    pub fn noise(&self) -> f64 {
        self.noise
    }

    /// The usual interval between readings, s.
    pub fn interval_s(&self) -> f64 {
        self.interval_s
    }

    /// First and last time, s.
    pub fn range_s(&self) -> (f64, f64) {
        self.series.range_s().unwrap_or((0.0, 0.0))
    }

    /// Readings from one time to another, both counted.
    pub fn within(&self, from_s: f64, to_s: f64) -> impl Iterator<Item = (f64, f64)> + '_ {
        let times_s = self.series.times_s();
        let from = times_s.partition_point(|&time_s| time_s < from_s);
        let to = times_s.partition_point(|&time_s| time_s <= to_s);
        self.readings().skip(from).take(to.saturating_sub(from))
    }

    /// Between two readings on the straight line between them; `None` outside the record and in a gap.
    pub fn at(&self, time_s: f64) -> Option<f64> {
        let (times_s, values) = (self.series.times_s(), self.series.values());
        let after = times_s.partition_point(|&t| t < time_s);
        let (&t1, &x1) = (times_s.get(after)?, values.get(after)?);
        if t1 <= time_s {
            return Some(x1);
        }
        let before = after.checked_sub(1)?;
        let (&t0, &x0) = (times_s.get(before)?, values.get(before)?);
        let gap = t1 - t0 > GAP_S.max(3.0 * self.interval_s);
        (!gap).then(|| x0 + (x1 - x0) * (time_s - t0) / (t1 - t0))
    }

    /// Mean, standard deviation and number of the readings in an interval.
    pub fn mean(&self, from_s: f64, to_s: f64) -> Option<(f64, f64, f64)> {
        let (mut count, mut mean, mut squares) = (0.0, 0.0, 0.0);
        for (_, value) in self.within(from_s, to_s) {
            count += 1.0;
            let before = value - mean;
            mean += before / count;
            squares += before * (value - mean);
        }
        (count >= 3.0).then(|| (mean, libm::sqrt(squares / (count - 1.0)), count))
    }

    /// Median of the readings in an interval.
    pub fn median(&self, from_s: f64, to_s: f64) -> Option<f64> {
        let mut values: Vec<f64> = self.within(from_s, to_s).map(|(_, value)| value).collect();
        values.sort_by(f64::total_cmp);
        (!values.is_empty()).then(|| median_of_sorted(&values))
    }

    /// Half the window in which local lines are laid, s: a tenth of a second or two intervals.
    pub fn half_window_s(&self) -> f64 {
        0.1f64.max(2.0 * self.interval_s) * (1.0 + 1e-9)
    }

    /// Times `from_s` + k `step_s` up to `to_s` about which there may be a local line: none in gaps, whatever they last.
    pub fn line_times(&self, from_s: f64, to_s: f64, step_s: f64) -> Vec<f64> {
        let (half_s, most) = (self.half_window_s(), libm::floor((to_s - from_s) / step_s));
        let (mut next, mut times) = (0.0f64, Vec::new());
        for (time_s, _) in self.within(from_s - half_s, to_s + half_s) {
            let last = libm::floor((time_s + half_s - from_s) / step_s).min(most);
            next = next.max(libm::ceil((time_s - half_s - from_s) / step_s));
            while next <= last {
                times.push(from_s + step_s * next);
                next += 1.0;
            }
        }
        times
    }

    /// The straight line of least squares through the readings about a time; `None` near ends and gaps.
    pub fn line(&self, time_s: f64) -> Option<LocalLine> {
        let half_s = self.half_window_s();
        let (mut n, mut st, mut sx, mut stt, mut stx) = (0.0, 0.0, 0.0, 0.0, 0.0);
        let (mut before, mut behind) = (false, false);
        for (t, x) in self.within(time_s - half_s, time_s + half_s) {
            let t = t - time_s;
            before |= t <= -0.4 * half_s;
            behind |= t >= 0.4 * half_s;
            n += 1.0;
            st += t;
            sx += x;
            stt += t * t;
            stx += t * x;
        }
        let determinant = n * stt - st * st;
        if n < 4.0 || !before || !behind || !(determinant > 0.0) {
            return None;
        }
        let slope = (n * stx - st * sx) / determinant;
        Some(LocalLine {
            value: (sx - slope * st) / n,
            slope,
            value_std: self.noise * libm::sqrt(stt / determinant),
            slope_std: self.noise * libm::sqrt(n / determinant),
        })
    }

    /// Means of the readings in bins of that width: mean time, mean value, how many.
    pub fn binned(&self, from_s: f64, to_s: f64, width_s: f64) -> Vec<Option<(f64, f64)>> {
        let bins = ((to_s - from_s) / width_s).max(0.0) as usize + 1;
        let mut sums = vec![(0.0, 0.0, 0.0); bins];
        for (time_s, value) in self.within(from_s, to_s) {
            if let Some(sum) = sums.get_mut(((time_s - from_s) / width_s + 1e-9) as usize) {
                *sum = (sum.0 + 1.0, sum.1 + time_s, sum.2 + value);
            }
        }
        sums.into_iter().map(|(count, time, value)| (count > 0.0).then(|| (time / count, value / count))).collect()
    }
}

/// The middle of values in order.
pub fn median_of_sorted(sorted: &[f64]) -> f64 {
    let at = |place: usize| sorted.get(place).copied().unwrap_or(0.0);
    let half = sorted.len() / 2;
    if sorted.len() % 2 == 1 { at(half) } else { 0.5 * (at(half.saturating_sub(1)) + at(half)) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::num::random::NormalNoise;

    #[test]
    fn noise_is_told_from_motion() {
        let mut noise = NormalNoise::new(1, 1);
        let trace = Trace::through((0..4000).map(|i| {
            let t = f64::from(i) * 0.01;
            (t, 0.3 * libm::sin(2.0 * t) + 0.002 * noise.draw())
        }))
        .unwrap();
        assert!((trace.noise() / 0.002 - 1.0).abs() < 0.05, "{}", trace.noise());
        assert!((trace.interval_s() - 0.01).abs() < 1e-9);
    }

    #[test]
    fn a_line_is_its_own_local_line_and_a_gap_has_none() {
        let times = (0..100).map(f64::from).map(|i| 0.02 * i).chain((0..100).map(f64::from).map(|i| 5.0 + 0.02 * i));
        let trace = Trace::through(times.map(|t| (t, 1.0 + 3.0 * t))).unwrap();
        let line = trace.line(1.0).unwrap();
        assert!((line.value - 4.0).abs() < 1e-12 && (line.slope - 3.0).abs() < 1e-10);
        assert!(trace.line(3.0).is_none() && trace.at(3.0).is_none());
        let by_clock: Vec<f64> = (0..=700).map(|k| 0.01 * f64::from(k)).filter(|t| trace.line(*t).is_some()).collect();
        let times = trace.line_times(0.0, 7.0, 0.01);
        assert!(times.len() < 450 && times.array_windows().all(|[before, after]| before < after), "{}", times.len());
        assert_eq!(times.into_iter().filter(|t| trace.line(*t).is_some()).collect::<Vec<_>>(), by_clock);
        assert!((trace.at(1.01).unwrap() - 4.03).abs() < 1e-12);
        assert!(Trace::through([(0.0, 1.0)]).is_none());
    }
}
