//! `sideslip watch`: the newest estimates out of shared memory, once a second, for a person or a program.

use super::terminal::output_file::print_while_read;
use super::terminal::stop::stopped_by_signals;
use crate::command::root_path;
use serde_json::{Value, json};
use sideslip::error::{Failure, Outcome};
use sideslip::flight::channel::ControlNames;
use sideslip::flight::file::run_file::RunInfo;
use sideslip::io::bus::payload::{FindingPayload, OutputErrorPayload};
use sideslip::io::bus::reader::{NewestEstimate, Reader};
use sideslip::io::bus::run_head::newest_head;
use sideslip::io::bus::service::Bus;
use sideslip::io::outputs::json::derivatives_json::{RunEstimates, derivatives_json};
use sideslip::io::outputs::tables::terminal::{EstimateTable, Style};
use sideslip::io::outputs::words::finding_text::FindingsTable;
use sideslip::io::outputs::words::output_error_text::OutputErrorTable;
use sideslip::io::outputs::words::status_text::StatusText;
use sideslip::postflight::diagnosis::record::{FindingRecord, FindingStatus, FindingsSoFar};
use sideslip::postflight::output_error::record::OutputErrorRecord;
use std::io::IsTerminal;
use std::path::PathBuf;
use std::sync::atomic::Ordering;
use std::time::{Duration, Instant};

const EXAMPLE: &str = "\
Example:
  sideslip watch
  sideslip watch --json | jq --unbuffered '.estimate.modes.dutch_roll'

With --json each line holds age (s), sequence, incarnation, missed, status, valid, and the estimate in the form of
derivatives.json. All but `missed`, `status` and `valid` are null before
the first estimate. It ends with ctrl-C, or when nobody reads it any more.";

/// Interval of the check whether it was stopped.
const SLICE: Duration = Duration::from_millis(20);

/// Show the latest estimates of a running estimator, once a second
#[derive(clap::Args)]
#[command(after_help = EXAMPLE)]
pub(crate) struct WatchArgs {
    /// Directory of the run: processes and readers with the same one share its data
    #[arg(long, value_name = "DIR")]
    root: Option<PathBuf>,
    /// Print a JSON object a line
    #[arg(long)]
    json: bool,
    /// Interval of the output, s
    #[arg(long, value_name = "S", default_value = "1", value_parser = interval)]
    every: Duration,
    /// End after so many outputs
    #[arg(long, value_name = "N")]
    count: Option<u64>,
}

fn interval(text: &str) -> Result<Duration, String> {
    let seconds = text.parse::<f64>().ok().filter(|seconds| (0.02..=3600.0).contains(seconds));
    seconds.map(Duration::from_secs_f64).ok_or_else(|| format!("expected seconds from 0.02 to 3600, found `{text}`"))
}

/// Prints until it is stopped.
pub(crate) fn run(args: &WatchArgs) -> Result<Outcome, Failure> {
    let stop = stopped_by_signals()?;
    let bus = Bus::enter(&root_path(args.root.as_ref()))?;
    let mut reader = Reader::on(&bus)?;
    let mut output_errors = bus.subscriber::<OutputErrorPayload>()?;
    let mut findings = bus.subscriber::<FindingPayload>()?;
    let (mut output_error, mut so_far) = (None, FindingsOfEstimator::default());
    // An estimate that was published before comes with the next one.
    let patience = Instant::now() + Duration::from_millis(500);
    while reader.latest()?.is_none() && Instant::now() < patience && !stop.load(Ordering::Relaxed) {
        std::thread::sleep(SLICE);
    }
    let mut due = Instant::now();
    let mut polls = 0;
    while !stop.load(Ordering::Relaxed) && args.count.is_none_or(|count| polls < count) {
        let now = Instant::now();
        if now < due {
            std::thread::sleep(SLICE.min(due - now));
            continue;
        }
        due = (due + args.every).max(now);
        polls += 1;
        let estimate = reader.latest()?;
        while let Some(newest) = output_errors.receive()? {
            output_error = Some(newest.record()?);
        }
        while let Some(newest) = findings.receive()? {
            so_far.update(newest.header.incarnation, &newest.record()?);
        }
        let (name, controls) = run_of(&bus);
        let shown = if args.json {
            format!("{}\n", line(&name, controls, estimate.as_ref(), output_error.as_ref(), so_far.findings.records())?)
        } else {
            screen(&name, controls, estimate.as_ref(), output_error.as_ref(), so_far.findings.records())
        };
        if !print_while_read(&shown)? {
            break;
        }
    }
    Ok(Outcome::Done)
}

/// What the diagnosis of one estimator said so far.
#[derive(Default)]
struct FindingsOfEstimator {
    incarnation: u64,
    findings: FindingsSoFar,
}

impl FindingsOfEstimator {
    /// The first word of a run ends those of the run before; so does another estimator.
    fn update(&mut self, incarnation: u64, record: &FindingRecord) {
        if incarnation != self.incarnation || record.standing == FindingStatus::Waiting {
            *self = FindingsOfEstimator { incarnation, findings: FindingsSoFar::new() };
        }
        self.findings.update(record);
    }
}

/// Name and controls of the run that telemetry announced last.
fn run_of(bus: &Bus) -> (String, ControlNames) {
    let head = newest_head(bus.root()).ok().flatten();
    let controls = head.as_ref().map_or(ControlNames::Rotorcraft, |head| head.controls);
    let info = head.and_then(|head| RunInfo::from_toml(&head.run_toml).ok());
    (info.and_then(|info| info.run().map(str::to_owned)).unwrap_or_else(|| "live".to_owned()), controls)
}

fn screen(
    name: &str,
    controls: ControlNames,
    estimate: Option<&NewestEstimate>,
    output_error: Option<&OutputErrorRecord>,
    findings: &[FindingRecord],
) -> String {
    // A terminal shows the newest only; elsewhere one stands below the other.
    let clear = if std::io::stdout().is_terminal() { "\x1b[H\x1b[2J" } else { "" };
    let Some(estimate) = estimate else { return format!("{clear}no estimate yet\n") };
    let status = StatusText { status: estimate.status, controls };
    let NewestEstimate { derivatives, modes, age, sequence, missed, .. } = estimate;
    let style = Style::of_stream(&std::io::stdout());
    let table = EstimateTable { controls, derivatives: Some(derivatives), modes: Some(modes), events: &[], notes: &[], style };
    let now_s = derivatives.time_s;
    let fitted = output_error.map(|record| OutputErrorTable { record, now_s, controls, style }.to_string()).unwrap_or_default();
    let held = FindingsTable { findings, style };
    let age_s = age.as_secs_f64();
    format!("{clear}run {name}, estimate {sequence}, {age_s:.2} s old, {missed} missed: {status}\n{table}{fitted}{held}\n")
}

fn line(
    name: &str,
    controls: ControlNames,
    estimate: Option<&NewestEstimate>,
    output_error: Option<&OutputErrorRecord>,
    findings: &[FindingRecord],
) -> Result<Value, Failure> {
    let Some(estimate) = estimate else {
        return Ok(json!({
            "age": null,
            "sequence": null,
            "incarnation": null,
            "missed": 0,
            "status": "waiting",
            "valid": false,
            "estimate": null,
        }));
    };
    let run = RunEstimates {
        run: name,
        controls,
        state: None,
        derivatives: Some(&estimate.derivatives),
        modes: Some(&estimate.modes),
        output_error,
        findings,
        warnings: &[],
        consistency: [None, None],
        noise: None,
    };
    let wrong = |error: serde_json::Error| Failure::Running(error.to_string());
    let document: Value = serde_json::from_str(&derivatives_json(&[run]).map_err(wrong)?).map_err(wrong)?;
    Ok(json!({
        "age": estimate.age.as_secs_f64(),
        "sequence": estimate.sequence,
        "incarnation": estimate.incarnation,
        "missed": estimate.missed,
        "status": StatusText { status: estimate.status, controls }.to_string(),
        "valid": estimate.is_valid(),
        "estimate": document.pointer("/runs/0"),
    }))
}
