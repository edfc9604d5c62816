//! A recording whose rows come at the times at which its channels were measured.
//!
//! Consumes a recording and what its run says of latencies (`latency_s`); produces its rows by [`super::row_alignment`].
//! Without the key rows are neither shifted nor reordered.

use super::reorder::config::ReorderSettingError;
use super::reorder::events::ReorderTally;
use super::row_alignment::{RowAlignment, WINDOW_S};
use crate::flight::file::run_file::{ChannelLatencies, RecordingColumn};
use crate::flight::signal::GAP_S;
use crate::io::telemetry::record::{RecordingError, RecordingRow};
use crate::io::telemetry::recording::Recording;
use crate::io::telemetry::waiting_rows::WaitingRows;

/// A shorter time between rows is no gap of a recording, s.
const GAP_MIN_S: f64 = 2.0 * GAP_S;

/// A recording, aligned where its run has latencies.
#[derive(Debug)]
pub struct AlignedRecording {
    /// The recording as it stands in its file.
    pub recording: Recording,
    alignment: Option<Box<RowAlignment>>,
    waiting: WaitingRows,
    last_s: f64,
    longest_gap: Option<[f64; 2]>,
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
        Ok(AlignedRecording { recording, alignment, waiting: WaitingRows::default(), last_s: f64::NAN, longest_gap: None })
    }

    /// The next row; `None` at the end.
    ///
    /// # Errors
    /// As [`Recording::next_row`]; what waited until then is lost.
    pub fn next_row(&mut self) -> Result<Option<&RecordingRow>, RecordingError> {
        let AlignedRecording { recording, alignment, waiting, last_s, longest_gap } = self;
        let row = Self::next_of(recording, alignment, waiting)?;
        if let Some(row) = row {
            let longest_s = longest_gap.map_or(GAP_MIN_S, |[from_s, to_s]| to_s - from_s);
            if row.sample.time_s - *last_s > longest_s {
                *longest_gap = Some([*last_s, row.sample.time_s]);
            }
            *last_s = row.sample.time_s;
        }
        Ok(row)
    }

    fn next_of<'a>(
        recording: &'a mut Recording,
        alignment: &mut Option<Box<RowAlignment>>,
        waiting: &'a mut WaitingRows,
    ) -> Result<Option<&'a RecordingRow>, RecordingError> {
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

    /// The longest time between two rows above a second, of the rows so far: the times of both, s.
    pub fn longest_gap(&self) -> Option<[f64; 2]> {
        self.longest_gap
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
