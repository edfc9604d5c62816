//! Aids: one file a measurement, each with its prediction, its row of H and its noise.
//!
//! In: the state and where the instruments stand. Out: a [`Prediction`].
//! Assumed: the instruments' positions are those of the run. Refused: a flow angle or airspeed below the speed at which
//! it means anything (`None`, and the aid is not fused).

pub mod airspeed;
pub mod altitude;
pub mod attitude;
pub mod flow_angle;
pub mod inertial;

use super::config::Noise;
use super::process::{RATES, SCALE_ERROR, STATES, State, VELOCITY};
use super::record::Aid;
use crate::flight::run::RunGeometry;

/// Airspeed below which flow angles and airspeed are not used, m/s.
pub const AIRSPEED_MIN_M_S: f64 = 5.0;

/// What an aid should read, and how that depends on the state.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Prediction {
    /// Predicted reading.
    pub value: f64,
    /// Row of H \[25\]: derivative of the reading with respect to the state.
    pub row: [f64; STATES],
    /// Variance of the reading's noise.
    pub noise_var: f64,
    /// Whether the reading is an angle, so that differences are to be wrapped to +-pi.
    pub wraps: bool,
}

impl Prediction {
    /// The same through an instrument whose scale error is state `SCALE_ERROR + place`: (1 + e) times the reading.
    fn scaled(mut self, place: usize, state: &State) -> Self {
        let scale = 1.0 + state[SCALE_ERROR + place];
        for entry in &mut self.row {
            *entry *= scale;
        }
        self.row[SCALE_ERROR + place] = self.value;
        self.value *= scale;
        self
    }
}

/// Prediction of one aid from the state.
pub fn predict(aid: Aid, state: &State, geometry: &RunGeometry, noise: &Noise) -> Option<Prediction> {
    let centre = || LocalVelocity::at([0.0; 3], state, geometry);
    let vane = || LocalVelocity::at(geometry.vane_position_m, state, geometry);
    match aid {
        Aid::Airspeed => airspeed::predict(&centre(), noise).map(|reading| reading.scaled(0, state)),
        Aid::Incidence => flow_angle::predict_incidence(&vane(), noise).map(|reading| reading.scaled(1, state)),
        Aid::Sideslip => flow_angle::predict_sideslip(&vane(), noise).map(|reading| reading.scaled(2, state)),
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
}

impl LocalVelocity {
    /// At `position` from the centre of mass.
    fn at(position: [f64; 3], state: &State, geometry: &RunGeometry) -> Self {
        let [x, y, z]: [f64; 3] = core::array::from_fn(|i| position[i] - geometry.accelerometer_position_m[i]);
        let [p, q, r]: [f64; 3] = core::array::from_fn(|i| state[RATES + i]);
        let velocity =
            [state[VELOCITY] + q * z - r * y, state[VELOCITY + 1] + r * x - p * z, state[VELOCITY + 2] + p * y - q * x];
        LocalVelocity { velocity, arm: [x, y, z] }
    }

    /// Row of H for a reading whose derivative with respect to the local velocity is `slope`.
    fn row(&self, slope: [f64; 3]) -> [f64; STATES] {
        let [x, y, z] = self.arm;
        let [su, sv, sw] = slope;
        let mut row = [0.0; STATES];
        row[VELOCITY..VELOCITY + 3].copy_from_slice(&slope);
        row[RATES..RATES + 3].copy_from_slice(&[sw * y - sv * z, su * z - sw * x, sv * x - su * y]);
        row
    }
}
