//! The result of a fit by filter error: covariances, innovations of every run, estimates of the process noise.
//!
//! The unknowns are theta, ln q, ln r and the run parameters. M is (2) of `likelihood`. In W of `covariance`, the part of the
//! means comes from the autocovariance of the innovations (`coloured_errors`, on innovations over their standard deviations), the
//! part of the variances stays as in M. White innovations give W = M but for chance.

use super::likelihood::FilterErrorLikelihood;
use super::likelihood::FilterErrorSearch;
use super::process_noise::{Gust, ProcessNoiseEstimate};
use crate::num::dense::Dense;
use crate::postflight::output_error::coloured_errors::ColouredGradient;
use crate::postflight::output_error::covariance::{AllUnknowns, standard_errors};
use crate::postflight::output_error::error::OutputErrorFitError;
use crate::postflight::output_error::fit_result::{FitEnd, FitResult, FittedRun};
use crate::postflight::output_error::identifiability::inverse_or_names;
use crate::postflight::output_error::simulated_outputs::simulate;

/// What a run's innovations are.
struct FilterErrorInnovations {
    coloured: ColouredGradient,
    variances: Dense,
    predicted: Vec<Vec<f64>>,
}

/// The result at the end of the search.
pub(crate) fn result(
    posed: &mut FilterErrorLikelihood<'_>,
    ended: FilterErrorSearch,
) -> Result<(FitResult, ProcessNoiseEstimate), OutputErrorFitError> {
    let FilterErrorSearch { stand, iterations, converged } = ended;
    let layout = posed.problem.prepared.layout.clone();
    let (p, columns, outputs) = (posed.parameters, layout.columns(), layout.outputs);
    let unknowns = AllUnknowns::new(&layout, stand.run_parameters.len());
    let size = unknowns.size();
    let mut names: Vec<String> = posed.problem.parameters.iter().map(|one| one.name.clone()).collect();
    let (mut m, mut runs) = (Dense::zeros(size, size), Vec::new());
    let (mut spread, mut noise) = (vec![0.0; outputs], vec![0.0; outputs]);
    let r = posed.noise(&stand.theta);
    for run in 0..stand.run_parameters.len() {
        names.extend(posed.problem.prepared.structure.run_parameter_names(run));
        let samples = posed.problem.runs.get(run).map_or(0, |one| one.samples);
        let width = outputs * columns;
        let (mut rows, mut whitened) = (vec![0.0; samples * width], vec![f64::NAN; samples * outputs]);
        let mut predicted = vec![vec![f64::NAN; samples]; outputs];
        let measured = posed.problem.runs.get(run).map(|one| one.outputs.clone()).unwrap_or_default();
        let (means, variances) = posed.information_of(run, &stand, |one| {
            let (root, place) = (libm::sqrt(one.s), one.sample * outputs + one.output);
            whitened[place] = one.v / root;
            predicted[one.output][one.sample] = measured[place] - one.v;
            spread[one.output] += one.s;
            noise[one.output] += r[one.output];
            let row = &mut rows[place * columns..(place + 1) * columns];
            row.iter_mut().zip(one.change).for_each(|(row, x)| *row = x / root);
        });
        for block in [&means, &variances] {
            unknowns.add_block(&mut m, &block.part(0..columns, 0..columns), run);
        }
        let Some(one) = posed.problem.runs.get(run) else { continue };
        let unit = Dense::from_fn(outputs, outputs, |i, j| f64::from(u8::from(i == j)));
        runs.push(FilterErrorInnovations {
            coloured: ColouredGradient::of(one, columns, &whitened, rows, &unit),
            variances,
            predicted,
        });
    }
    let mut prior = vec![0.0; size];
    for (j, parameter) in posed.problem.parameters.iter().enumerate() {
        if let Some((_, std)) = parameter.prior {
            prior[j] = 1.0 / (std * std);
        }
    }
    let held = posed.held();
    (0..size).for_each(|j| m[(j, j)] += prior[j] + f64::from(u8::from(held.contains(&j))));
    let cramer_rao = inverse_or_names(&m, &names)?;
    let corrected = unknowns.corrected(&cramer_rao, &prior, |run, cov| {
        let Some(FilterErrorInnovations { coloured, variances, .. }) = runs.get(run) else { return Vec::new() };
        let means = cov.map_or_else(|| coloured.gradient_cov(), |cov| coloured.corrected_gradient_cov(cov));
        vec![means, variances.part(0..columns, 0..columns)]
    });
    let stds = standard_errors(&corrected);
    let mut fitted_runs = Vec::new();
    for (number, (run, values)) in posed.problem.runs.iter_mut().zip(&stand.run_parameters).enumerate() {
        let prepared = &posed.problem.prepared;
        run.delay(&layout, &stand.theta);
        let simulated = simulate(&layout, &stand.point, &prepared.steps(&stand.point, &run.timeline, false), run, values);
        let std = unknowns.run_parameters_std(&layout, &stds, number);
        fitted_runs.push(FittedRun::new(&layout, run, values.clone(), std, &simulated));
    }
    let densities = posed.densities(&stand.theta);
    let gusts = posed.disturbances.gusts.iter().zip(densities).enumerate().map(|(place, (&state, density))| {
        let std_log = if density > 0.0 { stds[p + place] } else { 0.0 };
        Gust { state, density, std_log }
    });
    let gusts = gusts.collect();
    let disturbed = spread.iter().zip(&noise).map(|(all, noise)| 1.0 - noise / all).collect();
    let end = FitEnd {
        theta: stand.theta[..p].to_vec(),
        noise_cov: Dense::from_fn(outputs, outputs, |i, j| if i == j { r[i] } else { 0.0 }),
        cost: stand.cost,
        iterations,
        converged,
        runs: fitted_runs,
    };
    let fitted = FitResult::new(end, &m, &cramer_rao, &corrected, posed.problem.parameters);
    Ok((fitted, ProcessNoiseEstimate { gusts, predicted: runs.into_iter().map(|one| one.predicted).collect(), disturbed }))
}
