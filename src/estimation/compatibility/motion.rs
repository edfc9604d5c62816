//! The kinematic model of the check: how the measured rates and specific forces move an aircraft, and what is seen of it.
//!
//! Consumes the state \[u v w phi theta psi h wind\] of the place where the accelerometers stand (m/s body axes through the
//! air, rad, m) and the inputs \[ax ay az p q r\] (m/s^2, rad/s); produces rates of change, outputs and the Jacobians of both.
//!     u' = v r - w q + ax - g sin(theta)           phi' = p + (q sin(phi) + r cos(phi)) tan(theta)          (1)
//!     v' = w p - u r + ay + g cos(theta) sin(phi)  theta' = q cos(phi) - r sin(phi)
//!     w' = u q - v p + az + g cos(theta) cos(phi)  psi' = (q sin(phi) + r cos(phi))/cos(theta)
//!     h' = u sin(theta) - (v sin(phi) + w cos(phi)) cos(theta) + wind             wind' = 0
//! At rho from that place the velocity is V + omega x rho, and the altitude
//!     h + rho_x sin(theta) - (rho_y sin(phi) + rho_z cos(phi)) cos(theta)                                   (2)
//! Source: P. G. Hamel and R. V. Jategaonkar, Evolution of Flight Vehicle System Identification, J. Aircraft 33(1), 1996
//! (flight path reconstruction); V. Klein and E. A. Morelli, Aircraft System Identification, 2nd ed. 2016, ch. 10.
//! Numerics: (1) has a pole at theta = +-90 deg; `None` within 3 deg of it, and where the aircraft hardly moves forward.

use crate::flight::unit::STANDARD_GRAVITY as G0;

/// Number of states.
pub const STATES: usize = 8;
const COS_THETA_MIN: f64 = 0.05;
const SPEED_MIN: f64 = 2.0;

/// Rate of change of the state, (1).
pub fn rate(x: &[f64; STATES], input: &[f64; 6]) -> Option<[f64; STATES]> {
    let [u, v, w, phi, theta, _, _, wind] = *x;
    let [ax, ay, az, p, q, r] = *input;
    let (sp, cp) = libm::sincos(phi);
    let (st, ct) = libm::sincos(theta);
    if !(ct > COS_THETA_MIN) {
        return None;
    }
    let turn = q * sp + r * cp;
    Some([
        v * r - w * q + ax - G0 * st,
        w * p - u * r + ay + G0 * ct * sp,
        u * q - v * p + az + G0 * ct * cp,
        p + turn * st / ct,
        q * cp - r * sp,
        turn / ct,
        u * st - (v * sp + w * cp) * ct + wind,
        0.0,
    ])
}

/// Jacobians of (1): by the state, by the inputs.
pub type Jacobians = ([[f64; STATES]; STATES], [[f64; 6]; STATES]);

/// Jacobians of (1).
pub fn jacobians(x: &[f64; STATES], input: &[f64; 6]) -> Option<Jacobians> {
    let [u, v, w, phi, theta, ..] = *x;
    let [_, _, _, p, q, r] = *input;
    let (sp, cp) = libm::sincos(phi);
    let (st, ct) = libm::sincos(theta);
    if !(ct > COS_THETA_MIN) {
        return None;
    }
    let tt = st / ct;
    let (turn, lean) = (q * sp + r * cp, q * cp - r * sp);
    let a = [
        [0.0, r, -q, 0.0, -G0 * ct, 0.0, 0.0, 0.0],
        [-r, 0.0, p, G0 * ct * cp, -G0 * st * sp, 0.0, 0.0, 0.0],
        [q, -p, 0.0, -G0 * ct * sp, -G0 * st * cp, 0.0, 0.0, 0.0],
        [0.0, 0.0, 0.0, lean * tt, turn * (1.0 + tt * tt), 0.0, 0.0, 0.0],
        [0.0, 0.0, 0.0, -turn, 0.0, 0.0, 0.0, 0.0],
        [0.0, 0.0, 0.0, lean / ct, turn * tt / ct, 0.0, 0.0, 0.0],
        [st, -sp * ct, -cp * ct, (w * sp - v * cp) * ct, u * ct + (v * sp + w * cp) * st, 0.0, 0.0, 1.0],
        [0.0; STATES],
    ];
    let g = [
        [1.0, 0.0, 0.0, 0.0, -w, v],
        [0.0, 1.0, 0.0, w, 0.0, -u],
        [0.0, 0.0, 1.0, -v, u, 0.0],
        [0.0, 0.0, 0.0, 1.0, sp * tt, cp * tt],
        [0.0, 0.0, 0.0, 0.0, cp, -sp],
        [0.0, 0.0, 0.0, 0.0, sp / ct, cp / ct],
        [0.0; 6],
        [0.0; 6],
    ];
    Some((a, g))
}

/// An output without instrument: its value and its derivatives.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Seen {
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
pub fn seen(output: usize, x: &[f64; STATES], omega: [f64; 3], rho: [f64; 3]) -> Option<Seen> {
    let mut seen = Seen::default();
    match output {
        0..=2 => {
            let [p, q, r] = omega;
            let [rx, ry, rz] = rho;
            let u = x[0] + q * rz - r * ry;
            let v = x[1] + r * rx - p * rz;
            let w = x[2] + p * ry - q * rx;
            let s2 = u * u + w * w;
            let speed2 = s2 + v * v;
            let (s, speed) = (libm::sqrt(s2), libm::sqrt(speed2));
            if !(u > SPEED_MIN) {
                return None;
            }
            let (value, slope) = match output {
                0 => (speed, [u / speed, v / speed, w / speed]),
                1 => (libm::atan2(w, u), [-w / s2, 0.0, u / s2]),
                _ => (libm::atan2(v, s), [-v * u / (s * speed2), s / speed2, -v * w / (s * speed2)]),
            };
            seen.value = value;
            let [a, b, c] = slope;
            seen.by_state = [a, b, c, 0.0, 0.0, 0.0, 0.0, 0.0];
            seen.by_place = [b * r - c * q, c * p - a * r, a * q - b * p];
            seen.by_rates = [c * ry - b * rz, a * rz - c * rx, b * rx - a * ry];
        }
        3..=5 => {
            seen.value = x[output];
            seen.by_state[output] = 1.0;
        }
        _ => {
            let (sp, cp) = libm::sincos(x[3]);
            let (st, ct) = libm::sincos(x[4]);
            let [rx, ry, rz] = rho;
            let across = ry * sp + rz * cp;
            seen.value = x[6] + rx * st - across * ct;
            seen.by_state[3] = -(ry * cp - rz * sp) * ct;
            seen.by_state[4] = rx * ct + across * st;
            seen.by_state[6] = 1.0;
            seen.by_place = [st, -sp * ct, -cp * ct];
        }
    }
    Some(seen)
}
