//! How much coloured residuals add to the variance of time and drift.
//!
//! Where two instruments differ by more than white noise (lags, calibrations, what the spline cannot follow), residuals go
//! together from sample to sample, and the covariance of white noise is too small. A sample moves the estimate by
//!     psi_i = S^-1 (x_i - C' A^-1 b_i) e_i/(sigma^2 sqrt(1 - lever))                                    (1)
//! with x_i, b_i its rows of globals and splines; with Psi_n the sums over bins of the knots' width, and L lags,
//!     kappa = sum_(|l| <= L) (1 - |l|/(L + 1)) sum_n Psi_n Psi_(n-l) / (S^-1)_ii                         (2)
//! the larger one of both. It counts where it is above 1 by more than three of its standard errors,
//! sqrt(2 (2 L/3 + 1)/M) with M = (sum_n v_n)^2/sum_n v_n^2 for variances v_n of the Psi_n under white noise, and is 1 otherwise.
//! Source: W. K. Newey and K. D. West, Econometrica 55, 1987, with L = 4 (N/100)^(2/9) as in Rev. Econ. Stud. 61, 1994.

use super::joint_fit::{DRIFT, GLOBALS, JointData, JointFit, TIME};
use super::spline::SplineRow;

/// Standard errors above 1 from which colour counts.
const SIGNIFICANT: f64 = 3.0;

/// kappa; `None` where S has no inverse.
pub(super) fn colour_factor(data: &JointData, fit: &JointFit) -> Option<f64> {
    let covariance = fit.information.inverse()?;
    let bins = fit.knots.intervals;
    let (mut sums, mut variances) = (vec![[0.0; 2]; bins], vec![[0.0; 2]; bins]);
    let mut add = |row: &SplineRow, globals: &[f64; GLOBALS], weights: &[f64; 4], of: usize, residual: f64| {
        let left: [f64; GLOBALS] =
            core::array::from_fn(|g| globals[g] - (0..4).map(|k| weights[k] * fit.projection[(row.first + k, g)]).sum::<f64>());
        for (place, global) in [TIME, DRIFT].into_iter().enumerate() {
            let moves: f64 = (0..GLOBALS).map(|g| covariance[(global, g)] * left[g]).sum();
            if let (Some(sum), Some(variance)) = (sums.get_mut(row.first), variances.get_mut(row.first)) {
                sum[place] += moves * residual / (fit.noise_var[of] * libm::sqrt(1.0 - fit.lever[of]));
                variance[place] += moves * moves / fit.noise_var[of];
            }
        }
    };
    for &sample in &data.ours {
        let (row, residual) = JointData::our_row(fit, sample);
        add(&row, &[0.0; GLOBALS], &row.value, 0, residual);
    }
    for &sample in &data.theirs {
        let row = data.their_row(fit, sample);
        let scaled = row.spline.value.map(|value| fit.globals[2] * value);
        add(&row.spline, &row.globals, &scaled, 1, row.residual);
    }
    let lags = (4.0 * libm::pow(bins as f64 / 100.0, 2.0 / 9.0)) as usize;
    let of = |place: usize, global: usize| {
        let product = |lag: usize| sums.iter().zip(sums.iter().skip(lag)).map(|(a, b)| a[place] * b[place]).sum::<f64>();
        let tapered = (1..=lags).map(|lag| 2.0 * (1.0 - lag as f64 / (lags + 1) as f64) * product(lag)).sum::<f64>();
        let (sum, square) = variances.iter().fold((0.0, 0.0), |(sum, square), v| (sum + v[place], square + v[place] * v[place]));
        let std = libm::sqrt(2.0 * (2.0 * lags as f64 / 3.0 + 1.0) * square / (sum * sum));
        let kappa = (product(0) + tapered) / covariance[(global, global)];
        if kappa > 1.0 + SIGNIFICANT * std { kappa } else { 1.0 }
    };
    let of_time = of(0, TIME);
    Some(if data.with_drift { of_time.max(of(1, DRIFT)) } else { of_time })
}
