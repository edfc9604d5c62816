//! Identify: derivatives and modes from whole runs, against recordings with known answers and flights whose truth is known.
#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    clippy::print_stderr,
    reason = "a test fails by panicking and says what it measured"
)]

#[path = "../support/program.rs"]
mod program;

mod banked;
mod calls;
mod flights;
mod frequency;
mod instruments;
mod live;
mod recordings;
