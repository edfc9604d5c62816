//! Residuals along a run: what the instruments saw less what they would have seen of the model's forces and moments.
//!
//! Consumes a run, the states of the search's filter along it, effects and small errors of derivatives; produces by axis
//!     e = z - I(F(x, u))                                                                              (1)
//! for accelerometers at the nodes, lever arms counted; for gyros z is the difference of two means over the step between them and
//! F the moment in its middle. I is what effects on the instrument make of it (`as_read`); a run's own offsets are taken off.
//! The same of a reading: z less what the instrument would read of the state.

use super::aircraft::Partials;
use super::driven::{Driven, MOVED};
use super::filter::State;
use super::point::{OWN, output_of};
use super::posed::{Here, Posed, deviations};
use super::problem::Problem;
use super::run_record::{OUTPUT_CHANNELS, OUTPUTS, ROTOR, Record};
use super::search::Searched;
use crate::estimation::compatibility::readings::Readings;
use crate::flight::channel::Channel;
use crate::flight::derivative::{AXES, VARIABLES};
use crate::flight::effect::{Effect, PositionedSensor};

/// A run with where it was.
pub(super) struct Flown<'p> {
    problem: &'p Problem,
    record: &'p Record,
    states: &'p [State],
    own: [f64; OWN],
}

impl<'p> Flown<'p> {
    /// A run of the problem; `None` where the search did not follow it.
    pub(super) fn of(problem: &'p Problem, searched: &'p Searched, number: usize) -> Option<Self> {
        Some(Flown {
            problem,
            record: problem.runs.get(number)?,
            states: &searched.local.runs.get(number)?.states,
            own: *searched.point.own.get(number)?,
        })
    }

    /// Time between nodes, s.
    pub(super) fn step_s(&self) -> f64 {
        self.record.mesh.step_s
    }

    /// The run.
    pub(super) fn record(&self) -> &'p Record {
        self.record
    }

    /// (1) by axis under these effects; empty where the instrument is missing.
    pub(super) fn residuals(&self, effects: &[Effect], small: &Partials) -> [Vec<f64>; AXES] {
        self.posed(effects, small, |posed| {
            let (forces, moments) = (self.forces(posed), self.moments(posed));
            core::array::from_fn(|axis| {
                let Some(series) = self.record.outputs.get(axis).and_then(Option::as_ref) else { return Vec::new() };
                let is_force = axis < 3;
                let model =
                    if is_force { self.seen(posed, &forces, axis) } else { moments.iter().map(|one| one[axis]).collect() };
                let model = as_read(model, self.step_s(), OUTPUT_CHANNELS[axis], effects, !is_force);
                let mesh = &self.record.mesh;
                let half_s = 0.5 * mesh.step_s;
                let at = |time_s: f64| series.mean(time_s - half_s, time_s + half_s);
                let measured = |node: usize| {
                    let time_s = mesh.time_s(node);
                    if is_force {
                        at(time_s) - self.own[AXES + axis]
                    } else {
                        (at(time_s + mesh.step_s) - at(time_s)) / mesh.step_s
                    }
                };
                model.iter().enumerate().map(|(node, model)| measured(node) - model).collect()
            })
        })
    }

    /// An output as measured, its own bias taken off, and as the instrument would have read it under these effects.
    pub(super) fn readings(&self, output: usize, effects: &[Effect], small: &Partials) -> Vec<(f64, f64)> {
        let (Some(series), Some(&channel)) =
            (self.record.outputs.get(output).and_then(Option::as_ref), OUTPUT_CHANNELS.get(output))
        else {
            return Vec::new();
        };
        let seen = self.posed(effects, small, |posed| self.seen(posed, &self.forces(posed), output));
        let bias = if output < 6 { self.own[AXES + output] } else { 0.0 };
        let half_s = 0.5 * self.step_s();
        let reads = as_read(seen, self.step_s(), channel, effects, false);
        let measured = |node: usize| {
            let time_s = self.record.mesh.time_s(node);
            series.mean(time_s - half_s, time_s + half_s) - bias
        };
        reads.into_iter().enumerate().map(|(node, read)| (measured(node), read)).collect()
    }

    /// Deviations from trim, attitude and the rotor's speed at the nodes, under these effects.
    pub(super) fn motion(&self, effects: &[Effect]) -> Vec<([f64; VARIABLES], State, f64)> {
        let trim = self.problem.aircraft.trim();
        let driven = Driven::of(self.record, trim, effects);
        let nodes = self.states.iter().zip(&driven.nodes);
        nodes.map(|(x, moved)| (deviations(trim, x, moved), *x, moved[ROTOR])).collect()
    }

    /// Forces and moments at the nodes.
    fn forces(&self, posed: &Posed<'_>) -> Vec<[f64; AXES]> {
        self.states.iter().zip(&posed.driven.nodes).map(|(x, moved)| posed.force(x, moved)).collect()
    }

    /// And in the middle of each step.
    fn moments(&self, posed: &Posed<'_>) -> Vec<[f64; AXES]> {
        let between = self.states.windows(2).zip(&posed.driven.steps).filter_map(|(pair, over)| {
            let [x, next] = pair else { return None };
            let middle: State = core::array::from_fn(|i| 0.5 * (x[i] + next[i]));
            Some(posed.force(&middle, over))
        });
        between.collect()
    }

    /// An output's true values at the nodes.
    fn seen(&self, posed: &Posed<'_>, forces: &[[f64; AXES]], output: usize) -> Vec<f64> {
        let at = |(x, force): (&State, &[f64; AXES])| {
            let (by, deviations) = ([[0.0; VARIABLES]; AXES], [0.0; VARIABLES]);
            let here = Here { force: *force, by, by_rotor: [0.0; AXES], by_rate: [0.0; AXES], deviations, moved: [0.0; MOVED] };
            posed.seen(output, x, &here).map_or(f64::NAN, |(value, ..)| value)
        };
        self.states.iter().zip(forces).map(at).collect()
    }

    fn posed<T>(&self, effects: &[Effect], small: &Partials, with: impl FnOnce(&Posed<'_>) -> T) -> T {
        let trim = self.problem.aircraft.trim();
        let model = self.problem.aircraft.changed(effects, small);
        let driven = Driven::of(self.record, trim, effects);
        let place = |sensor: PositionedSensor, mut place: [f64; 3]| {
            for effect in effects {
                if let Effect::SensorPosition { sensor: of, offset_m } = effect
                    && *of == sensor
                {
                    place.iter_mut().zip(offset_m).for_each(|(place, offset)| *place += offset);
                }
            }
            place
        };
        let mut constant = [0.0; AXES];
        constant.copy_from_slice(&self.own[..AXES]);
        with(&Posed {
            record: self.record,
            model: &model,
            trim,
            driven: &driven,
            moved: &[],
            readings: &Readings::default(),
            constant,
            bias: [0.0; OUTPUTS],
            factor: [1.0; OUTPUTS],
            accelerometer_m: place(PositionedSensor::Accelerometer, self.record.geometry.accelerometer_position_m),
            vane_m: place(PositionedSensor::Vane, self.record.geometry.vane_position_m),
            lag: None,
        })
    }
}

/// What an instrument makes of true values at equal steps: effects on that channel, in their order; of a rate of change no bias.
fn as_read(mut values: Vec<f64>, step_s: f64, channel: Channel, effects: &[Effect], is_rate: bool) -> Vec<f64> {
    for effect in effects.iter().filter(|effect| effect.sensor_channel() == Some(channel) && output_of(effect).is_some()) {
        match *effect {
            Effect::SensorBias { value, .. } if !is_rate => values.iter_mut().for_each(|x| *x += value),
            Effect::SensorScale { factor, .. } => values.iter_mut().for_each(|x| *x *= factor),
            Effect::SensorDelay { delay, .. } => {
                let last = values.len().saturating_sub(1) as f64;
                let at = |k: usize| {
                    let place = (k as f64 - delay / step_s).clamp(0.0, last);
                    let before = place as usize;
                    let (x0, x1) = (values.get(before), values.get(before + 1).or(values.get(before)));
                    x0.zip(x1).map_or(f64::NAN, |(x0, x1)| x0 + (x1 - x0) * (place - before as f64))
                };
                values = (0..values.len()).map(at).collect();
            }
            Effect::SensorLag { tau, .. } => {
                let part = 1.0 - libm::exp(-step_s / tau.max(1e-9));
                let (mut before, mut read) = (values.first().copied().unwrap_or(0.0), values.first().copied().unwrap_or(0.0));
                for x in &mut values {
                    read += part * (0.5 * (*x + before) - read);
                    before = *x;
                    *x = read;
                }
            }
            _ => {}
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
