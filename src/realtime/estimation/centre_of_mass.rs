//! From the accelerometers, which the filter follows, to the centre of mass, of which everything else speaks.
//!
//! Consumes the filter's state and standard deviations, and the accelerometers' position; produces the published state by (1) and
//! (6) of `sensors`, solved for the foot of the arm.
//! The standard deviations are those where the accelerometers stand.

use super::ekf::Ekf;
use super::fixed_lag::SmoothedPoint;
use super::process::{
    ACCELEROMETER_BIAS, ALTITUDE, ANGULAR_ACCELERATION, ATTITUDE, GYRO_BIAS, MOVING, RATES, SPECIFIC_FORCE, State, VELOCITY,
};
use super::record::{LaggedRecord, StateRecord};
use crate::dynamics::sensors::{specific_force_at_foot, velocity_at_foot};
use crate::flight::run::RunGeometry;

pub(crate) fn centre_velocity(x: &State, geometry: &RunGeometry) -> [f64; 3] {
    let [u, v, w, _, _, _, _, p, q, r, ..] = *x;
    velocity_at_foot([u, v, w], [p, q, r], geometry.accelerometer_position_m)
}

/// The published state from the filter's, with its standard deviations.
pub(crate) fn state_record(time_s: f64, x: &State, std: &State, geometry: &RunGeometry) -> StateRecord {
    let three = |offset: usize| core::array::from_fn(|i| x[offset + i]);
    let three_std = |offset: usize| core::array::from_fn(|i| std[offset + i]);
    StateRecord {
        time_s,
        velocity: centre_velocity(x, geometry),
        velocity_std: three_std(VELOCITY),
        rates: three(RATES),
        rates_std: three_std(RATES),
        angular_acceleration: three(ANGULAR_ACCELERATION),
        angular_acceleration_std: three_std(ANGULAR_ACCELERATION),
        specific_force: specific_force_at_foot(
            three(SPECIFIC_FORCE),
            three(RATES),
            three(ANGULAR_ACCELERATION),
            geometry.accelerometer_position_m,
        ),
        specific_force_std: three_std(SPECIFIC_FORCE),
        attitude: three(ATTITUDE),
        attitude_std: three_std(ATTITUDE),
        altitude: x[ALTITUDE],
        altitude_std: std[ALTITUDE],
        accelerometer_bias: three(ACCELEROMETER_BIAS),
        accelerometer_bias_std: three_std(ACCELEROMETER_BIAS),
        gyro_bias: three(GYRO_BIAS),
        gyro_bias_std: three_std(GYRO_BIAS),
        fused: 0,
    }
}

/// A smoothed instant, `now_s` the time of the newest sample; what does not move is as the filter knows it now.
pub(crate) fn lagged(point: &SmoothedPoint, now_s: f64, ekf: &Ekf, geometry: &RunGeometry) -> LaggedRecord {
    let (mut x, mut std) = (*ekf.state(), ekf.stds());
    x[..MOVING].copy_from_slice(&point.x);
    for (std, var) in std.iter_mut().zip(point.var) {
        *std = libm::sqrt(var);
    }
    LaggedRecord { state: state_record(point.time_s, &x, &std, geometry), lag_s: now_s - point.time_s }
}
