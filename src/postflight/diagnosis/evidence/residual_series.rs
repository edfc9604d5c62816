//! Residuals along a run: what the instruments saw less what they would have seen of the model's forces and moments.
//!
//! Consumes a run, the states of the search's filter along it, effects and small errors of derivatives; produces by axis
//!     e = z - I(F(x, u))                                                                              (1)
//! for accelerometers at the nodes, lever arms counted; for gyros z is the difference of two means over the step between them and
//! F the moment in its middle. I is what effects on the instrument make of it (`as_read`); a run's own offsets are taken off.
//! The same of a reading: z less what the instrument would read of the state.

use crate::flight::derivative::{AXES, VARIABLES};
use crate::flight::effect::{Effect, PositionedSensor};
use crate::flight::signal::readings::Readings;
use crate::postflight::diagnosis::data::blade_input::{BladeInput, INPUT_LENGTH};
use crate::postflight::diagnosis::data::run_data::{OUTPUT_CHANNELS, OUTPUTS, ROTOR, RunData};
use crate::postflight::diagnosis::likelihood::aircraft::Partials;
use crate::postflight::diagnosis::likelihood::parameter::RUN_OFFSETS;
use crate::postflight::diagnosis::likelihood::parameter::as_read;
use crate::postflight::diagnosis::likelihood::problem::DiagnosisProblem;
use crate::postflight::diagnosis::likelihood::run_model::{OperatingPoint, RunModel, deviations};
use crate::postflight::diagnosis::likelihood::state::FilterState;
use crate::postflight::diagnosis::search::forward_search::SearchResult;

/// A run with where it was.
pub(crate) struct FilteredRun<'p> {
    problem: &'p DiagnosisProblem,
    record: &'p RunData,
    states: &'p [FilterState],
    own: [f64; RUN_OFFSETS],
}

impl<'p> FilteredRun<'p> {
    /// A run of the problem; `None` where the search did not follow it.
    pub(crate) fn of(problem: &'p DiagnosisProblem, searched: &'p SearchResult, number: usize) -> Option<Self> {
        Some(FilteredRun {
            problem,
            record: problem.runs.get(number)?,
            states: &searched.local.runs.get(number)?.states,
            own: *searched.point.run_offsets.get(number)?,
        })
    }

    /// Time between nodes, s.
    pub(crate) fn step_s(&self) -> f64 {
        self.record.mesh.step_s
    }

    pub(crate) fn record(&self) -> &'p RunData {
        self.record
    }

    /// (1) by axis under these effects; empty where the instrument is missing.
    pub(crate) fn residuals(&self, effects: &[Effect], small: &Partials) -> [Vec<f64>; AXES] {
        self.run_model(effects, small, |run_model| {
            let (forces, moments) = (self.forces(run_model), self.moments(run_model));
            core::array::from_fn(|axis| {
                let is_force = axis < 3;
                let model =
                    if is_force { self.predict(run_model, &forces, axis) } else { moments.iter().map(|one| one[axis]).collect() };
                let model = as_read(model, self.step_s(), OUTPUT_CHANNELS[axis], effects, !is_force);
                let measured = self.measured(axis, model.len());
                measured.iter().zip(&model).map(|(measured, model)| measured - model).collect()
            })
        })
    }

    /// z of (1) at the first nodes; empty where the instrument is missing.
    pub(crate) fn measured(&self, axis: usize, nodes: usize) -> Vec<f64> {
        let Some(series) = self.record.outputs.get(axis).and_then(Option::as_ref) else { return Vec::new() };
        let mesh = &self.record.mesh;
        let half_s = 0.5 * mesh.step_s;
        let at = |time_s: f64| series.mean(time_s - half_s, time_s + half_s);
        let measured = |node: usize| {
            let time_s = mesh.time_s(node);
            if axis < 3 {
                at(time_s) - self.own.get(AXES + axis).copied().unwrap_or(0.0)
            } else {
                (at(time_s + mesh.step_s) - at(time_s)) / mesh.step_s
            }
        };
        (0..nodes).map(measured).collect()
    }

    /// An output as measured, its own bias taken off, and as the instrument would have read it under these effects.
    pub(crate) fn readings(&self, output: usize, effects: &[Effect], small: &Partials) -> Vec<(f64, f64)> {
        let (Some(series), Some(&channel)) =
            (self.record.outputs.get(output).and_then(Option::as_ref), OUTPUT_CHANNELS.get(output))
        else {
            return Vec::new();
        };
        let seen = self.run_model(effects, small, |run_model| self.predict(run_model, &self.forces(run_model), output));
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
    pub(crate) fn motion(&self, effects: &[Effect]) -> Vec<([f64; VARIABLES], FilterState, f64)> {
        let trim = self.problem.aircraft.trim();
        let blade_input = BladeInput::of(self.record, trim, effects);
        let nodes = self.states.iter().zip(&blade_input.nodes);
        nodes.map(|(x, moved)| (deviations(trim, x, moved), *x, moved[ROTOR])).collect()
    }

    /// Forces and moments at the nodes.
    fn forces(&self, run_model: &RunModel<'_>) -> Vec<[f64; AXES]> {
        self.states.iter().zip(&run_model.blade_input.nodes).map(|(x, moved)| run_model.force(x, moved)).collect()
    }

    /// And in the middle of each step.
    fn moments(&self, run_model: &RunModel<'_>) -> Vec<[f64; AXES]> {
        let between = self.states.windows(2).zip(&run_model.blade_input.steps).filter_map(|(pair, over)| {
            let [x, next] = pair else { return None };
            let middle: FilterState = core::array::from_fn(|i| 0.5 * (x[i] + next[i]));
            Some(run_model.force(&middle, over))
        });
        between.collect()
    }

    /// An output's true values at the nodes.
    fn predict(&self, run_model: &RunModel<'_>, forces: &[[f64; AXES]], output: usize) -> Vec<f64> {
        let at = |(x, force): (&FilterState, &[f64; AXES])| {
            let (by, deviations) = ([[0.0; VARIABLES]; AXES], [0.0; VARIABLES]);
            let here = OperatingPoint {
                force: *force,
                by,
                by_rotor: [0.0; AXES],
                by_rate: [0.0; AXES],
                deviations,
                inputs: [0.0; INPUT_LENGTH],
            };
            run_model.predict(output, x, &here).map_or(f64::NAN, |(value, ..)| value)
        };
        self.states.iter().zip(forces).map(at).collect()
    }

    fn run_model<T>(&self, effects: &[Effect], small: &Partials, with: impl FnOnce(&RunModel<'_>) -> T) -> T {
        let trim = self.problem.aircraft.trim();
        let model = self.problem.aircraft.changed(effects, small);
        let blade_input = BladeInput::of(self.record, trim, effects);
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
        with(&RunModel {
            record: self.record,
            model: &model,
            trim,
            blade_input: &blade_input,
            blade_input_changes: &[],
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
