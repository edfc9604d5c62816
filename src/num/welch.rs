//! Spectra and coherence of evenly sampled signals: averaged periodograms over overlapping windows.
//!
//! Consumes a signal x_j at steps dt; produces for every segment of length T, overlapping the next by half, its mean subtracted,
//! under Hann's window w, at the lines f_k = k/T
//!     X_k = sum_j w_j x_j exp(-2 pi i f_k j dt)                                                           (1)
//! then, over all segments of all runs, the one-sided density and the coherence of two signals,
//!     S_k = 2 dt/sum w^2 mean |X_k|^2     gamma^2_k = |mean X_k* Y_k|^2/(mean |X_k|^2 mean |Y_k|^2)        (2)
//! Independent signals exceed gamma^2 = 1 - p^(1/(n - 1)) with probability p, n the equivalent number of independent segments:
//! of m that overlap by half under Hann's window, m/(1 + 2 (m - 1)/m rho^2), rho = 1/6.  (3)
//! Source: P. D. Welch, IEEE Trans. AU-15 (1967); G. C. Carter, C. H. Knapp, A. H. Nuttall, IEEE Trans. AU-21 (1973), for (3).
//! Numerics: the coherence of a constant signal is zero.

use core::f64::consts::TAU;

/// Correlation of half-overlapping segments under Hann's window.
const OVERLAPPED: f64 = 1.0 / 6.0;

/// How signals are cut and which lines are looked at.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WelchConfig {
    /// Length of a segment, s.
    pub segment_s: f64,
    /// How many lines, from 1/T up.
    pub lines: usize,
}

/// One segment's lines (1), each times sqrt(2 dt/sum w^2): real and imaginary part.
pub type SegmentSpectrum = Vec<(f64, f64)>;

impl WelchConfig {
    /// Frequency of a line, Hz.
    pub fn hz(&self, line: usize) -> f64 {
        (line + 1) as f64 / self.segment_s
    }

    /// The segments of one signal; none where it is shorter than one.
    pub fn segments(&self, values: &[f64], step_s: f64) -> Vec<SegmentSpectrum> {
        let length = libm::round(self.segment_s / step_s) as usize;
        if length < 8 || values.len() < length {
            return Vec::new();
        }
        let window: Vec<f64> = (0..length).map(|j| 0.5 - 0.5 * libm::cos(TAU * (j as f64 + 0.5) / length as f64)).collect();
        let scale = libm::sqrt(2.0 * step_s / window.iter().map(|w| w * w).sum::<f64>());
        let turns: Vec<Vec<(f64, f64)>> = (0..self.lines)
            .map(|line| {
                let omega = TAU * self.hz(line) * step_s;
                window
                    .iter()
                    .enumerate()
                    .map(|(j, _)| libm::sincos(omega * j as f64))
                    .zip(&window)
                    .map(|((s, c), w)| (s * w, c * w))
                    .collect()
            })
            .collect();
        let hop = length / 2;
        let count = (values.len() - length) / hop + 1;
        (0..count)
            .filter_map(|place| values.get(place * hop..place * hop + length))
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

    /// S of (2), by line.
    pub fn density(&self, segments: &[SegmentSpectrum]) -> Vec<f64> {
        self.mean(segments, segments, |(a, b), _| (a * a + b * b, 0.0)).into_iter().map(|(density, _)| density).collect()
    }

    /// Coherence of (2), by line; segment by segment the same times.
    pub fn coherence(&self, x: &[SegmentSpectrum], y: &[SegmentSpectrum]) -> Vec<f64> {
        let cross = self.mean(x, y, |(a, b), (c, d)| (a * c + b * d, a * d - b * c));
        let powers = self.density(x).into_iter().zip(self.density(y));
        let of = |((re, im), (x, y)): ((f64, f64), (f64, f64))| {
            let both = x * y;
            if both > 0.0 { ((re * re + im * im) / both).min(1.0) } else { 0.0 }
        };
        cross.into_iter().zip(powers).map(of).collect()
    }

    fn mean(
        &self,
        x: &[SegmentSpectrum],
        y: &[SegmentSpectrum],
        of: impl Fn((f64, f64), (f64, f64)) -> (f64, f64),
    ) -> Vec<(f64, f64)> {
        let mut sums = vec![(0.0, 0.0); self.lines];
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

/// (3): coherence that chance passes with probability `chance`, of so many overlapping segments.
pub fn coherence_by_chance(segments: usize, chance: f64) -> f64 {
    let m = segments as f64;
    let independent = m / (1.0 + 2.0 * (m - 1.0).max(0.0) / m.max(1.0) * OVERLAPPED * OVERLAPPED);
    if independent > 1.0 { 1.0 - libm::pow(chance, 1.0 / (independent - 1.0)) } else { 1.0 }
}

#[cfg(test)]
mod tests {
    use super::super::random::NormalNoise;
    use super::*;

    const CUT: WelchConfig = WelchConfig { segment_s: 8.0, lines: 64 };
    const STEP_S: f64 = 1.0 / 32.0;

    fn white(seed: u64, count: usize) -> Vec<f64> {
        let mut noise = NormalNoise::new(seed, 0);
        (0..count).map(|_| noise.draw()).collect()
    }

    #[test]
    fn a_sine_is_one_line_with_half_its_square() {
        // 3 sin at 1.5 Hz, twelve periods a segment: under Hann's window the line and half of it on either side, and the power
        // within them, each 1/T wide, over the window's own width of 1.5/T is 9/2.
        let sine: Vec<f64> = (0..2048).map(|j| 5.0 + 3.0 * libm::sin(TAU * 1.5 * STEP_S * f64::from(j))).collect();
        let density = CUT.density(&CUT.segments(&sine, STEP_S));
        let strongest = (0..64).max_by(|a, b| density[*a].total_cmp(&density[*b])).unwrap();
        assert_eq!(strongest, 11);
        assert!((CUT.hz(strongest) - 1.5).abs() < 1e-12);
        let power = density.iter().sum::<f64>() / 8.0;
        assert!((power - 4.5).abs() < 0.01, "{power}");
        assert!((density[11] / density[10] - 4.0).abs() < 0.01 && density[20] < 1e-6 * density[11]);
    }

    #[test]
    fn white_noise_has_the_level_of_its_variance() {
        // Variance 1 spread over 0 to 16 Hz.
        let density = CUT.density(&CUT.segments(&white(7, 64_000), STEP_S));
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
        let (xs, ys) = (CUT.segments(&x, STEP_S), CUT.segments(&y, STEP_S));
        let coherence = CUT.coherence(&xs, &ys);
        for (line, found) in coherence.iter().enumerate() {
            let g = 2.0 + 2.0 * libm::cos(TAU * CUT.hz(line) * STEP_S);
            assert!((found - g / (g + s * s)).abs() < 0.12, "{line}: {found}");
        }
        // A signal goes wholly with itself, and with what is not there not at all.
        assert!(CUT.coherence(&xs, &xs).iter().all(|found| (found - 1.0).abs() < 1e-12));
        let nothing = CUT.segments(&vec![3.0; x.len()], STEP_S);
        assert!(CUT.coherence(&xs, &nothing).iter().all(|found| *found < 1e-300));
    }

    #[test]
    fn chance_passes_its_level_as_often_as_it_says() {
        let (mut passed, mut looked) = (0, 0);
        for seed in 0..60 {
            let (x, y) = (white(100 + 2 * seed, 2560), white(101 + 2 * seed, 2560));
            let (x, y) = (CUT.segments(&x, STEP_S), CUT.segments(&y, STEP_S));
            assert_eq!(x.len(), 19);
            let level = coherence_by_chance(x.len(), 0.05);
            // Every other line: neighbours share their noise under the window.
            let coherence = CUT.coherence(&x, &y);
            passed += coherence.iter().step_by(2).filter(|found| **found > level).count();
            looked += coherence.len() / 2;
        }
        let part = passed as f64 / looked as f64;
        assert!((0.035..0.065).contains(&part), "{part}");
        assert!((coherence_by_chance(2, 0.05) - 1.0).abs() < 0.15 && coherence_by_chance(1, 0.05) >= 1.0);
        // Too short for one segment.
        assert!(CUT.segments(&[1.0; 100], STEP_S).is_empty());
    }
}
