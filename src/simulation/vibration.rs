//! Blade-passing vibration: two spectral lines that follow the rotor.
//!
//! Consumes the rotor's speed over time; produces what an instrument reads besides the motion. With B blades and azimuth psi:
//!     psi = integral of rotor speed,   y = a1 cos(B psi + f1) + a2 cos(2 B psi + f2)     (1)
//! so the phase is continuous whatever the speed does; f1 and f2 are drawn by seed for each channel. A first-order lag of the
//! instrument gives each line, at its angular frequency w of that moment, the gain and phase of
//!     1 / (1 + i w tau)                                                                  (2)
//! It is a vibration at the instrument, not of the rigid body: it is not integrated, and does not refine the mesh. Sampled at
//! less than twice its frequency it is aliased, as in an aircraft.

use super::integrate::TrueState;
use crate::flight::channel::Channel;
use crate::num::random::NormalNoise;
use core::f64::consts::TAU;

/// First stream of noise that phases are drawn from, above those of channels and gusts.
const FIRST_STREAM: u64 = 2000;

/// The rotor's azimuth over time, by trapezia between true states.
#[derive(Clone, Debug)]
pub(crate) struct Azimuth {
    /// Time s, azimuth rad, speed rad/s.
    points: Vec<(f64, f64, f64)>,
}

impl Azimuth {
    /// From zero at the first state on; `None` where a state has no rotor speed.
    pub(crate) fn of(states: &[TrueState]) -> Option<Self> {
        let mut points: Vec<(f64, f64, f64)> = Vec::with_capacity(states.len());
        for state in states {
            let speed = state.rotor_speed?;
            let azimuth = points
                .last()
                .map_or(0.0, |&(before_s, azimuth, before)| azimuth + 0.5 * (before + speed) * (state.time_s - before_s));
            points.push((state.time_s, azimuth, speed));
        }
        Some(Azimuth { points })
    }

    /// Azimuth, rad, and speed, rad/s; before the first time and after the last the speed is held.
    fn at(&self, time_s: f64) -> (f64, f64) {
        let after = self.points.partition_point(|&(t, _, _)| t <= time_s);
        let before = after.checked_sub(1).and_then(|place| self.points.get(place));
        match (before, self.points.get(after)) {
            (Some(&(t0, azimuth, speed)), Some(&(t1, _, next))) => {
                let (h, slope) = (time_s - t0, (next - speed) / (t1 - t0));
                (azimuth + h * (speed + 0.5 * h * slope), speed + h * slope)
            }
            (Some(&(t, azimuth, speed)), None) | (None, Some(&(t, azimuth, speed))) => (azimuth + (time_s - t) * speed, speed),
            (None, None) => (0.0, 0.0),
        }
    }
}

#[derive(Clone, Copy, Debug)]
pub(crate) struct Vibration {
    blades: f64,
    /// Amplitude and phase of each.
    lines: [(f64, f64); 2],
}

impl Vibration {
    /// These amplitudes, in the channel's unit, with phases by seed.
    pub(crate) fn new(channel: Channel, amplitudes: [f64; 2], blades: f64, seed: u64) -> Self {
        let mut phases = NormalNoise::new(seed, FIRST_STREAM + channel.index() as u64);
        Vibration { blades, lines: amplitudes.map(|amplitude| (amplitude, TAU * phases.uniform())) }
    }

    /// (1) behind these lags, s.
    pub(crate) fn at(&self, time_s: f64, azimuth: &Azimuth, lags_s: impl Iterator<Item = f64> + Clone) -> f64 {
        let (azimuth, speed) = azimuth.at(time_s);
        let mut sum = 0.0;
        for (harmonic, (amplitude, phase)) in [1.0, 2.0].into_iter().zip(self.lines) {
            let order = harmonic * self.blades;
            let (mut amplitude, mut angle) = (amplitude, order * azimuth + phase);
            for tau in lags_s.clone() {
                let behind = order * speed * tau;
                amplitude /= libm::sqrt(1.0 + behind * behind);
                angle -= libm::atan(behind);
            }
            sum += amplitude * libm::cos(angle);
        }
        sum
    }
}
