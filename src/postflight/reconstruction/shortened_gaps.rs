//! A record's times with its long gaps shortened, so that what is laid over them costs by the rows and not by the clock.
//!
//! Consumes samples; where no row stands for longer than
//!     G = max(G_min, N median(t_k+1 - t_k))                                                           (1)
//! all later times are moved back, so that the gap lasts G. Nothing is carried over a gap, so its length is no information:
//! test points of one sortie, or a clock that jumps to the time since 1970, are followed as records one after another.
//! Times that do not go forward stay as they are.

use crate::flight::sample::Sample;
use crate::flight::signal::GAP_S;
use std::borrow::Cow;

/// `G_min` of (1), s: above what parts a record.
const LEAST_S: f64 = 2.0 * GAP_S;
/// N of (1): a slow record keeps its rate.
const MEDIANS: f64 = 8.0;

/// Samples with every gap longer than (1) shortened to it, and those gaps: the last time before and the first after, s.
pub(crate) fn with_shortened_gaps(samples: &[Sample]) -> (Cow<'_, [Sample]>, Vec<[f64; 2]>) {
    let mut steps: Vec<f64> = samples
        .windows(2)
        .filter_map(|pair| Some(pair.get(1)?.time_s - pair.first()?.time_s))
        .filter(|step| *step > 0.0)
        .collect();
    let longest = steps.iter().copied().fold(0.0, f64::max);
    let middle = steps.len() / 2;
    let median = if steps.is_empty() { 0.0 } else { *steps.select_nth_unstable_by(middle, f64::total_cmp).1 };
    let most_s = LEAST_S.max(MEDIANS * median);
    if !(longest > most_s) {
        return (Cow::Borrowed(samples), Vec::new());
    }
    let mut moved = samples.to_vec();
    let (mut back_s, mut last_s, mut gaps) = (0.0, f64::INFINITY, Vec::new());
    for sample in &mut moved {
        let time_s = sample.time_s;
        if time_s - last_s > most_s {
            back_s += time_s - last_s - most_s;
            gaps.push([last_s, time_s]);
        }
        // A time before the latest is left behind it, where every consumer sees that it goes back.
        last_s = if last_s.is_finite() { last_s.max(time_s) } else { time_s };
        sample.time_s = time_s - back_s;
    }
    (Cow::Owned(moved), gaps)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn shortened(times_s: &[f64]) -> Vec<f64> {
        let samples: Vec<Sample> = times_s.iter().map(|&time_s| Sample::new(time_s)).collect();
        with_shortened_gaps(&samples).0.iter().map(|sample| sample.time_s).collect()
    }

    #[test]
    fn a_long_gap_lasts_a_second_and_what_follows_keeps_its_intervals() {
        let rows = |from_s: f64| (0..100).map(move |k| from_s + 0.02 * f64::from(k));
        let times: Vec<f64> = rows(10.0).chain(rows(1e9)).chain(rows(1e9 + 500.0)).collect();
        let shortened = shortened(&times);
        assert_eq!(shortened[..100], times[..100]);
        let intervals: Vec<f64> = shortened.windows(2).map(|pair| pair[1] - pair[0]).collect();
        for (place, interval_s) in intervals.iter().enumerate() {
            let expected = if place == 99 || place == 199 { LEAST_S } else { 0.02 };
            // Times of 1e9 s have a spacing of 1.2e-7 s.
            assert!((interval_s - expected).abs() < 1e-6, "{place}: {interval_s}");
        }
    }

    #[test]
    fn a_record_without_long_gaps_and_a_slow_one_are_left_alone() {
        let even: Vec<f64> = (0..50).map(|k| 0.9 * f64::from(k)).collect();
        assert_eq!(shortened(&even), even);
        let slow: Vec<f64> = (0..50).map(|k| 3.0 * f64::from(k)).collect();
        assert_eq!(shortened(&slow), slow);
        assert!(shortened(&[]).is_empty());
    }

    #[test]
    fn one_wrong_stamp_leaves_all_after_it_behind_it() {
        let shortened = shortened(&[0.0, 0.02, 0.04, 1e9, 0.08, 0.1]);
        assert!(shortened[3] < 2.0 && shortened[4] < shortened[3] && shortened[5] < shortened[3], "{shortened:?}");
    }
}
