//! The library: every effect that could be the cause, as the data carry it.
//!
//! Consumes the runs; produces candidates of every kind for every axis, control and channel that is there. An effect that is
//! not small in any number (rate limit, dead zone) or whose shape changes with it (lag, delay) stands there several
//! times, once for each of a few sizes; its column is then what that size changes, and the number it is weighed by a share.

use super::column::Column;
use super::driven::Driven;
use super::linearise::Candidate;
use super::point::{moves_blades, output_of};
use super::problem::Problem;
use super::run_record::{OUTPUT_CHANNELS, ROTOR, input_channel};
use crate::flight::channel::Channel;
use crate::flight::control::Control;
use crate::flight::derivative::{Axis, Variable};
use crate::flight::effect::{Effect, PositionedSensor, same_cause};
use crate::flight::term::Term;

/// Standard errors that a rate limit must be from nothing, where it would cut the control off.
const SURE: f64 = 2.5;

/// Least half width of a dead zone, of the control's noise.
const DROWNED: f64 = 4.0;

/// An entry of the library.
#[derive(Clone, Debug)]
pub struct Entry {
    /// The effect, with the number that a share of one stands for; a unit where it is linear.
    pub effect: Effect,
    /// Its column.
    pub candidate: Candidate,
    /// Component of a position.
    pub component: usize,
    /// Whether its number is a share of the effect's.
    pub shared: bool,
    /// Standard deviation of its number; `None` where that follows from the axis's forces.
    pub prior_std: Option<f64>,
}

/// Sizes of a lag and of a delay, s.
const LAGS_S: [f64; 2] = [0.06, 0.25];
const DELAYS_S: [f64; 2] = [0.06, 0.2];
/// Rates as parts of the control's range a second, and half widths as parts of the range.
const RATES: [f64; 5] = [0.3, 0.7, 1.5, 3.0, 6.0];
const WIDTHS: [f64; 4] = [0.08, 0.2, 0.4, 0.7];
/// Power of what a lag takes from a control, of its noise's, below which it may be that noise: a mean over a step has two thirds
/// of it or less.
const TAKEN: f64 = 3.0;
/// Standard deviation of a share.
const SHARE_STD: f64 = 1.0;

/// Standard deviation that a number has beforehand, of the kinds whose unit says it.
pub fn prior_std(effect: &Effect) -> Option<f64> {
    Some(match effect {
        Effect::ControlEffectiveness { .. } | Effect::RotorReaction { .. } => 0.3,
        Effect::ActuatorLag { .. } | Effect::TransportDelay { .. } => 0.2,
        Effect::CrossFeed { .. } => 0.4,
        Effect::SensorScale { .. } => 0.2,
        Effect::SensorLag { .. } | Effect::SensorDelay { .. } => 0.2,
        Effect::SensorPosition { .. } => 5.0,
        Effect::SensorBias { channel, .. } => match channel {
            Channel::Ax | Channel::Ay | Channel::Az => 0.5,
            Channel::P | Channel::Q | Channel::R => 0.02,
            Channel::Tas => 3.0,
            Channel::Altitude => 20.0,
            Channel::RotorSpeed => 0.5,
            Channel::LonCyclic | Channel::LatCyclic | Channel::Collective | Channel::Pedal => 0.01,
            _ => 0.03,
        },
        _ => return None,
    })
}

/// Whether what an effect takes from a control on its way to the blade is so little that it is the recorded control's noise and
/// nothing else, or a dead zone as narrow as that; or a rate limit so low that it is not told from a control that is cut off.
pub(super) fn drowned(problem: &Problem, effect: &Effect, std: f64) -> bool {
    let is_noise = |control: Control| {
        let (place, trim) = (control.index(), problem.aircraft.trim());
        !problem.runs.iter().any(|run| {
            let taken = Driven::of(run, trim, &[*effect]).less(&Driven::of(run, trim, &[]), 1.0);
            let power: f64 = taken.nodes.iter().map(|moved| moved[place] * moved[place]).sum();
            power > TAKEN * run.input_noise[place] * run.input_noise[place] * taken.nodes.len() as f64
        })
    };
    match *effect {
        Effect::DeadZone { control, half_width } => {
            let noise = problem.runs.iter().filter_map(|run| run.input_noise.get(control.index())).copied().fold(0.0, f64::max);
            half_width < DROWNED * noise || is_noise(control)
        }
        Effect::RateLimit { control, rate } => rate < SURE * std || is_noise(control),
        Effect::ActuatorLag { control, .. } | Effect::TransportDelay { control, .. } => is_noise(control),
        _ => false,
    }
}

/// Every effect that the data carry, with the effects that are in the model already.
pub fn library(problem: &Problem, present: &[Effect]) -> Vec<Entry> {
    let mut entries = Vec::new();
    let mut plain = |effect: Effect, component: usize| entries.push(unmoved(problem, effect, component));
    let moved: Vec<Control> = Control::ALL.into_iter().filter(|control| range(problem, control.index()) > 0.0).collect();
    let rotor_moves = problem.has_input(ROTOR) && range(problem, ROTOR) > 0.0;
    for axis in Axis::ALL.into_iter().filter(|axis| !problem.silent[axis.index()]) {
        for variable in Variable::ALL {
            if !variable.is_control() || moved.iter().any(|control| control.variable() == variable) {
                plain(Effect::Derivative { axis, variable, delta: 0.0 }, 0);
            }
        }
        for term in Term::library() {
            plain(Effect::Nonlinear { axis, term, coefficient: 0.0 }, 0);
        }
        if rotor_moves {
            plain(Effect::RotorSpeed { axis, coefficient: 0.0 }, 0);
        }
    }
    if rotor_moves && !problem.silent[Axis::N.index()] && !problem.aircraft.is_governed() {
        // Whichever way it turns: what it takes of the other moments has the sign of neither.
        for reaction in [f64::MIN_POSITIVE, -f64::MIN_POSITIVE] {
            plain(Effect::RotorReaction { reaction }, 0);
        }
    }
    for &control in &moved {
        plain(Effect::ControlEffectiveness { control, factor: 1.0 }, 0);
    }
    for (output, channel) in OUTPUT_CHANNELS.into_iter().enumerate() {
        if !problem.runs.iter().any(|run| run.outputs[output].is_some()) {
            continue;
        }
        // Heading and height are told from where a run began.
        if !matches!(channel, Channel::Psi | Channel::Altitude) {
            plain(Effect::SensorBias { channel, value: 0.0 }, 0);
        }
        if channel != Channel::Altitude {
            plain(Effect::SensorScale { channel, factor: 1.0 }, 0);
        }
        plain(Effect::SensorDelay { channel, delay: 0.0 }, 0);
    }
    for sensor in PositionedSensor::ALL {
        for component in 0..3 {
            plain(Effect::SensorPosition { sensor, offset_m: [0.0; 3] }, component);
        }
    }
    for &control in &moved {
        let range = range(problem, control.index());
        for tau in LAGS_S {
            shared(problem, present, Effect::ActuatorLag { control, tau }, &mut entries);
        }
        for delay in DELAYS_S {
            shared(problem, present, Effect::TransportDelay { control, delay }, &mut entries);
        }
        for rate in RATES {
            shared(problem, present, Effect::RateLimit { control, rate: rate * range }, &mut entries);
        }
        for width in WIDTHS {
            shared(problem, present, Effect::DeadZone { control, half_width: width * range }, &mut entries);
        }
        for &to in &moved_or_still(problem) {
            if to != control {
                slope(problem, present, Effect::CrossFeed { from: control, to, gain: 0.0 }, &mut entries);
            }
        }
    }
    for input in 0..=ROTOR {
        if !problem.has_input(input) || (input == ROTOR && !rotor_moves) {
            continue;
        }
        let channel = input_channel(input);
        // Off the model's trim a control's bias is what its trim is, and of one that rests a factor is a bias.
        if !problem.other_trim {
            slope(problem, present, Effect::SensorBias { channel, value: 0.0 }, &mut entries);
        }
        if !problem.other_trim || range(problem, input) > 0.0 {
            slope(problem, present, Effect::SensorScale { channel, factor: 1.0 }, &mut entries);
        }
        slope(problem, present, Effect::SensorDelay { channel, delay: 0.0 }, &mut entries);
    }
    entries.retain(|entry| !present.iter().any(|there| same_cause(there, &entry.effect)));
    entries
}

/// What a simulation has of second order in sideways motion, and another aircraft may have otherwise: by its symmetry squares in
/// the plane of symmetry, and out of it what turns its sign.
pub fn curvature(problem: &Problem, present: &[Effect]) -> Vec<Entry> {
    let (v, p, r) = (Variable::V, Variable::P, Variable::R);
    let axes = Axis::ALL.into_iter().filter(|axis| !problem.silent[axis.index()]);
    let terms = |axis: Axis| match axis {
        Axis::X | Axis::Z | Axis::M => [v, p, r].map(|x| Term::Product(x, x)),
        _ => [Term::SignedSquare(v), Term::Product(v, v), Term::Cube(v)],
    };
    let effects = axes.flat_map(|axis| terms(axis).map(|term| Effect::Nonlinear { axis, term, coefficient: 0.0 }));
    let new = |effect: &Effect| !present.iter().any(|there| same_cause(there, effect));
    effects.filter(new).map(|effect| unmoved(problem, effect, 0)).collect()
}

/// An entry that does not change what reaches the blades.
fn unmoved(problem: &Problem, effect: Effect, component: usize) -> Entry {
    let candidate = Candidate { column: problem.column_of(&effect, component), moved: Vec::new() };
    Entry { effect, candidate, component, shared: false, prior_std: prior_std(&effect) }
}

/// Controls that act on anything.
fn moved_or_still(problem: &Problem) -> Vec<Control> {
    let acts =
        |control: &Control| Axis::ALL.iter().any(|&axis| problem.aircraft.linear.derivative(axis, control.variable()) != 0.0);
    Control::ALL.into_iter().filter(acts).collect()
}

/// Half of what a control moves through, its noise left out; nothing where it stands still.
fn range(problem: &Problem, place: usize) -> f64 {
    let mut most = 0.0f64;
    for run in &problem.runs {
        let Some(series) = run.inputs.get(place).and_then(Option::as_ref) else { continue };
        let mut values: Vec<f64> = series.samples().map(|(_, value)| value).collect();
        values.sort_by(f64::total_cmp);
        let at = |part: f64| values.get((part * (values.len().saturating_sub(1)) as f64) as usize).copied().unwrap_or(0.0);
        let span = 0.5 * (at(0.98) - at(0.02));
        if span > 4.0 * run.input_noise[place].max(1e-6) {
            most = most.max(span);
        }
    }
    most
}

/// An effect at one size: its column is what that changes.
fn shared(problem: &Problem, present: &[Effect], effect: Effect, entries: &mut Vec<Entry>) {
    let mut with = present.to_vec();
    with.push(effect);
    let trim = problem.aircraft.trim();
    let difference = |run| Driven::of(run, trim, &with).less(&Driven::of(run, trim, present), 1.0);
    let moved: Vec<_> = problem.runs.iter().map(difference).collect();
    if moved.iter().any(Driven::moves) {
        let candidate = Candidate { column: Column::Moved(0), moved };
        entries.push(Entry { effect, candidate, component: 0, shared: true, prior_std: Some(SHARE_STD) });
    }
}

/// An effect on what reaches the blades that is linear in its number.
fn slope(problem: &Problem, present: &[Effect], effect: Effect, entries: &mut Vec<Entry>) {
    debug_assert!(moves_blades(&effect) && output_of(&effect).is_none());
    let mut with = present.to_vec();
    with.push(effect);
    let moved = problem.slope_of(&with, present.len());
    if moved.iter().any(Driven::moves) {
        let candidate = Candidate { column: Column::Moved(0), moved };
        entries.push(Entry { effect, candidate, component: 0, shared: false, prior_std: prior_std(&effect) });
    }
}
