//! One run as the estimator sees it from the bus: pipeline, log, what it came to.

use super::super::estimation_options::OutputError;
use super::super::model_beside::{Beside, ModelBeside};
use super::super::replay::log::{Log, Logged};
use super::super::replay::sink::Sink;
use super::outlet::Outlet;
use super::voice::Voice;
use ::replay::Pace;
use sideslip::bus::payload::{Header, SamplePayload};
use sideslip::error::Failure;
use sideslip::flight::log_head::LogHead;
use sideslip::flight::run_file::RunInfo;
use sideslip::identification::follower::Follower;
use sideslip::identification::live::{Live, Seen};
use sideslip::outputs::derivatives_json::RunEstimates;
use sideslip::outputs::event_ring::{FoldedEvent, FoldedText};
use sideslip::outputs::finding_text::FindingsTable;
use sideslip::outputs::noise::NoiseUsed;
use sideslip::outputs::output_error_text::OutputErrorTable;
use sideslip::outputs::terminal::{Style, Table};
use sideslip::outputs::text::{Severity, event_severity};
use sideslip::pipeline::{Config, Pipeline};
use sideslip::telemetry::recording::Row;
use std::fmt::Write;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

/// The longest wait for a log that does not catch up.
const CATCHING_UP: Duration = Duration::from_millis(200);
/// The longest wait for the last fit of output error, and for the last look of the diagnosis.
const LAST_FIT: Duration = Duration::from_secs(3);
const LAST_LOOK: Duration = Duration::from_secs(8);

/// A run that is being estimated.
pub(super) struct LiveRun {
    head: LogHead,
    info: RunInfo,
    pipeline: Box<Pipeline>,
    follower: Option<Follower<Live>>,
    diagnosis: Option<Follower<Beside>>,
    sink: Sink,
    log: Option<Log>,
    /// Why there is none, where one was wanted.
    unlogged: Option<String>,
    row: Row,
    rows: u64,
    first_s: Option<f64>,
    last: Header,
    /// Samples that output error did not get, and that the diagnosis did not.
    unfitted: u64,
    undiagnosed: u64,
}

/// What a run is begun with.
pub(super) struct Asked<'a> {
    pub(super) config: &'a Config,
    pub(super) output_error: OutputError,
    /// The model that it is held against.
    pub(super) model: Option<&'a ModelBeside>,
    /// Where its log goes.
    pub(super) out: Option<&'a Path>,
    /// Whether telemetry waits for the estimator.
    pub(super) telemetry_waits: bool,
}

/// What a run came to.
pub(super) struct Ended {
    name: String,
    head: LogHead,
    rows: u64,
    range_s: Option<(f64, f64)>,
    sink: Sink,
    events: Vec<FoldedEvent>,
    consistency: [Option<f64>; 2],
    noise: Option<NoiseUsed>,
    warnings: Vec<String>,
    log: Option<Logged>,
    unlogged: Option<String>,
    unfitted: u64,
    undiagnosed: u64,
}

impl LiveRun {
    /// Begins a run; its log takes the first free name after `out`. Where telemetry waits for the estimator, the estimator
    /// waits for the log; else nothing waits.
    ///
    /// A log that cannot be opened is said and counted as lost: estimates come without it.
    pub(super) fn begin(head: LogHead, asked: &Asked<'_>, voice: &Voice) -> Result<Self, Failure> {
        let Asked { config, output_error, model, out, telemetry_waits } = *asked;
        let wrong = |what: String| Failure::Running(format!("the head of the run: {what}"));
        let mut info = RunInfo::from_toml(&head.run_toml).map_err(|place| wrong(place.to_string()))?;
        info.set_controls(head.controls);
        let pipeline = Pipeline::new(config, *info.geometry()).map_err(|wrong| Failure::Input(wrong.to_string()))?;
        let follower = match output_error.live(*info.geometry()).map(Follower::spawn).transpose() {
            Ok(follower) => follower,
            Err(error) => {
                voice.say(format!("sideslip: this run has no output error: no thread to be had: {error}"));
                None
            }
        };
        let diagnosis = match model.map(|model| Follower::spawn(model.live(*info.geometry()))).transpose() {
            Ok(diagnosis) => diagnosis,
            Err(error) => {
                voice.say(format!("sideslip: this run is not held against the model: no thread to be had: {error}"));
                None
            }
        };
        let mut sink = Sink::new(None);
        let (mut log, mut unlogged) = (None, None);
        if let Some(out) = out {
            let path = free_name(out);
            match Log::start(&path, head.clone(), if telemetry_waits { Pace::Max } else { Pace::RealTime }) {
                Ok((sender, started)) => {
                    voice.say(format!("sideslip: logging to {}", path.display()));
                    sink = Sink::new(Some(sender));
                    log = Some(started);
                }
                Err(failure) => {
                    voice.say(format!("sideslip: this run has no log: {failure}"));
                    unlogged = Some(failure.to_string());
                }
            }
        }
        let others = vec![None; head.unknown_columns()];
        let row = Row { number: 0, sample: sideslip::telemetry::record::Sample::new(0.0), others };
        let last = Header { time_s: f64::NEG_INFINITY, ..Header::default() };
        Ok(LiveRun {
            head,
            info,
            pipeline: Box::new(pipeline),
            follower,
            diagnosis,
            sink,
            log,
            unlogged,
            row,
            rows: 0,
            first_s: None,
            last,
            unfitted: 0,
            undiagnosed: 0,
        })
    }

    /// Whether telemetry that began again with that head goes on with this run: the same head, and time goes on.
    pub(super) fn goes_on_with(&self, head: &LogHead, time_s: f64) -> bool {
        *head == self.head && !(time_s <= self.last.time_s)
    }

    /// One sample: estimate, publish, log.
    pub(super) fn sample(&mut self, payload: &SamplePayload, outlet: &mut Outlet) -> Result<(), Failure> {
        let header = payload.header;
        self.row.sample = payload.sample();
        self.row.others.iter_mut().zip(&payload.others).for_each(|(to, from)| *to = Some(*from));
        self.rows += 1;
        self.last = Header { time_s: self.last.time_s, ..header };
        if header.time_s.is_finite() {
            self.first_s.get_or_insert(header.time_s);
            self.last.time_s = self.last.time_s.max(header.time_s);
        }
        self.sink.row(&self.row);
        let tick = self.pipeline.step(&self.row.sample);
        outlet.tick(&header, tick)?;
        self.sink.tick(tick);
        let seen = tick.derivatives.as_ref().map(Seen::from);
        if let Some(record) = self.follower.as_mut().and_then(|follower| follower.step(&self.row.sample, seen)) {
            outlet.output_error(&header, &record)?;
            self.sink.output_error(&record);
        }
        if let Some(record) = self.diagnosis.as_mut().and_then(|diagnosis| diagnosis.step(&self.row.sample, seen)) {
            outlet.finding(&header, &record)?;
            self.sink.finding(&record);
        }
        Ok(())
    }

    /// After a backlog's sample: waits while the log's queue is more than half full, so that catching up loses nothing.
    pub(super) fn let_the_log_catch_up(&self) {
        let begun = Instant::now();
        while self.sink.is_half_full() && begun.elapsed() < CATCHING_UP {
            std::thread::sleep(Duration::from_millis(1));
        }
    }

    /// The last word: everything that came of age, the log closed.
    pub(super) fn end(mut self, outlet: &mut Outlet) -> Result<Ended, Failure> {
        let tick = self.pipeline.finish();
        outlet.tick(&self.last, tick)?;
        self.sink.tick(tick);
        if let Some(follower) = self.follower.take() {
            self.unfitted = follower.lost();
            if let Some(record) = follower.finish(LAST_FIT).last() {
                outlet.output_error(&self.last, &record)?;
                self.sink.output_error(&record);
            }
        }
        if let Some(diagnosis) = self.diagnosis.take() {
            self.undiagnosed = diagnosis.lost();
            for record in diagnosis.finish(LAST_LOOK) {
                outlet.finding(&self.last, &record)?;
                self.sink.finding(&record);
            }
        }
        self.sink.close();
        let log = self.log.map(Log::finish).transpose()?;
        let events = self.sink.events.entries().to_vec();
        let told = events.iter().filter(|event| event_severity(&event.kind) > Severity::Info);
        let controls = self.head.controls;
        let warnings = told.map(|event| FoldedText { event, controls }.to_string()).collect();
        Ok(Ended {
            name: self.info.run().unwrap_or("live").to_owned(),
            head: self.head,
            rows: self.rows,
            range_s: self.first_s.map(|from_s| (from_s, self.last.time_s)),
            sink: self.sink,
            events,
            consistency: self.pipeline.estimator().consistency(),
            noise: NoiseUsed::of(self.pipeline.estimator().noise(), self.pipeline.estimator().instrumentation()),
            warnings,
            log,
            unlogged: self.unlogged,
            unfitted: self.unfitted,
            undiagnosed: self.undiagnosed,
        })
    }
}

impl Ended {
    /// The answer for a person.
    pub(super) fn table(&self, style: Style) -> String {
        let mut text = format!("run {}: {} samples", self.name, self.rows);
        if let Some((from, to)) = self.range_s {
            let _ = write!(text, ", {from:.2} to {to:.2} s");
        }
        let (derivatives, modes) = (self.sink.derivatives.as_ref(), self.sink.modes.as_ref());
        let table = Table { controls: self.head.controls, derivatives, modes, events: &self.events, notes: &[], style };
        let _ = write!(text, "\n{table}");
        if let Some(record) = &self.sink.output_error {
            let now_s = self.range_s.map_or(record.time_s, |(_, to_s)| to_s);
            let _ = write!(text, "{}", OutputErrorTable { record, now_s, controls: self.head.controls, style });
        }
        let _ = write!(text, "{}", FindingsTable { findings: self.sink.findings.records(), style });
        if self.unfitted > 0 {
            let _ = writeln!(text, "output error did not keep up: {} samples and publications went by it", self.unfitted);
        }
        if self.undiagnosed > 0 {
            let _ = writeln!(text, "the diagnosis did not keep up: {} samples and publications went by it", self.undiagnosed);
        }
        if let Some(noise) = &self.noise {
            let _ = writeln!(text, "{noise}");
        }
        if let Some(log) = &self.log {
            let _ = writeln!(text, "log: {}, {} messages", log.path.display(), log.written);
        }
        text
    }

    /// The numbers for a program.
    pub(super) fn estimates(&self) -> RunEstimates<'_> {
        RunEstimates {
            run: &self.name,
            controls: self.head.controls,
            state: self.sink.state.as_ref(),
            derivatives: self.sink.derivatives.as_ref(),
            modes: self.sink.modes.as_ref(),
            output_error: self.sink.output_error.as_ref(),
            findings: self.sink.findings.records(),
            warnings: &self.warnings,
            consistency: self.consistency,
            noise: self.noise,
        }
    }

    /// What was lost or not used, a sentence each.
    pub(super) fn losses(&self) -> Vec<String> {
        let mut losses = self.sink.losses(self.rows);
        losses.extend(self.log.as_ref().and_then(Logged::loss));
        losses.extend(self.unlogged.iter().map(|why| format!("no log was written: {why}")));
        losses.into_iter().map(|loss| format!("run {}: {loss}", self.name)).collect()
    }
}

/// `flight.mcap`, or the first of `flight-2.mcap`, `flight-3.mcap` that is not there yet: no log is written over.
fn free_name(out: &Path) -> PathBuf {
    let stem = out.file_stem().unwrap_or_default().to_string_lossy();
    let numbered = |number: u32| match number {
        1 => out.to_path_buf(),
        _ => out.with_file_name(format!("{stem}-{number}.mcap")),
    };
    (1..).map(numbered).find(|path| path.symlink_metadata().is_err()).unwrap_or_else(|| out.to_path_buf())
}

#[cfg(test)]
mod tests {
    use super::super::super::estimation_options::OutputError;
    use super::super::outlet::Outlet;
    use super::super::voice::Voice;
    use super::{Asked, LiveRun, ModelBeside, free_name};
    use crate::allocations::during;
    use sideslip::bus::payload::{
        DerivativesPayload, EventPayload, FindingPayload, InnovationsPayload, ModesPayload, OutputErrorPayload, Payload, SAMPLE,
        SamplePayload, SmoothedPayload, StatePayload,
    };
    use sideslip::bus::service::{Bus, Subscriber};
    use sideslip::flight::channel::ControlNames;
    use sideslip::flight::log_head::LogHead;
    use sideslip::pipeline::Config;
    use sideslip::telemetry::recording::Recording;
    use std::path::Path;

    fn heard<P: Payload>(subscriber: &mut Subscriber<P>) -> u64 {
        let mut count = 0;
        while subscriber.receive().unwrap().is_some() {
            count += 1;
        }
        count
    }

    /// The middleware takes and gives back one block for each message that it sends; nothing else is allocated.
    #[test]
    fn from_a_sample_to_its_estimates_on_the_bus_and_in_the_log_nothing_of_ours_is_allocated() {
        let folder = std::env::temp_dir().join(format!("sideslip-no-allocation-{}", std::process::id()));
        std::fs::create_dir_all(&folder).unwrap();
        let bus = Bus::enter(&folder.join("root")).unwrap();
        let mut outlet = Outlet::new(&bus).unwrap();
        let (mut states, mut innovations) = (bus.subscriber::<StatePayload>().unwrap(), bus.subscriber().unwrap());
        let (mut derivatives, mut modes) = (bus.subscriber::<DerivativesPayload>().unwrap(), bus.subscriber().unwrap());
        let (mut events, mut smoothed) = (bus.subscriber::<EventPayload>().unwrap(), bus.subscriber().unwrap());
        let mut output_errors = bus.subscriber::<OutputErrorPayload>().unwrap();
        let mut findings = bus.subscriber::<FindingPayload>().unwrap();
        let head = LogHead::every_channel(String::new(), ControlNames::Rotorcraft);
        let log = folder.join("flight.mcap");
        let voice = Voice::start().unwrap();
        let own = Path::new(env!("CARGO_MANIFEST_DIR")).join("replay");
        let model = ModelBeside::read(&own.join("models/puma-like.toml"), None).unwrap();
        let asked = Asked {
            config: &Config::default(),
            output_error: OutputError::Streaming,
            model: Some(&model),
            out: Some(&log),
            telemetry_waits: false,
        };
        let mut run = LiveRun::begin(head, &asked, &voice).unwrap();
        let puma = own.join("recordings/puma-100kn-pedal-3211.csv");
        let mut recording = Recording::open(&puma).unwrap();
        let (mut rows, mut sent, mut lagged) = (0, 0, 0);
        // As where the estimator waits for samples: no service opens a connection with its first message.
        outlet.meet().unwrap();
        while let Some(row) = recording.next_row().unwrap() {
            let payload = SamplePayload::new(&row.sample, std::iter::empty(), SAMPLE);
            let allocated = during(|| run.sample(&payload, &mut outlet).unwrap());
            rows += 1;
            let of_age = heard::<SmoothedPayload>(&mut smoothed);
            lagged += of_age;
            let published = heard(&mut states)
                + of_age
                + heard::<InnovationsPayload>(&mut innovations)
                + heard(&mut derivatives)
                + heard::<ModesPayload>(&mut modes)
                + heard(&mut output_errors)
                + heard(&mut findings)
                + heard(&mut events);
            // Readers have found their publishers by then, and what grows to its size has grown.
            if rows > 0 {
                sent += published;
                assert_eq!(allocated, 2 * published, "sample {rows}");
            }
        }
        assert!(sent > 3000 && lagged > 100, "{sent} {lagged}");
        run.end(&mut outlet).unwrap();
        drop((states, smoothed, innovations, derivatives, modes, output_errors, findings, events, outlet, bus));
        std::fs::remove_dir_all(&folder).unwrap();
    }

    #[test]
    fn no_log_is_written_over() {
        let folder = std::env::temp_dir().join(format!("sideslip-free-name-{}", std::process::id()));
        std::fs::create_dir_all(&folder).unwrap();
        let first = folder.join("flight.mcap");
        assert_eq!(free_name(&first), first);
        std::fs::write(&first, "").unwrap();
        assert_eq!(free_name(&first), folder.join("flight-2.mcap"));
        std::fs::write(folder.join("flight-2.mcap"), "").unwrap();
        assert_eq!(free_name(&first), folder.join("flight-3.mcap"));
        std::fs::remove_dir_all(&folder).unwrap();
    }
}
