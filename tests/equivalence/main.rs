//! Two ways to the same answer: recursive and batch, sequential and joint, firmware and host, today and again.
#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    clippy::print_stderr,
    unreachable_pub,
    reason = "a test fails by panicking, and says aloud what it measured; the manoeuvre is shared with a library"
)]

#[path = "../support/allocations.rs"]
mod allocations;
#[path = "../../firmware-profile/src/fingerprint.rs"]
mod fingerprint;
#[path = "../support/manoeuvre.rs"]
mod flights;
#[path = "../../firmware-profile/src/manoeuvre.rs"]
mod manoeuvre;
#[path = "../support/program.rs"]
mod program;
#[path = "../support/puma.rs"]
mod puma;
#[path = "../support/short_period.rs"]
mod short_period;
#[path = "../support/uniform.rs"]
mod uniform;

mod allocation;
mod determinism;
mod error_autocovariance;
mod filter_error;
mod firmware;
mod frequency;
mod output_error;
mod recursive_batch;
mod replay;
mod sequential_joint;
mod smoothed_file;
mod smoothers;
mod structure;
