//! `sideslip inspect`: what is in a recording, and what of it can be estimated.

mod estimable;
mod json;
mod survey;
mod table;

use super::message;
use estimable::Estimable;
use sideslip::error::{Failure, Outcome};
use sideslip::telemetry::recording::Recording;
use std::io::{ErrorKind, Write};
use std::path::{Path, PathBuf};
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
pub(crate) struct Args {
    /// The recording; its format is told by its content.
    file: PathBuf,
    /// Write the answer as JSON to this file, or to standard output with `-`.
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
}

/// Reads the whole recording once and says what is in it.
pub(crate) fn run(args: &Args) -> Result<Outcome, Failure> {
    let mut recording = Recording::open(&args.file)?;
    let mut survey = Survey::new(recording.columns());
    while let Some(row) = recording.next_row()? {
        survey.add(row);
    }
    let estimable = Estimable::of(&survey, recording.info().geometry().controls);
    let table = table::text(&args.file, &recording, &survey, &estimable);
    match &args.json {
        None => print(&table)?,
        Some(target) => {
            message(format_args!("{}", table.trim_end()));
            let document = json::document(&args.file, &recording, &survey, &estimable);
            let text = format!("{document:#}\n");
            if target.as_os_str() == "-" { print(&text)? } else { write_whole(target, &text)? }
        }
    }
    let skipped = recording.skipped().rows();
    if skipped == 0 {
        return Ok(Outcome::Done);
    }
    message(format_args!("sideslip: {}: {skipped} of {} rows skipped", args.file.display(), skipped + survey.rows));
    Ok(Outcome::DataLost)
}

/// To standard output; a reader that has seen enough is no failure.
fn print(text: &str) -> Result<(), Failure> {
    let mut output = std::io::stdout().lock();
    match output.write_all(text.as_bytes()).and_then(|()| output.flush()) {
        Err(error) if error.kind() != ErrorKind::BrokenPipe => Err(Failure::io(Path::new("standard output"), &error)),
        _ => Ok(()),
    }
}

/// The whole file or none: it gets its name after its last byte.
fn write_whole(path: &Path, text: &str) -> Result<(), Failure> {
    let mut name = path.file_name().unwrap_or_default().to_os_string();
    name.push(format!(".{}.part", std::process::id()));
    let part = path.with_file_name(name);
    std::fs::write(&part, text).and_then(|()| std::fs::rename(&part, path)).map_err(|error| {
        let _ = std::fs::remove_file(&part);
        Failure::io(path, &error)
    })
}
