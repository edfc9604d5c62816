//! Kinematic compatibility of a run's instruments (data compatibility, flight path reconstruction): the command `check`.
//!
//! In: samples of one or several runs, and where their instruments are said to stand. Out: biases, factors, lags, skews and
//! places of instruments that are not what they should be, each with its standard error and with what else it may be; what
//! these runs cannot tell; a verdict a run.
//! Assumed: a rigid body in air that moves steadily; gusts widen the errors. Refused: to name one cause where two fit alike.

pub mod correction;
pub(crate) mod fault_selection;
pub mod filter;
pub mod fit;
pub(crate) mod flow_angle_r2;
pub mod gross_errors;
pub(crate) mod mean_force_check;
pub mod motion;
pub mod noise;
pub(crate) mod observability;
pub(crate) mod outlier_runs;
pub mod parameter;
#[cfg(test)]
mod reconstruction_tests;
pub mod record;
mod refusal;
pub(crate) mod run_channels;
mod run_verdict;
pub mod screening;
mod shortened_gaps;
pub(crate) mod single_run;
pub mod verdict;
mod wiring;
