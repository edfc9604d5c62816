//! Excitation: whether the present motion carries information about the derivatives.
//!
//! Consumes z on the regression grid; produces whether the aircraft is being excited: the deviation of some regressor from
//! its own recent mean, over about two seconds, exceeds that of a regressor at rest. Quiet flight carries no information: it is
//! not added, and nothing is forgotten in it.
//!     m <- m + g (z - m),   s2 <- (1 - g)(s2 + g (z - m)^2)                                          (1)

use super::candidate::{SIGNALS, STILL};
use crate::flight::derivative::VARIABLES;

/// Time constant of (1), s.
const MEMORY_S: f64 = 1.0;
/// Time that excitation continues after the last deviation, s.
const HOLD_S: f64 = 1.0;

/// Recent mean and variance of every regressor.
#[derive(Clone, Debug)]
pub struct Excitation {
    mean: [f64; VARIABLES],
    var: [f64; VARIABLES],
    started: bool,
    quiet_s: f64,
}

impl Excitation {
    /// Before the first instant.
    pub const START: Excitation =
        Excitation { mean: [0.0; VARIABLES], var: [0.0; VARIABLES], started: false, quiet_s: f64::INFINITY };

    /// One instant of the grid; whether the aircraft is excited.
    pub fn step(&mut self, z: &[f64; SIGNALS], interval_s: f64) -> bool {
        let gain = 1.0 - libm::exp(-interval_s / MEMORY_S);
        let mut excited = false;
        for i in 0..VARIABLES {
            if !self.started {
                self.mean[i] = z[1 + i];
                continue;
            }
            let deviation = z[1 + i] - self.mean[i];
            self.mean[i] += gain * deviation;
            self.var[i] = (1.0 - gain) * (self.var[i] + gain * deviation * deviation);
            excited |= self.var[i] > STILL[i] * STILL[i];
        }
        self.started = true;
        self.quiet_s = if excited { 0.0 } else { self.quiet_s + interval_s };
        self.quiet_s <= HOLD_S
    }
}

#[cfg(test)]
mod tests {
    use super::super::candidate::regressor;
    use super::*;
    use crate::flight::derivative::Variable;

    #[test]
    fn a_new_steady_state_is_no_excitation_and_an_oscillation_is() {
        let mut excitation = Excitation::START;
        let mut z = [0.0; SIGNALS];
        assert!(!excitation.step(&z, 0.08));
        let mut excited = [false; 300];
        for (k, excited) in excited.iter_mut().enumerate() {
            z[regressor(Variable::V)] = if k < 100 { libm::sin(0.12 * k as f64) } else { 2.0 };
            *excited = excitation.step(&z, 0.08);
        }
        assert!(excited[20..100].iter().all(|&now| now));
        assert!(!excited[250], "it stands at 2 m/s and does not move");
    }
}
