//! Filter error: output error whose states are disturbed besides, by gusts and by the noise of recorded inputs.
//!
//! In: as for output error, the states that gusts accelerate, and the density of every recorded input's noise. Out: the same
//! answer, on the innovations of a Kalman filter, and the gusts' densities and the noise of the outputs with standard errors.
//! Assumed: gusts white within the model's band; noise of the outputs white and each its own; a start that is known or fitted.
//! Refused: what output error refuses. A gust that the records do not ask for has density zero, and without any the answer is
//! that of output error.

pub mod disturbance;
mod ended;
mod filter;
pub mod fit;
mod posed;
mod spread;

pub use disturbance::{Disturbances, Found, Gust};
pub use fit::fit;
