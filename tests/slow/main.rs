//! The slow tests: studies over many seeds and fits of whole sorties, in short forms that environment variables lengthen.
#![cfg(feature = "cli")]
#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    clippy::print_stderr,
    reason = "a test fails by panicking and prints what it measured"
)]

#[path = "../support/mod.rs"]
mod support;

#[path = "../check/mod.rs"]
mod check;
#[path = "../compare/slow.rs"]
mod compare;
#[path = "../consistency/slow.rs"]
mod consistency;
#[path = "../equivalence/slow.rs"]
mod equivalence;
#[path = "../faults/slow.rs"]
mod faults;
#[path = "../hidden/mod.rs"]
mod hidden;
#[path = "../identify/slow.rs"]
mod identify;
#[path = "../paper/mod.rs"]
mod paper;
#[path = "../recovery/mod.rs"]
mod recovery;
#[path = "../studies/mod.rs"]
mod studies;
#[path = "../telemetry/slow.rs"]
mod telemetry;
