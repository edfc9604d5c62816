//! A recording that was read to its end, its rows kept: what needs the whole of it first, such as the manoeuvres of a flight, need
//! not read the file again, which may be a pipe.
//!
//! Consumes a [`Recording`]; produces the same rows and the same words as often as it is opened. Memory is that of the rows.

use super::mavlink::recording::Traffic;
use super::record::{RecordingError, RecordingRow, SkippedByReason};
use super::recording::Recording;
use crate::flight::file::run_file::{RecordingColumn, RunInfo};
use std::sync::Arc;

/// All that a recording said.
#[derive(Debug)]
pub struct ReadRecording {
    pub(super) format: &'static str,
    pub(super) counted_in: &'static str,
    pub(super) info: RunInfo,
    pub(super) columns: Vec<RecordingColumn>,
    pub(super) rows: Vec<RecordingRow>,
    pub(super) skipped: SkippedByReason,
    pub(super) left_out: Vec<String>,
    pub(super) assumed: Vec<String>,
    pub(super) found_out: Vec<String>,
    pub(super) shortfall: Option<String>,
    pub(super) ends_abruptly: bool,
    pub(super) traffic: Option<Traffic>,
}

impl ReadRecording {
    /// Reads it to its end.
    ///
    /// # Errors
    /// As [`Recording::next_row`].
    pub fn of(mut recording: Recording) -> Result<Self, RecordingError> {
        let mut rows = Vec::new();
        while let Some(row) = recording.next_row()? {
            rows.push(row.clone());
        }
        Ok(ReadRecording {
            format: recording.format(),
            counted_in: recording.counted_in(),
            info: recording.info().clone(),
            columns: recording.columns().to_vec(),
            rows,
            skipped: recording.skipped().clone(),
            left_out: recording.left_out().to_vec(),
            assumed: recording.assumed().to_vec(),
            found_out: recording.found_out().to_vec(),
            shortfall: recording.shortfall(),
            ends_abruptly: recording.ends_abruptly(),
            traffic: recording.traffic().cloned(),
        })
    }
}

/// Its rows one by one.
#[derive(Debug)]
pub struct KeptRecording {
    pub(super) read: Arc<ReadRecording>,
    next: usize,
}

impl KeptRecording {
    /// From the first row on.
    pub fn new(read: Arc<ReadRecording>) -> Self {
        KeptRecording { read, next: 0 }
    }

    pub(super) fn next_row(&mut self) -> Option<&RecordingRow> {
        let row = self.read.rows.get(self.next);
        self.next += usize::from(row.is_some());
        row
    }
}
