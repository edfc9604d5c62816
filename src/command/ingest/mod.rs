//! `sideslip ingest`: telemetry into shared memory, from a recording or a link.

mod feed;
mod link;
mod play;
mod quiet;
mod vehicle_file;

use super::stop::{stopped_by_signals, supervised};
use ::replay::Pace;
use sideslip::error::{Failure, Outcome};
use sideslip::flight::log_head::LogHead;
use sideslip::flight::run_file::{RunInfo, Target};
use sideslip::telemetry::mavlink::link::Url;
use sideslip::telemetry::recording::Recording;
use std::path::{Path, PathBuf};
use std::str::FromStr;

const EXAMPLE: &str = "\
Example:
  sideslip ingest --source udpin://127.0.0.1:14550
  sideslip ingest --source serial:///dev/ttyUSB0?baud=921600 --set run=flight-12
  sideslip ingest --source file://flight.csv --speed 4 --root run/

A link is listened to until ctrl-C; one that breaks is opened again. Each boot of the vehicle is a run of its own.
With --speed max nothing may be lost: it waits for the estimator to take every sample, and for an estimator to come.

Exit status: 0 done; 1 failed while running; 2 the call or the recording is wrong, or other telemetry is in this root;
3 done, with data lost or skipped (said how much).";

/// What `--source` accepts, for help and messages.
pub(crate) const SOURCES: &str =
    "udpin://HOST:PORT, udpout://HOST:PORT, tcp://HOST:PORT, serial://DEVICE?baud=N (MAVLink) or file://PATH (a recording)";

/// Where telemetry comes from.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Source {
    /// A recording of any format that is read.
    File(PathBuf),
    /// A link that brings MAVLink.
    Link(Url),
}

impl FromStr for Source {
    type Err = String;

    fn from_str(url: &str) -> Result<Self, String> {
        if Url::is_link(url) {
            return Url::parse(url).map(Source::Link).map_err(|wrong| wrong.to_string());
        }
        match url.split_once("://") {
            Some(("file", path)) if !path.is_empty() => Ok(Source::File(path.into())),
            _ => Err(format!("expected {SOURCES}; found `{}`", url.chars().take(60).collect::<String>())),
        }
    }
}

/// Bring telemetry into shared memory, where `estimate` takes it up
#[derive(clap::Args)]
#[command(after_help = EXAMPLE)]
pub(crate) struct Args {
    /// Where telemetry comes from: udpin://HOST:PORT, udpout://HOST:PORT, tcp://HOST:PORT or serial://DEVICE?baud=N
    /// (MAVLink 1 and 2); file://PATH, a recording of any format that is read
    #[arg(long, value_name = "URL")]
    source: Source,
    /// Which message gives which channel, for MAVLink (TOML)
    #[arg(long, value_name = "FILE")]
    config: Option<PathBuf>,
    /// Directory in which the processes meet
    #[arg(long, value_name = "DIR")]
    root: Option<PathBuf>,
    /// How fast a recording comes: 1 is real time, 4 four times as fast, max as fast as the estimator takes it
    #[arg(long, value_name = "1|N|max", default_value = "1")]
    speed: Pace,
    /// Override a key of the run, such as vane_position_m=[13.08,0,0]; repeatable
    #[arg(long, value_name = "KEY=VALUE")]
    set: Vec<String>,
    /// End when standard input ends
    #[arg(long, hide = true)]
    supervised: bool,
    /// Wait until every sample was taken, at whatever speed
    #[arg(long, hide = true)]
    lossless: bool,
    /// The link's socket is open already, as standard output
    #[arg(long, hide = true)]
    held: bool,
    /// Go on where a recording that began to play earlier would be now
    #[arg(long, hide = true)]
    resume: bool,
}

/// Publishes the source to its end, or until it is stopped.
pub(crate) fn run(args: &Args) -> Result<Outcome, Failure> {
    let stop = stopped_by_signals()?;
    supervised(args.supervised, &stop)?;
    match &args.source {
        Source::File(path) => play::play(args, path, &stop),
        Source::Link(url) => link::listen(args, url, &stop),
    }
}

/// The head of a recording's run, keys overridden, named by its file where it has no name.
pub(crate) fn head_of(file: &Path, recording: &Recording, overrides: &[String]) -> Result<(RunInfo, LogHead), Failure> {
    let mut info = recording.info().clone();
    override_keys(&mut info, overrides)?;
    if info.run().is_none() {
        // A log has another name than the recording; the run keeps its own.
        let stem = file.file_stem().unwrap_or_default().to_string_lossy();
        info.set(&format!("run={stem}")).map_err(|what| Failure::file(file, what))?;
    }
    let carried = recording.columns().iter().filter(|column| !matches!(column.target, Target::Time { .. }));
    let head = LogHead {
        run_toml: info.to_toml(),
        channels: carried.map(|column| (column.name.clone(), column.inner_unit().to_owned())).collect(),
        controls: info.geometry().controls,
    };
    Ok((info, head))
}

/// `--set` on what the run says of itself.
fn override_keys(info: &mut RunInfo, overrides: &[String]) -> Result<(), Failure> {
    overrides.iter().try_for_each(|set| info.set(set)).map_err(|what| Failure::Input(format!("--set: {what}")))
}

#[cfg(test)]
mod tests {
    use super::Source;

    #[test]
    fn a_source_is_a_url_of_a_known_kind() {
        assert_eq!("file://a/b.csv".parse(), Ok(Source::File("a/b.csv".into())));
        assert_eq!("file:///a b.csv".parse(), Ok(Source::File("/a b.csv".into())));
        for wrong in ["", "file://", "a.csv", "ftp://x"] {
            let said = wrong.parse::<Source>().unwrap_err();
            assert!(said.contains("expected udpin://HOST:PORT") && said.contains("found `"), "{said}");
        }
        assert!(matches!("udpin://127.0.0.1:14550".parse(), Ok(Source::Link(_))));
        assert!("udpin://127.0.0.1".parse::<Source>().unwrap_err().contains("expected host:port"));
    }
}
