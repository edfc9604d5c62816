//! Post-flight analysis: whole records, with all the time and memory that a workstation has.
//!
//! In: recorded runs, a model. Out: instrument errors, derivatives with standard errors, prediction
//! errors, causes of a model's error.
//! Outcomes are data; sentences for people are made in `io::outputs::words`.

pub mod diagnosis;
pub mod equation_error;
pub mod identification;
pub mod manoeuvres;
pub mod output_error;
pub mod reconstruction;
pub mod recorded_run;
mod start_state;
pub mod validation;
pub mod work_progress;
