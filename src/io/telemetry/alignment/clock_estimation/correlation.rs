//! Cross-correlation of two white records over all lags, with the significance of each.
//!
//! Consumes e_i of ours and f_i of theirs in bins of width D; produces for lag k, over the bins that both have,
//!     r_k = sum_i e_(i+k) f_i / sqrt(E F),   E = sum_i e_(i+k)^2,   F = sum_i f_i^2                      (1)
//!     n_k = E F/(c sum_i e_(i+k)^2 f_i^2),   nu_k = n_k - p - 2                                         (2)
//!     x_k = sqrt(-nu_k ln(1 - r_k^2)),   P(|r| > r_k) <= exp(-x_k^2/2)                                  (3)
//! with c what is left of their own correlation and p the coefficients of the filter ([`super::prewhitening`]). n counts the
//! bins that are independent evidence: one jolt in each record is one, whatever its length. For small r, x_k^2 is the square of
//! the sum over its variance under unrelated signs; for r near 1 a few bins are enough, as they must be for short manoeuvres
//! that stand far above the noise. Over K lags the largest x exceeds
//!     x = sqrt(2 ln(2 K/alpha))                                                                         (4)
//! in at most a part alpha of unrelated pairs.
//! Source: the generalised cross-correlation of C. H. Knapp and G. C. Carter, IEEE Trans. ASSP-24, 1976, with both signals
//! whitened; (3) is the tail of R. A. Fisher's distribution of r (Biometrika 10, 1915) with n normal values; (4) by the sum over
//! lags. n of (2) and the colour that is left make (3) an approximation, which `tests/telemetry/clock_coverage.rs` counts.

use super::prewhitening::WhitePair;
use crate::num::fft::{ComplexSeries, FourierTransform};

/// Independent bins (nu) at least.
const LEAST_INDEPENDENT: f64 = 6.0;

/// The correlation at one lag.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct LagPeak {
    /// Bins that theirs is late by: i of theirs falls on i + lag of ours.
    pub(super) lag: i64,
    /// x of (3).
    pub(super) significance: f64,
}

/// (3) at each admitted lag, in order.
pub(super) fn significances(white: &WhitePair, lags: impl Fn(i64) -> bool) -> Vec<LagPeak> {
    let (ours, theirs) = (&white.ours, &white.theirs);
    let transform = FourierTransform::at_least(ours.len() + theirs.len());
    let square = |x: &[f64]| x.iter().map(|x| x * x).collect::<Vec<f64>>();
    let filled = |x: &[f64]| x.iter().map(|x| f64::from(u8::from(*x != 0.0))).collect::<Vec<f64>>();
    let values = transform.of_two(ours, theirs);
    let squares = transform.of_two(&square(ours), &square(theirs));
    let bins = transform.of_two(&filled(ours), &filled(theirs));
    let product = correlated(&transform, &values.0, &values.1);
    let variance = correlated(&transform, &squares.0, &squares.1);
    let our_power = correlated(&transform, &squares.0, &bins.1);
    let their_power = correlated(&transform, &bins.0, &squares.1);
    let length = transform.length() as i64;
    let (last, first) = (ours.len() as i64 - 1, 1 - theirs.len() as i64);
    // What rounding makes of zero is far below.
    let least = 1e-9 * variance.iter().copied().fold(0.0, f64::max);
    (first..=last)
        .filter(|lag| lags(*lag))
        .filter_map(|lag| {
            let place = lag.rem_euclid(length) as usize;
            let (product, variance) = (*product.get(place)?, *variance.get(place)?);
            let powers = our_power.get(place)? * their_power.get(place)?;
            if !(variance > least && powers > 0.0) {
                return None;
            }
            let independent = powers / (white.inflation * variance) - white.order as f64 - 2.0;
            let unexplained = (1.0 - product * product / powers).clamp(1e-12, 1.0);
            (independent >= LEAST_INDEPENDENT)
                .then(|| LagPeak { lag, significance: libm::sqrt(-independent * libm::log(unexplained)) })
        })
        .collect()
}

/// sum_i a_(i+k) b_i at place k modulo the length, from the transforms of both.
fn correlated(transform: &FourierTransform, a: &ComplexSeries, b: &ComplexSeries) -> Vec<f64> {
    let mut out = ComplexSeries::zeros(a.re.len());
    for f in 0..a.re.len() {
        out.re[f] = a.re[f] * b.re[f] + a.im[f] * b.im[f];
        out.im[f] = a.im[f] * b.re[f] - a.re[f] * b.im[f];
    }
    transform.back(&out)
}

/// x of (4) for this rate of false alarms over so many lags.
pub(super) fn threshold(rate: f64, lags: usize) -> f64 {
    libm::sqrt(2.0 * libm::log(2.0 * lags.max(1) as f64 / rate))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::num::random::NormalNoise;

    #[test]
    fn it_is_the_sum_written_out() {
        let mut noise = NormalNoise::new(5, 1);
        let mut draw = |count: usize| (0..count).map(|_| noise.draw()).collect::<Vec<f64>>();
        let white = WhitePair { ours: draw(90), theirs: draw(70), inflation: 1.5, order: 3 };
        let found = significances(&white, |lag| lag % 7 == 0);
        assert!(found.len() > 5 && found.iter().any(|peak| peak.lag < 0));
        for LagPeak { lag, significance } in found {
            let pairs: Vec<(f64, f64)> = (0..70)
                .filter_map(|i| Some((*white.ours.get(usize::try_from(i + lag).ok()?)?, white.theirs[i as usize])))
                .collect();
            let sum = |of: fn(f64, f64) -> f64| pairs.iter().map(|&(e, f)| of(e, f)).sum::<f64>();
            let powers = sum(|e, _| e * e) * sum(|_, f| f * f);
            let independent = powers / (1.5 * sum(|e, f| e * e * f * f)) - 5.0;
            let square = -independent * libm::log(1.0 - sum(|e, f| e * f).powi(2) / powers);
            assert!((significance - libm::sqrt(square)).abs() < 1e-9, "{lag}");
        }
        assert!((threshold(1e-3, 5000) - libm::sqrt(2.0 * libm::log(1e7))).abs() < 1e-12);
    }
}
