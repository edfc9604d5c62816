//! What moved the aircraft, as effects say that it reached the blades: means over the steps and about the nodes of a mesh.
//!
//! Consumes a run's recorded controls and rotor speed and the effects on their instruments and on the way to the blade; produces
//! deviations from the model's trim. An instrument's error is undone first: true(t) = (read(t + delay) - bias)/factor, and a lag
//! by its own equation, true = read + tau d(read)/dt. Then the way of `simulation::control_path`, the same that `simulate` flies.

use super::run_data::{INPUTS, MEASURED_FORCE, ROTOR, RunData, input_channel};
use crate::dynamics::linear::Turning;
use crate::flight::control::{CONTROLS, Control};
use crate::flight::effect::{Effect, SensorError};
use crate::flight::model::Trim;
use crate::flight::signal::piecewise_linear::History;
use crate::flight::signal::series::Series;
use crate::simulation::control_path::ControlPath;

const PARTS: usize = 4;

/// Place of the rotor's acceleration, rad/s^2, behind the inputs.
pub const ROTOR_ACCELERATION: usize = INPUTS;
/// How much drives the motion.
pub const INPUT_LENGTH: usize = INPUTS + 1;

/// Deviations of four blades and of the rotor's speed, what was felt on silent axes, the rotor's acceleration.
pub type InputVector = [f64; INPUT_LENGTH];

/// What the rotor does.
pub fn turning(moved: &InputVector) -> Turning {
    Turning { deviation: moved[ROTOR], rate: moved[ROTOR_ACCELERATION] }
}

/// Over a whole run.
#[derive(Clone, Debug, Default)]
pub struct BladeInput {
    /// Mean from each node to the next.
    pub steps: Vec<InputVector>,
    /// Mean over a step's length about each node.
    pub nodes: Vec<InputVector>,
}

/// The recorded input as its instrument's effects let it have been.
fn corrected(series: &Series, input: usize, effects: &[Effect]) -> Vec<(f64, f64)> {
    let channel = input_channel(input);
    let mut points: Vec<(f64, f64)> = series.samples().collect();
    for (_, error) in effects.iter().filter_map(Effect::sensor_error).filter(|(of, _)| *of == channel) {
        match error {
            SensorError::Bias(value) => points.iter_mut().for_each(|(_, x)| *x -= value),
            SensorError::Scale(factor) => points.iter_mut().for_each(|(_, x)| *x /= factor),
            SensorError::Delay(delay) => points.iter_mut().for_each(|(t, _)| *t -= delay),
            SensorError::Lag(tau) => {
                let line = Series::of(points.iter().copied());
                let half_s = line.interval_s().unwrap_or(0.02);
                for (time_s, value) in &mut points {
                    *value += tau * (line.at(*time_s + half_s) - line.at(*time_s - half_s)) / (2.0 * half_s);
                }
            }
        }
    }
    points
}

impl BladeInput {
    /// Of a run.
    pub fn of(record: &RunData, trim: &Trim, effects: &[Effect]) -> BladeInput {
        let histories: [History; CONTROLS] = Control::ALL.map(|control| {
            let place = control.index();
            let at_trim = trim.controls[place];
            let points = record.inputs[place].as_ref().map(|series| corrected(series, place, effects));
            let history = points.and_then(|points| History::through(points).ok());
            history.map_or(History::constant(0.0), |history| history.shifted(-at_trim))
        });
        let mut path = ControlPath::new(effects);
        path.extend(&histories);
        let fine = record.mesh.step_s / PARTS as f64;
        let count = record.mesh.nodes * PARTS + PARTS;
        let from_s = record.mesh.time_s(0) - 0.5 * record.mesh.step_s;
        let times: Vec<f64> = (0..=count).map(|k| from_s + fine * k as f64).collect();
        let blade = path.blade(&times);
        let rotor = match (record.inputs[ROTOR].as_ref(), trim.rotor_speed) {
            (Some(series), Some(at_trim)) => Some((Series::of(corrected(series, ROTOR, effects)), at_trim)),
            _ => None,
        };
        let mean = |from: usize| -> InputVector {
            let mut sum = [0.0; INPUT_LENGTH];
            for part in 0..=PARTS {
                let weight = if part == 0 || part == PARTS { 0.5 } else { 1.0 } / PARTS as f64;
                for (sum, moved) in sum.iter_mut().zip(blade.get(from + part).into_iter().flatten()) {
                    *sum += weight * moved;
                }
            }
            if let Some((series, at_trim)) = &rotor {
                let begin_s = from_s + fine * from as f64;
                let end_s = begin_s + record.mesh.step_s;
                sum[ROTOR] = series.mean(begin_s, end_s) - at_trim;
                sum[ROTOR_ACCELERATION] = (series.at(end_s) - series.at(begin_s)) / record.mesh.step_s;
            }
            for (sum, series) in sum.iter_mut().zip(&record.inputs).skip(MEASURED_FORCE) {
                if let Some(series) = series {
                    let begin_s = from_s + fine * from as f64;
                    *sum = series.mean(begin_s, begin_s + record.mesh.step_s);
                }
            }
            sum
        };
        BladeInput {
            steps: (0..record.mesh.nodes).map(|node| mean(node * PARTS + PARTS / 2)).collect(),
            nodes: (0..record.mesh.nodes).map(|node| mean(node * PARTS)).collect(),
        }
    }

    /// What is more here than there, each divided by `by`.
    pub fn difference(&self, other: &BladeInput, by: f64) -> BladeInput {
        let difference = |a: &[InputVector], b: &[InputVector]| -> Vec<InputVector> {
            a.iter().zip(b).map(|(a, b)| core::array::from_fn(|i| (a[i] - b[i]) / by)).collect()
        };
        BladeInput { steps: difference(&self.steps, &other.steps), nodes: difference(&self.nodes, &other.nodes) }
    }

    /// Whether anything moves at all.
    pub fn moves(&self) -> bool {
        self.nodes.iter().flatten().any(|moved| libm::fabs(*moved) > 1e-9)
    }
}
