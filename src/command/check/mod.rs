//! `sideslip check`: do a run's instruments agree with each other, and what is wrong where they do not?

mod interpretation;
mod json;
mod read_run;
mod table;

use super::options::fitted_runs::refuse_twice;
use super::options::mapping_input::{CONFIG_HELP, MapOption, read_mapping};
use super::options::replace_option::ReplaceOption;
use super::options::run_parts::PartOptions;
use super::options::telemetry_source::RecordingSource;
use super::recordings::chosen_runs::chosen_runs;
use super::recordings::provenance::Provenance;
use super::recordings::run_input::screened;
use super::recordings::run_names::tell_apart;
use super::terminal::console::{message_once, print};
use super::terminal::output_file::{refuse_to_overwrite, refuse_without_folder};
use crate::command::{message, message_text};
use read_run::read;
use sideslip::error::{Failure, Outcome};
use sideslip::flight::channel::ControlNames;
use sideslip::flight::file::run_file::RunInfo;
use sideslip::io::outputs::json::document_schema::DocumentSchema;
use sideslip::io::outputs::tables::terminal::Style;
use sideslip::io::outputs::words::control_scale::assumed_names;
use sideslip::postflight::reconstruction::verdict::{Fitness, check};
use sideslip::postflight::recorded_run::RecordedRun;
use std::io::IsTerminal;
use std::path::PathBuf;

const EXAMPLE: &str = "\
Example:
  sideslip check flight.csv
  sideslip check monday/*.csv --json - | jq '.runs[].verdict'
  sideslip check flight.csv --set 'vane_position_m=[13.1,0,0]'

Rates, accelerometers, attitude and air data measure one motion: what contradicts it is an error of an instrument. Samples that no
instrument measured (spikes, frozen or zeroed stretches) are not used, and counted; a reversed sign, a wrong unit and two
exchanged channels are tested first. All runs are then fitted together: scale factors, lags, time skews and positions are common
to all of them, biases are estimated for each run; an outlier run is checked by itself. A correction is reported where it is
significant against the (coloured) noise and against the tolerance of healthy instruments; where two explanations fit equally
well, both are reported. A run needs 5 s, rates at 8 Hz, and motion.

Exit status: 0 all runs are fit, some perhaps after corrections; 1 failed while running; 2 the call or a recording is wrong;
3 all fit, but rows were skipped or samples not used; 4 a run is not fit for identification. With --json the table goes to
standard error.";

/// Check instruments against the kinematics: biases, factors, lags, skews and positions, and whether a run is fit
#[derive(clap::Args)]
#[command(after_help = EXAMPLE)]
pub(crate) struct CheckArgs {
    /// Recordings, a run each; their format is recognised by their content; a stream of PCM is
    /// pcm+file://PATH?format=FRAME.toml, Chapter 10 whose setup does not name the channels ch10+file://PATH?format=FILE.toml
    #[arg(required = true, value_name = "RUN", value_parser = RecordingSource::parser())]
    files: Vec<RecordingSource>,
    /// Override a key of every run, such as vane_position_m=[13.08,0,0] or latency_s={tas=0.25} (channels stamped late, s);
    /// RUN:KEY=VALUE of that recording alone; repeatable
    #[arg(long, value_name = "[RUN:]KEY=VALUE")]
    set: Vec<String>,
    /// Which message (MAVLink) or measurement (IRIG 106 Chapter 10) carries which channel, or the format of PCM frames in Chapter
    /// 10 packets (TOML)
    #[arg(long, value_name = "FILE", long_help = CONFIG_HELP)]
    config: Option<PathBuf>,
    #[command(flatten)]
    map: MapOption,
    #[command(flatten)]
    parts: PartOptions,
    /// Write the answer as JSON to this file, or to standard output with -
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
    #[command(flatten)]
    replace: ReplaceOption,
}

/// Reads every run, checks them together and reports the verdicts.
pub(crate) fn run(args: &CheckArgs) -> Result<Outcome, Failure> {
    if let Some(json) = args.json.as_ref().filter(|json| json.as_os_str() != "-") {
        refuse_to_overwrite("--json", json, &args.files.iter().flat_map(RecordingSource::files).collect::<Vec<_>>())?;
        refuse_without_folder("--json", json)?;
        args.replace.refuse("--json", json)?;
    }
    let mapping = read_mapping(args.config.as_deref(), &args.map)?;
    let [sources] = chosen_runs([&args.files], &args.parts, &args.set, &mapping)?;
    refuse_twice(&sources.iter().collect::<Vec<_>>())?;
    let mut read = sources.iter().map(|source| read(source, &mapping)).collect::<Result<Vec<_>, _>>()?;
    tell_apart(read.iter_mut().map(|one| &mut one.candidate.name), &sources.iter().collect::<Vec<_>>());
    let mut named = read.iter().zip(&sources).filter_map(|(one, source)| Some((one.info.aircraft()?, &source.file)));
    if let Some((first, _)) = named.next()
        && let Some((other, file)) = named.find(|(other, _)| *other != first)
    {
        let what = format!("expected runs of one aircraft, whose instruments are checked together: `{first}`, found `{other}`");
        return Err(Failure::file(file, what));
    }
    let candidates: Vec<RecordedRun> = read.iter().map(|one| one.candidate.clone()).collect();
    if std::io::stderr().is_terminal() {
        message(format_args!("{} run(s) read, checking ...", candidates.len()));
    }
    let verdicts = check(&candidates);
    let controls = candidates.first().map_or(ControlNames::Rotorcraft, |one| one.geometry.controls);
    let style = if args.json.is_some() { Style::of_stream(&std::io::stderr()) } else { Style::of_stream(&std::io::stdout()) };
    let infos: Vec<&RunInfo> = read.iter().map(|one| &one.info).collect();
    let interpreted = interpretation::of(&read);
    let text = table::text(&verdicts, &infos, controls, style) + &interpretation::text(&interpreted);
    match &args.json {
        None => print(&text)?,
        Some(path) => {
            message_text(text.trim_end());
            let mut document = json::document(&verdicts, controls);
            if read.iter().any(|one| !assumed_names(&one.info).is_empty()) {
                document["assumed_scale"] = read.iter().map(|one| assumed_names(&one.info)).collect();
            }
            document["interpretation"] = interpretation::document(&interpreted);
            let files = args.files.iter().flat_map(RecordingSource::files).chain(args.config.clone()).chain(args.map.map.clone());
            let dated = read
                .iter()
                .zip(&sources)
                .fold(Provenance::of(files), |all, (one, source)| all.dated(&source.file, one.info.recorded_at()));
            dated.write_json(path, DocumentSchema::Check, &format!("{document:#}\n"))?;
        }
    }
    let screened = verdicts
        .iter()
        .zip(&sources)
        .flat_map(|(verdict, source)| verdict.screened.iter().map(move |one| screened(&source.file, one, controls)));
    let losses: Vec<String> = read.iter().flat_map(|one| one.losses.clone()).chain(screened).collect();
    for loss in &losses {
        message_once(format_args!("sideslip: {loss}"));
    }
    Ok(if verdicts.iter().any(|verdict| verdict.fitness == Fitness::NotFit) {
        Outcome::NotGood
    } else if losses.is_empty() {
        Outcome::Done
    } else {
        Outcome::DataLost
    })
}
