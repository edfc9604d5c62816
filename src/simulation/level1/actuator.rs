//! Blade-pitch actuators: first-order lag with a rate limit.
//!
//! Consumes demanded and actual pitch, rad; produces the pitch rate, rad/s,
//!     dtheta/dt = (theta_demand - theta)/tau, limited to +- rate                                       (1)
//! with time constant tau, s.

/// Data of one actuator.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Actuator {
    /// Time constant, s.
    pub tau: f64,
    /// Greatest rate, rad/s.
    pub rate: f64,
}

impl Actuator {
    /// (1), rad/s.
    pub(crate) fn rate_of(&self, asked: f64, position: f64) -> f64 {
        ((asked - position) / self.tau).clamp(-self.rate, self.rate)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn slow_moves_lag_and_fast_ones_are_held() {
        let actuator = Actuator { tau: 0.05, rate: 0.5 };
        assert!((actuator.rate_of(0.02, 0.01) - 0.2).abs() < 1e-15);
        assert!((actuator.rate_of(-0.2, 0.1) + 0.5).abs() < 1e-15);
    }
}
