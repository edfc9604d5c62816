//! Output error during the flight: which samples are manoeuvres, when they are fitted again, whether the estimates have
//! converged.
//!
//! In: every sample, and at each publication of the regression whether the aircraft is excited and which terms it has.
//! Out: an [`OutputErrorRecord`] after every fit and when the estimates become stale. A manoeuvre begins `lead_s` before
//! excitation was detected and ends with it; each has its own trim, initial state and biases, all share one model.
//! Time is that of the samples, so a recording gives the same numbers however fast it is played.
//! Assumed: the regression's terms are those of the aircraft, the manoeuvres are of one flight condition.
//! Bounded: memory for a fixed number of samples; where a manoeuvre does not fit, the oldest is dropped, which is reported. The
//! work of a fit grows with what it is made to, so the interval between fits does too: the work per second of flight stays that
//! of the first `full_pace_s` of manoeuvres.

use super::live_fit;
use super::manoeuvre_buffer::{ManoeuvreBuffer, SegmentLimits};
use super::output_error_config::LiveOutputErrorConfig;
use super::regression_report::RegressionReport;
use crate::flight::run::RunGeometry;
use crate::flight::sample::Sample;
use crate::postflight::output_error::record::{OutputErrorProgress, OutputErrorRecord};

/// Output error during a flight.
#[derive(Clone, Debug)]
pub struct LiveOutputError {
    config: LiveOutputErrorConfig,
    geometry: RunGeometry,
    manoeuvres: ManoeuvreBuffer,
    /// Excitation of the longest closed manoeuvre, s.
    longest_s: f64,
    /// The newest that had terms.
    regression: RegressionReport,
    fitted_s: f64,
    due: bool,
    /// Estimates that later ones are compared with, and since when these have stayed near them.
    reference: Vec<f64>,
    since_s: f64,
    record: OutputErrorRecord,
}

impl LiveOutputError {
    /// Allocates all memory for samples.
    pub fn new(config: LiveOutputErrorConfig, geometry: RunGeometry) -> Self {
        let LiveOutputErrorConfig { lead_s, shortest_s, longest_s, capacity, .. } = config;
        let limits = SegmentLimits { lead_s, shortest_s, longest_s, capacity, most: usize::MAX };
        LiveOutputError {
            manoeuvres: ManoeuvreBuffer::new(limits),
            config,
            geometry,
            longest_s: 0.0,
            regression: RegressionReport::NONE,
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

    /// Takes a publication of the regression; the record where it has become stale.
    pub fn regression_report(&mut self, report: &RegressionReport) -> Option<&OutputErrorRecord> {
        if report.has_terms() {
            self.regression = *report;
        }
        let ended = self.manoeuvres.set_excited(report.time_s, report.excited);
        self.over(ended);
        let open_for_s = self.manoeuvres.open_for(report.time_s);
        let long_enough = open_for_s.is_some_and(|open_for_s| open_for_s >= self.config.shortest_s);
        let length = (self.manoeuvres.recorded_s(report.time_s) / self.config.full_pace_s).max(1.0);
        let again = self.config.streaming && long_enough && report.time_s - self.fitted_s >= length * self.config.every_s;
        self.due |= again && self.regression.has_terms();
        let old = open_for_s.is_none() && report.time_s - self.record.fitted_s > self.config.stale_s;
        if old && !self.due && matches!(self.record.progress, OutputErrorProgress::Converging | OutputErrorProgress::Converged) {
            self.record.progress = OutputErrorProgress::Stale;
            self.record.time_s = report.time_s;
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

    /// The newest record.
    pub fn record(&self) -> &OutputErrorRecord {
        &self.record
    }

    /// End of the run: an open manoeuvre ends.
    pub fn finish(&mut self) {
        let ended = self.manoeuvres.finish();
        self.over(ended);
    }

    /// Fits all manoeuvres in the buffer, the open one included.
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
        match live_fit::fit(&self.manoeuvres.runs(), self.geometry, &self.regression, &starts, excited_s, &self.config) {
            Err(reason) => {
                // Estimates of the fit before are still those of `fitted_s`.
                let has_before = !self.record.parameters.is_empty();
                self.record.progress = if has_before { OutputErrorProgress::Stale } else { OutputErrorProgress::Failed };
                self.record.explain(&reason);
            }
            Ok(found) => {
                let live_fit::LiveFit { record, searched, doubted } = found;
                let known = live_fit::is_known(&record) && !doubted;
                self.record = OutputErrorRecord { time_s, fitted_s: time_s, dropped: self.record.dropped, ..record };
                let settled = self.settled(time_s);
                self.record.progress = if searched && known && (settled || !open) {
                    OutputErrorProgress::Converged
                } else {
                    OutputErrorProgress::Converging
                };
            }
        }
        &self.record
    }

    /// Whether the estimates have stayed within two standard errors for `settled_s`.
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
    use crate::flight::derivative::{AXES, Axis, Variable};
    use crate::postflight::output_error::record::ParameterRecord;

    fn report(time_s: f64, excited: bool) -> RegressionReport {
        RegressionReport { time_s, excited, ..RegressionReport::NONE }
    }

    /// Samples at 10 Hz from a time to another, excitation as it is.
    fn fly(live: &mut LiveOutputError, from: u32, to: u32, excited: bool) {
        for k in from..to {
            let time_s = 0.1 * f64::from(k);
            live.sample(&Sample::new(time_s));
            let _ = live.regression_report(&report(time_s, excited));
        }
    }

    #[test]
    fn what_cannot_be_fitted_is_a_reason() {
        let mut live = LiveOutputError::new(LiveOutputErrorConfig::default(), RunGeometry::DEFAULT);
        fly(&mut live, 0, 60, true);
        assert!(!live.is_due(), "nothing has any terms");
        fly(&mut live, 60, 61, false);
        assert!(live.is_due(), "a manoeuvre is over");
        let record = live.refit();
        assert_eq!(record.progress, OutputErrorProgress::Failed);
        assert!(!record.reason.is_empty() && record.parameters.is_empty());
        assert!(!live.is_due());
    }

    #[test]
    fn a_fit_that_fails_leaves_the_estimates_of_the_one_before_as_stale() {
        let mut live = LiveOutputError::new(LiveOutputErrorConfig::default(), RunGeometry::DEFAULT);
        let before = ParameterRecord { axis: Axis::N, variable: Variable::V, value: 0.04, std: 0.003, std_cramer_rao: 0.003 };
        let _ = live.record.parameters.push(before);
        fly(&mut live, 0, 60, true);
        fly(&mut live, 60, 61, false);
        let record = live.refit();
        assert_eq!(record.progress, OutputErrorProgress::Stale);
        assert!(!record.reason.is_empty() && record.parameters.first() == Some(&before));
    }

    #[test]
    fn samples_fitted_in_a_second_of_flight_stay_bounded() {
        let config = LiveOutputErrorConfig { streaming: true, ..LiveOutputErrorConfig::default() };
        let mut live = LiveOutputError::new(config, RunGeometry::DEFAULT);
        // Excited throughout for 300 s at 10 Hz, in the pieces that the buffer allows; work is samples passed to a fit.
        let mut per_minute = [0_usize; 5];
        for k in 0..3000_u32 {
            let time_s = 0.1 * f64::from(k);
            live.sample(&Sample::new(time_s));
            let _ =
                live.regression_report(&RegressionReport { time_s, excited: true, terms: [1; AXES], ..RegressionReport::NONE });
            if live.is_due() {
                per_minute[k as usize / 600] += live.manoeuvres.runs().iter().map(|run| run.len()).sum::<usize>();
                let _ = live.refit();
            }
        }
        let first = per_minute[0];
        assert!(first > 0, "nothing was fitted in the first minute");
        assert!(per_minute.iter().all(|&work| work <= 2 * first), "samples fitted by minute: {per_minute:?}");
    }
}
