//! Channels and controls recorded with the sign turned, the commonest fault there is, or under each other's name: no small change
//! of a number leads there.
//!
//! Consumes how a problem is posed with effects in the model; produces factors of -1 (`sensor_scale` of a channel,
//! `control_effectiveness` of a control) and `exchanged` pairs, each with twice the logarithm of its odds. Tried are the
//! [`TRIED`] with which the cost of the model falls most, by [`FALLS`] at least, noise of forces and offsets as they begin: what
//! else is wrong, such as the place of an accelerometer, lets several channels that see it seem turned there. Taken is the first
//! with which, noise and offsets free,
//!     E_0 - E_1 > FALLS     R_1 < PART (R_0 + E_0 - E_1)                                               (1)
//! E of `problem` (2) without and with it, R the cost that noise of forces beyond its floor saves: such a fault explains most of
//! what is wrong. In no run may the cost rise by FALLS. The search begins again with it in the model, up to
//! [`MOST`]. Two that act on the same motion, such as vane and gyro of yaw, are not found: neither mends much without the other.

use super::forward_search::SearchResult;
use super::hypotheses::{plain_entry, prior_std};
use super::next_cause::usual_forces;
use super::score_test::score_test;
use crate::flight::channel::Channel;
use crate::flight::control::Control;
use crate::flight::effect::Effect;
use crate::postflight::diagnosis::data::run_data::OUTPUT_CHANNELS;
use crate::postflight::diagnosis::likelihood::adequacy::unexplained;
use crate::postflight::diagnosis::likelihood::maximise::{Effort, maximise};
use crate::postflight::diagnosis::likelihood::normal_equations::{Detail, linearise};
use crate::postflight::diagnosis::likelihood::parameter_set::ParameterSet;
use crate::postflight::diagnosis::likelihood::problem::DiagnosisProblem;
use crate::postflight::recorded_run::RecordedRun;

/// Least that cost and evidence fall by.
const FALLS: f64 = 100.0;
/// How many are tried.
const TRIED: usize = 8;
/// Most of what is wrong that it leaves, as a part.
const PART: f64 = 0.5;
/// Most that are looked for.
const MOST: usize = 2;

/// A channel or control of turned sign, or an exchanged pair.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct RecordingFault {
    /// With the factor -1 where it has one.
    pub(crate) effect: Effect,
    /// Twice the logarithm of its odds.
    pub(crate) odds: f64,
}

/// Those of a set of runs; `pose` is given the effects that are in the model.
pub(crate) fn recording_faults(pose: &impl Fn(&[Effect]) -> DiagnosisProblem) -> Vec<RecordingFault> {
    let mut faults: Vec<RecordingFault> = Vec::new();
    while faults.len() < MOST {
        let known: Vec<Effect> = faults.iter().map(|one| one.effect).collect();
        let Some(next) = next_fault(pose, &known) else { break };
        faults.push(next);
    }
    faults
}

fn next_fault(pose: &impl Fn(&[Effect]) -> DiagnosisProblem, known: &[Effect]) -> Option<RecordingFault> {
    let with = |effect: Effect| pose(&[known, &[effect]].concat());
    let cost = |problem: &DiagnosisProblem| {
        linearise(problem, &problem.null_hypothesis(), &[], Detail::Cost).map_or(f64::INFINITY, |local| local.cost)
    };
    let problem = pose(known);
    let begin = cost(&problem);
    let others = candidates(&problem).into_iter().filter(|effect| !known.contains(effect));
    let mut tried: Vec<(f64, Effect, DiagnosisProblem)> = others
        .map(|effect| (effect, with(effect)))
        .map(|(effect, mended)| (cost(&mended), effect, mended))
        .filter(|(cost, ..)| *cost < begin - FALLS)
        .collect();
    tried.sort_by(|(one, ..), (other, ..)| one.total_cmp(other));
    tried.truncate(TRIED);
    if tried.is_empty() {
        return None;
    }
    let (point, before) = maximise(&problem, problem.null_hypothesis(), Effort::SETTLED)?;
    let left = |problem: &DiagnosisProblem, point: &ParameterSet| Some(unexplained(problem, point)?.iter().sum::<f64>());
    let as_recorded = left(&problem, &point)?;
    tried.into_iter().find_map(|(_, effect, mended)| {
        let (there, after) = maximise(&mended, mended.null_hypothesis(), Effort::SETTLED)?;
        let odds = before.evidence() - after.evidence();
        // What one run has and another has not is no fault of the recording of all.
        let rises = after.runs.len() > 1
            && after.runs.iter().zip(&before.runs).any(|(mended, recorded)| mended.cost > recorded.cost + FALLS);
        let is_taken = odds > FALLS && !rises && left(&mended, &there)? < PART * (as_recorded + odds);
        is_taken.then_some(RecordingFault { effect, odds })
    })
}

/// What can be turned (a speed and a height above the ground have no sign) or exchanged: channels of one quantity.
fn candidates(problem: &DiagnosisProblem) -> Vec<Effect> {
    let recorded = |output: usize| problem.runs.iter().any(|run| run.outputs.get(output).is_some_and(Option::is_some));
    let signed = OUTPUT_CHANNELS.into_iter().enumerate().filter(|(output, _)| recorded(*output)).map(|(_, channel)| channel);
    let channels: Vec<Channel> = signed.filter(|channel| !matches!(channel, Channel::Tas | Channel::Altitude)).collect();
    let moves = |control: &Control| problem.runs.iter().any(|run| run.moves(control.index()));
    let controls: Vec<Control> = Control::ALL.into_iter().filter(moves).collect();
    let of_control: Vec<Channel> = controls.iter().map(|control| control.channel()).collect();
    let turned = channels.iter().map(|&channel| Effect::SensorScale { channel, factor: -1.0 });
    let reversed = controls.iter().map(|&control| Effect::ControlEffectiveness { control, factor: -1.0 });
    turned.chain(reversed).chain(pairs(&channels)).chain(pairs(&of_control)).collect()
}

/// Every two of one quantity.
fn pairs(channels: &[Channel]) -> Vec<Effect> {
    let two = |(place, &one): (usize, &Channel)| {
        let others = channels.get(place + 1..).unwrap_or_default().iter().filter(move |other| other.quantity() == one.quantity());
        others.map(move |&other| Effect::Exchanged { channels: [one, other] }).collect::<Vec<Effect>>()
    };
    channels.iter().enumerate().flat_map(two).collect()
}

/// Standard error of the factor where the search ended; `None` of a fault without.
pub(crate) fn factor_std(problem: &DiagnosisProblem, searched: &SearchResult, effect: &Effect) -> Option<f64> {
    let neutral = match *effect {
        Effect::SensorScale { channel, .. } => Effect::SensorScale { channel, factor: 1.0 },
        Effect::ControlEffectiveness { control, .. } => Effect::ControlEffectiveness { control, factor: 1.0 },
        _ => return None,
    };
    let entry = plain_entry(neutral, 0);
    let wide = linearise(problem, &searched.point, &[&entry.candidate], Detail::Slopes)?;
    let score = score_test(&wide, &[entry], &usual_forces(problem)).first().copied();
    score.map(|score| score.std).or(prior_std(&neutral))
}

/// Of each fault of the recording the part of the error that mending it takes away, in the channel where that is most; from the
/// errors by channel with none, one, two ... of them mended. All of it where only mending makes the model follow the runs.
pub(crate) fn shares_of_faults(errors: &[Vec<(Channel, f64)>]) -> Vec<f64> {
    let of =
        |errors: &[(Channel, f64)], channel: Channel| errors.iter().find(|(other, _)| *other == channel).map(|(_, error)| *error);
    let Some(first) = errors.iter().find(|one| !one.is_empty()) else { return vec![0.0; errors.len().saturating_sub(1)] };
    let share = |two: &[Vec<(Channel, f64)>]| {
        let [before, after] = two else { return 0.0 };
        if before.is_empty() {
            return if after.is_empty() { 0.0 } else { 1.0 };
        }
        let parts = first.iter().filter_map(|&(channel, all)| Some((of(before, channel)? - of(after, channel)?) / all));
        parts.fold(0.0, f64::max).min(1.0)
    };
    errors.windows(2).map(share).collect()
}

/// The runs as they should have been recorded.
pub(crate) fn as_it_should_be_recorded(runs: &[RecordedRun], faults: &[RecordingFault]) -> Vec<RecordedRun> {
    let mut runs = runs.to_vec();
    for sample in runs.iter_mut().flat_map(|run| &mut run.samples) {
        for fault in faults.iter().rev() {
            match fault.effect {
                Effect::SensorScale { channel, .. } => {
                    if let Some(value) = sample.get(channel) {
                        sample.set(channel, -value);
                    }
                }
                Effect::Exchanged { channels: [one, other] } => {
                    let values = [(one, sample.get(other)), (other, sample.get(one))];
                    for (channel, value) in values {
                        match value {
                            Some(value) => sample.set(channel, value),
                            None => sample.clear(channel),
                        }
                    }
                }
                _ => {}
            }
        }
    }
    runs
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::flight::derivative::{AXES, Axis, VARIABLES, Variable};
    use crate::flight::effect::PositionedSensor;
    use crate::flight::run::RunGeometry;
    use crate::postflight::diagnosis::data::run_data::RunData;
    use crate::postflight::diagnosis::likelihood::aircraft::Aircraft;
    use crate::postflight::diagnosis::likelihood::likelihood_tests::flown;

    /// What is found in a flight with these effects, of the model without them.
    fn found(effects: &[Effect]) -> Vec<Effect> {
        let (model, samples) = flown(effects.to_vec());
        let run = RunData::of("one", &samples, RunGeometry::DEFAULT).unwrap();
        let pose = |effects: &[Effect]| {
            let stds = [[0.0; VARIABLES]; AXES];
            DiagnosisProblem::new(Aircraft::of(&model), effects.to_vec(), vec![run.clone()], 0.03, &stds)
        };
        recording_faults(&pose).iter().map(|fault| fault.effect).collect()
    }

    #[test]
    fn turned_signs_and_exchanged_channels_are_found() {
        use Channel::{Ax, Ay, Az, P, Phi, Psi, Q, R, Theta};
        let turned = [Ax, Ay, Az, P, Q, R, Phi, Theta, Psi, Channel::Alpha, Channel::Beta];
        let turned = turned.map(|channel| Effect::SensorScale { channel, factor: -1.0 });
        let reversed = [Control::Pedal, Control::LonCyclic].map(|control| Effect::ControlEffectiveness { control, factor: -1.0 });
        let pairs =
            [[P, R], [Q, R], [Ay, Az], [Phi, Theta], [Channel::Alpha, Channel::Beta], [Channel::LonCyclic, Channel::Pedal]];
        let exchanged = pairs.map(|channels| Effect::Exchanged { channels });
        for effect in turned.into_iter().chain(reversed).chain(exchanged) {
            assert_eq!(found(&[effect]), [effect]);
        }
        for both in [[Phi, Theta], [Channel::Beta, Channel::Alpha], [R, Theta], [Q, Az]] {
            let both = both.map(|channel| Effect::SensorScale { channel, factor: -1.0 });
            let twice = found(&both);
            assert!(twice.len() == 2 && both.iter().all(|one| twice.contains(one)), "{twice:?}");
        }
    }

    /// A lateral accelerometer that the model is far from lets ay and beta seem turned before noise and offsets settle.
    #[test]
    fn a_turned_control_is_found_beside_a_large_error_of_the_side_force() {
        let reversed = Effect::ControlEffectiveness { control: Control::Pedal, factor: -1.0 };
        let derivative = Effect::Derivative { axis: Axis::Y, variable: Variable::V, delta: 0.1 };
        let elsewhere = Effect::SensorPosition { sensor: PositionedSensor::Accelerometer, offset_m: [-12.0, 1.0, 1.0] };
        for besides in [vec![derivative], vec![elsewhere], vec![derivative, elsewhere]] {
            assert_eq!(found(&[&[reversed], &besides[..]].concat()), [reversed], "{besides:?}");
            assert_eq!(found(&besides), [], "{besides:?}");
        }
    }

    /// What is wrong otherwise is no turned sign.
    #[test]
    fn other_faults_are_none_of_these() {
        assert_eq!(found(&[]), []);
        for factor in [0.3, 0.7, 1.5, 3.0] {
            for channel in [Channel::P, Channel::Phi, Channel::Beta, Channel::Ay] {
                assert_eq!(found(&[Effect::SensorScale { channel, factor }]), [], "{channel:?} {factor}");
            }
            assert_eq!(found(&[Effect::ControlEffectiveness { control: Control::Pedal, factor }]), [], "pedal {factor}");
        }
        let late = Effect::SensorDelay { channel: Channel::R, delay: 0.3 };
        let gusts = Effect::Turbulence { sigma: 1.0, length: 300.0 };
        let biased = Effect::SensorBias { channel: Channel::Beta, value: 0.2 };
        for effect in [late, gusts, biased, Effect::ActuatorLag { control: Control::Pedal, tau: 0.6 }] {
            assert_eq!(found(&[effect]), [], "{effect:?}");
        }
    }

    #[test]
    fn a_faults_share_is_what_mending_it_takes_away() {
        let errors = |p: f64, r: f64| vec![(Channel::P, p), (Channel::R, r)];
        assert_eq!(shares_of_faults(&[errors(100.0, 10.0), errors(20.0, 8.0), errors(25.0, 1.0)]), [0.8, 0.7]);
        assert_eq!(shares_of_faults(&[Vec::new(), errors(20.0, 8.0), errors(20.0, 2.0)]), [1.0, 0.75]);
        assert_eq!(shares_of_faults(&[errors(10.0, 10.0), errors(12.0, 11.0)]), [0.0]);
    }
}
