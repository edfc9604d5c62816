//! A model that is wrong in many derivatives at once: all of them fitted together, those kept that are really off.
//!
//! Consumes the problem; with every derivative of the axes that the model speaks of as free as the search's own priors make one
//! alone (and what a simulation has of second order in sideways motion), and all at once, those that come out off by more than
//! four standard errors become causes, and the others go back to the model's tolerance, until all that stay are off by so
//! many; then causes are exchanged for what stands better in their place, and the search goes on from there. Standard errors are
//! those with everything in doubt that may be. What is left of a model that is wrong in another way stays left: the caller
//! judges that as after the search.

use super::exchange::{InPlace, in_place};
use super::library::{Entry, curvature, library};
use super::linearise::{Local, With};
use super::point::{Hypothesis, Point};
use super::problem::Problem;
use super::screen::{Score, axis_of, prior_of};
use super::search::{Rival, Searched, Settings, go_on, sized, usual_forces};
use super::settle::Rounds;
use crate::flight::derivative::{Axis, Variable};
use crate::flight::effect::Effect;

/// Standard errors that a derivative is off by.
const SURE: f64 = 4.0;

/// How much lower the evidence must be for an exchange.
const BETTER: f64 = 6.0;

/// Exchanges that are tried at once.
const OFFERS: usize = 3;

/// Part of what is there that derivatives alone may leave, so that it is worth while to go on.
const PROMISING: f64 = 0.3;

/// The causes, where many derivatives are wrong; `None` where no fit of all of them settles.
pub fn whole(problem: &Problem, from: &Searched, settings: &Settings) -> Option<Searched> {
    let mut point = problem.zero();
    point.force = from.point.force;
    point.hypotheses = off(problem, &point)?;
    let (mut point, mut local) = only_sure(problem, point)?;
    let left: f64 = problem.unexplained(&point)?.iter().sum();
    if !(left < PROMISING * from.before.iter().sum::<f64>()) {
        return None;
    }
    let mut against = standing(problem, &point)?;
    for _ in 0..point.hypotheses.len() {
        let Some(better) = exchanged(problem, &point, &local, &against) else { break };
        (point, local) = better;
        against = standing(problem, &point)?;
    }
    let rivals = rivals(&point, &local, &against);
    let stand = rivals.len();
    let mut searched = go_on(problem, (point, local), (rivals, stand), from.before, settings)?;
    searched.stds = with_all_in_doubt(problem, &searched.point)?;
    Some(searched)
}

/// The point with those hypotheses alone that are off by more than [`SURE`] standard errors, settled.
fn only_sure(problem: &Problem, mut point: Point) -> Option<(Point, Local)> {
    loop {
        let (there, local) = problem.settle(point, Rounds::SETTLED)?;
        let size = |hypothesis: &Hypothesis| libm::fabs(hypothesis.effect.main_number().unwrap_or(0.0));
        let sure = |&(place, hypothesis): &(usize, &Hypothesis)| size(hypothesis) > SURE * local.std(there.place_of(place));
        let kept: Vec<Hypothesis> = there.hypotheses.iter().enumerate().filter(sure).map(|(_, kept)| *kept).collect();
        if kept.len() == there.hypotheses.len() {
            return Some((there, local));
        }
        point = Point { hypotheses: kept, ..there };
    }
}

/// The library, and how each hypothesis stands against it.
struct Standing {
    entries: Vec<Entry>,
    places: Vec<InPlace>,
}

fn standing(problem: &Problem, point: &Point) -> Option<Standing> {
    let present = problem.effects(point);
    let entries: Vec<Entry> = library(problem, &present).into_iter().filter(|entry| axis_of(&entry.effect).is_some()).collect();
    let candidates: Vec<_> = entries.iter().map(|entry| &entry.candidate).collect();
    let wide = problem.linearise(point, &candidates, With::Slopes)?;
    let places = in_place(&wide, point, &entries, &usual_forces(problem))?;
    Some(Standing { entries, places })
}

/// With one hypothesis exchanged for what stands better in its place, where the evidence bears that out.
fn exchanged(problem: &Problem, point: &Point, local: &Local, standing: &Standing) -> Option<(Point, Local)> {
    let best = |(number, place): (usize, &InPlace)| {
        let score = *place.others.first()?;
        Some((number, score, score.gain - place.own))
    };
    let mut offers: Vec<(usize, Score, f64)> = standing.places.iter().enumerate().filter_map(best).collect();
    offers.retain(|(_, _, more)| *more > BETTER);
    offers.sort_by(|a, b| b.2.total_cmp(&a.2));
    offers.into_iter().take(OFFERS).find_map(|(number, score, _)| {
        let entry = standing.entries.get(score.entry)?;
        let mut other = point.clone();
        *other.hypotheses.get_mut(number)? = Hypothesis::of(sized(entry, &score), score.prior_std);
        let (there, found) = only_sure(problem, other)?;
        (found.evidence() < local.evidence() - BETTER).then_some((there, found))
    })
}

/// Each hypothesis with what else it may be.
fn rivals(point: &Point, local: &Local, standing: &Standing) -> Vec<Vec<Rival>> {
    let ranked = point.hypotheses.iter().zip(&standing.places).enumerate().map(|(number, (hypothesis, place))| {
        let std = local.std(point.place_of(number));
        let mut ranked = vec![Rival { effect: hypothesis.effect, std, odds: place.own, fitted: true }];
        ranked.extend(place.others.iter().filter_map(|score| {
            let effect = sized(standing.entries.get(score.entry)?, score);
            Some(Rival { effect, std: score.std, odds: score.gain, fitted: false })
        }));
        ranked
    });
    ranked.collect()
}

/// The problem with every derivative as free as the search's own priors make one alone, and what of the simulation's curvature is
/// in doubt with them: a model that is wrong in many derivatives is right in the others only within such bounds.
fn in_doubt(problem: &Problem, point: &Point) -> Option<(Problem, Vec<Hypothesis>)> {
    let present = problem.effects(point);
    let derivatives = library(problem, &present).into_iter().filter(|entry| matches!(entry.effect, Effect::Derivative { .. }));
    let curved = if problem.aircraft.is_curved() { curvature(problem, &present) } else { Vec::new() };
    let entries: Vec<Entry> = derivatives.chain(curved).collect();
    let candidates: Vec<_> = entries.iter().map(|entry| &entry.candidate).collect();
    let wide = problem.linearise(point, &candidates, With::Slopes)?;
    let usual = usual_forces(problem);
    let mut free = problem.clone();
    free.small.clear();
    let mut terms = Vec::new();
    for (place, entry) in entries.iter().enumerate() {
        let prior_std = prior_of(entry, &wide, place, &usual);
        match (entry.effect, prior_std) {
            (Effect::Derivative { axis, variable, .. }, Some(prior_std)) => free.small.push((axis, variable, prior_std)),
            (effect, Some(prior_std)) => terms.push(Hypothesis::of(effect, prior_std)),
            (_, None) => {}
        }
    }
    Some((free, terms))
}

/// The derivatives that are off, each with its prior, where all are free at once.
fn off(problem: &Problem, start: &Point) -> Option<Vec<Hypothesis>> {
    let (free, terms) = in_doubt(problem, start)?;
    let tolerance = |axis: Axis, variable: Variable| {
        problem.small.iter().find(|(a, v, _)| (*a, *v) == (axis, variable)).map_or(0.0, |(_, _, std)| *std)
    };
    let (point, local) = free.settle(Point { hypotheses: terms, ..start.clone() }, Rounds::SETTLED)?;
    let before = point.places().len();
    let off = free.small.iter().enumerate().filter_map(|(place, &(axis, variable, prior_std))| {
        let delta = *point.small.get(axis.index())?.get(variable.index())?;
        let allowed = SURE * libm::hypot(local.std(before + place), tolerance(axis, variable));
        (libm::fabs(delta) > allowed).then(|| Hypothesis::of(Effect::Derivative { axis, variable, delta }, prior_std))
    });
    Some(off.collect())
}

/// Standard errors of the hypotheses with everything else in doubt that may be: what was left out was left out because these runs
/// do not show it, not because it is nothing.
fn with_all_in_doubt(problem: &Problem, point: &Point) -> Option<Vec<f64>> {
    let (free, terms) = in_doubt(problem, point)?;
    let mut all = point.clone();
    all.hypotheses.extend(terms);
    let local = free.linearise(&all, &[], With::Slopes)?;
    Some((0..point.hypotheses.len()).map(|place| local.std(all.main_place_of(place))).collect())
}
