//! Signals: a channel as a function of time, and several channels on one mesh of time.
//!
//! In: samples in order of time. Out: series, readings at given times, piecewise linear functions.
//! Refused: times that do not increase.

pub mod gyro_coverage;
pub mod piecewise_linear;
pub mod readings;
pub mod series;
pub mod trace;
pub mod white_noise;
