//! `--config`: the file that says which message or measurement gives which channel.

use sideslip::error::Failure;
use sideslip::io::telemetry::recording_config::RecordingConfig;
use sideslip::io::text_file::read_text;
use std::path::Path;

/// Reads the file; the defaults where none was named.
pub(crate) fn read_mapping(file: Option<&Path>) -> Result<RecordingConfig, Failure> {
    let Some(file) = file else { return Ok(RecordingConfig::default()) };
    let text = read_text(file).map_err(|wrong| Failure::file(file, wrong))?;
    RecordingConfig::from_toml(&text).map_err(|place| Failure::at(file, place.line, place.column, place.what))
}
