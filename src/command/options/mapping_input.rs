//! `--config`: the file that says which MAVLink message gives which channel.

use sideslip::error::Failure;
use sideslip::io::telemetry::mavlink::mapping::MavlinkConfig;
use std::path::Path;

/// Reads the file; the defaults where none was named.
pub(crate) fn read_mapping(file: Option<&Path>) -> Result<MavlinkConfig, Failure> {
    let Some(file) = file else { return Ok(MavlinkConfig::default()) };
    let text = std::fs::read_to_string(file).map_err(|error| Failure::file(file, format_args!("cannot be read: {error}")))?;
    MavlinkConfig::from_toml(&text).map_err(|place| Failure::at(file, place.line, place.column, place.what))
}
