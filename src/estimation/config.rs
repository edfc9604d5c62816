//! What the state estimation assumes: noise of the instruments, priors of their biases, gates and windows.

pub use crate::flight::setting::ConfigError;
use crate::flight::setting::{Setting, check};

/// Standard deviations of the instruments' white noise, a sample.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Noise {
    /// Accelerometers, m/s^2.
    pub accelerometer_std: f64,
    /// Gyros, rad/s.
    pub gyro_std: f64,
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

/// Configuration of the estimation stage.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Config {
    /// Noise of the instruments.
    pub noise: Noise,
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
    /// Half width of the smoothing kernel: the regression lags the newest sample by that much, s.
    pub lag_s: f64,
    /// Interval of the regression grid, s.
    pub grid_s: f64,
    /// Length of the window at the run's start whose mean is the trim, s.
    pub trim_window_s: f64,
    /// Silence longer than this is a gap: the filter starts again, s.
    pub gap_s: f64,
    /// A channel's last value serves for at most so long, s.
    pub hold_s: f64,
}

impl Default for Config {
    fn default() -> Self {
        Config::DEFAULT
    }
}

impl Config {
    /// Instruments of flight-test quality; nothing here was tuned to a recording.
    pub const DEFAULT: Config = Config {
        noise: Noise {
            accelerometer_std: 0.05,
            gyro_std: 0.002,
            airspeed_std: 0.5,
            incidence_std: 0.003,
            sideslip_std: 0.003,
            bank_std: 0.003,
            pitch_std: 0.003,
            heading_std: 0.005,
            altitude_std: 2.0,
        },
        accelerometer_bias_std: 0.1,
        gyro_bias_std: 0.003,
        accelerometer_bias_walk: 1e-4,
        gyro_bias_walk: 1e-5,
        unmeasured_acceleration_std: 1.0,
        gate_sigmas: 5.0,
        lag_s: 0.4,
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
            ("noise of the accelerometers", n.accelerometer_std, 0.0, 100.0),
            ("noise of the gyros", n.gyro_std, 0.0, 10.0),
            ("noise of the airspeed", n.airspeed_std, 0.0, 100.0),
            ("noise of the incidence vane", n.incidence_std, 0.0, 1.0),
            ("noise of the sideslip vane", n.sideslip_std, 0.0, 1.0),
            ("noise of the bank angle", n.bank_std, 0.0, 1.0),
            ("noise of the pitch attitude", n.pitch_std, 0.0, 1.0),
            ("noise of the heading", n.heading_std, 0.0, 3.0),
            ("noise of the altitude", n.altitude_std, 0.0, 1e4),
            ("prior of the accelerometer biases", self.accelerometer_bias_std, 0.0, 100.0),
            ("prior of the gyro biases", self.gyro_bias_std, 0.0, 10.0),
            ("walk of the accelerometer biases", self.accelerometer_bias_walk, -f64::MIN_POSITIVE, 10.0),
            ("walk of the gyro biases", self.gyro_bias_walk, -f64::MIN_POSITIVE, 1.0),
            ("unmeasured acceleration", self.unmeasured_acceleration_std, 0.0, 1e3),
            ("innovation gate", self.gate_sigmas, 1.0, 100.0),
            ("smoothing lag", self.lag_s, 0.02, 5.0),
            ("regression interval", self.grid_s, 0.005, 0.1),
            ("trim window", self.trim_window_s, 0.0, 60.0),
            ("gap", self.gap_s, 0.05, 60.0),
            ("hold", self.hold_s, 0.01, 60.0),
        ];
        check(&settings)
    }
}
