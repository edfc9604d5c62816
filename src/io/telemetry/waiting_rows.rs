//! Rows that a block of a file has brought and that are still to be handed out: what recordings of PCM have in common. A device
//! may bring bytes without end and never a row: the search stops where a flag says so.

use super::record::RecordingRow;
use crate::flight::sample::Sample;
use std::collections::VecDeque;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// Rows in the order of their coming, and the one that was handed out last.
#[derive(Debug)]
pub struct WaitingRows {
    waiting: VecDeque<RecordingRow>,
    newest: RecordingRow,
    ended: bool,
    stop: Option<Arc<AtomicBool>>,
}

impl Default for WaitingRows {
    fn default() -> Self {
        let newest = RecordingRow { number: 0, sample: Sample::new(0.0), others: Vec::new() };
        WaitingRows { waiting: VecDeque::new(), newest, ended: false, stop: None }
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

    /// No more are wanted where that flag is set.
    pub fn stop_by(&mut self, stop: Arc<AtomicBool>) {
        self.stop = Some(stop);
    }

    fn is_stopped(&self) -> bool {
        self.stop.as_ref().is_some_and(|stop| stop.load(Ordering::Relaxed))
    }

    /// Whether the whole file was read without a row.
    pub fn found_nothing(&self) -> bool {
        self.waiting.is_empty() && self.newest.number == 0 && !self.is_stopped()
    }

    /// Whether the file has to be read on before the next row.
    pub fn wants_more(&self) -> bool {
        self.waiting.is_empty() && !self.ended && !self.is_stopped()
    }

    /// The next row; `None` where there is none.
    pub fn next_row(&mut self) -> Option<&RecordingRow> {
        self.newest = self.waiting.pop_front()?;
        Some(&self.newest)
    }
}
