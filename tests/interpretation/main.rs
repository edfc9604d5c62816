//! Preliminary interpretation: simulated flights whose answers are known, and real recordings with published ones.
#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    clippy::print_stderr,
    reason = "a test fails by panicking and says what it measured"
)]

#[path = "../support/puma.rs"]
mod puma;

mod flights;
mod recordings;
