//! What several kinds of proof use: aircraft, manoeuvres, the program itself, random numbers, counters.
#![allow(dead_code, reason = "each binary uses its part")]

pub(crate) mod allocations;
pub(crate) mod asked;
pub(crate) mod chapter10;
pub(crate) mod equation;
#[path = "../../firmware-profile/src/fingerprint.rs"]
#[allow(unreachable_pub, reason = "the firmware's own file")]
pub(crate) mod fingerprint;
#[path = "../../firmware-profile/src/manoeuvre.rs"]
#[allow(unreachable_pub, reason = "the firmware's own file")]
pub(crate) mod firmware_manoeuvre;
pub(crate) mod help_examples;
pub(crate) mod identified;
pub(crate) mod invented;
pub(crate) mod manoeuvre;
pub(crate) mod navion;
pub(crate) mod paper_cases;
pub(crate) mod patience;
pub(crate) mod processor_clock;
pub(crate) mod program;
pub(crate) mod pseudo_terminal;
pub(crate) mod puma;
pub(crate) mod recorded_samples;
pub(crate) mod short_period;
pub(crate) mod transport;
pub(crate) mod uniform;
pub(crate) mod wilson;
