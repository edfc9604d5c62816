//! Output error: the parameters of a linear model whose simulated outputs are most likely to be the measured ones.
//!
//! In: a structure (four matrices whose entries are affine in the parameters), parameters with starts and priors, recorded
//! runs. Out: estimates with the Cramer-Rao bound and with errors corrected for coloured residuals, each run's own initial
//! state and biases, how well each output is followed, which parameters the records do not ask for.
//! Assumed: noise on the outputs alone; inputs straight between samples; parameters the same in all runs.
//! Refused: data that cannot tell the parameters, with the values that say so; nothing is repaired.

pub(crate) mod answer;
pub mod colour;
pub mod delayed;
pub mod dense;
pub mod discrete;
pub mod exponential;
pub mod fit;
pub mod fitted;
pub mod information;
pub mod model;
pub mod own;
pub(crate) mod problem;
pub(crate) mod reduced;
pub mod refused;
pub mod simulated;
pub mod spectrum;
pub mod thinned;

pub use fit::{Noise, Settings, fit};
pub use fitted::{Fitted, FittedRun};
pub use model::{Delay, Entry, Parameter, Record, Structure};
pub use own::{Own, follow, predict};
pub use refused::Refused;
