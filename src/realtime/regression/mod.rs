//! Regression: stability and control derivatives from smoothed signals, with standard errors for coloured residuals.
//!
//! In: smoothed signals on a uniform grid, the run's trim. Out: six equations with their terms, R2, F, standard errors for white
//! and for coloured residuals, and a status.
//! Assumed: forces and moments linear in deviations from trim; every signal through the same smoothing kernel.
//! Refused: a number without excitation, without the instruments it needs, or from rates below 8 Hz.

pub mod candidate;
pub mod coloured_errors;
pub mod config;
pub mod curvature;
pub mod endogeneity;
pub mod error_autocovariance;
pub mod excitation;
pub mod feedback;
pub mod frequency;
pub mod information;
pub mod instrumental;
#[cfg(test)]
mod instrumental_tests;
pub mod record;
pub mod recursive;
pub mod required_aids;
pub mod status;
pub mod stepwise;
