//! Maximum likelihood estimation by output error: Gauss-Newton with damping and step halving.
//!
//! Consumes a structure, p parameters and the records of N runs; minimises the negative logarithm of the likelihood of the
//! outputs, whose noise is white with covariance R [outputs square], with the priors of parameters that have one,
//!     J(theta, R) = 1/2 sum v'R^-1 v + n/2 ln|R| + 1/2 sum ((theta_j - m_j)/sigma_j)^2              (1)
//!     R = 1/n sum v v'                                                                              (2)
//! over all n samples, v = z - y the residuals. R is renewed by (2) between steps, so what has to fall is J(theta, R(theta)).
//!     [ M_tt M_tr ; M_rt M_rr ] [dtheta ; dr] = [g_t ; g_r],   M = S'R^-1 S,   g = S'R^-1 v         (3)
//! S = dy/d(theta, r) are the output sensitivities. The run parameters r (initial state, biases) are eliminated first (`schur`),
//! so the work grows with the samples only. A step that does not lower (1), or at which the outputs diverge, is halved, then
//! damped (Levenberg and Marquardt, on the diagonal). The search begins on decimated records (`decimated`) and ends on all
//! samples, where a full step would be shorter than `tolerance` standard errors, sqrt(g'dtheta).
//! Source: R. E. Maine and K. W. Iliff, NASA RP-1168, 1986; R. V. Jategaonkar, Flight Vehicle System Identification, 2nd ed.,
//! 2015, ch. 4.
//! Numerics: where the expected decrease is below the resolution of J, steps are taken for as long as they shrink.

use super::decimated::decimated;
use super::discrete::UnknownLayout;
use super::error::OutputErrorFitError;
use super::fit_result::FitResult;
use super::identifiability::inverse_or_names;
use super::model::{FitParameter, InputDelay, InputOutputRecord, ModelStructure};
use super::problem::{OutputErrorIterate, OutputErrorProblem, OutputErrorSearch};
use super::run_parameters::RunParameters;
use super::schur::SchurComplement;
use super::settings::FitSettings;
use crate::num::dense::Dense;
use crate::postflight::work_progress::{advance, is_stopped, plan};

const HALVINGS: usize = 3;
/// Damping to begin with, and the least after a step that did not lower the cost.
const DAMPING_FIRST: f64 = 1e-6;
const DAMPING_RAISED: f64 = 1e-3;
const DAMPING_MOST: f64 = 1e8;
/// Delays that are tried before the search, s: 0 to 200 ms.
const DELAYS_S: [f64; 11] = [0.0, 0.02, 0.04, 0.06, 0.08, 0.1, 0.12, 0.14, 0.16, 0.18, 0.2];
/// What the cost can tell, over itself.
const COST_RESOLUTION: f64 = 1e-11;
/// Length of the last step on thinned records, standard errors there.
const THINNED_TOLERANCE: f64 = 0.03;
const DELAY_STEPS: usize = 3;

/// The most likely parameters of all records together.
///
/// # Errors
/// [`OutputErrorFitError`], with what the data lack.
pub fn fit(
    structure: &ModelStructure,
    parameters: &[FitParameter],
    delays: &[InputDelay],
    records: &[InputOutputRecord],
    settings: &FitSettings,
) -> Result<FitResult, OutputErrorFitError> {
    let mut problem = OutputErrorProblem::new(structure, parameters, delays, records, settings.noise)?;
    problem.watch = settings.watch;
    let layout = problem.prepared.layout.clone();
    let theta: Vec<f64> = parameters.iter().map(|parameter| parameter.start).collect();
    let mut place = problem.at(theta, vec![RunParameters::zero(&layout); records.len()])?;
    let asked = settings.delay_grid && !delays.is_empty();
    let shorter = decimated(records);
    let led = shorter.as_ref().and_then(|shorter| {
        let mut problem = OutputErrorProblem::new(structure, parameters, delays, shorter, settings.noise).ok()?;
        let mut begin = problem.at(place.theta.clone(), place.run_parameters.clone()).ok()?;
        if asked {
            begin = problem.try_delays(begin).ok()?;
        }
        problem.watch = settings.watch;
        problem.search(begin, settings.iterations, THINNED_TOLERANCE, &[]).ok()
    });
    match led.map(|led| problem.at(led.place.theta, led.place.run_parameters)) {
        Some(Ok(better)) if better.cost < place.cost => place = better,
        _ if asked => place = problem.try_delays(place)?,
        _ => {}
    }
    let ended = problem.search(place, settings.iterations, settings.tolerance, &[])?;
    super::result::result(&mut problem, ended)
}

impl OutputErrorProblem<'_> {
    /// Goes down from a place. Parameters `held` stay.
    fn search(
        &mut self,
        from: OutputErrorIterate,
        most: usize,
        tolerance: f64,
        held: &[usize],
    ) -> Result<OutputErrorSearch, OutputErrorFitError> {
        let mut place = from;
        let mut damping = DAMPING_FIRST;
        let mut length_before = f64::INFINITY;
        let mut iterations = 0;
        plan(self.watch, most);
        loop {
            let information = self.information(&place);
            let reduced = self.reduced(&place, &information, held)?;
            let next = loop {
                let Some((step, run_steps, length)) = reduced.step(damping) else {
                    if damping > DAMPING_MOST {
                        return Err(self.unidentifiable(&reduced));
                    }
                    damping = (10.0 * damping).max(DAMPING_RAISED);
                    continue;
                };
                // Below this the cost cannot tell a better place from a worse one: steps are taken while they still shrink.
                let told = 0.5 * length * length > COST_RESOLUTION * place.cost.abs().max(1.0);
                let converged = length < tolerance || (!told && length > 0.9 * length_before);
                if converged || iterations == most || damping > DAMPING_MOST || is_stopped(self.watch) {
                    advance(self.watch, most - iterations);
                    return Ok(OutputErrorSearch { place, information, iterations, converged });
                }
                length_before = length;
                let lower =
                    if told { self.line_search(&place, &step, &run_steps) } else { self.moved(&place, &step, &run_steps, 1.0) };
                if let Some(next) = lower {
                    break next;
                }
                damping = (10.0 * damping).max(DAMPING_RAISED);
                length_before = f64::INFINITY;
            };
            place = next;
            damping *= 0.1;
            iterations += 1;
            advance(self.watch, 1);
        }
    }

    /// The model after a part of a step.
    fn moved(
        &mut self,
        place: &OutputErrorIterate,
        step: &[f64],
        run_steps: &[Vec<f64>],
        part: f64,
    ) -> Option<OutputErrorIterate> {
        let theta: Vec<f64> = place.theta.iter().zip(step).map(|(theta, step)| theta + part * step).collect();
        let scaled = |steps: &Vec<f64>| -> Vec<f64> { steps.iter().map(|step| part * step).collect() };
        let layout = &self.prepared.layout;
        let run_parameters = place
            .run_parameters
            .iter()
            .zip(run_steps)
            .map(|(run_parameters, steps)| run_parameters.moved(layout, &scaled(steps)))
            .collect();
        self.at(theta, run_parameters).ok()
    }

    /// The first of the step and its halves that lowers the cost.
    fn line_search(&mut self, place: &OutputErrorIterate, step: &[f64], run_steps: &[Vec<f64>]) -> Option<OutputErrorIterate> {
        let mut part = 1.0;
        for _ in 0..=HALVINGS {
            if let Some(next) = self.moved(place, step, run_steps, part)
                && next.cost < place.cost
            {
                return Some(next);
            }
            part *= 0.5;
        }
        None
    }

    /// (3) with every run's own unknowns eliminated.
    fn reduced(
        &self,
        place: &OutputErrorIterate,
        information: &[Dense],
        held: &[usize],
    ) -> Result<SchurComplement, OutputErrorFitError> {
        let run_parameter_names = |run: usize| self.prepared.structure.run_parameter_names(run);
        let mut reduced = SchurComplement::of(self.prepared.layout.parameters, information, run_parameter_names)?;
        reduced.with_priors(self.parameters, &place.theta);
        reduced.hold(held);
        Ok(reduced)
    }

    /// The unidentifiable parameters of a singular system.
    fn unidentifiable(&self, reduced: &SchurComplement) -> OutputErrorFitError {
        let names: Vec<String> = self.parameters.iter().map(|parameter| parameter.name.clone()).collect();
        inverse_or_names(&reduced.matrix, &names).err().unwrap_or(OutputErrorFitError::Singular { names, smallest: 0.0 })
    }

    /// Each delay in turn at the best of the grid, the other parameters going a few steps with it.
    fn try_delays(&mut self, from: OutputErrorIterate) -> Result<OutputErrorIterate, OutputErrorFitError> {
        let layout: UnknownLayout = self.prepared.layout.clone();
        let mut held: Vec<usize> = layout.delays.iter().map(|delay| delay.parameter).collect();
        held.sort_unstable();
        held.dedup();
        let mut best = from;
        for &parameter in &held {
            let mut found: Option<OutputErrorIterate> = None;
            for delay_s in DELAYS_S {
                let mut theta = best.theta.clone();
                theta[parameter] = delay_s;
                let Ok(tried) = self.at(theta, best.run_parameters.clone()) else { continue };
                let tried = self.search(tried, DELAY_STEPS, THINNED_TOLERANCE, &held)?.place;
                if found.as_ref().is_none_or(|found| tried.cost < found.cost) {
                    found = Some(tried);
                }
            }
            best = found.unwrap_or(best);
        }
        Ok(best)
    }
}
