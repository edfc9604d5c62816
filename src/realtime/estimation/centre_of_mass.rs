//! From the accelerometers, which the filter follows, to the centre of mass, of which everything else speaks.
//!
//! Consumes the filter's state and standard deviations, s the accelerometers' position; produces the published state.
//!     v_cm = v - omega x s,     a_cm = a - omega' x s - omega x (omega x s)                        (1)
//! The standard deviations are those where the accelerometers stand.

use super::ekf::Ekf;
use super::fixed_lag::SmoothedPoint;
use super::process::{
    ACCELEROMETER_BIAS, ALTITUDE, ANGULAR_ACCELERATION, ATTITUDE, GYRO_BIAS, MOVING, RATES, SPECIFIC_FORCE, State, VELOCITY,
};
use super::record::{LaggedRecord, StateRecord};
use crate::flight::run::RunGeometry;

/// Velocity of the centre of mass from that of the accelerometers: v - omega x s, s where they stand.
pub(crate) fn centre_velocity(x: &State, geometry: &RunGeometry) -> [f64; 3] {
    let [u, v, w, _, _, _, _, p, q, r, ..] = *x;
    let [ax, ay, az] = geometry.accelerometer_position_m;
    [u - (q * az - r * ay), v - (r * ax - p * az), w - (p * ay - q * ax)]
}

/// Specific force at the centre of mass: a - omega' x s - omega x (omega x s), s where the accelerometers stand.
pub(crate) fn centre_force(force: [f64; 3], rates: [f64; 3], slopes: [f64; 3], geometry: &RunGeometry) -> [f64; 3] {
    let ([ax, ay, az], [p, q, r], [dp, dq, dr]) = (force, rates, slopes);
    let [x, y, z] = geometry.accelerometer_position_m;
    [
        ax + (q * q + r * r) * x - (p * q - dr) * y - (p * r + dq) * z,
        ay - (p * q + dr) * x + (p * p + r * r) * y - (q * r - dp) * z,
        az - (p * r - dq) * x - (q * r + dp) * y + (p * p + q * q) * z,
    ]
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
        specific_force: centre_force(three(SPECIFIC_FORCE), three(RATES), three(ANGULAR_ACCELERATION), geometry),
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
