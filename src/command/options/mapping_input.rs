//! `--config`: the file that says which message or measurement gives which channel.

use sideslip::error::Failure;
use sideslip::io::telemetry::recording_config::RecordingConfig;
use std::path::Path;

/// Reads the file; the defaults where none was named.
pub(crate) fn read_mapping(file: Option<&Path>) -> Result<RecordingConfig, Failure> {
    let Some(file) = file else { return Ok(RecordingConfig::default()) };
    let text = std::fs::read_to_string(file).map_err(|error| Failure::file(file, format_args!("cannot be read: {error}")))?;
    RecordingConfig::from_toml(&text).map_err(|place| Failure::at(file, place.line, place.column, place.what))
}
