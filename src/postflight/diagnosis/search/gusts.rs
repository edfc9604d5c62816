//! Gusts instead of a cause: their standard deviation and scale length by the likelihood of the innovations.
//!
//! Consumes the problem and a point; produces the point with gusts, or nothing. Gusts reach vanes and airspeed at once and the
//! inertial instruments through the aircraft only, which separates them from process noise. Their standard deviation is estimated
//! with the other noises, (1) of `maximise`; both numbers are refined by a parabola along their logarithms.

use crate::flight::derivative::{Axis, Variable};
use crate::flight::effect::Effect;
use crate::postflight::diagnosis::likelihood::maximise::{Effort, maximise};
use crate::postflight::diagnosis::likelihood::normal_equations::{Detail, Linearisation, linearise};
use crate::postflight::diagnosis::likelihood::parameter_set::ParameterSet;
use crate::postflight::diagnosis::likelihood::problem::DiagnosisProblem;

/// Process noise over its least value beyond which gusts are tested.
const EXCESS: f64 = 3.0;

/// Whether there is more noise of forces than the controls' own makes.
pub(crate) fn has_excess_noise(problem: &DiagnosisProblem, point: &ParameterSet) -> bool {
    point.force_density.iter().zip(problem.noise_floor_at(point)).any(|(force, least)| *force > EXCESS * least)
}

/// Whether the model has a force or moment by velocity, through which gusts move the aircraft; without one they would be no more
/// than noise of the vanes.
fn is_moved_by_gusts(problem: &DiagnosisProblem) -> bool {
    let by_velocity = |axis: Axis| {
        [Variable::U, Variable::V, Variable::W].iter().any(|&velocity| problem.aircraft.linear.derivative(axis, velocity) != 0.0)
    };
    problem.aircraft.is_curved() || Axis::ALL.into_iter().any(by_velocity)
}

/// Gusts as they are tried first: standard deviations, m/s, and scale lengths, m.
const SIGMAS: [f64; 3] = [0.25, 0.6, 1.4];
const LENGTHS: [f64; 2] = [120.0, 350.0];
/// Scale length of gusts at the heights where tests are flown, m, and how far it may be off, as a logarithm.
const USUAL_M: f64 = 300.0;
const USUAL_STD: f64 = 0.8;

/// Gusts of less are still air, m/s: a tenth of what is called light (MIL-F-8785C, 3.7.3). Small errors of both vanes at once
/// pass for as much.
const STILL_AIR: f64 = 0.07;

/// The point with gusts instead of noise of forces; `None` where there are gusts already, or hardly any.
pub(crate) fn with_gusts(
    problem: &DiagnosisProblem,
    point: &ParameterSet,
    rounds: Effort,
) -> Option<(ParameterSet, Linearisation)> {
    if point.gust.0 > 0.0 || !is_moved_by_gusts(problem) {
        return None;
    }
    let airspeed = problem.aircraft.trim().airspeed().max(1.0);
    let calm = core::array::from_fn(|axis| problem.noise_floor[axis] * CALM);
    let mut best: Option<(ParameterSet, f64)> = None;
    for sigma in SIGMAS {
        for length in LENGTHS {
            let there = ParameterSet { gust: (sigma, length / airspeed), force_density: calm, ..point.clone() };
            let Some(local) = linearise(problem, &there, &[], Detail::Cost) else { continue };
            if best.as_ref().is_none_or(|(_, least)| local.cost < *least) {
                best = Some((there, local.cost));
            }
        }
    }
    let (mut there, _) = best?;
    for _ in 0..2 {
        there = gust_step(problem, maximise(problem, there, rounds)?.0)?;
    }
    maximise(problem, there, Effort::some(2)).filter(|(there, _)| there.gust.0 > STILL_AIR)
}

/// Noise of forces in gusts before the innovations say better, of the least.
const CALM: f64 = 4.0;
/// What the first-order spectrum leaves open of the standard deviation of Dryden's gusts over a minute or so, a part of it:
/// their roughness is known well, and the length that ties it to the standard deviation is not.
const SHAPE: f64 = 0.3;
/// Step of the logarithms of a gust's numbers.
const GUST_STEP: f64 = 0.25;

/// The gust's numbers at the bottom of a parabola each.
fn gust_step(problem: &DiagnosisProblem, mut point: ParameterSet) -> Option<ParameterSet> {
    for number in 0..2 {
        let (by, _) = bottom(problem, &point, number)?;
        scale_gust(&mut point, number, by);
    }
    Some(point)
}

fn scale_gust(point: &mut ParameterSet, number: usize, by: f64) {
    let factor = libm::exp(by);
    if number == 0 {
        point.gust.0 *= factor;
    } else {
        point.gust.1 *= factor;
    }
}

/// Where the parabola through three costs along the logarithm of a gust's number has its bottom, and its curvature.
fn bottom(problem: &DiagnosisProblem, point: &ParameterSet, number: usize) -> Option<(f64, f64)> {
    let cost = |by: f64| {
        let mut there = point.clone();
        scale_gust(&mut there, number, by);
        Some(linearise(problem, &there, &[], Detail::Cost)?.cost + usual(problem, &there))
    };
    let (here, up, down) = (cost(0.0)?, cost(GUST_STEP)?, cost(-GUST_STEP)?);
    let curvature = (up + down - 2.0 * here) / (GUST_STEP * GUST_STEP);
    let by = if curvature > 1.0 {
        0.5 * (down - up) / GUST_STEP / curvature
    } else if up < down {
        GUST_STEP
    } else {
        -GUST_STEP
    };
    Some((by.clamp(-0.7, 0.7), curvature))
}

/// The gusts of a point as an effect.
pub(crate) fn turbulence(problem: &DiagnosisProblem, point: &ParameterSet) -> Effect {
    Effect::Turbulence { sigma: point.gust.0, length: point.gust.1 * problem.aircraft.trim().airspeed().max(1.0) }
}

/// Standard error of their standard deviation: the cost is minus twice the logarithm of the likelihood, and the scale length,
/// which a short flight hardly tells, is free beside it.
pub(crate) fn gust_std(problem: &DiagnosisProblem, point: &ParameterSet) -> f64 {
    let cost = |sigma: f64, length: f64| {
        let mut there = point.clone();
        scale_gust(&mut there, 0, sigma * GUST_STEP);
        scale_gust(&mut there, 1, length * GUST_STEP);
        Some(linearise(problem, &there, &[], Detail::Cost)?.cost + usual(problem, &there))
    };
    let curvatures = || {
        let here = cost(0.0, 0.0)?;
        let own = |a: f64, b: f64| (a + b - 2.0 * here) / (GUST_STEP * GUST_STEP);
        let sigma = own(cost(1.0, 0.0)?, cost(-1.0, 0.0)?);
        let length = own(cost(0.0, 1.0)?, cost(0.0, -1.0)?);
        let both = cost(1.0, 1.0)? + cost(-1.0, -1.0)? - cost(1.0, -1.0)? - cost(-1.0, 1.0)?;
        Some((sigma, length, both / (4.0 * GUST_STEP * GUST_STEP)))
    };
    let Some((sigma, length, both)) = curvatures() else { return f64::NAN };
    let free = sigma - both * both / length;
    // Where the length is not told at all its own part is in SHAPE.
    let formal = match (length > 0.0 && free > 0.0, sigma > 0.0) {
        (true, _) => libm::sqrt(2.0 / free),
        (false, true) => libm::sqrt(2.0 / sigma),
        (false, false) => f64::NAN,
    };
    point.gust.0 * libm::hypot(formal, SHAPE)
}

/// What is known of the scale length beforehand, as a cost: about [`USUAL_M`], a factor of e^[`USUAL_STD`] either way.
fn usual(problem: &DiagnosisProblem, point: &ParameterSet) -> f64 {
    let length = point.gust.1 * problem.aircraft.trim().airspeed().max(1.0);
    let off = libm::log(length / USUAL_M) / USUAL_STD;
    off * off
}
