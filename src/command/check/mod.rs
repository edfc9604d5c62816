//! `sideslip check`: do a run's instruments agree with each other, and what is wrong where they do not?

mod interpretation;
mod json;
mod table;

use super::options::mapping_input::read_mapping;
use super::recordings::run_input::{RunInput, read_run, screened};
use super::terminal::output_file::{print, refuse_to_overwrite, refuse_without_folder, same_place, write_json};
use crate::command::message;
use sideslip::error::{Failure, Outcome};
use sideslip::flight::channel::ControlNames;
use sideslip::flight::file::run_file::RunInfo;
use sideslip::io::outputs::tables::terminal::Style;
use sideslip::io::telemetry::mavlink::mapping::MavlinkConfig as Mapping;
use sideslip::postflight::reconstruction::verdict::{CheckedRun, Fitness, check};
use std::io::IsTerminal;
use std::path::{Path, PathBuf};

const EXAMPLE: &str = "\
Example:
  sideslip check flight.csv
  sideslip check monday/*.csv --json - | jq .runs[].verdict
  sideslip check flight.csv --set vane_position_m=[13.1,0,0]

Rates, accelerometers, attitude and air data measure one motion: what does not fit together is an instrument. Samples that no
instrument measured (spikes, frozen or zeroed stretches) are not used, and counted; a turned sign, another unit, two channels
exchanged are looked for first. All runs are then taken together: factors, lags, skews and positions hold over all of them,
biases are each run's own; a run that is unlike the others is checked by itself. A correction is told where it is significant
beyond noise (as coloured as it is) and beyond what is normal among healthy instruments; where two explanations fit alike both
are told. A run needs 5 s, rates at 8 Hz, and motion.

Exit status: 0 all runs are fit, some perhaps after corrections; 1 failed while running; 2 the call or a recording is wrong;
3 all fit, but rows were skipped or samples not used; 4 a run is not fit for identification. With --json the table goes to
standard error.";

/// Check instruments against the kinematics: biases, factors, lags, skews and positions, and whether a run is fit
#[derive(clap::Args)]
#[command(after_help = EXAMPLE)]
pub(crate) struct Args {
    /// Recordings, a run each; their format is told by their content
    #[arg(required = true, value_name = "RUN")]
    files: Vec<PathBuf>,
    /// Override a key of every run, such as vane_position_m=[13.08,0,0]; repeatable
    #[arg(long, value_name = "KEY=VALUE")]
    set: Vec<String>,
    /// Which message gives which channel, for recordings of MAVLink (TOML)
    #[arg(long, value_name = "FILE")]
    config: Option<PathBuf>,
    /// Write the answer as JSON to this file, or to standard output with -
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
}

/// A recording as it was read.
struct ReadRun {
    candidate: CheckedRun,
    info: RunInfo,
    losses: Vec<String>,
}

/// Reads every run, checks them together and says what came of it.
pub(crate) fn run(args: &Args) -> Result<Outcome, Failure> {
    if let Some(json) = args.json.as_ref().filter(|json| json.as_os_str() != "-") {
        refuse_to_overwrite("--json", json, &args.files)?;
        refuse_without_folder("--json", json)?;
    }
    for (place, file) in args.files.iter().enumerate() {
        if args.files.iter().take(place).any(|other| same_place(other, file)) {
            return Err(Failure::file(file, "expected each run once, found the same file twice"));
        }
    }
    let mapping = read_mapping(args.config.as_deref())?;
    let read = args.files.iter().map(|file| read(file, &args.set, &mapping)).collect::<Result<Vec<_>, _>>()?;
    let mut named = read.iter().zip(&args.files).filter_map(|(one, file)| Some((one.info.aircraft()?, file)));
    if let Some((first, _)) = named.next()
        && let Some((other, file)) = named.find(|(other, _)| *other != first)
    {
        let what = format!("expected runs of one aircraft, whose instruments are checked together: `{first}`, found `{other}`");
        return Err(Failure::file(file, what));
    }
    let candidates: Vec<CheckedRun> = read.iter().map(|one| one.candidate.clone()).collect();
    if std::io::stderr().is_terminal() {
        message(format_args!("{} run(s) read, checking ...", candidates.len()));
    }
    let verdicts = check(&candidates);
    let controls = candidates.first().map_or(ControlNames::Rotorcraft, |one| one.geometry.controls);
    let style = if args.json.is_some() { Style::of_stream(&std::io::stderr()) } else { Style::of_stream(&std::io::stdout()) };
    let infos: Vec<&RunInfo> = read.iter().map(|one| &one.info).collect();
    let looked = interpretation::of(&read);
    let text = table::text(&verdicts, &infos, controls, style) + &interpretation::text(&looked);
    match &args.json {
        None => print(&text)?,
        Some(path) => {
            message(format_args!("{}", text.trim_end()));
            let mut document = json::document(&verdicts, controls);
            document["interpretation"] = interpretation::document(&looked);
            write_json(path, &format!("{document:#}\n"))?;
        }
    }
    let screened = verdicts
        .iter()
        .zip(&args.files)
        .flat_map(|(verdict, file)| verdict.screened.iter().map(move |one| screened(file, one, controls)));
    let losses: Vec<String> = read.iter().flat_map(|one| one.losses.clone()).chain(screened).collect();
    for loss in &losses {
        message(format_args!("sideslip: {loss}"));
    }
    Ok(if verdicts.iter().any(|verdict| verdict.fitness == Fitness::NotFit) {
        Outcome::NotGood
    } else if losses.is_empty() {
        Outcome::Done
    } else {
        Outcome::DataLost
    })
}

fn read(file: &Path, overrides: &[String], mapping: &Mapping) -> Result<ReadRun, Failure> {
    let RunInput { name, info, samples, mut losses } = read_run(file, overrides, mapping)?;
    let backwards = samples.array_windows().filter(|[before, after]| !(after.time_s > before.time_s)).count();
    if backwards > 0 {
        losses.push(format!("{}: time does not increase at {backwards} of {} rows", file.display(), samples.len()));
    }
    Ok(ReadRun { candidate: CheckedRun { name, samples, geometry: *info.geometry() }, info, losses })
}
