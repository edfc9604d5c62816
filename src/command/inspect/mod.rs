//! `sideslip inspect`: what is in a recording, and what of it can be estimated.

mod chapter10;
mod estimable;
mod json;
mod manoeuvre_list;
mod map_template;
mod seen_rows;
mod survey;
mod table;
mod traffic;

use super::options::mapping_input::{CONFIG_HELP, MapOption, read_mapping};
use super::options::replace_option::ReplaceOption;
use super::options::run_parts::PartOptions;
use super::options::telemetry_source::RecordingSource;
use super::recordings::chosen_runs::chosen_run;
use super::recordings::provenance::Provenance;
use super::terminal::console::print;
use super::terminal::output_file::refuse_to_overwrite;
use crate::command::message_text;
use seen_rows::SeenRows;
use sideslip::error::{Failure, Outcome};
use sideslip::io::outputs::json::document_schema::DocumentSchema;
use std::path::PathBuf;

const EXAMPLE: &str = "\
Example:
  sideslip inspect flight.csv
  sideslip inspect day.csv --manoeuvres
  sideslip inspect flight.csv --json - | jq .estimable.dutch_roll
  sideslip inspect theirs.csv --map-template map.toml && sideslip inspect theirs.csv --map map.toml
  sideslip inspect 'ch10+file://flight.ch10?format=frame.toml'

Exit status: 0 done; 1 failed while reading; 2 the file is no recording, or its header is wrong; 3 done, and rows were
skipped; 4 no manoeuvre with --manoeuvres. With --json the table goes to standard error.";

/// Show what is in a recording: channels, units, rates, gaps, time range, and what of it can be estimated.
#[derive(clap::Args)]
#[command(after_help = EXAMPLE)]
pub(crate) struct InspectArgs {
    /// The recording; its format is recognised by its content. A stream of PCM is pcm+file://PATH?format=FRAME.toml,
    /// IRIG 106 Chapter 10 whose setup does not name the channels ch10+file://PATH?format=FILE.toml
    #[arg(value_parser = RecordingSource::parser())]
    file: RecordingSource,
    /// Which message (MAVLink) or measurement (IRIG 106 Chapter 10) carries which channel, or the format of PCM frames in Chapter
    /// 10 packets (TOML).
    #[arg(long, value_name = "FILE", long_help = CONFIG_HELP)]
    config: Option<PathBuf>,
    #[command(flatten)]
    map: MapOption,
    /// Override a key of the run, such as vane_position_m=[13.08,0,0] or latency_s={tas=0.25} (channels stamped late, s);
    /// repeatable
    #[arg(long, value_name = "KEY=VALUE")]
    set: Vec<String>,
    #[command(flatten)]
    parts: PartOptions,
    /// List the manoeuvres of the flight instead: number, control, shape, times, airspeed, climb and altitude of the trim before
    /// each. --manoeuvre N on any command that reads runs takes one as a run of its own
    #[arg(long, conflicts_with_all = ["map_template", "manoeuvre"])]
    manoeuvres: bool,
    /// Write a map of a table (CSV) of another program to this file, or to standard output: guesses by its headers, to be
    /// checked, for --map; of a folder with the tables of one recording too
    #[arg(long, value_name = "OUT", num_args = 0..=1, default_missing_value = "-", conflicts_with_all = ["map", "json"])]
    map_template: Option<PathBuf>,
    /// Write the answer as JSON to this file, or to standard output with `-`.
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
    #[command(flatten)]
    replace: ReplaceOption,
}

/// Reads the whole recording once and says what is in it.
pub(crate) fn run(args: &InspectArgs) -> Result<Outcome, Failure> {
    if let Some(json) = &args.json {
        refuse_to_overwrite("--json", json, &args.file.files())?;
    }
    args.replace.refuse_each([("--json", args.json.as_deref())])?;
    if let Some(output) = &args.map_template {
        return map_template::run(&args.file, output, args.replace);
    }
    let config = read_mapping(args.config.as_deref(), &args.map)?;
    let source = chosen_run(&args.file, &args.parts, &args.set, &config)?;
    let files = args.file.files().into_iter().chain(args.config.clone()).chain(args.map.map.clone());
    if args.manoeuvres {
        return manoeuvre_list::run(&source, &config, args.json.as_deref(), files);
    }
    if source.is_chapter10() {
        return chapter10::run(&source, &config, args.json.as_deref());
    }
    let file = &source.file;
    let recording = source.open(&config)?;
    let seen = SeenRows::read(&source, recording)?;
    match &args.json {
        None => print(&seen.text)?,
        Some(target) => {
            message_text(seen.text.trim_end());
            let provenance = Provenance::of(files).dated(file, seen.info.recorded_at());
            provenance.write_json(target, DocumentSchema::Inspect, &format!("{:#}\n", seen.document))?;
        }
    }
    Ok(seen.outcome(file))
}
