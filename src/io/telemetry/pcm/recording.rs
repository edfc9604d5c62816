//! A stream of PCM in a file as a recording: rows of channels in order of time.
//!
//! Consumes the bytes of the line as they were received, and the format; produces [`RecordingRow`]s ([`PcmRows`]), whose time is
//! that of their words, s from the first bit of the file. What the synchroniser and the decommutator lost is said by
//! [`PcmRecording::shortfall`]. Refused: a format whose channels have units of another quantity, a file in which no minor frame
//! is found.

use super::decoder::PcmDecoder;
use super::decommutator::DecommutationCounters;
use super::format_file::PcmFormatFile;
use super::frame_sync::SyncCounters;
use super::layout::PcmFormat;
use super::rows::PcmRows;
use crate::flight::file::run_file::{RecordingColumn, RunInfo};
use crate::io::telemetry::byte_window::read_block;
use crate::io::telemetry::record::{RecordingError, RecordingRow, SkippedByReason};
use crate::io::telemetry::waiting_rows::WaitingRows;
use std::fs::File;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

/// Read at once, bytes.
const BLOCK: usize = 4096;

/// A stream that is being read.
pub struct PcmRecording {
    path: PathBuf,
    file: File,
    format: PcmFormat,
    decoder: PcmDecoder,
    rows: PcmRows,
    info: RunInfo,
    waiting: WaitingRows,
    skipped: SkippedByReason,
}

impl std::fmt::Debug for PcmRecording {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("PcmRecording").field("path", &self.path).field("format", &self.format.spec().name).finish_non_exhaustive()
    }
}

impl PcmRecording {
    /// Opens a file of that format.
    ///
    /// # Errors
    /// [`RecordingError`] where the file cannot be opened, or the format's parameters cannot be channels.
    pub fn open(path: &Path, format: PcmFormatFile) -> Result<Self, RecordingError> {
        let whole = |what: String| RecordingError::Whole { path: path.into(), what };
        let file = File::open(path).map_err(|error| whole(format!("cannot be opened: {error}")))?;
        if file.metadata().is_ok_and(|of| of.is_dir()) {
            return Err(whole("expected a stream of PCM, found a directory".into()));
        }
        let PcmFormatFile { format, mut info, .. } = format;
        let rows = PcmRows::new(&format).map_err(|what| whole(format!("format of its frames: {what}")))?;
        info.set_controls(rows.controls());
        Ok(PcmRecording {
            path: path.into(),
            file,
            decoder: PcmDecoder::new(&format, 0.0),
            format,
            rows,
            info,
            waiting: WaitingRows::default(),
            skipped: SkippedByReason::default(),
        })
    }

    /// What the format says of the run.
    pub fn info(&self) -> &RunInfo {
        &self.info
    }

    /// The time, then the parameters in the order of the format.
    pub fn columns(&self) -> &[RecordingColumn] {
        self.rows.columns()
    }

    /// No row is skipped: samples are left out, [`PcmRecording::shortfall`] says how many.
    pub fn skipped(&self) -> &SkippedByReason {
        &self.skipped
    }

    /// What was lost or left out, in words; complete after the last row.
    pub fn shortfall(&self) -> Option<String> {
        let (sync, data) = (self.decoder.synchronizer.counters(), self.decoder.decommutator.counters());
        let parts = [losses_in_words(&sync, &data), self.rows.shortfall()];
        let parts: Vec<String> = parts.into_iter().flatten().collect();
        (!parts.is_empty()).then(|| parts.join(", "))
    }

    /// Ends the search for rows where that flag is set: there may be none, and no end of the bytes.
    pub fn stop_by(&mut self, stop: Arc<AtomicBool>) {
        self.waiting.stop_by(stop);
    }

    /// The next row; `None` at the end.
    ///
    /// # Errors
    /// [`RecordingError`] where reading fails, or the end comes without a row.
    pub fn next_row(&mut self) -> Result<Option<&RecordingRow>, RecordingError> {
        while self.waiting.wants_more() {
            self.read_on()?;
        }
        if self.waiting.found_nothing() {
            return Err(self.nothing());
        }
        Ok(self.waiting.next_row())
    }

    fn read_on(&mut self) -> Result<(), RecordingError> {
        let mut block = [0; BLOCK];
        let read = read_block(&mut self.file, &mut block);
        let count = read.map_err(|source| RecordingError::Io { path: self.path.clone(), source })?;
        let PcmRecording { decoder, rows, waiting, .. } = self;
        let mut each = |row: &RecordingRow| waiting.push(row);
        decoder.feed(block.get(..count).unwrap_or_default(), |sample| rows.put(&sample, &mut each));
        if count == 0 {
            decoder.finish(|sample| rows.put(&sample, &mut each));
            rows.finish(&mut each);
            waiting.end();
        }
        Ok(())
    }

    fn nothing(&self) -> RecordingError {
        let counters = self.decoder.synchronizer.counters();
        let sync = self.format.spec().sync;
        let digits = usize::try_from(sync.bits.div_ceil(4)).unwrap_or_default();
        let what = if counters.minor_frames == 0 {
            format!(
                "expected minor frames of {} bits behind the sync pattern {:0digits$X} ({} bits), found none in {} bits",
                self.format.minor_frame_bits(),
                sync.pattern,
                sync.bits,
                counters.bits
            )
        } else {
            let why = self.shortfall().map(|what| format!(": {what}")).unwrap_or_default();
            format!("expected samples, found none that can be used in {} minor frames{why}", counters.minor_frames)
        };
        RecordingError::Whole { path: self.path.clone(), what }
    }
}

/// What a synchroniser and a decommutator lost; `None` where that is nothing.
#[must_use]
pub fn losses_in_words(sync: &SyncCounters, data: &DecommutationCounters) -> Option<String> {
    let parts = [
        (sync.losses, "losses of frame lock"),
        (sync.missed_syncs, "sync patterns missing at their place"),
        (sync.discarded, "minor frames discarded"),
        (sync.slips, "bit slips"),
        (sync.polarity_changes, "changes of polarity"),
        (data.withheld_frames, "minor frames with unknown subframe number"),
        (data.subframe_id.jumps, "jumps of the subframe identifier"),
        (data.subframe_id.out_of_range, "subframe identifiers out of range"),
    ];
    let mut parts: Vec<String> =
        parts.iter().filter(|(count, _)| *count > 0).map(|(count, what)| format!("{count} {what}")).collect();
    if data.parity_doubted > 0 {
        let (wrong, checked, doubted) = (data.parity_errors, data.parity_checks, data.parity_doubted);
        parts.push(format!(
            "{wrong} of {checked} words have wrong parity: where it is one in five or more, the words have another parity than the \
             format says, or none; {doubted} with right parity are left out there too"
        ));
    }
    (!parts.is_empty()).then(|| parts.join(", "))
}

#[cfg(test)]
#[path = "recording_tests.rs"]
mod tests;
