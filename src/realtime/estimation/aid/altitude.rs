//! Pressure altitude as a measurement of altitude, read as it is.

use crate::realtime::estimation::aid::prediction::Prediction;
use crate::realtime::estimation::config::Noise;
use crate::realtime::estimation::process::{ALTITUDE, STATES, State};

/// Altitude with its row of H.
pub fn predict(state: &State, noise: &Noise) -> Prediction {
    let mut row = [0.0; STATES];
    row[ALTITUDE] = 1.0;
    Prediction { value: state[ALTITUDE], row, noise_var: noise.altitude_std * noise.altitude_std, wraps: false }
}
