//! What belongs to one run alone (initial state and biases), and runs that were not fitted.

use super::dense::Dense;
use super::discrete::{Layout, Prepared};
use super::fitted::FittedRun;
use super::information::{Linear, Whitening};
use super::model::{Delay, Record, Structure};
use super::refused::Refused;
use super::simulated::{Run, simulate};

/// One run's own values; 0 where the structure leaves them none.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Own {
    /// x(0), by state.
    pub initial_state: Vec<f64>,
    /// b, by state.
    pub state_bias: Vec<f64>,
    /// c, by output.
    pub output_bias: Vec<f64>,
}

impl Own {
    /// All zero.
    pub fn zero(layout: &Layout) -> Self {
        Own {
            initial_state: vec![0.0; layout.states],
            state_bias: vec![0.0; layout.states],
            output_bias: vec![0.0; layout.outputs],
        }
    }

    /// Moved by the free ones' steps in the order x0, b, c.
    pub(crate) fn moved(&self, layout: &Layout, step: &[f64]) -> Own {
        let mut own = self.clone();
        let mut steps = step.iter();
        for (values, places) in [
            (&mut own.initial_state, &layout.initial),
            (&mut own.state_bias, &layout.state_bias),
            (&mut own.output_bias, &layout.output_bias),
        ] {
            for (&place, step) in places.iter().zip(&mut steps) {
                if let Some(value) = values.get_mut(place) {
                    *value += step;
                }
            }
        }
        own
    }
}

fn prepared<'a>(
    structure: &'a Structure,
    theta: &[f64],
    delays: &[Delay],
    record: &Record,
) -> Result<(Prepared<'a>, Run), Refused> {
    structure.check(theta.len(), delays)?;
    structure.check_record(record, 0)?;
    let prepared = Prepared::new(structure, Layout::new(structure, theta.len(), delays));
    let mut run = Run::new(record, &prepared.layout);
    run.delay(&prepared.layout, theta);
    Ok((prepared, run))
}

/// Outputs of the model with these values over a run, by output and sample; what the run measured is not looked at.
///
/// # Errors
/// What [`Structure::check`] and [`Structure::check_record`] refuse; [`Refused::Diverges`].
pub fn predict(
    structure: &Structure,
    theta: &[f64],
    delays: &[Delay],
    record: &Record,
    own: &Own,
) -> Result<Vec<Vec<f64>>, Refused> {
    let (prepared, run) = prepared(structure, theta, delays, record)?;
    for (what, expected, found) in [
        ("initial states", prepared.layout.states, own.initial_state.len()),
        ("state biases", prepared.layout.states, own.state_bias.len()),
        ("output biases", prepared.layout.outputs, own.output_bias.len()),
    ] {
        if expected != found {
            return Err(Refused::Shape { what: what.to_owned(), expected, found });
        }
    }
    let point = prepared.at(theta);
    let simulated = simulate(&prepared.layout, &point, &prepared.steps(&point, &run.timeline, false), &run, own);
    if simulated.outputs.iter().any(|y| !y.is_finite()) {
        return Err(Refused::Diverges { run: 0 });
    }
    let outputs = prepared.layout.outputs;
    Ok((0..outputs).map(|o| simulated.outputs.iter().skip(o).step_by(outputs).copied().collect()).collect())
}

/// A run that was not fitted, followed with the parameters held: only its own initial state and biases are found, by least
/// squares weighed with the noise covariance of the fit.
///
/// # Errors
/// As [`predict`]; [`Refused::Singular`] where the run does not tell its own values apart.
pub fn follow(
    structure: &Structure,
    theta: &[f64],
    delays: &[Delay],
    noise_cov: &Dense,
    record: &Record,
) -> Result<FittedRun, Refused> {
    let (prepared, run) = prepared(structure, theta, delays, record)?;
    let layout = &prepared.layout;
    let point = prepared.at(theta);
    let steps = prepared.steps(&point, &run.timeline, true);
    let output_lines = prepared.output_lines();
    let linear = Linear { prepared: &prepared, point: &point, steps: &steps, output_lines: &output_lines };
    let mut own = Own::zero(layout);
    let mut simulated = simulate(layout, &point, &steps, &run, &own);
    if simulated.outputs.iter().any(|y| !y.is_finite()) {
        return Err(Refused::Diverges { run: 0 });
    }
    let weights = noise_cov.diagonal().iter().map(|variance| 1.0 / libm::sqrt(*variance)).collect();
    let information = linear.information(&run, &simulated, &own, &Whitening::Diagonal(weights));
    let (from, to) = (layout.parameters, layout.columns());
    let mut cov = Dense::zeros(0, 0);
    if to > from {
        let matrix = information.part(from..to, from..to);
        cov = inverse_or_names(&matrix, &structure.own_names(0))?;
        let step = cov.times(&information.part(from..to, to..to + 1));
        let step: Vec<f64> = (0..step.rows()).map(|i| step[(i, 0)]).collect();
        own = own.moved(layout, &step);
        simulated = simulate(layout, &point, &steps, &run, &own);
    }
    let stds: Vec<f64> = cov.diagonal().iter().map(|variance| libm::sqrt(*variance)).collect();
    let std = Own::zero(layout).moved(layout, &stds);
    Ok(FittedRun::new(layout, &run, own, std, &simulated))
}

/// Inverse of an information matrix, or the names that it does not tell apart.
pub(crate) fn inverse_or_names(matrix: &Dense, names: &[String]) -> Result<Dense, Refused> {
    let diagonal = matrix.diagonal();
    let blind: Vec<String> = diagonal
        .iter()
        .zip(names)
        .filter(|(value, _)| !(**value > 0.0) || !value.is_finite())
        .map(|(_, name)| name.clone())
        .collect();
    if !blind.is_empty() {
        return Err(Refused::Singular { names: blind, smallest: 0.0 });
    }
    let scale: Vec<f64> = diagonal.iter().map(|value| 1.0 / libm::sqrt(*value)).collect();
    let scaled = Dense::from_fn(matrix.rows(), matrix.rows(), |i, j| matrix[(i, j)] * scale[i] * scale[j]);
    if let Some(inverse) = scaled.inverse() {
        return Ok(Dense::from_fn(matrix.rows(), matrix.rows(), |i, j| inverse[(i, j)] * scale[i] * scale[j]));
    }
    let (values, vectors) = scaled.symmetric_eigen();
    let part = |i: usize| vectors[(i, 0)].abs();
    let most = (0..names.len()).map(part).fold(0.0, f64::max);
    let names = names.iter().enumerate().filter(|(i, _)| part(*i) > 0.2 * most).map(|(_, name)| name.clone()).collect();
    Err(Refused::Singular { names, smallest: values.first().copied().unwrap_or(0.0) })
}
