//! Curvature: how far derivatives by least squares depend on the amplitude of the motion.
//!
//! Consumes z and, beside the information matrix, its products with the curvature c of the forces and moments; produces, for a
//! fitted equation, by how much its estimates would shift were c among the regressors. c has, for the equations of each plane,
//!     X, Z, M:  u [u w q lon col],   w [w q lon col],     v [v w p r lat ped],   v|v|, w|w|, p r                    (1)
//!     Y, L, N:  u [u v p r lat ped], w [w v p r lat ped], v [v q],               v|v|, w|w|, q r, p q
//! (speed, incidence and sideslip on which every derivative depends; inertia). With G = (X'X)^-1 X'c, c_r the part of c that the
//! regressors leave, e the residual, and s^2 the residual's variance for independent samples,
//!     kappa = P c_r'e/s^2,   P = (c_r'c_r/s^2 + T^-1)^-1,   shift = -G kappa, of covariance G P G'    (2)
//! T is the prior: a derivative doubles over `DOUBLING_RAD` of flow angle or `DOUBLING_SPEED` of speed, one of the other plane
//! is as large as its counterpart by symmetry of the rotor (v and w, p and q, cyclics), and the coupling by inertia,
//! (Izz - Iyy)/Ixx and its like, is 1. It keeps small motion, in which c cannot be told from the regressors, from giving any
//! curvature.
//! Source: (2) is ridge regression with a Gaussian prior, A. E. Hoerl and R. W. Kennard, Technometrics 12(1), 1970, and its
//! posterior covariance; polynomial terms of aerodynamic models: V. Klein and E. A. Morelli, Aircraft System Identification,
//! AIAA, 2006, ch. 5; coupling by inertia: Euler's equations of a rigid body.

use super::candidate::{BIAS, REGRESSORS, SIGNALS, is_primary, regressor};
use super::stepwise::Fit;
use crate::flight::derivative::Axis;
use crate::flight::derivative::Variable::{self, Collective, LatCyclic, LonCyclic, P, Pedal, Q, R, U, V, W};
use nalgebra::{SMatrix, SVector};

/// One entry of (1).
#[derive(Clone, Copy, Debug, PartialEq)]
enum Product {
    Of(Variable, Variable),
    /// x|x|.
    Signed(Variable),
}

/// Length of (1) of either plane.
const CURVATURES: usize = 18;

/// (1) of X, Z and M.
const LONGITUDINAL: [Product; CURVATURES] = [
    Product::Of(U, U),
    Product::Of(U, W),
    Product::Of(U, Q),
    Product::Of(U, LonCyclic),
    Product::Of(U, Collective),
    Product::Of(W, W),
    Product::Of(W, Q),
    Product::Of(W, LonCyclic),
    Product::Of(W, Collective),
    Product::Of(V, V),
    Product::Of(V, W),
    Product::Of(V, P),
    Product::Of(V, R),
    Product::Of(V, LatCyclic),
    Product::Of(V, Pedal),
    Product::Signed(V),
    Product::Signed(W),
    Product::Of(P, R),
];

/// (1) of Y, L and N.
const LATERAL: [Product; CURVATURES] = [
    Product::Of(U, U),
    Product::Of(U, V),
    Product::Of(U, P),
    Product::Of(U, R),
    Product::Of(U, LatCyclic),
    Product::Of(U, Pedal),
    Product::Of(W, W),
    Product::Of(W, V),
    Product::Of(W, P),
    Product::Of(W, R),
    Product::Of(W, LatCyclic),
    Product::Of(W, Pedal),
    Product::Of(V, V),
    Product::Of(V, Q),
    Product::Signed(V),
    Product::Signed(W),
    Product::Of(Q, R),
    Product::Of(P, Q),
];

/// Flow angle over which a derivative may change by its own size, rad.
const DOUBLING_RAD: f64 = 0.2;

/// Change of speed, relative, over which one may: by 1 it is in proportion to the speed.
const DOUBLING_SPEED: f64 = 1.0;

/// Shift of a primary term, in standard errors without it and as part of the value, above which it depends on the amplitude.
const LARGE_SHIFT: (f64, f64) = (3.0, 0.1);

/// Weighted sums of products of (1) with z and with itself, by plane.
#[derive(Clone, Debug)]
pub struct Curvature {
    planes: [PlaneSums; 2],
}

#[derive(Clone, Debug)]
struct PlaneSums {
    with_signals: [[f64; SIGNALS]; CURVATURES],
    /// The lower triangle.
    among: [[f64; CURVATURES]; CURVATURES],
}

/// Shift (2) of the estimates by place, zero where a term is not in, with its covariance.
struct Shift {
    mean: [f64; REGRESSORS],
    cov: [[f64; REGRESSORS]; REGRESSORS],
}

impl Curvature {
    /// No vector yet.
    pub const EMPTY: Curvature = Curvature {
        planes: [const { PlaneSums { with_signals: [[0.0; SIGNALS]; CURVATURES], among: [[0.0; CURVATURES]; CURVATURES] } }; 2],
    };

    /// One vector, with everything before it forgotten by `lambda`.
    pub fn add(&mut self, z: &[f64; SIGNALS], lambda: f64) {
        for (sums, products) in self.planes.iter_mut().zip([&LONGITUDINAL, &LATERAL]) {
            sums.add(&products.map(|one| one.of(z)), z, lambda);
        }
    }

    /// Adds the square of the shift (2) and its covariance to the covariance of the fit, as for any term that is left out
    /// (`stepwise::omitted` (1)); whether it is large for a primary term. `residual_var` is the variance of the residual.
    pub fn account_for(&self, axis: Axis, fit: &mut Fit, speed: f64, residual_var: f64) -> bool {
        // How much more variance the residual's colour makes of an estimate, on average over the terms.
        let colour = |&place: &usize| fit.cov[place][place] / (fit.dispersion[place][place] * residual_var);
        let terms = || fit.order.iter().filter(|&&place| place != BIAS);
        let colour = (terms().map(colour).sum::<f64>() / terms().count().max(1) as f64).max(1.0);
        let stds = prior_stds(axis, fit, speed);
        let sums = &self.planes[usize::from(axis.is_lateral())];
        let Some(shift) = sums.shift(fit, &stds, colour * residual_var) else { return false };
        let (standard_errors, part) = LARGE_SHIFT;
        let large = Variable::ALL.into_iter().filter(|&variable| is_primary(axis, variable)).any(|variable| {
            let place = regressor(variable);
            let size = shift.mean[place].abs();
            size > standard_errors * libm::sqrt(fit.cov[place][place]) && size > part * fit.theta[place].abs()
        });
        for &i in &fit.order {
            for &j in &fit.order {
                fit.cov[i][j] += shift.mean[i] * shift.mean[j] + shift.cov[i][j];
            }
            fit.curvature_var[i] = shift.mean[i] * shift.mean[i] + shift.cov[i][i];
        }
        large
    }
}

impl Product {
    fn of(self, z: &[f64; SIGNALS]) -> f64 {
        let value = |variable: Variable| z[regressor(variable)];
        match self {
            Product::Of(first, second) => value(first) * value(second),
            Product::Signed(variable) => value(variable) * value(variable).abs(),
        }
    }
}

impl PlaneSums {
    fn add(&mut self, c: &[f64; CURVATURES], z: &[f64; SIGNALS], lambda: f64) {
        for (i, &ci) in c.iter().enumerate() {
            for (sum, &zj) in self.with_signals[i].iter_mut().zip(z) {
                *sum = lambda * *sum + ci * zj;
            }
            for (sum, &cj) in self.among[i].iter_mut().zip(&c[..=i]) {
                *sum = lambda * *sum + ci * cj;
            }
        }
    }

    /// (2); `None` where nothing is to be compared. `residual_var` is s^2: the variance of the residual times how much more its
    /// colour makes of the variance of an estimate.
    #[inline(never)]
    fn shift(&self, fit: &Fit, prior_stds: &[f64; CURVATURES], residual_var: f64) -> Option<Shift> {
        if !(residual_var > 0.0 && prior_stds.iter().any(|std| *std > 0.0)) {
            return None;
        }
        // G T^(1/2) by place, a column for every curvature: one without a prior is zero.
        let regressed: [[f64; REGRESSORS]; CURVATURES] = core::array::from_fn(|c| {
            let mut column = [0.0; REGRESSORS];
            if prior_stds[c] > 0.0 {
                for &i in &fit.order {
                    let sum: f64 = fit.order.iter().map(|&j| fit.dispersion[i][j] * self.with_signals[c][j]).sum();
                    column[i] = prior_stds[c] * sum;
                }
            }
            column
        });
        // T^(1/2) P^-1 T^(1/2), whose diagonal is 1 or more; only the lower triangle counts.
        let mut precision = SMatrix::<f64, CURVATURES, CURVATURES>::identity();
        let has_prior = |&c: &usize| prior_stds[c] > 0.0;
        for c in (0..CURVATURES).filter(has_prior) {
            for d in (0..=c).filter(has_prior) {
                let by_regressors: f64 = fit.order.iter().map(|&i| self.with_signals[c][i] * regressed[d][i]).sum();
                precision[(c, d)] += prior_stds[c] * (prior_stds[d] * self.among[c][d] - by_regressors) / residual_var;
            }
        }
        let against = SVector::<f64, CURVATURES>::from_fn(|c, _| {
            let sum: f64 = fit.residual.iter().zip(&self.with_signals[c]).map(|(e, sum)| e * sum).sum();
            prior_stds[c] * sum / residual_var
        });
        let cholesky = precision.cholesky()?;
        let kappa = cholesky.solve(&against);
        let mut shift = Shift { mean: [0.0; REGRESSORS], cov: [[0.0; REGRESSORS]; REGRESSORS] };
        // Rows of G T^(1/2) L'^-1, with L L' the scaled precision: their products are the covariance.
        let lower = cholesky.l_dirty();
        let mut roots = [[0.0; CURVATURES]; REGRESSORS];
        for &i in &fit.order {
            shift.mean[i] = -(0..CURVATURES).map(|c| regressed[c][i] * kappa[c]).sum::<f64>();
            for c in (0..CURVATURES).filter(has_prior) {
                let before: f64 = (0..c).map(|d| lower[(c, d)] * roots[i][d]).sum();
                roots[i][c] = (regressed[c][i] - before) / lower[(c, c)];
            }
        }
        for &i in &fit.order {
            for &j in &fit.order {
                shift.cov[i][j] = roots[i].iter().zip(&roots[j]).map(|(a, b)| a * b).sum();
            }
        }
        Some(shift)
    }
}

/// Square roots of T's diagonal by place in (1); zero where the equation has no such curvature.
fn prior_stds(axis: Axis, fit: &Fit, speed: f64) -> [f64; CURVATURES] {
    if !(speed > 0.0) {
        return [0.0; CURVATURES];
    }
    let size = |variable: Variable| {
        let own = variable.is_lateral() == axis.is_lateral();
        fit.theta[regressor(if own { variable } else { counterpart(variable) })].abs()
    };
    let products = if axis.is_lateral() { &LATERAL } else { &LONGITUDINAL };
    products.map(|product| match (product, axis) {
        (Product::Of(U, second), _) => size(second) / (DOUBLING_SPEED * speed),
        (Product::Of(V | W, second), _) | (Product::Signed(second), _) => size(second) / (DOUBLING_RAD * speed),
        (Product::Of(Q, R), Axis::L) | (Product::Of(P, R), Axis::M) | (Product::Of(P, Q), Axis::N) => 1.0,
        _ => 0.0,
    })
}

/// What by symmetry of a rotor does in one plane what the variable does in the other.
fn counterpart(variable: Variable) -> Variable {
    match variable {
        U | W => V,
        V => W,
        P | R => Q,
        Q => P,
        LatCyclic | Pedal => LonCyclic,
        LonCyclic | Collective => LatCyclic,
    }
}

#[cfg(test)]
mod tests {
    use super::super::candidate::response;
    use super::super::information::Information;
    use super::super::stepwise::{Offer, Thresholds, fit};
    use super::*;

    /// The fit of the term of v alone to 400 vectors, whether it depends on amplitude, and what that adds to its standard error.
    fn fitted(axis: Axis, information: &Information<SIGNALS>, curvature: &Curvature) -> (Fit, bool, f64) {
        let v = regressor(Variable::V);
        let mut offer = Offer::NONE;
        offer.primary[v] = true;
        let thresholds = Thresholds { f_enter: 12.0, f_remove: 8.0 };
        let mut fit = fit(information, response(axis), &offer, &thresholds).unwrap();
        let before = fit.cov[v][v];
        let residual_var = fit.squares / 400.0;
        let large = curvature.account_for(axis, &mut fit, 50.0, residual_var);
        let added = libm::sqrt(fit.cov[v][v] - before);
        (fit, large, added)
    }

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
        fitted(Axis::N, &information, &curvature)
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

    /// Rolling moment 0.04 v less 0.3 q r of a motion in which q r correlates with v.
    fn of_coupled_motion(size: f64) -> (f64, f64) {
        let (mut information, mut curvature) = (Information::EMPTY, Curvature::EMPTY);
        for k in 0..400 {
            let t = 0.08 * f64::from(k);
            let (q, r) = (0.3 * size * libm::sin(0.6 * t), 0.3 * size * libm::cos(0.7 * t));
            let mut z = [0.0; SIGNALS];
            z[BIAS] = 1.0;
            z[regressor(Variable::V)] = size * libm::sin(1.3 * t) + 0.1 * size * libm::sin(4.1 * t);
            (z[regressor(Variable::Q)], z[regressor(Variable::R)]) = (q, r);
            z[response(Axis::L)] = 0.04 * z[regressor(Variable::V)] - 0.3 * q * r + 1e-3 * libm::cos(7.9 * t);
            information.add(&z, 1.0);
            curvature.add(&z, 1.0);
        }
        let (fit, _, added) = fitted(Axis::L, &information, &curvature);
        (fit.theta[regressor(Variable::V)] - 0.04, added)
    }

    #[test]
    fn coupling_by_inertia_that_correlates_with_a_regressor_is_in_its_error() {
        let (off, added) = of_coupled_motion(1.0);
        assert!(off.abs() > 5e-3, "{off}");
        assert!((added - off.abs()).abs() < 0.1 * off.abs(), "off by {off}, {added} added");
    }

    /// By a slow obvious version: all of T, against the closed form of one regressor and one curvature.
    #[test]
    fn shift_and_its_covariance_are_those_of_a_gaussian_posterior() {
        let mut curvature = Curvature::EMPTY;
        let mut information = Information::EMPTY;
        let (mut vv, mut cv, mut cc, mut cy, mut vy, mut yy) = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0);
        for k in 0..60 {
            let t = 0.3 * f64::from(k);
            let (q, r) = (0.2 + 0.1 * libm::sin(t), 0.3 * libm::cos(0.4 * t));
            let y = 0.5 * r - 0.2 * q * r + 0.01 * libm::sin(5.0 * t);
            let mut z = [0.0; SIGNALS];
            (z[regressor(Variable::Q)], z[regressor(Variable::R)], z[response(Axis::L)]) = (q, r, y);
            curvature.add(&z, 1.0);
            information.add(&z, 1.0);
            let c = q * r;
            vv += r * r;
            cv += c * r;
            cc += c * c;
            cy += c * y;
            vy += r * y;
            yy += y * y;
        }
        let theta = vy / vv;
        let mut by_hand = Fit {
            order: heapless::Vec::new(),
            theta: [0.0; REGRESSORS],
            dispersion: [[0.0; REGRESSORS]; REGRESSORS],
            cov: [[0.0; REGRESSORS]; REGRESSORS],
            bias_var: [0.0; REGRESSORS],
            curvature_var: [0.0; REGRESSORS],
            residual: [0.0; SIGNALS],
            squares: yy - theta * vy,
            response_squares: yy,
        };
        let place = regressor(Variable::R);
        by_hand.order.push(place).unwrap();
        by_hand.theta[place] = theta;
        by_hand.dispersion[place][place] = 1.0 / vv;
        by_hand.residual[response(Axis::L)] = 1.0;
        by_hand.residual[place] = -theta;
        let stds = LATERAL.map(|product| if product == Product::Of(Q, R) { 1.0 } else { 0.0 });
        let residual_var = 2e-4;
        let [_, lateral] = &curvature.planes;
        let shift = lateral.shift(&by_hand, &stds, residual_var).unwrap();
        let posterior = 1.0 / ((cc - cv * cv / vv) / residual_var + 1.0);
        let kappa = posterior * (cy - theta * cv) / residual_var;
        let mean = -cv / vv * kappa;
        let var = cv / vv * cv / vv * posterior;
        assert!((shift.mean[place] - mean).abs() < 1e-9 * mean.abs(), "{} {mean}", shift.mean[place]);
        assert!((shift.cov[place][place] - var).abs() < 1e-9 * var, "{} {var}", shift.cov[place][place]);
    }
}
