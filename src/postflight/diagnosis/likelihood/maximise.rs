//! The way down: steps of all parameters and of the noise densities, until nothing changes any more.
//!
//! Consumes the problem and a point; produces the point where it settles, with its neighbourhood. Parameters go by (1) of
//! `problem`; the noise of forces and moments, and that of gusts where there are any, by its own scores, (4) of `filter`:
//!     ln q <- ln q - (d cost)/(d^2 cost)                                                              (1)
//! Where noises are far from where they settle, passes without other sensitivities, which are quick, bring them nearer first.

use super::normal_equations::{Detail, Linearisation, linearise};
use super::parameter::RUN_OFFSETS;
use super::parameter_set::ParameterSet;
use super::problem::DiagnosisProblem;
use super::state::NOISES;
use crate::flight::derivative::AXES;
use nalgebra::DVector;

/// Most that the logarithm of a density changes at once.
const DENSITY_STEP: f64 = 3.0;
/// Change of the cost by which noises are far from where they settle, and rounds of quick passes that then bring them nearer.
const FAR: f64 = 30.0;
const QUICK_ROUNDS: usize = 3;
/// Parts of a step that are tried.
const STEPS: [f64; 4] = [1.0, 0.3, 0.1, 0.03];
/// Least second derivative by a noise's logarithm.
const LEAST_CURVATURE: f64 = 0.3;

/// How far a point is followed down.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Effort {
    pub(crate) most: usize,
    /// Change of the cost below which nothing changes any more.
    pub(crate) gain: f64,
}

impl Effort {
    pub(crate) const SETTLED: Effort = Effort { most: 14, gain: 0.3 };

    pub(crate) const fn some(most: usize) -> Self {
        Effort { most, gain: 1.0 }
    }
}

/// Goes down from a point until nothing changes any more.
pub(crate) fn maximise(problem: &DiagnosisProblem, point: ParameterSet, rounds: Effort) -> Option<(ParameterSet, Linearisation)> {
    let there = at(problem, point, true)?;
    resume(problem, there, rounds)
}

/// The same from a point whose neighbourhood is known.
pub(crate) fn resume(
    problem: &DiagnosisProblem,
    (mut point, mut local): (ParameterSet, Linearisation),
    rounds: Effort,
) -> Option<(ParameterSet, Linearisation)> {
    let mut before = local.noise_score;
    for _ in 0..rounds.most {
        let (force, gust, moved) = noise_step(problem, &point, &local.noise_score, &before);
        before = local.noise_score;
        let step = local.factor.solve(&local.gradient);
        let gain = step.dot(&local.gradient);
        // A step may lead out of what the kinematics can carry: then a part of it, and in the end none.
        let parts = STEPS.into_iter().find_map(|part| {
            let mut next = stepped(problem, &point, &step, part);
            (next.force_density, next.gust.0) = (force, gust);
            at(problem, next, moved > FAR)
        });
        let Some(next) = parts else { break };
        (point, local) = next;
        if gain < rounds.gain && moved < 2.0 * rounds.gain {
            break;
        }
    }
    Some((point, local))
}

/// The neighbourhood of a point, its noises brought nearer to where they settle; with its own where the filter cannot follow
/// with those.
fn at(problem: &DiagnosisProblem, point: ParameterSet, far: bool) -> Option<(ParameterSet, Linearisation)> {
    if far && problem.models_all_axes() {
        let found = with_noise_near(problem, point.clone());
        if let Some(local) = linearise(problem, &found, &[], Detail::Slopes) {
            return Some((found, local));
        }
    }
    let local = linearise(problem, &point, &[], Detail::Slopes)?;
    Some((point, local))
}

/// The noises alone brought nearer to where they settle: a pass without sensitivities is a quick one.
fn with_noise_near(problem: &DiagnosisProblem, mut point: ParameterSet) -> ParameterSet {
    let mut before = None;
    for _ in 0..QUICK_ROUNDS {
        let Some(local) = linearise(problem, &point, &[], Detail::Noises) else { break };
        let (force, gust, moved) = noise_step(problem, &point, &local.noise_score, &before.unwrap_or(local.noise_score));
        before = Some(local.noise_score);
        (point.force_density, point.gust.0) = (force, gust);
        if moved < FAR {
            break;
        }
    }
    point
}

/// A part of a step of the parameters.
fn stepped(problem: &DiagnosisProblem, point: &ParameterSet, step: &DVector<f64>, part: f64) -> ParameterSet {
    let mut next = point.clone();
    let run_s = problem.runs.iter().map(|run| run.mesh.length_s()).fold(f64::INFINITY, f64::min);
    let at = |place: usize| part * step.get(place).copied().unwrap_or(0.0);
    let places = point.places();
    for (place, &key) in places.iter().enumerate() {
        next.change(key, at(place), run_s);
    }
    for (k, &(axis, variable, _)) in problem.derivative_tolerances.iter().enumerate() {
        next.derivative_errors[axis.index()][variable.index()] += at(places.len() + k);
    }
    let shared = places.len() + problem.derivative_tolerances.len();
    for (number, own) in next.run_offsets.iter_mut().enumerate() {
        for (k, value) in own.iter_mut().enumerate() {
            *value += at(shared + number * RUN_OFFSETS + k);
        }
    }
    next
}

/// The noises after a step (1), and what the change is worth at most, as that of the parameters. Where the slope has changed
/// its sign the last step went too far, and so would this one: half of it is taken.
fn noise_step(
    problem: &DiagnosisProblem,
    point: &ParameterSet,
    noise_score: &[(f64, f64); NOISES],
    before: &[(f64, f64); NOISES],
) -> ([f64; AXES], f64, f64) {
    let by = |of: usize| {
        let ((slope, curvature), (last, _)) = (noise_score[of], before[of]);
        let part = if slope * last < 0.0 && problem.models_all_axes() { 0.5 } else { 1.0 };
        libm::exp((-part * slope / curvature.max(LEAST_CURVATURE)).clamp(-DENSITY_STEP, DENSITY_STEP))
    };
    let force: [f64; AXES] = core::array::from_fn(|axis| (point.force_density[axis] * by(axis)).max(problem.noise_floor[axis]));
    let changes = force.iter().zip(&point.force_density).zip(noise_score);
    let moved = changes.map(|((a, b), (slope, _))| libm::fabs(slope * libm::log(a / b))).fold(0.0, f64::max);
    // The gusts' density is proportional to the square of their standard deviation.
    (force, point.gust.0 * libm::sqrt(by(AXES)), moved)
}
