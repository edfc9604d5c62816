//! A model that is wrong in many derivatives at once: all of them fitted together, those kept that are really off.
//!
//! Consumes the problem; with every derivative of the axes that the model speaks of as free as the search's own priors make one
//! alone (and what a simulation has of second order in sideways motion), and all at once, those that come out off by more than
//! four standard errors become causes, and the others go back to the model's tolerance, until all that stay are off by so
//! many; then causes are exchanged for what stands better in their place, and the search goes on from there. Standard errors are
//! those with everything in doubt that may be. What is left of a model that is wrong in another way stays left: the caller
//! judges that as after the search.

use super::forward_search::{SearchResult, forward_search};
use super::hypotheses::{LibraryEntry, curvature, effect_at_estimate, hypotheses};
use super::next_cause::{Rival, SearchSettings, usual_forces};
use super::score_test::{HypothesisScore, prior_of};
use super::substitution::{Substitutes, substitutes};
use crate::flight::derivative::{Axis, Variable};
use crate::flight::effect::Effect;
use crate::postflight::diagnosis::likelihood::adequacy::unexplained;
use crate::postflight::diagnosis::likelihood::maximise::{Effort, maximise};
use crate::postflight::diagnosis::likelihood::normal_equations::{Detail, Linearisation, linearise};
use crate::postflight::diagnosis::likelihood::parameter_set::{Hypothesis, ParameterSet};
use crate::postflight::diagnosis::likelihood::problem::DiagnosisProblem;

/// Standard errors that a derivative is off by.
const SIGNIFICANT: f64 = 4.0;

/// How much lower the evidence must be for an exchange.
const BETTER: f64 = 6.0;

/// Exchanges that are tried at once.
const OFFERS: usize = 3;

/// Part of what is there that derivatives alone may leave, so that it is worth while to go on.
const PROMISING: f64 = 0.3;

/// The causes, where many derivatives are wrong; `None` where no fit of all of them settles.
pub fn joint_derivatives(problem: &DiagnosisProblem, from: &SearchResult, settings: &SearchSettings) -> Option<SearchResult> {
    if settings.is_stopped() {
        return None;
    }
    let mut point = problem.null_hypothesis();
    point.force_density = from.point.force_density;
    point.hypotheses = significant_derivatives(problem, &point)?;
    let (mut point, mut local) = significant_only(problem, point)?;
    let left: f64 = unexplained(problem, &point)?.iter().sum();
    if !(left < PROMISING * from.before.iter().sum::<f64>()) {
        return None;
    }
    let mut table = substitution_table(problem, &point)?;
    for _ in 0..point.hypotheses.len() {
        let Some(better) = exchanged(problem, &point, &local, &table) else { break };
        (point, local) = better;
        table = substitution_table(problem, &point)?;
    }
    let rivals = rivals(&point, &local, &table);
    let stand = rivals.len();
    let mut searched = forward_search(problem, (point, local), (rivals, stand), from.before, settings)?;
    searched.stds = stds_with_all_free(problem, &searched.point)?;
    Some(searched)
}

/// The point with those hypotheses alone that are off by more than [`SIGNIFICANT`] standard errors, settled.
fn significant_only(problem: &DiagnosisProblem, mut point: ParameterSet) -> Option<(ParameterSet, Linearisation)> {
    loop {
        let (there, local) = maximise(problem, point, Effort::SETTLED)?;
        let size = |hypothesis: &Hypothesis| libm::fabs(hypothesis.effect.main_number().unwrap_or(0.0));
        let sure =
            |&(place, hypothesis): &(usize, &Hypothesis)| size(hypothesis) > SIGNIFICANT * local.std(there.place_of(place));
        let kept: Vec<Hypothesis> = there.hypotheses.iter().enumerate().filter(sure).map(|(_, kept)| *kept).collect();
        if kept.len() == there.hypotheses.len() {
            return Some((there, local));
        }
        point = ParameterSet { hypotheses: kept, ..there };
    }
}

/// The library, and how each hypothesis stands against it.
struct Substitution {
    entries: Vec<LibraryEntry>,
    places: Vec<Substitutes>,
}

fn substitution_table(problem: &DiagnosisProblem, point: &ParameterSet) -> Option<Substitution> {
    let present = problem.effects(point);
    let entries: Vec<LibraryEntry> =
        hypotheses(problem, &present).into_iter().filter(|entry| entry.effect.axis().is_some()).collect();
    let candidates: Vec<_> = entries.iter().map(|entry| &entry.candidate).collect();
    let wide = linearise(problem, point, &candidates, Detail::Slopes)?;
    let places = substitutes(&wide, point, &entries, &usual_forces(problem))?;
    Some(Substitution { entries, places })
}

/// With one hypothesis exchanged for what stands better in its place, where the evidence bears that out.
fn exchanged(
    problem: &DiagnosisProblem,
    point: &ParameterSet,
    local: &Linearisation,
    substitution_table: &Substitution,
) -> Option<(ParameterSet, Linearisation)> {
    let best = |(number, place): (usize, &Substitutes)| {
        let score = *place.others.first()?;
        Some((number, score, score.gain - place.own))
    };
    let mut offers: Vec<(usize, HypothesisScore, f64)> = substitution_table.places.iter().enumerate().filter_map(best).collect();
    offers.retain(|(_, _, more)| *more > BETTER);
    offers.sort_by(|a, b| b.2.total_cmp(&a.2));
    offers.into_iter().take(OFFERS).find_map(|(number, score, _)| {
        let entry = substitution_table.entries.get(score.entry)?;
        let mut other = point.clone();
        *other.hypotheses.get_mut(number)? = Hypothesis::of(effect_at_estimate(entry, score.size), score.prior_std);
        let (there, found) = significant_only(problem, other)?;
        (found.evidence() < local.evidence() - BETTER).then_some((there, found))
    })
}

/// Each hypothesis with what else it may be.
fn rivals(point: &ParameterSet, local: &Linearisation, substitution_table: &Substitution) -> Vec<Vec<Rival>> {
    let ranked = point.hypotheses.iter().zip(&substitution_table.places).enumerate().map(|(number, (hypothesis, place))| {
        let std = local.std(point.place_of(number));
        let mut ranked = vec![Rival { effect: hypothesis.effect, std, odds: place.own, fitted: true }];
        ranked.extend(place.others.iter().filter_map(|score| {
            let effect = effect_at_estimate(substitution_table.entries.get(score.entry)?, score.size);
            Some(Rival { effect, std: score.std, odds: score.gain, fitted: false })
        }));
        ranked
    });
    ranked.collect()
}

/// The problem with every derivative as free as the search's own priors make one alone, and what of the simulation's curvature is
/// in doubt with them: a model that is wrong in many derivatives is right in the others only within such bounds.
fn all_free(problem: &DiagnosisProblem, point: &ParameterSet) -> Option<(DiagnosisProblem, Vec<Hypothesis>)> {
    let present = problem.effects(point);
    let derivatives = hypotheses(problem, &present).into_iter().filter(|entry| matches!(entry.effect, Effect::Derivative { .. }));
    let curved = if problem.aircraft.is_curved() { curvature(problem, &present) } else { Vec::new() };
    let entries: Vec<LibraryEntry> = derivatives.chain(curved).collect();
    let candidates: Vec<_> = entries.iter().map(|entry| &entry.candidate).collect();
    let wide = linearise(problem, point, &candidates, Detail::Slopes)?;
    let usual = usual_forces(problem);
    let mut free = problem.clone();
    free.derivative_tolerances.clear();
    let mut terms = Vec::new();
    for (place, entry) in entries.iter().enumerate() {
        let prior_std = prior_of(entry, &wide, place, &usual);
        match (entry.effect, prior_std) {
            (Effect::Derivative { axis, variable, .. }, Some(prior_std)) => {
                free.derivative_tolerances.push((axis, variable, prior_std))
            }
            (effect, Some(prior_std)) => terms.push(Hypothesis::of(effect, prior_std)),
            (_, None) => {}
        }
    }
    Some((free, terms))
}

/// The derivatives that are off, each with its prior, where all are free at once.
fn significant_derivatives(problem: &DiagnosisProblem, start: &ParameterSet) -> Option<Vec<Hypothesis>> {
    let (free, terms) = all_free(problem, start)?;
    let tolerance = |axis: Axis, variable: Variable| {
        problem.derivative_tolerances.iter().find(|(a, v, _)| (*a, *v) == (axis, variable)).map_or(0.0, |(_, _, std)| *std)
    };
    let (point, local) = maximise(&free, ParameterSet { hypotheses: terms, ..start.clone() }, Effort::SETTLED)?;
    let before = point.places().len();
    let significant_derivatives =
        free.derivative_tolerances.iter().enumerate().filter_map(|(place, &(axis, variable, prior_std))| {
            let delta = *point.derivative_errors.get(axis.index())?.get(variable.index())?;
            let allowed = SIGNIFICANT * libm::hypot(local.std(before + place), tolerance(axis, variable));
            (libm::fabs(delta) > allowed).then(|| Hypothesis::of(Effect::Derivative { axis, variable, delta }, prior_std))
        });
    Some(significant_derivatives.collect())
}

/// Standard errors of the hypotheses with everything else in doubt that may be: what was left out was left out because these runs
/// do not show it, not because it is nothing.
fn stds_with_all_free(problem: &DiagnosisProblem, point: &ParameterSet) -> Option<Vec<f64>> {
    let (free, terms) = all_free(problem, point)?;
    let mut all = point.clone();
    all.hypotheses.extend(terms);
    let local = linearise(&free, &all, &[], Detail::Slopes)?;
    Some((0..point.hypotheses.len()).map(|place| local.std(all.main_place_of(place))).collect())
}
