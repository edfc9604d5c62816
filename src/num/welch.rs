//! Spectra and coherence of evenly sampled signals: averaged periodograms over overlapping windows.
//!
//! Consumes a signal x_j at steps dt; produces for every segment of length T, its mean subtracted, under Hann's window w, at the
//! frequencies f_k
//!     X_k = sum_j w_j x_j exp(-2 pi i f_k j dt)                                                           (1)
//! then, over all segments of all runs, the one-sided density and the coherence of two signals,
//!     S_k = 2 dt/sum w^2 mean |X_k|^2     gamma^2_k = |mean X_k* Y_k|^2/(mean |X_k|^2 mean |Y_k|^2)        (2)
//! Of m segments, each of which overlaps the one j places on so that their values correlate by rho_j, as many are independent as
//!     n = m/(1 + 2 sum_j (m - j)/m rho_j^2)                                                               (3)
//! and independent signals exceed gamma^2 = 1 - p^(1/(n - 1)) with probability p.                          (4)
//! Under Hann's window rho is 0.659155, 1/6 for segments a quarter and a half of their length apart. Squares of Hann windows a
//! quarter apart add up to a constant, so that a sweep, which passes a frequency at one place of each, is not weighted by where
//! that is.
//! Source: P. D. Welch, IEEE Trans. AU-15 (1967); G. C. Carter, C. H. Knapp, A. H. Nuttall, IEEE Trans. AU-21 (1973), for (4).
//! Numerics: the coherence of a constant signal is zero.

use core::f64::consts::TAU;

/// Part of a segment that the next one shares with it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Overlap {
    Half,
    ThreeQuarters,
}

impl Overlap {
    /// From one segment's begin to the next one's, of so many samples.
    fn hop(self, length: usize) -> usize {
        match self {
            Overlap::Half => length / 2,
            Overlap::ThreeQuarters => length / 4,
        }
    }

    /// (3) of m segments.
    pub(crate) fn independent(self, segments: usize) -> f64 {
        let correlations: &[f64] = match self {
            Overlap::Half => &[1.0 / 6.0],
            Overlap::ThreeQuarters => &[0.659_155, 1.0 / 6.0],
        };
        let m = segments as f64;
        let shared = correlations.iter().zip(1..).map(|(rho, j)| (m - f64::from(j)).max(0.0) / m.max(1.0) * rho * rho);
        m / (1.0 + 2.0 * shared.sum::<f64>())
    }
}

/// How signals are cut, and at which frequencies they are transformed.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct WelchConfig {
    /// Length of a segment, s.
    pub(crate) segment_s: f64,
    pub(crate) overlap: Overlap,
    /// f_k, Hz.
    pub(crate) hz: Vec<f64>,
}

/// One segment's X of (1), each times sqrt(2 dt/sum w^2): real and imaginary part.
pub(crate) type SegmentSpectrum = Vec<(f64, f64)>;

impl WelchConfig {
    /// The first lines that segments of that length resolve, 1/T apart from 1/T up; segments overlap by half.
    pub(crate) fn lines(segment_s: f64, lines: u32) -> Self {
        WelchConfig { segment_s, overlap: Overlap::Half, hz: (1..=lines).map(|line| f64::from(line) / segment_s).collect() }
    }

    /// The segments of one signal; none where it is shorter than one.
    pub(crate) fn segments(&self, values: &[f64], step_s: f64) -> Vec<SegmentSpectrum> {
        let length = libm::round(self.segment_s / step_s) as usize;
        if length < 8 || values.len() < length {
            return Vec::new();
        }
        let window: Vec<f64> = (0..length).map(|j| 0.5 - 0.5 * libm::cos(TAU * (j as f64 + 0.5) / length as f64)).collect();
        let scale = libm::sqrt(2.0 * step_s / window.iter().map(|w| w * w).sum::<f64>());
        let turns: Vec<Vec<(f64, f64)>> = self
            .hz
            .iter()
            .map(|hz| {
                let omega = TAU * hz * step_s;
                window
                    .iter()
                    .enumerate()
                    .map(|(j, _)| libm::sincos(omega * j as f64))
                    .zip(&window)
                    .map(|((s, c), w)| (s * w, c * w))
                    .collect()
            })
            .collect();
        values
            .windows(length)
            .step_by(self.overlap.hop(length))
            .map(|part| {
                let mean = part.iter().sum::<f64>() / length as f64;
                turns
                    .iter()
                    .map(|turn| {
                        let sum = part
                            .iter()
                            .zip(turn)
                            .fold((0.0, 0.0), |(re, im), (x, (sin, cos))| (re + (x - mean) * cos, im - (x - mean) * sin));
                        (scale * sum.0, scale * sum.1)
                    })
                    .collect()
            })
            .collect()
    }

    /// S of (2), by frequency.
    pub(crate) fn density(&self, segments: &[SegmentSpectrum]) -> Vec<f64> {
        self.mean(segments, segments, |(a, b), _| (a * a + b * b, 0.0)).into_iter().map(|(density, _)| density).collect()
    }

    /// Mean X* Y by frequency, real and imaginary part, in the unit of S; segment by segment the same times.
    pub(crate) fn cross_density(&self, x: &[SegmentSpectrum], y: &[SegmentSpectrum]) -> Vec<(f64, f64)> {
        self.mean(x, y, |(a, b), (c, d)| (a * c + b * d, a * d - b * c))
    }

    /// Coherence of (2), by frequency; segment by segment the same times.
    pub(crate) fn coherence(&self, x: &[SegmentSpectrum], y: &[SegmentSpectrum]) -> Vec<f64> {
        let powers = self.density(x).into_iter().zip(self.density(y));
        self.cross_density(x, y).into_iter().zip(powers).map(|(cross, powers)| coherence(cross, powers)).collect()
    }

    fn mean(
        &self,
        x: &[SegmentSpectrum],
        y: &[SegmentSpectrum],
        of: impl Fn((f64, f64), (f64, f64)) -> (f64, f64),
    ) -> Vec<(f64, f64)> {
        let mut sums = vec![(0.0, 0.0); self.hz.len()];
        let mut count = 0.0;
        for (x, y) in x.iter().zip(y) {
            count += 1.0;
            for (sum, (x, y)) in sums.iter_mut().zip(x.iter().zip(y)) {
                let (re, im) = of(*x, *y);
                *sum = (sum.0 + re, sum.1 + im);
            }
        }
        sums.into_iter().map(|(re, im)| (re / f64::max(count, 1.0), im / f64::max(count, 1.0))).collect()
    }
}

/// gamma^2 of (2) from a cross density and both densities; zero where one of them is.
pub(crate) fn coherence((re, im): (f64, f64), (x, y): (f64, f64)) -> f64 {
    let both = x * y;
    if both > 0.0 { ((re * re + im * im) / both).min(1.0) } else { 0.0 }
}

/// (4): coherence that chance passes with probability `chance`, of so many half-overlapping segments.
pub(crate) fn coherence_by_chance(segments: usize, chance: f64) -> f64 {
    let independent = Overlap::Half.independent(segments);
    if independent > 1.0 { 1.0 - libm::pow(chance, 1.0 / (independent - 1.0)) } else { 1.0 }
}

#[cfg(test)]
mod tests {
    use super::super::random::NormalNoise;
    use super::*;

    const STEP_S: f64 = 1.0 / 32.0;

    fn cut() -> WelchConfig {
        WelchConfig::lines(8.0, 64)
    }

    fn white(seed: u64, count: usize) -> Vec<f64> {
        let mut noise = NormalNoise::new(seed, 0);
        (0..count).map(|_| noise.draw()).collect()
    }

    #[test]
    fn a_sine_is_one_line_with_half_its_square() {
        // 3 sin at 1.5 Hz, twelve periods a segment: under Hann's window the line and half of it on either side, and the power
        // within them, each 1/T wide, over the window's own width of 1.5/T is 9/2.
        let sine: Vec<f64> = (0..2048).map(|j| 5.0 + 3.0 * libm::sin(TAU * 1.5 * STEP_S * f64::from(j))).collect();
        let density = cut().density(&cut().segments(&sine, STEP_S));
        let strongest = (0..64).max_by(|a, b| density[*a].total_cmp(&density[*b])).unwrap();
        assert_eq!(strongest, 11);
        assert!((cut().hz[strongest] - 1.5).abs() < 1e-12);
        let power = density.iter().sum::<f64>() / 8.0;
        assert!((power - 4.5).abs() < 0.01, "{power}");
        assert!((density[11] / density[10] - 4.0).abs() < 0.01 && density[20] < 1e-6 * density[11]);
    }

    #[test]
    fn white_noise_has_the_level_of_its_variance() {
        // Variance 1 spread over 0 to 16 Hz.
        let density = cut().density(&cut().segments(&white(7, 64_000), STEP_S));
        let mean = density.iter().sum::<f64>() / density.len() as f64;
        assert!((mean * 16.0 - 1.0).abs() < 0.02, "{mean}");
        // 499 segments: each line within about five of its standard errors.
        assert!(density.iter().all(|line| (line * 16.0 - 1.0).abs() < 0.25));
    }

    #[test]
    fn coherence_is_that_of_a_known_filter() {
        // y_j = x_j + x_(j-1), and noise of variance s^2 on it: gamma^2 = g/(g + s^2) with g = 2 + 2 cos(omega dt).
        let (x, noise) = (white(1, 64_000), white(2, 64_000));
        let s = 1.5;
        let y: Vec<f64> = (0..x.len()).map(|j| x[j] + if j > 0 { x[j - 1] } else { 0.0 } + s * noise[j]).collect();
        let (xs, ys) = (cut().segments(&x, STEP_S), cut().segments(&y, STEP_S));
        let coherence = cut().coherence(&xs, &ys);
        for (line, found) in coherence.iter().enumerate() {
            let g = 2.0 + 2.0 * libm::cos(TAU * cut().hz[line] * STEP_S);
            assert!((found - g / (g + s * s)).abs() < 0.12, "{line}: {found}");
        }
        // Coherence with itself is one, with a constant zero.
        assert!(cut().coherence(&xs, &xs).iter().all(|found| (found - 1.0).abs() < 1e-12));
        let nothing = cut().segments(&vec![3.0; x.len()], STEP_S);
        assert!(cut().coherence(&xs, &nothing).iter().all(|found| *found < 1e-300));
    }

    #[test]
    fn chance_passes_its_level_as_often_as_it_says() {
        let (mut passed, mut tested) = (0, 0);
        for seed in 0..60 {
            let (x, y) = (white(100 + 2 * seed, 2560), white(101 + 2 * seed, 2560));
            let (x, y) = (cut().segments(&x, STEP_S), cut().segments(&y, STEP_S));
            assert_eq!(x.len(), 19);
            let level = coherence_by_chance(x.len(), 0.05);
            // Every other line: neighbours share their noise under the window.
            let coherence = cut().coherence(&x, &y);
            passed += coherence.iter().step_by(2).filter(|found| **found > level).count();
            tested += coherence.len() / 2;
        }
        let part = passed as f64 / tested as f64;
        assert!((0.035..0.065).contains(&part), "{part}");
        assert!((coherence_by_chance(2, 0.05) - 1.0).abs() < 0.15 && coherence_by_chance(1, 0.05) >= 1.0);
        // Too short for one segment.
        assert!(cut().segments(&[1.0; 100], STEP_S).is_empty());
    }
}
