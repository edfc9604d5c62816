//! How much each variable and each axis moves in the runs to look at, flown without anything hidden: what sizes are taken from.

use super::case::Plan;
use super::flights::{RATE_HZ, flown};
use sideslip::dynamics::linear::{Turning, forces};
use sideslip::flight::control::{CONTROLS, Control};
use sideslip::flight::derivative::{AXES, Axis, VARIABLES, Variable};
use sideslip::flight::term::Term;
use sideslip::simulation::unmodelled::Unmodelled;

/// Force that an accelerometer plainly shows beside vibration, rms, m/s^2.
const SEEN_FORCE: f64 = 0.8;

/// Deviations from trim by run and time.
pub(crate) struct Motion {
    runs: Vec<Vec<[f64; VARIABLES]>>,
    rotor_speed: Vec<Vec<f64>>,
    /// Deviation of each axis's acceleration, rms of the run in which it moves most.
    axis_rms: [f64; AXES],
    /// How far the pilot's hand moves each control from trim, rad.
    pub(crate) amplitude: [f64; CONTROLS],
}

impl Motion {
    /// Of a plan's four runs.
    pub(crate) fn of(plan: &Plan) -> Self {
        let model = &plan.truth.model;
        let trim = &model.trim;
        let mut motion = Motion { runs: Vec::new(), rotor_speed: Vec::new(), axis_rms: [0.0; AXES], amplitude: [0.0; CONTROLS] };
        for run in 0..4 {
            let truth = flown(plan, run).unwrap().truth;
            let rows: Vec<[f64; VARIABLES]> = truth
                .iter()
                .map(|state| {
                    let mut row = [0.0; VARIABLES];
                    let body = [Variable::U, Variable::V, Variable::W, Variable::P, Variable::Q, Variable::R];
                    for (variable, value) in body.into_iter().zip(state.air_velocity.into_iter().chain(state.motion.rates)) {
                        row[variable.index()] = value - trim.of(variable);
                    }
                    for control in Control::ALL {
                        row[control.variable().index()] = state.blade[control.index()] - trim.controls[control.index()];
                    }
                    row
                })
                .collect();
            motion.rotor_speed.push(truth.iter().map(|state| state.rotor_speed.unwrap() - trim.rotor_speed.unwrap()).collect());
            let at_rest = forces(model, &[0.0; VARIABLES], Turning::default());
            for axis in Axis::ALL {
                let moved =
                    rms(rows.iter().map(|row| forces(model, row, Turning::default())[axis.index()] - at_rest[axis.index()]));
                motion.axis_rms[axis.index()] = motion.axis_rms[axis.index()].max(moved);
            }
            for control in Control::ALL {
                let most = rows.iter().map(|row| row[control.variable().index()].abs()).fold(0.0, f64::max);
                motion.amplitude[control.index()] = motion.amplitude[control.index()].max(most);
            }
            motion.runs.push(rows);
        }
        motion
    }

    /// Deviation of that axis's acceleration in the run in which it moves most, rms; of a force that hardly moves, what is seen.
    pub(crate) fn axis_rms(&self, axis: Axis) -> f64 {
        self.axis_rms[axis.index()].max(if axis.is_force() { SEEN_FORCE } else { 0.0 })
    }

    /// The term's value in the run in which it is largest, rms.
    pub(crate) fn term_rms(&self, term: Term) -> f64 {
        self.runs.iter().map(|rows| rms(rows.iter().map(|row| term.value(row)))).fold(0.0, f64::max)
    }

    /// Deviation of the rotor's speed in the run in which it is largest, rms, rad/s.
    pub(crate) fn rotor_rms(&self) -> f64 {
        self.rotor_speed.iter().map(|values| rms(values.iter().copied())).fold(0.0, f64::max)
    }

    /// What a law adds to an axis in each run, by small steps along the motion.
    pub(crate) fn law(&self, law: &Unmodelled, axis: Axis) -> Vec<Vec<f64>> {
        const PARTS: u32 = 8;
        let one = |rows: &Vec<[f64; VARIABLES]>| {
            let mut memory = 0.0;
            rows.iter()
                .map(|row| {
                    for _ in 0..PARTS {
                        memory += law.at(row, memory).1 / (RATE_HZ * f64::from(PARTS));
                    }
                    law.at(row, memory).0[axis.index()]
                })
                .collect()
        };
        self.runs.iter().map(one).collect()
    }

    /// The largest part of those values, of 1, that one term of the library makes up.
    pub(crate) fn told_by_one_term(&self, values: &[Vec<f64>]) -> f64 {
        let whole: f64 = values.iter().flatten().map(|x| x * x).sum();
        let linear = Variable::ALL.into_iter().map(Term::Linear);
        let part = |regressor: &dyn Fn(usize, usize) -> f64| {
            let (mut together, mut own) = (0.0, 0.0);
            for (run, values) in values.iter().enumerate() {
                for (place, value) in values.iter().enumerate() {
                    let x = regressor(run, place);
                    (together, own) = (together + x * value, own + x * x);
                }
            }
            if own > 0.0 { together * together / (own * whole) } else { 0.0 }
        };
        let by_terms =
            linear.chain(Term::library()).map(|term| part(&|run, place| term.value(&self.runs[run][place]))).fold(0.0, f64::max);
        by_terms.max(part(&|run, place| self.rotor_speed[run][place]))
    }
}

pub(crate) fn rms(values: impl Iterator<Item = f64>) -> f64 {
    let (mut sum, mut count) = (0.0, 0.0);
    for value in values {
        (sum, count) = (sum + value * value, count + 1.0);
    }
    if count > 0.0 { (sum / count).sqrt() } else { 0.0 }
}
