//! One identification: structure, start values, output error over all runs, modes, and the prediction of hold-out runs.
//!
//! Consumes runs in columns and a request; produces [`IdentificationResult`]. In order: start values by equation error
//! (`start_values`), output error, then as requested instrument parameters with delays linearised about the last fit
//! (`instrument_parameters`) and filter error with vibration removed (`vibration`, `process_noise`). A hold-out run is predicted
//! from its own trim with its measured inputs; nothing is fitted to it.
//! Returns [`IdentificationError`] where the model cannot be built or the fit is refused; no modes where the search has not
//! converged.

use super::columns::{ColumnError, Columns};
use super::identification_model::IdentificationModel;
use super::instrument_notes::{instrument_note, misfit_note};
use super::instrument_parameters::relinearise_delays;
use super::model_variables::{IdentificationModelError, ModelVariables, is_control};
use super::process_noise::disturbances;
use super::roots::{Modes, modes};
use super::run_prediction::RunPrediction;
use super::start_values::starts;
use super::usual_variables::{STILL_RAD, are_separate, excited, plane_of, square_mean};
use super::vibration::remove_vibration;
use crate::postflight::output_error::filter_error;
use crate::postflight::output_error::filter_error::ProcessNoiseEstimate;
use crate::postflight::output_error::{FitResult, FitSettings, OutputErrorFitError, RunParameters, fit, predict};

/// How errors of instruments are treated.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum InstrumentTreatment {
    /// Noise and bias only.
    #[default]
    Trusted,
    /// Scales, delays, and the trim's incidence and airspeed are estimated too: see `instrument_parameters`; controls at
    /// rest are replaced by their mean: see `resting_controls`.
    Estimated,
}

/// Likelihood that the parameters maximise.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum FitMethod {
    /// Measurement noise only.
    #[default]
    OutputError,
    /// Measurement noise and process noise: gusts, noise of the inputs.
    FilterError,
}

/// What to identify and how.
#[derive(Clone, Debug)]
pub struct IdentificationRequest {
    /// Names of states, inputs and outputs.
    pub choice: ModelVariables,
    /// The derivatives to estimate, by axis and variable; `None` for all.
    pub only: Option<Vec<(char, String)>>,
    /// Treatment of errors of instruments.
    pub instruments: InstrumentTreatment,
    /// Output error or filter error.
    pub method: FitMethod,
}

impl From<ModelVariables> for IdentificationRequest {
    /// All derivatives by output error, instruments trusted.
    fn from(choice: ModelVariables) -> Self {
        IdentificationRequest { choice, only: None, instruments: InstrumentTreatment::Trusted, method: FitMethod::OutputError }
    }
}

/// The identified model, its fit and its predictions.
#[derive(Clone, Debug)]
pub struct IdentificationResult {
    /// Structure and names of the parameters.
    pub linear: IdentificationModel,
    /// Start values of output error, by derivative.
    pub starts: Vec<f64>,
    /// Fit of output error, or of filter error started from it.
    pub fitted: FitResult,
    /// Estimated process noise; `None` of output error.
    pub disturbed: Option<ProcessNoiseEstimate>,
    /// Modes of A, or the reason why there are none.
    pub modes: Modes,
    /// Runs of the fit, measured and predicted.
    pub fit: Vec<RunPrediction>,
    /// Hold-out runs, measured and predicted.
    pub holdout: Vec<RunPrediction>,
}

/// Why an identification is refused.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[expect(missing_docs, reason = "the message of each says what its fields are")]
pub enum IdentificationError {
    #[error(transparent)]
    Model(#[from] IdentificationModelError),
    #[error("output error: {0}")]
    Fit(#[from] OutputErrorFitError),
}

impl From<ColumnError> for IdentificationError {
    fn from(error: ColumnError) -> Self {
        IdentificationError::Model(error.into())
    }
}

/// Fits the requested model to the runs and predicts the hold-out runs with it.
///
/// # Errors
/// [`IdentificationError`] where the model cannot be built or the fit is refused.
pub fn identify(
    runs: &[Columns],
    holdout: &[Columns],
    request: IdentificationRequest,
    settings: &FitSettings,
) -> Result<IdentificationResult, IdentificationError> {
    let separate = request.only.as_deref().is_some_and(|only| are_separate(&request.choice, only));
    let mut linear = IdentificationModel::new(request.choice, runs, request.only.as_deref())?;
    let mut records = runs.iter().map(|run| linear.record(run)).collect::<Result<Vec<_>, _>>()?;
    let mut holdout_records = holdout.iter().map(|run| linear.record(run)).collect::<Result<Vec<_>, _>>()?;
    for (run, record) in runs.iter().zip(&mut records).chain(holdout.iter().zip(&mut holdout_records)) {
        linear.hold_controls(run, record)?;
    }
    let starts = starts(&linear, &records);
    let mut fitted = fit(&linear.structure, &linear.parameters(&starts), &[], &records, settings)?;
    let filtered = request.method == FitMethod::FilterError;
    let instruments_estimated = request.instruments == InstrumentTreatment::Estimated;
    if instruments_estimated {
        // Delays are linearised about those of the fit before.
        linear.add_instrument_parameters();
        relinearise_delays(&linear, &mut records, &fitted)?;
        fitted = fit(&linear.structure, &linear.parameters_with_instruments(&fitted), &[], &records, settings)?;
    }
    let mut changed = instruments_estimated;
    if filtered {
        for (record, own) in records.iter_mut().zip(&fitted.runs) {
            changed |= remove_vibration(&mut linear, record, &own.predicted);
        }
    }
    if instruments_estimated {
        relinearise_delays(&linear, &mut records, &fitted)?;
    }
    if changed {
        fitted = fit(&linear.structure, &linear.parameters_with_instruments(&fitted), &[], &records, settings)?;
    }
    let mut disturbed = None;
    if filtered {
        let disturbances = disturbances(&linear, runs, &records)?;
        if instruments_estimated {
            relinearise_delays(&linear, &mut records, &fitted)?;
        }
        let parameters = linear.parameters_with_instruments(&fitted);
        let (better, found) = filter_error::fit(&linear.structure, &parameters, &[], &records, &disturbances, settings, &fitted)?;
        (fitted, disturbed) = (better, Some(found));
        linear.notes.push(NARROW.to_owned());
    }
    if instruments_estimated {
        let own = zero_run_parameters(&linear);
        let flown = holdout_records.into_iter().map(|record| linear.record_with_delays(record, &fitted.theta, &own));
        holdout_records = flown.collect::<Result<_, OutputErrorFitError>>()?;
    }
    linear.notes.extend(coloured(&fitted));
    linear.notes.extend(unexcited(&linear.choice, runs));
    linear.notes.extend(runs.iter().filter_map(|run| unsteady(&linear.choice, run)));
    if !instruments_estimated && !filtered && fitted.converged {
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
    let misfits = fit.iter().zip(runs).filter_map(|(flown, run)| {
        // Of a model of separate planes a run shows those that it excited.
        let excited = separate.then(|| excited(run));
        misfit_note(flown, &linear.structure.outputs, |name| {
            excited.is_none_or(|planes| plane_of(name).is_none_or(|plane| planes.get(plane) == Some(&true)))
        })
    });
    let misfits: Vec<String> = misfits.collect();
    linear.notes.extend(misfits);
    let own = zero_run_parameters(&linear);
    let holdout_predictions = holdout.iter().zip(holdout_records).map(|(run, record)| {
        let predicted = predict(&linear.structure, &fitted.theta, &[], &record, &own)?;
        Ok(RunPrediction::new(run, record, predicted))
    });
    let holdout = holdout_predictions.collect::<Result<_, OutputErrorFitError>>()?;
    Ok(IdentificationResult { linear, starts, fitted, disturbed, modes, fit, holdout })
}

/// What is known of filter error's intervals (`tests/paper`).
const NARROW: &str = "filter error: in still air 94 of 100 intervals of 95 % held the truth in simulated flights, in gusts of 1 m/s 65; \
                      there take the standard errors twice as large";
/// Median ratio of corrected standard errors to those for white residuals above which a note is made.
const COLOURED: f64 = 5.0;
/// Ratio of control motion (rms) between the planes below which the lesser plane is unexcited.
const UNEXCITED: f64 = 0.2;

/// A note where residuals are far from white: an effect acts that is not in the model.
fn coloured(fitted: &FitResult) -> Option<String> {
    let ratio = fitted.colour_ratio().filter(|ratio| *ratio > COLOURED)?;
    Some(format!(
        "the residuals are not noise, a motion is left in them: standard errors are taken {ratio:.0} times as large for it, and \
         may still be too small; the model lacks something: another state (--states), gusts (--method filter-error), an error of \
         an instrument (--doubt-instruments, `sideslip check`), or amplitudes that are not small"
    ))
}

/// A note on the plane that no control excited, of a model of both planes.
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

/// Ratio of a control's rms in the trim window to that over the run above which the window is no trim.
const UNSTEADY: f64 = 0.3;

/// A note on a run whose control moves in the trim window: deviations are then not from a trim.
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

/// Initial state at trim and no biases.
fn zero_run_parameters(linear: &IdentificationModel) -> RunParameters {
    let (states, outputs) = (linear.structure.states.len(), linear.structure.outputs.len());
    RunParameters { initial_state: vec![0.0; states], state_bias: vec![0.0; states], output_bias: vec![0.0; outputs] }
}
