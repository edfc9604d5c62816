//! Regression: smoothed signals become stability and control derivatives with honest standard errors.
//!
//! In: smoothed signals on a uniform grid, the run's trim. Out: six equations with their terms, R2, F, standard errors as in
//! the paper and corrected for coloured residuals, and a status.
//! Assumed: forces and moments linear in deviations from trim; every signal through the same smoothing kernel.
//! Refused: a number without excitation, without the instruments it needs, or from rates below 8 Hz.

pub mod candidate;
pub mod coloured_errors;
pub mod config;
pub mod error_autocovariance;
pub mod excitation;
pub mod frequency;
pub mod information;
pub mod record;
pub mod recursive;
pub mod status;
pub mod stepwise;
