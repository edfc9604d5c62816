//! The search: one cause after the other, each fitted with everything else free, until what remains is noise.
//!
//! Consumes the problem; produces the point with its causes, the rivals of each with their probabilities, and what is left.

use super::hypotheses::prior_std;
use super::next_cause::{Rival, SearchSettings, next_cause};
use super::retest::{drop_redundant, retest};
use crate::flight::derivative::AXES;
use crate::flight::file::effect_file::DeclaredEffect;
use crate::postflight::diagnosis::evidence::cause_size::cause_sizes;
use crate::postflight::diagnosis::holdout::horizon_prediction::HORIZON_S;
use crate::postflight::diagnosis::likelihood::adequacy::unexplained;
use crate::postflight::diagnosis::likelihood::maximise::{Effort, maximise};
use crate::postflight::diagnosis::likelihood::normal_equations::{Detail, Linearisation, linearise};
use crate::postflight::diagnosis::likelihood::parameter_set::{Hypothesis, ParameterSet};
use crate::postflight::diagnosis::likelihood::problem::DiagnosisProblem;

/// So many small causes at most are found beside those that the settings allow.
const SMALL_MOST: usize = 2;

/// Result of the search.
#[derive(Clone, Debug)]
pub struct SearchResult {
    /// What noise beyond the least is still worth, by axis: how much the cost rises without it.
    pub left: [f64; AXES],
    /// What noise was worth before there was any cause.
    pub before: [f64; AXES],
    /// With all of them.
    pub point: ParameterSet,
    /// There.
    pub local: Linearisation,
    /// By cause, the chosen one first.
    pub rivals: Vec<Vec<Rival>>,
    /// The candidates tested last and refused.
    pub refused: Vec<Rival>,
    /// Standard errors of the causes' main numbers where more is in doubt than at the point itself; none elsewhere.
    pub stds: Vec<f64>,
}

impl SearchResult {
    /// Whether it is many derivatives that are off, fitted together.
    pub fn is_joint(&self) -> bool {
        !self.stds.is_empty()
    }

    /// Standard error of a cause's main number, by its place among the point's hypotheses.
    pub fn std(&self, place: usize) -> f64 {
        let own = self.local.std(self.point.main_place_of(place));
        self.stds.get(place).copied().map_or(own, |std| std.max(own))
    }
}

/// Forward search for causes, after those that are known without the model: each with its alternatives.
pub fn search(problem: &DiagnosisProblem, known: &[Vec<DeclaredEffect>], settings: &SearchSettings) -> Option<SearchResult> {
    let (mut point, mut local) = maximise(problem, problem.null_hypothesis(), Effort::SETTLED)?;
    let before = unexplained(problem, &point)?;
    let mut rivals: Vec<Vec<Rival>> = Vec::new();
    for explanations in known {
        if let Some((next, ranked)) = choose_explanation(problem, &point, &local, explanations) {
            (point, local) = next;
            rivals.push(ranked);
        }
    }
    forward_search(problem, (point, local), (rivals, 0), before, settings)
}

/// Forward search for causes besides those given, the first `stand` of which are not tested again.
pub(crate) fn forward_search(
    problem: &DiagnosisProblem,
    (mut point, mut local): (ParameterSet, Linearisation),
    (mut rivals, stand): (Vec<Vec<Rival>>, usize),
    before: [f64; AXES],
    settings: &SearchSettings,
) -> Option<SearchResult> {
    let mut refused = Vec::new();
    let mut known = rivals.len();
    // What is known stands where motion is taken as it was measured: a model that is silent there has nothing to say against it.
    let stand = if problem.models_all_axes() { stand } else { known };
    settings.plan(settings.causes + 1);
    let mut searched = 0;
    while rivals.len() < known + settings.causes + small_causes(problem, &point).min(SMALL_MOST) && !settings.is_stopped() {
        if searched > settings.causes {
            settings.plan(1);
        }
        searched += 1;
        let (taken, ranked) = next_cause(problem, &point, &local, settings)?;
        let Some(next) = taken else {
            refused = ranked;
            break;
        };
        (point, local) = next;
        rivals.push(ranked);
        (point, local) = drop_redundant(problem, (point, local), &mut rivals, (stand, &mut known), settings);
    }
    settings.advance((settings.causes + 1).saturating_sub(searched) * settings.steps());
    // Where motion is taken as it was measured, what one cause leaves is hardly another's.
    if problem.models_all_axes() && !settings.is_stopped() {
        (point, local) = retest(problem, (point, local), &mut rivals, (stand, known), settings);
    }
    let local = linearise(problem, &point, &[], Detail::Traces).unwrap_or(local);
    let left = unexplained(problem, &point)?;
    Some(SearchResult { left, before, point, local, rivals, refused, stds: Vec::new() })
}

/// How many causes are small beside what is left: these do not take the place of one that matters. Where motion is taken as it
/// was measured, what is left is no measure of the model.
fn small_causes(problem: &DiagnosisProblem, point: &ParameterSet) -> usize {
    if !problem.models_all_axes() {
        return 0;
    }
    let [sizes] = cause_sizes(problem, point, [HORIZON_S]);
    (0..sizes.of.len()).filter(|&place| sizes.is_small(place)).count()
}

/// A cause that is known beforehand, by the explanation that the runs bear out best. Where all of them make the model follow the
/// runs less well than nothing does, it is not taken as known: gusts can feign to the kinematics an instrument that is late.
fn choose_explanation(
    problem: &DiagnosisProblem,
    point: &ParameterSet,
    local: &Linearisation,
    explanations: &[DeclaredEffect],
) -> Option<KnownCause> {
    let fits = explanations.iter().filter_map(|&DeclaredEffect { effect, std }| {
        let mut start = point.clone();
        start.hypotheses.push(Hypothesis { effect, prior_std: std.or(prior_std(&effect))?, known: Some(effect) });
        let (there, found) = maximise(problem, start, Effort::SETTLED)?;
        let place = there.hypotheses.len().checked_sub(1)?;
        let effect = there.hypotheses.get(place)?.effect;
        let std = found.std(there.main_place_of(place));
        let odds = local.evidence() - found.evidence();
        Some((Rival { effect, std, odds, fitted: true }, (there, found)))
    });
    let mut fits: Vec<(Rival, (ParameterSet, Linearisation))> = fits.collect();
    fits.sort_by(|(a, _), (b, _)| b.odds.total_cmp(&a.odds));
    let ranked = fits.iter().map(|(rival, _)| *rival).collect();
    let (first, best) = fits.into_iter().next()?;
    (first.odds > 0.0).then_some((best, ranked))
}

/// The point with a cause that is known, and its explanations.
type KnownCause = ((ParameterSet, Linearisation), Vec<Rival>);
