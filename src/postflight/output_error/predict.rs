//! Runs that were not fitted: prediction with given run parameters, and least squares for the run parameters alone.

use super::discrete::{PreparedModel, UnknownLayout};
use super::error::OutputErrorFitError;
use super::fit_result::FittedRun;
use super::identifiability::inverse_or_names;
use super::information::{SensitivityModel, Whitening};
use super::model::{InputDelay, InputOutputRecord, ModelStructure};
use super::run_parameters::RunParameters;
use super::simulated_outputs::{PreparedRun, simulate};
use crate::num::dense::Dense;

fn prepared<'a>(
    structure: &'a ModelStructure,
    theta: &[f64],
    delays: &[InputDelay],
    record: &InputOutputRecord,
) -> Result<(PreparedModel<'a>, PreparedRun), OutputErrorFitError> {
    structure.check(theta.len(), delays)?;
    structure.check_record(record, 0)?;
    let prepared = PreparedModel::new(structure, UnknownLayout::new(structure, theta.len(), delays));
    let mut run = PreparedRun::new(record, &prepared.layout);
    run.delay(&prepared.layout, theta);
    Ok((prepared, run))
}

/// Outputs of the model with these values over a run, by output and sample; the measured outputs are not used.
///
/// # Errors
/// What [`ModelStructure::check`] and [`ModelStructure::check_record`] refuse; [`OutputErrorFitError::Diverges`].
pub fn predict(
    structure: &ModelStructure,
    theta: &[f64],
    delays: &[InputDelay],
    record: &InputOutputRecord,
    run_parameters: &RunParameters,
) -> Result<Vec<Vec<f64>>, OutputErrorFitError> {
    let (prepared, run) = prepared(structure, theta, delays, record)?;
    for (what, expected, found) in [
        ("initial states", prepared.layout.states, run_parameters.initial_state.len()),
        ("state biases", prepared.layout.states, run_parameters.state_bias.len()),
        ("output biases", prepared.layout.outputs, run_parameters.output_bias.len()),
    ] {
        if expected != found {
            return Err(OutputErrorFitError::Shape { what: what.to_owned(), expected, found });
        }
    }
    let point = prepared.at(theta);
    let simulated = simulate(&prepared.layout, &point, &prepared.steps(&point, &run.timeline, false), &run, run_parameters);
    if simulated.outputs.iter().any(|y| !y.is_finite()) {
        return Err(OutputErrorFitError::Diverges { run: 0 });
    }
    let outputs = prepared.layout.outputs;
    Ok((0..outputs).map(|o| simulated.outputs.iter().skip(o).step_by(outputs).copied().collect()).collect())
}

/// A run that was not fitted, followed with the parameters held: only its own initial state and biases are found, by least
/// squares weighed with the noise covariance of the fit.
///
/// # Errors
/// As [`predict`]; [`OutputErrorFitError::Singular`] where the run does not tell its own values apart.
pub fn fit_run_parameters(
    structure: &ModelStructure,
    theta: &[f64],
    delays: &[InputDelay],
    noise_cov: &Dense,
    record: &InputOutputRecord,
) -> Result<FittedRun, OutputErrorFitError> {
    let (prepared, run) = prepared(structure, theta, delays, record)?;
    let layout = &prepared.layout;
    let point = prepared.at(theta);
    let steps = prepared.steps(&point, &run.timeline, true);
    let output_lines = prepared.output_lines();
    let linear = SensitivityModel { prepared: &prepared, point: &point, steps: &steps, output_lines: &output_lines };
    let mut run_parameters = RunParameters::zero(layout);
    let mut simulated = simulate(layout, &point, &steps, &run, &run_parameters);
    if simulated.outputs.iter().any(|y| !y.is_finite()) {
        return Err(OutputErrorFitError::Diverges { run: 0 });
    }
    let weights = noise_cov.diagonal().iter().map(|variance| 1.0 / libm::sqrt(*variance)).collect();
    let information = linear.information(&run, &simulated, &run_parameters, &Whitening::Diagonal(weights));
    let (from, to) = (layout.parameters, layout.columns());
    let mut cov = Dense::zeros(0, 0);
    if to > from {
        let matrix = information.part(from..to, from..to);
        cov = inverse_or_names(&matrix, &structure.run_parameter_names(0))?;
        let step = cov.times(&information.part(from..to, to..to + 1));
        let step: Vec<f64> = (0..step.rows()).map(|i| step[(i, 0)]).collect();
        run_parameters = run_parameters.moved(layout, &step);
        simulated = simulate(layout, &point, &steps, &run, &run_parameters);
    }
    let stds: Vec<f64> = cov.diagonal().iter().map(|variance| libm::sqrt(*variance)).collect();
    let std = RunParameters::zero(layout).moved(layout, &stds);
    Ok(FittedRun::new(layout, &run, run_parameters, std, &simulated))
}
