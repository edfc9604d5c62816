//! Channels and controls recorded with the sign turned, the commonest fault there is: no small change of a number leads to it.
//!
//! Consumes how a problem is posed with effects in the model; produces the factors of -1 (`sensor_scale` of a channel,
//! `control_effectiveness` of a control), each with twice the logarithm of its odds. Tried is the one with the least
//!     C = cost of the model with it, noise of forces and offsets as they begin                          (1)
//! where that falls by [`FALLS`]; it is taken where with noise and offsets free
//!     E_0 - E_1 > FALLS     R_1 < PART (R_0 + E_0 - E_1)                                               (2)
//! E of `problem` (2) without and with it, R the cost that noise of forces beyond its floor saves: what is turned explains most
//! of what is wrong. The search begins again with it in the model, up to [`MOST`].

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

/// Least that (1) and the evidence fall by.
const FALLS: f64 = 100.0;
/// Most of what is wrong that it leaves, as a part.
const PART: f64 = 0.5;
/// Most that are looked for.
const MOST: usize = 2;

/// A channel or control of turned sign.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct TurnedSign {
    /// With the factor -1.
    pub(crate) effect: Effect,
    /// Twice the logarithm of its odds.
    pub(crate) odds: f64,
}

/// Those of a set of runs; `pose` is given the effects that are in the model.
pub(crate) fn turned_signs(pose: &impl Fn(&[Effect]) -> DiagnosisProblem) -> Vec<TurnedSign> {
    let mut turned: Vec<TurnedSign> = Vec::new();
    while turned.len() < MOST {
        let known: Vec<Effect> = turned.iter().map(|one| one.effect).collect();
        let Some(next) = next_turned(pose, &known) else { break };
        turned.push(next);
    }
    turned
}

fn next_turned(pose: &impl Fn(&[Effect]) -> DiagnosisProblem, known: &[Effect]) -> Option<TurnedSign> {
    let with = |effect: Effect| pose(&[known, &[effect]].concat());
    let cost = |problem: &DiagnosisProblem| {
        linearise(problem, &problem.null_hypothesis(), &[], Detail::Cost).map_or(f64::INFINITY, |local| local.cost)
    };
    let problem = pose(known);
    let cost_as_recorded = cost(&problem);
    let tried = candidates(&problem).into_iter().filter(|effect| !known.contains(effect));
    let (effect, least) = tried.map(|effect| (effect, cost(&with(effect)))).min_by(|(_, a), (_, b)| a.total_cmp(b))?;
    if !(least < cost_as_recorded - FALLS) {
        return None;
    }
    let turned = with(effect);
    let (point, before) = maximise(&problem, problem.null_hypothesis(), Effort::SETTLED)?;
    let (turned_point, after) = maximise(&turned, turned.null_hypothesis(), Effort::SETTLED)?;
    let odds = before.evidence() - after.evidence();
    let left = |problem: &DiagnosisProblem, point: &ParameterSet| Some(unexplained(problem, point)?.iter().sum::<f64>());
    let (as_recorded, as_turned) = (left(&problem, &point)?, left(&turned, &turned_point)?);
    (odds > FALLS && as_turned < PART * (as_recorded + odds)).then_some(TurnedSign { effect, odds })
}

/// What can be turned: a speed and a height above the ground have no sign.
fn candidates(problem: &DiagnosisProblem) -> Vec<Effect> {
    let recorded = |output: usize| problem.runs.iter().any(|run| run.outputs.get(output).is_some_and(Option::is_some));
    let channels = OUTPUT_CHANNELS
        .into_iter()
        .enumerate()
        .filter(|(output, channel)| recorded(*output) && !matches!(channel, Channel::Tas | Channel::Altitude));
    let moves = |control: &Control| problem.runs.iter().any(|run| run.moves(control.index()));
    let controls = Control::ALL.into_iter().filter(moves);
    channels
        .map(|(_, channel)| Effect::SensorScale { channel, factor: -1.0 })
        .chain(controls.map(|control| Effect::ControlEffectiveness { control, factor: -1.0 }))
        .collect()
}

/// Standard error of the factor where the search ended.
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

/// The runs with those channels as they should have been recorded.
pub(crate) fn in_right_sign(runs: &[RecordedRun], turned: &[TurnedSign]) -> Vec<RecordedRun> {
    let mut runs = runs.to_vec();
    for channel in turned.iter().filter_map(|one| one.effect.sensor_channel()) {
        for sample in runs.iter_mut().flat_map(|run| &mut run.samples) {
            if let Some(value) = sample.get(channel) {
                sample.set(channel, -value);
            }
        }
    }
    runs
}
