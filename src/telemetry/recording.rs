//! A recording, whatever its format: what the run says of itself, its columns, and its rows one by one.
//!
//! Consumes a path; produces [`Row`]s with the known channels in SI and the others as they came. The order of time is
//! not judged here. A row that cannot be read is skipped and counted ([`Skipped`]), never guessed; a file of which no
//! row can be read is an error. Memory is bounded by the longest row, not by the file.

use super::csv::CsvRecording;
use super::format::{Format, HEAD_BYTES};
use super::log_recording::LogRecording;
use super::mavlink::mapping::Config as MavlinkConfig;
use super::mavlink::packet::Framing;
use super::mavlink::recording::{MavlinkRecording, Traffic};
use super::record::Sample;
use crate::flight::run_file::{Column, PlaceError, RunInfo};
use std::fs::File;
use std::io::{Cursor, Read, Seek, SeekFrom};
use std::path::{Path, PathBuf};

/// Why a recording cannot be read.
#[derive(Debug, thiserror::Error)]
pub enum RecordingError {
    /// Reading failed.
    #[error("{}: {source}", path.display())]
    Io {
        /// Which file.
        path: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
    /// The file is wrong at one place.
    #[error("{}:{place}", path.display())]
    Place {
        /// Which file.
        path: PathBuf,
        /// Where, what was expected, what was found.
        place: PlaceError,
    },
    /// The file is wrong as a whole.
    #[error("{}: {what}", path.display())]
    Whole {
        /// Which file.
        path: PathBuf,
        /// What was expected and what was found.
        what: String,
    },
}

/// One row: what was measured at one time.
#[derive(Clone, Debug, PartialEq)]
pub struct Row {
    /// Line of a text, number of the message in a log; from 1.
    pub number: u64,
    /// Time and known channels, SI.
    pub sample: Sample,
    /// The other columns in their order, as they came; `None` where not sampled.
    pub others: Vec<Option<f64>>,
}

/// Why a row was skipped.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SkipReason {
    /// More or fewer cells than the header has.
    CellCount,
    /// A cell that is no number.
    NotANumber,
    /// No time.
    NoTime,
    /// A damaged or cut record of a log.
    Damaged,
}

impl SkipReason {
    /// In words.
    pub const fn words(self) -> &'static str {
        match self {
            SkipReason::CellCount => "wrong number of cells",
            SkipReason::NotANumber => "a cell that is no number",
            SkipReason::NoTime => "no time",
            SkipReason::Damaged => "damaged or cut short",
        }
    }
}

/// The rows skipped for one reason.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SkippedRows {
    /// Why.
    pub reason: SkipReason,
    /// How many.
    pub rows: u64,
    /// The first one: line of a text, number of the message in a log.
    pub first: u64,
    /// What was expected and found at the first one.
    pub example: String,
}

/// Every row that was skipped, by reason.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Skipped {
    reasons: Vec<SkippedRows>,
}

impl Skipped {
    /// Counts one row; `example` is asked for the first of its reason only.
    pub fn count(&mut self, reason: SkipReason, number: u64, example: impl FnOnce() -> String) {
        match self.reasons.iter_mut().find(|skipped| skipped.reason == reason) {
            Some(skipped) => skipped.rows += 1,
            None => self.reasons.push(SkippedRows { reason, rows: 1, first: number, example: example() }),
        }
    }

    /// The reasons in the order of their first row.
    pub fn reasons(&self) -> &[SkippedRows] {
        &self.reasons
    }

    /// How many rows in all.
    pub fn rows(&self) -> u64 {
        self.reasons.iter().map(|skipped| skipped.rows).sum()
    }
}

/// A recording that is being read.
#[derive(Debug)]
pub enum Recording {
    /// A run file in text.
    Csv(Box<CsvRecording>),
    /// A log of this program.
    Mcap(Box<LogRecording>),
    /// Messages of MAVLink.
    Mavlink(Box<MavlinkRecording>),
}

impl Recording {
    /// Opens a recording; its format is told by its content.
    ///
    /// # Errors
    /// [`RecordingError`] where the file cannot be read, is of another format, or its preamble or header is wrong.
    pub fn open(path: &Path) -> Result<Self, RecordingError> {
        Recording::open_with(path, &MavlinkConfig::default())
    }

    /// The same, with a configuration of which message gives which channel.
    ///
    /// # Errors
    /// As [`Recording::open`].
    pub fn open_with(path: &Path, mavlink: &MavlinkConfig) -> Result<Self, RecordingError> {
        let whole = |what: String| RecordingError::Whole { path: path.into(), what };
        let cannot = |error: std::io::Error| whole(format!("cannot be opened: {error}"));
        let mut file = File::open(path).map_err(cannot)?;
        if file.metadata().map_err(cannot)?.is_dir() {
            return Err(whole("expected a recording, found a directory".into()));
        }
        let mut head = Vec::with_capacity(HEAD_BYTES);
        let limit = u64::try_from(HEAD_BYTES).unwrap_or(u64::MAX);
        file.by_ref().take(limit).read_to_end(&mut head).map_err(|source| RecordingError::Io { path: path.into(), source })?;
        match Format::of(&head) {
            Format::Csv => {
                CsvRecording::new(path, Box::new(Cursor::new(head).chain(file))).map(|text| Recording::Csv(Box::new(text)))
            }
            Format::Mcap => {
                file.seek(SeekFrom::Start(0)).map_err(|source| RecordingError::Io { path: path.into(), source })?;
                LogRecording::new(path, file).map(|log| Recording::Mcap(Box::new(log)))
            }
            Format::Tlog => MavlinkRecording::new(path, file, Framing::Stamped, mavlink.clone())
                .map(|recording| Recording::Mavlink(Box::new(recording))),
            Format::Mavlink => MavlinkRecording::new(path, file, Framing::Bare, mavlink.clone())
                .map(|recording| Recording::Mavlink(Box::new(recording))),
            Format::Named(name) => Err(whole(format!("recognised as {name}, which this version does not read yet"))),
            Format::Empty => Err(whole("expected a recording, found an empty file".into())),
            Format::Unknown(bytes) => {
                let hex: Vec<String> = bytes.iter().map(|byte| format!("{byte:02x}")).collect();
                Err(whole(format!("expected a recording, found no known format: it starts with the bytes {}", hex.join(" "))))
            }
        }
    }

    /// The format in a word.
    pub fn format(&self) -> &'static str {
        match self {
            Recording::Csv(_) => "CSV",
            Recording::Mcap(_) => "MCAP",
            Recording::Mavlink(recording) => recording.format(),
        }
    }

    /// What rows are numbered by, in a word for messages.
    pub fn counted_in(&self) -> &'static str {
        match self {
            Recording::Csv(_) => "line",
            Recording::Mcap(_) | Recording::Mavlink(_) => "sample",
        }
    }

    /// What the run says of itself.
    pub fn info(&self) -> &RunInfo {
        match self {
            Recording::Csv(recording) => recording.info(),
            Recording::Mcap(recording) => recording.info(),
            Recording::Mavlink(recording) => recording.info(),
        }
    }

    /// The columns in the order of the file.
    pub fn columns(&self) -> &[Column] {
        match self {
            Recording::Csv(recording) => recording.columns(),
            Recording::Mcap(recording) => recording.columns(),
            Recording::Mavlink(recording) => recording.columns(),
        }
    }

    /// The next row that can be read; `None` at the end.
    ///
    /// # Errors
    /// [`RecordingError`] where reading fails, a row is longer than memory allows for, or the end comes without a single
    /// good row.
    pub fn next_row(&mut self) -> Result<Option<&Row>, RecordingError> {
        match self {
            Recording::Csv(recording) => recording.next_row(),
            Recording::Mcap(recording) => recording.next_row(),
            Recording::Mavlink(recording) => recording.next_row(),
        }
    }

    /// What was skipped so far.
    pub fn skipped(&self) -> &Skipped {
        match self {
            Recording::Csv(recording) => recording.skipped(),
            Recording::Mcap(recording) => recording.skipped(),
            Recording::Mavlink(recording) => recording.skipped(),
        }
    }

    /// What of the file could not be read, besides the rows that [`Recording::skipped`] counts, in words; complete after
    /// the last row.
    pub fn shortfall(&self) -> Option<String> {
        match self {
            Recording::Csv(_) => None,
            Recording::Mcap(recording) => recording.shortfall(),
            Recording::Mavlink(recording) => recording.shortfall(),
        }
    }

    /// Whether the recording stops without its proper end (no end of line, no footer): it may have been cut short.
    pub fn ends_abruptly(&self) -> bool {
        match self {
            Recording::Csv(recording) => recording.ends_abruptly(),
            Recording::Mcap(recording) => recording.ends_abruptly(),
            Recording::Mavlink(_) => false,
        }
    }

    /// Who sent what, of messages.
    pub fn traffic(&self) -> Option<&Traffic> {
        match self {
            Recording::Csv(_) | Recording::Mcap(_) => None,
            Recording::Mavlink(recording) => Some(recording.traffic()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn skipped_rows_are_counted_by_reason_with_the_first_of_each() {
        let mut skipped = Skipped::default();
        skipped.count(SkipReason::NoTime, 7, || "first".into());
        skipped.count(SkipReason::CellCount, 8, || "cells".into());
        skipped.count(SkipReason::NoTime, 9, || "second".into());
        assert_eq!(skipped.rows(), 3);
        let no_time = SkippedRows { reason: SkipReason::NoTime, rows: 2, first: 7, example: "first".into() };
        assert_eq!(skipped.reasons().first(), Some(&no_time));
    }
}
