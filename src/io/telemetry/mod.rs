//! Telemetry: bytes of an aircraft or a file become time-stamped samples.
//!
//! In: recordings in any format that is read (recognised by content). Out: [`Sample`](crate::flight::sample::Sample)s, the run's
//! own keys, columns. Assumed: nothing of the bytes. Refused: what has no time or is no number, row by row, counted and said; a
//! file whose format, preamble or header cannot be read, with the place.

pub mod alignment;
mod byte_window;
pub mod channel_map;
pub mod chapter10;
mod counter;
pub mod csv;
pub mod format;
#[cfg(feature = "log")]
pub mod log_recording;
pub mod logs;
#[cfg(feature = "log")]
pub mod mapped_log;
#[cfg(feature = "mavlink")]
pub mod mavlink;
#[cfg(feature = "log")]
pub mod mcap;
#[cfg(feature = "log")]
mod mcap_stream;
pub mod pcm;
#[cfg(all(feature = "log", feature = "mavlink"))]
pub mod read_recording;
pub mod record;
#[cfg(all(feature = "log", feature = "mavlink"))]
pub mod recording;
#[cfg(all(feature = "log", feature = "mavlink"))]
pub mod recording_config;
pub mod table;
pub mod waiting_rows;
