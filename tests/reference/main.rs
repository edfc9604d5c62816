//! Published values, with their provenance: what we compute from the same data comes out the same.
#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    clippy::print_stderr,
    reason = "a test fails by panicking, and says aloud what it skipped"
)]

mod attas;
mod attas_output_error;
mod level1_puma;
mod puma_matrices;
mod twin_otter;

#[path = "../support/program.rs"]
mod program;

#[path = "../support/puma.rs"]
mod puma;
