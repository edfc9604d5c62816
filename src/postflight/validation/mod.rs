//! Validation: a model's prediction against runs that were not used to fit it.
//!
//! In: a model, hold-out runs. Out: predictions, prediction errors and their improvement with intervals.

pub mod free_run;
pub mod improvement;
#[cfg(test)]
mod improvement_tests;
pub(crate) mod metrics;
pub mod prediction;
