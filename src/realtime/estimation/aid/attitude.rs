//! Attitude gyros as measurements of the Euler angles: phi, theta, psi read as they are.

use crate::realtime::estimation::aid::prediction::Prediction;
use crate::realtime::estimation::process::{ATTITUDE, STATES, State};

/// Angle number `which` (0 phi, 1 theta, 2 psi) with its row of H.
pub fn predict(which: usize, state: &State, std: f64) -> Prediction {
    let mut row = [0.0; STATES];
    row[ATTITUDE + which] = 1.0;
    Prediction { value: state[ATTITUDE + which], row, noise_var: std * std, wraps: true }
}
