//! Extended Kalman filter on the kinematics: sequencing only, the models are in `process` and `aid`.
//!
//! Consumes measurements with their predictions; produces the state \[25\] and its covariance P = U D U'.
//!     x <- x + dt f(x + dt/2 f(x))                                                                (1)
//!     P <- F P F' + G diag(q/dt) G'                                                               (2)
//!     F = I + dt A + dt^2/2 A_p   (A_p: attitude and velocity by angular acceleration, through the rates)
//!     G: a random walk w of an acceleration over dt moves the acceleration by dt w, its first integral by dt^2/2 w
//!     nu = z - h(x),  s = H P H' + R,  rejected where nu^2 > gate^2 s                              (3)
//!     x <- x + P H' nu/s,  P <- P - P H' H P/s                                                    (4)
//! one measurement after the other ((11) to (15) of Padfield et al. 1987, sequential; equal to the joint update for uncorrelated
//! noise up to the point of linearisation, which here is the state after the preceding measurement). Gyros and
//! accelerometers are measurements like the others: between two of their samples the random walk makes (1) the trapezoidal
//! rule once the second one is in.
//! Numerics: (2) and (4) on the factors (`num::ud`). The biases' random walk is added in steps of `WALK_STEP_S`.
//! Returns [`Breakdown`] where a variance is not positive or a state not finite; the filter is then to be thrown away.

use super::aid::prediction::Prediction;
use super::process::{
    ACCELEROMETER_BIAS, ANGULAR_ACCELERATION, GYRO_BIAS, MOVING, NAVIGATION, RATES, SPECIFIC_FORCE, STATES, State, VELOCITY,
    jacobian, rate,
};
use crate::num::ud::{Breakdown, UdFactor};
use core::f64::consts::PI;

/// The biases' random walk is added when so much time has gathered, s.
const WALK_STEP_S: f64 = 0.5;

/// Independent noises that drive the process: three angular accelerations, three specific forces.
pub const DRIVERS: usize = 6;

/// First rows of the transition matrix F; below them it is the identity.
pub type Transition = [[f64; MOVING]; MOVING];

/// The filter.
#[derive(Clone, Debug)]
pub struct Ekf {
    x: State,
    p: UdFactor<f64, STATES>,
    transition: Transition,
    walk_time_s: f64,
}

/// What drives the process.
#[derive(Clone, Copy, Debug)]
pub struct ProcessNoise {
    /// Intensity of the angular accelerations' random walk, (rad/s^2)^2/s.
    pub angular_acceleration: [f64; 3],
    /// Intensity of the specific forces' random walk, (m/s^2)^2/s; of the white noise in their place where not measured,
    /// (m/s^2)^2 s.
    pub specific_force: [f64; 3],
    /// Which specific forces are measured.
    pub measured: [bool; 3],
    /// Growth of the accelerometer biases' variance, (m/s^2)^2/s.
    pub accelerometer_walk_var: f64,
    /// Growth of the gyro biases' variance, (rad/s)^2/s.
    pub gyro_walk_var: f64,
}

/// Outcome of a measurement.
#[derive(Clone, Copy, Debug)]
pub struct Fusion {
    /// Measurement less prediction (angles wrapped to +-pi).
    pub innovation: f64,
    /// Its predicted variance.
    pub innovation_var: f64,
    /// innovation^2 / (gate^2 innovation_var): above 1 it is rejected.
    pub test_ratio: f64,
    /// P H'/s \[25\]; `None` where rejected.
    pub gain: Option<State>,
}

/// Observer of the filter's steps, such as a smoother.
pub trait FilterObserver {
    /// Time update; the first rows of F.
    fn propagate(&mut self, transition: &Transition);
    /// Measurement update with this row of H, fused or rejected.
    fn fuse(&mut self, row: &State, fusion: &Fusion);
}

impl FilterObserver for () {
    fn propagate(&mut self, _: &Transition) {}
    fn fuse(&mut self, _: &State, _: &Fusion) {}
}

impl Ekf {
    /// Starts from a state with independent variances.
    pub fn new(state: State, variances: [f64; STATES]) -> Self {
        let transition = core::array::from_fn(|i| core::array::from_fn(|j| if i == j { 1.0 } else { 0.0 }));
        Ekf { x: state, p: UdFactor::from_variances(variances), transition, walk_time_s: 0.0 }
    }

    /// The state.
    pub fn state(&self) -> &State {
        &self.x
    }

    /// Standard deviation of state `i`.
    pub fn std(&self, i: usize) -> f64 {
        libm::sqrt(self.p.variance(i))
    }

    /// Every standard deviation.
    pub fn stds(&self) -> State {
        self.p.variances().map(libm::sqrt)
    }

    /// The covariance in its factors.
    pub fn covariance(&self) -> &UdFactor<f64, STATES> {
        &self.p
    }

    /// First rows of F of the last [`Ekf::propagate`].
    pub fn transition(&self) -> &Transition {
        &self.transition
    }

    /// Time update of state and covariance over `dt` seconds, (1) and (2).
    ///
    /// # Errors
    /// [`Breakdown`] near theta = +-90 deg or where a variance is not positive or a state not finite.
    pub fn propagate(&mut self, dt: f64, noise: &ProcessNoise) -> Result<(), Breakdown> {
        let singular = Breakdown { index: STATES };
        let first = rate(&self.x, &noise.measured).ok_or(singular)?;
        let mut middle = self.x;
        for (x, slope) in middle.iter_mut().zip(first) {
            *x += 0.5 * dt * slope;
        }
        let slope = rate(&middle, &noise.measured).ok_or(singular)?;
        let a = jacobian(&middle, &noise.measured).ok_or(singular)?;
        for (x, slope) in self.x.iter_mut().zip(slope) {
            *x += dt * slope;
        }
        let half = 0.5 * dt * dt;
        let top = &mut self.transition;
        let mut driver = [[0.0; DRIVERS]; MOVING];
        for i in 0..NAVIGATION {
            for j in 0..MOVING {
                top[i][j] = dt * a[i][j];
            }
            top[i][i] += 1.0;
            for j in 0..3 {
                top[i][ANGULAR_ACCELERATION + j] = half * a[i][RATES + j];
            }
        }
        for i in 0..3 {
            top[RATES + i][ANGULAR_ACCELERATION + i] = dt;
            driver[RATES + i][i] = half;
            driver[ANGULAR_ACCELERATION + i][i] = dt;
            driver[SPECIFIC_FORCE + i][3 + i] = dt;
            driver[VELOCITY + i][3 + i] = if noise.measured[i] { half } else { dt };
        }
        let mut var = [0.0; DRIVERS];
        for i in 0..3 {
            var[i] = noise.angular_acceleration[i] / dt;
            var[3 + i] = noise.specific_force[i] / dt;
        }
        self.p.propagate(top, &driver, &var)?;
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

    /// Measurement update, (3) and (4), where the innovation passes the gate.
    ///
    /// # Errors
    /// [`Breakdown`] where a variance is not positive or a state not finite.
    pub fn fuse(&mut self, observation: f64, prediction: &Prediction, gate_sigmas: f64) -> Result<Fusion, Breakdown> {
        let projection = self.p.project(&prediction.row, prediction.noise_var)?;
        let innovation_var = projection.innovation_var;
        let mut innovation = observation - prediction.value;
        if prediction.wraps {
            innovation = wrap(innovation);
        }
        let test_ratio = innovation * innovation / (gate_sigmas * gate_sigmas * innovation_var);
        let mut fusion = Fusion { innovation, innovation_var, test_ratio, gain: None };
        if test_ratio <= 1.0 {
            let gain = self.p.fuse(&projection)?;
            for (x, k) in self.x.iter_mut().zip(gain) {
                *x += k * innovation;
            }
            self.check()?;
            fusion.gain = Some(gain);
        }
        Ok(fusion)
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
