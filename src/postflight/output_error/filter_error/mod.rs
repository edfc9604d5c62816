//! Filter error: output error with process noise, by gusts and by noise of the recorded inputs.
//!
//! In: as for output error, with the states that gusts accelerate and the noise density of every recorded input. Out: the same
//! result, from the innovations of a Kalman filter, and gust densities and output noise with standard errors.
//! Assumed: gusts white within the model's bandwidth; output noise white and uncorrelated; an initial state that is known or
//! free.
//! Refused: what output error refuses. A gust that does not raise the likelihood has density zero; without any, the result is
//! that of output error.

mod discrete_noise;
mod filter;
pub mod fit;
mod likelihood;
pub mod process_noise;
mod result;

pub use fit::fit;
pub use process_noise::{Disturbances, Gust, ProcessNoiseEstimate};
