//! Configuration of the regression: thresholds, forgetting, convergence.

use super::frequency::band::Band;
use crate::flight::setting::ConfigError;
use crate::flight::setting::{Setting, check};

/// Configuration of the regression stage.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RegressionConfig {
    /// A term enters above this corrected partial F.
    pub f_enter: f64,
    /// A term leaves below this corrected partial F.
    pub f_remove: f64,
    /// Time constant of forgetting, s of excited time.
    pub forgetting_s: f64,
    /// Excited time before there are numbers, s.
    pub exciting_s: f64,
    /// Quiet time after which numbers are stale, s.
    pub stale_s: f64,
    /// Rates slower than this are too slow for derivatives, Hz.
    pub rate_min_hz: f64,
    /// Standard error of a primary term, relative to its value, below which it is known.
    pub known_relative: f64,
    /// The same relative to the response: standard error times the regressor's deviation over the response's.
    pub known_contribution: f64,
    /// Estimates must have stayed within two standard errors for so long, s.
    pub settled_s: f64,
    /// Where the second estimator works.
    pub band: Band,
}

impl Default for RegressionConfig {
    fn default() -> Self {
        RegressionConfig::DEFAULT
    }
}

impl RegressionConfig {
    /// Entry at F 12 is about 1 % false entry over ten candidates; the rest is the field's usual practice.
    pub const DEFAULT: RegressionConfig = RegressionConfig {
        f_enter: 12.0,
        f_remove: 8.0,
        forgetting_s: 60.0,
        exciting_s: 2.0,
        stale_s: 10.0,
        rate_min_hz: 8.0,
        known_relative: 0.1,
        known_contribution: 0.05,
        settled_s: 2.0,
        band: Band::DEFAULT,
    };

    /// Validates every setting.
    ///
    /// # Errors
    /// [`ConfigError`] names the first setting that is out of its range.
    pub const fn validate(&self) -> Result<(), ConfigError> {
        let settings: [Setting; _] = [
            ("F of removal", self.f_remove, 0.0, 1e3),
            ("F of entry", self.f_enter, self.f_remove, 1e4),
            ("forgetting", self.forgetting_s, 1.0, 1e9),
            ("excited time before numbers", self.exciting_s, 0.0, 1e3),
            ("quiet time before stale", self.stale_s, 0.0, 1e6),
            ("slowest rate", self.rate_min_hz, 1.0, 100.0),
            ("known relative to its value", self.known_relative, 0.0, 1.0),
            ("known relative to the response", self.known_contribution, 0.0, 1.0),
            ("settling time", self.settled_s, 0.0, 1e3),
        ];
        match check(&settings) {
            Ok(()) => check(&self.band.settings()),
            refused => refused,
        }
    }
}
