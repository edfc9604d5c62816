//! Modes: derivatives become Dutch roll, roll and spiral, with standard errors.
//!
//! In: the lateral derivatives with their joint covariance, and those of all six equations once they are there. Out: exact
//! eigenvalues of the lateral subsystem v p phi r, and the Dutch roll of the whole aircraft beside it.
//! Assumed: small deviations about the trim.
//! Refused: modes of derivatives that have no number.

pub mod coupled;
pub mod lateral;
#[cfg(feature = "std")]
pub mod naming;
pub mod persistence;
pub mod record;
pub mod stage;
