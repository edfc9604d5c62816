//! One identification: structure, start values, output error over all runs, modes, and the prediction of hold-out runs.
//!
//! Consumes runs in columns and a request; produces [`IdentificationResult`]. A hold-out run is predicted from its own trim with
//! its measured inputs; nothing is fitted to it.

use super::columns::{ColumnError, Columns};
use super::identification_model::IdentificationModel;
use super::instrument_notes::{instrument_note, misfit_note};
use super::instrument_parameters::relinearise_delays;
use super::model_variables::{IdentificationModelError, ModelVariables, is_control};
use super::process_noise::disturbances;
use super::roots::{Modes, modes};
use super::run_prediction::RunPrediction;
use super::start_values::starts;
use super::vibration::without_vibration;
use crate::postflight::output_error::filter_error;
use crate::postflight::output_error::filter_error::ProcessNoiseEstimate;
use crate::postflight::output_error::{FitResult, FitSettings, OutputErrorFitError, RunParameters, fit, predict};

/// How errors of instruments are treated.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum InstrumentTreatment {
    /// Noise and bias only.
    #[default]
    Trusted,
    /// Scales, delays, and the trim's incidence and airspeed are estimated too: see [`super::instrument_parameters`]; controls at
    /// rest are replaced by their mean: see [`super::resting_controls`].
    Estimated,
}

/// By which method the parameters are found.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum FitMethod {
    /// Noise on the outputs alone.
    #[default]
    OutputError,
    /// Gusts and noise of the inputs too.
    FilterError,
}

/// What is wanted.
#[derive(Clone, Debug)]
pub struct IdentificationRequest {
    /// States, inputs, outputs.
    pub choice: ModelVariables,
    /// Those derivatives alone, by axis and variable; all without it.
    pub only: Option<Vec<(char, String)>>,
    /// Whether instruments are believed.
    pub instruments: InstrumentTreatment,
    /// By which method.
    pub method: FitMethod,
}

impl From<ModelVariables> for IdentificationRequest {
    /// All derivatives, instruments believed.
    fn from(choice: ModelVariables) -> Self {
        IdentificationRequest { choice, only: None, instruments: InstrumentTreatment::Trusted, method: FitMethod::OutputError }
    }
}

/// What was identified.
#[derive(Clone, Debug)]
pub struct IdentificationResult {
    /// The structure.
    pub linear: IdentificationModel,
    /// Where output error started, by derivative.
    pub starts: Vec<f64>,
    /// What it found, or filter error from there.
    pub fitted: FitResult,
    /// What filter error found besides; `None` where output error answers.
    pub disturbed: Option<ProcessNoiseEstimate>,
    /// The modes, or why there are none.
    pub modes: Modes,
    /// The runs that it was fitted to.
    pub fit: Vec<RunPrediction>,
    /// The runs that it was not.
    pub holdout: Vec<RunPrediction>,
}

/// Why there is no answer.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum IdentificationError {
    /// The choice or a run is wrong.
    #[error(transparent)]
    Model(#[from] IdentificationModelError),
    /// Output error cannot answer.
    #[error("output error: {0}")]
    Fit(#[from] OutputErrorFitError),
}

impl From<ColumnError> for IdentificationError {
    fn from(error: ColumnError) -> Self {
        IdentificationError::Model(error.into())
    }
}

/// Identifies the chosen model from the runs and flies the others with it.
///
/// # Errors
/// [`IdentificationError`] with what is wrong.
pub fn identify(
    runs: &[Columns],
    holdout: &[Columns],
    wanted: IdentificationRequest,
    settings: &FitSettings,
) -> Result<IdentificationResult, IdentificationError> {
    let mut linear = IdentificationModel::new(wanted.choice, runs, wanted.only.as_deref())?;
    let mut records = runs.iter().map(|run| linear.record(run)).collect::<Result<Vec<_>, _>>()?;
    let mut kept_back = holdout.iter().map(|run| linear.record(run)).collect::<Result<Vec<_>, _>>()?;
    for (run, record) in runs.iter().zip(&mut records).chain(holdout.iter().zip(&mut kept_back)) {
        linear.hold_controls(run, record)?;
    }
    let starts = starts(&linear, &records);
    let mut fitted = fit(&linear.structure, &linear.parameters(&starts), &[], &records, settings)?;
    let filtered = wanted.method == FitMethod::FilterError;
    let doubted = wanted.instruments == InstrumentTreatment::Estimated;
    if doubted {
        // The lateness of every fit is what the next one's is about.
        linear.add_instrument_parameters();
        relinearise_delays(&linear, &mut records, &fitted)?;
        fitted = fit(&linear.structure, &linear.parameters_with_instruments(&fitted), &[], &records, settings)?;
    }
    let mut changed = doubted;
    if filtered {
        for (record, own) in records.iter_mut().zip(&fitted.runs) {
            changed |= without_vibration(&mut linear, record, &own.predicted);
        }
    }
    if doubted {
        relinearise_delays(&linear, &mut records, &fitted)?;
    }
    if changed {
        fitted = fit(&linear.structure, &linear.parameters_with_instruments(&fitted), &[], &records, settings)?;
    }
    let mut disturbed = None;
    if filtered {
        let disturbances = disturbances(&linear, runs, &records)?;
        if doubted {
            relinearise_delays(&linear, &mut records, &fitted)?;
        }
        let parameters = linear.parameters_with_instruments(&fitted);
        let (better, found) = filter_error::fit(&linear.structure, &parameters, &[], &records, &disturbances, settings, &fitted)?;
        (fitted, disturbed) = (better, Some(found));
        linear.notes.push(NARROW.to_owned());
    }
    if doubted {
        let own = zero_run_parameters(&linear);
        let flown = kept_back.into_iter().map(|record| linear.record_with_delays(record, &fitted.theta, &own));
        kept_back = flown.collect::<Result<_, OutputErrorFitError>>()?;
    }
    linear.notes.extend(coloured(&fitted));
    linear.notes.extend(unexcited(&linear.choice, runs));
    linear.notes.extend(runs.iter().filter_map(|run| unsteady(&linear.choice, run)));
    if !doubted && !filtered && fitted.converged {
        linear.notes.extend(instrument_note(&linear, &records, &fitted, settings));
    }
    let modes = if fitted.converged {
        modes(
            &linear.structure,
            &fitted.theta,
            &fitted.cov,
            &linear.reference_trim.steps(linear.reference_trim_std, &linear.choice.states),
        )
    } else {
        Err("the search has not converged".to_owned())
    };
    let fit = runs
        .iter()
        .zip(records)
        .zip(&fitted.runs)
        .map(|((run, record), fitted)| RunPrediction::new(run, record, fitted.predicted.clone()));
    let fit: Vec<RunPrediction> = fit.collect();
    linear.notes.extend(fit.iter().filter_map(|flown| misfit_note(flown, &linear.structure.outputs)));
    let own = zero_run_parameters(&linear);
    let flown_back = holdout.iter().zip(kept_back).map(|(run, record)| {
        let predicted = predict(&linear.structure, &fitted.theta, &[], &record, &own)?;
        Ok(RunPrediction::new(run, record, predicted))
    });
    let holdout = flown_back.collect::<Result<_, OutputErrorFitError>>()?;
    Ok(IdentificationResult { linear, starts, fitted, disturbed, modes, fit, holdout })
}

/// What is known of filter error's intervals (`tests/paper`).
const NARROW: &str = "filter error: in still air 94 of 100 intervals of 95 % held the truth in simulated flights, in gusts of 1 m/s 65; \
                      there take the standard errors twice as large";
/// Corrected standard errors so many times those for white residuals (median) are said.
const COLOURED: f64 = 5.0;
/// Controls of one plane that move less than this part of the other's leave their own plane unexcited.
const UNEXCITED: f64 = 0.2;

/// Says where the residuals are far from white: then something acts that the model does not have.
fn coloured(fitted: &FitResult) -> Option<String> {
    let ratio = fitted.colour_ratio().filter(|ratio| *ratio > COLOURED)?;
    Some(format!(
        "the residuals are far from white: standard errors are {ratio:.0} times what white ones would give, and may still be too \
         small; something acts that this model does not have (a state, a nonlinearity, gusts, an instrument)"
    ))
}

/// Says of a model of both planes which of them no control moved.
fn unexcited(choice: &ModelVariables, runs: &[Columns]) -> Option<String> {
    let has = |name: &str| choice.states.iter().any(|state| state == name);
    let moved = |names: &[&str]| {
        let of_run = |run: &Columns, name: &str| run.deviations(name).map_or(0.0, |values| square_mean(&values));
        let all = runs.iter().flat_map(|run| names.iter().map(move |name| of_run(run, name)));
        libm::sqrt(all.fold(0.0, f64::max))
    };
    let longitudinal = moved(&["lon_cyclic", "collective", "elevator", "throttle"]);
    let lateral = moved(&["lat_cyclic", "pedal", "aileron", "rudder"]);
    let (axes, plane) = match (has("q") && has("p"), longitudinal < UNEXCITED * lateral, lateral < UNEXCITED * longitudinal) {
        (true, true, _) => ("X Z M", "longitudinal"),
        (true, _, true) => ("Y L N", "lateral"),
        _ => return None,
    };
    Some(format!(
        "{axes}: no {plane} control moved beside the others, so these derivatives hold what was left of that motion in these runs \
         and are not the aircraft's; fly the {plane} controls too"
    ))
}

/// A control that moves in the trim's window by this part of what it does in the whole run has no trim there.
const UNSTEADY: f64 = 0.3;

/// Says of a run whose trim is taken while a control moves: deviations, speed and attitude are then from no trim at all.
fn unsteady(choice: &ModelVariables, run: &Columns) -> Option<String> {
    let moves = |name: &&String| {
        let Ok(values) = run.deviations(name) else { return false };
        let rms = |values: &[f64]| libm::sqrt(square_mean(values));
        let (window, whole) = (rms(values.get(..run.trim_rows()).unwrap_or_default()), rms(&values));
        is_control(name) && whole > STILL_RAD && window > UNSTEADY * whole
    };
    let moving: Vec<String> = choice.inputs.iter().filter(moves).map(|name| format!("`{name}`")).collect();
    (!moving.is_empty()).then(|| {
        format!(
            "{}: {} moves in the window its trim is taken from; give one in which nothing happens yet (`--trim-window`)",
            run.run,
            moving.join(", ")
        )
    })
}

/// In trim, nothing of a run's own.
fn zero_run_parameters(linear: &IdentificationModel) -> RunParameters {
    let (states, outputs) = (linear.structure.states.len(), linear.structure.outputs.len());
    RunParameters { initial_state: vec![0.0; states], state_bias: vec![0.0; states], output_bias: vec![0.0; outputs] }
}

/// What a person would choose who was not asked: of a helicopter all eight states, for its planes are coupled and a model of
/// one finds the other's derivatives in its own; else the lateral motion with what measures it, or the longitudinal one where
/// that was excited; over the controls that moved.
pub fn usual_choice(runs: &[Columns]) -> ModelVariables {
    let all = |name: &str| runs.iter().all(|run| run.has(name));
    let rms = |name: &str| {
        let of_run = |run: &Columns| run.deviations(name).map_or(0.0, |values| square_mean(&values));
        libm::sqrt(runs.iter().map(of_run).fold(0.0, f64::max))
    };
    let owned = |names: &[&str]| names.iter().map(|&name| name.to_owned()).collect::<Vec<_>>();
    let moved = |names: &[&str]| -> Vec<String> {
        let moved = |name: &&&str| all(name) && rms(name) > STILL_RAD;
        names.iter().filter(moved).map(|&name| name.to_owned()).collect()
    };
    if all("lat_cyclic") && MEASURING_ALL.iter().all(|name| all(name)) {
        return ModelVariables {
            states: owned(&["u", "w", "q", "theta", "v", "p", "phi", "r"]),
            inputs: moved(&["lon_cyclic", "collective", "lat_cyclic", "pedal"]),
            outputs: owned(&MEASURING_ALL),
        };
    }
    let longitudinal = rms("q") > rms("p").max(rms("r"));
    let states: &[&str] = match (longitudinal, all("beta"), all("alpha")) {
        (false, true, _) => &["v", "p", "phi", "r"],
        (false, false, _) => &["p", "r"],
        (true, _, true) => &["w", "q"],
        (true, _, false) => &["q"],
    };
    let outputs: &[&str] = match (longitudinal, all("beta"), all("alpha")) {
        (false, true, _) => &["beta", "p", "phi", "r", "ay"],
        (false, false, _) => &["p", "r"],
        (true, _, true) => &["alpha", "q", "az"],
        (true, _, false) => &["q"],
    };
    let inputs = if longitudinal {
        moved(&["lon_cyclic", "elevator", "collective", "throttle"])
    } else {
        moved(&["lat_cyclic", "aileron", "pedal", "rudder"])
    };
    let outputs = outputs.iter().copied().filter(|name| all(name)).collect::<Vec<_>>();
    ModelVariables { states: owned(states), inputs, outputs: owned(&outputs) }
}

/// What measures all eight states and the forces on them.
const MEASURING_ALL: [&str; 11] = ["tas", "alpha", "q", "theta", "beta", "p", "phi", "r", "ax", "ay", "az"];
/// A control that moves less than this (rms, rad) stands still.
const STILL_RAD: f64 = 5e-4;

fn square_mean(values: &[f64]) -> f64 {
    let known = values.iter().filter(|value| value.is_finite());
    let (sum, count) = known.fold((0.0, 0.0), |(sum, count), value| (sum + value * value, count + 1.0));
    if count > 0.0 { sum / count } else { 0.0 }
}
