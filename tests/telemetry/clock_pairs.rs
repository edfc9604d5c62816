//! Simulated pairs of recordings: one band-limited signal, two clocks, two rates, noise and gaps on both.

use sideslip::flight::signal::series::Series;
use sideslip::num::random::NormalNoise;
use std::f64::consts::TAU;

/// Lines of the signal's spectrum.
const LINES: usize = 120;

/// Motion of an aircraft, to 2 Hz.
pub(crate) const MOTION: Band = Band { std: 1.0, from_hz: 0.02, to_hz: 2.0, corner_hz: 0.5 };

/// A sum of sines at random places of a band, of density 1/(1 + (f/corner)^4).
#[derive(Clone, Debug)]
pub(crate) struct Signal {
    /// Angular frequency, amplitudes of sine and cosine.
    lines: Vec<(f64, f64, f64)>,
}

/// The spectrum: variance `std`^2 from `from_hz` to `to_hz`, and its corner.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Band {
    pub(crate) std: f64,
    pub(crate) from_hz: f64,
    pub(crate) to_hz: f64,
    pub(crate) corner_hz: f64,
}

impl Band {
    /// Its shape before it is scaled.
    fn shape(&self, f: f64) -> f64 {
        1.0 / (1.0 + (f / self.corner_hz).powi(4))
    }

    /// Two-sided density at a frequency.
    pub(crate) fn density(&self, f: f64) -> f64 {
        let steps = 2000;
        let step = (self.to_hz - self.from_hz) / f64::from(steps);
        let whole: f64 = (0..steps).map(|k| self.shape(self.from_hz + (f64::from(k) + 0.5) * step) * step).sum();
        0.5 * self.std * self.std * self.shape(f) / whole
    }

    /// A draw.
    pub(crate) fn draw(&self, seed: u64, stream: u64) -> Signal {
        let mut noise = NormalNoise::new(seed, stream);
        let width = (self.to_hz - self.from_hz) / LINES as f64;
        let mut lines = Vec::new();
        for k in 0..LINES {
            // Anywhere in its part of the band, so that the sum has no period.
            let place = 0.5 + (noise.draw() / 3.0).clamp(-0.5, 0.5);
            let f = self.from_hz + (k as f64 + place) * width;
            let std = (2.0 * self.density(f) * width).sqrt();
            lines.push((TAU * f, std * noise.draw(), std * noise.draw()));
        }
        Signal { lines }
    }
}

impl Signal {
    pub(crate) fn at(&self, time_s: f64) -> f64 {
        self.lines
            .iter()
            .map(|(omega, a, b)| {
                let (sin, cos) = (omega * time_s).sin_cos();
                a * sin + b * cos
            })
            .sum()
    }
}

/// How one recording samples the signal: `bias + scale s(true time) + noise`.
#[derive(Clone, Debug)]
pub(crate) struct Recorder {
    pub(crate) rate_hz: f64,
    pub(crate) noise_std: f64,
    pub(crate) bias: f64,
    pub(crate) scale: f64,
    /// Time on our clock, s.
    pub(crate) from_s: f64,
    pub(crate) to_s: f64,
    /// Gaps on our clock, s.
    pub(crate) gaps_s: Vec<(f64, f64)>,
}

impl Recorder {
    /// What it records on a clock whose t is (our time - offset)/(1 + drift).
    pub(crate) fn record(&self, signal: impl Fn(f64) -> f64, offset_s: f64, drift: f64, seed: u64, stream: u64) -> Series {
        let mut noise = NormalNoise::new(seed, stream);
        // Clocks do not tick together.
        let phase = (0.31 * stream as f64 + 0.17 * seed as f64).fract();
        let own = |time_s: f64| (time_s - offset_s) / (1.0 + drift);
        let first = own(self.from_s);
        let count = ((own(self.to_s) - first) * self.rate_hz) as u64;
        Series::of((0..count).filter_map(|k| {
            let own_s = first + (k as f64 + phase) / self.rate_hz;
            let ours_s = offset_s + (1.0 + drift) * own_s;
            let value = self.bias + self.scale * signal(ours_s) + self.noise_std * noise.draw();
            let lost = self.gaps_s.iter().any(|(from, to)| ours_s > *from && ours_s < *to);
            (!lost).then_some((own_s, value))
        }))
    }
}

/// A recorder without gaps.
pub(crate) fn recorder(rate_hz: f64, noise_std: f64, from_s: f64, to_s: f64) -> Recorder {
    Recorder { rate_hz, noise_std, bias: 3.0, scale: 1.0, from_s, to_s, gaps_s: Vec::new() }
}
