//! Estimation: samples become states, and smoothed signals for the regression.
//!
//! In: samples in order of time, whatever channels they carry. Out: the filtered state with its standard deviations, the
//! innovations of every aid, smoothed signals on the regression grid, the run's trim, events.
//! Assumed: a rigid body over a flat earth, in still air or in gusts that are the same over the whole aircraft; instruments at
//! the positions that the run declares.
//! Refused: a number that no instrument observes. A missing accelerometer or aid widens the uncertainty and is an event.

pub mod admission;
pub mod aid;
mod aid_kind;
mod centre_of_mass;
pub mod config;
pub mod consistency;
pub mod delay_line;
pub mod ekf;
pub mod estimator;
#[cfg(feature = "std")]
pub mod fixed_interval;
pub mod fixed_lag;
pub mod gust_velocity;
pub mod health;
pub mod latest;
pub mod noise;
pub mod noise_bank;
pub mod process;
pub mod record;
pub mod screening;
pub mod state_variable;
pub mod trim;
pub mod vibration;
