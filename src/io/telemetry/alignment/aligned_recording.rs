//! A recording whose rows come at the times at which its channels were measured.
//!
//! Consumes a recording and what its run says of latencies (`latency_s`); produces its rows by [`super::row_alignment`].
//! Without the key rows are neither shifted nor reordered. Where a part of it was asked for, the other rows are left out.

use super::reorder::config::ReorderSettingError;
use super::reorder::events::ReorderTally;
use super::row_alignment::{RowAlignment, WINDOW_S};
use crate::flight::file::run_file::{ChannelLatencies, RecordingColumn};
use crate::flight::sample::Sample;
use crate::flight::signal::GAP_S;
use crate::io::telemetry::record::{RecordingError, RecordingRow};
use crate::io::telemetry::recording::Recording;
use crate::io::telemetry::waiting_rows::WaitingRows;
use std::path::PathBuf;

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
    part: Option<Box<RecordingPart>>,
}

/// A part of a recording by time.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct TimeSpan {
    /// What is earlier is left out, s.
    pub from_s: Option<f64>,
    /// What is later is left out, s.
    pub to_s: Option<f64>,
}

impl TimeSpan {
    /// Whether nothing is left out.
    pub fn is_whole(&self) -> bool {
        *self == TimeSpan::default()
    }

    /// Whether a row of that time is in it; one without a time is never left out.
    pub fn has(&self, time_s: f64) -> bool {
        !(self.from_s.is_some_and(|from_s| time_s < from_s) || self.to_s.is_some_and(|to_s| time_s > to_s))
    }

    /// The refusal of a recording of these times that has no row in it.
    pub fn refusal(&self, rows: Option<[f64; 2]>) -> String {
        let TimeSpan { from_s, to_s } = *self;
        let wanted = match (from_s, to_s) {
            (Some(from_s), Some(to_s)) => format!("from {from_s} to {to_s} s"),
            (Some(from_s), None) => format!("from {from_s} s on"),
            (None, to_s) => format!("to {} s", to_s.unwrap_or(f64::INFINITY)),
        };
        let found =
            rows.map_or("found no row".to_owned(), |[first_s, last_s]| format!("its rows are from {first_s} to {last_s} s"));
        format!("expected rows {wanted} (--from, --to); {found}")
    }
}

/// The part that is read, and what of the recording was seen.
#[derive(Debug)]
struct RecordingPart {
    span: TimeSpan,
    /// For the refusal of a recording without rows in it.
    path: PathBuf,
    current: RecordingRow,
    /// Whether the current row is still to be given.
    ahead: bool,
    any: bool,
    seen_s: Option<[f64; 2]>,
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
        Ok(AlignedRecording {
            recording,
            alignment,
            waiting: WaitingRows::default(),
            last_s: f64::NAN,
            longest_gap: None,
            part: None,
        })
    }

    /// The same without the rows outside of a part; `path` is that of the recording, for the error where none is in it.
    pub fn within(mut self, span: TimeSpan, path: PathBuf) -> Self {
        let current = RecordingRow { number: 0, sample: Sample::new(0.0), others: Vec::new() };
        self.part =
            (!span.is_whole()).then(|| Box::new(RecordingPart { span, path, current, ahead: false, any: false, seen_s: None }));
        self
    }

    /// The next row; `None` at the end.
    ///
    /// # Errors
    /// As [`Recording::next_row`]; what waited until then is lost. Where a part was asked for, an end without a row in it.
    pub fn next_row(&mut self) -> Result<Option<&RecordingRow>, RecordingError> {
        let AlignedRecording { recording, alignment, waiting, last_s, longest_gap, part } = self;
        let row = match part {
            None => Self::next_of(recording, alignment, waiting)?,
            Some(part) => Self::next_within(recording, alignment, waiting, part)?,
        };
        if let Some(row) = row {
            let longest_s = longest_gap.map_or(GAP_MIN_S, |[from_s, to_s]| to_s - from_s);
            if row.sample.time_s - *last_s > longest_s {
                *longest_gap = Some([*last_s, row.sample.time_s]);
            }
            *last_s = row.sample.time_s;
        }
        Ok(row)
    }

    fn next_within<'a>(
        recording: &mut Recording,
        alignment: &mut Option<Box<RowAlignment>>,
        waiting: &mut WaitingRows,
        part: &'a mut RecordingPart,
    ) -> Result<Option<&'a RecordingRow>, RecordingError> {
        if std::mem::take(&mut part.ahead) {
            return Ok(Some(&part.current));
        }
        while let Some(row) = Self::next_of(recording, alignment, waiting)? {
            let time_s = row.sample.time_s;
            if time_s.is_finite() {
                part.seen_s =
                    Some(part.seen_s.map_or([time_s; 2], |[first_s, last_s]| [first_s.min(time_s), last_s.max(time_s)]));
            }
            if part.span.has(time_s) {
                part.any |= time_s.is_finite();
                part.current.clone_from(row);
                return Ok(Some(&part.current));
            }
        }
        if part.any {
            return Ok(None);
        }
        Err(RecordingError::Whole { path: part.path.clone(), what: part.span.refusal(part.seen_s) })
    }

    /// How much later than the recording the part begins, s: its first row is read, and given next. Zero without a part.
    ///
    /// # Errors
    /// As [`AlignedRecording::next_row`].
    pub fn begins_after(&mut self) -> Result<f64, RecordingError> {
        let AlignedRecording { recording, alignment, waiting, part, .. } = self;
        let Some(part) = part else { return Ok(0.0) };
        if Self::next_within(recording, alignment, waiting, part)?.is_none() {
            return Ok(0.0);
        }
        part.ahead = true;
        Ok(part.seen_s.map_or(0.0, |[first_s, _]| part.current.sample.time_s - first_s))
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
