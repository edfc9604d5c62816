//! Sideslip tells, while the aircraft is still in the air, how stable it is.
#![cfg_attr(not(any(feature = "std", test)), no_std)]

pub mod estimation;
pub mod flight;
pub mod guide;
pub mod modes;
pub mod num;
pub mod outputs;
pub mod pipeline;
pub mod regression;
pub mod telemetry;

#[cfg(feature = "std")]
pub mod bus;
#[cfg(feature = "std")]
pub mod diagnosis;
#[cfg(feature = "std")]
pub mod error;
#[cfg(feature = "std")]
pub mod identification;
#[cfg(feature = "std")]
pub mod simulation;
