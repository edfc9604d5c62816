//! A log of this program as a recording: what the run says of itself, its columns, its samples row by row.
//!
//! Consumes an MCAP log; produces [`RecordingRow`]s with the bits that were logged. A sample that cannot be understood is skipped
//! and counted; what a cut or damaged file did not give is said by [`LogRecording::shortfall`]. Refused: an MCAP file of
//! someone else, a head that is wrong, a log without a single sample.

use super::mcap::{LogReadError, SampleReader};
use super::record::{RecordingError, RecordingRow, SkipReason, SkippedByReason};
use crate::flight::file::run_file::{RecordingColumn, RecordingHeader, RunInfo, quoted};
use crate::flight::sample::Sample;
use std::fs::File;
use std::path::{Path, PathBuf};

/// A log that is being read.
pub struct LogRecording {
    path: PathBuf,
    reader: SampleReader<File>,
    info: RunInfo,
    columns: Vec<RecordingColumn>,
    row: RecordingRow,
    rows: u64,
    skipped: SkippedByReason,
    ended: bool,
}

impl std::fmt::Debug for LogRecording {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("LogRecording").field("path", &self.path).field("rows", &self.rows).finish_non_exhaustive()
    }
}

impl LogRecording {
    /// Finds the log's head; `path` is named in messages only.
    ///
    /// # Errors
    /// [`RecordingError`] where reading fails or the file is no log of this program.
    pub fn new(path: &Path, source: File) -> Result<Self, RecordingError> {
        let whole = |what: String| RecordingError::Whole { path: path.into(), what };
        let reader = SampleReader::open(source).map_err(|error| match error {
            LogReadError::Io(source) => RecordingError::Io { path: path.into(), source },
            wrong => whole(wrong.to_string()),
        })?;
        let head = reader.head();
        let mut info =
            RunInfo::from_toml(&head.run_toml).map_err(|place| whole(format!("metadata record `run`, toml:{place}")))?;
        let mut columns = vec![RecordingColumn::new("time", None).map_err(whole)?];
        for (name, unit) in &head.channels {
            columns.push(column(name, unit).map_err(whole)?);
        }
        RecordingHeader::from_columns(columns.clone()).map_err(whole)?;
        info.set_controls(head.controls);
        let row = RecordingRow { number: 0, sample: Sample::new(0.0), others: vec![None; head.unknown_columns()] };
        Ok(LogRecording {
            path: path.into(),
            reader,
            info,
            columns,
            row,
            rows: 0,
            skipped: SkippedByReason::default(),
            ended: false,
        })
    }

    /// What the run says of itself, as it was in effect when the log was written.
    pub fn info(&self) -> &RunInfo {
        &self.info
    }

    /// The time, then the columns in the order of the log.
    pub fn columns(&self) -> &[RecordingColumn] {
        &self.columns
    }

    /// What was skipped so far.
    pub fn skipped(&self) -> &SkippedByReason {
        &self.skipped
    }

    /// Whether the log, as far as it was read, stops without its proper end.
    pub fn ends_abruptly(&self) -> bool {
        self.reader.losses().stopped.is_some()
    }

    /// What of the file could not be read, besides single samples, in words; complete after the last row.
    pub fn shortfall(&self) -> Option<String> {
        let mut losses = self.reader.losses();
        losses.malformed = None;
        (!losses.is_none()).then(|| losses.to_string())
    }

    /// The next sample; `None` at the end of what can be read.
    ///
    /// # Errors
    /// [`RecordingError`] where reading fails, or the end comes without a single good sample.
    pub fn next_row(&mut self) -> Result<Option<&RecordingRow>, RecordingError> {
        if self.ended {
            return Ok(None);
        }
        let read = self.reader.next_sample().map_err(|source| RecordingError::Io { path: self.path.clone(), source })?;
        let some = match read {
            Some((sample, others)) => {
                self.row.sample = sample;
                self.row.others.copy_from_slice(others);
                true
            }
            None => false,
        };
        self.count_malformed();
        if some {
            self.rows += 1;
            self.row.number = self.rows + self.skipped.rows();
            return Ok(Some(&self.row));
        }
        self.ended = true;
        if self.rows > 0 {
            return Ok(None);
        }
        let losses = self.reader.losses();
        let why = if losses.is_none() { String::new() } else { format!(": {losses}") };
        Err(RecordingError::Whole { path: self.path.clone(), what: format!("expected samples, found none{why}") })
    }

    /// Takes over the samples that the reader could not understand since it was asked last.
    fn count_malformed(&mut self) {
        let Some((count, reason)) = self.reader.malformed() else { return };
        for _ in self.skipped.rows()..*count {
            let number = self.rows + self.skipped.rows() + 1;
            self.skipped.count(SkipReason::Damaged, number, || reason.clone());
        }
    }
}

/// A column of a log: known channels are in SI there, others in the unit that their text names.
fn column(name: &str, unit: &str) -> Result<RecordingColumn, String> {
    let carried = RecordingColumn::new(name, (!unit.is_empty()).then_some(unit))?;
    let si = RecordingColumn::new(name, None)?;
    if carried.target != si.target {
        let expected = si.inner_unit();
        return Err(format!("column {}: expected {expected}, as every log holds it, found {}", quoted(name), quoted(unit)));
    }
    Ok(carried)
}
