//! The result of a fit by output error: both covariances over all unknowns, and the figures that follow from them.
//!
//! Consumes the end of the search with the information M of every run there; produces [`FitResult`]. Priors add M_0 to M.

use super::coloured_errors::{ColouredGradient, weighed_sensitivities};
use super::covariance::{AllUnknowns, standard_errors};
use super::error::OutputErrorFitError;
use super::fit_result::{FitEnd, FitResult, FittedRun};
use super::identifiability::inverse_or_names;
use super::information::SensitivityModel;
use super::input_noise;
use super::problem::{OutputErrorProblem, OutputErrorSearch};
use crate::num::dense::Dense;

/// The result at the end of the search.
pub(crate) fn result(problem: &mut OutputErrorProblem<'_>, ended: OutputErrorSearch) -> Result<FitResult, OutputErrorFitError> {
    let OutputErrorSearch { place, information, iterations, converged } = ended;
    problem.delay(&place);
    let layout = problem.prepared.layout.clone();
    let columns = layout.columns();
    let unknowns = AllUnknowns::new(&layout, problem.runs.len());
    let mut names: Vec<String> = problem.parameters.iter().map(|parameter| parameter.name.clone()).collect();
    let mut m = Dense::zeros(unknowns.size(), unknowns.size());
    let mut prior = vec![0.0; layout.parameters];
    for (run, block) in information.iter().enumerate() {
        names.extend(problem.prepared.structure.run_parameter_names(run));
        unknowns.add_block(&mut m, &block.part(0..columns, 0..columns), run);
    }
    for (j, parameter) in problem.parameters.iter().enumerate() {
        if let Some((_, std)) = parameter.prior {
            prior[j] = 1.0 / (std * std);
            m[(j, j)] += prior[j];
        }
    }
    let cramer_rao = inverse_or_names(&m, &names)?;
    let inverse_cov = place.whitening.inverse_cov();
    let mut coloured = Vec::with_capacity(problem.runs.len());
    let mut by_inputs = Vec::with_capacity(problem.runs.len());
    for ((run, simulated), run_parameters) in problem.runs.iter().zip(&place.simulated).zip(&place.run_parameters) {
        let steps = problem.prepared.steps(&place.point, &run.timeline, true);
        let linear = SensitivityModel {
            prepared: &problem.prepared,
            point: &place.point,
            steps: &steps,
            output_lines: &problem.output_lines,
        };
        let weighed = weighed_sensitivities(&linear, run, simulated, run_parameters, &inverse_cov);
        by_inputs.push(input_noise::gradient_cov(&layout, &place.point, &steps, run, &weighed));
        coloured.push(ColouredGradient::of(run, columns, &simulated.residuals, weighed, &place.noise_cov));
    }
    let corrected = unknowns.corrected(&cramer_rao, &prior, |run, cov| {
        let one = coloured.get(run);
        let by_residuals = one.map(|one| cov.map_or_else(|| one.gradient_cov(), |cov| one.corrected_gradient_cov(cov)));
        by_residuals.into_iter().chain(by_inputs.get(run).cloned()).collect()
    });
    let stds = standard_errors(&corrected);
    let runs = problem.runs.iter().zip(&place.simulated).zip(&place.run_parameters).enumerate();
    let runs = runs.map(|(number, ((run, simulated), values))| {
        FittedRun::new(&layout, run, values.clone(), unknowns.run_parameters_std(&layout, &stds, number), simulated)
    });
    let runs = runs.collect();
    let end = FitEnd { theta: place.theta, noise_cov: place.noise_cov, cost: place.cost, iterations, converged, runs };
    Ok(FitResult::new(end, &m, &cramer_rao, &corrected, problem.parameters))
}
