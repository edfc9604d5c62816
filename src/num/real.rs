//! The arithmetic that a factorisation requires of its scalar: closed under + - * /, ordered, with a test for infinities and NaN.

use core::ops::{Add, AddAssign, Div, Mul, Neg, Sub, SubAssign};

/// The scalar of a factorisation: `f64` on every target, `f32` to prove how much room there is.
pub trait Real:
    Copy
    + PartialOrd
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
    + AddAssign
    + SubAssign
{
    /// 0.
    const ZERO: Self;
    /// 1.
    const ONE: Self;
    /// Whether it is neither infinite nor NaN.
    fn finite(self) -> bool;
}

impl Real for f64 {
    const ZERO: f64 = 0.0;
    const ONE: f64 = 1.0;
    fn finite(self) -> bool {
        self.is_finite()
    }
}

impl Real for f32 {
    const ZERO: f32 = 0.0;
    const ONE: f32 = 1.0;
    fn finite(self) -> bool {
        self.is_finite()
    }
}
