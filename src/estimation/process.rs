//! Rigid-body kinematics as the filter's process: equations (1) to (6) of the paper and altitude.
//!
//! Consumes the state \[13\] and the inputs (measured specific force and body rates); produces its rate of change f and the
//! Jacobians of f with respect to navigation states A [7 x 7] and inputs G [7 x 6].
//!     u' = -w q + v r + ax - g sin(theta)                                                         (1)
//!     v' = -u r + w p + ay + g cos(theta) sin(phi)                                                (2)
//!     w' = -v p + u q + az + g cos(theta) cos(phi)                                                (3)
//!     phi'   = p + (q sin(phi) + r cos(phi)) tan(theta)                                           (4)
//!     theta' = q cos(phi) - r sin(phi)                                                            (5)
//!     psi'   = (q sin(phi) + r cos(phi)) / cos(theta)                                             (6)
//!     h' = u sin(theta) - (v sin(phi) + w cos(phi)) cos(theta)                                    (7)
//! | symbol | unit | meaning |
//! | --- | --- | --- |
//! | u v w | m/s | velocity through the air of the point where the accelerometers stand, body axes |
//! | phi theta psi | rad | Euler angles |
//! | h | m | altitude (still air) |
//! | ax ay az, p q r | m/s^2, rad/s | measured less bias; the biases are states 7 to 12 |
//!
//! (1) to (3) hold for any point of a rigid body with the specific force felt *at that point*; following the
//! accelerometers instead of the centre of mass needs no angular acceleration.
//! Source: UK Research into System Identification for Helicopter Flight Mechanics (RAE/Glasgow), (1) to (6).
//! Numerics: (4) and (6) have a pole at theta = +-90 deg; [`rate`] returns `None` within 3 deg of it.

use crate::flight::unit::STANDARD_GRAVITY as G0;

/// Number of states.
pub const STATES: usize = 13;
/// Navigation states: they come first.
pub const NAVIGATION: usize = 7;
/// Inputs: three specific forces, three rates.
pub const INPUTS: usize = 6;

/// Offset of u, v, w.
pub const VELOCITY: usize = 0;
/// Offset of phi, theta, psi.
pub const ATTITUDE: usize = 3;
/// Offset of altitude.
pub const ALTITUDE: usize = 6;
/// Offset of the three accelerometer biases.
pub const ACCELEROMETER_BIAS: usize = 7;
/// Offset of the three gyro biases.
pub const GYRO_BIAS: usize = 10;

/// cos(theta) below which the Euler angles are of no use.
const COS_THETA_MIN: f64 = 0.05;

/// The filter's state vector.
pub type State = [f64; STATES];
/// ax ay az p q r.
pub type Input = [f64; INPUTS];

/// Rate of change of the navigation states, (1) to (7), for inputs already less bias.
///
/// Returns `None` too near theta = +-90 deg.
pub fn rate(state: &State, input: &Input) -> Option<[f64; NAVIGATION]> {
    let [u, v, w, phi, theta, ..] = *state;
    let [ax, ay, az, p, q, r] = *input;
    let (sin_phi, cos_phi) = libm::sincos(phi);
    let (sin_theta, cos_theta) = libm::sincos(theta);
    if !(cos_theta > COS_THETA_MIN) {
        return None;
    }
    let turn = q * sin_phi + r * cos_phi;
    Some([
        -w * q + v * r + ax - G0 * sin_theta,
        -u * r + w * p + ay + G0 * cos_theta * sin_phi,
        -v * p + u * q + az + G0 * cos_theta * cos_phi,
        p + turn * sin_theta / cos_theta,
        q * cos_phi - r * sin_phi,
        turn / cos_theta,
        u * sin_theta - (v * sin_phi + w * cos_phi) * cos_theta,
    ])
}

/// Jacobian of f with respect to the navigation states, A, and to the inputs, G.
pub type Jacobians = ([[f64; NAVIGATION]; NAVIGATION], [[f64; INPUTS]; NAVIGATION]);

/// Jacobians of [`rate`]: A with respect to the navigation states, G with respect to the inputs.
///
/// Returns `None` where [`rate`] does.
pub fn jacobians(state: &State, input: &Input) -> Option<Jacobians> {
    let [u, v, w, phi, theta, ..] = *state;
    let [_, _, _, p, q, r] = *input;
    let (sin_phi, cos_phi) = libm::sincos(phi);
    let (sin_theta, cos_theta) = libm::sincos(theta);
    if !(cos_theta > COS_THETA_MIN) {
        return None;
    }
    let tan_theta = sin_theta / cos_theta;
    let turn = q * sin_phi + r * cos_phi;
    let lean = q * cos_phi - r * sin_phi;
    let a = [
        [0.0, r, -q, 0.0, -G0 * cos_theta, 0.0, 0.0],
        [-r, 0.0, p, G0 * cos_theta * cos_phi, -G0 * sin_theta * sin_phi, 0.0, 0.0],
        [q, -p, 0.0, -G0 * cos_theta * sin_phi, -G0 * sin_theta * cos_phi, 0.0, 0.0],
        [0.0, 0.0, 0.0, lean * tan_theta, turn * (1.0 + tan_theta * tan_theta), 0.0, 0.0],
        [0.0, 0.0, 0.0, -turn, 0.0, 0.0, 0.0],
        [0.0, 0.0, 0.0, lean / cos_theta, turn * tan_theta / cos_theta, 0.0, 0.0],
        [
            sin_theta,
            -sin_phi * cos_theta,
            -cos_phi * cos_theta,
            (w * sin_phi - v * cos_phi) * cos_theta,
            u * cos_theta + (v * sin_phi + w * cos_phi) * sin_theta,
            0.0,
            0.0,
        ],
    ];
    let g = [
        [1.0, 0.0, 0.0, 0.0, -w, v],
        [0.0, 1.0, 0.0, w, 0.0, -u],
        [0.0, 0.0, 1.0, -v, u, 0.0],
        [0.0, 0.0, 0.0, 1.0, sin_phi * tan_theta, cos_phi * tan_theta],
        [0.0, 0.0, 0.0, 0.0, cos_phi, -sin_phi],
        [0.0, 0.0, 0.0, 0.0, sin_phi / cos_theta, cos_phi / cos_theta],
        [0.0; INPUTS],
    ];
    Some((a, g))
}

/// Inputs less the biases that the state holds.
pub fn unbiased(state: &State, measured: &Input) -> Input {
    core::array::from_fn(|i| measured[i] - state[ACCELEROMETER_BIAS + i])
}
