//! Consistency: errors are as large as the filter says, over many seeded flights.
#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    clippy::print_stderr,
    reason = "a test fails by panicking and says what it measured"
)]

#[path = "../support/manoeuvre.rs"]
mod manoeuvre;
#[path = "../support/puma.rs"]
mod puma;
#[path = "../support/short_period.rs"]
mod short_period;
#[path = "../support/uniform.rs"]
mod uniform;

mod biases;
mod filter;
mod gusts;
mod instruments;
mod output_error;
mod smoother;
