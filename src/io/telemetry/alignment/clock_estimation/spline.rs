//! A uniform cubic B-spline: the band-limited signal that two recordings share.
//!
//! The signal is
//!     s(t) = sum_k c_k B((t - t_0)/h - k)                                                             (1)
//! with knots h apart; at a time the four splines that are not zero, with their first two derivatives. Outside of its range the
//! outermost piece goes on. Its band ends at about 1/(2 h).
//! Source: C. de Boor, A Practical Guide to Splines, 1978, for equal knots.

/// Knots.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct SplineKnots {
    pub(super) from_s: f64,
    /// h, s.
    pub(super) step_s: f64,
    pub(super) intervals: usize,
}

/// What four splines are at one time: the first of them, values, first and second derivatives (1/s, 1/s^2).
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct SplineRow {
    pub(super) first: usize,
    pub(super) value: [f64; 4],
    pub(super) slope: [f64; 4],
    pub(super) curvature: [f64; 4],
}

impl SplineKnots {
    /// Knots that cover this range, s.
    pub(super) fn over(from_s: f64, to_s: f64, step_s: f64) -> Self {
        SplineKnots { from_s, step_s, intervals: (libm::ceil((to_s - from_s) / step_s) as usize).max(1) }
    }

    /// How many coefficients there are.
    pub(super) fn coefficients(&self) -> usize {
        self.intervals + 3
    }

    /// The splines at a time.
    pub(super) fn at(&self, time_s: f64) -> SplineRow {
        let place = (time_s - self.from_s) / self.step_s;
        let first = (libm::floor(place).max(0.0) as usize).min(self.intervals - 1);
        let (x, h) = (place - first as f64, self.step_s);
        let y = 1.0 - x;
        SplineRow {
            first,
            value: [
                y * y * y / 6.0,
                (3.0 * x * x * x - 6.0 * x * x + 4.0) / 6.0,
                (3.0 * y * y * y - 6.0 * y * y + 4.0) / 6.0,
                x * x * x / 6.0,
            ],
            slope: [-0.5 * y * y, 1.5 * x * x - 2.0 * x, -1.5 * y * y + 2.0 * y, 0.5 * x * x].map(|slope| slope / h),
            curvature: [y, 3.0 * x - 2.0, 3.0 * y - 2.0, x].map(|curvature| curvature / (h * h)),
        }
    }
}

impl SplineRow {
    /// Sum of four coefficients with these weights.
    pub(super) fn of(&self, weights: &[f64; 4], coefficients: &[f64]) -> f64 {
        let four = coefficients.get(self.first..self.first + 4).unwrap_or(&[]);
        weights.iter().zip(four).map(|(weight, c)| weight * c).sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn coefficients_of_a_square_give_the_square_and_its_derivatives() {
        let knots = SplineKnots::over(2.0, 5.0, 0.5);
        assert_eq!((knots.intervals, knots.coefficients()), (6, 9));
        // Of t^2 the coefficients are x_k^2 - h^2/3 at the centres x_k = 2 + 0.5 (k - 1) of the splines.
        let c: Vec<f64> = (0..9).map(|k| 2.0 + 0.5 * (f64::from(k) - 1.0)).map(|x| x * x - 0.25 / 3.0).collect();
        for time_s in [2.0, 2.3, 3.77, 4.5, 5.0] {
            let row = knots.at(time_s);
            let found = [row.of(&row.value, &c), row.of(&row.slope, &c), row.of(&row.curvature, &c)];
            for (found, wanted) in found.into_iter().zip([time_s * time_s, 2.0 * time_s, 2.0]) {
                assert!((found - wanted).abs() < 1e-12, "{time_s}: {found} {wanted}");
            }
        }
    }
}
