//! `inspect --map-template`: a map of a table of another program, written to be checked.

use crate::command::message;
use crate::command::options::replace_option::ReplaceOption;
use crate::command::options::telemetry_source::RecordingSource;
use crate::command::terminal::console::print;
use crate::command::terminal::output_file::{refuse_without_folder, write_whole};
use sideslip::error::{Failure, Outcome};
use sideslip::io::telemetry::channel_map::template;
use sideslip::io::telemetry::format::{HEAD_BYTES, RecordingFormat};
use std::io::Read;
use std::path::Path;

/// So much of a file is looked at, bytes.
const LOOKED_AT: u64 = 256 << 10;
/// So many files of a folder.
const FILES: usize = 1000;

/// Writes the map to the file, or to standard output with `-`.
pub(super) fn run(source: &RecordingSource, output: &Path, replace: ReplaceOption) -> Result<Outcome, Failure> {
    let file = &source.file;
    if output.as_os_str() != "-" {
        refuse_without_folder("--map-template", output)?;
        replace.refuse("--map-template", output)?;
    }
    let map = if file.is_dir() { of_folder(file)? } else { of_one(file)? };
    if output.as_os_str() == "-" {
        print(&map)?;
    } else {
        write_whole(output, |sink| sink.write_all(map.as_bytes()))?;
        message(format_args!(
            "{}: guesses to be checked, then: sideslip inspect {} --map {}",
            output.display(),
            file.display(),
            output.display()
        ));
    }
    Ok(Outcome::Done)
}

/// The whole lines of a file's beginning.
fn beginning(file: &Path) -> Result<Vec<u8>, Failure> {
    let mut first = Vec::new();
    let opened = std::fs::File::open(file).map_err(|error| Failure::file(file, format_args!("cannot be opened: {error}")))?;
    opened.take(LOOKED_AT).read_to_end(&mut first).map_err(|error| Failure::io(file, &error))?;
    if let Some(end) = first.iter().rposition(|byte| *byte == b'\n') {
        first.truncate(end + 1);
    }
    Ok(first)
}

/// The map of a folder whose tables are one recording.
fn of_folder(folder: &Path) -> Result<String, Failure> {
    let listed = std::fs::read_dir(folder).map_err(|error| Failure::io(folder, &error))?;
    let mut paths: Vec<_> = listed.flatten().map(|entry| entry.path()).filter(|path| path.is_file()).collect();
    paths.sort();
    let mut files = Vec::new();
    for path in paths.iter().take(FILES) {
        let first = beginning(path)?;
        if RecordingFormat::of(first.get(..first.len().min(HEAD_BYTES)).unwrap_or_default()) == RecordingFormat::Csv
            && path.extension().is_some_and(|ending| ["csv", "txt", "tsv"].iter().any(|known| ending.eq_ignore_ascii_case(known)))
        {
            files.push((path.file_name().unwrap_or_default().to_string_lossy().into_owned(), first));
        }
    }
    if files.is_empty() {
        return Err(Failure::file(folder, "--map-template: expected tables (.csv, .txt, .tsv) in the folder, found none"));
    }
    Ok(template::of_files(&folder.display().to_string(), &files))
}

/// The map of one table.
fn of_one(file: &Path) -> Result<String, Failure> {
    let first = beginning(file)?;
    let format = RecordingFormat::of(first.get(..first.len().min(HEAD_BYTES)).unwrap_or_default());
    if format != RecordingFormat::Csv {
        let what = format_args!(
            "--map-template: expected a table in text (CSV), found {}: sideslip inspect {} shows what is read of it",
            format.words(),
            file.display()
        );
        return Err(Failure::file(file, what));
    }
    Ok(template::of_table(&file.display().to_string(), &first))
}
