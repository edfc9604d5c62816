//! Every derivative that the program has in closed form, against derivatives found in another way.
#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    clippy::float_cmp,
    reason = "a test fails by panicking, and a structural zero is compared as such"
)]

#[path = "../support/dual.rs"]
mod dual;
#[path = "../support/uniform.rs"]
mod uniform;

mod aids;
mod linear_model;
mod process;
mod states;
