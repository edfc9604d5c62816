//! A run as it was recorded: samples and where its instruments stand; and its parts between gaps.
//!
//! Consumes the samples of a run; where a rate is not sampled for longer than [`GAP_S`] a motion cannot be followed, so that
//! what comes before and after are runs of their own. How long a gap lasts makes no difference: a clock that jumps to the time
//! since 1970 leaves two parts, and their cost is that of their rows.

use crate::flight::channel::Channel;
use crate::flight::run::RunGeometry;
use crate::flight::sample::Sample;
use crate::flight::signal::GAP_S;
use crate::flight::signal::gap_union::gap_union;

/// A recorded run.
#[derive(Clone, Debug)]
pub struct RecordedRun {
    /// What it is called.
    pub name: String,
    /// Its samples in order of time.
    pub samples: Vec<Sample>,
    /// Where its instruments are said to stand.
    pub geometry: RunGeometry,
    /// Whether `reconstruction::screening` has taken damaged samples out already.
    pub screened: bool,
}

/// What a run is between the gaps of its rates.
#[derive(Clone, Debug)]
pub struct PartedRun {
    /// The parts, each called by the run and the times that it covers; the run itself where it has no gap.
    pub parts: Vec<RecordedRun>,
    /// The gaps: last time with every rate before, first after, s.
    pub gaps: Vec<[f64; 2]>,
    /// Parts that are shorter than was asked for, s; they are left out. Where all are, the run is left whole.
    pub short: Vec<[f64; 2]>,
}

impl RecordedRun {
    /// The parts that last `least_s` or more. A run whose time goes back, or without a rate, is left whole: it has no gaps to
    /// speak of, but another fault.
    #[must_use]
    pub fn parted(self, least_s: f64) -> PartedRun {
        let gaps = self.gaps();
        if gaps.is_empty() {
            return PartedRun { parts: vec![self], gaps, short: Vec::new() };
        }
        let begins = core::iter::once(f64::NEG_INFINITY).chain(gaps.iter().map(|[_, after_s]| *after_s));
        let ends = gaps.iter().map(|[before_s, _]| *before_s).chain([f64::INFINITY]);
        let (mut parts, mut short) = (Vec::new(), Vec::new());
        for (begin_s, end_s) in begins.zip(ends) {
            let from = self.samples.partition_point(|sample| sample.time_s < begin_s);
            let to = self.samples.partition_point(|sample| sample.time_s <= end_s);
            let samples = self.samples.get(from..to).unwrap_or_default();
            let (Some(first), Some(last)) = (samples.first(), samples.last()) else { continue };
            if !(last.time_s - first.time_s >= least_s) {
                short.push([first.time_s, last.time_s]);
                continue;
            }
            let name = format!("{}, {:.2} to {:.2} s", self.name, first.time_s, last.time_s);
            parts.push(RecordedRun { name, samples: samples.to_vec(), geometry: self.geometry, screened: self.screened });
        }
        if parts.is_empty() {
            return PartedRun { parts: vec![self], gaps: Vec::new(), short: Vec::new() };
        }
        PartedRun { parts, gaps, short }
    }

    /// Times over which a rate is not sampled for longer than [`GAP_S`], in order; those that overlap are one.
    fn gaps(&self) -> Vec<[f64; 2]> {
        if self.samples.array_windows().any(|[before, after]| !(after.time_s >= before.time_s)) {
            return Vec::new();
        }
        let mut gaps: Vec<[f64; 2]> = Vec::new();
        for rate in [Channel::P, Channel::Q, Channel::R] {
            let read = |sample: &&Sample| sample.get(rate).is_some_and(f64::is_finite);
            let mut before_s = None;
            for time_s in self.samples.iter().filter(read).map(|sample| sample.time_s) {
                gaps.extend(before_s.filter(|before_s| time_s - before_s > GAP_S).map(|before_s| [before_s, time_s]));
                before_s = Some(time_s);
            }
        }
        gap_union(gaps)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn run(rows: impl Iterator<Item = (f64, bool)>) -> RecordedRun {
        let samples = rows.map(|(time_s, with_q)| {
            let mut sample = Sample::new(time_s);
            sample.set(Channel::P, 0.1);
            sample.set(Channel::R, 0.1);
            if with_q {
                sample.set(Channel::Q, 0.2);
            }
            sample
        });
        let samples = samples.collect();
        RecordedRun { name: "one".to_owned(), samples, geometry: RunGeometry::DEFAULT, screened: true }
    }

    fn rows(from_s: f64, count: u32) -> impl Iterator<Item = f64> {
        (0..count).map(move |k| from_s + 0.02 * f64::from(k))
    }

    #[test]
    fn what_lies_between_gaps_is_a_run_and_what_is_short_is_left_out() {
        let all = rows(0.0, 500).chain(rows(20.0, 50)).chain(rows(1.7e9, 500));
        let parted = run(all.map(|time_s| (time_s, true))).parted(3.0);
        assert_eq!(parted.parts.iter().map(|part| part.samples.len()).collect::<Vec<_>>(), [500, 500]);
        assert_eq!(parted.parts[0].name, "one, 0.00 to 9.98 s");
        assert_eq!((parted.gaps.len(), parted.short.as_slice()), (2, [[20.0, 20.98]].as_slice()));
        assert!(parted.parts.iter().all(|part| part.screened));
    }

    /// q is not sampled from 4 to 5 s, and from 4.5 to 6 s nothing is: rows of two rates alone belong to no part.
    #[test]
    fn a_gap_of_one_rate_parts_the_run_too() {
        let all = rows(0.0, 225).chain(rows(6.0, 200)).map(|time_s| (time_s, !(4.0..5.0).contains(&time_s)));
        let parted = run(all).parted(3.0);
        assert_eq!(parted.gaps.len(), 1);
        assert!((parted.gaps[0][0] - 3.98).abs() < 1e-9 && (parted.gaps[0][1] - 6.0).abs() < 1e-9, "{:?}", parted.gaps);
        assert_eq!(parted.parts.iter().map(|part| part.samples.len()).collect::<Vec<_>>(), [200, 200]);
    }

    #[test]
    fn a_run_without_gaps_and_one_whose_time_goes_back_are_left_whole() {
        let whole = run(rows(0.0, 300).map(|time_s| (time_s, true))).parted(3.0);
        assert_eq!((whole.parts.len(), whole.gaps.len(), whole.parts[0].name.as_str()), (1, 0, "one"));
        let scraps = run(rows(0.0, 50).chain(rows(9.0, 50)).map(|time_s| (time_s, true))).parted(3.0);
        assert_eq!((scraps.parts.len(), scraps.gaps.len(), scraps.parts[0].samples.len()), (1, 0, 100));
        let back = run(rows(0.0, 300).chain(rows(90.0, 300)).chain(rows(3.0, 300)).map(|time_s| (time_s, true))).parted(3.0);
        assert_eq!((back.parts.len(), back.parts[0].samples.len()), (1, 900));
    }
}
