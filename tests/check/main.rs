//! Check: errors put into simulated instruments are found and sized, healthy ones are left alone, real recordings say what is
//! known of them.
#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    clippy::print_stderr,
    reason = "a test fails by panicking and says what it measured"
)]

#[path = "../support/manoeuvre.rs"]
mod manoeuvre;
#[path = "../support/program.rs"]
mod program;
#[path = "../support/uniform.rs"]
mod uniform;

mod coarse;
mod errors;
mod flown;
mod injected;
mod odd;
mod recordings;
mod score;
mod simulated;
mod sortie;
