//! A recording that stands in several tables, a file each: their rows in order of time.
//!
//! Consumes a path and a map with a section a file; produces rows, each with the channels of one time. Rows of two files that are
//! no further apart than [`SAME_S`] are one; nothing is interpolated. The files are those in a folder, or those whose names begin
//! alike, whose names end as the sections say. Columns that the map does not name are left out. Refused: a section without its
//! file, or with several.

use crate::flight::channel::Channel;
use crate::flight::file::run_file::{RecordingColumn, RecordingTarget, RunInfo, quoted};
use crate::flight::sample::Sample;
use crate::io::telemetry::alignment::row_alignment::SAME_S;
use crate::io::telemetry::channel_map::map_file::{ChannelMap, MapSection};
use crate::io::telemetry::csv::CsvRecording;
use crate::io::telemetry::record::{RecordingError, RecordingRow, SkippedByReason};
use std::fs::File;
use std::path::{Path, PathBuf};

/// One of the files: its next row.
struct Table {
    name: String,
    text: CsvRecording,
    next: Option<Sample>,
}

/// Tables that are being read as one recording.
pub struct TablesRecording {
    path: PathBuf,
    info: RunInfo,
    columns: Vec<RecordingColumn>,
    tables: Vec<Table>,
    row: RecordingRow,
    started: bool,
    skipped: SkippedByReason,
    found_out: Vec<String>,
}

impl std::fmt::Debug for TablesRecording {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("TablesRecording").field("path", &self.path).field("tables", &self.tables.len()).finish_non_exhaustive()
    }
}

impl TablesRecording {
    /// Opens every file that the map names.
    ///
    /// # Errors
    /// [`RecordingError`] where a file is missing or cannot be read, or its header lacks what the map names.
    pub fn open(path: &Path, map: &ChannelMap) -> Result<Self, RecordingError> {
        let whole = |what: String| RecordingError::Whole { path: path.into(), what };
        let files = FilesOfRecording::of(path, &map.sections).map_err(whole)?;
        let mut info = map.info.clone();
        info.set_controls(map.controls());
        info.add_text("run", &files.run);
        let mut tables = Vec::with_capacity(files.files.len());
        let mut columns = vec![RecordingColumn::new("time", None).map_err(whole)?];
        let mut found_out: Vec<String> = Vec::new();
        for (file, section) in files.files.iter().zip(&map.sections) {
            let whole = |what: String| RecordingError::Whole { path: file.clone(), what };
            let opened = File::open(file).map_err(|error| whole(format!("cannot be opened: {error}")))?;
            let text = CsvRecording::mapped(file, Box::new(opened), section, RunInfo::default())?;
            let known = |column: &&RecordingColumn| matches!(column.target, RecordingTarget::Known { .. });
            columns.extend(text.columns().iter().filter(known).cloned());
            let name = file.file_name().unwrap_or_default().to_string_lossy().into_owned();
            found_out.extend(text.found_out().iter().map(|found| format!("{name}: {found}")));
            if let Some(at) = text.info().text("recorded_at") {
                info.add_text("recorded_at", at);
            }
            tables.push(Table { name, text, next: None });
        }
        // Dates of all files count from the same midnight.
        if let Some(day) = tables.iter_mut().filter_map(|table| table.text.clock().zero_day()).min() {
            tables.iter_mut().for_each(|table| table.text.clock().count_from(day));
        }
        let row = RecordingRow { number: 0, sample: Sample::new(0.0), others: Vec::new() };
        let skipped = SkippedByReason::default();
        Ok(TablesRecording { path: path.into(), info, columns, tables, row, started: false, skipped, found_out })
    }

    /// What the map says of the run.
    pub fn info(&self) -> &RunInfo {
        &self.info
    }

    /// The time, then the channels in the order of the map.
    pub fn columns(&self) -> &[RecordingColumn] {
        &self.columns
    }

    /// What was skipped so far, in all files.
    pub fn skipped(&self) -> &SkippedByReason {
        &self.skipped
    }

    /// What of the files' form was found out, in sentences.
    pub fn found_out(&self) -> &[String] {
        &self.found_out
    }

    /// The next row of all together, numbered from 1; `None` at the end.
    ///
    /// # Errors
    /// [`RecordingError`] of one of the files.
    pub fn next_row(&mut self) -> Result<Option<&RecordingRow>, RecordingError> {
        if !std::mem::replace(&mut self.started, true) {
            for place in 0..self.tables.len() {
                self.advance(place)?;
            }
        }
        let earliest = |time_s: Option<f64>, table: &Table| match (time_s, &table.next) {
            // What has no time that is a number stands for itself, at once.
            (Some(time_s), Some(next)) => Some(if next.time_s < time_s || next.time_s.is_nan() { next.time_s } else { time_s }),
            (time_s, next) => time_s.or(next.map(|next| next.time_s)),
        };
        let Some(time_s) = self.tables.iter().fold(None, earliest) else { return Ok(None) };
        self.row.number += 1;
        self.row.sample = Sample::new(time_s);
        for place in 0..self.tables.len() {
            let Some(next) = self.tables.get(place).and_then(|table| table.next) else { continue };
            let is_same = next.time_s - time_s <= SAME_S || next.time_s.to_bits() == time_s.to_bits();
            if is_same {
                for channel in Channel::ALL {
                    if let Some(value) = next.get(channel) {
                        self.row.sample.set(channel, value);
                    }
                }
                self.advance(place)?;
            }
        }
        Ok(Some(&self.row))
    }

    /// Reads the next row of that file.
    fn advance(&mut self, place: usize) -> Result<(), RecordingError> {
        let Some(table) = self.tables.get_mut(place) else { return Ok(()) };
        let before = table.text.skipped().rows();
        table.next = table.text.next_row()?.map(|row| row.sample);
        if table.text.skipped().rows() > before {
            self.skipped = SkippedByReason::default();
            for table in &self.tables {
                self.skipped.join(table.text.skipped(), &table.name);
            }
        }
        Ok(())
    }
}

/// The files of one recording, in the order of the sections.
#[derive(Debug, PartialEq, Eq)]
struct FilesOfRecording {
    /// What their names have in common, or the folder's name.
    run: String,
    files: Vec<PathBuf>,
}

impl FilesOfRecording {
    /// By a folder, one of the files, or the beginning of their names.
    fn of(path: &Path, sections: &[MapSection]) -> Result<Self, String> {
        let text = |path: Option<&std::ffi::OsStr>| path.unwrap_or_default().to_string_lossy().into_owned();
        let name = text(path.file_name());
        let (folder, begin) = if path.is_dir() {
            (path.to_path_buf(), String::new())
        } else {
            let ends = sections.iter().filter_map(|section| section.of.as_deref());
            let begin = ends.filter_map(|end| name.strip_suffix(end)).min_by_key(|begin| begin.len());
            let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
            (folder.to_path_buf(), begin.unwrap_or(&name).to_owned())
        };
        let listed = std::fs::read_dir(&folder).map_err(|error| format!("the folder cannot be read: {error}"))?;
        let mut names: Vec<String> = listed.flatten().map(|entry| text(Some(&entry.file_name()))).collect();
        names.sort();
        let mut files = Vec::with_capacity(sections.len());
        for section in sections {
            let end = section.of.as_deref().unwrap_or_default();
            let fits = |name: &&String| name.starts_with(&begin) && name.ends_with(end) && name.len() >= begin.len() + end.len();
            let mut fitting: Vec<&String> = names.iter().filter(fits).collect();
            if let Some(exact) = fitting.iter().position(|name| name.len() == begin.len() + end.len()) {
                fitting = vec![fitting.swap_remove(exact)];
            }
            match fitting.as_slice() {
                [one] => files.push(folder.join(one)),
                [] => {
                    return Err(format!(
                        "by the map, expected a file that begins with {} and ends with {}, found none in {}",
                        quoted(&begin),
                        quoted(end),
                        folder.display()
                    ));
                }
                [one, other, ..] => {
                    return Err(format!(
                        "by the map, expected one file that ends with {}, found {} and {}: name the beginning of one recording's \
                         files instead of the folder, or a longer `ends`",
                        quoted(end),
                        quoted(one),
                        quoted(other)
                    ));
                }
            }
        }
        let run = begin.trim_end_matches(['_', '-', '.', ' ']).to_owned();
        Ok(FilesOfRecording { run: if run.is_empty() { name } else { run }, files })
    }
}
