//! Gusts with Dryden's spectra, piecewise linear in time.
//!
//! Consumes sigma (m/s), scale length L (m), airspeed V (m/s) and a seed; produces the gust along each body axis, white
//! noise through shaping filters with tau = L / V, the same sigma and L for all three:
//!     along x:      H(s) = sigma sqrt(2 tau) / (1 + tau s)                               (1)
//!     along y, z:   H(s) = sigma sqrt(tau) (1 + sqrt(3) tau s) / (1 + tau s)^2           (2)
//! Discretised exactly: x(k+1) = F x(k) + noise of covariance P - F P F', P the stationary covariance. With states
//! tau x1' = -x1 + n, tau x2' = x1 - x2 and output (2) = sqrt(3) x1 + (1 - sqrt(3)) x2, in units of n's strength,
//! P = 1/(2 tau) [[1, 1/2], [1/2, 1/2]].
//! It starts in still air and grows over a few tau, so that the run begins in trim. The field is uniform over the aircraft:
//! rotational gusts (p, q, r) are left out, for derivatives by a rate do not separate the air's share from that of the body.
//! Source: MIL-F-8785C, section 3.7.1.2, Dryden form; MIL-HDBK-1797, appendix A, has the same with Lu = 2 Lv = 2 Lw = L.

use crate::flight::signal::piecewise_linear::History;
use crate::num::random::NormalNoise;

/// Scale length at medium height, m: 1750 ft, MIL-F-8785C section 3.7.2.
pub const MEDIUM_HEIGHT_LENGTH_M: f64 = 533.4;

/// Time between breakpoints of a gust, s.
const GUST_STEP_S: f64 = 0.01;

/// First of the three streams of noise that gusts take; channels have those below it.
const FIRST_STREAM: u64 = 1000;

/// Gusts along x, y, z from `start_s` to `end_s`, m/s: velocity of the air, body axes.
pub(crate) fn gusts(sigma: f64, length: f64, airspeed: f64, (start_s, end_s): (f64, f64), seed: u64) -> [History; 3] {
    let steps = libm::ceil((end_s - start_s) / GUST_STEP_S).max(0.0) as usize + 1;
    let times = |step: usize| start_s + step as f64 * GUST_STEP_S;
    // At rest the field does not blow past: a slow walk is the least that keeps tau finite.
    let tau = length / airspeed.max(1.0);
    [0u64, 1, 2].map(|axis| {
        let mut noise = NormalNoise::new(seed, FIRST_STREAM + axis);
        let values = if axis == 0 { along(sigma, tau, steps, &mut noise) } else { across(sigma, tau, steps, &mut noise) };
        let points = values.into_iter().enumerate().map(|(step, value)| (times(step), value)).collect();
        History::through(points).unwrap_or_else(|_| History::constant(0.0))
    })
}

/// Equation (1).
fn along(sigma: f64, tau: f64, steps: usize, noise: &mut NormalNoise) -> Vec<f64> {
    let kept = libm::exp(-GUST_STEP_S / tau);
    let fresh = sigma * libm::sqrt(1.0 - kept * kept);
    let mut gust = 0.0;
    let mut values = vec![0.0];
    for _ in 0..steps {
        gust = kept * gust + fresh * noise.draw();
        values.push(gust);
    }
    values
}

/// Equation (2).
fn across(sigma: f64, tau: f64, steps: usize, noise: &mut NormalNoise) -> Vec<f64> {
    let root3 = libm::sqrt(3.0);
    let ratio = GUST_STEP_S / tau;
    let kept = libm::exp(-ratio);
    // F = kept [[1, 0], [ratio, 1]]; P in units where the output's variance is sigma^2: P = sigma^2 [[1/2, 1/4], [1/4, 1/4]].
    let (p11, p12, p22) = (0.5, 0.25, 0.25);
    let kept2 = kept * kept;
    let q11 = p11 - kept2 * p11;
    let q12 = p12 - kept2 * (ratio * p11 + p12);
    let q22 = p22 - kept2 * (ratio * ratio * p11 + 2.0 * ratio * p12 + p22);
    // Cholesky factor of the covariance; its last pivot is of the order of ratio^3 and may round below zero.
    let c11 = libm::sqrt(q11.max(0.0));
    let c21 = if c11 > 0.0 { q12 / c11 } else { 0.0 };
    let c22 = libm::sqrt((q22 - c21 * c21).max(0.0));
    let (mut x1, mut x2) = (0.0, 0.0);
    let mut values = vec![0.0];
    for _ in 0..steps {
        let (n1, n2) = (noise.draw(), noise.draw());
        (x1, x2) = (kept * x1 + c11 * n1, kept * (ratio * x1 + x2) + c21 * n1 + c22 * n2);
        values.push(sigma * (root3 * x1 + (1.0 - root3) * x2));
    }
    values
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn gusts_have_their_sigma_and_their_correlation() {
        // Autocorrelation of (1): exp(-t/tau); of (2): exp(-t/tau) (1 - t / (2 tau)).
        let (sigma, length, airspeed) = (1.5, 25.0, 50.0);
        let gusts = gusts(sigma, length, airspeed, (0.0, 20_000.0), 11);
        let tau = length / airspeed;
        let lag = (tau / GUST_STEP_S) as usize;
        for (axis, wanted) in [(0, (-1.0f64).exp()), (1, 0.5 * (-1.0f64).exp()), (2, 0.5 * (-1.0f64).exp())] {
            let values: Vec<f64> = gusts[axis].points().iter().skip(1000).map(|&(_, value)| value).collect();
            let count = values.len() as f64;
            let variance = values.iter().map(|x| x * x).sum::<f64>() / count;
            let together = values.iter().zip(values.iter().skip(lag)).map(|(a, b)| a * b).sum::<f64>() / count / variance;
            assert!((variance.sqrt() / sigma - 1.0).abs() < 0.02, "axis {axis}: {}", variance.sqrt());
            assert!((together - wanted).abs() < 0.02, "axis {axis}: {together} is not {wanted}");
        }
    }
}
