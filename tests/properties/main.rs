//! What must hold for every input: round trips, order, symmetry.
#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    clippy::float_cmp,
    clippy::print_stderr,
    reason = "a test fails by panicking, and says aloud what it measured"
)]

#[path = "../support/uniform.rs"]
mod uniform;

mod admission;
mod any_sample;
mod covariance;
mod filter_covariance;
mod kernel;
mod mavlink_frames;
mod missing;
mod pipeline;
mod run_files;
