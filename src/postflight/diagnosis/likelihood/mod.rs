//! The likelihood of runs given a model with hypotheses, its gradient and normal equations.

pub mod adequacy;
pub mod aircraft;
pub(crate) mod covariance;
pub mod filter;
#[cfg(test)]
pub(crate) mod likelihood_tests;
pub(crate) mod maximise;
pub(crate) mod noise_score;
pub mod normal_equations;
pub mod parameter;
pub mod parameter_set;
pub mod problem;
pub mod run_model;
pub(crate) mod sandwich;
pub(crate) mod sensitivity;
pub mod state;
pub(crate) mod unseen_velocity;
