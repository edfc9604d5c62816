//! Standard errors of equation error for coloured residuals: the equation error as an autoregression.
//!
//! Consumes a residual v = M e, M = I - X D X', D = (X'X)^-1, and the columns X [rows x terms] of the fit; produces
//!     e_k = sum_j a_j e_(k-j) + eps_k,  j = 1 .. q                                                   (1)
//! and X' Sigma X, Sigma the covariance of e, so that cov(theta) = D X' Sigma X D.                        (2)
//! The residual lacks the part of the error that lies in the span of X, so its autocovariance is biased low. With c_l = sum v_k
//! v_(k-l),
//!     E c_l = n_l r_l - sum_k ((X D)_k (Sigma X)_(k-l)' + (Sigma X)_k (X D)_(k-l)')
//!             + sum_k (X D)_k (X' Sigma X) (X D)_(k-l)'                                               (3)
//! is solved for r_l = E e_k e_(k-l), l = 0 .. q, by iteration: Sigma from the last r by (1), r from (3). For white errors
//! r_0 = c_0/(m - p): Padfield et al. 1987, (19). The order q minimises the Akaike criterion.
//! Sigma x takes two passes of (1), backward and forward, at a cost of rows times q: Sigma = s2 A^-1 A^-T, with A the
//! autoregression as a band matrix; the backward pass continues beyond a stretch's first row until it has decayed.
//! Source: (2) E. A. Morelli and V. Klein, J. Guidance 20(1), 1997; order H. Akaike, IEEE Trans. Automatic Control 19(6), 1974;
//! (3) is ours: `realtime::regression::error_autocovariance`, with (1) for lags beyond q.
//! Numerics: the iteration starts from the residual's own autocovariance, which is positive definite. Where (3) asks for one that
//! is not, the last positive one is kept; residuals are never taken as white instead.

use super::design::inner;
use std::ops::Range;

/// Largest part of the rows that the order may be.
const ROWS_A_LAG: usize = 12;

/// Rounds of (3).
const ROUNDS: usize = 12;

/// Largest change of an autocovariance, relative to r_0, at convergence.
const SETTLED: f64 = 1e-3;

/// Largest reflection coefficient of the Levinson recursion.
const REFLECTION_MAX: f64 = 0.9999;

/// Part of an impulse response at which the backward pass ends.
const REST: f64 = 1e-4;

/// Order of the model of coloured residuals.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ErrorModelOrder {
    /// Largest order of the autoregression; 0 takes residuals as white.
    pub order_max: usize,
}

impl Default for ErrorModelOrder {
    fn default() -> Self {
        ErrorModelOrder { order_max: 12 }
    }
}

/// The autoregression (1) and the middle of (2).
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ErrorModel {
    /// a_1 .. a_q.
    pub coefficients: Vec<f64>,
    /// Variance of eps.
    pub innovation_var: f64,
    /// Variance of e.
    pub var: f64,
    /// X' Sigma X, row after row.
    pub middle: Vec<f64>,
}

/// Columns of a fit.
pub(super) struct FittedEquation<'a> {
    /// Columns of X: the biases' and the terms'.
    pub(super) x: &'a [&'a [f64]],
    /// Columns of X D.
    pub(super) xd: &'a [Vec<f64>],
    pub(super) stretches: &'a [Range<usize>],
}

impl ErrorModel {
    /// The model of the equation error from that residual, by (3).
    pub(super) fn of(residual: &[f64], fitted: &FittedEquation<'_>, colour: ErrorModelOrder) -> ErrorModel {
        let rows = residual.len();
        let parameters = fitted.x.len();
        let order_max = colour.order_max.min(rows / ROWS_A_LAG);
        let lagged = |a: &[f64], b: &[f64], lag: usize| -> f64 {
            let of_stretch = |range: &Range<usize>| {
                let (a, b) = (&a[range.clone()], &b[range.clone()]);
                if a.len() > lag { inner(&a[lag..], &b[..b.len() - lag]) } else { 0.0 }
            };
            fitted.stretches.iter().map(of_stretch).sum()
        };
        let sums: Vec<f64> = (0..=order_max).map(|lag| lagged(residual, residual, lag)).collect();
        let pairs = |lag: usize| -> f64 { fitted.stretches.iter().map(|range| range.len().saturating_sub(lag) as f64).sum() };
        let freedom = (rows as f64 - parameters as f64).max(1.0);
        let white = sums[0] / freedom;
        // Divided by the number of rows, not of pairs: positive definite for any residual.
        let mut r: Vec<f64> = sums.iter().map(|c| c / freedom).collect();
        let (mut error, _) = ErrorModel::autoregression(&r, rows as f64, None);
        let mut order = None;
        for round in 0..ROUNDS {
            let spread: Vec<Vec<f64>> = error.covaried(fitted);
            error.middle = fitted.x.iter().flat_map(|x| spread.iter().map(|s| inner(x, s))).collect();
            if error.coefficients.is_empty() && order_max == 0 {
                break;
            }
            let mut moved: f64 = 0.0;
            let folded = error.folded(fitted, rows);
            let mut next = r.clone();
            for (lag, next) in next.iter_mut().enumerate() {
                let mut taken = 0.0;
                for ((xd, spread), folded) in fitted.xd.iter().zip(&spread).zip(&folded) {
                    taken += lagged(xd, spread, lag) + lagged(spread, xd, lag) - lagged(xd, folded, lag);
                }
                *next = (sums[lag] + taken) / pairs(lag).max(1.0);
            }
            let usable = next.iter().all(|r| r.is_finite()) && next[0] > 0.0 && next[0] < 20.0 * white;
            if !usable {
                break;
            }
            for (new, old) in next.iter().zip(&r) {
                moved = moved.max(libm::fabs(new - old) / next[0]);
            }
            r = next;
            // The order may change twice and is then held, so that the rounds end.
            if round >= 1 {
                order = Some(error.coefficients.len());
            }
            let (found, is_positive) = ErrorModel::autoregression(&r, rows as f64, order);
            if !is_positive {
                break;
            }
            error = found;
            if moved < SETTLED {
                break;
            }
        }
        let spread: Vec<Vec<f64>> = error.covaried(fitted);
        error.middle = fitted.x.iter().flat_map(|x| spread.iter().map(|s| inner(x, s))).collect();
        error
    }

    /// X D (X' Sigma X), column by column.
    fn folded(&self, fitted: &FittedEquation<'_>, rows: usize) -> Vec<Vec<f64>> {
        let p = fitted.x.len();
        let column = |j: usize| {
            let mut sum = vec![0.0; rows];
            for (i, xd) in fitted.xd.iter().enumerate() {
                let factor = self.middle[i * p + j];
                sum.iter_mut().zip(xd).for_each(|(s, x)| *s += factor * x);
            }
            sum
        };
        (0..p).map(column).collect()
    }

    /// (1) by the Levinson recursion, of the order that minimises the Akaike criterion or of the order given, and whether the
    /// autocovariances are positive definite.
    fn autoregression(r: &[f64], rows: f64, wanted: Option<usize>) -> (ErrorModel, bool) {
        let mut a: Vec<f64> = Vec::new();
        let mut var = r[0];
        let mut best = ErrorModel { coefficients: Vec::new(), innovation_var: var, var: r[0], middle: Vec::new() };
        let mut smallest = libm::log(var);
        for q in 1..r.len() {
            if wanted.is_some_and(|wanted| q > wanted) {
                break;
            }
            let ahead: f64 = a.iter().enumerate().map(|(j, a)| a * r[q - 1 - j]).sum();
            let reflection = (r[q] - ahead) / var;
            if !(libm::fabs(reflection) < REFLECTION_MAX) {
                return (best, false);
            }
            a = (0..q).map(|j| if j + 1 == q { reflection } else { a[j] - reflection * a[q - 2 - j] }).collect();
            var *= 1.0 - reflection * reflection;
            let criterion = libm::log(var) + 2.0 * q as f64 / rows;
            if wanted.is_some() || criterion < smallest {
                smallest = criterion;
                best = ErrorModel { coefficients: a.clone(), innovation_var: var, var: r[0], middle: Vec::new() };
            }
        }
        (best, true)
    }

    /// Sigma x for every column of X.
    fn covaried(&self, fitted: &FittedEquation<'_>) -> Vec<Vec<f64>> {
        let run_on = self.memory();
        fitted.x.iter().map(|x| self.spread(x, fitted.stretches, run_on)).collect()
    }

    /// Sigma x, stretch by stretch.
    fn spread(&self, x: &[f64], stretches: &[Range<usize>], run_on: usize) -> Vec<f64> {
        let q = self.coefficients.len();
        if q == 0 {
            return x.iter().map(|x| self.innovation_var * x).collect();
        }
        let mut out = vec![0.0; x.len()];
        for range in stretches {
            // g = A^-T x, from the last row back; `run_on` rows before the first one, q zeros behind the last.
            let rows = range.len();
            let mut g = vec![0.0; run_on + rows + q];
            g[run_on..run_on + rows].copy_from_slice(&x[range.clone()]);
            for k in (0..run_on + rows).rev() {
                let ahead: f64 = self.coefficients.iter().zip(&g[k + 1..]).map(|(a, g)| a * g).sum();
                g[k] += ahead;
            }
            // A^-1 g, forward.
            for k in 0..run_on + rows {
                let behind: f64 = self.coefficients.iter().zip(g[..k].iter().rev()).map(|(a, g)| a * g).sum();
                g[k] += behind;
            }
            for (out, g) in out[range.clone()].iter_mut().zip(&g[run_on..]) {
                *out = self.innovation_var * g;
            }
        }
        out
    }

    /// Rows after which the impulse response of (1) has decayed.
    fn memory(&self) -> usize {
        const LONGEST: usize = 2000;
        let q = self.coefficients.len();
        let mut response = vec![0.0; LONGEST + q];
        let mut seen = q;
        if let Some(first) = response.get_mut(q) {
            *first = 1.0;
        }
        for k in q + 1..LONGEST {
            let behind: f64 = self.coefficients.iter().zip(response[..k].iter().rev()).map(|(a, e)| a * e).sum();
            response[k] = behind;
            if libm::fabs(behind) > REST {
                seen = k;
            }
            if k > seen + 4 * q {
                break;
            }
        }
        seen + 1 - q
    }
}
