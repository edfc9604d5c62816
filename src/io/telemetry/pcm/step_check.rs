//! Samples too far from those beside them: what wrong bits make that neither parity nor limits tell.
//!
//! Consumes the values of one parameter in order of time; tells of each whether it is within the largest step from the last one
//! that was. One that is not is held against the next: where that follows it, the level has changed and goes on from there;
//! where it follows the last good one, the sample between stood alone. So a wrong word costs itself, a true jump its first
//! sample, and nothing waits for the next sample. The first sample is taken as it comes. Nothing is allocated.

/// The last values of a parameter.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct StepCheck {
    good: Option<f64>,
    /// The last one, where it was too far away.
    apart: Option<f64>,
}

impl StepCheck {
    /// Whether the value is no further than `step` from the last good one, or from the one apart before it.
    pub fn follows(&mut self, value: f64, step: f64) -> bool {
        let near = |other: Option<f64>| other.is_some_and(|other| libm::fabs(value - other) <= step);
        let follows = self.good.is_none() || near(self.good) || near(self.apart);
        if follows {
            self.good = Some(value);
            self.apart = None;
        } else {
            self.apart = Some(value);
        }
        follows
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn told(values: &[f64]) -> Vec<bool> {
        let mut check = StepCheck::default();
        values.iter().map(|value| check.follows(*value, 1.0)).collect()
    }

    #[test]
    fn one_that_stands_alone_is_told_and_a_jump_costs_one() {
        assert_eq!(told(&[0.0, 0.5, 9.0, 0.6, 1.6]), [true, true, false, true, true]);
        assert_eq!(told(&[0.0, 5.0, 5.5, 5.0, 0.0, 0.1]), [true, false, true, true, false, true]);
        // Two wrong ones in a row that do not agree; then one that begins wrong.
        assert_eq!(told(&[0.0, 9.0, -9.0, 0.2]), [true, false, false, true]);
        assert_eq!(told(&[9.0, 0.0, 0.1, 0.2]), [true, false, true, true]);
    }
}
