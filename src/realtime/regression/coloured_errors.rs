//! Standard errors of recursive equation error for coloured residuals.
//!
//! Consumes an information matrix and fitted equations; produces the covariance of the estimates
//!     Sigma_ab = D_a [ sum_l w_l (R^ab_l G_l + R^ba_l G_l') ] D_b   (l = 0 counted once)             (1)
//! for equations a and b (a = b: the ordinary covariance of one), with
//! | symbol | shape | meaning |
//! | --- | --- | --- |
//! | D_a | p x p | (X_a'X_a)^-1 of equation a, zero where a regressor is not in it |
//! | G_l | p x p | lagged products of the regressors, information (2) |
//! | R^ab_l | 1 | covariance of residual a at k with residual b at k - l, information (3) |
//! | w_l | 1 | 1 - l/(LAGS + 1): with it and the residual's own R (1) cannot be negative: the product of two positive sequences |
//!
//! For white residuals and no forgetting (1) is sigma^2 D, (19) of Padfield et al. 1987.
//! Source: E. A. Morelli and V. Klein, J. Guidance 20(1), 1997, eq. (22); weights: W. K. Newey and K. D. West,
//! Econometrica 55(3), 1987. Every R has the factor n/(n - p) for the p parameters fitted.
//! Numerics: the weights leave out part of a residual that stays correlated over much of LAGS steps of the grid. With the R of
//! the equation error (`error_autocovariance`) a variance can be negative in a short record; that of the residual is used
//! then. Blocks between two equations always have the residuals' R.

use super::candidate::{Coefficients, REGRESSORS, SIGNALS};
use super::information::{Information, LAGS, LagCovariance};
use crate::realtime::regression::error_autocovariance;

/// Covariances R^ab_l of two residuals; `parameters` fitted in each.
pub fn residual_covariance(
    information: &Information<SIGNALS>,
    a: &Coefficients,
    b: &Coefficients,
    parameters: usize,
) -> LagCovariance {
    let n = information.effective_samples();
    let used_up = if n > parameters as f64 { n / (n - parameters as f64) } else { f64::INFINITY };
    let scale = used_up / information.weight2();
    information.forms(a, b).map(|form| scale * form)
}

/// By how much more a variance of (1) has to be, for p parameters fitted to n samples of which m are independent: p of them are
/// absorbed, and the residual's variance is known from m - p alone, so that 95 % lie within t/1.96 times as many standard errors,
///     f = (m/(m - p)) ((n - p)/n) (t/z)^2,   t = z + (z^3 + z)/(4 nu) + (5 z^5 + 16 z^3 + 3 z)/(96 nu^2),   nu = m - p  (2)
/// with z = 1.96, t the quantile of Student's distribution: Abramowitz and Stegun, 26.7.5. At least one of nu is counted.
pub fn small_sample_factor(samples: f64, independent: f64, parameters: f64) -> f64 {
    const Z: f64 = 1.96;
    const FIRST: f64 = (Z * Z + 1.0) / 4.0;
    const SECOND: f64 = (5.0 * Z * Z * Z * Z + 16.0 * Z * Z + 3.0) / 96.0;
    let left = (independent - parameters).max(1.0);
    let student = 1.0 + FIRST / left + SECOND / (left * left);
    independent.max(1.0) / left * ((samples - parameters) / samples).clamp(0.0, 1.0) * student * student
}

/// Weight of a lag in (1).
pub(crate) fn taper(lag: usize) -> f64 {
    1.0 - lag as f64 / (LAGS + 1) as f64
}

/// Variance of one estimate, (1) for a single regressor: `direction` is that regressor after regression on all the others in
/// its equation (coefficients over z), `squares` its sum of squares.
pub fn variance(information: &Information<SIGNALS>, direction: &Coefficients, squares: f64, residual: &LagCovariance) -> f64 {
    let forms = information.forms(direction, direction);
    let mut sum = 0.0;
    for (lag, (r, form)) in residual.iter().zip(&forms).enumerate() {
        let twice = if lag == 0 { 1.0 } else { 2.0 };
        sum += twice * taper(lag) * r * form;
    }
    sum / (squares * squares)
}

/// The bracket of (1) for one equation with those terms, by place; zero where a term is not in.
pub fn middle(information: &Information<SIGNALS>, order: &[usize], residual: &LagCovariance) -> [[f64; REGRESSORS]; REGRESSORS] {
    let ahead: LagCovariance = core::array::from_fn(|lag| taper(lag) * residual[lag]);
    let mut behind = ahead;
    behind[0] = 0.0;
    let mut middle = [[0.0; REGRESSORS]; REGRESSORS];
    for (n, &i) in order.iter().enumerate() {
        for &j in order.iter().take(n + 1) {
            middle[i][j] = information.weighted(&ahead, i, j) + information.weighted(&behind, j, i);
            middle[j][i] = middle[i][j];
        }
    }
    middle
}

/// Variance of one estimate, (1), from the bracket and the estimate's row of D.
pub fn row_variance(middle: &[[f64; REGRESSORS]; REGRESSORS], row: &[f64; REGRESSORS]) -> f64 {
    let mut sum = 0.0;
    for (of_i, d_i) in middle.iter().zip(row) {
        if *d_i != 0.0 {
            let inner: f64 = of_i.iter().zip(row).map(|(m, d_j)| m * d_j).sum();
            sum += d_i * inner;
        }
    }
    sum
}

/// (1) for two equations, entry `[i][j]` the covariance of regressor i's estimate in a with regressor j's in b.
pub fn covariance(
    information: &Information<SIGNALS>,
    d_a: &[[f64; REGRESSORS]; REGRESSORS],
    d_b: &[[f64; REGRESSORS]; REGRESSORS],
    forward: &LagCovariance,
    backward: &LagCovariance,
) -> [[f64; REGRESSORS]; REGRESSORS] {
    let ahead: LagCovariance = core::array::from_fn(|lag| taper(lag) * forward[lag]);
    let behind: LagCovariance = core::array::from_fn(|lag| if lag == 0 { 0.0 } else { taper(lag) * backward[lag] });
    let mut middle = [[0.0; REGRESSORS]; REGRESSORS];
    for i in (0..REGRESSORS).filter(|&i| d_a[i][i] != 0.0) {
        for j in (0..REGRESSORS).filter(|&j| d_b[j][j] != 0.0) {
            middle[i][j] = information.weighted(&ahead, i, j) + information.weighted(&behind, j, i);
        }
    }
    product(d_a, &product(&middle, d_b))
}

/// Covariance of the estimates of one equation with those terms, (1) with the autocovariance of the equation error
/// (`error_autocovariance`); with that of the residual where the record is too short for it.
pub fn equation_covariance(
    information: &Information<SIGNALS>,
    order: &[usize],
    dispersion: &[[f64; REGRESSORS]; REGRESSORS],
    residual: &Coefficients,
) -> [[f64; REGRESSORS]; REGRESSORS] {
    let with =
        |autocovariance: &LagCovariance| product(dispersion, &product(&middle(information, order, autocovariance), dispersion));
    if let Some(error) = error_autocovariance::error_covariance(information, order, dispersion, residual) {
        let cov = with(&error);
        if order.iter().all(|&place| cov[place][place] > 0.0) {
            return cov;
        }
    }
    let fitted = residual_covariance(information, residual, residual, order.len());
    with(&fitted)
}

/// (1) for one equation whose residual is white with that variance.
pub fn white_covariance(
    information: &Information<SIGNALS>,
    d: &[[f64; REGRESSORS]; REGRESSORS],
    residual_var: f64,
) -> [[f64; REGRESSORS]; REGRESSORS] {
    let squared = information.squared();
    let middle = core::array::from_fn(|i| core::array::from_fn(|j| residual_var * squared[i][j]));
    product(d, &product(&middle, d))
}

fn product(a: &[[f64; REGRESSORS]; REGRESSORS], b: &[[f64; REGRESSORS]; REGRESSORS]) -> [[f64; REGRESSORS]; REGRESSORS] {
    let mut out = [[0.0; REGRESSORS]; REGRESSORS];
    for (row, out_row) in a.iter().zip(&mut out) {
        for (entry, b_row) in row.iter().zip(b) {
            if *entry != 0.0 {
                for (o, x) in out_row.iter_mut().zip(b_row) {
                    *o += entry * x;
                }
            }
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Quantiles of Student's distribution at 97.5 %: Abramowitz and Stegun, table 26.10.
    #[test]
    fn few_independent_samples_widen_by_the_quantile_of_student_and_by_what_the_parameters_absorb() {
        for (left, quantile, within) in [(4.0, 2.776, 0.02), (6.0, 2.447, 0.01), (10.0, 2.228, 0.003), (30.0, 2.042, 0.001)] {
            // As many samples as independent ones: nothing is absorbed beyond n/(n - p).
            let student = libm::sqrt(small_sample_factor(left + 8.0, left + 8.0, 8.0));
            assert!((student * 1.96 / quantile - 1.0).abs() < within, "{left}: {}", student * 1.96);
        }
        let many = small_sample_factor(1e7, 1e6, 8.0);
        assert!((many - 1.0).abs() < 1e-4, "{many}");
        let factor = small_sample_factor(120.0, 20.0, 8.0);
        let student = small_sample_factor(20.0, 20.0, 8.0);
        assert!((factor - student * (20.0 / 12.0) * (112.0 / 120.0)).abs() < 1e-12);
    }
}
