//! A run with the model and everything that reaches it: motion, outputs, and what columns do to forces.
//!
//! Consumes the state, the blades' motion and the model; produces the state's rate of change and its Jacobian, each output with
//! its slopes by the state, by forces and by the place of its sensor, and the force or moment of every column. Equations of
//! motion are those of `simulation::motion`; gusts take from the velocity through the air, and their rates are
//!     g' = -g/tau                                                                                     (1)
//! with tau the scale length over the airspeed along the flight, and two thirds of it across.
//! Along an axis without a model, the force is what the accelerometer felt there; where none stands, and about
//! such an axis, it is noise, and the motion follows its instruments.

use super::aircraft::{ModifiedAircraft, Partials};
use super::state::{ALTITUDE, ATTITUDE, FilterState, GUST, LAG, RATES, STATES, StateMatrix, VELOCITY, gust_time, triple};
use crate::dynamics::kinematics::{Attitude, velocity_rate, velocity_rate_by_rates, velocity_rate_by_velocity};
use crate::dynamics::sensors::{
    AirData, centripetal_by_rates, centripetal_terms, cross, specific_force_by_angular_acceleration, specific_force_by_arm,
    velocity_at_arm,
};
use crate::flight::derivative::{AXES, Axis, VARIABLES, Variable};
use crate::flight::model::Trim;
use crate::flight::signal::readings::Readings;
use crate::postflight::diagnosis::data::blade_input::{BladeInput, InputVector, ROTOR_ACCELERATION, turning};
use crate::postflight::diagnosis::data::run_data::{
    ALPHA_OUTPUT, ALTITUDE_OUTPUT, ATTITUDE_OUTPUT, BETA_OUTPUT, FORCE_OUTPUT, MEASURED_FORCE, OUTPUTS, RATE_OUTPUT, ROTOR,
    RunData, TAS_OUTPUT,
};
use crate::postflight::start_state::{start_reading, start_velocity};

/// Forward speed below which vanes tell nothing, m/s.
const SPEED_MIN: f64 = 2.0;

/// A run with the model and everything that reaches it.
#[expect(missing_docs, reason = "fields are what their names say")]
pub struct RunModel<'a> {
    pub record: &'a RunData,
    pub model: &'a ModifiedAircraft<'a>,
    pub trim: &'a Trim,
    /// What reaches the blades.
    pub blade_input: &'a BladeInput,
    /// Changes of that, by place.
    pub blade_input_changes: &'a [&'a BladeInput],
    /// The outputs' readings, skews undone.
    pub readings: &'a Readings,
    /// Offset of the forces and moments of this run.
    pub constant: [f64; AXES],
    /// Biases and factors of the outputs.
    pub bias: [f64; OUTPUTS],
    /// See `bias`.
    pub factor: [f64; OUTPUTS],
    /// Where accelerometers stand, m.
    pub accelerometer_m: [f64; 3],
    /// Where vanes stand, m.
    pub vane_m: [f64; 3],
    /// The output with a lag of its own, and its time constant, s.
    pub lag: Option<(usize, f64)>,
}

/// Forces and their slopes at a node.
#[derive(Clone, Copy)]
pub struct OperatingPoint {
    pub(crate) force: [f64; AXES],
    pub(crate) by: Partials,
    pub(crate) by_rotor: [f64; AXES],
    pub(crate) by_rate: [f64; AXES],
    pub(crate) deviations: [f64; VARIABLES],
    pub(crate) inputs: InputVector,
}

impl OperatingPoint {
    fn angular_acceleration(&self) -> [f64; 3] {
        let [_, _, _, dp, dq, dr] = self.force;
        [dp, dq, dr]
    }
}

impl RunModel<'_> {
    pub(crate) fn deviations(&self, x: &FilterState, moved: &InputVector) -> [f64; VARIABLES] {
        deviations(self.trim, x, moved)
    }

    pub(crate) fn force(&self, x: &FilterState, moved: &InputVector) -> [f64; AXES] {
        let mut force = self.model.forces(&self.deviations(x, moved), turning(moved));
        let turning = [force[3], force[4], force[5]];
        for (axis, force) in force.iter_mut().enumerate() {
            *force = self.measured_force_at_cg(axis, x, moved, turning).unwrap_or(*force) + self.constant[axis];
        }
        force
    }

    /// What an accelerometer felt along an axis without a model, brought to the centre of mass by (6) of
    /// `sensors`.
    fn measured_force_at_cg(
        &self,
        axis: usize,
        x: &FilterState,
        moved: &InputVector,
        angular_acceleration: [f64; 3],
    ) -> Option<f64> {
        self.record.inputs.get(MEASURED_FORCE + axis)?.as_ref()?;
        let arm = self.accelerometer_m;
        let tangential = cross(angular_acceleration, arm).get(axis).copied()?;
        let (added, taken) = centripetal_terms(triple(x, RATES), arm).get(axis).copied()?;
        Some(moved.get(MEASURED_FORCE + axis)? - (tangential + added - taken))
    }

    /// Rate of change of the state.
    pub(crate) fn rate(&self, x: &FilterState, force: &[f64; AXES], gust_s: f64) -> Option<FilterState> {
        let attitude = Attitude::regular(x[ATTITUDE], x[ATTITUDE + 1])?;
        let (velocity, rates) = (triple(x, VELOCITY), triple(x, RATES));
        let [du, dv, dw] = velocity_rate(velocity, rates, [force[0], force[1], force[2]]);
        let [gx, gy, gz] = attitude.gravity();
        let [dphi, dtheta, dpsi] = attitude.euler_rates(rates);
        let mut rate = [0.0; STATES];
        rate[..LAG].copy_from_slice(&[
            du + gx,
            dv + gy,
            dw + gz,
            force[3],
            force[4],
            force[5],
            dphi,
            dtheta,
            dpsi,
            attitude.climb(velocity),
        ]);
        for axis in 0..3 {
            rate[GUST + axis] = -x[GUST + axis] / gust_time(axis, gust_s);
        }
        Some(rate)
    }

    /// Jacobian of the rate of change by the state.
    pub(crate) fn jacobian(&self, x: &FilterState, by: &Partials, gust_s: f64) -> Option<StateMatrix> {
        let attitude = Attitude::regular(x[ATTITUDE], x[ATTITUDE + 1])?;
        let (velocity, rates) = (triple(x, VELOCITY), triple(x, RATES));
        let (by_velocity, by_rates) = (velocity_rate_by_velocity(rates), velocity_rate_by_rates(velocity));
        let (gravity, euler) = (attitude.gravity_partials(), attitude.euler_partials(rates));
        let mut a = [[0.0; STATES]; STATES];
        for i in 0..3 {
            for j in 0..3 {
                a[VELOCITY + i][VELOCITY + j] = by_velocity[i][j];
                a[VELOCITY + i][RATES + j] = by_rates[i][j];
                a[ATTITUDE + i][RATES + j] = euler.by_rates[i][j];
            }
            a[VELOCITY + i][ATTITUDE..ATTITUDE + 2].copy_from_slice(&gravity[i]);
            a[ATTITUDE + i][ATTITUDE..ATTITUDE + 2].copy_from_slice(&euler.by_attitude[i]);
            a[GUST + i][GUST + i] = -1.0 / gust_time(i, gust_s);
        }
        a[ALTITUDE][VELOCITY..VELOCITY + 3].copy_from_slice(&attitude.climb_by_vector());
        a[ALTITUDE][ATTITUDE..ATTITUDE + 2].copy_from_slice(&attitude.climb_by_attitude(velocity));
        for (row, by) in a.iter_mut().zip(by) {
            for j in 0..6 {
                row[j] += by[j];
            }
            for j in 0..3 {
                row[GUST + j] -= by[j];
            }
        }
        Some(a)
    }

    /// An output's true value, its slope by the state, and by forces and moments.
    pub(crate) fn predict(
        &self,
        output: usize,
        x: &FilterState,
        here: &OperatingPoint,
    ) -> Option<(f64, FilterState, [f64; AXES])> {
        let mut h = [0.0; STATES];
        let mut by_force = [0.0; AXES];
        let rates = triple(x, RATES);
        let value = match output {
            FORCE_OUTPUT..RATE_OUTPUT => {
                let axis = output - FORCE_OUTPUT;
                let arm = self.accelerometer_m;
                let tangential = cross(here.angular_acceleration(), arm)[axis];
                let (added, taken) = centripetal_terms(rates, arm)[axis];
                by_force[axis] = 1.0;
                by_force[3..].copy_from_slice(&specific_force_by_angular_acceleration(arm)[axis]);
                for (j, slope) in centripetal_by_rates(rates, arm)[axis].into_iter().enumerate() {
                    h[RATES + j] += slope;
                }
                for (axis, weight) in by_force.into_iter().enumerate() {
                    if weight != 0.0 {
                        let by = &here.by[axis];
                        h.iter_mut().zip(by).take(6).for_each(|(h, by)| *h += weight * by);
                        h.iter_mut().skip(GUST).zip(by).take(3).for_each(|(h, by)| *h -= weight * by);
                    }
                }
                here.force[axis] + tangential + (added - taken)
            }
            RATE_OUTPUT..TAS_OUTPUT => {
                let state = RATES + output - RATE_OUTPUT;
                h[state] = 1.0;
                x[state]
            }
            TAS_OUTPUT | ALPHA_OUTPUT | BETA_OUTPUT => {
                let arm = if output == TAS_OUTPUT { [0.0; 3] } else { self.vane_m };
                let velocity = velocity_at_arm(core::array::from_fn(|i| x[VELOCITY + i] - x[GUST + i]), rates, arm);
                if !(velocity[0] > SPEED_MIN) {
                    return None;
                }
                let instrument = match output {
                    TAS_OUTPUT => AirData::Airspeed,
                    ALPHA_OUTPUT => AirData::Incidence,
                    _ => AirData::Sideslip,
                };
                let reading = instrument.reading(velocity);
                for (j, slope) in reading.by_velocity.into_iter().enumerate() {
                    h[VELOCITY + j] = slope;
                    h[GUST + j] = -slope;
                }
                h[RATES..RATES + 3].copy_from_slice(&reading.by_rates(arm));
                reading.value
            }
            _ => {
                h[ALTITUDE] = 1.0;
                x[ALTITUDE]
            }
        };
        Some((value, h, by_force))
    }

    /// Slope of an output by the place of its sensor.
    pub(crate) fn by_sensor_position(&self, output: usize, axis: usize, x: &FilterState, here: &OperatingPoint) -> f64 {
        let rates = triple(x, RATES);
        match output {
            FORCE_OUTPUT..RATE_OUTPUT => specific_force_by_arm(rates, here.angular_acceleration())[output - FORCE_OUTPUT][axis],
            ALPHA_OUTPUT | BETA_OUTPUT => {
                let Some((_, h, _)) = self.predict(output, x, here) else { return 0.0 };
                cross(triple(&h, VELOCITY), rates)[axis]
            }
            _ => 0.0,
        }
    }
}

impl RunModel<'_> {
    pub(crate) fn operating_point(&self, x: &FilterState, moved: &InputVector) -> OperatingPoint {
        let deviations = self.deviations(x, moved);
        OperatingPoint {
            force: self.force(x, moved),
            by: self.model.partials(&deviations, moved[ROTOR]),
            by_rotor: self.model.by_rotor(&deviations, moved[ROTOR]),
            by_rate: core::array::from_fn(|axis| {
                if axis == Axis::N.index() { self.model.reaction() * self.model.share_of_yaw() } else { 0.0 }
            }),
            deviations,
            inputs: *moved,
        }
    }

    /// The same after the state has been corrected.
    pub(crate) fn updated(&self, mut here: OperatingPoint, x: &FilterState, before: &FilterState) -> OperatingPoint {
        for (axis, force) in here.force.iter_mut().enumerate() {
            for j in 0..6 {
                *force += here.by[axis][j] * (x[j] - before[j]);
            }
            for j in 0..3 {
                *force -= here.by[axis][j] * (x[GUST + j] - before[GUST + j]);
            }
        }
        here
    }
}

/// Deviations from trim of a state, through the air, and of what moves the blades.
pub(crate) fn deviations(trim: &Trim, x: &FilterState, moved: &InputVector) -> [f64; VARIABLES] {
    let mut deviations = [0.0; VARIABLES];
    deviations[Variable::U.index()] = x[VELOCITY] - x[GUST] - trim.u;
    deviations[Variable::V.index()] = x[VELOCITY + 1] - x[GUST + 1] - trim.v;
    deviations[Variable::W.index()] = x[VELOCITY + 2] - x[GUST + 2] - trim.w;
    deviations[3..6].copy_from_slice(&x[3..6]);
    for (place, variable) in Variable::CONTROLS.into_iter().enumerate() {
        deviations[variable.index()] = moved[place];
    }
    deviations
}

/// A first guess of the state, by what is measured at the start.
pub(crate) fn initial_state(run: &RunModel<'_>) -> Option<FilterState> {
    let record = run.record;
    let time_s = record.mesh.time_s(0);
    let read = |output: usize| {
        let series = record.outputs.get(output).and_then(Option::as_ref)?;
        Some((start_reading(series, time_s) - run.bias[output]) / run.factor[output])
    };
    let trim = run.trim;
    let speed = read(TAS_OUTPUT).unwrap_or(trim.airspeed());
    let alpha = read(ALPHA_OUTPUT).unwrap_or(trim.incidence());
    let beta = read(BETA_OUTPUT).unwrap_or(trim.sideslip());
    let mut x = [0.0; STATES];
    x[VELOCITY..VELOCITY + 3].copy_from_slice(&start_velocity(speed, alpha, beta));
    for (output, x) in x.iter_mut().enumerate().take(9).skip(3) {
        const THETA_OUTPUT: usize = ATTITUDE_OUTPUT + 1;
        let at_trim = match output {
            ATTITUDE_OUTPUT => trim.phi,
            THETA_OUTPUT => trim.theta,
            _ => 0.0,
        };
        *x = read(output).unwrap_or(at_trim);
    }
    x[ALTITUDE] = read(ALTITUDE_OUTPUT).unwrap_or(0.0);
    x.iter().all(|x| x.is_finite()).then_some(x)
}

/// Rate of change of an axis's force or moment by the controls and the rotor.
pub(crate) fn force_rate(here: &OperatingPoint, axis: usize, turning: &InputVector) -> f64 {
    let blades = Variable::CONTROLS.into_iter().zip(turning).map(|(variable, rate)| here.by[axis][variable.index()] * rate);
    blades.sum::<f64>() + here.by_rotor[axis] * turning[ROTOR] + here.by_rate[axis] * turning[ROTOR_ACCELERATION]
}
