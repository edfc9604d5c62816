//! Identification after the flight: which linear model several runs are flights of, by output error over all of them.
//!
//! In: runs as they were recorded, and which of their channels are states, inputs and outputs. Out: derivatives with standard
//! errors (Cramer-Rao, and corrected for the colour of the residuals), the modes of the identified model with theirs, and how
//! well it predicts runs that were not used.
//! Assumed: small deviations from each run's own trim; a control moves in a straight line from sample to sample; rows of the
//! attitudes are kinematics, and what gravity and the flight speed do to the velocities is known.
//! Refused: a state or input that was not recorded, an equation without what it needs, runs that are no flights of one trim.

pub mod columns;
pub mod effective_damping;
pub mod identification_model;
pub mod identify;
mod instrument_delay;
mod instrument_notes;
pub mod instrument_parameters;
pub mod measured_responses;
pub mod model_variables;
pub mod nonlinear_remainder;
pub mod process_noise;
pub mod reference_trim;
pub mod resting_controls;
pub mod roots;
pub mod run_prediction;
pub mod start_values;
pub mod steady_sideslip;
pub mod test_condition;
pub mod velocity;
pub mod vibration;
