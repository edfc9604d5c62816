//! The autocovariance of the equation error from lagged products, against whole matrices: what least squares leaves of errors
//! with a given autocovariance, multiplied out over the record.

use crate::support::uniform::Uniform;
use nalgebra::{DMatrix, DVector};
use sideslip::flight::derivative::Axis;
use sideslip::realtime::regression::candidate::{BIAS, REGRESSORS, SIGNALS, response};
use sideslip::realtime::regression::error_autocovariance::error_covariance;
use sideslip::realtime::regression::information::{Information, LAGS};
use sideslip::realtime::regression::stepwise::{Offer, Thresholds, fit};

const RECORD: usize = 500;

/// Slow regressors, and a response with an error of its own colour.
fn record(uniform: &mut Uniform) -> Vec<[f64; SIGNALS]> {
    let (mut slow, mut error) = ([0.0; SIGNALS], 0.0);
    let mut one = || {
        let mut z = [0.0; SIGNALS];
        z[BIAS] = 1.0;
        for i in 1..REGRESSORS {
            slow[i] = 0.9 * slow[i] + uniform.within(1.0);
            z[i] = slow[i];
        }
        error = 0.7 * error + uniform.within(1.0);
        z[response(Axis::N)] = 0.3 * z[1] - z[3] + error;
        z
    };
    (0..RECORD).map(|_| one()).collect()
}

/// Solves E[sum_k w_k w_(k-l) v_k v_(k-l)] = sum_m T_lm r_m with T from v = M e written out.
fn exact(x: &DMatrix<f64>, y: &DVector<f64>, weights: &[f64]) -> DVector<f64> {
    let n = weights.len();
    let w = DMatrix::from_diagonal(&DVector::from_column_slice(weights));
    let d = (x.transpose() * &w * x).try_inverse().unwrap();
    let m = DMatrix::identity(n, n) - x * d * x.transpose() * &w;
    let v = &m * y;
    let product = |left: &dyn Fn(usize, usize) -> f64, lag: usize| -> f64 {
        (lag..n).map(|k| weights[k] * weights[k - lag] * left(k, k - lag)).sum()
    };
    let mut t = DMatrix::zeros(LAGS + 1, LAGS + 1);
    for shift in 0..=LAGS {
        let band = DMatrix::from_fn(n, n, |i, j| f64::from(u8::from(i.abs_diff(j) == shift)));
        let left = &m * band * m.transpose();
        for lag in 0..=LAGS {
            t[(lag, shift)] = product(&|i, j| left[(i, j)], lag);
        }
    }
    let sums = DVector::from_fn(LAGS + 1, |lag, _| product(&|i, j| v[i] * v[j], lag));
    t.lu().solve(&sums).unwrap()
}

#[test]
fn lagged_products_give_nearly_what_whole_matrices_give() {
    let mut uniform = Uniform(81);
    // Lagged products leave out the ends of the record: 2 and 3 % of the variance at 500 instants.
    for (lambda, tolerance) in [(1.0, 0.04), (0.997, 0.05)] {
        let mut worst: f64 = 0.0;
        for _ in 0..3 {
            let record = record(&mut uniform);
            let mut information = Information::<SIGNALS>::default();
            record.iter().for_each(|z| information.add(z, lambda));
            let offer = Offer { primary: std::array::from_fn(|place| place != BIAS), ..Offer::NONE };
            let y = response(Axis::N);
            let found = fit(&information, y, &offer, &Thresholds { f_enter: 12.0, f_remove: 8.0 }).unwrap();
            let r = error_covariance(&information, &found.order, &found.dispersion, &found.residual).unwrap();

            let x = DMatrix::from_fn(RECORD, REGRESSORS, |k, j| record[k][j]);
            let weights: Vec<f64> = (0..RECORD).map(|k| libm::pow(lambda, (RECORD - 1 - k) as f64)).collect();
            let exact = exact(&x, &DVector::from_fn(RECORD, |k, _| record[k][y]), &weights);
            for lag in 0..=LAGS {
                worst = worst.max((r[lag] - exact[lag]).abs() / exact[0]);
            }
        }
        eprintln!("lambda {lambda}: at most {worst:.4} of the variance apart");
        assert!(worst < tolerance, "lambda {lambda}: {worst} of the variance apart");
    }
}
