//! Polynomials of one variable on an interval: value, sign changes, inverse where monotone.
//!
//! Coefficients stand from the constant upwards.

/// The value (Horner's rule).
#[must_use]
#[inline]
pub(super) fn value(coefficients: &[f64], x: f64) -> f64 {
    coefficients.iter().rev().fold(0.0, |sum, coefficient| sum * x + coefficient)
}

/// Whether the polynomial rises or falls all the way from `low` to `high`.
pub(super) fn is_monotone(coefficients: &[f64], low: f64, high: f64) -> bool {
    let slope = derivative(coefficients);
    slope.iter().any(|coefficient| coefficient.abs() > 0.0) && sign_changes(&slope, low, high).is_empty()
}

/// Places inside the interval where the sign changes. Between places where its derivative changes sign a polynomial is monotone
/// and changes sign at most once.
fn sign_changes(coefficients: &[f64], low: f64, high: f64) -> Vec<f64> {
    if coefficients.len() < 2 {
        return Vec::new();
    }
    let mut ends = sign_changes(&derivative(coefficients), low, high);
    ends.push(high);
    let mut from = low;
    let mut found = Vec::new();
    for to in ends {
        if value(coefficients, from) * value(coefficients, to) < 0.0 {
            found.push(bisect(|x| value(coefficients, x), from, to));
        }
        from = to;
    }
    found
}

/// Where a function that is monotone between `low` and `high`, with different signs there, is zero: to the last bit.
pub(super) fn bisect(function: impl Fn(f64) -> f64, mut low: f64, mut high: f64) -> f64 {
    let falling = function(low) > 0.0;
    loop {
        let middle = low / 2.0 + high / 2.0;
        if middle <= low || middle >= high {
            return if function(low).abs() <= function(high).abs() { low } else { high };
        }
        if (function(middle) > 0.0) == falling {
            low = middle;
        } else {
            high = middle;
        }
    }
}

fn derivative(coefficients: &[f64]) -> Vec<f64> {
    coefficients.iter().skip(1).zip(1..).map(|(coefficient, power)| coefficient * f64::from(power)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sign_changes_are_the_roots_of_odd_order() {
        // (x - 1)(x - 2)(x - 3)(x + 4)
        let four = [24.0, -38.0, 13.0, 2.0, -1.0].map(|c: f64| -c);
        let roots = sign_changes(&four, -10.0, 10.0);
        assert!(roots.iter().zip([-4.0, 1.0, 2.0, 3.0]).all(|(found, root)| (found - root).abs() < 1e-12), "{roots:?}");
        assert_eq!(roots.len(), 4);
        // (x - 1)^2 touches zero, x^3 crosses it.
        assert!(sign_changes(&[1.0, -2.0, 1.0], -5.0, 5.0).is_empty());
        assert_eq!(sign_changes(&[0.0, 0.0, 0.0, 1.0], -5.0, 4.0).len(), 1);
    }

    #[test]
    fn monotone_is_told_from_what_turns_inside() {
        assert!(is_monotone(&[3.0, -2.0], -1e300, 1e300));
        assert!(is_monotone(&[0.0, 0.0, 1.0], 0.0, 4095.0) && !is_monotone(&[0.0, 0.0, 1.0], -1.0, 4095.0));
        assert!(is_monotone(&[0.0, 0.0, 0.0, 1.0], -5.0, 5.0));
        assert!(!is_monotone(&[7.0], 0.0, 1.0) && !is_monotone(&[], 0.0, 1.0));
        // Turns twice within a hundredth of the interval.
        let narrow = [0.0, 1.0 - 1e-5, -1.0, 1.0 / 3.0];
        assert!(!is_monotone(&narrow, 0.0, 2.0));
    }
}
