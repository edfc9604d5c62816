//! The linear relation of two clocks, with the uncertainty of its numbers.
//!
//! Our time of a time of theirs is
//!     t_ours = offset + (1 + drift) t_theirs                                                          (1)
//! kept about a reference time r of their clock, in the middle of what both recorded, where the two numbers hardly depend on each
//! other and large clock times (since 1970) lose no digits:
//!     t_ours = a + (1 + d) (t_theirs - r),   offset = a - (1 + d) r,   drift = d                      (2)
//!     var t_ours = var a + 2 x cov(a, d) + x^2 var d,   x = t_theirs - r                              (3)
//! A relation that was given has no standard errors. Refused: numbers that are not finite, a drift of -1 or less.

use std::fmt;

/// Variances and covariance of a, s^2, s and d.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ClockCovariance {
    /// Of a, s^2.
    pub time_var: f64,
    /// Of a and d, s.
    pub time_drift_cov: f64,
    /// Of d.
    pub drift_var: f64,
}

/// From their clock to ours.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ClockRelation {
    reference_s: f64,
    at_reference_s: f64,
    drift: f64,
    covariance: Option<ClockCovariance>,
}

impl ClockRelation {
    /// (1) as it was given, without standard errors; `None` where the numbers are no relation.
    pub fn given(offset_s: f64, drift: f64) -> Option<Self> {
        ClockRelation::about(0.0, offset_s, drift, None)
    }

    /// (2) with its uncertainty; `None` where the numbers are no relation.
    pub fn about(reference_s: f64, at_reference_s: f64, drift: f64, covariance: Option<ClockCovariance>) -> Option<Self> {
        let is_relation = reference_s.is_finite() && at_reference_s.is_finite() && drift.is_finite() && drift > -1.0;
        is_relation.then_some(ClockRelation { reference_s, at_reference_s, drift, covariance })
    }

    /// Our time of a time of theirs, s.
    pub fn ours_s(&self, theirs_s: f64) -> f64 {
        let since_s = theirs_s - self.reference_s;
        self.at_reference_s + since_s + self.drift * since_s
    }

    /// Their time of a time of ours, s.
    pub fn theirs_s(&self, ours_s: f64) -> f64 {
        self.reference_s + (ours_s - self.at_reference_s) / (1.0 + self.drift)
    }

    /// Standard error of our time of a time of theirs by (3), s; `None` of a relation that was given.
    pub fn std_at_s(&self, theirs_s: f64) -> Option<f64> {
        let ClockCovariance { time_var, time_drift_cov, drift_var } = self.covariance?;
        let x = theirs_s - self.reference_s;
        Some(libm::sqrt((time_var + 2.0 * x * time_drift_cov + x * x * drift_var).max(0.0)))
    }

    /// Offset of (1), s: our time where their clock is zero.
    pub fn offset_s(&self) -> f64 {
        self.ours_s(0.0)
    }

    /// Its standard error, s.
    pub fn offset_std_s(&self) -> Option<f64> {
        self.std_at_s(0.0)
    }

    /// Covariance of offset and drift of (1), s.
    pub fn offset_drift_cov(&self) -> Option<f64> {
        self.covariance.map(|of| of.time_drift_cov - self.reference_s * of.drift_var)
    }

    /// How much faster our clock counts than theirs, as a part of one.
    pub fn drift(&self) -> f64 {
        self.drift
    }

    /// Its standard error.
    pub fn drift_std(&self) -> Option<f64> {
        self.covariance.map(|of| libm::sqrt(of.drift_var.max(0.0)))
    }

    /// r of (2), s.
    pub fn reference_s(&self) -> f64 {
        self.reference_s
    }

    /// a of (2), s.
    pub fn at_reference_s(&self) -> f64 {
        self.at_reference_s
    }

    /// Covariance of a and d; `None` of a relation that was given.
    pub fn covariance(&self) -> Option<ClockCovariance> {
        self.covariance
    }
}

impl fmt::Display for ClockRelation {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let ppm = 1e6 * self.drift;
        match (self.std_at_s(self.reference_s), self.drift_std()) {
            (Some(time_std_s), Some(drift_std)) => write!(
                f,
                "t = {:.6} s +- {time_std_s:.2e} s where theirs is {:.6} s, drift {ppm:+.3} +- {:.3} ppm",
                self.at_reference_s,
                self.reference_s,
                1e6 * drift_std
            ),
            _ => write!(f, "t = {:.6} s + (1 {ppm:+.3} ppm) theirs, as given", self.offset_s()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn offset_and_covariance_at_zero_are_those_at_the_reference_carried_there() {
        let covariance = ClockCovariance { time_var: 4e-6, time_drift_cov: 1e-9, drift_var: 1e-12 };
        let relation = ClockRelation::about(100.0, 112.0, 5e-5, Some(covariance)).unwrap();
        // 112 - 1.00005 x 100, and J C J' with J = (1, -100) by hand: 4e-6 - 2e-7 + 1e-8.
        assert!((relation.offset_s() - 11.995).abs() < 1e-12);
        assert!((relation.offset_std_s().unwrap().powi(2) - 3.81e-6).abs() < 1e-15);
        assert!((relation.offset_drift_cov().unwrap() - (1e-9 - 1e-10)).abs() < 1e-20);
        assert!((relation.theirs_s(relation.ours_s(321.5)) - 321.5).abs() < 1e-12);
        assert!((relation.ours_s(200.0) - (relation.offset_s() + 1.00005 * 200.0)).abs() < 1e-12);
    }

    #[test]
    fn what_is_given_has_no_standard_error_and_nonsense_is_no_relation() {
        let given = ClockRelation::given(12.5, 1e-4).unwrap();
        assert_eq!((given.offset_std_s(), given.drift_std(), given.std_at_s(5.0)), (None, None, None));
        assert!((given.ours_s(1000.0) - 1012.6).abs() < 1e-9);
        assert_eq!(format!("{given}"), "t = 12.500000 s + (1 +100.000 ppm) theirs, as given");
        assert!(ClockRelation::given(f64::NAN, 0.0).is_none() && ClockRelation::given(0.0, -1.0).is_none());
        // Microseconds since 1970 keep theirs.
        let unix = ClockRelation::about(1.7e9, 10.0, 0.0, None).unwrap();
        assert!((unix.ours_s(1.7e9 + 0.001) - 10.001).abs() < 3e-7);
    }
}
