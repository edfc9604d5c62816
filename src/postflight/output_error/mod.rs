//! Output error: the parameters of a linear model whose simulated outputs are most likely to be the measured ones.
//!
//! In: a structure (four matrices whose entries are affine in the parameters), parameters with starts and priors, recorded
//! runs. Out: estimates with the Cramer-Rao bound and with errors corrected for coloured residuals, each run's own initial
//! state and biases, how well each output is followed, which parameters the records do not ask for.
//! Assumed: noise on the outputs, and on the inputs as far as it is small; inputs straight between samples; parameters the same
//! in all runs.
//! Refused: data that cannot tell the parameters, with the values that say so; nothing is repaired.

pub mod coloured_errors;
pub(crate) mod covariance;
pub mod decimated;
pub mod discrete;
pub mod error;
pub mod exponential;
pub mod filter_error;
pub mod fit;
pub mod fit_result;
pub(crate) mod identifiability;
pub mod information;
pub mod input_delay;
mod input_noise;
pub mod model;
pub mod predict;
pub(crate) mod problem;
pub mod record;
pub(crate) mod result;
pub mod run_parameters;
pub(crate) mod schur;
pub mod settings;
pub mod simulated_outputs;

pub use error::OutputErrorFitError;
pub use fit::fit;
pub use fit_result::{FitResult, FittedRun};
pub use model::{FitParameter, InputDelay, InputOutputRecord, MatrixEntry, ModelStructure};
pub use predict::{fit_run_parameters, predict};
pub use run_parameters::RunParameters;
pub use settings::{FitSettings, NoiseCovariance};
