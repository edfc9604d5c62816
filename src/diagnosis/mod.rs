//! What a model gets wrong, and why: the cause named, the model extended, the gain measured on runs that it did not see.
//!
//! In: a model with effects (`simulation::flight_model`), runs as samples with their geometry. `taken` says which runs can be
//! used, `run_record` and `driven` what was flown, `aircraft` what the model makes of it, `posed` the two together; `filter`
//! (with `covariance`, `noisier` and `slopes`) compares them along a run. `problem` joins several runs at a `point`,
//! `linearise` has its neighbourhood and `settle` the way down. `library` holds the hypotheses, `screen` weighs them all at
//! once, `search` fits the best and looks again, and `earlier` weighs what was found first with the rest in place; where many
//! derivatives are wrong `whole` has them together, and `exchange` what would stand in the place of each. `diagnose` says what
//! came of it, `explain` in words, `companions` and `against` (with `residual_series` and `spectrum`) by what the residuals go
//! with. `free_run` predicts runs, and `gain` says how much better one model predicts than another. `live` does it while the
//! flight goes on, and says what it finds as the records of `record`.
//! Assumed: body axes, SI; controls in straight lines between samples; a run begins in its own trim.
//! Refused: a run without rates, one too short, a control that the model answers to and the run lacks, a time that goes back, a
//! channel in another unit than its header says (`other_unit`).

pub mod against;
pub mod aircraft;
mod blade_passing;
#[cfg(test)]
mod checks;
pub mod column;
pub mod companions;
mod covariance;
pub mod diagnose;
pub mod driven;
mod earlier;
mod exchange;
pub mod explain;
pub mod filter;
pub mod flight_path;
pub mod free_run;
pub mod gain;
mod gusts;
pub mod kinematics;
pub mod library;
pub mod linearise;
pub mod live;
mod noisier;
mod other_unit;
pub mod point;
pub mod posed;
pub mod problem;
pub mod record;
pub mod residual;
mod residual_series;
pub mod run_record;
pub mod screen;
pub mod search;
mod settle;
mod slopes;
mod smoothed;
pub mod spectrum;
mod taken;
pub mod whole;
