//! Segmentation of a flight into manoeuvres while it goes on: intervals of excitation, the newest of which are kept.
//!
//! In: every sample, and at intervals whether the aircraft is excited. Out: the samples of each manoeuvre, from `lead_s` before
//! excitation was detected to its end.
//! Bounded: memory for a fixed number of samples; where a manoeuvre does not fit, the oldest is dropped and counted.

use crate::flight::sample::Sample;
use std::collections::VecDeque;

/// Limits of a manoeuvre and of the buffer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SegmentLimits {
    /// Time of trim before excitation is detected that belongs to a manoeuvre, s.
    pub lead_s: f64,
    /// Excitation that is shorter is no manoeuvre, s.
    pub shortest_s: f64,
    /// A manoeuvre that is longer is cut, s.
    pub longest_s: f64,
    /// Samples that are kept.
    pub capacity: usize,
    /// Manoeuvres that are kept.
    pub most: usize,
}

/// The newest manoeuvres of a flight, and the open one.
#[derive(Clone, Debug)]
pub struct ManoeuvreBuffer {
    limits: SegmentLimits,
    /// The lead in quiet flight, or the open manoeuvre.
    current: VecDeque<Sample>,
    open_s: Option<f64>,
    kept: VecDeque<Vec<Sample>>,
    kept_samples: usize,
    dropped: u32,
}

impl ManoeuvreBuffer {
    /// Allocates all memory for the stream of samples.
    pub fn new(limits: SegmentLimits) -> Self {
        ManoeuvreBuffer {
            current: VecDeque::with_capacity(limits.capacity),
            limits,
            open_s: None,
            kept: VecDeque::new(),
            kept_samples: 0,
            dropped: 0,
        }
    }

    /// A sample as it came; one without a time, or not after the one before, is left out.
    pub fn sample(&mut self, sample: &Sample) {
        let newest = self.current.back().map_or(f64::NEG_INFINITY, |last| last.time_s);
        if !sample.time_s.is_finite() || !(sample.time_s > newest) {
            return;
        }
        if self.current.len() >= self.limits.capacity {
            self.current.pop_front();
        }
        self.current.push_back(*sample);
        if self.open_s.is_none() {
            self.keep_lead(sample.time_s);
        }
    }

    /// Excitation at a time; the length of the manoeuvre that ended with it, s.
    pub fn set_excited(&mut self, time_s: f64, excited: bool) -> Option<f64> {
        match self.open_s {
            None if excited => {
                self.open_s = Some(time_s);
                None
            }
            Some(open_s) if !excited || time_s - open_s > self.limits.longest_s => {
                self.open_s = excited.then_some(time_s);
                self.close(time_s - open_s)
            }
            _ => None,
        }
    }

    /// End of the run: an open manoeuvre ends.
    pub fn finish(&mut self) -> Option<f64> {
        let (open_s, last) = (self.open_s.take()?, self.current.back()?);
        let long_s = last.time_s - open_s;
        self.close(long_s)
    }

    /// Length of the open manoeuvre, if any, s.
    pub fn open_for(&self, time_s: f64) -> Option<f64> {
        self.open_s.map(|open_s| time_s - open_s)
    }

    /// Length of all manoeuvres in the buffer, the open one included, s.
    pub fn recorded_s(&self, time_s: f64) -> f64 {
        let long_s =
            |samples: &Vec<Sample>| samples.last().zip(samples.first()).map_or(0.0, |(last, first)| last.time_s - first.time_s);
        self.kept.iter().map(long_s).sum::<f64>() + self.open_for(time_s).unwrap_or(0.0)
    }

    /// Number of manoeuvres dropped for lack of room.
    pub fn dropped(&self) -> u32 {
        self.dropped
    }

    /// All manoeuvres in the buffer, oldest first, the open one included.
    pub fn runs(&mut self) -> Vec<&[Sample]> {
        let open = self.open_s.is_some();
        let current = if open { self.current.make_contiguous() } else { &mut [] };
        let mut runs: Vec<&[Sample]> = self.kept.iter().map(Vec::as_slice).collect();
        if !current.is_empty() {
            runs.push(current);
        }
        runs
    }

    /// Drops all closed manoeuvres but the newest.
    pub fn keep_the_newest(&mut self) {
        while self.kept.len() > 1 {
            self.drop_the_oldest();
        }
    }

    fn drop_the_oldest(&mut self) {
        self.kept_samples -= self.kept.pop_front().map_or(0, |oldest| oldest.len());
        self.dropped += 1;
    }

    fn keep_lead(&mut self, time_s: f64) {
        while self.current.front().is_some_and(|first| first.time_s < time_s - self.limits.lead_s) {
            self.current.pop_front();
        }
    }

    /// Closes the open manoeuvre; `None` where it was too short for one.
    fn close(&mut self, long_s: f64) -> Option<f64> {
        if long_s < self.limits.shortest_s {
            self.keep_lead(self.current.back().map_or(0.0, |last| last.time_s));
            return None;
        }
        let over: Vec<Sample> = self.current.drain(..).collect();
        self.kept_samples += over.len();
        self.kept.push_back(over);
        while (self.kept_samples > self.limits.capacity || self.kept.len() > self.limits.most) && self.kept.len() > 1 {
            self.drop_the_oldest();
        }
        Some(long_s)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn manoeuvres(capacity: usize) -> ManoeuvreBuffer {
        ManoeuvreBuffer::new(SegmentLimits { lead_s: 4.0, shortest_s: 2.0, longest_s: 40.0, capacity, most: usize::MAX })
    }

    /// Samples at 10 Hz from a time to another, excitation as it is; manoeuvres that ended.
    fn fly(manoeuvres: &mut ManoeuvreBuffer, from: u32, to: u32, excited: bool) -> usize {
        let ended = (from..to).filter_map(|k| {
            let time_s = 0.1 * f64::from(k);
            manoeuvres.sample(&Sample::new(time_s));
            manoeuvres.set_excited(time_s, excited)
        });
        ended.count()
    }

    #[test]
    fn a_manoeuvre_has_its_lead_and_the_oldest_goes_where_there_is_no_room() {
        let mut manoeuvres = manoeuvres(250);
        assert_eq!(fly(&mut manoeuvres, 0, 100, false), 0);
        assert_eq!(manoeuvres.current.len(), 41, "the lead alone is kept");
        assert_eq!(fly(&mut manoeuvres, 100, 200, true), 0);
        assert_eq!(fly(&mut manoeuvres, 200, 201, false), 1);
        assert!(manoeuvres.kept.len() == 1 && manoeuvres.kept[0].len() == 141, "{}", manoeuvres.kept[0].len());
        fly(&mut manoeuvres, 201, 210, true);
        fly(&mut manoeuvres, 210, 300, false);
        assert_eq!(manoeuvres.kept.len(), 1, "0.9 s are no manoeuvre");
        fly(&mut manoeuvres, 300, 400, true);
        fly(&mut manoeuvres, 400, 410, false);
        assert_eq!((manoeuvres.kept.len(), manoeuvres.dropped()), (1, 1));
        assert!(manoeuvres.kept[0][0].time_s > 25.0);
    }

    #[test]
    fn no_more_manoeuvres_than_asked_for_are_kept() {
        let mut manoeuvres = manoeuvres(10_000);
        manoeuvres.limits.most = 2;
        for start in [0, 100, 200] {
            fly(&mut manoeuvres, start, start + 50, true);
            fly(&mut manoeuvres, start + 50, start + 100, false);
        }
        assert_eq!((manoeuvres.runs().len(), manoeuvres.dropped()), (2, 1));
        assert!(manoeuvres.finish().is_none());
        manoeuvres.keep_the_newest();
        assert_eq!((manoeuvres.runs().len(), manoeuvres.dropped()), (1, 2));
    }

    #[test]
    fn time_that_goes_back_is_left_out() {
        let mut manoeuvres = manoeuvres(1000);
        fly(&mut manoeuvres, 0, 60, true);
        fly(&mut manoeuvres, 30, 40, true);
        fly(&mut manoeuvres, 60, 61, false);
        assert_eq!(manoeuvres.kept[0].len(), 61);
    }
}
