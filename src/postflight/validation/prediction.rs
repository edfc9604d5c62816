//! Measures of prediction of one output: rms error, VAF, Theil's coefficient, whiteness and spectral lines of the residual.
//!
//! Consumes a measured series z and a predicted series y at the same times; produces, with e = z - y, the measures of
//! `metrics`, the whiteness of e by Ljung and Box, Q = N (N + 2) sum_k rho_k^2/(N - k) against chi-square, and
//! spectral lines: I_k, relative to the mean estimated from the median of its neighbours, is in noise one exponential over the
//! mean of K of them, so for m frequencies
//!     Pr(any above x) < m (1 + x/K)^-K                                                                 (1)
//! A line at twice the frequency of the response is a second-order response, a sign of nonlinearity (Padfield et al. 1987).
//! Source: G. M. Ljung and G. E. P. Box, Biometrika 65, 1978; (1) as in R. A. Fisher's test, Proc. R. Soc. A 125, 1929, with a
//! spectrum that need not be white.
//! Numerics: a Hann taper limits the leakage of trends; a line is then four frequencies wide.
//! Returns `None` for fewer than 32 samples, and no lines for fewer than 100.

use super::metrics::PredictionMoments;
use core::f64::consts::TAU;

/// Lags of the test for whiteness.
const LAGS: usize = 20;

/// Half width of the running median and of its gap about the frequency itself, in frequencies of the periodogram.
const NEIGHBOURS: usize = 16;
const OWN: usize = 2;

/// Equivalent number K of independent exponentials in the median of the tapered neighbours.
const EQUIVALENT: f64 = 14.0;

/// Probability (1) below which a line is reported.
const LINE_PROBABILITY: f64 = 1e-3;

/// Least number of cycles in a record of a response with a dominant frequency.
const CYCLES: f64 = 3.5;

/// Relative tolerance about twice the response's frequency.
const TWICE: f64 = 0.15;

/// A line in a residual's spectrum.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ResidualLine {
    /// Frequency, rad/s.
    pub omega: f64,
    /// Amplitude, the residual's unit.
    pub amplitude: f64,
    /// Whether its frequency is twice that of the response.
    pub at_twice_the_response: bool,
}

/// Figures of merit of the prediction of one output.
#[derive(Clone, Debug, PartialEq)]
pub struct PredictionScore {
    /// Root mean square of z - y, the output's unit.
    pub rms: f64,
    /// VAF, at most one; negative where the mean would be a better prediction.
    pub vaf: f64,
    /// Theil's coefficient.
    pub theil: f64,
    /// Probability of as large a Q in white noise.
    pub white_probability: f64,
    /// Correlation rho_1 of neighbouring residuals.
    pub neighbours: f64,
    /// Spectral lines of the residual, the strongest first.
    pub lines: Vec<ResidualLine>,
    /// Number of samples.
    pub samples: usize,
}

/// The score of a prediction; `None` with fewer than 32 samples, or none that is finite.
pub fn score(times_s: &[f64], measured: &[f64], predicted: &[f64]) -> Option<PredictionScore> {
    let rows: Vec<(f64, f64, f64)> = times_s
        .iter()
        .zip(measured.iter().zip(predicted))
        .filter(|(_, (z, y))| z.is_finite() && y.is_finite())
        .map(|(&t, (&z, &y))| (t, z, y))
        .collect();
    if rows.len() < 32 {
        return None;
    }
    let n = rows.len() as f64;
    let moments = PredictionMoments::of(rows.iter().map(|&(_, z, y)| (z, y)));
    let mean_e = rows.iter().map(|(_, z, y)| z - y).sum::<f64>() / n;
    let residual: Vec<f64> = rows.iter().map(|row| row.1 - row.2 - mean_e).collect();
    let var_e = moments.error_variance;
    let correlation = |lag: usize| {
        let products = residual.iter().zip(residual.iter().skip(lag)).map(|(a, b)| a * b);
        if var_e > 0.0 { products.sum::<f64>() / (n * var_e) } else { 0.0 }
    };
    let q: f64 = (1..=LAGS).map(|lag| correlation(lag) * correlation(lag) / (n - lag as f64)).sum::<f64>() * n * (n + 2.0);
    let times: Vec<f64> = rows.iter().map(|row| row.0).collect();
    let response: Vec<f64> = rows.iter().map(|row| row.2).collect();
    Some(PredictionScore {
        rms: moments.rms(),
        vaf: moments.vaf(),
        theil: moments.theil(),
        white_probability: chi_square_tail(q, LAGS),
        neighbours: correlation(1),
        lines: lines(&times, &residual, &response),
        samples: rows.len(),
    })
}

/// Pr(chi^2 > q) for an even number of degrees of freedom: a finite sum.
fn chi_square_tail(q: f64, degrees: usize) -> f64 {
    let half = 0.5 * q;
    let (mut term, mut sum) = (1.0, 1.0);
    for k in 1..degrees / 2 {
        term *= half / k as f64;
        sum += term;
    }
    (libm::exp(-half) * sum).clamp(0.0, 1.0)
}

/// Fourier sums at multiples of the record's own frequency.
fn spectrum(times_s: &[f64], values: &[f64]) -> Vec<(f64, f64)> {
    let (Some(first), Some(last)) = (times_s.first(), times_s.last()) else { return Vec::new() };
    let n = values.len();
    let span_s = (last - first) * n as f64 / (n - 1).max(1) as f64;
    let mean = values.iter().sum::<f64>() / n as f64;
    (1..n / 2)
        .map(|k| {
            let omega = TAU * k as f64 / span_s;
            let (mut re, mut im) = (0.0, 0.0);
            for (t, x) in times_s.iter().zip(values) {
                let (sin, cos) = libm::sincos(omega * (t - first));
                // Hann's taper; its mean is one half.
                let tapered = (x - mean) * (1.0 - libm::cos(TAU * (t - first) / span_s));
                re += tapered * cos;
                im -= tapered * sin;
            }
            (omega, 2.0 * libm::hypot(re, im) / n as f64)
        })
        .collect()
}

fn lines(times_s: &[f64], residual: &[f64], response: &[f64]) -> Vec<ResidualLine> {
    let found = spectrum(times_s, residual);
    let power: Vec<f64> = found.iter().map(|(_, amplitude)| amplitude * amplitude).collect();
    let m = power.len();
    if m < 3 * NEIGHBOURS {
        return Vec::new();
    }
    let over: Vec<f64> = (0..m)
        .map(|k| {
            let near = k.saturating_sub(NEIGHBOURS)..(k + NEIGHBOURS + 1).min(m);
            let beside = near.filter(|other| other.abs_diff(k) > OWN);
            let mut around: Vec<f64> = beside.filter_map(|other| power.get(other).copied()).collect();
            around.sort_by(f64::total_cmp);
            let median = around.get(around.len() / 2).copied().unwrap_or(0.0);
            // An exponential's median is ln 2 of its mean.
            if median > 0.0 { power.get(k).copied().unwrap_or(0.0) * core::f64::consts::LN_2 / median } else { 0.0 }
        })
        .collect();
    let resolution = found.first().map_or(0.0, |(omega, _)| *omega);
    // A response that goes round fewer times than that in the record has no frequency of its own to be doubled.
    let own = spectrum(times_s, response).into_iter().max_by(|a, b| a.1.total_cmp(&b.1));
    let own = own.map_or(f64::NAN, |(omega, _)| if omega > CYCLES * resolution { omega } else { f64::NAN });
    let mut lines: Vec<ResidualLine> = Vec::new();
    for ((&(omega, amplitude), ratio), k) in found.iter().zip(&over).zip(0..) {
        let peak = power.get(k) >= power.get(k.wrapping_sub(1)) && power.get(k) >= power.get(k + 1);
        let chance = m as f64 * libm::pow(1.0 + ratio / EQUIVALENT, -EQUIVALENT);
        if peak && chance < LINE_PROBABILITY {
            let off = libm::fabs(omega - 2.0 * own);
            let at_twice_the_response = off <= (TWICE * own).max(1.5 * resolution);
            lines.push(ResidualLine { omega, amplitude, at_twice_the_response });
        }
    }
    lines.sort_by(|a, b| b.amplitude.total_cmp(&a.amplitude));
    lines
}

#[cfg(test)]
mod tests {
    use super::*;

    struct Draws(u64);

    impl Draws {
        fn uniform(&mut self) -> f64 {
            self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            ((self.0 >> 11) as f64 + 0.5) / (1_u64 << 53) as f64
        }

        fn normal(&mut self) -> f64 {
            (-2.0 * self.uniform().ln()).sqrt() * (TAU * self.uniform()).cos()
        }

        /// Coloured noise of variance one.
        fn coloured(&mut self, a: f64, n: usize) -> Vec<f64> {
            let mut now = self.normal();
            let shock = (1.0 - a * a).sqrt();
            (0..n)
                .map(|_| {
                    now = a * now + shock * self.normal();
                    now
                })
                .collect()
        }
    }

    fn times(n: usize) -> Vec<f64> {
        (0..n).map(|k| k as f64 / 25.0).collect()
    }

    #[test]
    fn a_score_is_that_computed_by_hand() {
        let times = times(64);
        let measured: Vec<f64> = (0..64).map(|k| if k % 2 == 0 { 1.0 } else { -1.0 }).collect();
        let predicted: Vec<f64> = measured.iter().map(|z| 0.5 * z).collect();
        let found = score(&times, &measured, &predicted).unwrap();
        assert!((found.rms - 0.5).abs() < 1e-12 && (found.vaf - 0.75).abs() < 1e-12 && (found.theil - 0.5 / 1.5).abs() < 1e-12);
        assert!(found.neighbours < -0.95 && found.white_probability < 1e-6 && found.samples == 64);
        assert!(score(&times[..31], &measured, &predicted).is_none());
        // Chi-square with 20 degrees of freedom exceeds 31.41 in 5 %.
        assert!((chi_square_tail(31.410_43, 20) - 0.05).abs() < 1e-6);
    }

    /// Of 100 records each: at most two with a line that is none, and four fifths of the lines found where they
    /// stand, of half the noise's size in white noise and nearly twice it in noise of that frequency.
    #[test]
    fn a_line_at_twice_the_response_is_found_and_none_is_told_of_noise() {
        let (mut draws, n) = (Draws(11), 750);
        let times = times(n);
        let response: Vec<f64> = times.iter().map(|t| (1.8 * t).sin()).collect();
        for a in [0.0, 0.9] {
            let (mut false_alarms, mut found, mut not_white) = (0, 0, 0);
            for _ in 0..100 {
                let noise = draws.coloured(a, n);
                let measured: Vec<f64> = response.iter().zip(&noise).map(|(y, e)| y + 0.05 * e).collect();
                let clean = score(&times, &measured, &response).unwrap();
                false_alarms += usize::from(!clean.lines.is_empty());
                not_white += usize::from(clean.white_probability < 0.01);
                let size = if a > 0.5 { 0.09 } else { 0.028 };
                let with: Vec<f64> = measured.iter().zip(&times).map(|(z, t)| z + size * (3.6 * t).sin()).collect();
                let told = score(&times, &with, &response).unwrap();
                found += usize::from(told.lines.iter().any(|line| line.at_twice_the_response && (line.omega - 3.6).abs() < 0.2));
            }
            eprintln!("colour {a}: {false_alarms} false lines, {found} found, {not_white} called not white, of 100");
            assert!(false_alarms <= 2 && found >= 80);
            assert!(if a > 0.5 { not_white == 100 } else { not_white <= 4 });
        }
    }
}
