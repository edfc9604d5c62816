//! Noise statistics in use: as configured, or estimated from the record within bounds about the configured ones.
//!
//! Consumes admitted samples; produces the standard deviations that the aids are predicted with and the random walks that
//! drive the process. Every channel has a bank (`noise_bank`); what its maximum of likelihood says is taken within
//!     gyros: `LEAST` to `MOST` times the configured standard deviation, accelerometers from `FORCE_LEAST` on (a random walk
//!     is a poor picture of a specific force, and at slow rates leaves it hardly any noise)            (1)
//!     aids: 1 to `MOST` times it: a vane in turbulent air is worse than its own noise, never better (2)
//!     random walks: `WALK_LEAST` to `WALK_MOST` times the configured one                             (3)
//! A bank does not contain slow errors: gusts, a wrong position of an instrument. So the variance of an aid is also multiplied by
//! c, which follows the normalised innovations of fused measurements,
//!     ln c <- ln c + `GAIN` (min(nu^2/s, 9) - 1),   1 <= c <= `INFLATION_MOST`                        (4)
//! and settles where their mean is 1. Rejected measurements do not count, so that a fault stays rejected.
//! Source: Padfield et al. 1987, section 2.2.4, on the sensitivity of the filter to its process noise.

use super::aid::inertial::INERTIAL;
use super::config::{EstimationConfig, Noise, NoiseSource};
use super::ekf::ProcessNoise;
use super::noise_bank::{NoiseBank, Wander};
use super::record::{AIDS, Aid, NoiseRecord};
use crate::flight::sample::Sample;
use core::f64::consts::PI;

/// Bounds (1) and (2).
const LEAST: f64 = 0.1;
const FORCE_LEAST: f64 = 0.3;
const MOST: f64 = 20.0;
/// Bounds (3).
const WALK_LEAST: f64 = 0.02;
const WALK_MOST: f64 = 100.0;

/// Gain and bound of (4).
const GAIN: f64 = 0.01;
const INFLATION_MOST: f64 = 100.0;

/// Channels with a bank: gyros, accelerometers, aids.
const BANKS: usize = 6 + AIDS;

/// The statistics in use and the banks they are estimated by.
#[derive(Clone, Debug)]
pub struct NoiseStatistics {
    source: NoiseSource,
    banks: [NoiseBank; BANKS],
    configured: NoiseRecord,
    /// Without (4).
    by_banks: Noise,
    /// c of (4), by `Aid::index()`.
    inflation: [f64; AIDS],
    now: NoiseRecord,
}

fn within(std: f64, configured: f64, least: f64, most: f64) -> f64 {
    std.clamp(least * configured, most * configured)
}

impl NoiseStatistics {
    /// The configured statistics, until the banks have an estimate.
    pub const fn new(config: &EstimationConfig) -> Self {
        let mut banks = [const { NoiseBank::new(Wander::Slope) }; BANKS];
        let mut i = 0;
        while i < 3 {
            banks[3 + i] = NoiseBank::new(Wander::Level);
            i += 1;
        }
        let configured = NoiseRecord {
            noise: config.noise,
            angular_acceleration_walk: config.angular_acceleration_walk,
            specific_force_walk: config.specific_force_walk,
        };
        let (by_banks, inflation) = (configured.noise, [1.0; AIDS]);
        NoiseStatistics { source: config.noise_source, banks, configured, by_banks, inflation, now: configured }
    }

    /// What is in use.
    pub fn record(&self) -> &NoiseRecord {
        &self.now
    }

    /// The instruments' noise in use.
    pub fn noise(&self) -> &Noise {
        &self.now.noise
    }

    /// Variance of an aid's noise without (4): what its innovations are judged by.
    pub fn without_inflation(&self, aid: Aid) -> f64 {
        self.by_banks.of(aid) * self.by_banks.of(aid)
    }

    /// An innovation of that aid was fused: its square over its variance, for (4).
    pub fn fused(&mut self, aid: Aid, nis: f64) {
        if self.source == NoiseSource::Configured {
            return;
        }
        if let Some(c) = self.inflation.get_mut(aid.index()) {
            *c = (*c * libm::exp(GAIN * (nis.min(9.0) - 1.0))).clamp(1.0, INFLATION_MOST);
        }
    }

    /// Whether the newest reading of an aid stands out from those before it, as a spike does.
    pub fn stands_out(&self, aid: Aid) -> bool {
        self.banks.get(INERTIAL.len() + aid.index()).is_some_and(NoiseBank::waits)
    }

    /// The signals begin anew: after a gap.
    pub fn break_off(&mut self) {
        for bank in &mut self.banks {
            bank.break_off();
        }
    }

    /// Takes a sample in.
    pub fn take(&mut self, sample: &Sample) {
        if self.source == NoiseSource::Configured {
            return;
        }
        let channels = INERTIAL.into_iter().chain(Aid::ALL.map(Aid::channel));
        for (place, (bank, channel)) in self.banks.iter_mut().zip(channels).enumerate() {
            if let Some(value) = sample.get(channel) {
                let wraps = place == 6 + Aid::Heading.index() || place == 6 + Aid::Bank.index();
                bank.take(sample.time_s, value, if wraps { 2.0 * PI } else { 0.0 });
            }
        }
    }

    /// Updates the statistics in use from the banks.
    pub fn update(&mut self) {
        if self.source == NoiseSource::Configured {
            return;
        }
        let was = &self.configured;
        for (place, bank) in self.banks.iter().enumerate() {
            let Some(found) = bank.likeliest() else { continue };
            let (std, walk) = (libm::sqrt(found.noise_var), libm::sqrt(found.intensity));
            let now = &mut self.now;
            match place {
                0..3 => {
                    now.noise.gyro_std[place] = within(std, was.noise.gyro_std[place], LEAST, MOST);
                    now.angular_acceleration_walk[place] =
                        within(walk, was.angular_acceleration_walk[place], WALK_LEAST, WALK_MOST);
                }
                3..6 => {
                    let i = place - 3;
                    now.noise.accelerometer_std[i] = within(std, was.noise.accelerometer_std[i], FORCE_LEAST, MOST);
                    now.specific_force_walk[i] = within(walk, was.specific_force_walk[i], WALK_LEAST, WALK_MOST);
                }
                _ => {
                    if let Some(&aid) = Aid::ALL.get(place - 6) {
                        let by_banks = within(std, was.noise.of(aid), 1.0, MOST);
                        *self.by_banks.of_mut(aid) = by_banks;
                        let inflation = self.inflation.get(aid.index()).copied().unwrap_or(1.0);
                        *now.noise.of_mut(aid) = by_banks * libm::sqrt(inflation);
                    }
                }
            }
        }
    }

    /// Process noise, with the configured random walks of the biases and of axes without an accelerometer.
    pub fn process(&self, config: &EstimationConfig, measured: [bool; 3]) -> ProcessNoise {
        let square = |std: f64| std * std;
        // Correlated over 1 s: white noise of that intensity brings as much variance.
        let unmeasured = 2.0 * square(config.unmeasured_acceleration_std);
        let walk = self.now.specific_force_walk;
        ProcessNoise {
            angular_acceleration: self.now.angular_acceleration_walk.map(square),
            specific_force: core::array::from_fn(|i| if measured[i] { square(walk[i]) } else { unmeasured }),
            measured,
            accelerometer_walk_var: square(config.accelerometer_bias_walk),
            gyro_walk_var: square(config.gyro_bias_walk),
        }
    }
}
