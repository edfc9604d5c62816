//! The paper's own story on flights of its models: Dutch roll against flight path.
#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    clippy::print_stderr,
    reason = "a test fails by panicking and says what it measured"
)]

#[path = "../support/manoeuvre.rs"]
mod manoeuvre;
#[path = "../support/paper_cases.rs"]
mod paper_cases;
#[path = "../support/program.rs"]
mod program;

mod collapse;
mod diagnosis;
mod flown;
mod monte_carlo;
mod path;
mod story;
