//! Kinematic consistency of the flow angles: the rate of a vane against accelerometers, gyros and attitude.
//!
//! Consumes the smoothed rate of a measured flow angle (transferred to the accelerometers) and the kinematic rate there, rad/s;
//! produces the running coefficient of determination
//!     R2 = 1 - var(measured - kinematic)/var(measured)                                            (1)
//! (variances about the means, so that constant biases do not count). The vane disagrees where
//!     var(measured - kinematic) > (1 - R2_MIN) var(measured) + NOISE_MARGIN noise                 (2)
//! with the variance that instrument noise alone brings into the difference.
//! Kinematics, from (1) to (3) of `kinematics`, V^2 = u^2 + v^2 + w^2:
//!     alpha' = (w' u - w u')/(u^2 + w^2)      beta' = (v' - v V'/V)/sqrt(u^2 + w^2)                (3)
//! Source: V. Klein and E. A. Morelli, Aircraft System Identification, 2nd ed. 2016, ch. 10 (data compatibility).
//! Returns `None` before `COUNT_MIN` instants or while the measured rate is within its noise.

use crate::dynamics::kinematics::{Attitude, velocity_rate};

/// Coefficient of determination below which a vane disagrees. A vane 13 m ahead of the centre of mass of a transport gives
/// 0.965, the same record brought to the centre of mass 0.997; one 6 m ahead, or a vane that reads 0.9 of the truth, 0.987 to
/// 0.991 in simulated flights.
pub const R2_MIN: f64 = 0.993;
/// Coefficient of determination below which a vane moves against the kinematics: -3 of a reversed one in still air, -1.4 in gusts
/// of 1 m/s, where one that reads right has 0.2 or more.
pub const R2_CONTRARY: f64 = -0.5;
const NOISE_MARGIN: f64 = 1.5;
const COUNT_MIN: f64 = 50.0;

/// Rates of alpha and beta from velocity u v w, attitude phi theta, specific force and rates, (3).
///
/// `None` below the least airspeed.
pub fn flow_angle_rates(velocity: [f64; 3], attitude: [f64; 2], force: [f64; 3], rates: [f64; 3]) -> Option<[f64; 2]> {
    let [u, v, w] = velocity;
    let s = u * u + w * w;
    if !(s > 25.0) {
        return None;
    }
    let gravity = Attitude::new(attitude[0], attitude[1]).gravity();
    let by_force = velocity_rate(velocity, rates, force);
    let [du, dv, dw]: [f64; 3] = core::array::from_fn(|i| by_force[i] + gravity[i]);
    let speed2 = s + v * v;
    let along = (u * du + v * dv + w * dw) / speed2;
    Some([(dw * u - w * du) / s, (dv - v * along) / libm::sqrt(s)])
}

/// The comparison of one vane.
#[derive(Clone, Copy, Debug)]
pub struct Consistency {
    count: f64,
    mean_measured: f64,
    mean_difference: f64,
    squares_measured: f64,
    squares_difference: f64,
    noise_var: f64,
}

impl Default for Consistency {
    fn default() -> Self {
        Consistency::NEW
    }
}

impl Consistency {
    /// Nothing compared yet.
    pub const NEW: Consistency = Consistency {
        count: 0.0,
        mean_measured: 0.0,
        mean_difference: 0.0,
        squares_measured: 0.0,
        squares_difference: 0.0,
        noise_var: 0.0,
    };

    /// One instant: both rates and the variance that noise brings into their difference.
    pub fn compare(&mut self, measured: f64, kinematic: f64, noise_var: f64) {
        if !(measured.is_finite() && kinematic.is_finite() && noise_var.is_finite()) {
            return;
        }
        // Welford's update of two means and two sums of squares.
        self.count += 1.0;
        let difference = measured - kinematic;
        let before = measured - self.mean_measured;
        self.mean_measured += before / self.count;
        self.squares_measured += before * (measured - self.mean_measured);
        let before = difference - self.mean_difference;
        self.mean_difference += before / self.count;
        self.squares_difference += before * (difference - self.mean_difference);
        self.noise_var += (noise_var - self.noise_var) / self.count;
    }

    /// (1); `None` while it is not determined.
    pub fn r_squared(&self) -> Option<f64> {
        let enough = self.count >= COUNT_MIN && self.squares_measured > NOISE_MARGIN * self.noise_var * self.count;
        enough.then(|| 1.0 - self.squares_difference / self.squares_measured)
    }

    /// R2 where the vane disagrees with the kinematics by (2); `None` where it agrees or R2 is not determined.
    pub fn disagreement(&self) -> Option<f64> {
        let r_squared = self.r_squared()?;
        let allowed = (1.0 - R2_MIN) * self.squares_measured + NOISE_MARGIN * self.noise_var * self.count;
        (self.squares_difference > allowed).then_some(r_squared)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::flight::unit::STANDARD_GRAVITY as G0;

    #[test]
    fn the_same_signal_agrees_and_a_quarter_of_it_too_much_does_not() {
        let (mut same, mut scaled, mut noisy) = (Consistency::default(), Consistency::default(), Consistency::default());
        for i in 0..500 {
            let rate = 0.1 * libm::sin(0.16 * f64::from(i));
            same.compare(rate + 0.01, rate, 1e-8);
            scaled.compare(1.25 * rate, rate, 1e-8);
            noisy.compare(1.25 * rate, rate, 0.01);
        }
        assert!(same.r_squared().unwrap() > 0.999_999 && same.disagreement().is_none());
        // var(0.25 x)/var(1.25 x) = 0.04.
        assert!((scaled.disagreement().unwrap() - 0.96).abs() < 1e-3);
        assert!(noisy.r_squared().is_none() && noisy.disagreement().is_none());
    }

    #[test]
    fn straight_and_level_flight_has_no_rates() {
        let theta: f64 = 0.05;
        let force = [G0 * libm::sin(theta), 0.0, -G0 * libm::cos(theta)];
        let [alpha, beta] = flow_angle_rates([50.0, 0.0, 2.0], [0.0, theta], force, [0.0; 3]).unwrap();
        assert!(alpha.abs() < 1e-15 && beta.abs() < 1e-15);
        assert!(flow_angle_rates([3.0, 0.0, 0.0], [0.0; 2], [0.0; 3], [0.0; 3]).is_none());
    }
}
