//! Sideslip tells, while the aircraft is still in the air, how stable it is.
#![cfg_attr(not(any(feature = "std", test)), no_std)]

pub mod dynamics;
#[cfg(feature = "cli")]
pub mod error;
pub mod flight;
pub mod guide;
#[cfg(feature = "std")]
pub mod io;
#[cfg(feature = "std")]
pub mod live;
pub mod num;
#[cfg(feature = "std")]
pub mod postflight;
pub mod realtime;
#[cfg(feature = "std")]
pub mod simulation;
