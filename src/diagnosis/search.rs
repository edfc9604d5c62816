//! The search: one cause after the other, each fitted with everything else free, until what remains is noise.
//!
//! Consumes the problem; produces the point with its causes, the rivals of each with their probabilities, and what is left.

use super::earlier::{weighed_again, without_needless};
use super::gusts::{gust_std, in_gusts, noisy, turbulence};
use super::library::{Entry, drowned, library, prior_std};
use super::linearise::{Local, With};
use super::point::{Hypothesis, Point, nudged};
use super::problem::Problem;
use super::run_record::RATE_MAX_HZ;
use super::screen::{Score, screen};
use super::settle::Rounds;
use crate::flight::derivative::AXES;
use crate::flight::effect::{Effect, EffectKind, same_cause};
use crate::flight::effect_file::DeclaredEffect;

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

/// Part of a cause's odds that is left for gusts, below which they are not looked at.
const CALM: f64 = 0.02;

/// How the search goes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// Most causes.
    pub causes: usize,
    /// How many of the best of a screening are fitted.
    pub fitted: usize,
    /// Rounds of a fit.
    pub rounds: usize,
    /// Twice the logarithm of the odds against any cause beforehand.
    pub against: f64,
}

impl Default for Settings {
    fn default() -> Self {
        Settings { causes: 3, fitted: 6, rounds: 6, against: 10.0 }
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

/// What came of it.
#[derive(Clone, Debug)]
pub struct Searched {
    /// What noise beyond the least is still worth, by axis: how much the cost rises without it.
    pub left: [f64; AXES],
    /// What noise was worth before there was any cause.
    pub before: [f64; AXES],
    /// With all of them.
    pub point: Point,
    /// There.
    pub local: Local,
    /// By cause, the chosen one first.
    pub rivals: Vec<Vec<Rival>>,
    /// What was looked at last and refused.
    pub refused: Vec<Rival>,
    /// Standard errors of the causes' main numbers where more is in doubt than at the point itself; none elsewhere.
    pub stds: Vec<f64>,
}

impl Searched {
    /// Standard error of a cause's main number, by its place among the point's hypotheses.
    pub fn std(&self, place: usize) -> f64 {
        let own = self.local.std(self.point.main_place_of(place));
        self.stds.get(place).copied().map_or(own, |std| std.max(own))
    }
}

/// What causes are worth beforehand: all kinds alike, and within a kind all of its causes in the library.
struct Worth {
    kinds: usize,
    own: Vec<(EffectKind, usize)>,
}

impl Worth {
    fn of(entries: &[Entry]) -> Self {
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
        Worth { kinds: own.len().max(1), own }
    }

    /// Twice the logarithm of an effect's odds among all.
    fn odds(&self, effect: &Effect) -> f64 {
        let own = self.own.iter().find(|(kind, _)| *kind == effect.kind()).map_or(1, |(_, count)| *count);
        // Instruments are late; one that is early is likelier to be the only one that is not late.
        let early = matches!(effect, Effect::SensorDelay { delay, .. } if *delay < 0.0);
        -2.0 * libm::log((self.kinds * own) as f64) - if early { EARLY } else { 0.0 }
    }
}

/// Looks for causes, after those that are known without the model: each with what else it may be.
pub fn search(problem: &Problem, known: &[Vec<DeclaredEffect>], settings: &Settings) -> Option<Searched> {
    let (mut point, mut local) = problem.settle(problem.zero(), Rounds::SETTLED)?;
    let before = problem.unexplained(&point)?;
    let mut rivals: Vec<Vec<Rival>> = Vec::new();
    for explanations in known {
        if let Some((next, ranked)) = told_apart(problem, &point, &local, explanations) {
            (point, local) = next;
            rivals.push(ranked);
        }
    }
    go_on(problem, (point, local), (rivals, 0), before, settings)
}

/// Looks for causes besides those that are there, the first `stand` of which are not looked at again.
pub(super) fn go_on(
    problem: &Problem,
    (mut point, mut local): (Point, Local),
    (mut rivals, stand): (Vec<Vec<Rival>>, usize),
    before: [f64; AXES],
    settings: &Settings,
) -> Option<Searched> {
    let mut refused = Vec::new();
    let mut known = rivals.len();
    // What is known stands where motion is taken as it was measured: a model that is silent there has nothing to say against it.
    let stand = if problem.says_all() { stand } else { known };
    while rivals.len() < known + settings.causes {
        let (taken, ranked) = one_more(problem, &point, &local, settings)?;
        let Some(next) = taken else {
            refused = ranked;
            break;
        };
        (point, local) = next;
        rivals.push(ranked);
        (point, local) = without_needless(problem, (point, local), &mut rivals, (stand, &mut known), settings);
    }
    // Where motion is taken as it was measured, what one cause leaves is hardly another's.
    if problem.says_all() {
        (point, local) = weighed_again(problem, (point, local), &mut rivals, (stand, known), settings);
    }
    let local = problem.linearise(&point, &[], With::Traces).unwrap_or(local);
    let left = problem.unexplained(&point)?;
    Some(Searched { left, before, point, local, rivals, refused, stds: Vec::new() })
}

/// A cause that is known beforehand, by the explanation that the runs bear out best. Where all of them make the model follow the
/// runs less well than nothing does, it is not taken as known: gusts can feign to the kinematics an instrument that is late.
fn told_apart(problem: &Problem, point: &Point, local: &Local, explanations: &[DeclaredEffect]) -> Option<Known> {
    let fits = explanations.iter().filter_map(|&DeclaredEffect { effect, std }| {
        let mut start = point.clone();
        start.hypotheses.push(Hypothesis { effect, prior_std: std.or(prior_std(&effect))?, known: Some(effect) });
        let (there, found) = problem.settle(start, Rounds::SETTLED)?;
        let place = there.hypotheses.len().checked_sub(1)?;
        let effect = there.hypotheses.get(place)?.effect;
        let std = found.std(there.main_place_of(place));
        let odds = local.evidence() - found.evidence();
        Some((Rival { effect, std, odds, fitted: true }, (there, found)))
    });
    let mut fits: Vec<(Rival, (Point, Local))> = fits.collect();
    fits.sort_by(|(a, _), (b, _)| b.odds.total_cmp(&a.odds));
    let ranked = fits.iter().map(|(rival, _)| *rival).collect();
    let (first, best) = fits.into_iter().next()?;
    (first.odds > 0.0).then_some((best, ranked))
}

/// The point with a cause that is known, and its explanations.
type Known = ((Point, Local), Vec<Rival>);

/// The next cause, where one is worth it, and everything that was looked at.
pub(super) type OneMore = (Option<(Point, Local)>, Vec<Rival>);

/// The best cause besides those that are there, where it is worth it.
pub(super) fn one_more(problem: &Problem, point: &Point, local: &Local, settings: &Settings) -> Option<OneMore> {
    let entries = library(problem, &problem.effects(point));
    let candidates: Vec<_> = entries.iter().map(|entry| &entry.candidate).collect();
    let wide = problem.linearise(point, &candidates, With::Slopes)?;
    let worth = Worth::of(&entries);
    let hoped = |score: &Score, effect: &Effect| score.gain + worth.odds(effect) - settings.against;
    let scores = screen(&wide, &entries, &usual_forces(problem));
    let mut chosen: Vec<(&Entry, Score)> = Vec::new();
    let mut others: Vec<Rival> = Vec::new();
    for score in &scores {
        let entry = &entries[score.entry];
        if chosen.iter().any(|(other, _)| same_cause(&other.effect, &entry.effect)) {
            continue;
        }
        if chosen.len() < settings.fitted {
            chosen.push((entry, *score));
        } else if !others.iter().any(|other| same_cause(&other.effect, &entry.effect)) {
            let effect = sized(entry, score);
            others.push(Rival { effect, std: score.std, odds: hoped(score, &effect), fitted: false });
        }
        if others.len() > 20 {
            break;
        }
    }
    let lagging = problem.effects(point).iter().any(|effect| matches!(effect, Effect::SensorLag { .. }));
    let before = local.evidence();
    let odds = |there: &Local, effect: &Effect| before - there.evidence() + worth.odds(effect) - settings.against;
    // A few rounds for every start, and all for those that are still in the running, by what they have come to or by what the
    // screening made of them.
    let mut fits: Vec<(Point, Local, f64, f64)> = Vec::new();
    for (entry, score) in chosen {
        let promised = hoped(&score, &entry.effect);
        if promised < HOPELESS {
            others.push(Rival { effect: sized(entry, &score), std: score.std, odds: promised, fitted: false });
            continue;
        }
        for effect in starts(entry, &score, lagging) {
            let mut start = point.clone();
            let prior = entry.prior_std.filter(|_| !entry.shared).or(prior_std(&effect)).unwrap_or(match effect {
                Effect::RateLimit { rate: number, .. } | Effect::DeadZone { half_width: number, .. } => number,
                _ => score.prior_std,
            });
            start.hypotheses.push(Hypothesis::of(effect, prior));
            if let Some((there, local)) = problem.settle(start, Rounds::some(HEAT)) {
                let odds = odds(&local, &effect);
                fits.push((there, local, odds, hoped(&score, &effect)));
            }
        }
    }
    let leading = fits.iter().map(|fit| fit.2).fold(f64::NEG_INFINITY, f64::max);
    let mut best: Option<(Point, Local, f64)> = None;
    let (mut ranked, mut fitted) = (Vec::new(), Vec::new());
    for (mut there, mut local, mut found, hoped) in fits {
        if found.max(hoped) > leading - (0.5 * leading).max(IN_THE_RUNNING) {
            let Some(settled) = problem.settle_on((there, local), Rounds::some(settings.rounds)) else { continue };
            (there, local) = settled;
            found = there.hypotheses.last().map_or(found, |hypothesis| odds(&local, &hypothesis.effect));
        }
        let std = local.std(there.place_of(there.hypotheses.len() - 1));
        let Some(effect) = there.hypotheses.last().map(|last| last.effect).filter(|effect| !drowned(problem, effect, std)) else {
            continue;
        };
        ranked.push(Rival { effect, std, odds: found, fitted: true });
        if best.as_ref().is_none_or(|(.., most)| found > *most) {
            best = Some((there.clone(), local, found));
        }
        fitted.push((there, found));
    }
    // What gusts would explain is noise of forces until they are there: where a cause has left next to none they explain nothing.
    let calm = best.as_ref().is_some_and(|(there, _, odds)| {
        let left = || problem.unexplained(there).map_or(f64::INFINITY, |left| left.iter().sum());
        !noisy(problem, there) || left() < CALM * odds
    });
    if noisy(problem, point)
        && !calm
        && let Some((there, local)) = in_gusts(problem, point, Rounds::some(settings.rounds))
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
    let settled = match closer_look(problem, &point, &mut ranked, &fitted, |effect| worth.odds(effect)) {
        Some(better) => problem.settle(better, Rounds::SETTLED),
        None => problem.settle_on((point, local), Rounds::SETTLED),
    };
    Some((settled, ranked))
}

/// Compares the best with those that are nearly as good on a mesh twice as fine, where the shape of a quick motion within a step
/// counts: a lag is then told from a delay that is shorter than the step. What they are worth there replaces what they were.
fn closer_look(
    problem: &Problem,
    best: &Point,
    ranked: &mut [Rival],
    fitted: &[(Point, f64)],
    worth: impl Fn(&Effect) -> f64,
) -> Option<Point> {
    let leading = ranked.first().filter(|first| first.fitted)?.odds;
    let near = |odds: f64| odds > leading - (CLOSE * leading).max(IN_THE_RUNNING);
    let mut close: Vec<&(Point, f64)> = fitted.iter().filter(|(_, odds)| near(*odds)).collect();
    close.sort_by(|a, b| b.1.total_cmp(&a.1));
    close.truncate(3);
    if close.len() < 2 || !close.iter().any(|(point, _)| point.hypotheses.last().is_some_and(|h| is_timing(&h.effect))) {
        return None;
    }
    let finer = problem.on_mesh_of(2.0 * RATE_MAX_HZ);
    let mut looked: Vec<(Point, Rival, f64)> = Vec::new();
    for (point, _) in close {
        let (there, local) = finer.settle(point.clone(), Rounds::some(HEAT + 1))?;
        let effect = there.hypotheses.last()?.effect;
        let std = local.std(there.place_of(there.hypotheses.len() - 1));
        looked.push((there, Rival { effect, std, odds: leading, fitted: true }, local.evidence() - worth(&effect)));
    }
    let least = looked.iter().map(|look| look.2).fold(f64::INFINITY, f64::min);
    let mut better = None;
    for (point, rival, evidence) in looked {
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

/// Whether an effect acts by when things happen.
fn is_timing(effect: &Effect) -> bool {
    matches!(
        effect,
        Effect::SensorLag { .. } | Effect::SensorDelay { .. } | Effect::ActuatorLag { .. } | Effect::TransportDelay { .. }
    )
}

/// The effect that an entry's score stands for.
pub(super) fn sized(entry: &Entry, score: &Score) -> Effect {
    let size = match entry.effect {
        _ if entry.shared => return entry.effect,
        // A factor stays positive.
        Effect::SensorScale { .. } | Effect::ControlEffectiveness { .. } => score.size.max(-0.9),
        Effect::SensorPosition { sensor, mut offset_m } => {
            if let Some(offset) = offset_m.get_mut(entry.component) {
                *offset = score.size;
            }
            return Effect::SensorPosition { sensor, offset_m };
        }
        _ => score.size,
    };
    nudged(&entry.effect, size)
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

/// Where fits of an entry begin: what delays may also be a lag, where there is none yet.
fn starts(entry: &Entry, score: &Score, lagging: bool) -> Vec<Effect> {
    let effect = sized(entry, score);
    match effect {
        Effect::SensorDelay { channel, delay } => {
            let delay = delay.clamp(-0.4, 0.4);
            let mut both = vec![Effect::SensorDelay { channel, delay }];
            if delay > 0.0 && !lagging {
                both.push(Effect::SensorLag { channel, tau: delay });
            }
            both
        }
        Effect::ActuatorLag { control, tau } => {
            let tau = (tau * score.size.clamp(0.2, 3.0)).max(0.01);
            vec![Effect::ActuatorLag { control, tau }]
        }
        Effect::TransportDelay { control, delay } => {
            vec![Effect::TransportDelay { control, delay: (delay * score.size.clamp(0.2, 3.0)).max(0.01) }]
        }
        _ => vec![effect],
    }
}

/// Root mean square of the model's own forces, by axis: what a hypothesis is measured by beforehand.
pub(super) fn usual_forces(problem: &Problem) -> [f64; AXES] {
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
