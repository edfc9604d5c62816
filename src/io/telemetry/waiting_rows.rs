//! Rows that a block of a file has brought and that are still to be handed out: what recordings of PCM have in common.

use super::record::RecordingRow;
use crate::flight::sample::Sample;
use std::collections::VecDeque;

/// Rows in the order of their coming, and the one that was handed out last.
#[derive(Debug)]
pub struct WaitingRows {
    waiting: VecDeque<RecordingRow>,
    newest: RecordingRow,
    ended: bool,
}

impl Default for WaitingRows {
    fn default() -> Self {
        let newest = RecordingRow { number: 0, sample: Sample::new(0.0), others: Vec::new() };
        WaitingRows { waiting: VecDeque::new(), newest, ended: false }
    }
}

impl WaitingRows {
    /// A row behind the others.
    pub fn push(&mut self, row: &RecordingRow) {
        self.waiting.push_back(row.clone());
    }

    /// No more will come.
    pub fn end(&mut self) {
        self.ended = true;
    }

    /// Whether none is left.
    pub fn is_empty(&self) -> bool {
        self.waiting.is_empty()
    }

    /// Whether the file has to be read on before the next row.
    pub fn wants_more(&self) -> bool {
        self.waiting.is_empty() && !self.ended
    }

    /// The next row; `None` where there is none.
    pub fn next_row(&mut self) -> Option<&RecordingRow> {
        self.newest = self.waiting.pop_front()?;
        Some(&self.newest)
    }

    /// Whether any row was handed out: rows count from 1.
    pub fn gave_any(&self) -> bool {
        self.newest.number > 0
    }
}
