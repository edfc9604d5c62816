//! Autocovariance of the equation error, corrected for the part of it that the fit absorbs.
//!
//! Consumes the lagged products of an equation's regressors and its residual; produces estimates r_l, l = 0 .. LAGS, of the
//! autocovariance of the equation error. A fitted residual v = M e, M = I - X D X'W, lacks the part of e in the
//! span of the regressors: for white errors p of n degrees of freedom, for coloured ones most of their slow part, and standard
//! errors from it are too small by a half. With W = diag(w), S_l the shift by l and B_m = S_m + S_m' (B_0 = I),
//!     E[sum_k w_k w_(k-l) v_k v_(k-l)] = sum_m T_lm r_m                                            (1)
//!     T_lm = delta_lm g_l - 2 w3 (t_|l-m| + 1(m > 0) t_(l+m)) + trace(G_l' D (G_m + 1(m > 0) G_m') D) (2)
//! with 1(m > 0) one there and else zero, g_l the sum of w_k w_(k-l), t_l = trace(D G_l), and w3 = sum w^3/sum w^2; (1) is
//! solved for r. Errors beyond the last lag, and t beyond it, count as zero.
//! | symbol | shape | meaning |
//! | --- | --- | --- |
//! | D | p x p | (X'WX)^-1 |
//! | G_l | p x p | lagged products of the regressors, information (2): X'W S_l W X |
//!
//! Derivation: E[v v'] = M Sigma M' with Sigma = sum_m r_m B_m, multiplied out; it is the covariance of a least-squares
//! residual (e.g. J. Durbin and G. S. Watson, Biometrika 37, 1950, eq. (5) for white errors) written in lagged products.
//! Numerics: T is close to g_l times the identity while the record is long beside LAGS and p; in 200 simulated records its
//! condition stayed below 5. Returns `None` where T is singular or r_0 is not positive: the record is too short for this.

use super::candidate::REGRESSORS;
use super::candidate::{BIAS, Coefficients, SIGNALS};
use super::information::{Information, LAGS, LagCovariance};
use nalgebra::{SMatrix, SVector};

/// Lags counted from zero.
const COUNT: usize = LAGS + 1;

type RegressorMatrix = [[f64; REGRESSORS]; REGRESSORS];
/// A row or column of a p x p matrix for every lag.
type VectorOverLags = [[f64; COUNT]; REGRESSORS];

/// Autocovariance r of the error of the equation with those terms; `residual` over z, `dispersion` by place.
pub fn error_covariance(
    information: &Information<SIGNALS>,
    order: &[usize],
    dispersion: &RegressorMatrix,
    residual: &Coefficients,
) -> Option<LagCovariance> {
    // quadratic[l][m] = trace(G_l' D (G_m + 1(m > 0) G_m') D), a row of D G_l' and the column of D (G_m + ..) that meets it at a
    // time: on a flight computer's stack there is no room for whole matrices over all lags.
    let mut quadratic = [[0.0; COUNT]; COUNT];
    let mut trace = [0.0; COUNT];
    for (i, &place_i) in order.iter().enumerate().take(REGRESSORS) {
        let (mut row, mut column): (VectorOverLags, VectorOverLags) = ([[0.0; COUNT]; REGRESSORS], [[0.0; COUNT]; REGRESSORS]);
        for &place_k in order {
            let mut both = information.over_lags(place_k, place_i);
            let behind = information.over_lags(place_i, place_k);
            both.iter_mut().zip(behind).skip(1).for_each(|(sum, behind)| *sum += behind);
            for ((&place_j, row), column) in order.iter().zip(&mut row).zip(&mut column) {
                information.add_over_lags(row, dispersion[place_i][place_k], place_j, place_k);
                let d = dispersion[place_j][place_k];
                column.iter_mut().zip(&both).for_each(|(entry, both)| *entry += d * both);
            }
        }
        for (of_row, of_column) in row.iter().zip(&column).take(order.len()) {
            for (entries, of_l) in quadratic.iter_mut().zip(of_row) {
                entries.iter_mut().zip(of_column).for_each(|(entry, of_m)| *entry += of_l * of_m);
            }
        }
        trace.iter_mut().zip(row[i]).for_each(|(trace, own)| *trace += own);
    }
    let pairs = information.over_lags(BIAS, BIAS);
    let w3 = information.weight3() / information.weight2();
    let t = SMatrix::<f64, COUNT, COUNT>::from_fn(|l, m| {
        let mut linear = trace[l.abs_diff(m)];
        if m > 0 && l + m < COUNT {
            linear += trace[l + m];
        }
        let own = if l == m { pairs[l] } else { 0.0 };
        own - 2.0 * w3 * linear + quadratic[l][m]
    });
    let sums = SVector::<f64, COUNT>::from(information.forms(residual, residual));
    let r = t.lu().solve(&sums)?;
    let finite = r.iter().all(|entry| entry.is_finite());
    (finite && r[0] > 0.0).then(|| core::array::from_fn(|lag| r[lag]))
}

#[cfg(test)]
mod tests {
    use super::super::candidate::response;
    use super::super::stepwise::{Offer, Thresholds, fit};
    use super::*;
    use crate::flight::derivative::Axis;

    /// Oscillating regressors and an autoregressive error of known autocovariance: the residual's is too small, this one's
    /// is not.
    #[test]
    fn the_mean_over_many_records_is_the_autocovariance_of_the_error() {
        let mut seed = 11_u64;
        let mut uniform = || {
            seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            ((seed >> 11) as f64 + 0.5) / (1_u64 << 53) as f64
        };
        let mut normal = || libm::sqrt(-2.0 * libm::log(uniform())) * libm::cos(2.0 * core::f64::consts::PI * uniform());
        let (records, samples, memory) = (400, 250, 0.6);
        let y = response(Axis::L);
        let mut offer = Offer::NONE;
        offer.primary[1..9].fill(true);
        let mut mean = [0.0; 5];
        let mut mean_residual = [0.0; 5];
        for _ in 0..records {
            let mut information = Information::<SIGNALS>::default();
            let mut error = normal();
            let phase = 6.0 * normal();
            for k in 0..samples {
                let t = 0.08 * f64::from(k) + phase;
                let mut z = [0.0; SIGNALS];
                z[BIAS] = 1.0;
                for (j, entry) in z.iter_mut().enumerate().take(9).skip(1) {
                    *entry = libm::sin(0.45 * j as f64 * t + j as f64);
                }
                error = memory * error + libm::sqrt(1.0 - memory * memory) * normal();
                z[y] = 0.7 * z[1] - 0.2 * z[5] + error;
                information.add(&z, 1.0);
            }
            let thresholds = Thresholds { f_enter: 12.0, f_remove: 8.0 };
            let fit = fit(&information, y, &offer, &thresholds).unwrap();
            assert_eq!(fit.order.len(), 9);
            let r = error_covariance(&information, &fit.order, &fit.dispersion, &fit.residual).unwrap();
            let fitted = super::super::coloured_errors::residual_covariance(&information, &fit.residual, &fit.residual, 9);
            for lag in 0..5 {
                mean[lag] += r[lag] / f64::from(records);
                mean_residual[lag] += fitted[lag] / f64::from(records);
            }
        }
        for (lag, mean) in mean.into_iter().enumerate() {
            let truth = libm::pow(memory, lag as f64);
            // The mean of 400 records knows each lag to about 0.01.
            assert!((mean - truth).abs() < 0.04, "lag {lag}: {mean} for {truth}");
        }
        assert!(mean_residual[2] < 0.36 - 0.1, "{mean_residual:?}: nothing to make good in this example");
    }

    #[test]
    fn a_record_of_nothing_has_no_autocovariance() {
        let information = Information::<SIGNALS>::default();
        assert!(error_covariance(&information, &[0], &[[0.0; REGRESSORS]; REGRESSORS], &[0.0; SIGNALS]).is_none());
    }
}
