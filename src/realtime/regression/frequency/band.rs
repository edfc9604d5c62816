//! The band of frequencies in which the second estimator works.

use crate::flight::setting::Setting;

/// Frequencies that there is room for.
pub const FREQUENCIES: usize = 36;

/// Lowest frequency of any band, Hz: below it a record of a minute is no cycle.
const LOWEST_HZ: f64 = 0.01;
/// Highest, Hz: above it the regression's grid tells nothing.
const HIGHEST_HZ: f64 = 6.0;

/// Evenly spaced frequencies.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Band {
    /// The lowest, Hz.
    pub from_hz: f64,
    /// None is above this, Hz.
    pub to_hz: f64,
    /// From one to the next, Hz.
    pub step_hz: f64,
}

impl Default for Band {
    fn default() -> Self {
        Band::DEFAULT
    }
}

impl Band {
    /// Where rigid-body motion is, and structure and vibration are not.
    pub const DEFAULT: Band = Band { from_hz: 0.1, to_hz: 1.5, step_hz: 0.04 };

    /// What each setting must be: as many frequencies as there is room for, and no more.
    pub const fn settings(&self) -> [Setting; 3] {
        [
            ("lowest frequency of the band", self.from_hz, LOWEST_HZ, HIGHEST_HZ),
            ("highest frequency of the band", self.to_hz, self.from_hz, HIGHEST_HZ),
            ("step of the band", self.step_hz, (self.to_hz - self.from_hz) / FREQUENCIES as f64, self.to_hz - self.from_hz),
        ]
    }

    /// How many frequencies.
    pub fn count(&self) -> usize {
        let steps = libm::floor((self.to_hz - self.from_hz) / self.step_hz + 1e-6);
        (steps.max(0.0) as usize + 1).min(FREQUENCIES)
    }

    /// The frequency at a place, rad/s.
    pub fn rad_s(&self, place: usize) -> f64 {
        core::f64::consts::TAU * (self.from_hz + place as f64 * self.step_hz)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::flight::setting::check;

    #[test]
    fn the_band_begins_and_ends_where_it_says() {
        let band = Band::DEFAULT;
        assert_eq!(band.count(), FREQUENCIES);
        assert!((band.rad_s(35) / core::f64::consts::TAU - 1.5).abs() < 1e-12);
        assert!(check(&band.settings()).is_ok());
        assert_eq!(Band { step_hz: 0.3, ..band }.count(), 5);
        assert!(check(&Band { step_hz: 0.03, ..band }.settings()).is_err());
        assert!(check(&Band { to_hz: 0.1, ..band }.settings()).is_err());
    }
}
