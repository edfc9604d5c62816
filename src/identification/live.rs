//! Output error while the flight goes on: which samples are manoeuvres, when they are fitted again, how far the answer is.
//!
//! In: every sample, and at each publication of the regression whether the aircraft is excited and which terms it has.
//! Out: an [`OutputErrorRecord`] whenever something was fitted or has grown old. A manoeuvre begins `lead_s` before excitation
//! was seen and ends with it; each has its own trim, initial state and biases, all have one model.
//! Time is the samples' own, so that a recording gives the same numbers whenever and however fast it is played.
//! Assumed: the regression's terms are those of the aircraft, the manoeuvres are of one flight condition.
//! Bounded: so many samples are kept and no more; where a manoeuvre finds no room the oldest goes, which is said.

use super::live_fit;
use super::record::{OutputErrorRecord, Progress};
use crate::flight::derivative::{AXES, Variable};
use crate::flight::run::RunGeometry;
use crate::regression::record::{DerivativesRecord, Status};
use crate::telemetry::record::Sample;
use std::collections::VecDeque;

/// How it goes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Config {
    /// Whether it is fitted while a manoeuvre goes on; else at the end of each only.
    pub streaming: bool,
    /// From one fit to the next while a manoeuvre goes on, s.
    pub every_s: f64,
    /// So long before excitation is seen a manoeuvre begins, s: it is still in trim there.
    pub lead_s: f64,
    /// Window of a manoeuvre's trim, s.
    pub trim_s: f64,
    /// Excitation that is shorter is no manoeuvre, s.
    pub shortest_s: f64,
    /// A manoeuvre that is longer is cut, s.
    pub longest_s: f64,
    /// Samples that are kept.
    pub capacity: usize,
    /// Samples a second that a fit takes: means over blocks of what came.
    pub rate_hz: f64,
    /// Most steps of a fit.
    pub iterations: usize,
    /// Excitation after which every term is free, not those alone that the regression has selected, s.
    pub all_terms_s: f64,
    /// Whether controls are held still where their samples differ by noise only: see [`super::held`].
    pub hold_controls: bool,
    /// Numbers are stale after so long without excitation, s.
    pub stale_s: f64,
    /// Estimates must have stayed within two standard errors for so long, s.
    pub settled_s: f64,
}

impl Default for Config {
    fn default() -> Self {
        Config {
            streaming: true,
            every_s: 0.5,
            lead_s: 4.0,
            trim_s: 1.0,
            shortest_s: 2.0,
            longest_s: 40.0,
            capacity: 16_384,
            rate_hz: 32.0,
            iterations: 12,
            all_terms_s: 10.0,
            hold_controls: true,
            stale_s: 10.0,
            settled_s: 2.0,
        }
    }
}

/// What the regression said at a publication.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Seen {
    /// When, s.
    pub time_s: f64,
    /// Whether the aircraft is excited.
    pub excited: bool,
    /// By axis, a bit for each variable in its equation.
    pub terms: [u16; AXES],
}

impl From<&DerivativesRecord> for Seen {
    fn from(record: &DerivativesRecord) -> Self {
        let mut terms = [0; AXES];
        for (bits, equation) in terms.iter_mut().zip(&record.equations) {
            if equation.status.rank() >= Status::Stale.rank() {
                let variables = equation.terms.iter().filter_map(|term| term.variable);
                *bits = variables.fold(0, |bits, variable: Variable| bits | 1 << variable.index());
            }
        }
        Seen { time_s: record.time_s, excited: record.excited, terms }
    }
}

/// Output error beside a flight.
#[derive(Clone, Debug)]
pub struct Live {
    config: Config,
    geometry: RunGeometry,
    /// Quiet flight just now, or the manoeuvre that goes on.
    current: VecDeque<Sample>,
    open_s: Option<f64>,
    kept: VecDeque<Vec<Sample>>,
    kept_samples: usize,
    /// Excitation of the longest manoeuvre that is kept, and of the one that goes on, s.
    longest_s: f64,
    terms: [u16; AXES],
    fitted_s: f64,
    due: bool,
    /// What numbers are held against, and since when they have not left it.
    reference: Vec<f64>,
    since_s: f64,
    record: OutputErrorRecord,
}

impl Live {
    /// Nothing seen yet; all memory for samples is taken here.
    pub fn new(config: Config, geometry: RunGeometry) -> Self {
        Live {
            current: VecDeque::with_capacity(config.capacity),
            config,
            geometry,
            open_s: None,
            kept: VecDeque::new(),
            kept_samples: 0,
            longest_s: 0.0,
            terms: [0; AXES],
            fitted_s: f64::NEG_INFINITY,
            due: false,
            reference: Vec::new(),
            since_s: 0.0,
            record: OutputErrorRecord::EMPTY,
        }
    }

    /// A sample as it came; one without a time, or not after the one before, is left out.
    pub fn sample(&mut self, sample: &Sample) {
        let newest = self.current.back().map_or(f64::NEG_INFINITY, |last| last.time_s);
        if !sample.time_s.is_finite() || !(sample.time_s > newest) {
            return;
        }
        if self.current.len() >= self.config.capacity {
            self.current.pop_front();
        }
        self.current.push_back(*sample);
        if self.open_s.is_none() {
            self.keep_lead(sample.time_s);
        }
    }

    fn keep_lead(&mut self, time_s: f64) {
        while self.current.front().is_some_and(|first| first.time_s < time_s - self.config.lead_s) {
            self.current.pop_front();
        }
    }

    /// What the regression said; the record where it has changed by time alone.
    pub fn seen(&mut self, seen: &Seen) -> Option<&OutputErrorRecord> {
        if seen.terms.iter().any(|bits| *bits != 0) {
            self.terms = seen.terms;
        }
        match self.open_s {
            None if seen.excited => self.open_s = Some(seen.time_s),
            Some(open_s) if !seen.excited || seen.time_s - open_s > self.config.longest_s => {
                self.close(seen.time_s - open_s);
                self.open_s = seen.excited.then_some(seen.time_s);
            }
            _ => {}
        }
        let again =
            self.config.streaming && self.is_long_enough(seen.time_s) && seen.time_s - self.fitted_s >= self.config.every_s;
        self.due |= again && self.terms.iter().any(|bits| *bits != 0);
        let old = self.open_s.is_none() && seen.time_s - self.record.fitted_s > self.config.stale_s;
        if old && !self.due && matches!(self.record.progress, Progress::Converging | Progress::Converged) {
            self.record.progress = Progress::Stale;
            self.record.time_s = seen.time_s;
            return Some(&self.record);
        }
        None
    }

    fn is_long_enough(&self, time_s: f64) -> bool {
        self.open_s.is_some_and(|open_s| time_s - open_s >= self.config.shortest_s)
    }

    /// The manoeuvre that went on is over.
    fn close(&mut self, long_s: f64) {
        if long_s < self.config.shortest_s {
            self.keep_lead(self.current.back().map_or(0.0, |last| last.time_s));
            return;
        }
        self.longest_s = self.longest_s.max(long_s);
        let over: Vec<Sample> = self.current.drain(..).collect();
        self.kept_samples += over.len();
        self.kept.push_back(over);
        while self.kept_samples > self.config.capacity && self.kept.len() > 1 {
            self.kept_samples -= self.kept.pop_front().map_or(0, |oldest| oldest.len());
            self.record.dropped += 1;
        }
        self.due = true;
    }

    /// Whether it is time to fit again.
    pub fn is_due(&self) -> bool {
        self.due
    }

    /// The record as it stands.
    pub fn record(&self) -> &OutputErrorRecord {
        &self.record
    }

    /// The end of the run: a manoeuvre that goes on is over.
    pub fn finish(&mut self) {
        if let (Some(open_s), Some(last)) = (self.open_s.take(), self.current.back()) {
            self.close(last.time_s - open_s);
        }
    }

    /// Fits every manoeuvre that is kept, the one that goes on among them.
    pub fn refit(&mut self) -> &OutputErrorRecord {
        self.due = false;
        let newest = |samples: &[Sample]| samples.last().map(|last| last.time_s);
        let open = self.open_s.is_some();
        let current = if open { self.current.make_contiguous() } else { &mut [] };
        let mut runs: Vec<&[Sample]> = self.kept.iter().map(Vec::as_slice).collect();
        if !current.is_empty() {
            runs.push(current);
        }
        let Some(time_s) = runs.last().and_then(|last| newest(last)) else { return &self.record };
        self.fitted_s = time_s;
        self.record.time_s = time_s;
        let excited_s = self.longest_s.max(self.open_s.map_or(0.0, |open_s| time_s - open_s));
        let starts: Vec<_> = self.record.parameters.iter().map(|one| (one.axis, one.variable, one.value)).collect();
        match live_fit::fit(&runs, self.geometry, &self.terms, &starts, excited_s, &self.config) {
            Err(reason) => {
                self.record.progress = Progress::Failed;
                self.record.explain(&reason);
            }
            Ok(found) => {
                let live_fit::Found { record, searched } = found;
                let known = live_fit::is_known(&record);
                self.record = OutputErrorRecord { time_s, fitted_s: time_s, dropped: self.record.dropped, ..record };
                let settled = self.settled(time_s);
                self.record.progress =
                    if searched && known && (settled || !open) { Progress::Converged } else { Progress::Converging };
            }
        }
        &self.record
    }

    /// Whether the numbers have stayed within two standard errors for long enough.
    fn settled(&mut self, time_s: f64) -> bool {
        let moved = self.record.parameters.len() != self.reference.len()
            || self
                .record
                .parameters
                .iter()
                .zip(&self.reference)
                .any(|(one, before)| !((one.value - before).abs() <= 2.0 * one.std));
        if moved {
            self.reference = self.record.parameters.iter().map(|one| one.value).collect();
            self.since_s = time_s;
        }
        time_s - self.since_s >= self.config.settled_s
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn seen(time_s: f64, excited: bool) -> Seen {
        Seen { time_s, excited, terms: [0; AXES] }
    }

    fn live(capacity: usize) -> Live {
        Live::new(Config { capacity, ..Config::default() }, RunGeometry::DEFAULT)
    }

    /// Samples at 10 Hz from a time to another, excitation as it is.
    fn fly(live: &mut Live, from: u32, to: u32, excited: bool) {
        for k in from..to {
            let time_s = 0.1 * f64::from(k);
            live.sample(&Sample::new(time_s));
            let _ = live.seen(&seen(time_s, excited));
        }
    }

    #[test]
    fn a_manoeuvre_has_its_lead_and_the_oldest_goes_where_there_is_no_room() {
        let mut live = live(250);
        fly(&mut live, 0, 100, false);
        assert_eq!(live.current.len(), 41, "the lead alone is kept");
        fly(&mut live, 100, 200, true);
        fly(&mut live, 200, 201, false);
        assert!(live.is_due() && live.kept.len() == 1 && live.kept[0].len() == 141, "{}", live.kept[0].len());
        fly(&mut live, 201, 210, true);
        fly(&mut live, 210, 300, false);
        assert_eq!(live.kept.len(), 1, "0.9 s are no manoeuvre");
        fly(&mut live, 300, 400, true);
        fly(&mut live, 400, 410, false);
        assert_eq!((live.kept.len(), live.record.dropped), (1, 1));
        assert!(live.kept[0][0].time_s > 25.0);
    }

    #[test]
    fn what_cannot_be_fitted_is_a_reason_and_time_that_goes_back_is_left_out() {
        let mut live = live(1000);
        fly(&mut live, 0, 60, true);
        fly(&mut live, 30, 40, true);
        fly(&mut live, 60, 61, false);
        assert_eq!(live.kept[0].len(), 61);
        let record = live.refit();
        assert_eq!(record.progress, Progress::Failed);
        assert!(!record.reason.is_empty() && record.parameters.is_empty());
        assert!(!live.is_due());
    }
}
