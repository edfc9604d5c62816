//! Gyros and accelerometers as measurements: each reads its rate or specific force and its bias.
//!
//! Consumes the state; produces the predicted reading and its row of H. An accelerometer stands where the state's velocity
//! and specific force are, so it has no arm.

use crate::flight::channel::Channel;
use crate::realtime::estimation::aid::prediction::Prediction;
use crate::realtime::estimation::config::Noise;
use crate::realtime::estimation::process::{ACCELEROMETER_BIAS, GYRO_BIAS, RATES, SPECIFIC_FORCE, STATES, State};

/// The inertial channels in the order in which they are fused: p q r, ax ay az.
pub const INERTIAL: [Channel; 6] = [Channel::P, Channel::Q, Channel::R, Channel::Ax, Channel::Ay, Channel::Az];

/// Reading of inertial channel `place` of [`INERTIAL`] with its row of H.
pub fn predict(place: usize, state: &State, noise: &Noise) -> Prediction {
    let gyro = place < 3;
    let (truth, bias) =
        if gyro { (RATES + place, GYRO_BIAS + place) } else { (SPECIFIC_FORCE + place - 3, ACCELEROMETER_BIAS + place - 3) };
    let mut row = [0.0; STATES];
    row[truth] = 1.0;
    row[bias] = 1.0;
    let std = if gyro { noise.gyro_std[place] } else { noise.accelerometer_std[place - 3] };
    Prediction { value: state[truth] + state[bias], row, noise_var: std * std, wraps: false }
}
