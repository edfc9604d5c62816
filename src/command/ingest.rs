//! `sideslip ingest`: telemetry into shared memory. A recording comes paced by its own time stamps.

use super::live::supervised;
use super::replay::stopped_by_signals;
use super::{message, root_path};
use ::replay::{MonotonicClock, Pace, Player};
use sideslip::bus::clock::monotonic_ns;
use sideslip::bus::payload::{OTHERS, SAMPLE, SAMPLE_TO_ACKNOWLEDGE, SamplePayload, TakenPayload};
use sideslip::bus::root::Role;
use sideslip::bus::run_head::{playing_since, write_head};
use sideslip::bus::service::{Bus, Publisher, Subscriber};
use sideslip::error::{Failure, Outcome};
use sideslip::flight::channel::Channel;
use sideslip::flight::log_head::LogHead;
use sideslip::flight::run_file::{RunInfo, Target};
use sideslip::telemetry::recording::{Recording, Row};
use std::path::{Path, PathBuf};
use std::str::FromStr;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

const EXAMPLE: &str = "\
Example:
  sideslip ingest --source file://flight.csv
  sideslip ingest --source file://flight.mcap --speed 4 --root run/

With --speed max nothing may be lost: it waits for the estimator to take every sample, and for an estimator to come.

Exit status: 0 done; 1 failed while running; 2 the call or the recording is wrong, or other telemetry is in this root;
3 done, with data skipped (said how much).";

/// Samples that may be under way where none may be lost; the estimator's place holds twice as many.
const IN_FLIGHT: u64 = 512;
/// Between looks at what the estimator has taken.
const LOOK: Duration = Duration::from_micros(50);
/// Silence after which it is said that nobody takes the samples.
const SAY_WAITING: Duration = Duration::from_secs(3);
/// What was published last stays in reach for subscribers that have not found this publisher yet.
const LINGER: Duration = Duration::from_millis(100);

/// Where telemetry comes from.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Source {
    /// A recording of any format that is read.
    File(PathBuf),
}

impl FromStr for Source {
    type Err = String;

    fn from_str(url: &str) -> Result<Self, String> {
        match url.split_once("://") {
            Some(("file", path)) if !path.is_empty() => Ok(Source::File(path.into())),
            _ => Err(format!("expected file://PATH, found `{}`", url.chars().take(60).collect::<String>())),
        }
    }
}

/// Bring telemetry into shared memory, where `estimate` takes it up
#[derive(clap::Args)]
#[command(after_help = EXAMPLE)]
pub(crate) struct Args {
    /// Where telemetry comes from: file://PATH, a recording of any format that is read
    #[arg(long, value_name = "URL")]
    source: Source,
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
    /// Go on where a recording that began to play earlier would be now
    #[arg(long, hide = true)]
    resume: bool,
}

/// Publishes the source to its end, or until it is stopped.
pub(crate) fn run(args: &Args) -> Result<Outcome, Failure> {
    let stop = stopped_by_signals()?;
    supervised(args.supervised, &stop)?;
    match &args.source {
        Source::File(path) => play(args, path, &stop),
    }
}

/// The head of a recording's run, keys overridden, named by its file where it has no name.
pub(crate) fn head_of(file: &Path, recording: &Recording, overrides: &[String]) -> Result<(RunInfo, LogHead), Failure> {
    let mut info = recording.info().clone();
    for assignment in overrides {
        info.set(assignment).map_err(|what| Failure::Input(format!("--set: {what}")))?;
    }
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

/// Leaves out the columns that a sample on the bus has no place for, and says so.
fn fitted(mut head: LogHead) -> LogHead {
    let (mut others, all) = (0, head.unknown_columns());
    head.channels.retain(|(name, _)| {
        let known = Channel::from_name(name).is_some();
        others += usize::from(!known);
        known || others <= OTHERS
    });
    if all > OTHERS {
        message(format_args!("sideslip: {} of {all} columns without meaning here are left out: {OTHERS} fit", all - OTHERS));
    }
    head
}

fn play(args: &Args, file: &Path, stop: &AtomicBool) -> Result<Outcome, Failure> {
    let mut recording = Recording::open(file)?;
    let (_, head) = head_of(file, &recording, &args.set)?;
    let bus = Bus::enter(&root_path(args.root.as_ref()))?;
    let _role = bus.take(Role::Telemetry)?;
    write_head(bus.root(), bus.incarnation(), &fitted(head))?;
    let mut feed = Feed::new(&bus, args.lossless || args.speed == Pace::Max)?;
    let mut player = Player::<MonotonicClock>::new(args.speed);
    let played_s = played_before(args, &bus)?;
    let mut missed = 0_u64;
    let mut first_s = None;
    let mut newest_s = 0.0;
    while let Some(row) = recording.next_row()? {
        let time_s = row.sample.time_s;
        if time_s.is_finite() && time_s - *first_s.get_or_insert(time_s) < played_s {
            missed += 1;
            continue;
        }
        if !player.wait_for(time_s, || !stop.load(Ordering::Relaxed)) || !feed.sample(row, stop)? {
            break;
        }
        if time_s.is_finite() {
            newest_s = time_s;
        }
    }
    feed.end(newest_s, stop)?;
    let skipped = recording.skipped().rows();
    let mut outcome = Outcome::Done;
    if missed > 0 {
        message(format_args!("sideslip: {missed} samples came while no telemetry was running"));
        outcome = Outcome::DataLost;
    }
    if skipped > 0 || recording.shortfall().is_some() {
        let short = recording.shortfall().map(|what| format!("; {what}")).unwrap_or_default();
        message(format_args!("sideslip: {}: {skipped} rows skipped{short}", file.display()));
        outcome = Outcome::DataLost;
    }
    Ok(outcome)
}

/// How much of the recording had been due before now, s of its own time: as with a live source, it is gone.
fn played_before(args: &Args, bus: &Bus) -> Result<f64, Failure> {
    let factor = match args.speed {
        Pace::RealTime => 1.0,
        Pace::Factor(factor) => factor,
        Pace::Max => return Ok(0.0),
    };
    if !args.resume {
        return Ok(0.0);
    }
    let now_ns = monotonic_ns();
    let since_ns = playing_since(bus.root(), now_ns)?;
    Ok(Duration::from_nanos(now_ns.saturating_sub(since_ns)).as_secs_f64() * factor)
}

/// The way of samples onto the bus.
struct Feed {
    publisher: Publisher<SamplePayload>,
    /// Where none may be lost: what the estimator has taken.
    taken: Option<(Subscriber<TakenPayload>, u64)>,
    incarnation: u64,
}

impl Feed {
    fn new(bus: &Bus, lossless: bool) -> Result<Self, Failure> {
        let taken = if lossless { Some((bus.subscriber()?, 0)) } else { None };
        Ok(Feed { publisher: bus.publisher()?, taken, incarnation: bus.incarnation() })
    }

    /// Publishes a row; false where it was stopped while it waited for room.
    fn sample(&mut self, row: &Row, stop: &AtomicBool) -> Result<bool, Failure> {
        if !self.room_for(IN_FLIGHT, stop)? {
            return Ok(false);
        }
        let others = row.others.iter().map(|other| other.unwrap_or(f64::NAN));
        let kind = if self.taken.is_some() { SAMPLE_TO_ACKNOWLEDGE } else { SAMPLE };
        self.publisher.publish(&SamplePayload::new(&row.sample, others, kind), None)?;
        Ok(true)
    }

    /// Says that the run has ended, and stays until that has been heard.
    fn end(&mut self, time_s: f64, stop: &AtomicBool) -> Result<(), Failure> {
        self.publisher.publish(&SamplePayload::the_end(time_s), None)?;
        if self.taken.is_none() || !self.room_for(1, stop)? {
            std::thread::sleep(LINGER);
        }
        Ok(())
    }

    /// Waits until fewer than so many samples are under way; false where it was stopped before.
    fn room_for(&mut self, limit: u64, stop: &AtomicBool) -> Result<bool, Failure> {
        let Some((taken, count)) = &mut self.taken else { return Ok(true) };
        let mut since = Instant::now();
        let mut said = false;
        while self.publisher.published() - *count >= limit {
            match taken.receive()? {
                Some(answer) if answer.of_incarnation == self.incarnation => {
                    *count = answer.taken.clamp(*count, self.publisher.published());
                    since = Instant::now();
                }
                Some(_) => {}
                None if stop.load(Ordering::Relaxed) => return Ok(false),
                None => std::thread::sleep(LOOK),
            }
            if !said && since.elapsed() > SAY_WAITING {
                said = true;
                message(format_args!("sideslip: waiting for an estimator to take the samples"));
            }
        }
        Ok(true)
    }
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
            assert!(said.starts_with("expected file://PATH, found `"), "{said}");
        }
    }
}
