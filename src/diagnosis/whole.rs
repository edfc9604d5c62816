//! A model that is wrong in many derivatives at once: all of them fitted together, those kept that are really off.
//!
//! Consumes the problem; with every derivative of the axes that the model speaks of as free as the search's own priors make one
//! alone, and all at once, those that come out off by more than `SURE` standard errors become causes, and the others go back to
//! the model's tolerance, until all that stay are off by so many. Then the search goes on from there. What is left of a model
//! that is wrong in another way stays left: the caller judges that as after the search.

use super::library::library;
use super::linearise::With;
use super::point::{Hypothesis, Point};
use super::problem::Problem;
use super::screen::prior_of;
use super::search::{Rival, SETTLED, Searched, Settings, go_on, usual_forces};
use crate::flight::derivative::{Axis, Variable};
use crate::flight::effect::Effect;

/// Standard errors that a derivative is off by.
const SURE: f64 = 4.0;

/// Part of what is there that derivatives alone may leave, so that it is worth while to go on.
const PROMISING: f64 = 0.3;

/// The causes, where many derivatives are wrong; `None` where no fit of all of them settles.
pub fn whole(problem: &Problem, from: &Searched, settings: &Settings) -> Option<Searched> {
    let mut point = problem.zero();
    point.force = from.point.force;
    point.hypotheses = off(problem, &point)?;
    let (rivals, local) = loop {
        let (there, local) = problem.settle(point, SETTLED)?;
        point = there;
        // A derivative with size x, error s and s_0 beforehand is worth x^2/s^2 - ln(s_0^2/s^2) (Savage and Dickey).
        let rivals = point.hypotheses.iter().enumerate().map(|(place, hypothesis)| {
            let std = local.std(point.place_of(place));
            let z = hypothesis.effect.main_number().unwrap_or(0.0) / std;
            let odds = z * z - 2.0 * libm::log(hypothesis.prior_std / std);
            Rival { effect: hypothesis.effect, std, odds, fitted: true }
        });
        let rivals: Vec<Rival> = rivals.collect();
        let count = rivals.len();
        let sure = |rival: &Rival| libm::fabs(rival.effect.main_number().unwrap_or(0.0)) > SURE * rival.std;
        let kept: Vec<Hypothesis> =
            point.hypotheses.iter().zip(&rivals).filter(|(_, rival)| sure(rival)).map(|(kept, _)| *kept).collect();
        if kept.len() == count {
            break (rivals, local);
        }
        point.hypotheses = kept;
    };
    let left: f64 = problem.unexplained(&point)?.iter().sum();
    if !(left < PROMISING * from.before.iter().sum::<f64>()) {
        return None;
    }
    let rivals = rivals.into_iter().map(|rival| vec![rival]).collect();
    go_on(problem, (point, local), rivals, from.before, settings)
}

/// The derivatives that are off, each with its prior, where all are free at once.
fn off(problem: &Problem, start: &Point) -> Option<Vec<Hypothesis>> {
    let entries: Vec<_> =
        library(problem, &problem.fixed).into_iter().filter(|entry| matches!(entry.effect, Effect::Derivative { .. })).collect();
    let candidates: Vec<_> = entries.iter().map(|entry| &entry.candidate).collect();
    let wide = problem.linearise(start, &candidates, With::Slopes)?;
    let usual = usual_forces(problem);
    let mut free = problem.clone();
    let tolerance = |axis: Axis, variable: Variable| {
        problem.small.iter().find(|(a, v, _)| (*a, *v) == (axis, variable)).map_or(0.0, |(_, _, std)| *std)
    };
    free.small = entries
        .iter()
        .enumerate()
        .filter_map(|(place, entry)| match entry.effect {
            Effect::Derivative { axis, variable, .. } => Some((axis, variable, prior_of(entry, &wide, place, &usual)?)),
            _ => None,
        })
        .collect();
    let (point, local) = free.settle(start.clone(), SETTLED)?;
    let off = free.small.iter().enumerate().filter_map(|(place, &(axis, variable, prior_std))| {
        let delta = *point.small.get(axis.index())?.get(variable.index())?;
        let allowed = SURE * libm::hypot(local.std(place), tolerance(axis, variable));
        (libm::fabs(delta) > allowed).then(|| Hypothesis::of(Effect::Derivative { axis, variable, delta }, prior_std))
    });
    Some(off.collect())
}
