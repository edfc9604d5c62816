//! The linear model of chosen states and inputs: known entries, derivatives to be estimated, and what is measured.
//!
//! Consumes names of states, inputs and outputs and the trims of the runs; produces the structure that output error fits,
//! x' = A x + B u [n, n x n, n x k], y = C x + D u (m outputs), all as deviations from trim, SI, body axes at the centre of mass.
//! With the trim's velocity u0 v0 w0, airspeed V0, attitude theta0 phi0, and AXIS_x the derivatives, A and B are
//!     u' = X_x x + .. - w0 q + v0 r - g cos(theta0) theta                                              (1)
//!     v' = Y_x x + .. + w0 p - u0 r + g cos(theta0) cos(phi0) phi - g sin(theta0) sin(phi0) theta      (2)
//!     w' = Z_x x + .. + u0 q - v0 p - g sin(theta0) cos(phi0) theta - g cos(theta0) sin(phi0) phi      (3)
//!     beta' = Y_x x + .. + the known part of (2) over V0                                               (4)
//!     alpha' = Z_x x + .. + q + the rest of the known part of (3) over V0                              (5)
//!     p' = L_x x + ..     q' = M_x x + ..     r' = N_x x + ..                                          (6)
//!     phi' = p + tan(theta0) (sin(phi0) q + cos(phi0) r)     theta' = cos(phi0) q - sin(phi0) r        (7)
//! over every state and input x but attitudes; a known entry whose variable is an input stands in B. (4) and (5) have force
//! derivatives in 1/s (over mass and V0). Outputs, with s^2 = u0^2 + w0^2 and, at a vane at x y z, du = u + z q - y r and so on:
//!     beta = (s^2 dv - u0 v0 du - w0 v0 dw)/(s V0^2)     alpha = (u0 dw - w0 du)/s^2
//!     tas = (u0 u + v0 v + w0 w)/V0                                                                   (8)
//!     ay = Y_x x + .. + x_a r' - z_a p'     az = Z_x x + .. + y_a p' - x_a q'     ax = X_x x + .. + z_a q' - y_a r'    (9)
//! and the states themselves. What (1) to (9) omit, products of deviations, is computed from measurements
//! (`nonlinear_remainder`).
//! Source: Padfield et al. 1987, (1) to (6), (23) and (24), linearised; R. V. Jategaonkar, Flight Vehicle System Identification,
//! 2006.
//! Returns [`IdentificationModelError`] where names contradict each other or a run lacks a channel.

use super::columns::{ColumnError, Columns};
use super::model_variables::{IdentificationModelError, ModelVariables, STATES, axis, is_attitude, is_control};
use super::nonlinear_remainder::NonlinearRemainder;
use super::reference_trim::{NUMBERS, ReferenceTrim};
use super::velocity::CHANNELS;
use crate::flight::signal::white_noise::white_noise_std_between_gaps;

use crate::postflight::output_error::{FitParameter, InputOutputRecord, MatrixEntry, ModelStructure};

/// A parameter of an instrument, estimated with the derivatives: a scale, an error of the trim, a delay.
#[derive(Clone, Debug, PartialEq)]
pub struct InstrumentParameter {
    /// `beta_scale`, `alpha_scale`, `tas_scale`, `alpha_trim`, and of output p `late_p`, `lag_part_p`.
    pub name: String,
    /// Mean of the prior; a scale is relative to one.
    pub prior_mean: f64,
    /// Standard deviation of the prior, in `unit`.
    pub prior_std: f64,
    /// SI; empty for a ratio.
    pub unit: &'static str,
}

/// The structure (1) to (9) with the names of its parameters: derivatives first, then instrument parameters.
#[derive(Clone, Debug)]
pub struct IdentificationModel {
    /// Names of states, inputs and outputs.
    pub choice: ModelVariables,
    /// The trim that deviations are about: mean over the runs.
    pub reference_trim: ReferenceTrim,
    /// Standard errors of its numbers, in the order tas (m/s), alpha, beta, theta, phi (rad).
    pub reference_trim_std: [f64; NUMBERS.len()],
    /// A, B, C, D as affine functions of the parameters.
    pub structure: ModelStructure,
    /// Axis and variable of each parameter.
    pub derivatives: Vec<(char, String)>,
    /// Inputs that are commands by a scale that nobody stated: derivatives by them are per unit of command.
    pub assumed_scale: Vec<String>,
    /// Errors of instruments, estimated together with the derivatives.
    pub instrument_parameters: Vec<InstrumentParameter>,
    /// States whose nonlinear kinematics are known further inputs, appended to the chosen ones.
    pub remainders: Vec<String>,
    /// Whether the nonlinear part of the outputs is subtracted from the measurements, too.
    pub nonlinear_outputs: bool,
    /// Assumptions and omissions, in words.
    pub notes: Vec<String>,
}

impl IdentificationModel {
    /// The structure over these runs, with the derivatives of `only` (axis, variable) free; with all of them where it is `None`.
    ///
    /// # Errors
    /// [`IdentificationModelError`] where the choice contradicts itself or a run lacks a channel.
    pub fn new(
        choice: ModelVariables,
        runs: &[Columns],
        only: Option<&[(char, String)]>,
    ) -> Result<Self, IdentificationModelError> {
        check(&choice)?;
        let mut notes = Vec::new();
        let speedy = choice.states.iter().any(|state| matches!(state.as_str(), "u" | "v" | "w" | "alpha" | "beta"));
        let reference_trim = ReferenceTrim::of(runs, speedy, &mut notes)?;
        let variables: Vec<&String> = choice.states.iter().chain(&choice.inputs).collect();
        let mut derivatives: Vec<(char, String)> = Vec::new();
        // Rows over states and inputs together: free derivatives alone, then with the known entries.
        let mut found: Vec<Vec<MatrixEntry>> = Vec::new();
        for state in &choice.states {
            let row = variables.iter().map(|variable| {
                let wanted = axis(state).filter(|_| !is_attitude(variable));
                let wanted = wanted.map(|axis| (axis, (*variable).clone()));
                let Some(term) = wanted.filter(|term| only.is_none_or(|only| only.contains(term))) else {
                    return MatrixEntry::default();
                };
                derivatives.push(term);
                MatrixEntry { fixed: 0.0, terms: vec![(derivatives.len() - 1, 1.0)] }
            });
            found.push(row.collect());
        }
        let rows: Vec<Vec<MatrixEntry>> = found
            .iter()
            .zip(&choice.states)
            .map(|(row, state)| {
                let with_known = row.iter().zip(&variables).map(|(entry, variable)| MatrixEntry {
                    fixed: reference_trim.known(state, variable),
                    terms: entry.terms.clone(),
                });
                with_known.collect()
            })
            .collect();
        let measured =
            MeasurementRows { choice: &choice, reference_trim, variables: &variables, found: &found, rows: &rows, runs };
        let outputs = choice.outputs.iter().map(|name| measured.row(name, &mut notes)).collect::<Result<Vec<_>, _>>()?;
        let count = choice.states.len();
        let split = |rows: &[Vec<MatrixEntry>]| -> (Vec<Vec<MatrixEntry>>, Vec<Vec<MatrixEntry>>) {
            rows.iter().map(|row| (row.iter().take(count).cloned().collect(), row.iter().skip(count).cloned().collect())).unzip()
        };
        let ((a, mut b), (c, mut d)) = (split(&rows), split(&outputs));
        let moving: Vec<String> =
            choice.states.iter().filter(|state| !matches!(state.as_str(), "p" | "q" | "r")).cloned().collect();
        let missing = CHANNELS.into_iter().find(|channel| !runs.iter().all(|run| run.has(channel)));
        let remainders = if missing.is_none() { moving.clone() } else { Vec::new() };
        if let Some(missing) = missing.filter(|_| !moving.is_empty()) {
            notes.push(format!("kinematics to first order only: `{missing}` is not in every run"));
        }
        for (state, row) in choice.states.iter().zip(&mut b) {
            row.extend(remainders.iter().map(|own| MatrixEntry::fixed(if own == state { 1.0 } else { 0.0 })));
        }
        d.iter_mut().for_each(|row| row.extend(remainders.iter().map(|_| MatrixEntry::default())));
        let named = remainders.iter().map(|state| format!("kinematics of {state}"));
        let structure = ModelStructure {
            states: choice.states.clone(),
            inputs: choice.inputs.iter().cloned().chain(named).collect(),
            outputs: choice.outputs.clone(),
            a,
            b,
            c,
            d,
            state_bias: vec![true; count],
            output_bias: choice.outputs.iter().map(|name| matches!(name.as_str(), "ax" | "ay" | "az")).collect(),
            initial_state: vec![true; count],
        };
        let has = |names: &[&str]| variables.iter().any(|variable| names.contains(&variable.as_str()));
        for (rates, angles, what) in [(&["p", "r"][..], &["v", "beta"][..], "sideslip"), (&["q"], &["w", "alpha"], "incidence")] {
            if choice.states.iter().any(|state| rates.contains(&state.as_str())) && !has(angles) {
                notes.push(format!(
                    "{what} is neither state nor input: its effect is absorbed by the derivatives, which are then not those of \
                     the aircraft; only the roots are"
                ));
            }
        }
        notes.sort();
        notes.dedup();
        let reference_trim_std = ReferenceTrim::std(runs);
        let assumed = |input: &&String| runs.iter().any(|run| run.assumed_scale.contains(*input));
        let assumed_scale = choice.inputs.iter().filter(assumed).cloned().collect();
        Ok(IdentificationModel {
            choice,
            assumed_scale,
            reference_trim,
            reference_trim_std,
            structure,
            derivatives,
            instrument_parameters: Vec::new(),
            remainders,
            nonlinear_outputs: true,
            notes,
        })
    }

    /// Name of the parameter at that place; empty beyond the last.
    pub fn name(&self, place: usize) -> String {
        let instrument = || {
            place.checked_sub(self.derivatives.len()).and_then(|place| Some(self.instrument_parameters.get(place)?.name.clone()))
        };
        match self.derivatives.get(place) {
            Some((axis, variable)) => format!("{axis}_{variable}"),
            None => instrument().unwrap_or_default(),
        }
    }

    /// The derivatives as parameters of a fit, with these start values.
    pub fn parameters(&self, starts: &[f64]) -> Vec<FitParameter> {
        let named = self.derivatives.iter().zip(starts);
        named.map(|((axis, variable), &start)| FitParameter { name: format!("{axis}_{variable}"), start, prior: None }).collect()
    }

    /// Inputs and outputs of a run as deviations from its trim, nonlinear remainders appended to the inputs.
    ///
    /// # Errors
    /// [`ColumnError`] where the run lacks a channel.
    pub fn record(&self, run: &Columns) -> Result<InputOutputRecord, ColumnError> {
        let chosen = self.choice.inputs.iter().map(|name| self.input(run, name));
        let variables: Vec<&String> = self.choice.states.iter().chain(&self.choice.inputs).collect();
        let mut inputs = chosen.collect::<Result<Vec<_>, _>>()?;
        let mut outputs = self.choice.outputs.iter().map(|name| run.deviations(name)).collect::<Result<Vec<_>, ColumnError>>()?;
        if !self.remainders.is_empty() {
            let remainder = NonlinearRemainder::of(run)?;
            inputs.extend(self.remainders.iter().map(|state| remainder.of_state(&self.reference_trim, state, &variables)));
            for (name, values) in self.choice.outputs.iter().zip(&mut outputs).filter(|_| self.nonlinear_outputs) {
                let remainders = remainder.of_output(&self.reference_trim, name, &variables, &run.geometry);
                values.iter_mut().zip(remainders.into_iter().flatten()).for_each(|(value, remainders)| *value -= remainders);
            }
        }
        let noise_std = |(name, values): (&String, &Vec<f64>)| {
            let samples: Vec<(f64, f64)> = run.times_s.iter().copied().zip(values.iter().copied()).collect();
            if is_control(name) { white_noise_std_between_gaps(&samples) } else { 0.0 }
        };
        let input_noise_std = self.choice.inputs.iter().zip(&inputs).map(noise_std).collect();
        Ok(InputOutputRecord { times_s: run.times_s.clone(), inputs, outputs, input_noise_std })
    }

    /// Replaces samples of controls at rest by their mean (`resting_controls`) in the record of that run.
    ///
    /// # Errors
    /// As for [`IdentificationModel::record`].
    pub fn hold_controls(&self, run: &Columns, record: &mut InputOutputRecord) -> Result<(), ColumnError> {
        let inputs = self.choice.inputs.iter().zip(&mut record.inputs);
        for (name, values) in inputs.filter(|(name, _)| is_control(name)) {
            *values = run.held(name)?;
        }
        Ok(())
    }

    /// An input over time; flow angles are transferred from their vane to the centre of mass.
    fn input(&self, run: &Columns, name: &str) -> Result<Vec<f64>, ColumnError> {
        let mut values = run.lines(name)?;
        let [x, y, z] = run.geometry.vane_position_m;
        let arms: [(&str, f64); 2] = match name {
            "beta" => [("r", x), ("p", -z)],
            "alpha" => [("q", -x), ("p", y)],
            _ => return Ok(values),
        };
        for (rate, arm) in arms.into_iter().filter(|(_, arm)| *arm != 0.0) {
            let per_speed = arm / run.trim("tas")?;
            values.iter_mut().zip(run.lines(rate)?).for_each(|(value, rate)| *value -= per_speed * rate);
        }
        Ok(values)
    }
}

fn check(choice: &ModelVariables) -> Result<(), IdentificationModelError> {
    if choice.states.is_empty() {
        return Err(IdentificationModelError::NoState);
    }
    if choice.inputs.is_empty() {
        return Err(IdentificationModelError::NoInput);
    }
    if let Some(name) = choice.states.iter().find(|name| !STATES.contains(&name.as_str())) {
        return Err(IdentificationModelError::State(name.clone()));
    }
    let all: Vec<&String> = choice.states.iter().chain(&choice.inputs).collect();
    for (place, name) in all.iter().enumerate() {
        if all.iter().take(place).any(|other| other == name) {
            return Err(IdentificationModelError::Twice((*name).clone()));
        }
    }
    for (one, other) in [("v", "beta"), ("w", "alpha")] {
        if [one, other].iter().all(|name| choice.states.iter().any(|state| state == name)) {
            return Err(IdentificationModelError::Same(one, other));
        }
    }
    Ok(())
}

/// Rows of C and D, built from those of A and B.
struct MeasurementRows<'a> {
    choice: &'a ModelVariables,
    reference_trim: ReferenceTrim,
    variables: &'a [&'a String],
    found: &'a [Vec<MatrixEntry>],
    rows: &'a [Vec<MatrixEntry>],
    runs: &'a [Columns],
}

impl MeasurementRows<'_> {
    /// The row of an output, (8), (9).
    fn row(&self, name: &str, notes: &mut Vec<String>) -> Result<Vec<MatrixEntry>, IdentificationModelError> {
        let mut row = vec![MatrixEntry::default(); self.variables.len()];
        let ([u0, _, w0], speed) = (self.reference_trim.velocity(), self.reference_trim.airspeed);
        let s2 = u0 * u0 + w0 * w0;
        let slopes = self.reference_trim.flow_slopes(name).unwrap_or_default();
        let [x, y, z] = self.position(|run| run.geometry.vane_position_m, notes);
        let state = |name: &str| self.choice.states.iter().position(|state| state == name);
        let mut add = |variable: &str, factor: f64| match self.variables.iter().position(|known| *known == variable) {
            Some(place) => row[place].fixed += factor,
            // Without its velocity the motion is taken to have none; a rate that is missing turns the vane about.
            None if factor != 0.0 && matches!(variable, "p" | "q" | "r") => {
                notes.push(format!("`{name}` is taken at the centre of mass: `{variable}` is neither state nor input"));
            }
            None => {}
        };
        let [by_u, by_v, by_w] = slopes;
        // Velocities, or the flow angles that stand for them; and what the rates add to them at the vane.
        let mut flow = || {
            add("u", by_u);
            if state("beta").is_some() {
                add("beta", by_v * speed)
            } else {
                add("v", by_v)
            }
            if state("alpha").is_some() { add("alpha", by_w * s2 / u0) } else { add("w", by_w) }
        };
        let turned = [("p", by_w * y - by_v * z), ("q", by_u * z - by_w * x), ("r", by_v * x - by_u * y)];
        match name {
            "beta" | "alpha" if state(name).is_some() || state(if name == "beta" { "v" } else { "w" }).is_some() => {
                flow();
                turned.into_iter().for_each(|(rate, factor)| add(rate, factor));
            }
            "tas" if state("u").is_some() => flow(),
            "ax" | "ay" | "az" => return self.specific_force(name, notes),
            "p" | "q" | "r" | "phi" | "theta" if state(name).is_some() => add(name, 1.0),
            _ => {
                let expected = "`beta` with v or beta, `alpha` with w or alpha, `tas` with u, `ax`, `ay`, `az` with u, v, w";
                return Err(IdentificationModelError::Output { name: name.to_owned(), expected });
            }
        }
        Ok(row)
    }

    /// (9).
    fn specific_force(&self, name: &str, notes: &mut Vec<String>) -> Result<Vec<MatrixEntry>, IdentificationModelError> {
        let state = |name: &str| self.choice.states.iter().position(|state| state == name);
        let [x, y, z] = self.position(|run| run.geometry.accelerometer_position_m, notes);
        let (own, scaled, arms) = match name {
            "ax" => (state("u"), None, [("q", z), ("r", -y)]),
            "ay" => (state("v"), state("beta"), [("r", x), ("p", -z)]),
            _ => (state("w"), state("alpha"), [("p", y), ("q", -x)]),
        };
        let expected = "`ax` with u, `ay` with v or beta, `az` with w or alpha";
        let Some(place) = own.or(scaled) else {
            return Err(IdentificationModelError::Output { name: name.to_owned(), expected });
        };
        let mut row = vec![MatrixEntry::default(); self.variables.len()];
        let mut add = |from: &[MatrixEntry], factor: f64| {
            for (entry, from) in row.iter_mut().zip(from) {
                entry.fixed += factor * from.fixed;
                entry.terms.extend(from.terms.iter().map(|(parameter, part)| (*parameter, part * factor)));
            }
        };
        if let Some(own) = self.found.get(place) {
            add(own, if own_is_velocity(self.choice, place) { 1.0 } else { self.reference_trim.airspeed });
        }
        for (rate, arm) in arms.into_iter().filter(|(_, arm)| *arm != 0.0) {
            match state(rate).and_then(|place| self.rows.get(place)) {
                Some(turning) => add(turning, arm),
                None => notes.push(format!("`{name}` is taken at the centre of mass: `{rate}` is no state")),
            }
        }
        Ok(row)
    }

    /// The position of an instrument; that of the first run, with a note, where runs differ.
    fn position(&self, of: impl Fn(&Columns) -> [f64; 3], notes: &mut Vec<String>) -> [f64; 3] {
        let first = self.runs.first().map_or([0.0; 3], &of);
        let same = |other: [f64; 3]| other.into_iter().zip(first).all(|(one, other)| one.to_bits() == other.to_bits());
        if !self.runs.iter().all(|run| same(of(run))) {
            notes.push("the runs' instruments stand at different places: the first run's are taken".to_owned());
        }
        first
    }
}

fn own_is_velocity(choice: &ModelVariables, place: usize) -> bool {
    choice.states.get(place).is_some_and(|state| matches!(state.as_str(), "u" | "v" | "w"))
}
