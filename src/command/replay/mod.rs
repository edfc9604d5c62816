//! `sideslip replay`: recordings through the very pipeline that runs live, at their own pace or as fast as it goes.

mod bus_source;
mod derivative_history;
mod output_per_recording;
mod replayed_run;
mod smoothed_file;

use super::options::estimation_options::{EstimationOptions, OutputErrorSchedule};
use super::options::mapping_input::{CONFIG_HELP, MapOption, read_mapping};
use super::options::replace_option::ReplaceOption;
use super::options::run_parts::PartOptions;
use super::options::telemetry_source::RecordingSource;
use super::recordings::chosen_runs::chosen_runs;
use super::recordings::provenance::Provenance;
use super::recordings::run_names::tell_apart;
use super::terminal::console::{message_once, print};
use super::terminal::output_file::{refuse_to_overwrite, refuse_without_folder, same_place};
use super::terminal::stop::stopped_by_signals;
use crate::command::{message, message_text};
use derivative_history::HISTORIES;
use output_per_recording::{LOGS, make_directory};
use replayed_run::{ReplayFiles, ReplayRun, ReplaySource, ReplayedRun};
use sideslip::error::{Failure, Outcome};
use sideslip::io::outputs::json::derivatives_json::derivatives_json;
use sideslip::io::outputs::json::document_schema::DocumentSchema;
use sideslip::io::outputs::tables::terminal::Style;
use std::path::PathBuf;
use std::sync::atomic::Ordering;

const EXAMPLE: &str = "\
Example:
  sideslip replay flight.csv
  sideslip replay flight.csv --set 'vane_position_m=[13.08,0,0]' --out flight.mcap --json flight.json
  sideslip replay flight.csv --smoothed states.csv
  sideslip replay flight.csv --bus
  sideslip replay day.csv --manoeuvre 2
  sideslip replay monday/*.csv --out logs/ --json - | jq '.runs[].modes.dutch_roll'

Every FILE is a run of its own, with its own trim: the mean over its first second. A log holds the keys of the run as
they were in effect, so that replaying it without --set gives the same numbers; --trim-window is no such key. Smoothed states
use the whole record: to plot and to compare with; estimating from them again would use the same data twice.

Exit status: 0 done; 1 failed while running, or stopped by a signal (what there was by then is printed); 2 the call or a
recording is wrong; 3 done, with data lost or skipped; 4 no derivative could be estimated. With --json - the table goes to standard error.";

/// Play recordings through the estimator: derivatives, Dutch roll, errors of the instruments
#[derive(clap::Args)]
#[command(after_help = EXAMPLE)]
pub(crate) struct ReplayArgs {
    /// Recordings; their format is recognised by their content; a stream of PCM is
    /// pcm+file://PATH?format=FRAME.toml, Chapter 10 whose setup does not name the channels ch10+file://PATH?format=FILE.toml
    #[arg(required = true, value_name = "FILE", value_parser = RecordingSource::parser())]
    files: Vec<RecordingSource>,
    /// How fast: 1 is real time, 4 four times as fast, max as fast as it goes
    #[arg(long, value_name = "1|N|max", default_value = "max")]
    speed: ::replay::Pace,
    /// Write an MCAP log: a file name for one FILE; for several a directory (made where it is missing), a log for each
    #[arg(long, value_name = "FILE|DIR")]
    out: Option<PathBuf>,
    /// Write the state at every sample, smoothed over the whole recording, with standard deviations: a name that ends in .csv
    /// (a run file) or .mcap (the recording with /smoothed); for several FILEs a directory, a CSV for each
    #[arg(long, value_name = "FILE|DIR")]
    smoothed: Option<PathBuf>,
    /// Write derivatives with standard errors, and the Dutch roll, against time (CSV): a file name for one FILE; for several a
    /// directory, a CSV for each
    #[arg(long, value_name = "FILE|DIR")]
    derivatives: Option<PathBuf>,
    /// Override a key of every run, such as vane_position_m=[13.08,0,0] or latency_s={tas=0.25} (channels stamped late, s);
    /// RUN:KEY=VALUE of that recording alone; repeatable
    #[arg(long, value_name = "[RUN:]KEY=VALUE")]
    set: Vec<String>,
    /// Write the last estimates as JSON to this file, or to standard output with -
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
    /// Which message (MAVLink) or measurement (IRIG 106 Chapter 10) carries which channel, or the format of PCM frames in Chapter
    /// 10 packets (TOML)
    #[arg(long, value_name = "FILE", long_help = CONFIG_HELP)]
    config: Option<PathBuf>,
    #[command(flatten)]
    map: MapOption,
    #[command(flatten)]
    parts: PartOptions,
    /// Through shared memory: the recording is brought in by another process, nothing is lost on the way
    #[arg(long)]
    bus: bool,
    #[command(flatten)]
    estimation: EstimationOptions,
    #[command(flatten)]
    replace: ReplaceOption,
}

/// Plays every recording and prints what it came to.
pub(crate) fn run(args: &ReplayArgs) -> Result<Outcome, Failure> {
    let config = args.estimation.config();
    let to_standard_output = args.json.as_ref().is_some_and(|json| json.as_os_str() == "-");
    let read: Vec<PathBuf> = args.files.iter().flat_map(RecordingSource::files).collect();
    if let Some(json) = args.json.as_ref().filter(|_| !to_standard_output) {
        refuse_to_overwrite("--json", json, &read)?;
    }
    args.replace.refuse_each([("--json", args.json.as_deref())])?;
    let mapping = read_mapping(args.config.as_deref(), &args.map)?;
    let [sources] = chosen_runs([&args.files], &args.parts, &args.set, &mapping)?;
    let logs = LOGS.places(args.out.as_deref(), &sources)?;
    let states = smoothed_file::STATES.places(args.smoothed.as_deref(), &sources)?;
    for file in states.iter().flatten() {
        if logs.iter().flatten().chain(args.json.as_ref()).any(|other| same_place(other, file)) {
            return Err(Failure::file(file, "--smoothed: expected another file than that of --out or --json, found the same"));
        }
    }
    let histories = HISTORIES.places(args.derivatives.as_deref(), &sources)?;
    for file in histories.iter().flatten() {
        if logs.iter().chain(&states).flatten().chain(args.json.as_ref()).any(|other| same_place(other, file)) {
            return Err(Failure::file(
                file,
                "--derivatives: expected another file than those of the other options, found the same",
            ));
        }
    }
    if let [Some(file)] = histories.as_slice() {
        refuse_without_folder("--derivatives", file)?;
    }
    if let [Some(file)] = states.as_slice() {
        refuse_without_folder("--smoothed", file)?;
    }
    if let Some(json) = args.json.as_ref().filter(|json| logs.iter().flatten().any(|log| log == *json)) {
        return Err(Failure::file(json, "--json: expected another file than the log of --out, found the same"));
    }
    for (option, files) in [("--out", &logs), ("--smoothed", &states), ("--derivatives", &histories)] {
        files.iter().flatten().try_for_each(|file| args.replace.refuse(option, file))?;
    }
    let model = args.estimation.live_diagnosis_model()?;
    let output_error = args.estimation.output_error_schedule(OutputErrorSchedule::Manoeuvre);
    let open = |source: &RecordingSource| {
        Ok(ReplayRun::open(source, &config, &mapping)?.with_output_error(output_error).with_diagnosis(model.as_ref()))
    };
    let mut runs = sources.iter().map(open).collect::<Result<Vec<_>, Failure>>()?;
    tell_apart(runs.iter_mut().map(|run| &mut run.name), &sources.iter().collect::<Vec<_>>());
    make_directory(args.out.as_deref(), &logs)?;
    make_directory(args.smoothed.as_deref(), &states)?;
    make_directory(args.derivatives.as_deref(), &histories)?;
    let stop = stopped_by_signals()?;
    let mut played = Vec::with_capacity(runs.len());
    for (((run, log), states), derivatives) in runs.into_iter().zip(logs).zip(states).zip(histories) {
        let answer = {
            let from =
                if args.bus { ReplaySource::Bus { config: args.config.as_deref(), map: &args.map } } else { ReplaySource::File };
            let files = ReplayFiles { log: log.as_deref(), smoothed: states.as_deref(), derivatives: derivatives.as_deref() };
            run.play(&from, args.speed, &files, &stop)?
        };
        let style = if to_standard_output { Style::of_stream(&std::io::stderr()) } else { Style::of_stream(&std::io::stdout()) };
        let gap = if played.is_empty() { "" } else { "\n" };
        let table = format!("{gap}{}", answer.table(style));
        if to_standard_output {
            message_text(table.trim_end_matches('\n'))
        } else {
            print(&table)?
        }
        played.push(answer);
        if stop.load(Ordering::Relaxed) {
            break;
        }
    }
    if let Some(json) = &args.json {
        let estimates: Vec<_> = played.iter().map(ReplayedRun::estimates).collect();
        let text = derivatives_json(&estimates).map_err(|error| Failure::Running(error.to_string()))?;
        let read = read.into_iter().chain(args.config.clone()).chain(args.map.map.clone());
        let provenance = played.iter().map(ReplayedRun::date).fold(Provenance::of(read), |all, (file, at)| all.dated(file, at));
        provenance.write_json(json, DocumentSchema::Estimates, &text)?;
    }
    let losses: Vec<String> = played.iter().flat_map(ReplayedRun::losses).collect();
    for loss in &losses {
        message_once(format_args!("sideslip: {loss}"));
    }
    let unplayed = sources.len() - played.len();
    if let Some(last) = played.last().filter(|last| last.interrupted || unplayed > 0) {
        return Err(Failure::Running(last.interruption(unplayed)));
    }
    if !played.iter().any(ReplayedRun::has_derivatives) {
        message(format_args!(
            "sideslip: no derivative could be estimated: the status of each equation says why; `sideslip inspect` lists what the channels \
             of a recording allow"
        ));
        return Ok(Outcome::NotGood);
    }
    Ok(if losses.is_empty() { Outcome::Done } else { Outcome::DataLost })
}
