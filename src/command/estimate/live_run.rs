//! One run of the estimator: samples of shared memory through the wiring, records published and logged.

use crate::command::message;
use crate::command::options::estimation_options::OutputErrorSchedule;
use crate::command::options::live_diagnosis_options::LiveDiagnosisModel;
use crate::command::recordings::provenance::Provenance;
use crate::command::recordings::run_log::RunLog;
use crate::command::recordings::run_result::RunResult;
use ::replay::Pace;
use sideslip::error::Failure;
use sideslip::flight::file::log_head::LogHead;
use sideslip::flight::file::run_file::RunInfo;
use sideslip::flight::file::time_stamp::TimeStamp;
use sideslip::io::bus::payload::{MessageHeader, SamplePayload};
use sideslip::io::ground_station::station::GroundStation;
use sideslip::io::outputs::json::derivatives_json::RunEstimates;
use sideslip::io::outputs::tables::terminal::Style;
use sideslip::io::outputs::words::control_scale::assumed_scale;
use sideslip::io::outputs::words::printable::printable;
use sideslip::io::telemetry::mavlink::senders::Sender;
use sideslip::io::telemetry::record::RecordingRow;
use sideslip::live::estimate_publisher::EstimatePublisher;
use sideslip::live::record_sink::RecordSink;
use sideslip::live::wiring::{Schedule, WiredRun};
use sideslip::realtime::pipeline::{Pipeline, PipelineConfig};
use std::fmt::Write;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};
use std::time::{SystemTime, UNIX_EPOCH};

/// The longest wait for a log that does not catch up.
const CATCHING_UP: Duration = Duration::from_millis(200);
/// A run that is being estimated.
pub(super) struct LiveRun {
    head: LogHead,
    info: RunInfo,
    wired: WiredRun,
    log: Option<RunLog>,
    /// Why there is none, where one was wanted.
    unlogged: Option<String>,
    row: RecordingRow,
    first_s: Option<f64>,
    last: MessageHeader,
}

/// What a run is begun with.
pub(super) struct LiveRunSetup<'a> {
    pub(super) config: &'a PipelineConfig,
    pub(super) output_error: OutputErrorSchedule,
    /// The model of the live diagnosis.
    pub(super) model: Option<&'a LiveDiagnosisModel>,
    pub(super) out: Option<&'a Path>,
    /// Whether telemetry waits for the estimator.
    pub(super) telemetry_waits: bool,
    /// The way to the ground station, where there is one.
    pub(super) station: Option<&'a GroundStation>,
}

pub(super) struct FinishedLiveRun {
    result: RunResult,
    unlogged: Option<String>,
}

impl LiveRun {
    /// Begins a run; its log takes the first free name after `out`. Where telemetry waits for the estimator, the estimator
    /// waits for the log; else nothing waits.
    ///
    /// A log that cannot be opened is said and counted as lost: estimates come without it.
    pub(super) fn begin(head: LogHead, setup: &LiveRunSetup<'_>) -> Result<Self, Failure> {
        let LiveRunSetup { config, output_error, model, out, telemetry_waits, station } = *setup;
        let wrong = |what: String| Failure::Running(format!("the head of the run: {what}"));
        let mut info = RunInfo::from_toml(&head.run_toml).map_err(|place| wrong(place.to_string()))?;
        info.set_controls(head.controls);
        if let Some(note) = assumed_scale(&info) {
            message(format_args!("note: {note}"));
        }
        let pipeline = Pipeline::new(config, *info.geometry()).map_err(|wrong| Failure::Input(wrong.to_string()))?;
        let output_error = match output_error.live(*info.geometry()).map(Schedule::thread).transpose() {
            Ok(output_error) => output_error,
            Err(error) => {
                message(format_args!("sideslip: this run has no output error: no thread could be started: {error}"));
                None
            }
        };
        let diagnosis = match model.map(|model| Schedule::thread(model.live(*info.geometry()))).transpose() {
            Ok(diagnosis) => diagnosis,
            Err(error) => {
                message(format_args!("sideslip: this run is not compared with the model: no thread could be started: {error}"));
                None
            }
        };
        let mut wired = WiredRun::new(pipeline, info.geometry().controls, output_error, diagnosis);
        let (mut log, mut unlogged) = (None, None);
        if let Some(out) = out {
            let path = free_name(out);
            match RunLog::start(&path, log_head(&head, &info), if telemetry_waits { Pace::Max } else { Pace::RealTime }) {
                Ok((sender, started)) => {
                    message(format_args!("sideslip: logging to {}", path.display()));
                    wired.sink = RecordSink::new(Some(sender));
                    log = Some(started);
                }
                Err(failure) => {
                    message(format_args!("sideslip: this run has no log: {failure}"));
                    unlogged = Some(failure.to_string());
                }
            }
        }
        if let Some(station) = station {
            let system = info.text("source").and_then(Sender::from_source).map(|vehicle| vehicle.system);
            let to_station = station.begin_run(name(&info), head.controls, system);
            if to_station.is_none() {
                message(format_args!("sideslip: this run does not go to the ground station, which is too far behind"));
            }
            wired.sink.set_station(to_station);
        }
        let others = vec![None; head.unknown_columns()];
        let row = RecordingRow { number: 0, sample: sideslip::flight::sample::Sample::new(0.0), others };
        let last = MessageHeader { time_s: f64::NEG_INFINITY, ..MessageHeader::default() };
        Ok(LiveRun { head, info, wired, log, unlogged, row, first_s: None, last })
    }

    /// Whether telemetry that began again with that head goes on with this run: the same head, and time goes on.
    pub(super) fn goes_on_with(&self, head: &LogHead, time_s: f64) -> bool {
        *head == self.head && !(time_s <= self.last.time_s)
    }

    /// One sample: estimate, publish, log.
    pub(super) fn sample(&mut self, payload: &SamplePayload, publisher: &mut EstimatePublisher) -> Result<(), Failure> {
        let header = payload.header;
        self.row.sample = payload.sample();
        self.row.others.iter_mut().zip(&payload.others).for_each(|(to, from)| *to = Some(*from));
        self.last = MessageHeader { time_s: self.last.time_s, ..header };
        if header.time_s.is_finite() {
            self.first_s.get_or_insert(header.time_s);
            self.last.time_s = self.last.time_s.max(header.time_s);
        }
        Ok(self.wired.step(&self.row, &mut publisher.of_sample(header))?)
    }

    /// After a backlog's sample: waits while the log's queue is more than half full, so that catching up loses nothing.
    pub(super) fn let_the_log_catch_up(&self) {
        let begun = Instant::now();
        while self.wired.sink.is_half_full() && begun.elapsed() < CATCHING_UP {
            std::thread::sleep(Duration::from_millis(1));
        }
    }

    /// Ends the run: lagged records, the last fit and diagnosis, the log closed.
    pub(super) fn end(self, publisher: &mut EstimatePublisher) -> Result<FinishedLiveRun, Failure> {
        let finished = self.wired.finish(&mut publisher.of_sample(self.last))?;
        let log = self.log.map(RunLog::finish).transpose()?;
        let range_s = self.first_s.map(|from_s| (from_s, self.last.time_s));
        let result = RunResult::new(name(&self.info).to_owned(), self.head.controls, range_s, finished, log);
        Ok(FinishedLiveRun { result, unlogged: self.unlogged })
    }
}

impl FinishedLiveRun {
    pub(super) fn table(&self, style: Style) -> String {
        let mut text = format!("run {}: {} samples", printable(&self.result.name), self.result.rows);
        if let Some((from, to)) = self.result.range_s {
            let _ = write!(text, ", {from:.2} to {to:.2} s");
        }
        let _ = write!(text, "\n{}", self.result.tables(style));
        text
    }

    pub(super) fn estimates(&self) -> RunEstimates<'_> {
        self.result.estimates()
    }

    /// Data that were lost or not used, a sentence each.
    pub(super) fn losses(&self) -> Vec<String> {
        let mut losses = self.result.losses();
        losses.extend(self.unlogged.iter().map(|why| format!("no log was written: {why}")));
        losses.into_iter().map(|loss| format!("run {}: {loss}", self.result.name)).collect()
    }
}

/// What the run is called.
fn name(info: &RunInfo) -> &str {
    info.run().unwrap_or("live")
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

/// The head of the log: this call, the files of the process that brought the samples in, and the host's date where they come
/// from no file and the run has none.
fn log_head(head: &LogHead, info: &RunInfo) -> LogHead {
    let mut dated = info.clone();
    let since_1970 = SystemTime::now().duration_since(UNIX_EPOCH).ok().filter(|_| !head.origin.contains_key("files"));
    let now = since_1970.and_then(|since| TimeStamp::of_unix_us(u64::try_from(since.as_micros()).ok()?).iso());
    if let Some(now) = now {
        dated.add_text("recorded_at", &now);
    }
    let origin = Provenance::default().origin_after(&head.origin);
    LogHead { run_toml: dated.to_toml(), origin, ..head.clone() }
}

#[cfg(test)]
mod tests {
    use super::{GroundStation, LiveDiagnosisModel, LiveRun, LiveRunSetup, free_name};
    use crate::allocations::during;
    use crate::command::options::estimation_options::OutputErrorSchedule;
    use sideslip::flight::channel::ControlNames;
    use sideslip::flight::file::log_head::LogHead;
    use sideslip::io::bus::payload::{
        DerivativesPayload, EventPayload, FindingPayload, InnovationsPayload, ModesPayload, OutputErrorPayload, Payload, SAMPLE,
        SamplePayload, SmoothedPayload, StatePayload,
    };
    use sideslip::io::bus::service::{Bus, Subscriber};
    use sideslip::io::ground_station::station::StationSettings;
    use sideslip::io::telemetry::mavlink::link::Url;
    use sideslip::io::telemetry::recording::Recording;
    use sideslip::live::estimate_publisher::EstimatePublisher;
    use sideslip::realtime::pipeline::PipelineConfig;
    use std::net::UdpSocket;
    use std::path::Path;
    use std::time::Duration;

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
        let mut publisher = EstimatePublisher::new(&bus).unwrap();
        let (mut states, mut innovations) = (bus.subscriber::<StatePayload>().unwrap(), bus.subscriber().unwrap());
        let (mut derivatives, mut modes) = (bus.subscriber::<DerivativesPayload>().unwrap(), bus.subscriber().unwrap());
        let (mut events, mut smoothed) = (bus.subscriber::<EventPayload>().unwrap(), bus.subscriber().unwrap());
        let mut output_errors = bus.subscriber::<OutputErrorPayload>().unwrap();
        let mut findings = bus.subscriber::<FindingPayload>().unwrap();
        let head = LogHead::every_channel(String::new(), ControlNames::Rotorcraft);
        let log = folder.join("flight.mcap");
        let own = Path::new(env!("CARGO_MANIFEST_DIR")).join("replay");
        let model = LiveDiagnosisModel::read(&own.join("models/puma-like.toml"), None).unwrap();
        // A ground station on this machine that takes nothing: the thread's own work is not the estimator's.
        let nobody = UdpSocket::bind("127.0.0.1:0").unwrap();
        let url = Url::UdpOut(nobody.local_addr().unwrap().to_string());
        let settings = StationSettings { url, system: None, signing: None };
        let station = GroundStation::start(settings, Box::new(|_| {})).unwrap();
        let setup = LiveRunSetup {
            config: &PipelineConfig::default(),
            output_error: OutputErrorSchedule::Streaming,
            model: Some(&model),
            out: Some(&log),
            telemetry_waits: false,
            station: Some(&station),
        };
        let mut run = LiveRun::begin(head, &setup).unwrap();
        let puma = own.join("recordings/puma-100kn-pedal-3211.csv");
        let mut recording = Recording::open(&puma).unwrap();
        let (mut rows, mut sent, mut lagged) = (0, 0, 0);
        // As where the estimator waits for samples: no service opens a connection with its first message.
        publisher.meet().unwrap();
        while let Some(row) = recording.next_row().unwrap() {
            let payload = SamplePayload::new(&row.sample, std::iter::empty(), SAMPLE);
            let allocated = during(|| run.sample(&payload, &mut publisher).unwrap());
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
        run.end(&mut publisher).unwrap();
        let report = station.finish(Duration::from_secs(30)).unwrap();
        assert!(report.sent > 20 && report.refused == 0, "{report:?}");
        drop((states, smoothed, innovations, derivatives, modes, output_errors, findings, events, publisher, bus));
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
