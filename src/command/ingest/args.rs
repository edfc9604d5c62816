//! The call of `sideslip ingest`.

use crate::command::options::mapping_input::{CONFIG_HELP, MapOption};
use crate::command::options::run_parts::PartOptions;
use crate::command::options::telemetry_source::TelemetrySource;
use ::replay::Pace;
use std::path::PathBuf;

const EXAMPLE: &str = "\
Example:
  sideslip ingest --source udpin://127.0.0.1:14550
  sideslip ingest --source 'serial:///dev/ttyUSB0?baud=921600' --set run=flight-12
  sideslip ingest --source file://flight.csv --speed 4 --root run/
  sideslip ingest --source udpin://0.0.0.0:14550 --signing-key flight.key
  sideslip ingest --source 'pcm+file://flight.pcm?format=frame.toml'
  sideslip ingest --source 'ch10+udp://127.0.0.1:50001?format=frame.toml'

A link is listened to until ctrl-C; one that breaks is opened again. Each boot of the vehicle is a run of its own.
With --speed max nothing may be lost: it waits for the estimator to take every sample, and for an estimator to come.

Exit status: 0 done; 1 failed while running; 2 the call or the recording is wrong, or other telemetry is in this root;
3 done, with data lost or skipped (said how much).";

/// Bring telemetry into shared memory, where `estimate` takes it up
#[derive(clap::Args)]
#[command(after_help = EXAMPLE)]
pub(crate) struct IngestArgs {
    /// Where telemetry comes from: udpin://HOST:PORT, udpout://HOST:PORT, tcp://HOST:PORT or serial://DEVICE?baud=N
    /// (MAVLink 1 and 2); file://PATH, a recording of any format that is read; pcm+file://PATH?format=FRAME.toml,
    /// pcm+udp://HOST:PORT?format=FRAME.toml, pcm+tcp://HOST:PORT?format=FRAME.toml, a stream of PCM; ch10+udp://HOST:PORT,
    /// ch10+file://PATH, IRIG 106 Chapter 10, with ?format=FILE.toml where its setup does not name the channels
    #[arg(long, value_name = "URL")]
    pub(super) source: TelemetrySource,
    /// Which message (MAVLink) or measurement (IRIG 106 Chapter 10) carries which channel, or the format of PCM frames in Chapter
    /// 10 packets (TOML)
    #[arg(long, value_name = "FILE", long_help = CONFIG_HELP)]
    pub(super) config: Option<PathBuf>,
    #[command(flatten)]
    pub(super) map: MapOption,
    #[command(flatten)]
    pub(super) parts: PartOptions,
    /// Key of MAVLink 2 signing, 64 hexadecimal digits or 32 raw bytes: what is not signed with it is refused and counted, and
    /// our heartbeats are signed. Timestamps are kept in FILE.timestamp-0
    #[arg(long, value_name = "FILE")]
    pub(super) signing_key: Option<PathBuf>,
    /// Directory of the run: processes and readers with the same one share its data
    #[arg(long, value_name = "DIR")]
    pub(super) root: Option<PathBuf>,
    /// How fast a recording comes: 1 is real time, 4 four times as fast, max as fast as the estimator takes it
    #[arg(long, value_name = "1|N|max", default_value = "1")]
    pub(super) speed: Pace,
    /// Override a key of the run, such as vane_position_m=[13.08,0,0] or latency_s={tas=0.25} (channels stamped late, s);
    /// repeatable
    #[arg(long, value_name = "KEY=VALUE")]
    pub(super) set: Vec<String>,
    /// End when standard input ends
    #[arg(long, hide = true)]
    pub(super) supervised: bool,
    /// Wait until every sample was taken, at whatever speed
    #[arg(long, hide = true)]
    pub(super) lossless: bool,
    /// The link's socket is open already, as standard output
    #[arg(long, hide = true)]
    pub(super) held: bool,
    /// Go on where a recording that began to play earlier would be now
    #[arg(long, hide = true)]
    pub(super) resume: bool,
}
