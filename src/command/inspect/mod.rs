//! `sideslip inspect`: what is in a recording, and what of it can be estimated.

mod chapter10;
mod estimable;
mod json;
mod survey;
mod table;
mod traffic;

use super::options::mapping_input::read_mapping;
use super::options::telemetry_source::RecordingSource;
use super::terminal::output_file::{print, refuse_to_overwrite, write_json};
use crate::command::message;
use estimable::EstimableQuantities;
use sideslip::error::{Failure, Outcome};
use sideslip::io::telemetry::format::RecordingFormat;
use std::io::Read;
use std::path::PathBuf;
use survey::Survey;

const EXAMPLE: &str = "\
Example:
  sideslip inspect flight.csv
  sideslip inspect flight.csv --json - | jq .estimable.dutch_roll

Exit status: 0 done; 1 failed while reading; 2 the file is no recording, or its header is wrong; 3 done, and rows were
skipped. With --json the table goes to standard error.";

/// Show what is in a recording: channels, units, rates, gaps, time range, and what of it can be estimated.
#[derive(clap::Args)]
#[command(after_help = EXAMPLE)]
pub(crate) struct InspectArgs {
    /// The recording; its format is recognised by its content. A stream of PCM is pcm+file://PATH?format=FRAME.toml
    #[arg(value_parser = RecordingSource::of_path_or_url)]
    file: RecordingSource,
    /// Which message carries which channel, for recordings of MAVLink (TOML).
    #[arg(long, value_name = "FILE")]
    config: Option<PathBuf>,
    /// Write the answer as JSON to this file, or to standard output with `-`.
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
}

/// Reads the whole recording once and says what is in it.
pub(crate) fn run(args: &InspectArgs) -> Result<Outcome, Failure> {
    if let Some(json) = &args.json {
        refuse_to_overwrite("--json", json, &args.file.files())?;
    }
    let file = &args.file.file;
    if args.file.pcm_format.is_none() && is_chapter10(file) {
        return chapter10::run(file, args.json.as_deref());
    }
    let mut recording = args.file.open(&read_mapping(args.config.as_deref())?)?;
    let mut survey = Survey::new(recording.columns());
    while let Some(row) = recording.next_row()? {
        survey.add(row);
    }
    let estimable = EstimableQuantities::of(&survey, recording.info().geometry().controls);
    let table = table::text(file, &recording, &survey, &estimable);
    match &args.json {
        None => print(&table)?,
        Some(target) => {
            message(format_args!("{}", table.trim_end()));
            let document = json::document(file, &recording, &survey, &estimable);
            write_json(target, &format!("{document:#}\n"))?;
        }
    }
    let skipped = recording.skipped().rows();
    let mut outcome = Outcome::Done;
    if skipped > 0 {
        message(format_args!("sideslip: {}: {skipped} of {} rows skipped", file.display(), skipped + survey.rows));
        outcome = Outcome::DataLost;
    }
    if let Some(shortfall) = recording.shortfall() {
        message(format_args!("sideslip: {}: {shortfall}", file.display()));
        outcome = Outcome::DataLost;
    }
    Ok(outcome)
}

/// Whether it is a recording after IRIG 106 Chapter 10; what cannot be read is refused later.
fn is_chapter10(file: &std::path::Path) -> bool {
    let mut head = [0; 2];
    let read = std::fs::File::open(file).and_then(|mut file| file.read_exact(&mut head));
    read.is_ok() && RecordingFormat::of(&head) == RecordingFormat::Chapter10
}
