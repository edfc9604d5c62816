//! The library: every effect that could be the cause, as the data carry it.
//!
//! Consumes the runs; produces candidates of every kind for every axis, control and channel that is there. An effect that is
//! not small in any number (rate limit, dead zone) or whose shape changes with it (lag, delay) stands there several
//! times, once for each of a few sizes; its column is then what that size changes, and the number it is weighed by a share.

use crate::flight::channel::Channel;
use crate::flight::control::Control;
use crate::flight::derivative::{Axis, Variable};
use crate::flight::effect::{Effect, PositionedSensor, same_cause};
use crate::flight::term::Term;
use crate::postflight::diagnosis::data::blade_input::BladeInput;
use crate::postflight::diagnosis::data::run_data::{OUTPUT_CHANNELS, ROTOR, input_channel};
use crate::postflight::diagnosis::likelihood::normal_equations::CandidateParameter;
use crate::postflight::diagnosis::likelihood::parameter::ParameterKind;
use crate::postflight::diagnosis::likelihood::parameter::parameter_kind;
use crate::postflight::diagnosis::likelihood::parameter::{moves_blades, output_of, with_number_changed};
use crate::postflight::diagnosis::likelihood::problem::DiagnosisProblem;

/// Standard errors that a rate limit must be from nothing, where it would cut the control off.
const SURE: f64 = 2.5;

/// Least half width of a dead zone, of the control's noise.
const BELOW_NOISE: f64 = 4.0;

/// An entry of the library.
#[derive(Clone, Debug)]
pub struct LibraryEntry {
    /// The effect, with the number that a share of one stands for; a unit where it is linear.
    pub effect: Effect,
    /// Its column.
    pub candidate: CandidateParameter,
    /// Component of a position.
    pub component: usize,
    /// Whether its number is a share of the effect's.
    pub fixed_size: bool,
    /// Standard deviation of its number; `None` where that follows from the axis's forces.
    pub prior_std: Option<f64>,
}

/// Sizes of a lag and of a delay, s.
const LAGS_S: [f64; 2] = [0.06, 0.25];
const DELAYS_S: [f64; 2] = [0.06, 0.2];
/// Rates as parts of the control's range a second, and half widths as parts of the range.
const RATES: [f64; 5] = [0.3, 0.7, 1.5, 3.0, 6.0];
const WIDTHS: [f64; 4] = [0.08, 0.2, 0.4, 0.7];
/// Least half range of a control that was moved, rad: a position transducer is known to 0.1 to 0.2 degrees.
const MOVED_RAD: f64 = 0.0025;
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
/// nothing else, or a dead zone as narrow as that; or a rate limit so low that it is not separable from a disconnected control.
pub(crate) fn below_noise(problem: &DiagnosisProblem, effect: &Effect, std: f64) -> bool {
    let is_noise = |control: Control| {
        let (place, trim) = (control.index(), problem.aircraft.trim());
        !problem.runs.iter().any(|run| {
            let taken = BladeInput::of(run, trim, &[*effect]).difference(&BladeInput::of(run, trim, &[]), 1.0);
            let power: f64 = taken.nodes.iter().map(|moved| moved[place] * moved[place]).sum();
            power > TAKEN * run.input_noise[place] * run.input_noise[place] * taken.nodes.len() as f64
        })
    };
    match *effect {
        Effect::DeadZone { control, half_width } => {
            let noise = problem.runs.iter().filter_map(|run| run.input_noise.get(control.index())).copied().fold(0.0, f64::max);
            half_width < BELOW_NOISE * noise || is_noise(control)
        }
        Effect::RateLimit { control, rate } => rate < SURE * std || is_noise(control),
        Effect::ActuatorLag { control, .. } | Effect::TransportDelay { control, .. } => is_noise(control),
        _ => false,
    }
}

/// Every effect that the data carry, with the effects that are in the model already.
pub fn hypotheses(problem: &DiagnosisProblem, present: &[Effect]) -> Vec<LibraryEntry> {
    let mut entries = Vec::new();
    let mut plain = |effect: Effect, component: usize| entries.push(plain_entry(effect, component));
    let moved: Vec<Control> = Control::ALL.into_iter().filter(|control| range(problem, control.index()) > 0.0).collect();
    let rotor_moves = problem.has_input(ROTOR) && range(problem, ROTOR) > 0.0;
    for axis in Axis::ALL.into_iter().filter(|axis| !problem.unmodelled[axis.index()]) {
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
    if rotor_moves && !problem.unmodelled[Axis::N.index()] && !problem.aircraft.is_governed() {
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
        // Heading and height are relative to the start of a run.
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
            fixed_size_entry(problem, present, Effect::ActuatorLag { control, tau }, &mut entries);
        }
        for delay in DELAYS_S {
            fixed_size_entry(problem, present, Effect::TransportDelay { control, delay }, &mut entries);
        }
        for rate in RATES {
            fixed_size_entry(problem, present, Effect::RateLimit { control, rate: rate * range }, &mut entries);
        }
        for width in WIDTHS {
            fixed_size_entry(problem, present, Effect::DeadZone { control, half_width: width * range }, &mut entries);
        }
        for &to in &acting_controls(problem) {
            if to != control {
                linear_entry(problem, present, Effect::CrossFeed { from: control, to, gain: 0.0 }, &mut entries);
            }
        }
    }
    for input in 0..=ROTOR {
        if !problem.has_input(input) || (input == ROTOR && !rotor_moves) {
            continue;
        }
        let channel = input_channel(input);
        // A control's bias is a difference of trim, and its factor about the trim its effectiveness.
        if input == ROTOR {
            linear_entry(problem, present, Effect::SensorScale { channel, factor: 1.0 }, &mut entries);
        }
        linear_entry(problem, present, Effect::SensorDelay { channel, delay: 0.0 }, &mut entries);
    }
    entries.retain(|entry| !present.iter().any(|there| same_cause(there, &entry.effect)));
    entries
}

/// What a simulation has of second order in sideways motion, and another aircraft may have otherwise: by its symmetry squares in
/// the plane of symmetry, and out of it what turns its sign.
pub fn curvature(problem: &DiagnosisProblem, present: &[Effect]) -> Vec<LibraryEntry> {
    let (v, p, r) = (Variable::V, Variable::P, Variable::R);
    let axes = Axis::ALL.into_iter().filter(|axis| !problem.unmodelled[axis.index()]);
    let terms = |axis: Axis| match axis {
        Axis::X | Axis::Z | Axis::M => [v, p, r].map(|x| Term::Product(x, x)),
        _ => [Term::SignedSquare(v), Term::Product(v, v), Term::Cube(v)],
    };
    let effects = axes.flat_map(|axis| terms(axis).map(|term| Effect::Nonlinear { axis, term, coefficient: 0.0 }));
    let new = |effect: &Effect| !present.iter().any(|there| same_cause(there, effect));
    effects.filter(new).map(|effect| plain_entry(effect, 0)).collect()
}

/// An entry that does not change what reaches the blades.
pub(crate) fn plain_entry(effect: Effect, component: usize) -> LibraryEntry {
    let candidate = CandidateParameter { column: parameter_kind(&effect, component), blade_input_changes: Vec::new() };
    LibraryEntry { effect, candidate, component, fixed_size: false, prior_std: prior_std(&effect) }
}

/// Controls that act on anything.
fn acting_controls(problem: &DiagnosisProblem) -> Vec<Control> {
    let acts =
        |control: &Control| Axis::ALL.iter().any(|&axis| problem.aircraft.linear.derivative(axis, control.variable()) != 0.0);
    Control::ALL.into_iter().filter(acts).collect()
}

/// Half of what a control moves through, its noise left out; nothing where it stands still, or moves no more than a surface does
/// that nobody moves: what is wrong with the motion is found in a trace of any shape.
fn range(problem: &DiagnosisProblem, place: usize) -> f64 {
    let mut most = 0.0f64;
    for run in &problem.runs {
        let Some(series) = run.inputs.get(place).and_then(Option::as_ref) else { continue };
        let mut values: Vec<f64> = series.samples().map(|(_, value)| value).collect();
        values.sort_by(f64::total_cmp);
        let at = |part: f64| values.get((part * (values.len().saturating_sub(1)) as f64) as usize).copied().unwrap_or(0.0);
        let span = 0.5 * (at(0.98) - at(0.02));
        if span > MOVED_RAD.max(4.0 * run.input_noise[place]) {
            most = most.max(span);
        }
    }
    most
}

/// An effect at one size: its column is what that changes.
fn fixed_size_entry(problem: &DiagnosisProblem, present: &[Effect], effect: Effect, entries: &mut Vec<LibraryEntry>) {
    let mut with = present.to_vec();
    with.push(effect);
    let trim = problem.aircraft.trim();
    let difference = |run| BladeInput::of(run, trim, &with).difference(&BladeInput::of(run, trim, present), 1.0);
    let moved: Vec<_> = problem.runs.iter().map(difference).collect();
    if moved.iter().any(BladeInput::moves) {
        let candidate = CandidateParameter { column: ParameterKind::BladeInput(0), blade_input_changes: moved };
        entries.push(LibraryEntry { effect, candidate, component: 0, fixed_size: true, prior_std: Some(SHARE_STD) });
    }
}

/// An effect on what reaches the blades that is linear in its number.
fn linear_entry(problem: &DiagnosisProblem, present: &[Effect], effect: Effect, entries: &mut Vec<LibraryEntry>) {
    debug_assert!(moves_blades(&effect) && output_of(&effect).is_none());
    let mut with = present.to_vec();
    with.push(effect);
    let moved = problem.blade_input_slope(&with, present.len());
    if moved.iter().any(BladeInput::moves) {
        let candidate = CandidateParameter { column: ParameterKind::BladeInput(0), blade_input_changes: moved };
        entries.push(LibraryEntry { effect, candidate, component: 0, fixed_size: false, prior_std: prior_std(&effect) });
    }
}

/// Standard deviation that an entry's number has beforehand where a fit begins at this effect; `scored` is that of its score
/// test.
pub(crate) fn fit_prior_std(entry: &LibraryEntry, effect: &Effect, scored: f64) -> f64 {
    entry.prior_std.filter(|_| !entry.fixed_size).or(prior_std(effect)).unwrap_or(match *effect {
        Effect::RateLimit { rate: number, .. } | Effect::DeadZone { half_width: number, .. } => number,
        _ => scored,
    })
}

/// Whether an effect acts by when things happen.
pub(crate) fn is_timing(effect: &Effect) -> bool {
    matches!(
        effect,
        Effect::SensorLag { .. } | Effect::SensorDelay { .. } | Effect::ActuatorLag { .. } | Effect::TransportDelay { .. }
    )
}

/// The effect that an entry stands for at this size.
pub(crate) fn effect_at_estimate(entry: &LibraryEntry, size: f64) -> Effect {
    let size = match entry.effect {
        _ if entry.fixed_size => return entry.effect,
        // A factor stays positive.
        Effect::SensorScale { .. } | Effect::ControlEffectiveness { .. } => size.max(-0.9),
        Effect::SensorPosition { sensor, mut offset_m } => {
            if let Some(offset) = offset_m.get_mut(entry.component) {
                *offset = size;
            }
            return Effect::SensorPosition { sensor, offset_m };
        }
        _ => size,
    };
    with_number_changed(&entry.effect, size)
}

/// Where fits of an entry begin: what delays may also be a lag, where there is none yet.
pub(crate) fn starts(entry: &LibraryEntry, size: f64, lagging: bool) -> Vec<Effect> {
    let effect = effect_at_estimate(entry, size);
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
            let tau = (tau * size.clamp(0.2, 3.0)).max(0.01);
            vec![Effect::ActuatorLag { control, tau }]
        }
        Effect::TransportDelay { control, delay } => {
            vec![Effect::TransportDelay { control, delay: (delay * size.clamp(0.2, 3.0)).max(0.01) }]
        }
        _ => vec![effect],
    }
}
