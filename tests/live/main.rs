//! Live: real processes over shared memory, killed at the worst moments. Each test has a root of its own.

#![expect(clippy::unwrap_used, clippy::panic, reason = "a test ends where it fails")]
#![allow(clippy::print_stderr, reason = "a test says what it measured")]

#[path = "../support/allocations.rs"]
mod allocations;
#[path = "../support/program.rs"]
mod program;

mod demo;
mod kills;
mod latency;
mod links;
mod payload;
mod processes;
mod real_time;
mod sender;
mod services;
mod stage;
