//! Feedback: the part of the controls' edges that answers the rates.
//!
//! Consumes third differences of the controls and of p q r on the regression grid; produces what of each control's is not
//! explained by those of the rates one and two instants before, by recursive least squares:
//!     x_k = [rates' differences at k-1, k-2],   e = d - K'x,   g = P x/(lambda s2 + x'P x)                (1)
//!     K <- K + g e,   P <- (P - g x'P)/lambda,   unexplained = e (1 - x'g)                            (2)
//! A test input moves the control before the aircraft: what came before explains none of it. A control that an augmentation
//! system moves is explained by what it answers, whatever its gains. What is explained never makes a difference larger.
//! Source: L. Ljung, System Identification, 2nd ed. 1999, section 11.2.

use crate::flight::control::CONTROLS;

/// Rates and how many instants of each.
const TAPS: usize = 6;
/// Prior standard deviation of a gain, rad of control for rad/s.
const GAIN_STD: f64 = 0.5;
/// Time constant of forgetting, s.
const MEMORY_S: f64 = 20.0;

/// The estimate.
#[derive(Clone, Debug)]
pub struct Feedback {
    gains: [[f64; TAPS]; CONTROLS],
    cov: [[f64; TAPS]; TAPS],
    /// x of (1).
    before: [f64; TAPS],
    /// Instants in a row that it holds.
    filled: usize,
}

impl Feedback {
    /// Nothing known.
    pub const NEW: Feedback = {
        let mut cov = [[0.0; TAPS]; TAPS];
        let mut i = 0;
        while i < TAPS {
            cov[i][i] = GAIN_STD * GAIN_STD;
            i += 1;
        }
        Feedback { gains: [[0.0; TAPS]; CONTROLS], cov, before: [0.0; TAPS], filled: 0 }
    };

    /// An instant without signals.
    pub fn skip(&mut self) {
        self.filled = 0;
    }

    /// One instant: differences of the controls, rad, and of the rates, rad/s; `noise_std` is the scatter of (1), rad. The part
    /// of the controls' that is unexplained, rad.
    pub fn unexplained(
        &mut self,
        controls: [f64; CONTROLS],
        rates: [f64; 3],
        noise_std: f64,
        interval_s: f64,
    ) -> [f64; CONTROLS] {
        let x = self.before;
        self.before.copy_within(..TAPS - 3, 3);
        self.before[..3].copy_from_slice(&rates);
        if self.filled < TAPS / 3 {
            self.filled += 1;
            return [0.0; CONTROLS];
        }
        let lambda = libm::exp(-interval_s / MEMORY_S);
        let px = self.cov.map(|row| row.iter().zip(&x).map(|(p, x)| p * x).sum::<f64>());
        let by_gains: f64 = px.iter().zip(&x).map(|(p, x)| p * x).sum();
        let var = lambda * noise_std * noise_std + by_gains;
        let mut left = controls;
        for (gains, left) in self.gains.iter_mut().zip(&mut left) {
            let error = *left - gains.iter().zip(&x).map(|(k, x)| k * x).sum::<f64>();
            gains.iter_mut().zip(&px).for_each(|(k, p)| *k += p * error / var);
            let unexplained = error * (1.0 - by_gains / var);
            if unexplained.abs() < left.abs() {
                *left = unexplained;
            }
        }
        self.update_covariance(&px, var, lambda);
        left
    }

    /// The last of (2), bounded by the prior: forgetting does not go beyond it.
    fn update_covariance(&mut self, px: &[f64; TAPS], var: f64, lambda: f64) {
        for i in 0..TAPS {
            for j in 0..TAPS {
                self.cov[i][j] = (self.cov[i][j] - px[i] * px[j] / var) / lambda;
            }
        }
        let most = GAIN_STD * GAIN_STD;
        let shrink: [f64; TAPS] = core::array::from_fn(|i| libm::sqrt(most / self.cov[i][i].max(most)));
        for i in 0..TAPS {
            for j in 0..TAPS {
                self.cov[i][j] *= shrink[i] * shrink[j];
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const INTERVAL_S: f64 = 0.08;
    const NOISE_STD: f64 = 6.5e-4;

    /// Rates' differences of a flight in rough air.
    fn rates(k: i32) -> [f64; 3] {
        let t = INTERVAL_S * f64::from(k);
        [0.03 * libm::sin(3.1 * t + libm::sin(0.7 * t)), 0.02 * libm::cos(2.3 * t + libm::cos(t)), 0.01 * libm::sin(1.7 * t)]
    }

    /// Largest unexplained difference of the first control after 5 s, which answers the roll rate and is moved as given.
    fn largest(input: impl Fn(i32) -> f64) -> f64 {
        let mut feedback = Feedback::NEW;
        let mut largest = 0.0f64;
        for k in 0..500 {
            let answer = 0.2 * rates(k - 1)[0] - 0.1 * rates(k - 2)[0];
            let left = feedback.unexplained([answer + input(k), 0.0, 0.0, 0.0], rates(k), NOISE_STD, INTERVAL_S);
            if k > 62 {
                largest = largest.max(left[0].abs());
            }
            assert!(left[1..].iter().all(|left| left.abs() < 1e-15), "a control that stands still: {left:?}");
        }
        largest
    }

    #[test]
    fn what_answers_the_rates_is_explained_and_an_input_on_top_of_it_is_not() {
        let left = largest(|_| 0.0);
        assert!(left < 0.3 * NOISE_STD, "{left} rad of differences of 7e-3");
        let edge = |k: i32| if k == 300 { 0.02 } else { 0.0 };
        assert!(largest(edge) > 0.01, "{}", largest(edge));
    }

    #[test]
    fn before_the_rates_are_known_and_after_a_hole_nothing_is_unexplained() {
        let mut feedback = Feedback::NEW;
        let step = |feedback: &mut Feedback| feedback.unexplained([0.01; CONTROLS], [1e-4; 3], NOISE_STD, INTERVAL_S)[0];
        assert!(step(&mut feedback).abs() < 1e-15 && step(&mut feedback).abs() < 1e-15 && step(&mut feedback) > 1e-3);
        feedback.skip();
        assert!(step(&mut feedback).abs() < 1e-15);
    }
}
