//! Parameters: how each effect acts on a run of the filter, and what a small change of its number does to forces and readings.
//!
//! Consumes an effect; produces the [`ParameterKind`] of its number, steps and limits of that number, and for each kind the
//! column dF/dtheta of forces and moments by axis at an operating point.

use super::run_model::{OperatingPoint, RunModel};
use crate::flight::channel::Channel;
use crate::flight::derivative::{AXES, Axis, Variable};
use crate::flight::effect::{Effect, PositionedSensor, SensorError};
use crate::flight::term::Term;
use crate::postflight::diagnosis::data::blade_input::{INPUT_LENGTH, InputVector, ROTOR_ACCELERATION};
use crate::postflight::diagnosis::data::run_data::{OUTPUT_CHANNELS, OUTPUTS, ROTOR, RunData};

/// Offsets that each run has for itself: forces and moments, then accelerometers and gyros.
pub const RUN_OFFSETS: usize = AXES + 6;

/// What a parameter acts on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ParameterKind {
    /// A derivative: the variable's deviation on the axis.
    Derivative(Axis, Variable),
    /// A nonlinear term on the axis.
    Term(Axis, Term),
    /// The share of a control that acts; its place.
    Effectiveness(usize),
    /// A change of what reaches the blades, prepared for each run; its place there.
    BladeInput(usize),
    /// The rotor speed's deviation on the axis.
    RotorSpeed(Axis),
    /// The rotor's reaction, of a rotor that turns with or against a positive yaw: the sign of c.
    Reaction(f64),
    /// One on the axis.
    Constant(Axis),
    /// One on an output's reading.
    Bias(usize),
    /// The true value on an output's reading.
    Scale(usize),
    /// Less the rate of change on an output's reading: a skew, and a small lag.
    Timing(usize),
    /// A lag of the one output that has a state of its own.
    Lag,
    /// The place of a sensor along one body axis.
    Place(PositionedSensor, usize),
}

/// The place of a channel among the outputs.
pub fn output_of(effect: &Effect) -> Option<usize> {
    let channel = effect.sensor_channel()?;
    OUTPUT_CHANNELS.iter().position(|&output| output == channel)
}

/// Whether an effect changes what reaches the blades.
pub fn moves_blades(effect: &Effect) -> bool {
    match effect {
        Effect::ActuatorLag { .. }
        | Effect::TransportDelay { .. }
        | Effect::RateLimit { .. }
        | Effect::DeadZone { .. }
        | Effect::CrossFeed { .. } => true,
        _ => effect.sensor_channel().is_some() && output_of(effect).is_none(),
    }
}

/// The parameter kind of an effect that does not change what reaches the blades.
pub fn parameter_kind(effect: &Effect, component: usize) -> ParameterKind {
    match *effect {
        Effect::Derivative { axis, variable, .. } | Effect::FlightPath { axis, variable, .. } => {
            ParameterKind::Derivative(axis, variable)
        }
        Effect::Nonlinear { axis, term, .. } => ParameterKind::Term(axis, term),
        Effect::ControlEffectiveness { control, .. } => ParameterKind::Effectiveness(control.index()),
        Effect::RotorSpeed { axis, .. } => ParameterKind::RotorSpeed(axis),
        Effect::RotorReaction { reaction } => ParameterKind::Reaction(libm::copysign(1.0, reaction)),
        Effect::SensorPosition { sensor, .. } => ParameterKind::Place(sensor, component),
        _ => {
            let output = output_of(effect).unwrap_or(0);
            match effect.sensor_error() {
                Some((_, SensorError::Scale(_))) => ParameterKind::Scale(output),
                Some((_, SensorError::Delay(_))) => ParameterKind::Timing(output),
                Some((_, SensorError::Lag(_))) => ParameterKind::Lag,
                Some((_, SensorError::Bias(_))) | None => ParameterKind::Bias(output),
            }
        }
    }
}

/// The effect with its main number changed by so much.
pub(crate) fn with_number_changed(effect: &Effect, by: f64) -> Effect {
    let mut effect = *effect;
    if let Some(number) = effect.main_number_mut() {
        *number += by;
    }
    effect
}

/// How many numbers of an effect are estimated.
pub(crate) fn components(effect: &Effect) -> usize {
    if matches!(effect, Effect::SensorPosition { .. }) { 3 } else { 1 }
}

/// The number `now + by`, within what one step of a run of this length may reach.
pub(crate) fn within_limits(effect: &Effect, now: f64, by: f64, run_s: f64) -> f64 {
    match effect {
        Effect::ActuatorLag { .. } | Effect::SensorLag { .. } => (now + by).clamp((0.3 * now).max(1e-3), 0.1 * run_s),
        Effect::TransportDelay { .. } => (now + by).clamp(0.0, 0.1 * run_s),
        Effect::SensorDelay { .. } => (now + by).clamp(-0.1 * run_s, 0.1 * run_s),
        Effect::RateLimit { .. } => (now + by).clamp(0.4 * now, 2.5 * now),
        Effect::DeadZone { .. } => (now + by).clamp(0.4 * now, 2.5 * now).max(1e-6),
        Effect::SensorScale { .. } | Effect::ControlEffectiveness { .. } => (now + by).max(0.05),
        _ => now + by,
    }
}

/// Steps up and down of a number for the central difference of what reaches the blades.
pub(crate) fn difference_steps(effect: &Effect, number: f64) -> (f64, f64) {
    let step = (0.02 * libm::fabs(number)).max(match effect {
        Effect::RateLimit { .. } | Effect::DeadZone { .. } => 1e-7,
        _ => 1e-4,
    });
    // A time cannot go below zero: its slope there is one-sided.
    let down = match effect {
        Effect::ActuatorLag { .. } | Effect::TransportDelay { .. } | Effect::SensorLag { .. } => -step.min(number),
        _ => -step,
    };
    (step, down)
}

impl RunModel<'_> {
    /// Axis of a column's force or moment and its value per unit of the parameter, of one that acts on one axis.
    fn one_axis_force(&self, column: ParameterKind, here: &OperatingPoint) -> Option<(usize, f64)> {
        // What is added to N turns the rotor with it.
        let share = |axis: Axis| if axis == Axis::N { self.model.share_of_yaw() } else { 1.0 };
        match column {
            ParameterKind::Derivative(axis, variable) => Some((axis.index(), share(axis) * here.deviations[variable.index()])),
            ParameterKind::Term(axis, term) => Some((axis.index(), share(axis) * term.value(&here.deviations))),
            ParameterKind::RotorSpeed(axis) => Some((axis.index(), share(axis) * here.inputs[ROTOR])),
            ParameterKind::Reaction(sign) => {
                let yaw = Axis::N.index();
                let turned = here.force[yaw] - self.constant[yaw];
                Some((yaw, share(Axis::N) * (here.inputs[ROTOR_ACCELERATION] - sign * turned)))
            }
            ParameterKind::Constant(axis) => Some((axis.index(), 1.0)),
            _ => None,
        }
    }

    /// The same of one that moves all axes.
    fn all_axis_forces(
        &self,
        column: ParameterKind,
        here: &OperatingPoint,
        moved: impl Fn(usize) -> InputVector,
    ) -> Option<[f64; AXES]> {
        match column {
            ParameterKind::Effectiveness(control) => {
                let variable = Variable::CONTROLS.get(control)?.index();
                let moved = here.deviations[variable] / self.model.share(control);
                Some(core::array::from_fn(|axis| here.by[axis][variable] * moved))
            }
            ParameterKind::BladeInput(place) => {
                let moved = moved(place);
                Some(core::array::from_fn(|axis| {
                    let blades = Variable::CONTROLS
                        .into_iter()
                        .zip(&moved)
                        .map(|(variable, moved)| here.by[axis][variable.index()] * moved);
                    blades.sum::<f64>() + here.by_rotor[axis] * moved[ROTOR] + here.by_rate[axis] * moved[ROTOR_ACCELERATION]
                }))
            }
            _ => None,
        }
    }

    /// Forces of all columns at a node, [axes x columns].
    pub(crate) fn parameter_forces(&self, columns: &[ParameterKind], here: &OperatingPoint, node: usize, out: &mut [f32]) {
        out.fill(0.0);
        let width = columns.len();
        let moved = |place: usize| {
            self.blade_input_changes
                .get(place)
                .and_then(|blade_input| blade_input.nodes.get(node))
                .copied()
                .unwrap_or([0.0; INPUT_LENGTH])
        };
        for (k, &column) in columns.iter().enumerate() {
            if let Some((axis, value)) = self.one_axis_force(column, here) {
                out[axis * width + k] = value as f32;
            } else if let Some(values) = self.all_axis_forces(column, here, moved) {
                values.into_iter().enumerate().for_each(|(axis, value)| out[axis * width + k] = value as f32);
            }
        }
    }
}

/// Errors of a run's instruments: its own biases and what effects add.
pub(crate) struct RunInstrumentErrors {
    pub(crate) bias: [f64; OUTPUTS],
    pub(crate) factor: [f64; OUTPUTS],
    pub(crate) late_s: [f64; OUTPUTS],
    /// The output with a first-order lag, and its time constant, s.
    pub(crate) lag: Option<(usize, f64)>,
    pub(crate) accelerometer_m: [f64; 3],
    pub(crate) vane_m: [f64; 3],
}

impl RunInstrumentErrors {
    /// Of a run with these offsets of its own, under these effects.
    pub(crate) fn of(record: &RunData, own: &[f64; RUN_OFFSETS], effects: &[Effect]) -> Self {
        let (mut bias, mut factor, mut late_s, mut lag) = ([0.0; OUTPUTS], [1.0; OUTPUTS], [0.0; OUTPUTS], None);
        bias[..6].copy_from_slice(&own[AXES..]);
        let mut accelerometer_m = record.geometry.accelerometer_position_m;
        let mut vane_m = record.geometry.vane_position_m;
        for effect in effects {
            if let Effect::SensorPosition { sensor, offset_m } = effect {
                let place = match sensor {
                    PositionedSensor::Accelerometer => &mut accelerometer_m,
                    PositionedSensor::Vane => &mut vane_m,
                };
                place.iter_mut().zip(offset_m).for_each(|(place, offset)| *place += offset);
            }
            let Some((output, (_, error))) = output_of(effect).zip(effect.sensor_error()) else { continue };
            match error {
                SensorError::Bias(value) => bias[output] += value,
                SensorError::Scale(by) => factor[output] *= by,
                SensorError::Delay(delay) => late_s[output] += delay,
                SensorError::Lag(tau) => lag = Some((output, tau)),
            }
        }
        RunInstrumentErrors { bias, factor, late_s, lag, accelerometer_m, vane_m }
    }
}

/// What an instrument makes of true values at equal steps: effects on that channel, in their order; of a rate of change no bias.
pub(crate) fn as_read(mut values: Vec<f64>, step_s: f64, channel: Channel, effects: &[Effect], is_rate: bool) -> Vec<f64> {
    for effect in effects.iter().filter(|effect| output_of(effect).is_some()) {
        let Some((_, error)) = effect.sensor_error().filter(|(of, _)| *of == channel) else { continue };
        match error {
            SensorError::Bias(_) if is_rate => {}
            SensorError::Bias(value) => values.iter_mut().for_each(|x| *x += value),
            SensorError::Scale(factor) => values.iter_mut().for_each(|x| *x *= factor),
            SensorError::Delay(delay) => {
                let last = values.len().saturating_sub(1) as f64;
                let at = |k: usize| {
                    let place = (k as f64 - delay / step_s).clamp(0.0, last);
                    let before = place as usize;
                    let (x0, x1) = (values.get(before), values.get(before + 1).or(values.get(before)));
                    x0.zip(x1).map_or(f64::NAN, |(x0, x1)| x0 + (x1 - x0) * (place - before as f64))
                };
                values = (0..values.len()).map(at).collect();
            }
            SensorError::Lag(tau) => {
                let part = 1.0 - libm::exp(-step_s / tau.max(1e-9));
                let (mut before, mut read) = (values.first().copied().unwrap_or(0.0), values.first().copied().unwrap_or(0.0));
                for x in &mut values {
                    read += part * (0.5 * (*x + before) - read);
                    before = *x;
                    *x = read;
                }
            }
        }
    }
    values
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_instrument_reads_as_its_effects_say() {
        let read = |values: &[f64], effects: &[Effect], is_rate| as_read(values.to_vec(), 0.1, Channel::R, effects, is_rate);
        let ramp: Vec<f64> = (0..100).map(|k| 0.1 * f64::from(k)).collect();
        let r = Channel::R;
        let late = read(&ramp, &[Effect::SensorDelay { channel: r, delay: 0.25 }], false);
        assert!((late[50] - (5.0 - 0.25)).abs() < 1e-12 && late[0].abs() < 1e-12);
        // A ramp through a lag is late by the time constant.
        let lagged = read(&ramp, &[Effect::SensorLag { channel: r, tau: 0.3 }], false);
        assert!((lagged[90] - (9.0 - 0.3)).abs() < 0.01, "{}", lagged[90]);
        let both = [Effect::SensorScale { channel: r, factor: 2.0 }, Effect::SensorBias { channel: r, value: 1.0 }];
        assert!((read(&ramp, &both, false)[10] - 3.0).abs() < 1e-12 && (read(&ramp, &both, true)[10] - 2.0).abs() < 1e-12);
        let other = [Effect::SensorScale { channel: Channel::P, factor: 2.0 }];
        assert_eq!(read(&ramp, &other, false), ramp);
    }
}
