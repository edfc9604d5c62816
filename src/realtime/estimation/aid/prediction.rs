//! What every aid has: a predicted reading with its row of H, and the air velocity where an instrument stands.

use crate::dynamics::sensors::{AirDataReading, velocity_at_arm};
use crate::flight::run::RunGeometry;
use crate::realtime::estimation::process::{RATES, SCALE_ERROR, STATES, State, VELOCITY};

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
    pub(super) fn scaled(mut self, place: usize, state: &State) -> Self {
        let scale = 1.0 + state[SCALE_ERROR + place];
        for entry in &mut self.row {
            *entry *= scale;
        }
        self.row[SCALE_ERROR + place] = self.value;
        self.value *= scale;
        self
    }
}

/// Air velocity at a point of the aircraft, body axes, by (1) of `sensors`; the arm is that from the accelerometers, whose
/// velocity the filter carries, to the point.
#[derive(Clone, Copy, Debug)]
pub struct LocalVelocity {
    pub(super) velocity: [f64; 3],
    arm: [f64; 3],
}

impl LocalVelocity {
    /// At `position` from the centre of mass.
    pub(super) fn at(position: [f64; 3], state: &State, geometry: &RunGeometry) -> Self {
        let arm = core::array::from_fn(|i| position[i] - geometry.accelerometer_position_m[i]);
        let [velocity, rates] = [VELOCITY, RATES].map(|from| core::array::from_fn(|i| state[from + i]));
        LocalVelocity { velocity: velocity_at_arm(velocity, rates, arm), arm }
    }

    /// Row of H of a reading of this velocity.
    pub(super) fn row(&self, reading: &AirDataReading) -> [f64; STATES] {
        let mut row = [0.0; STATES];
        row[VELOCITY..VELOCITY + 3].copy_from_slice(&reading.by_velocity);
        row[RATES..RATES + 3].copy_from_slice(&reading.by_rates(self.arm));
        row
    }
}
