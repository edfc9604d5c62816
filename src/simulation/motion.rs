//! The rigid body's motion: kinematics that hold whatever the forces are.
//!
//! Consumes the state, specific force (m/s^2) and angular acceleration (rad/s^2), body axes; produces its rate of change:
//!     du/dt = -w q + v r + ax - g sin(theta)                                             (1)
//!     dv/dt = -u r + w p + ay + g cos(theta) sin(phi)                                    (2)
//!     dw/dt = -v p + u q + az + g cos(theta) cos(phi)                                    (3)
//!     dphi/dt = p + q sin(phi) tan(theta) + r cos(phi) tan(theta)                        (4)
//!     dtheta/dt = q cos(phi) - r sin(phi)                                                (5)
//!     dpsi/dt = q sin(phi) / cos(theta) + r cos(phi) / cos(theta)                        (6)
//!     daltitude/dt = u sin(theta) - v sin(phi) cos(theta) - w cos(phi) cos(theta)        (7)
//! Source: Padfield et al. 1987, (1) to (6); (7) is the vertical row of the same rotation.
//! Numerics: (4) and (6) have no value at theta = +-90 degrees; the flight ends before it (`integrate`).

use crate::flight::unit::STANDARD_GRAVITY;

/// How many numbers the motion has.
pub const MOTION_STATES: usize = 10;

/// Velocity, rates, attitude and height of the body.
#[derive(Clone, Copy, Debug, PartialEq, Default)]
pub struct Motion {
    /// Velocity of the centre of mass u, v, w, body axes, m/s, relative to air without gusts.
    pub velocity: [f64; 3],
    /// Rates p, q, r, rad/s.
    pub rates: [f64; 3],
    /// Bank, pitch attitude and heading, rad; not wrapped.
    pub attitude: [f64; 3],
    /// Height, m.
    pub altitude: f64,
}

impl Motion {
    /// As one vector, in the order of the fields.
    pub fn to_vector(self) -> [f64; MOTION_STATES] {
        let ([u, v, w], [p, q, r], [phi, theta, psi]) = (self.velocity, self.rates, self.attitude);
        [u, v, w, p, q, r, phi, theta, psi, self.altitude]
    }

    /// From one vector, in the order of the fields.
    pub fn from_vector([u, v, w, p, q, r, phi, theta, psi, altitude]: [f64; MOTION_STATES]) -> Self {
        Motion { velocity: [u, v, w], rates: [p, q, r], attitude: [phi, theta, psi], altitude }
    }

    /// Rate of change, equations (1) to (7), as a motion per second.
    pub fn rate_of_change(&self, specific_force: [f64; 3], angular_acceleration: [f64; 3]) -> Motion {
        let ([u, v, w], [p, q, r], [phi, theta, _]) = (self.velocity, self.rates, self.attitude);
        let [ax, ay, az] = specific_force;
        let g = STANDARD_GRAVITY;
        let (sin_phi, cos_phi) = libm::sincos(phi);
        let (sin_theta, cos_theta) = libm::sincos(theta);
        let turning = q * sin_phi + r * cos_phi;
        Motion {
            velocity: [
                -w * q + v * r + ax - g * sin_theta,
                -u * r + w * p + ay + g * cos_theta * sin_phi,
                -v * p + u * q + az + g * cos_theta * cos_phi,
            ],
            rates: angular_acceleration,
            attitude: [p + turning * sin_theta / cos_theta, q * cos_phi - r * sin_phi, turning / cos_theta],
            altitude: u * sin_theta - v * sin_phi * cos_theta - w * cos_phi * cos_theta,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn at_rest_on_the_ground_nothing_changes() {
        let still = Motion { attitude: [0.3, -0.2, 1.0], ..Motion::default() };
        let (g, [phi, theta, _]) = (STANDARD_GRAVITY, still.attitude);
        let support = [g * theta.sin(), -g * theta.cos() * phi.sin(), -g * theta.cos() * phi.cos()];
        let change = still.rate_of_change(support, [0.0; 3]).to_vector();
        assert!(change.iter().all(|rate| rate.abs() < 1e-14), "{change:?}");
    }

    #[test]
    fn a_level_turn_keeps_its_attitude() {
        // Bank phi at speed V: tan(phi) = V omega / g; rates are omega resolved into body axes.
        let (speed, omega) = (60.0, 0.1);
        let phi = (speed * omega / STANDARD_GRAVITY).atan();
        let turn = Motion {
            velocity: [speed, 0.0, 0.0],
            rates: [0.0, omega * phi.sin(), omega * phi.cos()],
            attitude: [phi, 0.0, 0.4],
            altitude: 100.0,
        };
        let change = turn.rate_of_change([0.0, 0.0, -STANDARD_GRAVITY / phi.cos()], [0.0; 3]);
        assert!(change.velocity.iter().all(|rate| rate.abs() < 1e-13), "{change:?}");
        assert!(change.attitude[0].abs() < 1e-15 && change.attitude[1].abs() < 1e-15);
        assert!((change.attitude[2] - omega).abs() < 1e-15 && change.altitude == 0.0);
        assert_eq!(Motion::from_vector(turn.to_vector()), turn);
    }
}
