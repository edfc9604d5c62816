//! Aids: one file a measurement, each with its prediction, its row of H and its noise.
//!
//! In: the state, the rates of the same instant, where the instruments stand. Out: a [`Prediction`].
//! Assumed: the instruments' positions are those of the run. Refused: a flow angle or airspeed below the speed at which
//! it means anything (`None`, and the aid is not fused).

pub mod airspeed;
pub mod altitude;
pub mod attitude;
pub mod flow_angle;

use super::config::Noise;
use super::process::{GYRO_BIAS, Input, STATES, State, VELOCITY};
use super::record::Aid;
use crate::flight::run::RunGeometry;

/// Airspeed below which flow angles and airspeed are not used, m/s.
pub const AIRSPEED_MIN_M_S: f64 = 5.0;

/// What an aid should read, and how that depends on the state.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Prediction {
    /// Predicted reading.
    pub value: f64,
    /// Row of H \[13\]: derivative of the reading with respect to the state.
    pub row: [f64; STATES],
    /// Variance of the reading's noise, the share of gyro noise through the instrument's arm included.
    pub noise_var: f64,
    /// Whether the reading is an angle, so that differences are to be wrapped to +-pi.
    pub wraps: bool,
}

/// Prediction of one aid from the state and the measured inputs of the same instant.
pub fn predict(aid: Aid, state: &State, measured: &Input, geometry: &RunGeometry, noise: &Noise) -> Option<Prediction> {
    match aid {
        Aid::Airspeed => airspeed::predict(&LocalVelocity::at([0.0; 3], state, measured, geometry, noise), noise),
        Aid::Incidence => {
            flow_angle::predict_incidence(&LocalVelocity::at(geometry.vane_position_m, state, measured, geometry, noise), noise)
        }
        Aid::Sideslip => {
            flow_angle::predict_sideslip(&LocalVelocity::at(geometry.vane_position_m, state, measured, geometry, noise), noise)
        }
        Aid::Bank => Some(attitude::predict(0, state, noise.bank_std)),
        Aid::Pitch => Some(attitude::predict(1, state, noise.pitch_std)),
        Aid::Heading => Some(attitude::predict(2, state, noise.heading_std)),
        Aid::Altitude => Some(altitude::predict(state, noise)),
    }
}

/// Air velocity at a point of the aircraft, body axes, with its derivatives:
///
/// u_l = u + q z - r y,  v_l = v + r x - p z,  w_l = w + p y - q x, for (x, y, z) from the accelerometers, whose velocity
/// the filter carries, to the point.
#[derive(Clone, Copy, Debug)]
pub struct LocalVelocity {
    velocity: [f64; 3],
    arm: [f64; 3],
    gyro_var: f64,
}

impl LocalVelocity {
    /// At `position` from the centre of mass.
    fn at(position: [f64; 3], state: &State, measured: &Input, geometry: &RunGeometry, noise: &Noise) -> Self {
        let [x, y, z]: [f64; 3] = core::array::from_fn(|i| position[i] - geometry.accelerometer_position_m[i]);
        let [p, q, r]: [f64; 3] = core::array::from_fn(|i| measured[3 + i] - state[GYRO_BIAS + i]);
        let velocity =
            [state[VELOCITY] + q * z - r * y, state[VELOCITY + 1] + r * x - p * z, state[VELOCITY + 2] + p * y - q * x];
        LocalVelocity { velocity, arm: [x, y, z], gyro_var: noise.gyro_std * noise.gyro_std }
    }

    /// Row of H for a reading whose derivative with respect to the local velocity is `slope`, and the variance that gyro
    /// noise brings into its prediction.
    fn row(&self, slope: [f64; 3]) -> ([f64; STATES], f64) {
        let [x, y, z] = self.arm;
        let [su, sv, sw] = slope;
        // Derivatives with respect to p, q, r; a bias lowers the rate by as much.
        let by_rate = [sw * y - sv * z, su * z - sw * x, sv * x - su * y];
        let mut row = [0.0; STATES];
        row[VELOCITY..VELOCITY + 3].copy_from_slice(&slope);
        let mut var = 0.0;
        for (i, slope) in by_rate.into_iter().enumerate() {
            row[GYRO_BIAS + i] = -slope;
            var += slope * slope * self.gyro_var;
        }
        (row, var)
    }
}
