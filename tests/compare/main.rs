//! Compare: a model beside flights, simulated ones whose answer is known and real ones, and what is gained by an extended model;
//! the page of a diagnosis, which shows both.
#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    clippy::print_stderr,
    reason = "a test fails by panicking and says what it measured"
)]

#[path = "../support/program.rs"]
mod program;

mod calls;
mod flights;
mod page;
mod real_models;
mod recordings;
