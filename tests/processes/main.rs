//! Tests of real processes, real time and allocations, one at a time.
//!
//! Each test holds `alone()` while it runs, so that no other of this binary disturbs it.
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

#[path = "../conformance/processes.rs"]
mod conformance;
#[path = "../equivalence/processes.rs"]
mod equivalence;
#[path = "../faults/processes.rs"]
mod faults;
#[path = "../live/mod.rs"]
mod live;
#[path = "../telemetry/allocation.rs"]
mod telemetry;

use std::sync::{Mutex, MutexGuard, PoisonError};

#[global_allocator]
static ALLOCATOR: support::allocations::Counted = support::allocations::Counted;

/// Held by each test of this binary while it runs.
pub(crate) fn alone() -> MutexGuard<'static, ()> {
    static TURN: Mutex<()> = Mutex::new(());
    // A test that failed while it held the lock leaves nothing behind it.
    TURN.lock().unwrap_or_else(PoisonError::into_inner)
}
