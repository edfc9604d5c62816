//! What instruments read of a rigid body's motion where they stand, and how that depends on the motion and on their place.
//!
//! Consumes, in body axes, the velocity through the air V = (u v w) (m/s), the rates omega = (p q r) (rad/s), their rates of
//! change omega' (rad/s^2), the specific force f (m/s^2) and the arm r = (x y z) (m) from the point at which V and f are given;
//! produces readings and their partial derivatives.
//!     velocity at the arm     V + omega x r = (u + q z - r y, v + r x - p z, w + p y - q x)                     (1)
//!     airspeed                tas = sqrt(u^2 + v^2 + w^2),                  d tas = (u du + v dv + w dw)/tas    (2)
//!     incidence               alpha = atan2(w, u),                          d alpha = (u dw - w du)/s^2         (3)
//!     sideslip                beta = asin(v/tas) = atan2(v, s),  s^2 = u^2 + w^2,
//!                             d beta = (s^2 dv - v (u du + w dw))/(s tas^2)                                     (4)
//!     and back                V = tas (cos(alpha) cos(beta), sin(beta), sin(alpha) cos(beta))                   (5)
//!     specific force          f + omega' x r + omega x (omega x r)                                              (6)
//!     omega x (omega x r)     = (p (q y + r z) - (q^2 + r^2) x, ..), round the axes                             (7)
//!     d (6)/dr                = \[omega' x\] + \[omega x\]^2                                                      (8)
//! With b the derivative of a reading of (2) to (4) by the velocity, that by the rates is r x b and that by the arm b x omega.
//! Source: V. Klein and E. A. Morelli, Aircraft System Identification, 2nd ed. 2016, ch. 3 (air data) and ch. 10 (arms of vanes
//! and accelerometers); Padfield et al. 1987.
//! Numerics: atan2 in (4) keeps the digits that asin loses near +-90 deg. (3) and (4) have no derivatives where s = 0, (2) where
//! tas = 0: they are NaN or infinite there, and the caller sets the least airspeed of a reading.

use crate::dynamics::kinematics::Square;

/// The vector product a x b.
#[inline]
pub fn cross([a1, a2, a3]: [f64; 3], [b1, b2, b3]: [f64; 3]) -> [f64; 3] {
    [a2 * b3 - a3 * b2, a3 * b1 - a1 * b3, a1 * b2 - a2 * b1]
}

/// (1): velocity at the arm from that at its foot.
#[inline]
pub fn velocity_at_arm([u, v, w]: [f64; 3], [p, q, r]: [f64; 3], [x, y, z]: [f64; 3]) -> [f64; 3] {
    [u + q * z - r * y, v + r * x - p * z, w + p * y - q * x]
}

/// (1) solved for the velocity at the arm's foot.
#[inline]
pub fn velocity_at_foot([u, v, w]: [f64; 3], rates: [f64; 3], arm: [f64; 3]) -> [f64; 3] {
    let [du, dv, dw] = cross(rates, arm);
    [u - du, v - dv, w - dw]
}

/// Incidence and sideslip at the arm's foot from those at the arm, by (1) for small angles at forward speed `u`.
#[inline]
pub fn flow_angles_at_foot([alpha, beta]: [f64; 2], rates: [f64; 3], arm: [f64; 3], u: f64) -> [f64; 2] {
    let [_, dv, dw] = cross(rates, arm);
    [alpha - dw / u, beta - dv / u]
}

/// (5) of unit length.
#[inline]
pub fn flow_direction(alpha: f64, beta: f64) -> [f64; 3] {
    let ((sin_alpha, cos_alpha), (sin_beta, cos_beta)) = (libm::sincos(alpha), libm::sincos(beta));
    [cos_alpha * cos_beta, sin_beta, sin_alpha * cos_beta]
}

/// (5).
#[inline]
pub fn velocity_of_air_data(tas: f64, alpha: f64, beta: f64) -> [f64; 3] {
    let ((sin_alpha, cos_alpha), (sin_beta, cos_beta)) = (libm::sincos(alpha), libm::sincos(beta));
    [tas * cos_alpha * cos_beta, tas * sin_beta, tas * sin_alpha * cos_beta]
}

/// An instrument of the air data.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum AirData {
    /// (2), m/s.
    Airspeed,
    /// (3), rad.
    Incidence,
    /// (4), rad.
    Sideslip,
}

/// A reading of the air data with its partial derivatives.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AirDataReading {
    /// The reading.
    pub value: f64,
    /// Derivative by the velocity u v w where the instrument stands.
    pub by_velocity: [f64; 3],
}

impl AirData {
    /// In the order of a run's outputs: tas, alpha, beta.
    pub const ALL: [AirData; 3] = [AirData::Airspeed, AirData::Incidence, AirData::Sideslip];

    /// (2), (3) or (4) of the velocity where the instrument stands.
    #[inline]
    pub fn value(self, [u, v, w]: [f64; 3]) -> f64 {
        match self {
            AirData::Airspeed => libm::sqrt(u * u + v * v + w * w),
            AirData::Incidence => libm::atan2(w, u),
            AirData::Sideslip => libm::atan2(v, libm::hypot(u, w)),
        }
    }

    /// The same, to rounding, with its derivatives, which share the squares.
    #[inline]
    pub fn reading(self, velocity: [f64; 3]) -> AirDataReading {
        let [u, v, w] = velocity;
        let s2 = u * u + w * w;
        let speed2 = s2 + v * v;
        match self {
            AirData::Airspeed => AirDataReading::of_airspeed(libm::sqrt(speed2), velocity),
            AirData::Incidence => AirDataReading { value: libm::atan2(w, u), by_velocity: [-w / s2, 0.0, u / s2] },
            AirData::Sideslip => {
                let s = libm::sqrt(s2);
                let per = s * speed2;
                AirDataReading { value: libm::atan2(v, s), by_velocity: [-v * u / per, s / speed2, -v * w / per] }
            }
        }
    }
}

impl AirDataReading {
    /// Airspeed `tas`, which is the length of `velocity`, with its derivatives (2).
    #[inline]
    pub fn of_airspeed(tas: f64, velocity: [f64; 3]) -> Self {
        AirDataReading { value: tas, by_velocity: velocity.map(|part| part / tas) }
    }

    /// Derivative by p q r of an instrument that stands at the arm.
    #[inline]
    pub fn by_rates(&self, arm: [f64; 3]) -> [f64; 3] {
        cross(arm, self.by_velocity)
    }

    /// Derivative by the arm.
    #[inline]
    pub fn by_arm(&self, rates: [f64; 3]) -> [f64; 3] {
        cross(self.by_velocity, rates)
    }
}

/// (6): specific force at the arm from that at its foot.
#[inline]
pub fn specific_force_at_arm(force: [f64; 3], rates: [f64; 3], angular_acceleration: [f64; 3], arm: [f64; 3]) -> [f64; 3] {
    let tangential = cross(angular_acceleration, arm);
    let centripetal = cross(rates, cross(rates, arm));
    core::array::from_fn(|axis| force[axis] + tangential[axis] + centripetal[axis])
}

/// (6) solved for the specific force at the arm's foot.
#[inline]
pub fn specific_force_at_foot(force: [f64; 3], rates: [f64; 3], angular_acceleration: [f64; 3], arm: [f64; 3]) -> [f64; 3] {
    let (by_arm, [x, y, z]) = (specific_force_by_arm(rates, angular_acceleration), arm);
    core::array::from_fn(|axis| {
        let [by_x, by_y, by_z] = by_arm[axis];
        force[axis] - by_x * x - by_y * y - by_z * z
    })
}

/// (8): derivative of (6) by the arm, a row an axis.
#[inline]
pub fn specific_force_by_arm([p, q, r]: [f64; 3], [dp, dq, dr]: [f64; 3]) -> Square {
    [
        [-(q * q + r * r), p * q - dr, p * r + dq],
        [p * q + dr, -(p * p + r * r), q * r - dp],
        [p * r - dq, q * r + dp, -(p * p + q * q)],
    ]
}

/// Derivative of (6) by the angular acceleration, a row an axis.
#[inline]
pub fn specific_force_by_angular_acceleration([x, y, z]: [f64; 3]) -> Square {
    [[0.0, z, -y], [-z, 0.0, x], [y, -x, 0.0]]
}

/// (7) as what is added along each axis and what is taken off.
#[inline]
pub fn centripetal_terms([p, q, r]: [f64; 3], [x, y, z]: [f64; 3]) -> [(f64, f64); 3] {
    [
        (p * (q * y + r * z), (q * q + r * r) * x),
        (q * (p * x + r * z), (p * p + r * r) * y),
        (r * (p * x + q * y), (p * p + q * q) * z),
    ]
}

/// Derivative of (7), which is that of (6), by p q r, a row an axis.
#[inline]
pub fn centripetal_by_rates([p, q, r]: [f64; 3], [x, y, z]: [f64; 3]) -> Square {
    [
        [q * y + r * z, p * y - 2.0 * q * x, p * z - 2.0 * r * x],
        [q * x - 2.0 * p * y, p * x + r * z, q * z - 2.0 * r * y],
        [r * x - 2.0 * p * z, r * y - 2.0 * q * z, p * x + q * y],
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    const STEP: f64 = 1e-6;
    const VELOCITY: [f64; 3] = [52.0, -7.0, 9.0];
    const RATES: [f64; 3] = [0.3, -0.2, 0.4];
    const ANGULAR_ACCELERATION: [f64; 3] = [0.7, 0.5, -0.6];
    const ARM: [f64; 3] = [6.0, 0.5, -1.2];

    fn near(found: f64, expected: f64) {
        assert!((found - expected).abs() < 1e-8 * expected.abs().max(1.0), "{found} {expected}");
    }

    /// Derivative of `f` by part `k` of `x`, by central differences.
    fn slope(f: impl Fn([f64; 3]) -> f64, x: [f64; 3], k: usize) -> f64 {
        let moved = |step: f64| core::array::from_fn(|i| if i == k { x[i] + step } else { x[i] });
        (f(moved(STEP)) - f(moved(-STEP))) / (2.0 * STEP)
    }

    #[test]
    fn values_are_those_found_by_hand() {
        // 12^2 + 4^2 + 3^2 = 13^2.
        let [tas, alpha, beta] = AirData::ALL.map(|instrument| instrument.value([12.0, 4.0, 3.0]));
        near(tas, 13.0);
        near(libm::tan(alpha), 0.25);
        near(libm::sin(beta), 4.0 / 13.0);
        // A yaw rate of 0.1 rad/s moves a vane 10 m ahead to the right, and one 2 m to the right backward.
        let moved = velocity_at_arm([50.0, 0.0, 0.0], [0.0, 0.0, 0.1], [10.0, 2.0, 0.0]);
        for (found, expected) in moved.into_iter().zip([49.8, 1.0, 0.0]) {
            near(found, expected);
        }
        // Steady yawing: 10 m ahead it is pulled back by r^2 x.
        near(specific_force_at_arm([0.0; 3], [0.0, 0.0, 0.5], [0.0; 3], [10.0, 0.0, 0.0])[0], -2.5);
        // Nose-up acceleration lifts what stands ahead: z is down.
        near(specific_force_at_arm([0.0; 3], [0.0; 3], [0.0, 0.5, 0.0], [10.0, 0.0, 0.0])[2], -5.0);
    }

    #[test]
    fn what_leads_there_and_back_is_the_same() {
        let there = velocity_at_arm(VELOCITY, RATES, ARM);
        let force = [0.4, -0.3, -9.7];
        let felt = specific_force_at_arm(force, RATES, ANGULAR_ACCELERATION, ARM);
        let [tas, alpha, beta] = AirData::ALL.map(|instrument| instrument.value(VELOCITY));
        for axis in 0..3 {
            near(velocity_at_foot(there, RATES, ARM)[axis], VELOCITY[axis]);
            near(specific_force_at_foot(felt, RATES, ANGULAR_ACCELERATION, ARM)[axis], force[axis]);
            near(velocity_of_air_data(tas, alpha, beta)[axis], VELOCITY[axis]);
            near(tas * flow_direction(alpha, beta)[axis], VELOCITY[axis]);
            let (added, taken) = centripetal_terms(RATES, ARM)[axis];
            near(force[axis] + cross(ANGULAR_ACCELERATION, ARM)[axis] + (added - taken), felt[axis]);
        }
        // Small angles: the error is of their third order.
        let at_vane = [1, 2].map(|place: usize| AirData::ALL[place].value(velocity_at_arm([50.0, 0.5, 1.0], [0.02; 3], ARM)));
        let [alpha, beta] = flow_angles_at_foot(at_vane, [0.02; 3], ARM, 50.0);
        assert!((alpha - 0.02).abs() < 2e-5 && (beta - 0.01).abs() < 2e-5, "{alpha} {beta}");
    }

    #[test]
    fn derivatives_of_air_data_are_those_of_small_differences() {
        for instrument in AirData::ALL {
            let value = |velocity, rates, arm| instrument.value(velocity_at_arm(velocity, rates, arm));
            let reading = instrument.reading(velocity_at_arm(VELOCITY, RATES, ARM));
            near(reading.value, value(VELOCITY, RATES, ARM));
            for k in 0..3 {
                near(reading.by_velocity[k], slope(|velocity| value(velocity, RATES, ARM), VELOCITY, k));
                near(reading.by_rates(ARM)[k], slope(|rates| value(VELOCITY, rates, ARM), RATES, k));
                near(reading.by_arm(RATES)[k], slope(|arm| value(VELOCITY, RATES, arm), ARM, k));
            }
        }
    }

    #[test]
    fn derivatives_of_specific_force_are_those_of_small_differences() {
        let force = |rates, turning, arm| specific_force_at_arm([0.4, -0.3, -9.7], rates, turning, arm);
        for axis in 0..3 {
            for k in 0..3 {
                let by_rates = slope(|rates| force(rates, ANGULAR_ACCELERATION, ARM)[axis], RATES, k);
                near(centripetal_by_rates(RATES, ARM)[axis][k], by_rates);
                let by_turning = slope(|turning| force(RATES, turning, ARM)[axis], ANGULAR_ACCELERATION, k);
                near(specific_force_by_angular_acceleration(ARM)[axis][k], by_turning);
                let by_arm = slope(|arm| force(RATES, ANGULAR_ACCELERATION, arm)[axis], ARM, k);
                near(specific_force_by_arm(RATES, ANGULAR_ACCELERATION)[axis][k], by_arm);
            }
        }
    }
}
