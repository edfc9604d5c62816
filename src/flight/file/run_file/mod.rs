//! The CSV run file: a TOML preamble about the run, a header of channels with units, rows of samples.
//!
//! In: the text of a preamble, the names of a header. Out: [`RunInfo`], [`RecordingHeader`] with one [`RecordingColumn`] a
//! name and its factor to SI, and [`RunFileWriter`] for the way back. Rows are read by `telemetry::csv`.
//! Assumed: lines that start with `# ` before the header are one TOML document; SI where a column names no unit.
//! Refused, each with line and column: TOML that does not parse, a known key of another type, an unknown or wrong unit
//! on a known channel, a column that comes twice, no `time`, controls called after two kinds of aircraft.

mod header;
mod info;
mod writer;

pub use header::{RecordingColumn, RecordingHeader, RecordingTarget};
pub use info::RunInfo;
pub use writer::RunFileWriter;

/// A wrong place in a run file: what was expected there and what was found.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{line}:{column}: {what}")]
pub struct RunFileError {
    /// Line, from 1.
    pub line: usize,
    /// Column in characters, from 1.
    pub column: usize,
    /// What was expected and what was found.
    pub what: String,
}

/// The text as it may stand in a message: on one line and not longer than 40 characters.
pub fn quoted(text: &str) -> String {
    let mut shown: String = text.chars().take(40).flat_map(char::escape_debug).collect();
    if text.chars().nth(40).is_some() {
        shown.push_str("...");
    }
    format!("`{shown}`")
}
