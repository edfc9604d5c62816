//! Dual numbers: a value and its exact partial derivatives, by the rules of differentiation alone.
//!
//! Forward mode with a vector of partials, one for each of the filter's states. Written from the rules, without
//! the program's own derivatives, so that it can judge them.

#![expect(clippy::suspicious_arithmetic_impl, reason = "the rules of a product and a quotient are sums and products")]

use std::ops::{Add, Div, Mul, Neg, Sub};

/// Partials: the states of the filter.
pub(crate) const PARTIALS: usize = 25;

/// A value with its partials.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Dual {
    /// The value.
    pub(crate) value: f64,
    /// Its partial derivatives.
    pub(crate) partials: [f64; PARTIALS],
}

impl Dual {
    /// A number that depends on nothing.
    pub(crate) fn constant(value: f64) -> Self {
        Dual { value, partials: [0.0; PARTIALS] }
    }

    /// The independent variable number `which`.
    pub(crate) fn variable(value: f64, which: usize) -> Self {
        let mut partials = [0.0; PARTIALS];
        partials[which] = 1.0;
        Dual { value, partials }
    }

    /// f(self), with f and f' at the value.
    fn chain(self, value: f64, slope: f64) -> Self {
        Dual { value, partials: self.partials.map(|partial| slope * partial) }
    }

    /// Sine.
    pub(crate) fn sin(self) -> Self {
        self.chain(self.value.sin(), self.value.cos())
    }

    /// Cosine.
    pub(crate) fn cos(self) -> Self {
        self.chain(self.value.cos(), -self.value.sin())
    }

    /// Tangent.
    pub(crate) fn tan(self) -> Self {
        self.sin() / self.cos()
    }

    /// Square root.
    pub(crate) fn sqrt(self) -> Self {
        let root = self.value.sqrt();
        self.chain(root, 0.5 / root)
    }

    /// Arc sine.
    pub(crate) fn asin(self) -> Self {
        self.chain(self.value.asin(), 1.0 / (1.0 - self.value * self.value).sqrt())
    }

    /// The angle of the point (x, self).
    pub(crate) fn atan2(self, x: Dual) -> Self {
        let square = x.value * x.value + self.value * self.value;
        let partials = std::array::from_fn(|i| (x.value * self.partials[i] - self.value * x.partials[i]) / square);
        Dual { value: self.value.atan2(x.value), partials }
    }
}

impl Add for Dual {
    type Output = Dual;
    fn add(self, other: Dual) -> Dual {
        let partials = std::array::from_fn(|i| self.partials[i] + other.partials[i]);
        Dual { value: self.value + other.value, partials }
    }
}

impl Neg for Dual {
    type Output = Dual;
    fn neg(self) -> Dual {
        self.chain(-self.value, -1.0)
    }
}

impl Sub for Dual {
    type Output = Dual;
    fn sub(self, other: Dual) -> Dual {
        self + -other
    }
}

impl Mul for Dual {
    type Output = Dual;
    fn mul(self, other: Dual) -> Dual {
        let partials = std::array::from_fn(|i| self.partials[i] * other.value + self.value * other.partials[i]);
        Dual { value: self.value * other.value, partials }
    }
}

impl Div for Dual {
    type Output = Dual;
    fn div(self, other: Dual) -> Dual {
        let value = self.value / other.value;
        let partials = std::array::from_fn(|i| (self.partials[i] - value * other.partials[i]) / other.value);
        Dual { value, partials }
    }
}

/// The type itself against difference quotients of plain functions.
#[test]
fn partials_are_difference_quotients() {
    let point = [0.7, -0.4];
    let check = |name: &str, dual: &dyn Fn(Dual, Dual) -> Dual, plain: &dyn Fn(f64, f64) -> f64| {
        let at = dual(Dual::variable(point[0], 0), Dual::variable(point[1], 18));
        assert!((at.value - plain(point[0], point[1])).abs() < 1e-15, "{name}");
        let step = 1e-6;
        let by_first = (plain(point[0] + step, point[1]) - plain(point[0] - step, point[1])) / (2.0 * step);
        let by_second = (plain(point[0], point[1] + step) - plain(point[0], point[1] - step)) / (2.0 * step);
        assert!((at.partials[0] - by_first).abs() < 1e-9 && (at.partials[18] - by_second).abs() < 1e-9, "{name}");
        assert!(at.partials[1..18].iter().all(|&partial| partial == 0.0), "{name}");
    };
    check("product", &|a, b| a * b, &|a, b| a * b);
    check("quotient", &|a, b| a / b, &|a, b| a / b);
    check("difference", &|a, b| a - b + a, &|a, b| a - b + a);
    check("sine and cosine", &|a, b| a.sin() * b.cos(), &|a, b| a.sin() * b.cos());
    check("tangent", &|a, b| (a + b).tan(), &|a, b| (a + b).tan());
    check("root", &|a, b| (a - b).sqrt(), &|a, b| (a - b).sqrt());
    check("arc sine", &|a, b| (a * b).asin(), &|a, b| (a * b).asin());
    check("angle", &|a, b| a.atan2(b), &|a, b| a.atan2(b));
    check("constant", &|a, _| a + Dual::constant(2.0), &|a, _| a + 2.0);
}
