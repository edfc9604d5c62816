//! What the state estimation assumes: noise of the instruments, priors of their biases, gates and windows.

use super::aid_kind::Aid;
pub use crate::flight::setting::ConfigError;
use crate::flight::setting::{Setting, check};

/// Standard deviations of the instruments' white noise, a sample.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Noise {
    /// Accelerometers x y z, m/s^2.
    pub accelerometer_std: [f64; 3],
    /// Gyros p q r, rad/s.
    pub gyro_std: [f64; 3],
    /// True airspeed, m/s.
    pub airspeed_std: f64,
    /// Incidence vane, rad.
    pub incidence_std: f64,
    /// Sideslip vane, rad.
    pub sideslip_std: f64,
    /// Bank, rad.
    pub bank_std: f64,
    /// Pitch attitude, rad.
    pub pitch_std: f64,
    /// Heading, rad.
    pub heading_std: f64,
    /// Altitude, m.
    pub altitude_std: f64,
}

impl Noise {
    /// Of one aid, in the aid's unit.
    pub fn of(&self, aid: Aid) -> f64 {
        match aid {
            Aid::Airspeed => self.airspeed_std,
            Aid::Incidence => self.incidence_std,
            Aid::Sideslip => self.sideslip_std,
            Aid::Bank => self.bank_std,
            Aid::Pitch => self.pitch_std,
            Aid::Heading => self.heading_std,
            Aid::Altitude => self.altitude_std,
        }
    }

    pub(crate) fn of_mut(&mut self, aid: Aid) -> &mut f64 {
        match aid {
            Aid::Airspeed => &mut self.airspeed_std,
            Aid::Incidence => &mut self.incidence_std,
            Aid::Sideslip => &mut self.sideslip_std,
            Aid::Bank => &mut self.bank_std,
            Aid::Pitch => &mut self.pitch_std,
            Aid::Heading => &mut self.heading_std,
            Aid::Altitude => &mut self.altitude_std,
        }
    }
}

/// Where the noise statistics come from.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum NoiseSource {
    /// From the record, by maximum likelihood, within bounds about what is configured.
    #[default]
    Record,
    /// As configured.
    Configured,
}

/// What the regression runs on.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum RegressionStates {
    /// Smoothed states: every signal through the same zero-phase kernel, `lag_s` late.
    #[default]
    Smoothed,
    /// Filtered states, measured rates, forces and controls, all through the same causal state-variable filter, so that nothing
    /// comes late behind anything else; less smooth, so standard errors are a fifth to two fifths larger (`tests/studies`).
    Filtered,
}

/// Configuration of the estimation stage.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EstimationConfig {
    /// Noise of the instruments: until the record has shown its own where `noise_source` says so.
    pub noise: Noise,
    /// Random walk of the angular accelerations p-dot q-dot r-dot, rad/s^2 per sqrt(s); likewise.
    pub angular_acceleration_walk: [f64; 3],
    /// Random walk of the specific forces x y z, m/s^2 per sqrt(s); likewise.
    pub specific_force_walk: [f64; 3],
    /// Where the noise comes from.
    pub noise_source: NoiseSource,
    /// Prior standard deviation of the scale errors of airspeed, incidence and sideslip; 0 takes them for exact.
    pub scale_error_std: [f64; 3],
    /// Prior standard deviation of the accelerometer biases, m/s^2.
    pub accelerometer_bias_std: f64,
    /// Prior standard deviation of the gyro biases, rad/s.
    pub gyro_bias_std: f64,
    /// Random walk of the accelerometer biases, m/s^2 per sqrt(s).
    pub accelerometer_bias_walk: f64,
    /// Random walk of the gyro biases, rad/s per sqrt(s).
    pub gyro_bias_walk: f64,
    /// Acceleration that a missing accelerometer may have left out, m/s^2, with a correlation time of 1 s.
    pub unmeasured_acceleration_std: f64,
    /// Innovations beyond so many of their standard deviations are rejected.
    pub gate_sigmas: f64,
    /// What the regression runs on.
    pub regression_states: RegressionStates,
    /// Lag of the fixed-lag smoother, s.
    pub smoother_lag_s: f64,
    /// Half width of the smoothing kernel: the regression lags the newest sample by that much, s.
    pub lag_s: f64,
    /// Corner of the state-variable filter that filtered states go through, omega/(2 pi): they lag by 2/omega, Hz.
    pub cutoff_hz: f64,
    /// Interval of the regression grid, s.
    pub grid_s: f64,
    /// Length of the window at the run's start whose mean is the trim, s.
    pub trim_window_s: f64,
    /// Silence longer than this is a gap: the filter starts again, s.
    pub gap_s: f64,
    /// A channel's last value serves for at most so long, s.
    pub hold_s: f64,
}

impl Default for EstimationConfig {
    fn default() -> Self {
        EstimationConfig::DEFAULT
    }
}

impl EstimationConfig {
    /// Instruments of flight-test quality; nothing here was tuned to a recording.
    pub const DEFAULT: EstimationConfig = EstimationConfig {
        noise: Noise {
            accelerometer_std: [0.05; 3],
            gyro_std: [0.002; 3],
            airspeed_std: 0.5,
            incidence_std: 0.003,
            sideslip_std: 0.003,
            bank_std: 0.003,
            pitch_std: 0.003,
            heading_std: 0.005,
            altitude_std: 2.0,
        },
        angular_acceleration_walk: [0.5; 3],
        specific_force_walk: [3.0; 3],
        noise_source: NoiseSource::Record,
        scale_error_std: [0.0; 3],
        accelerometer_bias_std: 0.1,
        gyro_bias_std: 0.003,
        accelerometer_bias_walk: 1e-4,
        gyro_bias_walk: 1e-5,
        unmeasured_acceleration_std: 1.0,
        gate_sigmas: 5.0,
        regression_states: RegressionStates::Smoothed,
        smoother_lag_s: 0.5,
        lag_s: 0.4,
        cutoff_hz: 2.0,
        grid_s: 0.08,
        trim_window_s: 1.0,
        gap_s: 1.0,
        hold_s: 0.5,
    };

    /// Checks every setting once, so that no stage has to.
    ///
    /// # Errors
    /// [`ConfigError`] names the first setting that is out of its range.
    pub const fn validate(&self) -> Result<(), ConfigError> {
        let n = &self.noise;
        let settings: [Setting; _] = [
            ("noise of the x accelerometer", n.accelerometer_std[0], 0.0, 100.0),
            ("noise of the y accelerometer", n.accelerometer_std[1], 0.0, 100.0),
            ("noise of the z accelerometer", n.accelerometer_std[2], 0.0, 100.0),
            ("noise of the p gyro", n.gyro_std[0], 0.0, 10.0),
            ("noise of the q gyro", n.gyro_std[1], 0.0, 10.0),
            ("noise of the r gyro", n.gyro_std[2], 0.0, 10.0),
            ("noise of the airspeed", n.airspeed_std, 0.0, 100.0),
            ("noise of the incidence vane", n.incidence_std, 0.0, 1.0),
            ("noise of the sideslip vane", n.sideslip_std, 0.0, 1.0),
            ("noise of the bank angle", n.bank_std, 0.0, 1.0),
            ("noise of the pitch attitude", n.pitch_std, 0.0, 1.0),
            ("noise of the heading", n.heading_std, 0.0, 3.0),
            ("noise of the altitude", n.altitude_std, 0.0, 1e4),
            ("walk of p-dot", self.angular_acceleration_walk[0], 0.0, 1e4),
            ("walk of q-dot", self.angular_acceleration_walk[1], 0.0, 1e4),
            ("walk of r-dot", self.angular_acceleration_walk[2], 0.0, 1e4),
            ("walk of the x specific force", self.specific_force_walk[0], 0.0, 1e4),
            ("walk of the y specific force", self.specific_force_walk[1], 0.0, 1e4),
            ("walk of the z specific force", self.specific_force_walk[2], 0.0, 1e4),
            ("prior of the airspeed scale", self.scale_error_std[0], -f64::MIN_POSITIVE, 1.0),
            ("prior of the incidence scale", self.scale_error_std[1], -f64::MIN_POSITIVE, 1.0),
            ("prior of the sideslip scale", self.scale_error_std[2], -f64::MIN_POSITIVE, 1.0),
            ("prior of the accelerometer biases", self.accelerometer_bias_std, 0.0, 100.0),
            ("prior of the gyro biases", self.gyro_bias_std, 0.0, 10.0),
            ("walk of the accelerometer biases", self.accelerometer_bias_walk, -f64::MIN_POSITIVE, 10.0),
            ("walk of the gyro biases", self.gyro_bias_walk, -f64::MIN_POSITIVE, 1.0),
            ("unmeasured acceleration", self.unmeasured_acceleration_std, 0.0, 1e3),
            ("innovation gate", self.gate_sigmas, 1.0, 100.0),
            ("smoother lag", self.smoother_lag_s, 0.02, 5.0),
            ("smoothing lag", self.lag_s, 0.02, 5.0),
            ("corner of the state-variable filter", self.cutoff_hz, 0.1, 20.0),
            ("regression interval", self.grid_s, 0.005, 0.1),
            ("trim window", self.trim_window_s, 0.0, 60.0),
            ("gap", self.gap_s, 0.05, 60.0),
            ("hold", self.hold_s, 0.01, 60.0),
        ];
        check(&settings)
    }
}
