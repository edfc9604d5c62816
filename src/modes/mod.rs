//! Modes: derivatives become Dutch roll, roll and spiral, with standard errors.
//!
//! In: the lateral derivatives with their joint covariance. Out: exact eigenvalues of the lateral subsystem.
//! Assumed: the lateral motion stands for itself (v p phi r); coupling with the longitudinal motion is left out.
//! Refused: modes of derivatives that have no number.

pub mod lateral;
pub mod record;
pub mod stage;
