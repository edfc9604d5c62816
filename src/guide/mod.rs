//! The guide: pages for people who read or change this code. There is nothing to call here.
//!
//! [`notation`] lists every symbol once, [`decisions`] says what was decided and why, [`imports`] which module may import
//! which (a test reads that page), and [`contributing`] where to look and what to run.

#[doc = include_str!("notation.md")]
pub mod notation {}

#[doc = include_str!("decisions.md")]
pub mod decisions {}

#[doc = include_str!("imports.md")]
pub mod imports {}

#[doc = include_str!("contributing.md")]
pub mod contributing {}
