//! Earlier causes with the later ones in place: what these have made needless goes, and what has become likelier takes its place.
//!
//! Consumes the problem, the point with its causes and the rivals of each; produces the same with every cause weighed beside all
//! others. A first cause may stand for two: vanes that are both late pass for vanes further ahead, until the second is there.

use super::next_cause::{NextCause, Rival, SearchSettings, next_cause};
use crate::flight::effect::{Effect, same_cause};
use crate::postflight::diagnosis::likelihood::maximise::{Effort, maximise};
use crate::postflight::diagnosis::likelihood::normal_equations::Linearisation;
use crate::postflight::diagnosis::likelihood::parameter_set::ParameterSet;
use crate::postflight::diagnosis::likelihood::problem::DiagnosisProblem;

/// Times that all are weighed: a cause that takes another's place changes what the rest are worth.
const SWEEPS: usize = 2;
/// Twice the logarithm of the odds by which another cause has to be better than what was known without the model: what the
/// kinematics have seen of it is not seen here again.
const KNOWN_STANDS: f64 = 20.0;

/// Where gusts stand among the causes: they are one, but no hypothesis with a number of its own.
fn place_of_gusts(rivals: &[Vec<Rival>]) -> Option<usize> {
    rivals.iter().position(|ranked| ranked.first().is_some_and(|first| matches!(first.effect, Effect::Turbulence { .. })))
}

/// How many hypotheses are the newest cause, which was weighed with all others in place.
fn newest(rivals: &[Vec<Rival>]) -> usize {
    usize::from(place_of_gusts(rivals).is_none_or(|gusts| gusts + 1 < rivals.len()))
}

/// Takes back causes that a later one has made needless: without them the evidence is hardly worse, or, of what was known
/// beforehand, no worse. The first `stand` are left alone; how many of those that are `known` are left is counted.
pub(crate) fn drop_redundant(
    problem: &DiagnosisProblem,
    (mut point, mut local): (ParameterSet, Linearisation),
    rivals: &mut Vec<Vec<Rival>>,
    (stand, known): (usize, &mut usize),
    settings: &SearchSettings,
) -> (ParameterSet, Linearisation) {
    let newest = newest(rivals);
    let mut number = stand;
    while number + newest < point.hypotheses.len() {
        let gusts = place_of_gusts(rivals);
        let worse = if number < *known { 0.0 } else { settings.odds_against };
        let mut fewer = point.clone();
        fewer.hypotheses.remove(number);
        let fewer = maximise(problem, fewer, Effort::some(settings.rounds));
        match fewer.filter(|(_, there)| there.evidence() - local.evidence() < worse) {
            Some(without) => {
                (point, local) = without;
                *known -= usize::from(number < *known);
                let place = number + usize::from(gusts.is_some_and(|gusts| gusts <= number));
                if place < rivals.len() {
                    rivals.remove(place);
                }
            }
            None => number += 1,
        }
    }
    (point, local)
}

/// Tests every cause but the newest again, with all others in place: its rivals are those of then, and where one of them is
/// likelier it stands instead. The first `stand` are left alone, and what was `known` beforehand has to be beaten by more.
pub(crate) fn retest(
    problem: &DiagnosisProblem,
    (mut point, mut local): (ParameterSet, Linearisation),
    rivals: &mut Vec<Vec<Rival>>,
    (stand, mut known): (usize, usize),
    settings: &SearchSettings,
) -> (ParameterSet, Linearisation) {
    for _ in 0..SWEEPS {
        let (mut number, mut changed) = (stand, false);
        for _ in stand..point.hypotheses.len().saturating_sub(newest(rivals)) {
            let place = number + usize::from(place_of_gusts(rivals).is_some_and(|gusts| gusts <= number));
            let more = if number < known { KNOWN_STANDS } else { 0.0 };
            match replacement(problem, (&point, &local), number, more, settings) {
                Some((Some(better), ranked)) => {
                    (point, local) = better;
                    if place < rivals.len() {
                        rivals.remove(place);
                    }
                    rivals.push(ranked);
                    // What comes after it has moved up.
                    known -= usize::from(number < known);
                    changed = true;
                }
                Some((None, ranked)) => {
                    if let Some(own) = rivals.get_mut(place) {
                        *own = ranked;
                    }
                    number += 1;
                }
                None => number += 1,
            }
        }
        if !changed {
            break;
        }
        // What stood beside a cause that has given way may have been what that one left.
        (point, local) = drop_redundant(problem, (point, local), rivals, (stand, &mut known), settings);
    }
    (point, local)
}

/// What else stands in the place of a hypothesis, and where that is likelier by so much more the point with it. `None` where the
/// search does not come upon the hypothesis again, nor upon anything that is better by what is asked of a cause.
fn replacement(
    problem: &DiagnosisProblem,
    (point, local): (&ParameterSet, &Linearisation),
    number: usize,
    more: f64,
    settings: &SearchSettings,
) -> Option<NextCause> {
    let own = point.hypotheses.get(number)?.effect;
    let mut without = point.clone();
    without.hypotheses.remove(number);
    let (without, there) = maximise(problem, without, Effort::some(settings.rounds))?;
    settings.plan(1);
    let (taken, ranked) = next_cause(problem, &without, &there, settings)?;
    let (taken, first) = taken.zip(ranked.first().copied())?;
    if same_cause(&first.effect, &own) {
        return Some((None, ranked));
    }
    let again = ranked.iter().any(|rival| rival.fitted && same_cause(&rival.effect, &own));
    let better = if again { more } else { settings.odds_against.max(more) };
    (taken.1.evidence() + better < local.evidence()).then_some((Some(taken), ranked))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::flight::channel::Channel;
    use crate::flight::effect::PositionedSensor;
    use crate::postflight::diagnosis::likelihood::likelihood_tests::problem_with;
    use crate::postflight::diagnosis::likelihood::parameter_set::Hypothesis;

    /// Both vanes late: their place was found first, then what it leaves of one of them.
    #[test]
    fn what_stood_for_two_causes_gives_way() {
        let late = |channel| Effect::SensorDelay { channel, delay: 0.08 };
        let problem = problem_with(vec![late(Channel::Alpha), late(Channel::Beta)]);
        let ahead = Effect::SensorPosition { sensor: PositionedSensor::Vane, offset_m: [1.0, 0.0, 0.0] };
        let mut point = problem.null_hypothesis();
        point.hypotheses = vec![Hypothesis::of(ahead, 5.0), Hypothesis::of(late(Channel::Beta), 0.2)];
        let found = maximise(&problem, point, Effort::SETTLED).unwrap();
        let rival = |effect| vec![Rival { effect, std: 0.1, odds: 30.0, fitted: true }];
        let mut rivals = vec![rival(ahead), rival(late(Channel::Beta))];
        let (point, local) = retest(&problem, found, &mut rivals, (0, 0), &SearchSettings::default());
        let effects: Vec<Effect> = point.effects().collect();
        assert_eq!(effects.len(), 2);
        for (place, channel) in [Channel::Beta, Channel::Alpha].into_iter().enumerate() {
            let (Effect::SensorDelay { channel: there, delay: found } | Effect::SensorLag { channel: there, tau: found }) =
                effects[place]
            else {
                panic!("{:?} stands in the place of {channel:?}", effects[place]);
            };
            let std = local.std(point.main_place_of(place));
            assert_eq!(there, channel);
            assert!((found - 0.08).abs() < 3.0 * std && std < 0.02, "{channel:?}: {found} +- {std}");
            assert!(same_cause(&rivals[place][0].effect, &effects[place]), "{:?}", rivals[place]);
        }
    }
}
