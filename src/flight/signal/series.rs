//! One channel of a run, linear between its samples: means over intervals, interpolated values, white noise.
//!
//! Consumes times, s, increasing, and values; produces exact integrals of the line, so that an average over an interval uses
//! every sample within it whatever the channel's rate, and whatever its time skew.

use super::white_noise::white_noise_std;
use crate::flight::channel::Channel;
use crate::flight::sample::Sample;

/// Samples of one channel.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Series {
    times_s: Vec<f64>,
    values: Vec<f64>,
    /// Integral of the line from the first sample, by sample.
    integral: Vec<f64>,
}

impl Series {
    /// Takes samples of increasing time; those that are no number or do not go forward are left out.
    pub fn of(samples: impl IntoIterator<Item = (f64, f64)>) -> Self {
        let mut series = Series::default();
        for (time_s, value) in samples {
            if !(time_s.is_finite() && value.is_finite()) {
                continue;
            }
            let grown = match (series.times_s.last(), series.values.last(), series.integral.last()) {
                (Some(&before_s), Some(&before), Some(&sum)) => {
                    if !(time_s > before_s) {
                        continue;
                    }
                    sum + 0.5 * (value + before) * (time_s - before_s)
                }
                _ => 0.0,
            };
            series.times_s.push(time_s);
            series.values.push(value);
            series.integral.push(grown);
        }
        series
    }

    /// Every value as that makes it.
    #[must_use]
    pub fn mapped(&self, of: impl Fn(f64) -> f64) -> Self {
        Series::of(self.samples().map(|(time_s, value)| (time_s, of(value))))
    }

    /// Samples of one channel, those of a bank angle or a heading without jumps of a full turn; `None` of fewer than `least`.
    pub fn of_channel(samples: &[Sample], channel: Channel, least: usize) -> Option<Self> {
        let series = Series::of(samples.iter().filter_map(|sample| Some((sample.time_s, sample.get(channel)?))));
        let turns = matches!(channel, Channel::Psi | Channel::Phi);
        (series.len() >= least).then(|| if turns { series.unwrapped() } else { series })
    }

    /// Takes jumps of a full turn out, as a heading has them.
    #[must_use]
    pub fn unwrapped(&self) -> Self {
        let turn = 2.0 * core::f64::consts::PI;
        let mut offset = 0.0;
        let mut before: Option<f64> = None;
        Series::of(self.samples().map(|(time_s, value)| {
            if let Some(before) = before {
                offset -= turn * libm::round((value + offset - before) / turn);
            }
            before = Some(value + offset);
            (time_s, value + offset)
        }))
    }

    /// The samples.
    pub fn samples(&self) -> impl Iterator<Item = (f64, f64)> + '_ {
        self.times_s.iter().copied().zip(self.values.iter().copied())
    }

    /// Mean of the samples.
    pub fn average(&self) -> f64 {
        self.values.iter().sum::<f64>() / self.values.len().max(1) as f64
    }

    /// How many there are.
    pub fn len(&self) -> usize {
        self.times_s.len()
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.times_s.is_empty()
    }

    /// First and last time, s.
    pub fn range_s(&self) -> Option<(f64, f64)> {
        self.times_s.first().copied().zip(self.times_s.last().copied())
    }

    /// The usual interval between samples, s: the median.
    pub fn interval_s(&self) -> Option<f64> {
        let mut intervals: Vec<f64> = self.times_s.windows(2).filter_map(|pair| Some(pair.get(1)? - pair.first()?)).collect();
        intervals.sort_by(f64::total_cmp);
        intervals.get(intervals.len() / 2).copied()
    }

    /// The longest interval without a sample between two times, s, the ends counted.
    pub fn longest_gap_s(&self, from_s: f64, to_s: f64) -> f64 {
        let (from, to) = (self.times_s.partition_point(|&t| t < from_s), self.times_s.partition_point(|&t| t <= to_s));
        let inside = self.times_s.get(from..to).unwrap_or(&[]).iter().copied();
        let (mut longest, mut before_s) = (0.0f64, from_s);
        for time_s in inside.chain([to_s]) {
            longest = longest.max(time_s - before_s);
            before_s = time_s;
        }
        longest
    }

    /// Intervals longer than `longest_s` without a sample, s: from the sample before (or `from_s`) to the one after.
    pub fn gaps(&self, from_s: f64, longest_s: f64) -> impl Iterator<Item = (f64, f64)> + '_ {
        let before = core::iter::once(from_s).chain(self.times_s.iter().copied());
        before.zip(self.times_s.iter().copied()).filter(move |(before_s, time_s)| time_s - before_s > longest_s)
    }

    /// Values at both ends held beyond them.
    pub fn at(&self, time_s: f64) -> f64 {
        let (_, _, value) = self.locate(time_s);
        value
    }

    /// Mean of the line over an interval.
    pub fn mean(&self, from_s: f64, to_s: f64) -> f64 {
        let length = to_s - from_s;
        if !(length > 0.0) {
            return self.at(from_s);
        }
        (self.integral_to(to_s) - self.integral_to(from_s)) / length
    }

    fn integral_to(&self, time_s: f64) -> f64 {
        let (place, before_s, value) = self.locate(time_s);
        let at = |list: &[f64]| list.get(place).copied().unwrap_or(0.0);
        at(&self.integral) + 0.5 * (at(&self.values) + value) * (time_s - before_s)
    }

    /// The sample at or before a time (the first one before all), its time, and the line's value at the time asked for.
    fn locate(&self, time_s: f64) -> (usize, f64, f64) {
        let after = self.times_s.partition_point(|&t| t <= time_s);
        let place = after.saturating_sub(1);
        let at = |place: usize| Some((*self.times_s.get(place)?, *self.values.get(place)?));
        match (at(place), at(after)) {
            (Some((t0, x0)), Some((t1, x1))) if after > 0 => (place, t0, x0 + (x1 - x0) * ((time_s - t0) / (t1 - t0))),
            (Some((t0, x0)), _) => (place, t0, x0),
            (None, _) => (0, time_s, 0.0),
        }
    }

    /// Standard deviation of the channel's white noise, by the mean of all of it.
    pub fn noise_std(&self) -> f64 {
        white_noise_std(&self.values)
    }

    pub(crate) fn times_s(&self) -> &[f64] {
        &self.times_s
    }

    pub(crate) fn values(&self) -> &[f64] {
        &self.values
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_mean_is_that_of_the_line() {
        // 0 to 2 over the first second, then 2 to 0 over two.
        let series = Series::of([(0.0, 0.0), (1.0, 2.0), (1.0, 9.0), (f64::NAN, 1.0), (3.0, 0.0)]);
        assert_eq!(series.len(), 3);
        assert!((series.mean(0.0, 3.0) - 1.0).abs() < 1e-15);
        assert!((series.mean(0.5, 1.0) - 1.5).abs() < 1e-15);
        assert!((series.mean(-1.0, 0.0)).abs() < 1e-15 && (series.mean(1.0, 2.0) - 1.5).abs() < 1e-15);
        assert!((series.mean(3.0, 4.0)).abs() < 1e-15 && (series.at(2.0) - 1.0).abs() < 1e-15);
        assert!((series.longest_gap_s(0.0, 5.0) - 2.0).abs() < 1e-15);
        assert!(Series::default().mean(0.0, 1.0).abs() < 1e-15 && Series::default().interval_s().is_none());
    }

    #[test]
    fn a_heading_through_north_is_one_line() {
        let turn = 2.0 * core::f64::consts::PI;
        let heading = Series::of((0..20).map(|i| (f64::from(i), (0.5 * f64::from(i)) % turn))).unwrapped();
        assert!(heading.samples().all(|(t, x)| (x - 0.5 * t).abs() < 1e-12));
    }

    #[test]
    fn noise_is_told_from_motion() {
        // A slow sine with an alternating 0.01: third differences of (-1)^i are 8, so that (1) gives 0.01 x 8/sqrt(20).
        let series = Series::of((0..500).map(|i| {
            let t = 0.02 * f64::from(i);
            (t, libm::sin(2.0 * t) + if i % 2 == 0 { 0.01 } else { -0.01 })
        }));
        assert!((series.noise_std() / (0.01 * 8.0 / libm::sqrt(20.0)) - 1.0).abs() < 0.01);
    }
}
