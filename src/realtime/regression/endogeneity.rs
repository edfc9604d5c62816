//! Bias of least squares where the disturbance of an equation moves the aircraft, and the estimate that accounts for it.
//!
//! Consumes a least-squares fit, its estimate by instrumental variables where there is one, and the noise of the signals;
//! produces the fit with estimates and covariances that hold whether the air moves or not. With the residual's variance s^2,
//! that part of it which the instruments' noise explains n^2 = sum_j e_j^2 n_j^2 (e the residual's coefficients over z), and W
//! the weight of the record,
//!     b = (X'X)^-1 X'v,   v the disturbance, of variance s_v^2 = max(0, s^2 - C^2 n^2)                (1)
//!     b ~ N(0, B),   B = c s_v^2 W (X'X)^-1                                                          (2)
//!     d = theta_LS - theta_IV = b + error of covariance Sigma_IV                                     (3)
//!     theta = theta_LS - K d,   K = B (B + Sigma_IV)^-1,   Sigma = Sigma_LS + (I - K) B              (4)
//! (2) is the prior of a disturbance that may be correlated with the regressors in any direction, to any degree: X'v/W is of
//! the order of Sigma_x^(1/2) s_v. In still air s_v is zero and (4) is least squares; in gusts it is instrumental variables;
//! without a control that moves, least squares with an error as large as the bias can be.
//! Source: (4) is the posterior mean of a Gaussian bias given (3) (e.g. A. Gelman et al., Bayesian Data Analysis, 3rd ed., 2013,
//! section 2.5); its covariance counts Sigma_LS and Sigma_IV as independent, which is on the safe side. The choice of (2) is
//! ours.

use super::candidate::{REGRESSORS, SIGNALS};
use super::instrumental::InstrumentalEstimate;
use super::stepwise::Fit;
use nalgebra::SMatrix;

/// c of (2): half of the largest variance that any correlation can bring, in every direction at once. With 1/8 of it the numbers
/// in gusts of 1 m/s are 1.1 standard errors off (rms), with 1/2 0.7.
const PRIOR: f64 = 0.5;
/// K of (5).
const TERMS: usize = 10;
/// C of (1): by how much the noise may exceed what is known of it.
const MARGIN: f64 = 1.2;

type RegressorSquare = SMatrix<f64, REGRESSORS, REGRESSORS>;

/// Equivalent width of the default smoothing kernel, 1/(integral of its square), s: samples closer than this are not independent.
const INDEPENDENT_S: f64 = 0.49;

/// Independent samples of a slow disturbance among so many at that interval.
pub fn independent_samples(samples: f64, interval_s: f64) -> f64 {
    samples * (interval_s / INDEPENDENT_S).min(1.0)
}

/// s_v^2 of (1), given the residual, its variance with the factor n/(n - p), those of the noise on each signal, and the
/// interval of the n samples. The disturbance is slow: p parameters absorb p of the m independent samples of it, not p of n.
pub fn disturbance_variance(fit: &Fit, residual_var: f64, noise: &[f64; SIGNALS], samples: f64, interval_s: f64) -> f64 {
    let parameters = fit.order.len() as f64;
    let independent = independent_samples(samples, interval_s);
    let left = (independent - parameters).max(1.0);
    let unbiased = residual_var * (samples - parameters) / samples * independent / left;
    let explained: f64 = fit.residual.iter().zip(noise).map(|(e, var)| e * e * var).sum();
    (unbiased - MARGIN * MARGIN * explained).max(0.0)
}

/// Adds the square of the attenuation by noise on the regressors to the covariance: with the variances N of that noise,
///     E(theta_LS) = (I - A) theta,   A = W (X'X)^-1 N,   E(theta_LS) - theta = -sum_k A^k theta,  k = 1 .. K      (5)
/// of theta_LS. It matters where a regressor differs from a combination of the others by its noise alone: a control that answers
/// the motion, the rate of a fast roll mode. Summed to K terms, the largest change is K times the estimate.
pub fn account_for_attenuation(fit: &mut Fit, noise: &[f64; SIGNALS], weight: f64) {
    let mut attenuation = [0.0; REGRESSORS];
    let mut power = fit.theta;
    for _ in 0..TERMS {
        let mut next = [0.0; REGRESSORS];
        for &i in &fit.order {
            next[i] = weight * fit.order.iter().map(|&j| fit.dispersion[i][j] * noise[j] * power[j]).sum::<f64>();
            attenuation[i] -= next[i];
        }
        power = next;
    }
    for &i in &fit.order {
        for &j in &fit.order {
            fit.cov[i][j] += attenuation[i] * attenuation[j];
        }
    }
}

/// (4) in place of least squares, given theta_IV where there is one and s_v^2 > 0.
#[inline(never)]
pub fn account_for(fit: &mut Fit, weight: f64, by_instruments: Option<&InstrumentalEstimate>, disturbance_var: f64) {
    let order = fit.order.clone();
    let factor = PRIOR * disturbance_var * weight;
    // Scaled by the prior's standard deviations.
    let size: [f64; REGRESSORS] =
        core::array::from_fn(|i| order.get(i).map_or(1.0, |&place| libm::sqrt(factor * fit.dispersion[place][place])));
    let scaled = |matrix: &[[f64; REGRESSORS]; REGRESSORS], factor: f64, i: usize, j: usize| match (order.get(i), order.get(j)) {
        (Some(&a), Some(&b)) => factor * matrix[a][b] / (size[i] * size[j]),
        _ => 0.0,
    };
    for (&place, size) in order.iter().zip(&size) {
        fit.bias_var[place] = size * size;
    }
    let prior = RegressorSquare::from_fn(|i, j| scaled(&fit.dispersion, factor, i, j));
    let mut left = prior;
    if let Some(estimate) = by_instruments {
        let its_cov = RegressorSquare::from_fn(|i, j| {
            let unused = i == j && i >= order.len();
            scaled(&estimate.cov, 1.0, i, j) + f64::from(u8::from(unused))
        });
        // K' = (B + Sigma_IV)^-1 B. Of nearly collinear regressors rounding can leave a Sigma_IV that is no covariance, and
        // (4) would take variance away: such an estimate tells nothing.
        let sum = its_cov.cholesky().and_then(|_| (prior + its_cov).cholesky());
        let combined = sum.map(|sum| {
            let gain = sum.solve(&prior).transpose();
            (gain, prior - gain * prior)
        });
        if let Some((gain, rest)) = combined.filter(|(_, rest)| (0..order.len()).all(|i| rest[(i, i)] >= 0.0)) {
            left = rest;
            let difference = SMatrix::<f64, REGRESSORS, 1>::from_fn(|i, _| {
                order.get(i).map_or(0.0, |&place| (fit.theta[place] - estimate.theta[place]) / size[i])
            });
            let shift = gain * difference;
            for (i, &place) in order.iter().enumerate() {
                fit.theta[place] -= shift[i] * size[i];
            }
        }
    }
    for (i, &a) in order.iter().enumerate() {
        for (j, &b) in order.iter().enumerate() {
            fit.cov[a][b] += 0.5 * (left[(i, j)] + left[(j, i)]) * size[i] * size[j];
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::candidate::{BIAS, regressor, response};
    use super::super::information::Information;
    use super::super::stepwise::{Offer, Thresholds, fit};
    use super::*;
    use crate::flight::derivative::{Axis, Variable};

    fn fitted() -> (Information<SIGNALS>, Fit) {
        let mut information = Information::EMPTY;
        for k in 0..400 {
            let t = 0.08 * f64::from(k);
            let mut z = [0.0; SIGNALS];
            z[BIAS] = 1.0;
            z[regressor(Variable::V)] = libm::sin(1.3 * t);
            z[response(Axis::N)] = 0.04 * libm::sin(1.3 * t) + 0.01 * libm::cos(7.9 * t);
            information.add(&z, 1.0);
        }
        let mut offer = Offer::NONE;
        offer.primary[regressor(Variable::V)] = true;
        let thresholds = Thresholds { f_enter: 12.0, f_remove: 8.0 };
        let fit = fit(&information, response(Axis::N), &offer, &thresholds).unwrap();
        (information, fit)
    }

    #[test]
    fn noise_that_is_known_is_no_disturbance_and_more_is() {
        let (_, fit) = fitted();
        let mut noise = [0.0; SIGNALS];
        let residual_var = 0.5e-4;
        noise[response(Axis::N)] = residual_var;
        assert!(disturbance_variance(&fit, residual_var, &noise, 4000.0, 0.08) < f64::MIN_POSITIVE);
        let found = disturbance_variance(&fit, 10.0 * residual_var, &noise, 1e6, 0.5);
        assert!((found - (10.0 - MARGIN * MARGIN) * residual_var).abs() < 1e-3 * residual_var, "{found}");
        // Of few independent samples two parameters absorb much.
        let short = disturbance_variance(&fit, residual_var, &[0.0; SIGNALS], 25.0, 0.08);
        let independent = independent_samples(25.0, 0.08);
        assert!((short / residual_var - 23.0 / 25.0 * independent / (independent - 2.0)).abs() < 1e-12, "{short}");
    }

    #[test]
    fn without_instruments_the_estimate_stands_and_its_error_is_as_large_as_the_bias_can_be() {
        let (information, before) = fitted();
        let mut after = before.clone();
        let disturbance_var = 0.25e-4;
        account_for(&mut after, information.weight(), None, disturbance_var);
        let v = regressor(Variable::V);
        assert!((after.theta[v] - before.theta[v]).abs() < 1e-15);
        // One regressor of variance 1/2: the bias is at most the disturbance's deviation over the regressor's, the prior c of it.
        let bias_var = after.cov[v][v] - before.cov[v][v];
        assert!((bias_var - PRIOR * disturbance_var / 0.5).abs() < 0.02 * bias_var, "{bias_var}");
        assert!((after.bias_var[v] - bias_var).abs() < 1e-12);
    }
}
