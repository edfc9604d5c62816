//! A recording through shared memory: another process brings it in, this one takes every sample and publishes what it brought.
//!
//! In a private root, removed at the end. The other process waits until each sample was taken, so that nothing is lost at
//! whatever speed, and the numbers are those of a replay in one process bit for bit.

use crate::command::options::mapping_input::MapOption;
use crate::command::options::telemetry_source::RecordingSource;
use ::replay::Pace;
use sideslip::error::Failure;
use sideslip::flight::file::log_head::LogHead;
use sideslip::flight::sample::Sample;
use sideslip::io::bus::payload::{OTHERS, SamplePayload, THE_END};
use sideslip::io::bus::root::BusRoot;
use sideslip::io::bus::service::{Bus, Subscriber};
use sideslip::io::telemetry::record::RecordingRow;
use sideslip::live::estimate_publisher::{EstimatePublisher, SamplePublication};
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

const POLL: Duration = Duration::from_micros(50);
/// How long a process that has said the end of the run may take to end itself.
const ENDING: Duration = Duration::from_secs(5);
/// Interval of the check whether the other process lives.
const ALIVE: Duration = Duration::from_millis(50);

/// The other process, and this one's place on the bus.
pub(super) struct BusSource {
    ingest: Child,
    samples: Subscriber<SamplePayload>,
    publisher: EstimatePublisher,
    /// The sample that is being worked on.
    current: Option<SamplePayload>,
    row: RecordingRow,
    // Last, so that the root goes after everything in it.
    _bus: Bus,
}

impl BusSource {
    /// Enters a root of its own and starts the other process.
    pub(super) fn start(
        source: &RecordingSource,
        head: &LogHead,
        pace: Pace,
        config: Option<&Path>,
        map: &MapOption,
    ) -> Result<Self, Failure> {
        if head.unknown_columns() > OTHERS {
            let found = head.unknown_columns();
            let what = format_args!("--bus: expected at most {OTHERS} columns besides the known channels, found {found}");
            return Err(Failure::file(&source.file, what));
        }
        let failed = |error: std::io::Error| Failure::Running(format!("ingest cannot be started: {error}"));
        let bus = Bus::enter_private(&BusRoot::private_path())?;
        let (samples, publisher) = (bus.subscriber()?, EstimatePublisher::new(&bus)?);
        let mut call = Command::new(std::env::current_exe().map_err(failed)?);
        call.args(["ingest", "--supervised", "--lossless", "--speed", &pace.to_string(), "--root"]).arg(bus.root().path());
        call.arg("--source").arg(source.url());
        call.args(source.call());
        if let Some(config) = config {
            call.arg("--config").arg(config);
        }
        if let Some(map) = &map.map {
            call.arg("--map").arg(map);
        }
        // What it says of the recording, the replay says itself.
        let ingest = call.stdin(Stdio::piped()).stdout(Stdio::null()).stderr(Stdio::null()).spawn().map_err(failed)?;
        let row = RecordingRow { number: 0, sample: Sample::new(0.0), others: vec![None; head.unknown_columns()] };
        Ok(BusSource { ingest, samples, publisher, current: None, row, _bus: bus })
    }

    /// The next sample; `None` at the end of the run, or where it was stopped.
    pub(super) fn next_row(&mut self, stop: &AtomicBool) -> Result<Option<(&RecordingRow, SamplePublication<'_>)>, Failure> {
        if let Some(current) = self.current.take() {
            self.publisher.taken(&current)?;
        }
        let mut look_at = Instant::now() + ALIVE;
        let mut died = false;
        while !stop.load(Ordering::Relaxed) {
            let Some(sample) = self.samples.receive()? else {
                if died {
                    return Err(Failure::Running("ingest ended before the recording did".into()));
                }
                if Instant::now() >= look_at {
                    look_at += ALIVE;
                    // Once more after its death: what it had published is still there.
                    died = self.ingest.try_wait().map_err(|error| Failure::Running(error.to_string()))?.is_some();
                }
                std::thread::sleep(POLL);
                continue;
            };
            if self.samples.missed() > 0 {
                let missed = self.samples.missed();
                return Err(Failure::Running(format!("{missed} samples were lost in shared memory where none may be")));
            }
            if sample.kind == THE_END {
                self.publisher.taken(&sample)?;
                return Ok(None);
            }
            self.row.number += 1;
            self.row.sample = sample.sample();
            // NaN stands for not sampled, as in a log.
            let others = sample.others.iter().map(|other| (!other.is_nan()).then_some(*other));
            self.row.others.iter_mut().zip(others).for_each(|(to, from)| *to = from);
            self.current = Some(sample);
            return Ok(Some((&self.row, self.publisher.of_sample(sample.header))));
        }
        Ok(None)
    }

    /// Waits for the other process to end, or ends it.
    pub(super) fn end(mut self) -> Result<(), Failure> {
        let failed = |error: std::io::Error| Failure::Running(format!("ingest: {error}"));
        drop(self.ingest.stdin.take());
        let begun = Instant::now();
        while begun.elapsed() < ENDING {
            if self.ingest.try_wait().map_err(failed)?.is_some() {
                return Ok(());
            }
            std::thread::sleep(Duration::from_millis(1));
        }
        self.ingest.kill().map_err(failed)
    }
}

impl Drop for BusSource {
    fn drop(&mut self) {
        // A failure on the way leaves no process behind.
        if !matches!(self.ingest.try_wait(), Ok(Some(_))) {
            let _ = self.ingest.kill();
            let _ = self.ingest.wait();
        }
    }
}
