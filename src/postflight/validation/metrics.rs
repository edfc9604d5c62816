//! Measures of a prediction y of a measured output z, e = z - y: rms error, Theil's coefficient, variance accounted for.
//!
//! Consumes pairs of z and y; produces
//!     rms = sqrt(mean e^2)     VAF = 1 - var(e)/var(z)                                                 (1)
//!     TIC = rms(e)/(rms(z) + rms(y))     0 exact, 1 worst                                              (2)
//! Source: H. Theil, Economic Forecasts and Policy, 1961, for (2).
//! Returns NaN for the VAF of an output that does not move, and for all of no samples.

/// Mean squares and variances, from which (1) and (2) follow.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct PredictionMoments {
    pub error_square: f64,
    pub measured_square: f64,
    pub predicted_square: f64,
    pub error_variance: f64,
    pub measured_variance: f64,
}

impl PredictionMoments {
    /// Of pairs of measured and predicted values; variances about the mean, in two passes.
    pub(crate) fn of(pairs: impl Iterator<Item = (f64, f64)> + Clone) -> Self {
        let count = pairs.clone().count() as f64;
        let mean = |of: &dyn Fn(f64, f64) -> f64| pairs.clone().map(|(z, y)| of(z, y)).sum::<f64>() / count;
        let (mean_z, mean_e) = (mean(&|z, _| z), mean(&|z, y| z - y));
        let error_variance = mean(&|z, y| (z - y - mean_e) * (z - y - mean_e));
        PredictionMoments {
            error_square: error_variance + mean_e * mean_e,
            measured_square: mean(&|z, _| z * z),
            predicted_square: mean(&|_, y| y * y),
            error_variance,
            measured_variance: mean(&|z, _| (z - mean_z) * (z - mean_z)),
        }
    }

    pub(crate) fn rms(&self) -> f64 {
        libm::sqrt(self.error_square)
    }

    pub(crate) fn theil(&self) -> f64 {
        self.rms() / (libm::sqrt(self.measured_square) + libm::sqrt(self.predicted_square))
    }

    pub(crate) fn vaf(&self) -> f64 {
        if self.measured_variance > 0.0 { 1.0 - self.error_variance / self.measured_variance } else { f64::NAN }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_measures_are_those_computed_by_hand() {
        // z = 1, 3, y = 0, 4: e = 1, -1; rms(z) = sqrt(5), rms(y) = sqrt(8), var(z) = 1.
        let moments = PredictionMoments::of([(1.0, 0.0), (3.0, 4.0)].into_iter());
        assert!((moments.rms() - 1.0).abs() < 1e-15 && moments.vaf().abs() < 1e-15, "{moments:?}");
        assert!((moments.theil() - 1.0 / (5f64.sqrt() + 8f64.sqrt())).abs() < 1e-15);
        let still = PredictionMoments::of([(2.0, 1.0), (2.0, 1.0)].into_iter());
        assert!(still.vaf().is_nan() && (still.rms() - 1.0).abs() < 1e-15);
        assert!(PredictionMoments::of(core::iter::empty()).rms().is_nan());
    }
}
