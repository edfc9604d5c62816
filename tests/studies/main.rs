//! Studies of the method on simulated data, whose truth is known: numbers and pictures, see README.md.
#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    clippy::print_stderr,
    reason = "a study stops where it cannot go on, and says what it measured"
)]

#[path = "../support/manoeuvre.rs"]
mod manoeuvre;
#[path = "../support/puma.rs"]
mod puma;

mod amplitude;
mod bound;
mod budget;
mod collapse;
mod convergence;
mod flown;
mod honesty;
mod lag;
mod score;
mod sheet;
mod steps;
