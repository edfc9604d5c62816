//! A recording whose rows come at the times at which its channels were measured.
//!
//! Consumes a recording and what its run says of latencies (`latency_s`); produces its rows by [`super::row_alignment`].
//! Without the key rows are neither shifted nor reordered.

use super::reorder::config::ReorderSettingError;
use super::reorder::events::ReorderTally;
use super::row_alignment::{RowAlignment, WINDOW_S};
use crate::flight::file::run_file::{ChannelLatencies, RecordingColumn};
use crate::io::telemetry::record::{RecordingError, RecordingRow};
use crate::io::telemetry::recording::Recording;
use crate::io::telemetry::waiting_rows::WaitingRows;

/// A recording, aligned where its run has latencies.
#[derive(Debug)]
pub struct AlignedRecording {
    /// The recording as it stands in its file.
    pub recording: Recording,
    alignment: Option<Box<RowAlignment>>,
    waiting: WaitingRows,
}

impl RowAlignment {
    /// Of the rows of that recording.
    ///
    /// # Errors
    /// Never of a run's latencies, which were checked.
    pub fn of_recording(recording: &Recording, latencies: &ChannelLatencies) -> Result<Self, ReorderSettingError> {
        RowAlignment::new(latencies, RecordingColumn::others(recording.columns()).count(), WINDOW_S)
    }
}

impl AlignedRecording {
    /// By these latencies; `None` leaves the rows as they are.
    ///
    /// # Errors
    /// As [`RowAlignment::of_recording`].
    pub fn new(recording: Recording, latencies: Option<&ChannelLatencies>) -> Result<Self, ReorderSettingError> {
        let alignment = latencies.map(|latencies| RowAlignment::of_recording(&recording, latencies)).transpose()?.map(Box::new);
        Ok(AlignedRecording { recording, alignment, waiting: WaitingRows::default() })
    }

    /// The next row; `None` at the end.
    ///
    /// # Errors
    /// As [`Recording::next_row`]; what waited until then is lost.
    pub fn next_row(&mut self) -> Result<Option<&RecordingRow>, RecordingError> {
        let AlignedRecording { recording, alignment, waiting } = self;
        let Some(alignment) = alignment else { return recording.next_row() };
        while waiting.wants_more() {
            match recording.next_row()? {
                Some(row) => alignment.push(row.number, &row.sample, &row.others, &mut |row| waiting.push(row)),
                None => {
                    alignment.finish(&mut |row| waiting.push(row));
                    waiting.end();
                }
            }
        }
        Ok(waiting.next_row())
    }

    /// What of the file could not be read, and what the alignment dropped, a phrase each. Complete after the last row.
    pub fn losses(&self) -> Vec<String> {
        self.recording.shortfall().into_iter().chain(self.tally().unwrap_or_default().losses()).collect()
    }

    /// What the alignment dropped and put right; `None` where there is none. Complete after the last row.
    pub fn tally(&self) -> Option<ReorderTally> {
        self.alignment.as_ref().map(|alignment| alignment.tally())
    }
}
