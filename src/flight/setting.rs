//! A setting out of its range: the one way in which a stage refuses its configuration.

/// A setting that cannot be used.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ConfigError {
    /// Which setting.
    pub setting: &'static str,
    /// Its value.
    pub found: f64,
    /// What it must be above.
    pub above: f64,
    /// What it must not exceed.
    pub at_most: f64,
}

impl core::fmt::Display for ConfigError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        write!(f, "{} is {}: expected above {} and at most {}", self.setting, self.found, self.above, self.at_most)
    }
}

impl core::error::Error for ConfigError {}

/// Which setting, its value, what it must be above, what it must not exceed.
pub type Setting = (&'static str, f64, f64, f64);

/// Checks settings against their ranges.
///
/// # Errors
/// [`ConfigError`] names the first that is out of its range.
pub const fn check(settings: &[Setting]) -> Result<(), ConfigError> {
    // A constant function has no iterators.
    let mut i = 0;
    while i < settings.len() {
        let (setting, found, above, at_most) = settings[i];
        if !(found > above && found <= at_most) {
            return Err(ConfigError { setting, found, above, at_most });
        }
        i += 1;
    }
    Ok(())
}
