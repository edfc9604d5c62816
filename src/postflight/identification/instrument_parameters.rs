//! Errors of instruments, estimated with the derivatives: scales of vanes, airspeed and incidence of the trim, delays.
//!
//! Consumes a structure and the predictions of a first fit; produces the structure with further parameters, each with a prior of
//! mean zero and standard deviation [`SCALE`], [`SPEED`], [`INCIDENCE`] or [`LATENESS_S`]:
//!     beta = (1 + k_beta) (v/V0 + ..)     alpha = (1 + k_alpha) (w/u0 + ..)                            (1)
//!     V0 (1 + k_V) and alpha0 + d_alpha for V0 and alpha0 in the kinematics' rows and in v/V0, w/u0    (2)
//!     y_read = y late by tau, a part s of it a lag and the rest a delay, for every output              (3)
//! (1) and (2) to first order, (3) by (2) of `instrument_delay`, linearised about the delays of the fit before, zero at first.
//! The kinematics identify them: v' = ay + w p - u r + g phi holds whatever the aircraft, and phi' = p.
//! Otherwise a vane that reads 2 % too much, or a gyro 8 ms late, biases the derivatives, and no standard error accounts for it.
//! A delay common to all outputs may as well be a lag of the controls: they are recorded where they are measured.
//! Source: R. V. Jategaonkar, Flight Vehicle System Identification, 2006, ch. 10; (3) is ours.

use super::identification_model::{IdentificationModel, InstrumentParameter};
use super::instrument_delay::DelayedReading;
use crate::postflight::output_error::{
    FitParameter, FitResult, InputOutputRecord, MatrixEntry, OutputErrorFitError, RunParameters, predict,
};

/// Standard deviation of a vane's scale about one.
pub const SCALE: f64 = 0.03;
/// Of the trim's airspeed, over itself.
pub const SPEED: f64 = 0.02;
/// Of the trim's incidence, rad.
pub const INCIDENCE: f64 = 0.01;
/// Of an output's lateness, s; of airspeed, which comes through pipes.
pub const LATENESS_S: f64 = 0.02;
/// See [`LATENESS_S`].
pub const LATENESS_OF_AIRSPEED_S: f64 = 0.4;
/// Mean and standard deviation of the part of a lateness that is a lag: 1 a first-order filter, 0 a delay.
pub const LAG_PART: (f64, f64) = (0.5, 0.5);

/// Inputs of [`DelayedReading`] by output.
const LATE: [&str; 3] = ["lateness of", "lateness by time of", "lateness by lag of"];

impl IdentificationModel {
    /// Adds the parameters to the structure; they stand behind the derivatives.
    pub fn add_instrument_parameters(&mut self) {
        let states = self.choice.states.clone();
        let outputs = self.choice.outputs.clone();
        let has = |names: &[&str]| states.iter().any(|state| names.contains(&state.as_str()));
        for (output, of) in [("beta", ["v", "beta"]), ("alpha", ["w", "alpha"])] {
            if let Some(row) = outputs.iter().position(|name| name == output).filter(|_| has(&of)) {
                let place = self.add(format!("{output}_scale"), SCALE, "");
                let c = self.structure.c.get_mut(row).into_iter().flatten();
                let d = self.structure.d.get_mut(row).into_iter().flatten();
                for entry in c.chain(d) {
                    let factor = entry.fixed;
                    follow(entry, place, factor);
                }
            }
        }
        let [u0, v0, w0] = self.reference_trim.velocity();
        let gravity = self.reference_trim.known("beta", "phi");
        let by_speed = [
            ("v", "r", -u0),
            ("v", "p", w0),
            ("w", "q", u0),
            ("w", "p", -v0),
            ("u", "q", -w0),
            ("u", "r", v0),
            ("beta", "phi", -gravity),
        ];
        let by_incidence = [("v", "p", u0), ("v", "r", w0), ("w", "q", -w0), ("u", "q", -u0), ("beta", "p", 1.0)];
        let numbers = [("tas_scale", SPEED, "", &by_speed[..]), ("alpha_trim", INCIDENCE, "rad", &by_incidence[..])];
        for (name, std, unit, factors) in numbers {
            let there: Vec<_> = factors.iter().copied().filter(|(state, ..)| has(&[state])).collect();
            if there.is_empty() {
                continue;
            }
            let place = self.add(name.to_owned(), std, unit);
            for (state, variable, factor) in there {
                self.row_entry(state, variable, |entry| follow(entry, place, factor));
            }
            if name == "tas_scale" {
                for (output, state) in [("beta", "v"), ("alpha", "w")] {
                    let row = outputs.iter().position(|known| known == output);
                    let column = states.iter().position(|known| known == state);
                    if let Some(entry) = row.zip(column).and_then(|(i, j)| self.structure.c.get_mut(i)?.get_mut(j)) {
                        let factor = -entry.fixed;
                        follow(entry, place, factor);
                    }
                }
            }
        }
        for (row, output) in outputs.iter().enumerate() {
            let std = if output == "tas" { LATENESS_OF_AIRSPEED_S } else { LATENESS_S };
            let places = [self.add(format!("late_{output}"), std, "s"), self.add(format!("lag_part_{output}"), LAG_PART.1, "")];
            if let Some(part) = self.instrument_parameters.last_mut() {
                part.prior_mean = LAG_PART.0;
            }
            self.structure.inputs.extend(LATE.map(|what| format!("{what} {output}")));
            self.structure.b.iter_mut().for_each(|b| b.extend(LATE.map(|_| MatrixEntry::default())));
            for (other, d) in self.structure.d.iter_mut().enumerate() {
                let own = [MatrixEntry::fixed(1.0), MatrixEntry::free(places[0]), MatrixEntry::free(places[1])];
                d.extend(if other == row { own } else { Default::default() });
            }
        }
    }

    fn add(&mut self, name: String, prior_std: f64, unit: &'static str) -> usize {
        self.instrument_parameters.push(InstrumentParameter { name, prior_mean: 0.0, prior_std, unit });
        self.derivatives.len() + self.instrument_parameters.len() - 1
    }

    /// An entry of A, or of B where the variable is an input.
    fn row_entry(&mut self, state: &str, variable: &str, change: impl FnOnce(&mut MatrixEntry)) {
        let Some(row) = self.choice.states.iter().position(|known| known == state) else { return };
        let column = |names: &[String]| names.iter().position(|known| known == variable);
        let (a, b) = (self.structure.a.get_mut(row), self.structure.b.get_mut(row));
        let entry = match (column(&self.choice.states), column(&self.choice.inputs)) {
            (Some(column), _) => a.and_then(|a| a.get_mut(column)),
            (None, Some(column)) => b.and_then(|b| b.get_mut(column)),
            (None, None) => None,
        };
        if let Some(entry) = entry {
            change(entry);
        }
    }

    /// The parameters of the next fit, which starts where the last one ended.
    pub fn parameters_with_instruments(&self, last: &FitResult) -> Vec<FitParameter> {
        let mut parameters = self.parameters(&last.theta);
        parameters.extend(self.instrument_parameters.iter().map(|doubt| FitParameter {
            name: doubt.name.clone(),
            start: doubt.prior_mean,
            prior: Some((doubt.prior_mean, doubt.prior_std)),
        }));
        // Of the first fit there are none yet.
        parameters.iter_mut().zip(&last.theta).for_each(|(parameter, theta)| parameter.start = *theta);
        parameters
    }

    /// A record with (3) behind its inputs, of what a fit predicts of it; `theta` of a fit without doubts knows of no lateness.
    ///
    /// # Errors
    /// As for [`predict()`].
    pub fn record_with_delays(
        &self,
        mut record: InputOutputRecord,
        theta: &[f64],
        own: &RunParameters,
    ) -> Result<InputOutputRecord, OutputErrorFitError> {
        let outputs = self.structure.outputs.len();
        let from = self.structure.inputs.len() - LATE.len() * outputs;
        record.inputs.truncate(from);
        let (samples, first) = (record.times_s.len(), self.instrument_parameters.len() - 2 * outputs + self.derivatives.len());
        record.inputs.resize(self.structure.inputs.len(), vec![0.0; samples]);
        let mut all: Vec<f64> =
            self.derivatives.iter().map(|_| 0.0).chain(self.instrument_parameters.iter().map(|one| one.prior_mean)).collect();
        all.iter_mut().zip(theta).for_each(|(slot, theta)| *slot = *theta);
        let predicted = predict(&self.structure, &all, &[], &record, own)?;
        record.inputs.truncate(from);
        for (values, found) in predicted.iter().zip(all.get(first..).unwrap_or_default().chunks_exact(2)) {
            let (late_s, part) = found.first().copied().zip(found.get(1).copied()).unwrap_or((0.0, LAG_PART.0));
            let DelayedReading { offset, by_tau, by_part } =
                DelayedReading::about(&record.times_s, values, late_s, part.clamp(0.0, 1.0));
            record.inputs.extend([offset, by_tau, by_part]);
        }
        Ok(record)
    }
}

/// The entry moves by that factor with the parameter.
fn follow(entry: &mut MatrixEntry, parameter: usize, factor: f64) {
    if factor != 0.0 {
        entry.terms.push((parameter, factor));
    }
}

/// Puts the lateness of a fit into what the next one is given.
pub(crate) fn relinearise_delays(
    linear: &IdentificationModel,
    records: &mut [InputOutputRecord],
    fitted: &FitResult,
) -> Result<(), OutputErrorFitError> {
    for (record, run) in records.iter_mut().zip(&fitted.runs) {
        *record = linear.record_with_delays(core::mem::take(record), &fitted.theta, &run.run_parameters)?;
    }
    Ok(())
}
