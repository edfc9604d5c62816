//! Signals: a channel as a function of time, and several channels on one mesh of time.
//!
//! In: samples in order of time. Out: series, readings at given times, piecewise linear functions.
//! Refused: times that do not increase.

pub mod gap_union;
pub mod gyro_coverage;
pub mod piecewise_linear;
pub mod readings;
pub mod series;
pub mod trace;
pub mod white_noise;

/// An interval without samples that nothing is carried over, s.
pub const GAP_S: f64 = 0.5;
