//! Output error while the flight goes on: which samples are manoeuvres, when they are fitted again, how far the answer is.
//!
//! In: every sample, and at each publication of the regression whether the aircraft is excited and which terms it has.
//! Out: an [`OutputErrorRecord`] whenever something was fitted or has grown old. A manoeuvre begins `lead_s` before excitation
//! was seen and ends with it; each has its own trim, initial state and biases, all have one model.
//! Time is the samples' own, so that a recording gives the same numbers whenever and however fast it is played.
//! Assumed: the regression's terms are those of the aircraft, the manoeuvres are of one flight condition.
//! Bounded: so many samples are kept and no more; where a manoeuvre finds no room the oldest goes, which is said.

use super::live_fit;
use super::manoeuvres::{Limits, Manoeuvres};
use super::record::{OutputErrorRecord, Progress};
use crate::flight::derivative::{AXES, Variable};
use crate::flight::run::RunGeometry;
use crate::regression::record::{DerivativesRecord, Status};
use crate::telemetry::record::Sample;

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
    manoeuvres: Manoeuvres,
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
        let Config { lead_s, shortest_s, longest_s, capacity, .. } = config;
        let limits = Limits { lead_s, shortest_s, longest_s, capacity, most: usize::MAX };
        Live {
            manoeuvres: Manoeuvres::new(limits),
            config,
            geometry,
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
        self.manoeuvres.sample(sample);
    }

    /// What the regression said; the record where it has changed by time alone.
    pub fn seen(&mut self, seen: &Seen) -> Option<&OutputErrorRecord> {
        if seen.terms.iter().any(|bits| *bits != 0) {
            self.terms = seen.terms;
        }
        let ended = self.manoeuvres.seen(seen.time_s, seen.excited);
        self.over(ended);
        let open_for_s = self.manoeuvres.open_for(seen.time_s);
        let long_enough = open_for_s.is_some_and(|open_for_s| open_for_s >= self.config.shortest_s);
        let again = self.config.streaming && long_enough && seen.time_s - self.fitted_s >= self.config.every_s;
        self.due |= again && self.terms.iter().any(|bits| *bits != 0);
        let old = open_for_s.is_none() && seen.time_s - self.record.fitted_s > self.config.stale_s;
        if old && !self.due && matches!(self.record.progress, Progress::Converging | Progress::Converged) {
            self.record.progress = Progress::Stale;
            self.record.time_s = seen.time_s;
            return Some(&self.record);
        }
        None
    }

    /// A manoeuvre of that length is over.
    fn over(&mut self, ended: Option<f64>) {
        if let Some(long_s) = ended {
            self.longest_s = self.longest_s.max(long_s);
            self.record.dropped = self.manoeuvres.dropped();
            self.due = true;
        }
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
        let ended = self.manoeuvres.finish();
        self.over(ended);
    }

    /// Fits every manoeuvre that is kept, the one that goes on among them.
    pub fn refit(&mut self) -> &OutputErrorRecord {
        self.due = false;
        let newest = |samples: &[Sample]| samples.last().map(|last| last.time_s);
        let runs = self.manoeuvres.runs();
        let Some(time_s) = runs.last().and_then(|last| newest(last)) else { return &self.record };
        self.fitted_s = time_s;
        self.record.time_s = time_s;
        let starts: Vec<_> = self.record.parameters.iter().map(|one| (one.axis, one.variable, one.value)).collect();
        let open_for_s = self.manoeuvres.open_for(time_s);
        let (open, excited_s) = (open_for_s.is_some(), self.longest_s.max(open_for_s.unwrap_or(0.0)));
        match live_fit::fit(&self.manoeuvres.runs(), self.geometry, &self.terms, &starts, excited_s, &self.config) {
            Err(reason) => {
                self.record.progress = Progress::Failed;
                self.record.explain(&reason);
            }
            Ok(found) => {
                let live_fit::Found { record, searched, coloured } = found;
                let known = live_fit::is_known(&record) && !coloured;
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

    /// Samples at 10 Hz from a time to another, excitation as it is.
    fn fly(live: &mut Live, from: u32, to: u32, excited: bool) {
        for k in from..to {
            let time_s = 0.1 * f64::from(k);
            live.sample(&Sample::new(time_s));
            let _ = live.seen(&seen(time_s, excited));
        }
    }

    #[test]
    fn what_cannot_be_fitted_is_a_reason() {
        let mut live = Live::new(Config::default(), RunGeometry::DEFAULT);
        fly(&mut live, 0, 60, true);
        assert!(!live.is_due(), "nothing has any terms");
        fly(&mut live, 60, 61, false);
        assert!(live.is_due(), "a manoeuvre is over");
        let record = live.refit();
        assert_eq!(record.progress, Progress::Failed);
        assert!(!record.reason.is_empty() && record.parameters.is_empty());
        assert!(!live.is_due());
    }
}
