//! The next cause: score test of every hypothesis, fits of the best, and the choice between them.
//!
//! Consumes the problem, the parameter set with the causes that are there and its linearisation; produces the best further cause,
//! fitted with everything else free, where its evidence outweighs its prior odds, and everything that it was compared with.

use super::gusts::{gust_std, has_excess_noise, turbulence, with_gusts};
use super::hypotheses::{LibraryEntry, below_noise, effect_at_estimate, fit_prior_std, hypotheses, is_timing, starts};
use super::score_test::{HypothesisScore, score_test};
use crate::flight::derivative::AXES;
use crate::flight::effect::{Effect, EffectKind, same_cause};
use crate::postflight::diagnosis::data::run_data::MESH_RATE_HZ;
use crate::postflight::diagnosis::likelihood::adequacy::unexplained;
use crate::postflight::diagnosis::likelihood::maximise::{Effort, maximise, resume};
use crate::postflight::diagnosis::likelihood::normal_equations::{Detail, Linearisation, linearise};
use crate::postflight::diagnosis::likelihood::parameter_set::{Hypothesis, ParameterSet};
use crate::postflight::diagnosis::likelihood::problem::DiagnosisProblem;
use crate::postflight::work_progress::{Watch, advance, is_stopped, plan};

/// Rounds that every start has.
const HEAT: usize = 2;
/// Odds of a screening, far below which a fit brings nothing more.
const HOPELESS: f64 = -8.0;
/// Least distance in odds behind the leading one at which a start is given up.
const IN_THE_RUNNING: f64 = 30.0;
/// Distance in odds, of the leading ones, within which a finer mesh decides.
const CLOSE: f64 = 0.1;

/// Odds against an instrument that reads early.
const EARLY: f64 = 8.0;

/// Part of a cause's odds that is left for gusts, below which they are not tested.
const CALM: f64 = 0.02;

/// Settings of the forward search.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SearchSettings {
    /// Most causes.
    pub causes: usize,
    /// How many of the best of a screening are fitted.
    pub fitted: usize,
    /// Rounds of a fit.
    pub rounds: usize,
    /// Twice the logarithm of the odds against any cause beforehand.
    pub odds_against: f64,
    /// Who watches the search, and may end it: each cause is as many steps as the search has for one.
    pub watch: Watch,
}

impl Default for SearchSettings {
    fn default() -> Self {
        SearchSettings { causes: 3, fitted: 6, rounds: 6, odds_against: 10.0, watch: None }
    }
}

impl SearchSettings {
    /// Steps of the search for one cause: the screening, its best fitted, and the settling of what is left of these.
    pub(crate) fn steps(&self) -> usize {
        self.fitted + 2
    }

    /// Whether the search was asked to end.
    pub(crate) fn is_stopped(&self) -> bool {
        is_stopped(self.watch)
    }

    /// Steps made of it, for who watches.
    pub(crate) fn advance(&self, steps: usize) {
        advance(self.watch, steps);
    }

    /// Causes that will be searched for.
    pub(crate) fn plan(&self, causes: usize) {
        plan(self.watch, causes * self.steps());
    }
}

/// A rival for a cause.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rival {
    /// With its number as fitted, or as screened.
    pub effect: Effect,
    /// Standard error of the main number.
    pub std: f64,
    /// Twice the logarithm of its odds against nothing.
    pub odds: f64,
    /// Whether it was fitted.
    pub fitted: bool,
}

/// What causes are worth beforehand: all kinds alike, and within a kind all of its causes in the library.
struct PriorOdds {
    kinds: usize,
    own: Vec<(EffectKind, usize)>,
}

impl PriorOdds {
    fn of(entries: &[LibraryEntry]) -> Self {
        let mut causes: Vec<&Effect> = Vec::new();
        let mut own: Vec<(EffectKind, usize)> = Vec::new();
        for entry in entries {
            if causes.iter().any(|there| same_cause(there, &entry.effect)) {
                continue;
            }
            causes.push(&entry.effect);
            let kind = entry.effect.kind();
            match own.iter_mut().find(|(there, _)| *there == kind) {
                Some((_, count)) => *count += 1,
                None => own.push((kind, 1)),
            }
        }
        PriorOdds { kinds: own.len().max(1), own }
    }

    /// Twice the logarithm of an effect's odds among all.
    fn odds(&self, effect: &Effect) -> f64 {
        let own = self.own.iter().find(|(kind, _)| *kind == effect.kind()).map_or(1, |(_, count)| *count);
        // Instruments are late; one that is early is likelier to be the only one that is not late.
        let early = matches!(effect, Effect::SensorDelay { delay, .. } if *delay < 0.0);
        -2.0 * libm::log((self.kinds * own) as f64) - if early { EARLY } else { 0.0 }
    }
}

/// The next cause, where one is worth its penalty, and all candidates that were tested.
pub(crate) type NextCause = (Option<(ParameterSet, Linearisation)>, Vec<Rival>);

/// The best cause besides those that are there, where it is worth it; none where the search was asked to end.
pub(crate) fn next_cause(
    problem: &DiagnosisProblem,
    point: &ParameterSet,
    local: &Linearisation,
    settings: &SearchSettings,
) -> Option<NextCause> {
    let entries = hypotheses(problem, &problem.effects(point));
    let candidates: Vec<_> = entries.iter().map(|entry| &entry.candidate).collect();
    let wide = linearise(problem, point, &candidates, Detail::Slopes)?;
    let worth = PriorOdds::of(&entries);
    let hoped = |score: &HypothesisScore, effect: &Effect| score.gain + worth.odds(effect) - settings.odds_against;
    let scores = score_test(&wide, &entries, &usual_forces(problem));
    let mut chosen: Vec<(&LibraryEntry, HypothesisScore)> = Vec::new();
    let mut others: Vec<Rival> = Vec::new();
    for score in &scores {
        let entry = &entries[score.entry];
        if chosen.iter().any(|(other, _)| same_cause(&other.effect, &entry.effect)) {
            continue;
        }
        if chosen.len() < settings.fitted {
            chosen.push((entry, *score));
        } else if !others.iter().any(|other| same_cause(&other.effect, &entry.effect)) {
            let effect = effect_at_estimate(entry, score.size);
            others.push(Rival { effect, std: score.std, odds: hoped(score, &effect), fitted: false });
        }
        if others.len() > 20 {
            break;
        }
    }
    let lagging = problem.effects(point).iter().any(|effect| matches!(effect, Effect::SensorLag { .. }));
    let before = local.evidence();
    let odds = |there: &Linearisation, effect: &Effect| before - there.evidence() + worth.odds(effect) - settings.odds_against;
    // A few rounds for every start, and all for those that are still in the running, by the evidence reached or by what the
    // screening made of them.
    let mut fits: Vec<(ParameterSet, Linearisation, f64, f64)> = Vec::new();
    settings.advance(1);
    let (mut left, stopped) = (settings.steps() - 1, (None, Vec::new()));
    for (entry, score) in chosen {
        if settings.is_stopped() {
            return Some(stopped);
        }
        settings.advance(1);
        left -= 1;
        let promised = hoped(&score, &entry.effect);
        if promised < HOPELESS {
            others.push(Rival { effect: effect_at_estimate(entry, score.size), std: score.std, odds: promised, fitted: false });
            continue;
        }
        for effect in starts(entry, score.size, lagging) {
            let mut start = point.clone();
            let prior = fit_prior_std(entry, &effect, score.prior_std);
            start.hypotheses.push(Hypothesis::of(effect, prior));
            if let Some((there, local)) = maximise(problem, start, Effort::some(HEAT)) {
                let odds = odds(&local, &effect);
                fits.push((there, local, odds, hoped(&score, &effect)));
            }
        }
    }
    let leading = fits.iter().map(|fit| fit.2).fold(f64::NEG_INFINITY, f64::max);
    let mut best: Option<(ParameterSet, Linearisation, f64)> = None;
    let (mut ranked, mut fitted) = (Vec::new(), Vec::new());
    for (mut there, mut local, mut found, hoped) in fits {
        if settings.is_stopped() {
            return Some(stopped);
        }
        if found.max(hoped) > leading - (0.5 * leading).max(IN_THE_RUNNING) {
            let Some(settled) = resume(problem, (there, local), Effort::some(settings.rounds)) else { continue };
            (there, local) = settled;
            found = there.hypotheses.last().map_or(found, |hypothesis| odds(&local, &hypothesis.effect));
        }
        let std = local.std(there.place_of(there.hypotheses.len() - 1));
        let Some(effect) = there.hypotheses.last().map(|last| last.effect).filter(|effect| !below_noise(problem, effect, std))
        else {
            continue;
        };
        ranked.push(Rival { effect, std, odds: found, fitted: true });
        if best.as_ref().is_none_or(|(.., most)| found > *most) {
            best = Some((there.clone(), local, found));
        }
        fitted.push((there, found));
    }
    settings.advance(left);
    // What gusts would explain is noise of forces until they are there: where a cause has left next to none they explain nothing.
    let calm = best.as_ref().is_some_and(|(there, _, odds)| {
        let left = || unexplained(problem, there).map_or(f64::INFINITY, |left| left.iter().sum());
        !has_excess_noise(problem, there) || left() < CALM * odds
    });
    if has_excess_noise(problem, point)
        && !calm
        && let Some((there, local)) = with_gusts(problem, point, Effort::some(settings.rounds))
    {
        let effect = turbulence(problem, &there);
        let found = odds(&local, &effect);
        ranked.push(Rival { effect, std: gust_std(problem, &there), odds: found, fitted: true });
        if best.as_ref().is_none_or(|(.., most)| found > *most) {
            best = Some((there, local, found));
        }
    }
    if lagging {
        ranked.extend(ranked.clone().iter().filter_map(as_lag));
    }
    ranked.extend(others);
    ranked.sort_by(|a, b| b.odds.total_cmp(&a.odds));
    let mut seen: Vec<Effect> = Vec::new();
    ranked.retain(|rival| {
        let new = !seen.iter().any(|there| same_cause(there, &rival.effect));
        seen.push(rival.effect);
        new
    });
    let Some((point, local, _)) = best.filter(|(.., odds)| *odds > 0.0) else { return Some((None, ranked)) };
    let settled = match refine_mesh(problem, &point, &mut ranked, &fitted, |effect| worth.odds(effect)) {
        Some(better) => maximise(problem, better, Effort::SETTLED),
        None => resume(problem, (point, local), Effort::SETTLED),
    };
    Some((settled, ranked))
}

/// Compares the best with those that are nearly as good on a mesh twice as fine, where the shape of a quick motion within a step
/// counts: a lag is then separable from a delay that is shorter than the step. Their evidence there replaces that before.
fn refine_mesh(
    problem: &DiagnosisProblem,
    best: &ParameterSet,
    ranked: &mut [Rival],
    fitted: &[(ParameterSet, f64)],
    worth: impl Fn(&Effect) -> f64,
) -> Option<ParameterSet> {
    let leading = ranked.first().filter(|first| first.fitted)?.odds;
    let near = |odds: f64| odds > leading - (CLOSE * leading).max(IN_THE_RUNNING);
    let mut close: Vec<&(ParameterSet, f64)> = fitted.iter().filter(|(_, odds)| near(*odds)).collect();
    close.sort_by(|a, b| b.1.total_cmp(&a.1));
    close.truncate(3);
    if close.len() < 2 || !close.iter().any(|(point, _)| point.hypotheses.last().is_some_and(|h| is_timing(&h.effect))) {
        return None;
    }
    let finer = problem.with_mesh_rate(2.0 * MESH_RATE_HZ);
    let mut refined: Vec<(ParameterSet, Rival, f64)> = Vec::new();
    for (point, _) in close {
        let (there, local) = maximise(&finer, point.clone(), Effort::some(HEAT + 1))?;
        let effect = there.hypotheses.last()?.effect;
        let std = local.std(there.place_of(there.hypotheses.len() - 1));
        refined.push((there, Rival { effect, std, odds: leading, fitted: true }, local.evidence() - worth(&effect)));
    }
    let least = refined.iter().map(|one| one.2).fold(f64::INFINITY, f64::min);
    let mut better = None;
    for (point, rival, evidence) in refined {
        let odds = leading - (evidence - least);
        if let Some(there) = ranked.iter_mut().find(|there| same_cause(&there.effect, &rival.effect)) {
            *there = Rival { odds, ..rival };
        }
        if evidence <= least
            && point.hypotheses.last().map(|h| h.effect.kind()) != best.hypotheses.last().map(|h| h.effect.kind())
        {
            better = Some(point);
        }
    }
    ranked.sort_by(|a, b| b.odds.total_cmp(&a.odds));
    better
}

/// A delay as a lag: the filter carries one lag, and beside one that stands there it does not tell the two apart.
fn as_lag(rival: &Rival) -> Option<Rival> {
    match rival.effect {
        Effect::SensorDelay { channel, delay } if delay > 0.0 => {
            Some(Rival { effect: Effect::SensorLag { channel, tau: delay }, fitted: false, ..*rival })
        }
        _ => None,
    }
}

/// Root mean square of the model's own forces, by axis: what a hypothesis is measured by beforehand.
pub(crate) fn usual_forces(problem: &DiagnosisProblem) -> [f64; AXES] {
    let mut usual = [0.3, 0.3, 0.5, 0.05, 0.05, 0.05];
    for run in &problem.runs {
        for (axis, usual) in usual.iter_mut().enumerate() {
            if let Some(series) = run.outputs.get(axis).and_then(Option::as_ref).filter(|_| axis < 3) {
                let mean = series.average();
                let square = series.samples().map(|(_, x)| (x - mean) * (x - mean)).sum::<f64>() / series.len() as f64;
                *usual = f64::max(*usual, libm::sqrt(square));
            }
            if let Some(series) = run.outputs.get(axis).and_then(Option::as_ref).filter(|_| axis >= 3) {
                let step = 0.125;
                let (from, to) = series.range_s().unwrap_or((0.0, 0.0));
                let count = ((to - from) / step) as usize;
                let square = (1..count)
                    .map(|k| {
                        let t = from + step * k as f64;
                        let slope = (series.mean(t, t + step) - series.mean(t - step, t)) / step;
                        slope * slope
                    })
                    .sum::<f64>()
                    / count.max(1) as f64;
                *usual = f64::max(*usual, libm::sqrt(square));
            }
        }
    }
    usual
}
