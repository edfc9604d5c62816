//! Dropouts: time ranges in which a link or an instrument delivers no samples.
//!
//! Consumes how often they begin and how long they last; produces whether a time is lost. Stretches of reception and of loss
//! follow each other, the lengths of both drawn from exponential laws, so that with r losses a second of reception and a
//! mean length m
//!     share of time lost = r m / (1 + r m)                                               (1)
//! It starts in reception. A lost sample is missing: no value is repeated.

use crate::num::random::NormalNoise;

/// First stream of noise that dropouts take, above those of channels, gusts and vibration.
const FIRST_STREAM: u64 = 3000;

/// How a link drops out.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Dropouts {
    /// Losses a second of reception, 1/s.
    pub rate: f64,
    /// Mean length of a loss, s.
    pub mean_length_s: f64,
}

/// One link as time goes on.
#[derive(Clone, Debug)]
pub(crate) struct DropoutLink {
    dropouts: Dropouts,
    draws: NormalNoise,
    lost: bool,
    until_s: f64,
}

impl DropoutLink {
    /// In reception at that time; links are distinguished by their number.
    pub(crate) fn new(dropouts: Dropouts, number: u64, start_s: f64, seed: u64) -> Self {
        let mut link =
            DropoutLink { dropouts, draws: NormalNoise::new(seed, FIRST_STREAM + number), lost: false, until_s: start_s };
        link.until_s += link.stretch_s();
        link
    }

    /// Whether what is sent at that time is lost; times are asked for in increasing order.
    pub(crate) fn loses(&mut self, time_s: f64) -> bool {
        while self.until_s <= time_s {
            self.lost = !self.lost;
            self.until_s += self.stretch_s();
        }
        self.lost
    }

    /// Length of the stretch that begins, s.
    fn stretch_s(&mut self) -> f64 {
        let mean_s = if self.lost { self.dropouts.mean_length_s } else { 1.0 / self.dropouts.rate };
        -mean_s * libm::log(1.0 - self.draws.uniform())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_share_and_the_number_of_losses_are_those_of_the_law() {
        let dropouts = Dropouts { rate: 0.2, mean_length_s: 0.5 };
        let (mut link, duration_s, step_s) = (DropoutLink::new(dropouts, 3, 0.0, 5), 100_000.0, 0.01);
        let (mut lost, mut begun, mut before) = (0.0, 0.0, false);
        for step in 0..(duration_s / step_s) as u64 {
            let now = link.loses(step as f64 * step_s);
            lost += if now { step_s } else { 0.0 };
            begun += if now && !before { 1.0 } else { 0.0 };
            before = now;
        }
        // Alternating renewal of means U = 5 s and D = 0.5 s, both exponential: the time lost has the variance
        // 2 U^2 D^2 T / (U + D)^3; losses shorter than a step (2 %) go uncounted. Four standard deviations either way.
        let (up, down) = (5.0f64, 0.5f64);
        let std = (2.0 * (up * down).powi(2) * duration_s / (up + down).powi(3)).sqrt();
        assert!((lost - duration_s * down / (up + down)).abs() < 4.0 * std, "{lost} s lost, {std}");
        let cycles = duration_s / (up + down);
        let seen = cycles * (-step_s / (2.0 * down)).exp();
        assert!((begun - seen).abs() < 4.0 * cycles.sqrt(), "{begun} losses of {seen}");
    }
}
