//! Standard errors of an output-error fit: with those by curvature, and where its assumptions do not hold limited from below by
//! the regression's.
//!
//! A linear model of a motion that bends its forces and moments is off by as much whichever method fits it: the regression's
//! estimate of that (`regression::curvature`) is added to the fit's own variances.
//! Output error assumes that every term is in the model and that nothing but the controls and the initial state moves the
//! aircraft. Where terms are left out, where gusts or unmodelled dynamics act (residuals far from white), or where the search has
//! not reached the minimum, its covariance is not that of its errors, corrected for colour or not. The regression's standard
//! errors, of the same samples, cover all three. In each plane, with s of the regression and s' of output error,
//!     f^2 = max(1, mean of (s/s')^2 over the derivatives of both),   std_i = max(s_i, f s'_i)                              (1)
//! and the estimates count as uncorrelated, because the correlations are those of the assumptions. A derivative of which the
//! regression has no number has none here, nor has a plane without a number in a moment equation.

use crate::flight::derivative::{AXES, Axis, VARIABLES, Variable};
use crate::num::dense::Dense;

/// Ratio of the standard errors by curvature to the fit's own, root mean square over an axis, from which on they dominate.
const DOMINATED: f64 = 1.0;

/// Whether the fit's own errors hold, or (1).
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum ErrorScale<'r> {
    /// The errors as they are, and what curvature contributes to those of any linear model.
    Own {
        /// Standard errors by curvature, NaN where not known.
        curvature: &'r [[f32; VARIABLES]; AXES],
        /// Their root mean square by axis, relative to the fit's own: for derivatives of which they are not known.
        relative: [f64; AXES],
    },
    /// Limited by the regression's.
    Limited {
        /// f of Y, L, N; `None` where the plane has no number.
        lateral: Option<f64>,
        /// f of X, Z, M.
        longitudinal: Option<f64>,
        /// Standard errors of the regression, NaN where none.
        regression: &'r [[f32; VARIABLES]; AXES],
    },
}

impl<'r> ErrorScale<'r> {
    /// The fit's own standard errors with those by curvature, NaN where not known.
    pub(crate) fn own(fitted: &[((Axis, Variable), f64)], curvature: &'r [[f32; VARIABLES]; AXES]) -> Self {
        let relative = Axis::ALL.map(|axis| {
            let ratios =
                fitted.iter().filter(|one| one.0.0 == axis).map(|&((axis, variable), std)| of(curvature, axis, variable) / std);
            let (sum, count) = ratios
                .filter(|ratio| ratio.is_finite())
                .fold((0.0, 0.0), |(sum, count), ratio| (sum + ratio * ratio, count + 1.0));
            if count > 0.0 { libm::sqrt(sum / count) } else { 0.0 }
        });
        ErrorScale::Own { curvature, relative }
    }

    /// Whether curvature contributes more to the standard errors in an axis than noise does: what the fit's own errors, which
    /// know of noise alone, say is then not its precision.
    pub(crate) fn is_dominated_by_curvature(&self) -> bool {
        matches!(self, ErrorScale::Own { relative, .. } if relative.iter().any(|relative| *relative > DOMINATED))
    }

    /// (1) from the derivatives of the fit with their standard errors, and the regression's standard errors, NaN where none.
    pub(crate) fn limited(fitted: &[((Axis, Variable), f64)], regression: &'r [[f32; VARIABLES]; AXES]) -> Self {
        let of_plane = |lateral: bool| {
            let (mut sum, mut count, mut moments) = (0.0, 0_u32, 0_u32);
            for &((axis, variable), std) in fitted.iter().filter(|one| one.0.0.is_lateral() == lateral) {
                let ratio = of(regression, axis, variable) / std;
                if ratio.is_finite() {
                    sum += ratio * ratio;
                    count += 1;
                    moments += u32::from(!axis.is_force());
                }
            }
            (moments > 0).then(|| libm::sqrt((sum / f64::from(count)).max(1.0)))
        };
        ErrorScale::Limited { lateral: of_plane(true), longitudinal: of_plane(false), regression }
    }

    /// Standard error of a derivative whose own is `std`; `None` where it has no number.
    pub(crate) fn std(&self, axis: Axis, variable: Variable, std: f64) -> Option<f64> {
        let regression = match self {
            ErrorScale::Own { curvature, relative } => {
                let known = Some(of(curvature, axis, variable)).filter(|known| known.is_finite());
                return Some(libm::hypot(std, known.unwrap_or_else(|| std * relative.get(axis.index()).copied().unwrap_or(0.0))));
            }
            ErrorScale::Limited { regression, .. } => *regression,
        };
        let least = Some(of(regression, axis, variable)).filter(|least| least.is_finite())?;
        self.factor(axis.is_lateral()).map(|factor| least.max(factor * std))
    }

    /// Whether a plane has numbers.
    pub(crate) fn has(&self, lateral: bool) -> bool {
        self.factor(lateral).is_some()
    }

    /// Covariance of the estimates for what follows from them.
    pub(crate) fn covariance(&self, names: &[(Axis, Variable)], cov: &Dense) -> Dense {
        if let ErrorScale::Own { .. } = self {
            let mut all = cov.clone();
            for (place, &(axis, variable)) in names.iter().enumerate() {
                let own = libm::sqrt(cov[(place, place)].max(0.0));
                let std = self.std(axis, variable, own).unwrap_or(own);
                all[(place, place)] = std * std;
            }
            return all;
        }
        let mut diagonal = Dense::zeros(cov.rows(), cov.rows());
        for (place, &(axis, variable)) in names.iter().enumerate() {
            let own = libm::sqrt(cov[(place, place)].max(0.0));
            let scaled = self.factor(axis.is_lateral()).unwrap_or(1.0) * own;
            let std = self.std(axis, variable, own).unwrap_or(scaled);
            diagonal[(place, place)] = std * std;
        }
        diagonal
    }

    fn factor(&self, of_lateral: bool) -> Option<f64> {
        match self {
            ErrorScale::Own { .. } => Some(1.0),
            ErrorScale::Limited { lateral, .. } if of_lateral => *lateral,
            ErrorScale::Limited { longitudinal, .. } => *longitudinal,
        }
    }
}

fn of(regression: &[[f32; VARIABLES]; AXES], axis: Axis, variable: Variable) -> f64 {
    regression.get(axis.index()).and_then(|row| row.get(variable.index())).map_or(f64::NAN, |&std| f64::from(std))
}

#[cfg(test)]
mod tests {
    use super::*;

    const NONE: [[f32; VARIABLES]; AXES] = [[f32::NAN; VARIABLES]; AXES];

    #[test]
    fn errors_are_never_below_those_of_the_regression() {
        let mut regression = NONE;
        regression[Axis::N.index()][Variable::V.index()] = 3.0;
        regression[Axis::L.index()][Variable::P.index()] = 8.0;
        regression[Axis::M.index()][Variable::Q.index()] = 0.125;
        let names = [(Axis::N, Variable::V), (Axis::L, Variable::P), (Axis::N, Variable::R), (Axis::M, Variable::Q)];
        let own = [1.0, 2.0, 0.5, 1.0];
        let fitted: Vec<_> = names.into_iter().zip(own).collect();
        let scale = ErrorScale::limited(&fitted, &regression);
        // f = sqrt((3^2 + 4^2)/2) of the lateral plane, 1 of the other, where the regression is better.
        let factor = 12.5_f64.sqrt();
        let expected = [Some(factor), Some(8.0), None, Some(1.0)];
        for ((&(axis, variable), own), expected) in names.iter().zip(own).zip(expected) {
            let found = scale.std(axis, variable, own);
            assert!(found.is_some() == expected.is_some() && (found.unwrap_or(0.0) - expected.unwrap_or(0.0)).abs() < 1e-12);
            assert_eq!(ErrorScale::own(&fitted, &NONE).std(axis, variable, own), Some(own));
        }
        let mut cov = Dense::zeros(4, 4);
        for i in 0..4 {
            for j in 0..4 {
                cov[(i, j)] = own[i] * own[j] * if i == j { 1.0 } else { 0.5 };
            }
        }
        let limited = scale.covariance(&names, &cov);
        assert!((limited[(2, 2)] - 12.5 * 0.25).abs() < 1e-12 && (limited[(1, 1)] - 64.0).abs() < 1e-12);
        assert!(limited[(0, 1)].abs() < 1e-300, "no correlation");
        let unchanged = ErrorScale::own(&fitted, &NONE).covariance(&names, &cov);
        assert!((0..4).all(|i| (0..4).all(|j| (unchanged[(i, j)] - cov[(i, j)]).abs() < 1e-15)));
    }

    #[test]
    fn curvature_adds_to_the_errors_of_a_fit_and_is_taken_as_large_where_it_is_not_known() {
        let mut curvature = NONE;
        curvature[Axis::N.index()][Variable::V.index()] = 3.0;
        let fitted = [((Axis::N, Variable::V), 4.0), ((Axis::N, Variable::R), 8.0), ((Axis::M, Variable::Q), 1.0)];
        let scale = ErrorScale::own(&fitted, &curvature);
        let std = |axis, variable, own| scale.std(axis, variable, own).unwrap();
        assert!((std(Axis::N, Variable::V, 4.0) - 5.0).abs() < 1e-12);
        assert!((std(Axis::N, Variable::R, 8.0) - 10.0).abs() < 1e-12, "3/4 of its own, as of the other of its axis");
        assert!((std(Axis::M, Variable::Q, 1.0) - 1.0).abs() < 1e-12, "nothing is known of M");
        let names = fitted.map(|(name, _)| name);
        let mut cov = Dense::zeros(3, 3);
        cov[(0, 0)] = 16.0;
        cov[(0, 1)] = 2.0;
        let all = scale.covariance(&names, &cov);
        assert!((all[(0, 0)] - 25.0).abs() < 1e-12 && (all[(0, 1)] - 2.0).abs() < 1e-15);
    }

    #[test]
    fn where_the_regression_has_no_moment_there_is_no_number() {
        let mut regression = NONE;
        regression[Axis::Y.index()][Variable::V.index()] = 0.1;
        let fitted = [((Axis::Y, Variable::V), 0.1), ((Axis::N, Variable::V), 0.01), ((Axis::M, Variable::Q), 0.01)];
        let scale = ErrorScale::limited(&fitted, &regression);
        assert!(!scale.has(true) && !scale.has(false));
        assert_eq!(scale.std(Axis::Y, Variable::V, 0.1), None);
        let own = ErrorScale::own(&fitted, &NONE);
        assert!(own.has(true) && own.has(false));
    }
}
