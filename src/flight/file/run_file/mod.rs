//! The CSV run file: a TOML preamble about the run, a header of channels with units, rows of samples.
//!
//! In: the text of a preamble, the names of a header. Out: [`RunInfo`], [`RecordingHeader`] with one [`RecordingColumn`] a
//! name and its factor to SI, and [`RunFileWriter`] for the way back. Rows are read by `telemetry::csv`.
//! Assumed: lines that start with `# ` before the header are one TOML document; SI where a column names no unit.
//! Refused, each with line and column: TOML that does not parse, a known key of another type, an unknown or wrong unit
//! on a known channel, a column that comes twice, no `time`, controls called after two kinds of aircraft.

mod error;
mod header;
mod info;
mod latency;
mod properties;
mod writer;

pub use error::{RunFileError, quoted};
pub use header::{RecordingColumn, RecordingHeader, RecordingTarget};
pub use info::RunInfo;
pub use latency::{ChannelLatencies, LATENCY_MAX_S};
pub use writer::RunFileWriter;
