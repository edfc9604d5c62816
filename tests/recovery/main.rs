//! Recovery: a simulated aircraft whose derivatives are known gives them back inside their own standard errors.
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

mod pilot;
mod puma_100kn;
mod tlog;
