//! Rigid-body kinematics as the filter's process: equations (1) to (6) of the paper and altitude, driven by accelerations
//! that are states themselves.
//!
//! Consumes the state \[25\]; produces the rate of change f of its moving part \[16\] and the Jacobian of f.
//!     u' = -w q + v r + ax - g sin(theta)                                                         (1)
//!     v' = -u r + w p + ay + g cos(theta) sin(phi)                                                (2)
//!     w' = -v p + u q + az + g cos(theta) cos(phi)                                                (3)
//!     phi'   = p + (q sin(phi) + r cos(phi)) tan(theta)                                           (4)
//!     theta' = q cos(phi) - r sin(phi)                                                            (5)
//!     psi'   = (q sin(phi) + r cos(phi)) / cos(theta)                                             (6)
//!     h' = u sin(theta) - (v sin(phi) + w cos(phi)) cos(theta)                                    (7)
//!     p' = p-dot, q' = q-dot, r' = r-dot                                                          (8)
//!     p-dot, q-dot, r-dot, ax, ay, az: random walks, a' = white noise of intensity q_a            (9)
//! | symbol | place | unit | meaning |
//! | --- | --- | --- | --- |
//! | u v w | 0 | m/s | velocity through the air of the point where the accelerometers stand, body axes |
//! | phi theta psi | 3 | rad | Euler angles |
//! | h | 6 | m | altitude (still air) |
//! | p q r | 7 | rad/s | body rates |
//! | p-dot q-dot r-dot | 10 | rad/s^2 | angular accelerations |
//! | ax ay az | 13 | m/s^2 | specific force where the accelerometers stand |
//! | b_a | 16 | m/s^2 | accelerometer biases |
//! | b_g | 19 | rad/s | gyro biases |
//! | e | 22 | 1 | scale errors of airspeed, incidence, sideslip: reading = (1 + e) truth |
//!
//! (1) to (3) hold for any point of a rigid body with the specific force felt *at that point*; following the
//! accelerometers instead of the centre of mass needs no angular acceleration.
//! A specific force that is not measured is none of (9): in (1) to (3) it balances gravity, and white noise takes its place.
//! Source: UK Research into System Identification for Helicopter Flight Mechanics (RAE/Glasgow), (1) to (6) and 2.2.4.
//! Numerics: (4) and (6) have a pole at theta = +-90 deg; [`rate`] returns `None` within 3 deg of it.

use crate::flight::unit::STANDARD_GRAVITY as G0;

/// Number of states.
pub const STATES: usize = 25;
/// Navigation states: they come first.
pub const NAVIGATION: usize = 7;
/// Navigation states, rates, angular accelerations and specific forces: what moves by (1) to (9).
pub const MOVING: usize = 16;

/// Offset of u, v, w.
pub const VELOCITY: usize = 0;
/// Offset of phi, theta, psi.
pub const ATTITUDE: usize = 3;
/// Offset of altitude.
pub const ALTITUDE: usize = 6;
/// Offset of p, q, r.
pub const RATES: usize = 7;
/// Offset of p-dot, q-dot, r-dot.
pub const ANGULAR_ACCELERATION: usize = 10;
/// Offset of ax, ay, az.
pub const SPECIFIC_FORCE: usize = 13;
/// Offset of the three accelerometer biases.
pub const ACCELEROMETER_BIAS: usize = 16;
/// Offset of the three gyro biases.
pub const GYRO_BIAS: usize = 19;
/// Offset of the scale errors of airspeed, incidence and sideslip.
pub const SCALE_ERROR: usize = 22;

/// cos(theta) below which the Euler angles are of no use.
const COS_THETA_MIN: f64 = 0.05;

/// The filter's state vector.
pub type State = [f64; STATES];

/// Rate of change of the navigation states and of the rates, (1) to (8).
pub type Rate = [f64; NAVIGATION + 3];

/// Jacobian of (1) to (7) with respect to the moving states.
pub type Jacobian = [[f64; MOVING]; NAVIGATION];

/// Rate of change of the navigation states and the rates, (1) to (8); `measured` says which specific forces are states.
///
/// Returns `None` too near theta = +-90 deg.
pub fn rate(state: &State, measured: &[bool; 3]) -> Option<Rate> {
    let [u, v, w, phi, theta, _, _, p, q, r, dp, dq, dr, ..] = *state;
    let (sin_phi, cos_phi) = libm::sincos(phi);
    let (sin_theta, cos_theta) = libm::sincos(theta);
    if !(cos_theta > COS_THETA_MIN) {
        return None;
    }
    // Specific force and gravity, which cancel where the force is not measured.
    let sum = |i: usize, gravity: f64| if measured[i] { state[SPECIFIC_FORCE + i] + gravity } else { 0.0 };
    let turn = q * sin_phi + r * cos_phi;
    Some([
        -w * q + v * r + sum(0, -G0 * sin_theta),
        -u * r + w * p + sum(1, G0 * cos_theta * sin_phi),
        -v * p + u * q + sum(2, G0 * cos_theta * cos_phi),
        p + turn * sin_theta / cos_theta,
        q * cos_phi - r * sin_phi,
        turn / cos_theta,
        u * sin_theta - (v * sin_phi + w * cos_phi) * cos_theta,
        dp,
        dq,
        dr,
    ])
}

/// Jacobian of (1) to (7) with respect to the moving states; `measured` as in [`rate`].
///
/// Returns `None` where [`rate`] does.
pub fn jacobian(state: &State, measured: &[bool; 3]) -> Option<Jacobian> {
    let [u, v, w, phi, theta, _, _, p, q, r, ..] = *state;
    let (sin_phi, cos_phi) = libm::sincos(phi);
    let (sin_theta, cos_theta) = libm::sincos(theta);
    if !(cos_theta > COS_THETA_MIN) {
        return None;
    }
    let tan_theta = sin_theta / cos_theta;
    let turn = q * sin_phi + r * cos_phi;
    let lean = q * cos_phi - r * sin_phi;
    let mut a = [[0.0; MOVING]; NAVIGATION];
    a[0][..10].copy_from_slice(&[0.0, r, -q, 0.0, -G0 * cos_theta, 0.0, 0.0, 0.0, -w, v]);
    let by_phi = G0 * cos_theta * cos_phi;
    a[1][..10].copy_from_slice(&[-r, 0.0, p, by_phi, -G0 * sin_theta * sin_phi, 0.0, 0.0, w, 0.0, -u]);
    let by_phi = -G0 * cos_theta * sin_phi;
    a[2][..10].copy_from_slice(&[q, -p, 0.0, by_phi, -G0 * sin_theta * cos_phi, 0.0, 0.0, -v, u, 0.0]);
    for (i, row) in a.iter_mut().take(3).enumerate() {
        if measured[i] {
            row[SPECIFIC_FORCE + i] = 1.0;
        } else {
            // What balances gravity takes gravity's derivatives away.
            row[ATTITUDE] = 0.0;
            row[ATTITUDE + 1] = 0.0;
        }
    }
    a[3][3..5].copy_from_slice(&[lean * tan_theta, turn * (1.0 + tan_theta * tan_theta)]);
    a[3][7..10].copy_from_slice(&[1.0, sin_phi * tan_theta, cos_phi * tan_theta]);
    a[4][3] = -turn;
    a[4][8..10].copy_from_slice(&[cos_phi, -sin_phi]);
    a[5][3..5].copy_from_slice(&[lean / cos_theta, turn * tan_theta / cos_theta]);
    a[5][8..10].copy_from_slice(&[sin_phi / cos_theta, cos_phi / cos_theta]);
    a[6][..5].copy_from_slice(&[
        sin_theta,
        -sin_phi * cos_theta,
        -cos_phi * cos_theta,
        (w * sin_phi - v * cos_phi) * cos_theta,
        u * cos_theta + (v * sin_phi + w * cos_phi) * sin_theta,
    ]);
    Some(a)
}
