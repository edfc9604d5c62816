//! Extended Kalman filter on the kinematics: sequencing only, the models are in `process` and `aid`.
//!
//! Consumes inputs (measured specific force and rates), measurements with their predictions; produces the state \[13\] and
//! its covariance P = U D U'.
//!     x <- x + dt f(x + dt/2 f(x, m), m),  m = mean of the inputs at both ends of dt, less bias    (1)
//!     P <- F P F' + (dt G) diag(q) (dt G)',  F = I + dt [A -G; 0 0]                                (2)
//!     nu = z - h(x),  s = H P H' + R,  rejected where nu^2 > gate^2 s                              (3)
//!     x <- x + P H' nu/s,  P <- P - P H' H P/s                                                    (4)
//! one measurement after the other ((11) to (15) of the paper, sequential; equal to the joint update for uncorrelated
//! noise up to the point of linearisation, which here is the state after the preceding measurement).
//! Numerics: (2) and (4) on the factors (`num::ud`). The biases' random walk is added in steps of `WALK_STEP_S`.
//! Returns [`Breakdown`] where a variance is not positive or a state not finite; the filter is then to be thrown away.

#![expect(clippy::needless_range_loop, reason = "indices are those of the equations")]

use super::aid::Prediction;
use super::process::{ACCELEROMETER_BIAS, GYRO_BIAS, INPUTS, Input, NAVIGATION, STATES, State, jacobians, rate, unbiased};
use super::record::{Aid, Innovation};
use crate::num::ud::{Breakdown, UdFactor};
use core::f64::consts::PI;

/// The biases' random walk is added when so much time has gathered, s.
const WALK_STEP_S: f64 = 0.5;

/// The filter.
#[derive(Clone, Debug)]
pub struct Ekf {
    x: State,
    p: UdFactor<f64, STATES>,
    walk_time_s: f64,
}

/// How the noise of the inputs and the biases' walk enter.
#[derive(Clone, Copy, Debug)]
pub struct ProcessNoise {
    /// Variances of ax ay az p q r, a sample.
    pub input_var: [f64; INPUTS],
    /// Growth of the accelerometer biases' variance, (m/s^2)^2/s.
    pub accelerometer_walk_var: f64,
    /// Growth of the gyro biases' variance, (rad/s)^2/s.
    pub gyro_walk_var: f64,
}

impl Ekf {
    /// Starts from a state with independent variances.
    pub fn new(state: State, variances: [f64; STATES]) -> Self {
        Ekf { x: state, p: UdFactor::from_variances(variances), walk_time_s: 0.0 }
    }

    /// The state.
    pub fn state(&self) -> &State {
        &self.x
    }

    /// Standard deviation of state `i`.
    pub fn std(&self, i: usize) -> f64 {
        libm::sqrt(self.p.variance(i))
    }

    /// The covariance in its factors.
    pub fn covariance(&self) -> &UdFactor<f64, STATES> {
        &self.p
    }

    /// Carries state and covariance over `dt` seconds, (1) and (2); inputs as measured at both ends.
    ///
    /// # Errors
    /// [`Breakdown`] near theta = +-90 deg or where the numbers gave out.
    pub fn propagate(&mut self, from: &Input, to: &Input, dt: f64, noise: &ProcessNoise) -> Result<(), Breakdown> {
        let mean: Input = core::array::from_fn(|i| 0.5 * (from[i] + to[i]));
        let m = unbiased(&self.x, &mean);
        let singular = Breakdown { index: STATES };
        let first = rate(&self.x, &m).ok_or(singular)?;
        let mut middle = self.x;
        for i in 0..NAVIGATION {
            middle[i] += 0.5 * dt * first[i];
        }
        let slope = rate(&middle, &m).ok_or(singular)?;
        let (a, g) = jacobians(&middle, &m).ok_or(singular)?;
        for i in 0..NAVIGATION {
            self.x[i] += dt * slope[i];
        }
        let mut top = [[0.0; STATES]; NAVIGATION];
        let mut noise_input = [[0.0; INPUTS]; NAVIGATION];
        for i in 0..NAVIGATION {
            for j in 0..NAVIGATION {
                top[i][j] = dt * a[i][j];
            }
            top[i][i] += 1.0;
            for j in 0..INPUTS {
                noise_input[i][j] = dt * g[i][j];
                top[i][ACCELEROMETER_BIAS + j] = -noise_input[i][j];
            }
        }
        self.p.propagate(&top, &noise_input, &noise.input_var)?;
        self.walk_time_s += dt;
        if self.walk_time_s >= WALK_STEP_S {
            for i in 0..3 {
                self.p.inflate(ACCELEROMETER_BIAS + i, noise.accelerometer_walk_var * self.walk_time_s)?;
                self.p.inflate(GYRO_BIAS + i, noise.gyro_walk_var * self.walk_time_s)?;
            }
            self.walk_time_s = 0.0;
        }
        self.check()
    }

    /// Judges a measurement and fuses it where its innovation passes the gate, (3) and (4).
    ///
    /// # Errors
    /// [`Breakdown`] where the numbers gave out.
    pub fn fuse(
        &mut self,
        time_s: f64,
        aid: Aid,
        observation: f64,
        prediction: &Prediction,
        gate_sigmas: f64,
    ) -> Result<Innovation, Breakdown> {
        let projection = self.p.project(&prediction.row, prediction.noise_var)?;
        let innovation_var = projection.innovation_var;
        let mut innovation = observation - prediction.value;
        if prediction.wraps {
            innovation = wrap(innovation);
        }
        let test_ratio = innovation * innovation / (gate_sigmas * gate_sigmas * innovation_var);
        let fused = test_ratio <= 1.0;
        if fused {
            let gain = self.p.fuse(&projection)?;
            for (x, k) in self.x.iter_mut().zip(gain) {
                *x += k * innovation;
            }
            self.check()?;
        }
        let observation_var = prediction.noise_var;
        Ok(Innovation { time_s, aid, observation, observation_var, innovation, innovation_var, test_ratio, fused })
    }

    fn check(&self) -> Result<(), Breakdown> {
        match self.x.iter().position(|x| !x.is_finite()) {
            Some(index) => Err(Breakdown { index }),
            None => Ok(()),
        }
    }
}

/// The angle in -pi .. pi that differs from `angle` by whole turns.
pub fn wrap(angle: f64) -> f64 {
    libm::remainder(angle, 2.0 * PI)
}
