//! The guide: pages for people who read or change this code. There is nothing to call here.
//!
//! [`notation`] lists every symbol once, [`decisions`] says what was decided and why, [`imports`] which module may import
//! which (a test reads that page), [`contributing`] where things are and what to run, [`usage`] what the commands can do,
//! [`json`] the documents for programs, and
//! [`standards`] which clauses of IRIG 106 and MAVLink are implemented (a test reads that page too).

#[doc = include_str!("notation.md")]
pub mod notation {}

#[doc = include_str!("decisions.md")]
pub mod decisions {}

#[doc = include_str!("imports.md")]
pub mod imports {}

#[doc = include_str!("contributing.md")]
pub mod contributing {}

#[doc = include_str!("use.md")]
pub mod usage {}

#[doc = include_str!("json.md")]
pub mod json {}

#[doc = include_str!("standards.md")]
pub mod standards {}
