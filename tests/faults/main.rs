//! The fault matrix: broken inputs give a clear end, never a panic and never a guess.
#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    clippy::print_stderr,
    reason = "a test fails by panicking, and says aloud what it skipped"
)]

#[path = "../support/program.rs"]
mod program;

mod design;
mod diagnose;
mod flight_condition;
mod inspect;
mod instrument_files;
mod level1_files;
mod mavlink;
mod model_files;
mod multirate;
mod replay;
mod run_files;
mod silence;
