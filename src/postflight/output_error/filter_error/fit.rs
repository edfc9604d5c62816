//! Maximum likelihood estimation by filter error: parameters, gust densities and noise variances by Fisher scoring.
//!
//! Consumes the result of output error as a start; minimises (1) of `likelihood` with steps of its (2), the run parameters
//! eliminated first, with damping and step halving. The gusts begin at the best of `STRENGTHS`, relative to the state's own rms
//! in one second, because output error has counted the gusts as noise of the outputs. A gust whose strength falls below
//! `ZERO_GUST` gets density zero and is held there.
//! Source: R. V. Jategaonkar, Flight Vehicle System Identification, 2nd ed., 2015, ch. 5, where the densities of the process
//! noise are estimated with the parameters; R is estimated in the same way here, because with outputs at different sampling times
//! no steady gain determines it.
//! Numerics: logarithms of densities move by no more than `MOST_LOG` in one step.

use super::likelihood::{FilterErrorIterate, FilterErrorLikelihood, FilterErrorSearch};
use super::process_noise::{Disturbances, ProcessNoiseEstimate};
use super::result::result;
use crate::postflight::output_error::error::OutputErrorFitError;
use crate::postflight::output_error::fit_result::FitResult;
use crate::postflight::output_error::identifiability::inverse_or_names;
use crate::postflight::output_error::model::{FitParameter, InputDelay, InputOutputRecord, ModelStructure};
use crate::postflight::output_error::problem::OutputErrorProblem;
use crate::postflight::output_error::run_parameters::RunParameters;
use crate::postflight::output_error::schur::SchurComplement;
use crate::postflight::output_error::settings::{FitSettings, NoiseCovariance};
use crate::postflight::output_error::simulated_outputs::simulate;
use crate::postflight::work_progress::is_stopped;

/// Strengths that are tried at first, of a state's rms in a second.
const STRENGTHS: [f64; 6] = [1e-3, 3e-3, 1e-2, 3e-2, 0.1, 0.3];
/// Parts of the residuals' variance that are tried as noise of the outputs.
const PARTS: [f64; 2] = [1.0, 0.1];
/// Strength of a gust that is none.
const ZERO_GUST: f64 = 1e-4;
const MOST_LOG: f64 = 1.5;
const HALVINGS: usize = 4;
const DAMPING_FIRST: f64 = 1e-6;
const DAMPING_RAISED: f64 = 1e-3;
const DAMPING_MOST: f64 = 1e8;
const COST_RESOLUTION: f64 = 1e-11;

/// The most likely parameters of all records together, from where output error ended.
///
/// # Errors
/// [`OutputErrorFitError`], with what the data lack.
pub fn fit(
    structure: &ModelStructure,
    parameters: &[FitParameter],
    delays: &[InputDelay],
    records: &[InputOutputRecord],
    disturbances: &Disturbances,
    settings: &FitSettings,
    start: &FitResult,
) -> Result<(FitResult, ProcessNoiseEstimate), OutputErrorFitError> {
    let below = |what: &str, expected: usize, found: usize| {
        let what = format!("{what}, by place below");
        if found < expected { Ok(()) } else { Err(OutputErrorFitError::Shape { what, expected, found }) }
    };
    for &state in &disturbances.gusts {
        below("a state with gusts", structure.states.len(), state)?;
    }
    if start.theta.len() != parameters.len() || start.runs.len() != records.len() {
        let what = "parameters of the start".to_owned();
        return Err(OutputErrorFitError::Shape { what, expected: parameters.len(), found: start.theta.len() });
    }
    let free = |name: String, start: f64| FitParameter { name, start, prior: None };
    let mut all = parameters.to_vec();
    all.extend(disturbances.gusts.iter().map(|&state| free(format!("gusts of {}", structure.states[state]), 0.0)));
    all.extend(structure.outputs.iter().map(|output| free(format!("noise of {output}"), 0.0)));
    let problem = OutputErrorProblem::new(structure, &all, delays, records, NoiseCovariance::Diagonal)?;
    let mut posed = FilterErrorLikelihood::new(problem, disturbances, parameters.len());
    let run_parameters: Vec<RunParameters> = start.runs.iter().map(|run| run.run_parameters.clone()).collect();
    let squares = posed.squares(&start.theta, &run_parameters);
    let begin = posed.begin(&start.theta, run_parameters, &start.noise_cov.diagonal(), &squares)?;
    let ended = posed.search(begin, settings, &squares)?;
    result(&mut posed, ended)
}

impl FilterErrorLikelihood<'_> {
    /// Mean square of every state that gusts accelerate, without them.
    fn squares(&mut self, theta: &[f64], run_parameters: &[RunParameters]) -> Vec<f64> {
        let prepared = &self.problem.prepared;
        let (n, point) = (prepared.layout.states, prepared.at(theta));
        let (mut sums, mut count) = (vec![0.0; n], 0.0);
        for (run, run_parameters) in self.problem.runs.iter_mut().zip(run_parameters) {
            run.delay(&prepared.layout, theta);
            let simulated =
                simulate(&prepared.layout, &point, &prepared.steps(&point, &run.timeline, false), run, run_parameters);
            for x in simulated.states.chunks_exact(n.max(1)) {
                sums.iter_mut().zip(x).for_each(|(sum, x)| *sum += x * x);
                count += 1.0;
            }
        }
        self.disturbances.gusts.iter().map(|&state| (sums[state] / count).max(1e-200)).collect()
    }

    /// The best of the strengths that are tried.
    fn begin(
        &mut self,
        theta: &[f64],
        run_parameters: Vec<RunParameters>,
        noise: &[f64],
        squares: &[f64],
    ) -> Result<FilterErrorIterate, OutputErrorFitError> {
        let mut best: Option<FilterErrorIterate> = None;
        let mut refused = None;
        let strengths = if squares.is_empty() { &STRENGTHS[..1] } else { &STRENGTHS[..] };
        for (strength, part) in strengths.iter().flat_map(|&strength| PARTS.map(|part| (strength, part))) {
            let mut tried = theta.to_vec();
            tried.extend(squares.iter().map(|square| libm::log(strength * strength * square)));
            tried.extend(noise.iter().zip(&self.problem.floors).map(|(r, floor)| libm::log((part * r).max(*floor))));
            match self.at(tried, run_parameters.clone()) {
                Ok(stand) if best.as_ref().is_none_or(|best| stand.cost < best.cost) => best = Some(stand),
                Ok(_) => {}
                Err(error) => refused = Some(error),
            }
        }
        best.ok_or_else(|| refused.unwrap_or(OutputErrorFitError::Diverges { run: 0 }))
    }

    /// Goes down from a place.
    fn search(
        &mut self,
        from: FilterErrorIterate,
        settings: &FitSettings,
        squares: &[f64],
    ) -> Result<FilterErrorSearch, OutputErrorFitError> {
        let mut stand = from;
        let (mut damping, mut length_before, mut iterations) = (DAMPING_FIRST, f64::INFINITY, 0);
        loop {
            self.drop_zero_gusts(&mut stand, squares)?;
            let information = self.information(&stand);
            let structure = self.problem.prepared.structure;
            let mut reduced = SchurComplement::of(self.problem.prepared.layout.parameters, &information, |run| {
                structure.run_parameter_names(run)
            })?;
            reduced.with_priors(self.problem.parameters, &stand.theta);
            reduced.hold(&self.held());
            let next = loop {
                let Some((step, run_steps, length)) = reduced.step(damping) else {
                    if damping > DAMPING_MOST {
                        let names: Vec<String> = self.problem.parameters.iter().map(|one| one.name.clone()).collect();
                        let blind = inverse_or_names(&reduced.matrix, &names).err();
                        return Err(blind.unwrap_or(OutputErrorFitError::Singular { names, smallest: 0.0 }));
                    }
                    damping = (10.0 * damping).max(DAMPING_RAISED);
                    continue;
                };
                let told = 0.5 * length * length > COST_RESOLUTION * stand.cost.abs().max(1.0);
                let converged = length < settings.tolerance || (!told && length > 0.9 * length_before);
                if converged || iterations == settings.iterations || damping > DAMPING_MOST || is_stopped(settings.watch) {
                    return Ok(FilterErrorSearch { stand, iterations, converged });
                }
                length_before = length;
                let mut part = 1.0;
                let mut lower = None;
                for _ in 0..=HALVINGS {
                    let moved = self.moved(&stand, &step, &run_steps, part);
                    if let Some(next) = moved.filter(|next| !told || next.cost < stand.cost) {
                        lower = Some(next);
                        break;
                    }
                    part *= 0.5;
                }
                if let Some(next) = lower {
                    break next;
                }
                damping = (10.0 * damping).max(DAMPING_RAISED);
                length_before = f64::INFINITY;
            };
            stand = next;
            damping *= 0.1;
            iterations += 1;
        }
    }

    /// Takes gusts out that have become none.
    fn drop_zero_gusts(&mut self, stand: &mut FilterErrorIterate, squares: &[f64]) -> Result<(), OutputErrorFitError> {
        let densities = self.densities(&stand.theta);
        let mut found = false;
        for ((still, q), square) in self.still.iter_mut().zip(&densities).zip(squares) {
            if !*still && *q < ZERO_GUST * ZERO_GUST * square {
                (*still, found) = (true, true);
            }
        }
        if found {
            *stand = self.at(stand.theta.clone(), stand.run_parameters.clone())?;
        }
        Ok(())
    }

    /// After a part of a step.
    fn moved(
        &mut self,
        stand: &FilterErrorIterate,
        step: &[f64],
        run_steps: &[Vec<f64>],
        part: f64,
    ) -> Option<FilterErrorIterate> {
        let outputs_from = self.parameters + self.still.len();
        let theta = stand.theta.iter().zip(step).enumerate().map(|(j, (theta, step))| {
            let by = if j < self.parameters { part * step } else { part * step.clamp(-MOST_LOG, MOST_LOG) };
            let floor =
                j.checked_sub(outputs_from).and_then(|o| self.problem.floors.get(o)).map_or(f64::NEG_INFINITY, |x| libm::log(*x));
            (theta + by).max(floor)
        });
        let theta = theta.collect();
        let scaled = |steps: &Vec<f64>| -> Vec<f64> { steps.iter().map(|step| part * step).collect() };
        let layout = &self.problem.prepared.layout;
        let run_parameters = stand
            .run_parameters
            .iter()
            .zip(run_steps)
            .map(|(run_parameters, steps)| run_parameters.moved(layout, &scaled(steps)))
            .collect();
        self.at(theta, run_parameters).ok()
    }
}
