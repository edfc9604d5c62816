//! Rigid-body kinematics over a flat earth in still air: rates of velocity, attitude and height from rates and specific force.
//!
//! Consumes velocity u v w (m/s, body axes, any point of the body), rates p q r (rad/s), the specific force felt at that point
//! (m/s^2) and the attitude; produces rates of change and their partial derivatives.
//!     (u v w)' = (u v w) x (p q r) + (ax ay az) + g(phi, theta)                                     (1)-(3)
//!     g = G0 (-sin(theta), cos(theta) sin(phi), cos(theta) cos(phi))
//!     phi'   = p + (q sin(phi) + r cos(phi)) tan(theta)                                             (4)
//!     theta' = q cos(phi) - r sin(phi)                                                              (5)
//!     psi'   = (q sin(phi) + r cos(phi)) / cos(theta)                                               (6)
//!     h' = u sin(theta) - (v sin(phi) + w cos(phi)) cos(theta)                                      (7)
//! Source: Padfield et al. 1987, (1) to (6); (7) is the vertical row of the same rotation.
//! Numerics: (4) and (6) have a pole at theta = +-90 deg; there is no [`Attitude::regular`] within 3 deg of it.

use crate::flight::unit::STANDARD_GRAVITY as G0;

/// cos(theta) below which the Euler angles are of no use.
const COS_THETA_MIN: f64 = 0.05;

/// A 3 x 3 matrix, by rows.
pub type Square = [[f64; 3]; 3];

/// Bank and pitch attitude as sines and cosines.
#[derive(Clone, Copy, Debug)]
pub struct Attitude {
    sin_phi: f64,
    cos_phi: f64,
    sin_theta: f64,
    cos_theta: f64,
}

/// Partial derivatives of (4) to (6).
#[derive(Clone, Copy, Debug)]
pub struct EulerPartials {
    /// By phi and theta.
    pub by_attitude: [[f64; 2]; 3],
    /// By p q r.
    pub by_rates: Square,
}

/// (1) to (3): rate of change of the velocity by `force`, specific force with gravity or without.
#[inline]
pub fn velocity_rate([u, v, w]: [f64; 3], [p, q, r]: [f64; 3], force: [f64; 3]) -> [f64; 3] {
    [v * r - w * q + force[0], w * p - u * r + force[1], u * q - v * p + force[2]]
}

/// Partial derivatives of (1) to (3) by the velocity.
#[inline]
pub fn velocity_rate_by_velocity([p, q, r]: [f64; 3]) -> Square {
    [[0.0, r, -q], [-r, 0.0, p], [q, -p, 0.0]]
}

/// Partial derivatives of (1) to (3) by p q r.
#[inline]
pub fn velocity_rate_by_rates([u, v, w]: [f64; 3]) -> Square {
    [[0.0, -w, v], [w, 0.0, -u], [-v, u, 0.0]]
}

impl Attitude {
    /// At any attitude: for gravity and height.
    #[inline]
    pub fn new(phi: f64, theta: f64) -> Self {
        let (sin_phi, cos_phi) = libm::sincos(phi);
        let (sin_theta, cos_theta) = libm::sincos(theta);
        Attitude { sin_phi, cos_phi, sin_theta, cos_theta }
    }

    /// The same, where the Euler angles are of use; `None` too near theta = +-90 deg.
    #[inline]
    pub fn regular(phi: f64, theta: f64) -> Option<Self> {
        let attitude = Attitude::new(phi, theta);
        (attitude.cos_theta > COS_THETA_MIN).then_some(attitude)
    }

    /// Gravity in body axes, m/s^2.
    #[inline]
    pub fn gravity(&self) -> [f64; 3] {
        let Attitude { sin_phi, cos_phi, sin_theta, cos_theta } = *self;
        [-G0 * sin_theta, G0 * cos_theta * sin_phi, G0 * cos_theta * cos_phi]
    }

    /// Its partial derivatives by phi and theta.
    #[inline]
    pub fn gravity_partials(&self) -> [[f64; 2]; 3] {
        let Attitude { sin_phi, cos_phi, sin_theta, cos_theta } = *self;
        [
            [0.0, -G0 * cos_theta],
            [G0 * cos_theta * cos_phi, -G0 * sin_theta * sin_phi],
            [-G0 * cos_theta * sin_phi, -G0 * sin_theta * cos_phi],
        ]
    }

    /// (4) to (6).
    #[inline]
    pub fn euler_rates(&self, [p, q, r]: [f64; 3]) -> [f64; 3] {
        let Attitude { sin_phi, cos_phi, sin_theta, cos_theta } = *self;
        let turn = q * sin_phi + r * cos_phi;
        [p + turn * sin_theta / cos_theta, q * cos_phi - r * sin_phi, turn / cos_theta]
    }

    /// Partial derivatives of (4) to (6).
    #[inline]
    pub fn euler_partials(&self, [_, q, r]: [f64; 3]) -> EulerPartials {
        let Attitude { sin_phi, cos_phi, sin_theta, cos_theta } = *self;
        let tan_theta = sin_theta / cos_theta;
        let turn = q * sin_phi + r * cos_phi;
        let lean = q * cos_phi - r * sin_phi;
        EulerPartials {
            by_attitude: [
                [lean * tan_theta, turn * (1.0 + tan_theta * tan_theta)],
                [-turn, 0.0],
                [lean / cos_theta, turn * tan_theta / cos_theta],
            ],
            by_rates: [
                [1.0, sin_phi * tan_theta, cos_phi * tan_theta],
                [0.0, cos_phi, -sin_phi],
                [0.0, sin_phi / cos_theta, cos_phi / cos_theta],
            ],
        }
    }

    /// (7): rate of climb, m/s.
    #[inline]
    pub fn climb(&self, velocity: [f64; 3]) -> f64 {
        self.height(0.0, velocity)
    }

    /// Height, m, of the place at `x y z` (body axes) from one at `origin`.
    #[inline]
    pub fn height(&self, origin: f64, [x, y, z]: [f64; 3]) -> f64 {
        origin + x * self.sin_theta - (y * self.sin_phi + z * self.cos_phi) * self.cos_theta
    }

    /// Partial derivatives of (7) by the velocity, or of the height by the place.
    #[inline]
    pub fn climb_by_vector(&self) -> [f64; 3] {
        [self.sin_theta, -self.sin_phi * self.cos_theta, -self.cos_phi * self.cos_theta]
    }

    /// Partial derivatives of (7) by phi and theta.
    #[inline]
    pub fn climb_by_attitude(&self, [u, v, w]: [f64; 3]) -> [f64; 2] {
        let Attitude { sin_phi, cos_phi, sin_theta, cos_theta } = *self;
        [(w * sin_phi - v * cos_phi) * cos_theta, u * cos_theta + (v * sin_phi + w * cos_phi) * sin_theta]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const H: f64 = 1e-6;

    fn near(found: f64, expected: f64) {
        assert!((found - expected).abs() < 1e-7 * expected.abs().max(1.0), "{found} {expected}");
    }

    #[test]
    fn partials_are_those_of_small_differences() {
        let (velocity, rates, phi, theta) = ([60.0, -4.0, 7.0], [0.3, -0.2, 0.4], 0.5, -0.7);
        let at = Attitude::regular(phi, theta).unwrap();
        let euler = at.euler_partials(rates);
        let change = |a: [f64; 3], b: [f64; 3], i: usize| (a[i] - b[i]) / (2.0 * H);
        for k in 0..2 {
            let tilt = |h: f64| if k == 0 { Attitude::new(phi + h, theta) } else { Attitude::new(phi, theta + h) };
            let (up, down) = (tilt(H), tilt(-H));
            for i in 0..3 {
                near(at.gravity_partials()[i][k], change(up.gravity(), down.gravity(), i));
                near(euler.by_attitude[i][k], change(up.euler_rates(rates), down.euler_rates(rates), i));
            }
            near(at.climb_by_attitude(velocity)[k], (up.climb(velocity) - down.climb(velocity)) / (2.0 * H));
        }
        for k in 0..3 {
            let step = |mut x: [f64; 3], h: f64| {
                x[k] += h;
                x
            };
            let (up, down) = (step(rates, H), step(rates, -H));
            let (fast, slow) = (step(velocity, H), step(velocity, -H));
            for i in 0..3 {
                near(euler.by_rates[i][k], change(at.euler_rates(up), at.euler_rates(down), i));
                let by_rates = change(velocity_rate(velocity, up, [0.0; 3]), velocity_rate(velocity, down, [0.0; 3]), i);
                near(velocity_rate_by_rates(velocity)[i][k], by_rates);
                let by_velocity = change(velocity_rate(fast, rates, [0.0; 3]), velocity_rate(slow, rates, [0.0; 3]), i);
                near(velocity_rate_by_velocity(rates)[i][k], by_velocity);
            }
            near(at.climb_by_vector()[k], (at.climb(fast) - at.climb(slow)) / (2.0 * H));
        }
    }

    #[test]
    fn near_the_pole_there_is_no_regular_attitude() {
        assert!(Attitude::regular(0.0, 1.5).is_some());
        assert!(Attitude::regular(0.0, 1.53).is_none() && Attitude::regular(0.0, f64::NAN).is_none());
        assert!(Attitude::regular(0.0, 2.0).is_none());
    }
}
