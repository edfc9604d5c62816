//! A recording that was read to its end, its rows kept: what needs the whole of it first, such as the manoeuvres of a flight,
//! need not read the file again, which may be a pipe.
//!
//! Consumes what a recording gave; produces the same rows and the same words as often as it is opened. Memory is that of the
//! rows.

use super::mavlink::recording::Traffic;
use super::record::{RecordingRow, SkippedByReason};
use crate::flight::file::run_file::{RecordingColumn, RunInfo};
use std::sync::Arc;

/// All that a recording said; `Recording::read_to_end` makes it.
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
