//! Errors of instruments, estimated with the derivatives: scales of vanes, airspeed and incidence of the trim, delays.
//!
//! Consumes a structure and the predictions of a first fit; produces the structure with further parameters, each with a Gaussian
//! prior: scales N(0, [`SCALE`]^2), k_V N(0, [`SPEED`]^2), d_alpha N(0, [`INCIDENCE`]^2), tau N(0, [`DELAY_S`]^2), s N(0.5,
//! 0.5^2):
//!     beta = (1 + k_beta) (v/V0 + ..)     alpha = (1 + k_alpha) (w/u0 + ..)                            (1)
//!     V0 (1 + k_V) and alpha0 + d_alpha for V0 and alpha0 in the rows of the kinematics and in v/V0, w/u0    (2)
//!     y_read(t) = y delayed by tau, a share s of it a lag and the rest a pure delay, for every output   (3)
//! (1) and (2) to first order, (3) by (2) of `instrument_delay`, linearised about the delays of the fit before, zero at first.
//! Identifiable by the kinematics, which hold for any aircraft: v' = ay + w p - u r + g phi, and phi' = p.
//! An unmodelled scale of 2 % or delay of 8 ms biases the derivatives, and their standard errors do not account for it.
//! A delay common to all outputs cannot be distinguished from a lead of the controls.
//! Source: R. V. Jategaonkar, Flight Vehicle System Identification, 2006, ch. 10; (3) is ours.

use super::identification_model::{IdentificationModel, InstrumentParameter};
use super::instrument_delay::DelayedReading;
use crate::postflight::output_error::{
    FitParameter, FitResult, InputOutputRecord, MatrixEntry, OutputErrorFitError, RunParameters, predict,
};

/// Prior standard deviation of a vane's scale.
pub(crate) const SCALE: f64 = 0.03;
/// Prior standard deviation of the relative error of the trim's airspeed.
pub(crate) const SPEED: f64 = 0.02;
/// Prior standard deviation of the error of the trim's incidence, rad.
pub(crate) const INCIDENCE: f64 = 0.01;
/// Prior standard deviation of an output's delay, s; below, of airspeed, whose pneumatic lines lag.
pub(crate) const DELAY_S: f64 = 0.02;
pub(crate) const AIRSPEED_DELAY_S: f64 = 0.4;
/// Prior mean and standard deviation of the share of a delay that is a lag: 1 a first-order lag, 0 a pure delay.
pub(crate) const LAG_PART: (f64, f64) = (0.5, 0.5);

/// Inputs of [`DelayedReading`] by output.
const DELAY_INPUTS: [&str; 3] = ["lateness of", "lateness by time of", "lateness by lag of"];

impl IdentificationModel {
    /// Appends the parameters to the structure, behind the derivatives.
    pub(crate) fn add_instrument_parameters(&mut self) {
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
                    add_dependence(entry, place, factor);
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
            let present: Vec<_> = factors.iter().copied().filter(|(state, ..)| has(&[state])).collect();
            if present.is_empty() {
                continue;
            }
            let place = self.add(name.to_owned(), std, unit);
            for (state, variable, factor) in present {
                self.row_entry(state, variable, |entry| add_dependence(entry, place, factor));
            }
            if name == "tas_scale" {
                for (output, state) in [("beta", "v"), ("alpha", "w")] {
                    let row = outputs.iter().position(|known| known == output);
                    let column = states.iter().position(|known| known == state);
                    if let Some(entry) = row.zip(column).and_then(|(i, j)| self.structure.c.get_mut(i)?.get_mut(j)) {
                        let factor = -entry.fixed;
                        add_dependence(entry, place, factor);
                    }
                }
            }
        }
        for (row, output) in outputs.iter().enumerate() {
            let std = if output == "tas" { AIRSPEED_DELAY_S } else { DELAY_S };
            let places = [self.add(format!("late_{output}"), std, "s"), self.add(format!("lag_part_{output}"), LAG_PART.1, "")];
            if let Some(part) = self.instrument_parameters.last_mut() {
                part.prior_mean = LAG_PART.0;
            }
            self.structure.inputs.extend(DELAY_INPUTS.map(|what| format!("{what} {output}")));
            self.structure.b.iter_mut().for_each(|b| b.extend(DELAY_INPUTS.map(|_| MatrixEntry::default())));
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

    /// Parameters of the next fit, started at the estimates of the last.
    pub(crate) fn parameters_with_instruments(&self, last: &FitResult) -> Vec<FitParameter> {
        let mut parameters = self.parameters(&last.theta);
        parameters.extend(self.instrument_parameters.iter().map(|parameter| FitParameter {
            name: parameter.name.clone(),
            start: parameter.prior_mean,
            prior: Some((parameter.prior_mean, parameter.prior_std)),
        }));
        // The first fit has estimates of the derivatives only.
        parameters.iter_mut().zip(&last.theta).for_each(|(parameter, theta)| parameter.start = *theta);
        parameters
    }

    /// A record with the three inputs of (3) for each output appended, from the outputs predicted with `theta`; delays that
    /// `theta` lacks are at the mean of their prior.
    ///
    /// # Errors
    /// As for [`predict()`].
    pub(crate) fn record_with_delays(
        &self,
        mut record: InputOutputRecord,
        theta: &[f64],
        own: &RunParameters,
    ) -> Result<InputOutputRecord, OutputErrorFitError> {
        let outputs = self.structure.outputs.len();
        let from = self.structure.inputs.len() - DELAY_INPUTS.len() * outputs;
        record.inputs.truncate(from);
        let (samples, first) = (record.times_s.len(), self.instrument_parameters.len() - 2 * outputs + self.derivatives.len());
        record.inputs.resize(self.structure.inputs.len(), vec![0.0; samples]);
        let mut theta_all: Vec<f64> =
            self.derivatives.iter().map(|_| 0.0).chain(self.instrument_parameters.iter().map(|one| one.prior_mean)).collect();
        theta_all.iter_mut().zip(theta).for_each(|(slot, theta)| *slot = *theta);
        let predicted = predict(&self.structure, &theta_all, &[], &record, own)?;
        record.inputs.truncate(from);
        for (values, delay) in predicted.iter().zip(theta_all.get(first..).unwrap_or_default().chunks_exact(2)) {
            let (delay_s, part) = delay.first().copied().zip(delay.get(1).copied()).unwrap_or((0.0, LAG_PART.0));
            let DelayedReading { offset, by_tau, by_part } =
                DelayedReading::about(&record.times_s, values, delay_s, part.clamp(0.0, 1.0));
            record.inputs.extend([offset, by_tau, by_part]);
        }
        Ok(record)
    }
}

/// Makes the entry depend on the parameter: d entry/d parameter = factor.
fn add_dependence(entry: &mut MatrixEntry, parameter: usize, factor: f64) {
    if factor != 0.0 {
        entry.terms.push((parameter, factor));
    }
}

/// Linearises (3) about the delays of a fit, in the records of the next.
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
