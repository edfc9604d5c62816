//! Rigid-body kinematics as the filter's process: (1) to (6) of Padfield et al. 1987 and altitude, driven by accelerations
//! that are states themselves.
//!
//! Consumes the state \[25\]; produces the rate of change f of its moving part \[16\] and the Jacobian of f.
//!     (u v w)', (phi theta psi)', h': (1) to (7) of `kinematics`
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
//! Source: Padfield et al. 1987, (1) to (6) and 2.2.4.
//! Numerics: (4) and (6) have a pole at theta = +-90 deg; [`rate`] returns `None` within 3 deg of it.

use crate::dynamics::kinematics::{Attitude, velocity_rate, velocity_rate_by_rates, velocity_rate_by_velocity};

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
    let attitude = Attitude::regular(phi, theta)?;
    let gravity = attitude.gravity();
    // Specific force and gravity, which cancel where the force is not measured.
    let force = core::array::from_fn(|i| if measured[i] { state[SPECIFIC_FORCE + i] + gravity[i] } else { 0.0 });
    let (velocity, rates) = ([u, v, w], [p, q, r]);
    let [du, dv, dw] = velocity_rate(velocity, rates, force);
    let [dphi, dtheta, dpsi] = attitude.euler_rates(rates);
    Some([du, dv, dw, dphi, dtheta, dpsi, attitude.climb(velocity), dp, dq, dr])
}

/// Jacobian of (1) to (7) with respect to the moving states; `measured` as in [`rate`].
///
/// Returns `None` where [`rate`] does.
pub fn jacobian(state: &State, measured: &[bool; 3]) -> Option<Jacobian> {
    let [u, v, w, phi, theta, _, _, p, q, r, ..] = *state;
    let attitude = Attitude::regular(phi, theta)?;
    let (velocity, rates) = ([u, v, w], [p, q, r]);
    let (by_velocity, by_rates) = (velocity_rate_by_velocity(rates), velocity_rate_by_rates(velocity));
    let gravity = attitude.gravity_partials();
    let euler = attitude.euler_partials(rates);
    let mut a = [[0.0; MOVING]; NAVIGATION];
    for i in 0..3 {
        a[i][VELOCITY..VELOCITY + 3].copy_from_slice(&by_velocity[i]);
        a[i][RATES..RATES + 3].copy_from_slice(&by_rates[i]);
        // What balances gravity takes gravity's derivatives away.
        if measured[i] {
            a[i][ATTITUDE..ATTITUDE + 2].copy_from_slice(&gravity[i]);
            a[i][SPECIFIC_FORCE + i] = 1.0;
        }
        let row = &mut a[ATTITUDE + i];
        row[ATTITUDE..ATTITUDE + 2].copy_from_slice(&euler.by_attitude[i]);
        row[RATES..RATES + 3].copy_from_slice(&euler.by_rates[i]);
    }
    a[ALTITUDE][VELOCITY..VELOCITY + 3].copy_from_slice(&attitude.climb_by_vector());
    a[ALTITUDE][ATTITUDE..ATTITUDE + 2].copy_from_slice(&attitude.climb_by_attitude(velocity));
    Some(a)
}
