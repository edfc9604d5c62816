//! Standard errors of an output-error fit whose assumptions do not hold, scaled to the regression's.
//!
//! Output error assumes that nothing but the controls and the initial state moves the aircraft. Where gusts or unmodelled
//! dynamics do (residuals far from white), or the search has not reached the minimum, its covariance is not that of its errors,
//! corrected for colour or not. The regression's standard errors, of the same samples, cover both. In each plane they give
//!     f^2 = max(1, mean of (s_regression/s_output_error)^2 over the derivatives of both),   C <- D C D                     (1)
//! with D the diagonal matrix of the f, so that correlations are kept. A plane of which the regression has no number in a moment
//! equation has none here either.

use crate::flight::derivative::{AXES, Axis, VARIABLES, Variable};

/// Factor f of (1) by plane: lateral (Y, L, N), longitudinal (X, Z, M). `None`: the plane has no number.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct ErrorScale {
    lateral: Option<f64>,
    longitudinal: Option<f64>,
}

impl ErrorScale {
    /// The errors as they are.
    pub(crate) const ONE: ErrorScale = ErrorScale { lateral: Some(1.0), longitudinal: Some(1.0) };

    /// From the derivatives of the fit with their standard errors, and the regression's standard errors, NaN where none.
    pub(crate) fn new(fitted: &[((Axis, Variable), f64)], regression: &[[f32; VARIABLES]; AXES]) -> Self {
        let of_plane = |lateral: bool| {
            let (mut sum, mut count, mut moments) = (0.0, 0_u32, 0_u32);
            for &((axis, variable), std) in fitted.iter().filter(|one| one.0.0.is_lateral() == lateral) {
                let row = regression.get(axis.index());
                let ratio = row.and_then(|row| row.get(variable.index())).map_or(f64::NAN, |&other| f64::from(other) / std);
                if ratio.is_finite() {
                    sum += ratio * ratio;
                    count += 1;
                    moments += u32::from(!axis.is_force());
                }
            }
            (moments > 0).then(|| libm::sqrt((sum / f64::from(count)).max(1.0)))
        };
        ErrorScale { lateral: of_plane(true), longitudinal: of_plane(false) }
    }

    /// f of an equation's plane.
    pub(crate) fn of(&self, axis: Axis) -> Option<f64> {
        self.of_plane(axis.is_lateral())
    }

    /// f of a plane.
    pub(crate) fn of_plane(&self, lateral: bool) -> Option<f64> {
        if lateral { self.lateral } else { self.longitudinal }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const NONE: [[f32; VARIABLES]; AXES] = [[f32::NAN; VARIABLES]; AXES];

    #[test]
    fn the_errors_of_a_plane_are_on_average_those_of_the_regression() {
        let mut regression = NONE;
        regression[Axis::N.index()][Variable::V.index()] = 3.0;
        regression[Axis::L.index()][Variable::P.index()] = 8.0;
        regression[Axis::M.index()][Variable::Q.index()] = 0.1;
        let fitted = [
            ((Axis::N, Variable::V), 1.0),
            ((Axis::L, Variable::P), 2.0),
            // No number of the regression: counts for nothing.
            ((Axis::N, Variable::R), 1e-6),
            ((Axis::M, Variable::Q), 1.0),
        ];
        let scale = ErrorScale::new(&fitted, &regression);
        // sqrt((3^2 + 4^2)/2), and never below 1.
        assert!((scale.of(Axis::N).unwrap() - 12.5_f64.sqrt()).abs() < 1e-12, "{scale:?}");
        assert_eq!(scale.of(Axis::Y), scale.of(Axis::N));
        assert_eq!(scale.of(Axis::M), Some(1.0));
    }

    #[test]
    fn where_the_regression_has_no_moment_there_is_no_number() {
        let mut regression = NONE;
        regression[Axis::Y.index()][Variable::V.index()] = 0.1;
        let fitted = [((Axis::Y, Variable::V), 0.1), ((Axis::N, Variable::V), 0.01), ((Axis::M, Variable::Q), 0.01)];
        let scale = ErrorScale::new(&fitted, &regression);
        assert_eq!(Axis::ALL.map(|axis| scale.of(axis)), [None; AXES]);
    }
}
