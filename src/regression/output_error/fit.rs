//! The search for the most likely parameters: Gauss-Newton with damping and step halving.
//!
//! Consumes a structure, parameters and records; minimises
//!     J(theta, R) = 1/2 sum v'R^-1 v + N/2 ln|R| + 1/2 sum ((theta_j - m_j)/sigma_j)^2             (1)
//!     R = 1/N sum v v'                     between steps, so that what falls is J(theta, R(theta))      (2)
//!     [ M_tt M_tr ; M_rt M_rr ] [dtheta ; dr] = [g_t ; g_r],     M = S'R^-1 S, g = S'R^-1 v            (3)
//! Each run's own unknowns r are eliminated first (Schur complement), so that many runs cost no more than their samples. A step
//! that does not lower (1), or whose outputs run away, is halved, then damped (Levenberg and Marquardt, on the diagonal).
//! The search begins on thinned records (`thinned`) and ends on all samples, where a whole step would be shorter than
//! `tolerance` standard errors (sqrt(g'dtheta)).
//! Source: R. E. Maine and K. W. Iliff, NASA RP-1168, 1986; R. V. Jategaonkar, Flight Vehicle System
//! Identification, 2nd ed., 2015, ch. 4.
//! Numerics: below what the cost can tell, steps are taken for as long as they shrink.

use super::dense::Dense;
use super::discrete::Layout;
use super::fitted::Fitted;
use super::model::{Delay, Parameter, Record, Structure};
use super::own::{Own, inverse_or_names};
use super::problem::{Place, Problem};
use super::reduced::Reduced;
use super::refused::Refused;
use super::thinned::thinned;

const HALVINGS: usize = 3;
/// Damping to begin with, and the least after a step that did not lower the cost.
const DAMPING_FIRST: f64 = 1e-6;
const DAMPING_RAISED: f64 = 1e-3;
const DAMPING_MOST: f64 = 1e8;
/// Delays that are tried before the search, s: 0 to 200 ms.
const DELAYS_S: [f64; 11] = [0.0, 0.02, 0.04, 0.06, 0.08, 0.1, 0.12, 0.14, 0.16, 0.18, 0.2];
/// What the cost can tell, over itself.
const COST_TOLD: f64 = 1e-11;
/// Length of the last step on thinned records, standard errors there.
const THINNED_TOLERANCE: f64 = 0.03;
/// Steps at each of them.
const DELAY_STEPS: usize = 3;

/// Which covariance the noise of the outputs has.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Noise {
    /// Each output its own; outputs may be sampled at different instants.
    #[default]
    Diagonal,
    /// All with all.
    Full,
}

/// How the search goes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// Most steps.
    pub iterations: usize,
    /// Length that ends the search: of the step that is not taken any more, standard errors.
    pub tolerance: f64,
    /// Covariance of the noise.
    pub noise: Noise,
    /// Whether delays are first tried from 0 to 200 ms; else they begin at their start.
    pub delay_grid: bool,
}

impl Default for Settings {
    fn default() -> Self {
        Settings { iterations: 60, tolerance: 1e-3, noise: Noise::Diagonal, delay_grid: true }
    }
}

/// The most likely parameters of all records together.
///
/// # Errors
/// [`Refused`], with what the data lack.
pub fn fit(
    structure: &Structure,
    parameters: &[Parameter],
    delays: &[Delay],
    records: &[Record],
    settings: &Settings,
) -> Result<Fitted, Refused> {
    let mut problem = Problem::new(structure, parameters, delays, records, settings.noise)?;
    let layout = problem.prepared.layout.clone();
    let theta: Vec<f64> = parameters.iter().map(|parameter| parameter.start).collect();
    let mut place = problem.at(theta, vec![Own::zero(&layout); records.len()])?;
    let asked = settings.delay_grid && !delays.is_empty();
    let shorter = thinned(records);
    let led = shorter.as_ref().and_then(|shorter| {
        let mut problem = Problem::new(structure, parameters, delays, shorter, settings.noise).ok()?;
        let mut begin = problem.at(place.theta.clone(), place.own.clone()).ok()?;
        if asked {
            begin = problem.try_delays(begin).ok()?;
        }
        problem.search(begin, settings.iterations, THINNED_TOLERANCE, &[]).ok()
    });
    match led.map(|led| problem.at(led.place.theta, led.place.own)) {
        Some(Ok(better)) if better.cost < place.cost => place = better,
        _ if asked => place = problem.try_delays(place)?,
        _ => {}
    }
    let ended = problem.search(place, settings.iterations, settings.tolerance, &[])?;
    super::answer::answer(&mut problem, ended)
}

/// Where a search ended.
pub(crate) struct Ended {
    pub(crate) place: Place,
    /// Of every run there.
    pub(crate) information: Vec<Dense>,
    pub(crate) iterations: usize,
    pub(crate) converged: bool,
}

impl Problem<'_> {
    /// Goes down from a place. Parameters `held` stay.
    fn search(&mut self, from: Place, most: usize, tolerance: f64, held: &[usize]) -> Result<Ended, Refused> {
        let mut place = from;
        let mut damping = DAMPING_FIRST;
        let mut length_before = f64::INFINITY;
        let mut iterations = 0;
        loop {
            let information = self.information(&place);
            let reduced = self.reduced(&place, &information, held)?;
            let next = loop {
                let Some((step, own_steps, length)) = reduced.step(damping) else {
                    if damping > DAMPING_MOST {
                        return Err(self.blind(&reduced));
                    }
                    damping = (10.0 * damping).max(DAMPING_RAISED);
                    continue;
                };
                // Below this the cost cannot tell a better place from a worse one: steps are taken while they still shrink.
                let told = 0.5 * length * length > COST_TOLD * place.cost.abs().max(1.0);
                let converged = length < tolerance || (!told && length > 0.9 * length_before);
                if converged || iterations == most || damping > DAMPING_MOST {
                    return Ok(Ended { place, information, iterations, converged });
                }
                length_before = length;
                let lower = if told { self.lower(&place, &step, &own_steps) } else { self.moved(&place, &step, &own_steps, 1.0) };
                if let Some(next) = lower {
                    break next;
                }
                damping = (10.0 * damping).max(DAMPING_RAISED);
                length_before = f64::INFINITY;
            };
            place = next;
            damping *= 0.1;
            iterations += 1;
        }
    }

    /// The model after a part of a step.
    fn moved(&mut self, place: &Place, step: &[f64], own_steps: &[Vec<f64>], part: f64) -> Option<Place> {
        let theta: Vec<f64> = place.theta.iter().zip(step).map(|(theta, step)| theta + part * step).collect();
        let scaled = |steps: &Vec<f64>| -> Vec<f64> { steps.iter().map(|step| part * step).collect() };
        let layout = &self.prepared.layout;
        let own = place.own.iter().zip(own_steps).map(|(own, steps)| own.moved(layout, &scaled(steps))).collect();
        self.at(theta, own).ok()
    }

    /// The first of the step and its halves that lowers the cost.
    fn lower(&mut self, place: &Place, step: &[f64], own_steps: &[Vec<f64>]) -> Option<Place> {
        let mut part = 1.0;
        for _ in 0..=HALVINGS {
            if let Some(next) = self.moved(place, step, own_steps, part)
                && next.cost < place.cost
            {
                return Some(next);
            }
            part *= 0.5;
        }
        None
    }

    /// (3) with every run's own unknowns eliminated.
    fn reduced(&self, place: &Place, information: &[Dense], held: &[usize]) -> Result<Reduced, Refused> {
        let own_names = |run: usize| self.prepared.structure.own_names(run);
        let mut reduced = Reduced::of(self.prepared.layout.parameters, information, own_names)?;
        reduced.with_priors(self.parameters, &place.theta);
        reduced.hold(held);
        Ok(reduced)
    }

    /// Who it is that nothing tells.
    fn blind(&self, reduced: &Reduced) -> Refused {
        let names: Vec<String> = self.parameters.iter().map(|parameter| parameter.name.clone()).collect();
        inverse_or_names(&reduced.matrix, &names).err().unwrap_or(Refused::Singular { names, smallest: 0.0 })
    }

    /// Each delay in turn at the best of the grid, the other parameters going a few steps with it.
    fn try_delays(&mut self, from: Place) -> Result<Place, Refused> {
        let layout: Layout = self.prepared.layout.clone();
        let mut held: Vec<usize> = layout.delays.iter().map(|delay| delay.parameter).collect();
        held.sort_unstable();
        held.dedup();
        let mut best = from;
        for &parameter in &held {
            let mut found: Option<Place> = None;
            for delay_s in DELAYS_S {
                let mut theta = best.theta.clone();
                theta[parameter] = delay_s;
                let Ok(tried) = self.at(theta, best.own.clone()) else { continue };
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
