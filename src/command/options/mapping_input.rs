//! `--config` and `--map`: files that say which message, measurement, column or field gives which channel.

use sideslip::error::Failure;
use sideslip::flight::file::run_file::RunFileError;
use sideslip::io::telemetry::channel_map::map_file::ChannelMap;
use sideslip::io::telemetry::recording_config::RecordingConfig;
use sideslip::io::text_file::read_text;
use std::path::{Path, PathBuf};

/// `--map`.
#[derive(clap::Args)]
pub(crate) struct MapOption {
    /// Which column of a table (CSV), or which topic and field of an MCAP log, of another program is which channel, with unit,
    /// sign and scale (TOML); `sideslip inspect FILE --map-template map.toml` writes it
    #[arg(long, value_name = "FILE")]
    pub(crate) map: Option<PathBuf>,
}

/// Reads the files; the defaults where none was named.
pub(crate) fn read_mapping(file: Option<&Path>, map: &MapOption) -> Result<RecordingConfig, Failure> {
    let mut config = match file {
        None => RecordingConfig::default(),
        Some(file) => {
            let text = read_text(file).map_err(|wrong| Failure::file(file, wrong))?;
            let placed = |place: RunFileError| Failure::at(file, place.line, place.column, place.what);
            RecordingConfig::from_toml(&text).map_err(placed)?
        }
    };
    if let Some(file) = &map.map {
        let text = read_text(file).map_err(|wrong| Failure::file(file, wrong))?;
        let read = ChannelMap::from_toml(&text).map_err(|place| Failure::at(file, place.line, place.column, place.what))?;
        config.map = Some(read);
    }
    Ok(config)
}
