//! The kinematic model of the check: how the measured rates and specific forces move an aircraft, and what is seen of it.
//!
//! Consumes the state \[u v w phi theta psi h wind\] of the place where the accelerometers stand (m/s body axes through the
//! air, rad, m) and the inputs \[ax ay az p q r\] (m/s^2, rad/s); produces rates of change, outputs and the Jacobians of both.
//!     velocity, attitude and height by (1) to (7) of `kinematics`, h' with the wind added, wind' = 0          (1)
//! At rho from that place the air data are those of (1) to (4) of `sensors`, and the altitude is
//!     h + rho_x sin(theta) - (rho_y sin(phi) + rho_z cos(phi)) cos(theta)                                   (2)
//! Source: P. G. Hamel and R. V. Jategaonkar, Evolution of Flight Vehicle System Identification, J. Aircraft 33(1), 1996
//! (flight path reconstruction); V. Klein and E. A. Morelli, Aircraft System Identification, 2nd ed. 2016, ch. 10.
//! Numerics: (1) has a pole at theta = +-90 deg; `None` within 3 deg of it, and where the aircraft hardly moves forward.

use crate::dynamics::kinematics::{Attitude, velocity_rate, velocity_rate_by_rates, velocity_rate_by_velocity};
use crate::dynamics::sensors::{AirData, velocity_at_arm};

/// Number of states.
pub const STATES: usize = 8;
const SPEED_MIN: f64 = 2.0;

/// Rate of change of the state, (1).
pub fn rate(x: &[f64; STATES], input: &[f64; 6]) -> Option<[f64; STATES]> {
    let [u, v, w, phi, theta, _, _, wind] = *x;
    let [ax, ay, az, p, q, r] = *input;
    let attitude = Attitude::regular(phi, theta)?;
    let (velocity, rates, [gx, gy, gz]) = ([u, v, w], [p, q, r], attitude.gravity());
    let [du, dv, dw] = velocity_rate(velocity, rates, [ax, ay, az]);
    let [dphi, dtheta, dpsi] = attitude.euler_rates(rates);
    Some([du + gx, dv + gy, dw + gz, dphi, dtheta, dpsi, attitude.climb(velocity) + wind, 0.0])
}

/// Jacobians of (1): by the state, by the inputs.
pub type Jacobians = ([[f64; STATES]; STATES], [[f64; 6]; STATES]);

/// Jacobians of (1).
pub fn jacobians(x: &[f64; STATES], input: &[f64; 6]) -> Option<Jacobians> {
    let [u, v, w, phi, theta, ..] = *x;
    let [_, _, _, p, q, r] = *input;
    let attitude = Attitude::regular(phi, theta)?;
    let (velocity, rates) = ([u, v, w], [p, q, r]);
    let (by_velocity, by_rates) = (velocity_rate_by_velocity(rates), velocity_rate_by_rates(velocity));
    let (gravity, euler) = (attitude.gravity_partials(), attitude.euler_partials(rates));
    let (mut a, mut g) = ([[0.0; STATES]; STATES], [[0.0; 6]; STATES]);
    for i in 0..3 {
        a[i][..3].copy_from_slice(&by_velocity[i]);
        a[i][3..5].copy_from_slice(&gravity[i]);
        a[3 + i][3..5].copy_from_slice(&euler.by_attitude[i]);
        g[i][i] = 1.0;
        g[i][3..].copy_from_slice(&by_rates[i]);
        g[3 + i][3..].copy_from_slice(&euler.by_rates[i]);
    }
    a[6][..3].copy_from_slice(&attitude.climb_by_vector());
    a[6][3..5].copy_from_slice(&attitude.climb_by_attitude(velocity));
    a[6][7] = 1.0;
    Some((a, g))
}

/// An output without instrument: its value and its derivatives.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Observation {
    /// The value.
    pub value: f64,
    /// By the state.
    pub by_state: [f64; STATES],
    /// By the place rho.
    pub by_place: [f64; 3],
    /// By p q r.
    pub by_rates: [f64; 3],
}

/// The output at a place (order of `OUTPUT_CHANNELS`: tas, alpha, beta, phi, theta, psi, altitude).
pub fn observe(output: usize, x: &[f64; STATES], omega: [f64; 3], rho: [f64; 3]) -> Option<Observation> {
    let mut observe = Observation::default();
    match output {
        0..=2 => {
            let velocity = velocity_at_arm([x[0], x[1], x[2]], omega, rho);
            if !(velocity[0] > SPEED_MIN) {
                return None;
            }
            let reading = AirData::ALL[output].reading(velocity);
            observe.value = reading.value;
            observe.by_state[..3].copy_from_slice(&reading.by_velocity);
            observe.by_place = reading.by_arm(omega);
            observe.by_rates = reading.by_rates(rho);
        }
        3..=5 => {
            observe.value = x[output];
            observe.by_state[output] = 1.0;
        }
        _ => {
            let attitude = Attitude::new(x[3], x[4]);
            let [by_phi, by_theta] = attitude.climb_by_attitude(rho);
            observe.value = attitude.height(x[6], rho);
            observe.by_state[3] = by_phi;
            observe.by_state[4] = by_theta;
            observe.by_state[6] = 1.0;
            observe.by_place = attitude.climb_by_vector();
        }
    }
    Some(observe)
}
