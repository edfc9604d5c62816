//! Curvature: how far derivatives by least squares depend on the amplitude of the motion.
//!
//! Consumes z and, beside the information matrix, its products with the curvature of the flow velocities
//!     c = [v^2, v|v|, w^2, w|w|]                                                                     (1)
//! and produces, for a fitted equation, by how much its estimates would shift were c among the regressors. With G = (X'X)^-1
//! X'c, c_r the part of c that the regressors leave, e the residual, and s^2 the residual's variance for independent samples,
//!     kappa = (c_r'c_r/s^2 + T^-1)^-1 c_r'e/s^2,    shift = -G kappa                                 (2)
//! T is the prior that a derivative doubles over `DOUBLING_RAD` of flow angle, by the stiffness of the equation; it keeps small
//! motion, in which c cannot be told from v, from giving any curvature.
//! Source: (2) is ridge regression with a Gaussian prior, A. E. Hoerl and R. W. Kennard, Technometrics 12(1), 1970; polynomial
//! terms of aerodynamic models: V. Klein and E. A. Morelli, Aircraft System Identification, AIAA, 2006, ch. 5.

use super::candidate::{BIAS, REGRESSORS, SIGNALS, is_primary, regressor};
use super::stepwise::Fit;
use crate::flight::derivative::{Axis, Variable};
use nalgebra::{SMatrix, SVector};

/// Length of (1).
const CURVATURES: usize = 4;

/// Flow angle over which a derivative may change by its own size, rad.
const DOUBLING_RAD: f64 = 0.2;

/// Shift of a primary term, in standard errors without it and as part of the value, above which it depends on the amplitude.
const LARGE_SHIFT: (f64, f64) = (3.0, 0.1);

/// Weighted sums of products of (1) with z and with itself.
#[derive(Clone, Debug)]
pub struct Curvature {
    with_signals: [[f64; SIGNALS]; CURVATURES],
    among: [[f64; CURVATURES]; CURVATURES],
}

impl Curvature {
    /// No vector yet.
    pub const EMPTY: Curvature = Curvature { with_signals: [[0.0; SIGNALS]; CURVATURES], among: [[0.0; CURVATURES]; CURVATURES] };

    /// One vector, with everything before it forgotten by `lambda`.
    pub fn add(&mut self, z: &[f64; SIGNALS], lambda: f64) {
        let (v, w) = (z[regressor(Variable::V)], z[regressor(Variable::W)]);
        let c = [v * v, v * v.abs(), w * w, w * w.abs()];
        for (i, &ci) in c.iter().enumerate() {
            for (sum, &zj) in self.with_signals[i].iter_mut().zip(z) {
                *sum = lambda * *sum + ci * zj;
            }
            for (sum, &cj) in self.among[i].iter_mut().zip(&c) {
                *sum = lambda * *sum + ci * cj;
            }
        }
    }

    /// Adds the square of the shift (2) to the covariance of the fit, as for any term that is left out (`stepwise` (3));
    /// whether it is large for a primary term. `residual_var` is the variance of the residual.
    pub fn account_for(&self, axis: Axis, fit: &mut Fit, speed: f64, residual_var: f64) -> bool {
        let stiffness = if axis.is_lateral() { Variable::V } else { Variable::W };
        // How much more variance the residual's colour makes of an estimate, at most.
        let colour = |&place: &usize| fit.cov[place][place] / (fit.dispersion[place][place] * residual_var);
        let colour = fit.order.iter().filter(|&&place| place != BIAS).map(colour).fold(1.0, f64::max);
        let shift = self.shift(fit, stiffness, speed, colour * residual_var);
        let (standard_errors, part) = LARGE_SHIFT;
        let large = Variable::ALL.into_iter().filter(|&variable| is_primary(axis, variable)).any(|variable| {
            let place = regressor(variable);
            let size = shift[place].abs();
            size > standard_errors * libm::sqrt(fit.cov[place][place]) && size > part * fit.theta[place].abs()
        });
        for &i in &fit.order {
            for &j in &fit.order {
                fit.cov[i][j] += shift[i] * shift[j];
            }
        }
        large
    }

    /// Shift (2) of the estimates by place; zero where a term is not in, or where there is no stiffness to compare with.
    /// `residual_var` is s^2: the variance of the residual times how much more its colour makes of the variance of an estimate.
    #[inline(never)]
    fn shift(&self, fit: &Fit, stiffness: Variable, speed: f64, residual_var: f64) -> [f64; REGRESSORS] {
        let mut shift = [0.0; REGRESSORS];
        let prior = (fit.theta[regressor(stiffness)] / (DOUBLING_RAD * speed)).abs();
        if !(speed > 0.0 && prior > 0.0 && residual_var > 0.0) {
            return shift;
        }
        // G by place, a column for every curvature.
        let regressed: [[f64; REGRESSORS]; CURVATURES] = core::array::from_fn(|c| {
            core::array::from_fn(|i| fit.order.iter().map(|&j| fit.dispersion[i][j] * self.with_signals[c][j]).sum())
        });
        let precision = SMatrix::<f64, CURVATURES, CURVATURES>::from_fn(|c, d| {
            let by_regressors: f64 = fit.order.iter().map(|&i| self.with_signals[c][i] * regressed[d][i]).sum();
            let own = if c == d { 1.0 / (prior * prior) } else { 0.0 };
            (self.among[c][d] - by_regressors) / residual_var + own
        });
        let against = SVector::<f64, CURVATURES>::from_fn(|c, _| {
            fit.residual.iter().zip(&self.with_signals[c]).map(|(e, sum)| e * sum).sum::<f64>() / residual_var
        });
        let Some(cholesky) = precision.cholesky() else { return shift };
        let kappa = cholesky.solve(&against);
        for &place in &fit.order {
            shift[place] = -(0..CURVATURES).map(|c| regressed[c][place] * kappa[c]).sum::<f64>();
        }
        shift
    }
}

#[cfg(test)]
mod tests {
    use super::super::candidate::response;
    use super::super::information::Information;
    use super::super::stepwise::{Offer, Thresholds, fit};
    use super::*;

    /// Yawing moment 0.04 v + `cubic` v|v| of an oscillation of that amplitude: the fit of the linear term, and its shift.
    fn of_oscillation(amplitude: f64, cubic: f64) -> (Fit, bool, f64) {
        let (mut information, mut curvature) = (Information::EMPTY, Curvature::EMPTY);
        for k in 0..400 {
            let t = 0.08 * f64::from(k);
            let v = amplitude * libm::sin(1.3 * t) * (0.6 + 0.4 * libm::sin(0.17 * t));
            let mut z = [0.0; SIGNALS];
            z[BIAS] = 1.0;
            z[regressor(Variable::V)] = v;
            z[response(Axis::N)] = 0.04 * v + cubic * v * v.abs() + 1e-3 * libm::cos(7.9 * t);
            information.add(&z, 1.0);
            curvature.add(&z, 1.0);
        }
        let mut offer = Offer { primary: [false; REGRESSORS], optional: [false; REGRESSORS] };
        offer.primary[regressor(Variable::V)] = true;
        let thresholds = Thresholds { f_enter: 12.0, f_remove: 8.0 };
        let mut fit = fit(&information, response(Axis::N), &offer, &thresholds).unwrap();
        let before = fit.cov[regressor(Variable::V)][regressor(Variable::V)];
        let residual_var = fit.squares / 400.0;
        let large = curvature.account_for(Axis::N, &mut fit, 50.0, residual_var);
        let shift = libm::sqrt(fit.cov[regressor(Variable::V)][regressor(Variable::V)] - before);
        (fit, large, shift)
    }

    #[test]
    fn a_derivative_of_a_curved_moment_depends_on_amplitude_by_what_least_squares_is_off() {
        let (fit, large, shift) = of_oscillation(5.0, 0.004);
        let off = fit.theta[regressor(Variable::V)] - 0.04;
        assert!(large && off > 0.01, "{off}");
        assert!((shift - off).abs() < 0.2 * off, "shift {shift}, off by {off}");
    }

    #[test]
    fn a_straight_moment_and_a_small_motion_do_not_depend_on_amplitude() {
        for (amplitude, cubic) in [(5.0, 0.0), (0.2, 0.004)] {
            let (fit, large, shift) = of_oscillation(amplitude, cubic);
            let v = regressor(Variable::V);
            assert!(!large && shift < libm::sqrt(fit.cov[v][v]), "{amplitude} {cubic}: {shift}");
        }
    }
}
