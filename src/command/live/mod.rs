//! `sideslip live`: telemetry and estimator as processes of their own, watched over and started again when they die.
//!
//! The supervisor holds every service of the bus open and does no work itself. Its children end when their standard input
//! ends, so that they outlive it in no case: closed on purpose in order (telemetry first, so that the run has its end and
//! the log its last sample), or by the system where the supervisor was killed.

mod supervised_process;

use super::options::estimation_options::EstimationOptions;
use super::options::mapping_input::{CONFIG_HELP, MapOption};
use super::options::mavlink_out_options::MavlinkOutOptions;
use super::options::replace_option::ReplaceOption;
use super::options::run_parts::PartOptions;
use super::options::signing_input::read_key;
use super::options::telemetry_source::TelemetrySource;
use super::terminal::stop::{stopped_by_signals, supervised};
use crate::command::{message, root_path};
use ::replay::Pace;
use sideslip::error::{Failure, Outcome};
use sideslip::io::bus::error::BusError;
use sideslip::io::bus::payload::{AcknowledgementPayload, SamplePayload};
use sideslip::io::bus::root::BusRole;
use sideslip::io::bus::run_head::play_anew;
use sideslip::io::bus::service::{Bus, Subscriber};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};
use supervised_process::{ProcessExit, SupervisedProcess};

const EXAMPLE: &str = "\
Example:
  sideslip live --source udpin://127.0.0.1:14550 --out logs/
  sideslip live --source file://flight.csv --out logs/
  sideslip live --source udpin://0.0.0.0:14550 --mavlink-out udpout://192.168.1.20:14550 --signing-key flight.key
and beside it, in another terminal:
  sideslip watch

It ends with its source, with ctrl-C or SIGTERM: the log is closed and the answer printed. A process that dies is started
again; the log then goes on in a file of its own (flight-2.mcap).

Exit status: 0 done; 1 failed while running; 2 the call or the recording is wrong, or the root is in use; 3 done, with
data lost or skipped (said how much).";

/// Polling interval of the children.
const POLL: Duration = Duration::from_millis(5);
/// The longest wait for the processes of a supervisor that was killed.
const ORPHANS: Duration = Duration::from_secs(15);
/// An estimator that gives no heartbeat for so long, while that many samples come, hangs.
const STILL: Duration = Duration::from_secs(3);
const UNANSWERED: u32 = 20;
/// A recording at which telemetry has failed so often is given up.
const FAILURES: u64 = 5;
/// How long telemetry, and then the estimator, may take to end.
const ENDING: Duration = Duration::from_secs(10);

/// Estimate live: telemetry and estimator as separate processes over shared memory, restarted when one dies
#[derive(clap::Args)]
#[command(after_help = EXAMPLE)]
pub(crate) struct LiveArgs {
    /// Where telemetry comes from: udpin://HOST:PORT, udpout://HOST:PORT, tcp://HOST:PORT or serial://DEVICE?baud=N
    /// (MAVLink 1 and 2); file://PATH, a recording of any format that is read; pcm+file://PATH?format=FRAME.toml,
    /// pcm+udp://HOST:PORT?format=FRAME.toml, pcm+tcp://HOST:PORT?format=FRAME.toml, a stream of PCM; ch10+udp://HOST:PORT,
    /// ch10+file://PATH, IRIG 106 Chapter 10, with ?format=FILE.toml where its setup does not name the channels
    #[arg(long, value_name = "URL")]
    source: String,
    /// Which message (MAVLink) or measurement (IRIG 106 Chapter 10) carries which channel, or the format of PCM frames in Chapter
    /// 10 packets (TOML)
    #[arg(long, value_name = "FILE", long_help = CONFIG_HELP)]
    config: Option<PathBuf>,
    #[command(flatten)]
    map: MapOption,
    #[command(flatten)]
    parts: PartOptions,
    /// Directory for the MCAP logs (made where it is missing)
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Write the last estimates as JSON to this file at the end, or to standard output with -
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
    /// Directory of the run: processes and readers with the same one share its data
    #[arg(long, value_name = "DIR")]
    root: Option<PathBuf>,
    /// How fast a recording comes: 1 is real time
    #[arg(long, value_name = "1|N|max", default_value = "1")]
    speed: Pace,
    /// Override a key of the run, such as vane_position_m=[13.08,0,0] or latency_s={tas=0.25} (channels stamped late, s);
    /// repeatable
    #[arg(long, value_name = "KEY=VALUE")]
    set: Vec<String>,
    #[command(flatten)]
    estimation: EstimationOptions,
    #[command(flatten)]
    station: MavlinkOutOptions,
    /// Key of MAVLink 2 signing, 64 hexadecimal digits or 32 raw bytes: telemetry that is not signed with it is refused and
    /// counted, and what is sent is signed. Timestamps are kept in FILE.timestamp-0 and FILE.timestamp-1
    #[arg(long, value_name = "FILE")]
    signing_key: Option<PathBuf>,
    #[command(flatten)]
    replace: ReplaceOption,
    /// End when standard input ends
    #[arg(long, hide = true)]
    supervised: bool,
}

/// Supervises until the source ends or it is stopped.
pub(crate) fn run(args: &LiveArgs) -> Result<Outcome, Failure> {
    let stop = stopped_by_signals()?;
    supervised(args.supervised, &stop)?;
    let source = args.source.parse::<TelemetrySource>().map_err(|what| Failure::Input(format!("--source: {what}")))?;
    if args.parts.any() && !matches!(source, TelemetrySource::Recording(_)) {
        return Err(Failure::Input("--from, --to, --manoeuvre: expected with a recording (file://PATH), found a link".into()));
    }
    args.replace.refuse_each([("--json", args.json.as_deref())])?;
    if let Some(key) = &args.signing_key {
        if !matches!(source, TelemetrySource::Link(_)) && args.station.mavlink_out.is_none() {
            return Err(Failure::Input(
                "--signing-key: expected with a link of MAVLink as the source, or with --mavlink-out".into(),
            ));
        }
        // Before the flight, not by each process in it.
        read_key(key)?;
    }
    let mut bus = Bus::enter(&root_path(args.root.as_ref()))?;
    let _role = bus.take(BusRole::Supervisor)?;
    wait_for_orphans(&bus, &stop)?;
    play_anew(bus.root());
    if let Some(out) = &args.out {
        must_be_writable(out)?;
    }
    // The socket is the supervisor's: what arrives while telemetry is away waits in it.
    let held = match &source {
        TelemetrySource::Link(url) | TelemetrySource::PcmLink { url, .. } | TelemetrySource::Chapter10Link { url, .. } => {
            url.hold().map_err(|wrong| Failure::Running(wrong.to_string()))?
        }
        TelemetrySource::Recording(_) => None,
    };
    let mut estimate = SupervisedProcess::new("estimate", estimate_call(args, bus.root().path(), &source), None);
    let mut ingest = SupervisedProcess::new("ingest", ingest_call(args, bus.root().path(), &source), held);
    estimate.start()?;
    ingest.start()?;
    let ended = watch(&bus, &mut estimate, &mut ingest, (&source, &stop));
    // In this order: the run has its end before the estimator is asked for its answer.
    let telemetry = ingest.end(ENDING)?;
    let estimator = estimate.end(ENDING)?;
    ended?;
    let restarts = estimate.restarts() + ingest.restarts();
    if restarts > 0 {
        message(format_args!(
            "sideslip: estimate was started again {} times, ingest {} times",
            estimate.restarts(),
            ingest.restarts()
        ));
    }
    match (telemetry, estimator) {
        (Some(0), Some(0)) if restarts == 0 => Ok(Outcome::Done),
        (Some(0 | 3), Some(0 | 3)) => Ok(Outcome::DataLost),
        (_, None) => Err(Failure::Running("estimate was killed while it was ending: there is no last answer".into())),
        (None, _) => Err(Failure::Running("ingest was killed while it was ending: what it had received last is lost".into())),
        (Some(one), Some(other)) => Err(Failure::Running(format!("ingest ended with exit status {one}, estimate with {other}"))),
    }
}

/// The processes of a supervisor that was killed end by themselves; until then their roles are taken.
fn wait_for_orphans(bus: &Bus, stop: &AtomicBool) -> Result<(), Failure> {
    let begun = Instant::now();
    let mut said = false;
    for role in [BusRole::Telemetry, BusRole::Estimator] {
        loop {
            match bus.root().take(role) {
                Ok(_) => break,
                Err(taken @ BusError::RoleTaken { .. }) if begun.elapsed() < ORPHANS && !stop.load(Ordering::Relaxed) => {
                    if !std::mem::replace(&mut said, true) {
                        message(format_args!("sideslip: {taken}; waiting for it to end"));
                    }
                    std::thread::sleep(POLL);
                }
                Err(other) => return Err(other.into()),
            }
        }
    }
    Ok(())
}

/// A directory in which no log can be written is the call's fault, and better said before the flight than in it.
fn must_be_writable(out: &Path) -> Result<(), Failure> {
    let refused = |error: std::io::Error| Failure::file(out, format_args!("--out: expected a directory for logs: {error}"));
    std::fs::create_dir_all(out).map_err(refused)?;
    let probe = out.join(format!(".sideslip-{}", std::process::id()));
    let written = std::fs::write(&probe, b"a log begins with more than this");
    let _ = std::fs::remove_file(&probe);
    written.map_err(refused)
}

fn ingest_call(args: &LiveArgs, root: &Path, source: &TelemetrySource) -> Vec<String> {
    let mut call = vec!["--source".to_owned(), args.source.clone(), "--speed".to_owned(), args.speed.to_string()];
    call.push("--resume".to_owned());
    call.extend(args.set.iter().flat_map(|set| ["--set".to_owned(), set.clone()]));
    if let Some(config) = &args.config {
        call.extend(["--config".to_owned(), config.display().to_string()]);
    }
    if let Some(map) = &args.map.map {
        call.extend(["--map".to_owned(), map.display().to_string()]);
    }
    call.extend(args.parts.call());
    if let (Some(key), TelemetrySource::Link(_)) = (&args.signing_key, source) {
        call.extend(["--signing-key".to_owned(), key.display().to_string()]);
    }
    call.extend(["--root".to_owned(), root.display().to_string()]);
    call
}

fn estimate_call(args: &LiveArgs, root: &Path, source: &TelemetrySource) -> Vec<String> {
    let mut call = vec!["--root".to_owned(), root.display().to_string()];
    if let Some(out) = &args.out {
        let name = match source {
            TelemetrySource::Recording(source) => source.file.with_extension("mcap").file_name().map(PathBuf::from),
            TelemetrySource::Link(_) | TelemetrySource::PcmLink { .. } | TelemetrySource::Chapter10Link { .. } => None,
        };
        call.extend(["--out".to_owned(), out.join(name.unwrap_or_else(|| "live.mcap".into())).display().to_string()]);
    }
    call.extend(args.estimation.call());
    call.extend(args.station.call());
    if let (Some(key), Some(_)) = (&args.signing_key, &args.station.mavlink_out) {
        call.extend(["--signing-key".to_owned(), key.display().to_string()]);
    }
    if let Some(json) = &args.json {
        // What stood there was refused at the start; an estimator that is started again replaces what the first one wrote.
        call.extend(["--json".to_owned(), json.display().to_string(), ReplaceOption::FORCE.to_owned()]);
    }
    call
}

/// Whether the estimator does anything: samples go in, signs of life come out.
struct EstimatorWatchdog {
    samples: Subscriber<SamplePayload>,
    taken: Subscriber<AcknowledgementPayload>,
    /// Samples since its last heartbeat, and when the first of them came.
    unanswered: Option<(u32, Instant)>,
}

impl EstimatorWatchdog {
    fn of(bus: &Bus) -> Result<Self, Failure> {
        Ok(EstimatorWatchdog { samples: bus.subscriber()?, taken: bus.subscriber()?, unanswered: None })
    }

    /// Whether so many samples have come for so long without a heartbeat that it cannot be alive.
    fn is_hung(&mut self) -> Result<bool, Failure> {
        while self.samples.receive()?.is_some() {
            let (count, since) = self.unanswered.unwrap_or((0, Instant::now()));
            self.unanswered = Some((count.saturating_add(1), since));
        }
        while self.taken.receive()?.is_some() {
            self.unanswered = None;
        }
        Ok(self.unanswered.is_some_and(|(count, since)| count >= UNANSWERED && since.elapsed() >= STILL))
    }
}

/// Starts again what dies or hangs, until telemetry has ended by itself or it is stopped.
fn watch(
    bus: &Bus,
    estimate: &mut SupervisedProcess,
    ingest: &mut SupervisedProcess,
    (source, stop): (&TelemetrySource, &AtomicBool),
) -> Result<(), Failure> {
    let is_recording = matches!(source, TelemetrySource::Recording(_));
    let mut watchdog = EstimatorWatchdog::of(bus)?;
    while !stop.load(Ordering::Relaxed) {
        for child in [&mut *estimate, &mut *ingest] {
            match child.poll_exit()? {
                None => {}
                Some(ProcessExit::Finished) if child.name() == "ingest" => return Ok(()),
                Some(ProcessExit::WrongCall) => return Err(Failure::Input(format!("{} cannot start", child.name()))),
                // A link may come back; a recording that cannot be read never does.
                Some(ProcessExit::Killed) if child.name() == "ingest" && is_recording && child.failures() >= FAILURES => {
                    return Err(Failure::Running(format!("ingest failed {FAILURES} times: the recording cannot be read")));
                }
                Some(ProcessExit::Finished | ProcessExit::Killed) => bus.clear_the_dead(),
            }
            child.start_when_due()?;
        }
        if watchdog.is_hung()? && estimate.age() >= STILL {
            estimate.kill("takes samples no more");
            watchdog.unanswered = None;
        }
        std::thread::sleep(POLL);
    }
    Ok(())
}
