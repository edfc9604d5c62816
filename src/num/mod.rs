//! Small dense mathematics: only what nalgebra lacks or does with an allocator.
//!
//! In: arrays of fixed size. Out: arrays of fixed size, or a refusal that says which pivot or variance failed.
//! Assumed: finite input. Refused: a variance that is not positive, a pivot that has vanished; nothing is repaired.

#[cfg(feature = "std")]
pub(crate) mod banded;
#[cfg(feature = "std")]
pub(crate) mod cholesky;
#[cfg(feature = "std")]
pub mod dense;
pub mod eigen;
#[cfg(feature = "std")]
pub mod fft;
#[cfg(feature = "std")]
pub mod frequency_response;
pub mod kernel;
#[cfg(feature = "std")]
pub(crate) mod parallel_map;
pub(crate) mod product;
#[cfg(feature = "std")]
pub mod random;
pub(crate) mod real;
pub(crate) mod rows;
pub mod sweep;
pub mod symmetric;
pub mod ud;
#[cfg(feature = "std")]
pub(crate) mod welch;
