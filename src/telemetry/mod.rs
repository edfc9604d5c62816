//! Telemetry: bytes of an aircraft or a file become time-stamped samples.
//!
//! In: recordings in any format that is read (told by content). Out: [`record::Sample`]s, the run's own keys, columns.
//! Assumed: nothing of the bytes. Refused: what has no time or is no number, row by row, counted and said; a file whose
//! format, preamble or header cannot be read, with the place.

pub mod record;

#[cfg(feature = "std")]
pub mod csv;
#[cfg(feature = "std")]
pub mod format;
#[cfg(feature = "std")]
pub mod log_recording;
#[cfg(feature = "std")]
pub mod mavlink;
#[cfg(feature = "std")]
pub mod mcap;
#[cfg(feature = "std")]
mod mcap_stream;
#[cfg(feature = "std")]
pub mod recording;
