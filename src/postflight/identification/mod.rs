//! Identification after the flight: one linear model fitted to several runs by output error or filter error.
//!
//! In: runs as recorded, and the names of states, inputs and outputs. Out: derivatives with standard errors (Cramer-Rao bound,
//! and corrected for coloured residuals), the modes of the identified model with theirs, and measures of its prediction of
//! hold-out runs.
//! Assumed: small deviations from each run's own trim; inputs linear between samples; known rows of the attitudes (kinematics)
//! and known terms of gravity and flight speed in the rows of the velocities.
//! Refused: a state or input that was not recorded, an equation whose regressors are missing, runs at different airspeeds.

pub mod columns;
pub mod effective_damping;
pub mod identification_model;
pub mod identify;
mod instrument_delay;
mod instrument_notes;
pub(crate) mod instrument_parameters;
pub mod measured_responses;
pub mod model_variables;
pub mod nondimensional;
pub(crate) mod nonlinear_remainder;
pub(crate) mod process_noise;
pub mod reference_trim;
pub(crate) mod resting_controls;
pub mod roots;
pub mod run_prediction;
pub mod start_values;
pub mod steady_sideslip;
pub mod test_condition;
pub mod usual_variables;
pub(crate) mod velocity;
pub mod vibration;
