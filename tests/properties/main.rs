//! What must hold for every input: round trips, order, symmetry.
#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    reason = "a test fails by panicking, and says aloud what it skipped"
)]

mod run_files;
