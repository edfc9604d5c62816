//! The fast tests: every kind of proof that takes seconds, for each change.
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

#[path = "../compare/mod.rs"]
mod compare;
#[path = "../conformance/mod.rs"]
mod conformance;
#[path = "../consistency/mod.rs"]
mod consistency;
#[path = "../equivalence/mod.rs"]
mod equivalence;
#[path = "../faults/mod.rs"]
mod faults;
#[path = "../fuzz/mod.rs"]
mod fuzz;
#[path = "../golden/mod.rs"]
mod golden;
#[path = "../identify/mod.rs"]
mod identify;
#[path = "../interpretation/mod.rs"]
mod interpretation;
#[path = "../jacobians/mod.rs"]
mod jacobians;
#[path = "../properties/mod.rs"]
mod properties;
#[path = "../reference/mod.rs"]
mod reference;
#[path = "../telemetry/mod.rs"]
mod telemetry;
#[path = "../tidy/mod.rs"]
mod tidy;

#[global_allocator]
static ALLOCATOR: support::allocations::Counted = support::allocations::Counted;
