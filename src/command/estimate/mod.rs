//! `sideslip estimate`: samples out of shared memory through the pipeline; estimates back into it and into a log.

mod live_run;

use super::options::estimation_options::{EstimationOptions, OutputErrorSchedule};
use super::options::live_diagnosis_options::LiveDiagnosisModel;
use super::options::mavlink_out_options::MavlinkOutOptions;
use super::options::replace_option::ReplaceOption;
use super::recordings::provenance::Provenance;
use super::terminal::console::answer;
use super::terminal::stop::{stopped_by_signals, supervised};
use crate::command::{message, message_text, patience, root_path};
use live_run::{FinishedLiveRun, LiveRun, LiveRunSetup};
use sideslip::error::{Failure, Outcome};
use sideslip::flight::channel::ControlNames;
use sideslip::flight::file::log_head::LogHead;
use sideslip::flight::run::RunGeometry;
use sideslip::io::bus::clock::monotonic_ns;
use sideslip::io::bus::payload::{SAMPLE_TO_ACKNOWLEDGE, SamplePayload, THE_END};
use sideslip::io::bus::root::BusRole;
use sideslip::io::bus::run_head::read_head;
use sideslip::io::bus::service::{Bus, Subscriber};
use sideslip::io::ground_station::station::GroundStation;
use sideslip::io::outputs::json::derivatives_json::derivatives_json;
use sideslip::io::outputs::json::document_schema::DocumentSchema;
use sideslip::io::outputs::tables::terminal::Style;
use sideslip::live::estimate_publisher::EstimatePublisher;
use sideslip::realtime::pipeline::{Pipeline, PipelineConfig};
use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

const EXAMPLE: &str = "\
Example, in three terminals:
  sideslip estimate --out flight.mcap
  sideslip ingest --source file://flight.csv
  sideslip watch
To a ground station too:
  sideslip estimate --mavlink-out udpout://127.0.0.1:14551 --signing-key flight.key

It ends with ctrl-C, SIGTERM or SIGHUP, with the log closed and the answer printed. A run ends where telemetry says so, or begins
again at an earlier time; the next one gets a log of its own, flight-2.mcap. No log is written over.

Exit status: 0 done; 1 failed while running; 2 the call is wrong, or another estimator is in this root; 3 done, with data
lost (said how much).";

/// Polling interval of the bus while samples come: the largest part of the latency, and some percent of a core.
const POLL: Duration = Duration::from_micros(100);
/// The same where nothing has come for [`QUIET`].
const POLL_QUIET: Duration = Duration::from_millis(1);
const QUIET: Duration = Duration::from_millis(250);

/// A sample that has waited so long belongs to a backlog, whose log may be waited for.
const BACKLOG: Duration = Duration::from_millis(100);

/// Ended runs that are kept for `--json`.
const RUNS_KEPT: usize = 64;

/// Estimate from shared memory: state, derivatives, Dutch roll, innovations and events back into it and into a log
#[derive(clap::Args)]
#[command(after_help = EXAMPLE)]
pub(crate) struct EstimateArgs {
    /// Directory of the run: processes and readers with the same one share its data
    #[arg(long, value_name = "DIR")]
    root: Option<PathBuf>,
    /// Write an MCAP log; a further run or a restart takes the next free name
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
    /// Write the last estimates as JSON to this file at the end, or to standard output with -
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
    #[command(flatten)]
    estimation: EstimationOptions,
    #[command(flatten)]
    station: MavlinkOutOptions,
    /// Key of MAVLink 2 signing, 64 hexadecimal digits or 32 raw bytes, for what is sent to the ground station. Timestamps are
    /// kept in FILE.timestamp-1
    #[arg(long, value_name = "FILE", requires = "mavlink_out")]
    signing_key: Option<PathBuf>,
    #[command(flatten)]
    replace: ReplaceOption,
    /// End when standard input ends
    #[arg(long, hide = true)]
    supervised: bool,
}

/// Estimates until it is stopped.
pub(crate) fn run(args: &EstimateArgs) -> Result<Outcome, Failure> {
    let stop = stopped_by_signals()?;
    supervised(args.supervised, &stop)?;
    if let Some(out) = args.out.as_ref().filter(|out| out.extension().is_none_or(|ending| ending != "mcap")) {
        return Err(Failure::file(out, "--out: expected a name that ends in .mcap"));
    }
    args.replace.refuse_each([("--json", args.json.as_deref())])?;
    let config = args.estimation.config();
    // A wrong setting is the call's fault, not the first run's.
    Pipeline::new(&config, RunGeometry::default()).map_err(|wrong| Failure::Input(wrong.to_string()))?;
    let model = args.estimation.live_diagnosis_model()?;
    let mut bus = Bus::enter(&root_path(args.root.as_ref()))?;
    let _role = bus.take_within(BusRole::Estimator, patience(args.supervised))?;
    let publisher = EstimatePublisher::new(&bus)?;
    let samples = bus.subscriber()?;
    let station = args.station.start(args.signing_key.as_deref())?;
    let mut process = EstimatorProcess {
        args,
        config,
        model,
        bus: &bus,
        samples,
        publisher,
        station,
        run: None,
        incarnation: None,
        ended: Vec::new(),
    };
    let worked = process.work(&stop);
    let closed = process.end_run();
    let answered = process.answer();
    worked.and(closed)?;
    answered
}

/// The estimator at its place.
struct EstimatorProcess<'a> {
    args: &'a EstimateArgs,
    config: PipelineConfig,
    model: Option<LiveDiagnosisModel>,
    bus: &'a Bus,
    samples: Subscriber<SamplePayload>,
    publisher: EstimatePublisher,
    station: Option<GroundStation>,
    run: Option<LiveRun>,
    incarnation: Option<u64>,
    ended: Vec<FinishedLiveRun>,
}

impl EstimatorProcess<'_> {
    fn work(&mut self, stop: &AtomicBool) -> Result<(), Failure> {
        let mut heard = Instant::now();
        while !stop.load(Ordering::Relaxed) {
            match self.samples.receive()? {
                Some(sample) => {
                    self.take(&sample)?;
                    heard = Instant::now();
                }
                None => {
                    self.publisher.meet()?;
                    std::thread::sleep(if heard.elapsed() < QUIET { POLL } else { POLL_QUIET });
                }
            }
        }
        // What had come by then belongs to the run.
        while let Some(sample) = self.samples.receive()? {
            self.take(&sample)?;
        }
        Ok(())
    }

    fn take(&mut self, sample: &SamplePayload) -> Result<(), Failure> {
        if sample.kind == THE_END {
            self.end_run()?;
        } else {
            if self.incarnation != Some(sample.header.incarnation) || self.run.is_none() {
                self.telemetry_began(sample)?;
            }
            if let Some(run) = &mut self.run {
                run.sample(sample, &mut self.publisher)?;
                let waited = monotonic_ns().saturating_sub(sample.header.published_ns);
                if Duration::from_nanos(waited) > BACKLOG {
                    run.let_the_log_catch_up();
                }
            }
        }
        Ok(self.publisher.taken(sample)?)
    }

    /// The first sample of a life of the telemetry: the run goes on, or another begins.
    fn telemetry_began(&mut self, sample: &SamplePayload) -> Result<(), Failure> {
        let incarnation = sample.header.incarnation;
        let head = read_head(self.bus.root(), incarnation)?.unwrap_or_else(|| {
            let what = "sideslip: telemetry has no run header; instruments are assumed at the centre of mass";
            message(format_args!("{what}"));
            LogHead::every_channel(String::new(), ControlNames::Rotorcraft)
        });
        let known = self.incarnation.replace(incarnation).is_some();
        if self.run.as_ref().is_some_and(|run| run.goes_on_with(&head, sample.header.time_s)) {
            if known {
                message(format_args!("sideslip: telemetry began again; the run goes on"));
            }
            return Ok(());
        }
        self.end_run()?;
        let when = self.args.estimation.output_error_schedule(OutputErrorSchedule::Streaming);
        let telemetry_waits = sample.kind == SAMPLE_TO_ACKNOWLEDGE;
        let setup = LiveRunSetup {
            config: &self.config,
            output_error: when,
            model: self.model.as_ref(),
            out: self.args.out.as_deref(),
            telemetry_waits,
            station: self.station.as_ref(),
        };
        self.run = Some(LiveRun::begin(head, &setup)?);
        Ok(())
    }

    /// Ends the run that there is, and prints what it came to.
    fn end_run(&mut self) -> Result<(), Failure> {
        let Some(run) = self.run.take() else { return Ok(()) };
        let ended = run.end(&mut self.publisher)?;
        if self.to_standard_output() {
            message_text(ended.table(Style::of_stream(&std::io::stderr())).trim_end_matches('\n'));
        } else {
            answer(&ended.table(Style::of_stream(&std::io::stdout())));
        }
        if self.ended.len() == RUNS_KEPT {
            self.ended.remove(0);
        }
        self.ended.push(ended);
        Ok(())
    }

    fn to_standard_output(&self) -> bool {
        self.args.json.as_ref().is_some_and(|json| json.as_os_str() == "-")
    }

    fn answer(self) -> Result<Outcome, Failure> {
        if let Some(json) = &self.args.json {
            let estimates: Vec<_> = self.ended.iter().map(FinishedLiveRun::estimates).collect();
            let text = derivatives_json(&estimates).map_err(|error| Failure::Running(error.to_string()))?;
            Provenance::of(self.args.estimation.files()).write_json(json, DocumentSchema::Estimates, &text)?;
        }
        let mut losses: Vec<String> = self.ended.iter().flat_map(FinishedLiveRun::losses).collect();
        let (missed, stale) = (self.samples.missed(), self.samples.stale());
        if missed > 0 {
            losses.push(format!("{missed} samples were overwritten in shared memory before the estimator took them"));
        }
        if stale > 0 {
            losses.push(format!("{stale} samples of an earlier telemetry came after those of a later one and were dropped"));
        }
        for loss in &losses {
            message(format_args!("sideslip: {loss}"));
        }
        if let Some(station) = self.station {
            message(format_args!("sideslip: {}", self.args.station.finish(station)));
        }
        Ok(if losses.is_empty() { Outcome::Done } else { Outcome::DataLost })
    }
}
