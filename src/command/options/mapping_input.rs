//! `--config` and `--map`: files that say which message, measurement, column or field gives which channel.

use sideslip::error::Failure;
use sideslip::flight::file::run_file::RunFileError;
use sideslip::io::telemetry::channel_map::map_file::ChannelMap;
use sideslip::io::telemetry::recording_config::RecordingConfig;
use sideslip::io::text_file::read_text;
use std::path::{Path, PathBuf};

/// What `--help` says of `--config`: every key of a file for MAVLink, and where those of the others stand.
pub(crate) const CONFIG_HELP: &str = "\
Which message (MAVLink) or measurement (IRIG 106 Chapter 10) carries which channel, or the format of PCM frames in Chapter 10 \
packets (TOML).

Keys of a file for MAVLink, all optional:
  system, component         ids of the vehicle [default: who sends most messages of motion]
  aircraft                  \"rotorcraft\" or \"fixed_wing\": names of the controls [default: by the heartbeat]
  reorder_ms                messages up to so late are put in order [default: 20]
  [sources]                 specific_force, rates, attitude, airspeed, flow_angles, altitude, controls, rotor_speed: a list of \
messages each, in the order of preference; [] for none
  [controls.NAME]           of a control, such as [controls.rudder]:
    channel                 number of the servo output or RC channel, from 1
    zero_us                 pulse width at zero, us [default: 1500]
    full_us, full_deg       so many us from zero are so many degrees, negative where a wider pulse means less [default: 500 and \
10, which is assumed, and said to be]
  [rpm]                     sensor (1 or 2), ratio (rotor speed over that of the shaft) [default: 1 and 1]

Keys of a file for Chapter 10 (channel, [measurements], [run]) and of PCM frames are in the guide.";

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
