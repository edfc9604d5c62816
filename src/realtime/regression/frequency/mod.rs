//! Frequency domain: the second estimator, beside least squares over time, from transforms in a band.
//!
//! In: the regression's signals on their grid, as deviations from trim, and the terms of each equation. Out: the same terms
//! estimated in the band alone, with standard errors.
//! Assumed: signals straight between instants; the equation's error white within the band.
//! Refused: terms that are collinear in the band.

pub mod band;
pub mod estimate;
pub mod transforms;
