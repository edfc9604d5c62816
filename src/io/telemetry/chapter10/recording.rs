//! An IRIG 106 Chapter 10 file as a recording: rows of the channels that one of its PCM channels carries.
//!
//! Consumes the file, and where the format of the frames comes from ([`FrameDescription`]); produces [`RecordingRow`]s. Time is
//! that of the relative time counter, s from the first packet of data, so that several PCM channels of a file have one time;
//! the time of day of its zero is the key `time_zero` of the run. Time packets are held against the counter and do not change
//! it. What is damaged or missing, and where the data contradict the setup, [`Chapter10Recording::shortfall`] says. Refused: a
//! file whose setup gives no channel, one in which no minor frame is found. Memory is bounded by the longest packet.

use super::channel_choice::{ChosenChannel, FrameDescription};
use super::channel_rows::ChannelRows;
use super::packet::{Chapter10Packet, Chapter10Reader};
use super::recording_start::RecordingStart;
use super::time_relation::TimeRelation;
use crate::flight::file::run_file::{RecordingColumn, RunInfo};
use crate::io::telemetry::byte_window::read_block;
use crate::io::telemetry::record::{RecordingError, RecordingRow, SkippedByReason};
use crate::io::telemetry::waiting_rows::WaitingRows;
use std::fs::File;
use std::io::{Seek, SeekFrom};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

/// Read at once, bytes.
const BLOCK: usize = 64 << 10;

/// A recording that is being read.
#[derive(Debug)]
pub struct Chapter10Recording {
    path: PathBuf,
    file: File,
    block: Vec<u8>,
    reader: Chapter10Reader,
    relation: TimeRelation,
    rows: ChannelRows,
    chosen: ChosenChannel,
    info: RunInfo,
    waiting: WaitingRows,
    skipped: SkippedByReason,
}

impl Chapter10Recording {
    /// Opens a file.
    ///
    /// # Errors
    /// [`RecordingError`] where it cannot be read, holds no packets, or does not say which channels its frames carry.
    pub fn open(path: &Path, description: &FrameDescription) -> Result<Self, RecordingError> {
        let whole = |what: String| RecordingError::Whole { path: path.into(), what };
        let io = |source| RecordingError::Io { path: path.into(), source };
        let mut file = File::open(path).map_err(|error| whole(format!("cannot be opened: {error}")))?;
        if file.metadata().is_ok_and(|of| of.is_dir()) {
            return Err(whole("expected a recording after IRIG 106 Chapter 10, found a directory".into()));
        }
        let mut block = vec![0; BLOCK];
        let start = RecordingStart::read(&mut file, &mut block).map_err(io)?;
        if start.packets == 0 {
            return Err(whole("expected packets of IRIG 106 Chapter 10, found none".into()));
        }
        if start.setup.is_empty() && start.is_xml && description.needs_setup() {
            return Err(whole("expected a setup (TMATS) as text, found XML: give a format of its frames".into()));
        }
        let chosen = description.choose(&start.setup).map_err(whole)?;
        let rows = ChannelRows::new(&chosen).map_err(|what| whole(format!("format of its frames: {what}")))?;
        let mut info = chosen.info.clone();
        if let Some(moment) = &start.moment {
            let text = format!("{}\ntime_zero = \"{moment}\"\n", info.to_toml());
            info = RunInfo::from_toml(&text).map_err(|wrong| whole(wrong.what))?;
        }
        info.set_controls(rows.controls());
        file.seek(SeekFrom::Start(0)).map_err(io)?;
        Ok(Chapter10Recording {
            path: path.into(),
            file,
            block,
            reader: Chapter10Reader::default(),
            relation: TimeRelation::default(),
            rows,
            chosen,
            info,
            waiting: WaitingRows::default(),
            skipped: SkippedByReason::default(),
        })
    }

    /// What its format says of the run, and the time of day of its zero.
    pub fn info(&self) -> &RunInfo {
        &self.info
    }

    /// The time, then the parameters in the order of the format.
    pub fn columns(&self) -> &[RecordingColumn] {
        self.rows.columns()
    }

    /// No row is skipped: packets and samples are left out, [`Chapter10Recording::shortfall`] says how many.
    pub fn skipped(&self) -> &SkippedByReason {
        &self.skipped
    }

    /// Measurements of the setup that are not read, each with the reason.
    pub fn left_out(&self) -> &[String] {
        &self.chosen.left_out
    }

    /// What the setup does not say of channels and was assumed, each in a sentence.
    pub fn assumed(&self) -> &[String] {
        &self.chosen.assumed
    }

    /// The channel that is read; `None` before the first of its packets where none was named.
    pub fn channel(&self) -> Option<u16> {
        self.rows.channel()
    }

    /// What was lost or left out, and what contradicts the setup, in words; complete after the last row.
    pub fn shortfall(&self) -> Option<String> {
        let mut parts = self.rows.shortfalls();
        let (tally, times) = (self.reader.tally(), self.relation.tally());
        if tally.skipped_bytes > 0 {
            parts.push(format!("{} bytes that belong to no packet", tally.skipped_bytes));
        }
        if times.unreadable > 0 {
            parts.push(format!("{} time packets that cannot be read", times.unreadable));
        }
        if let Some(first) = times.first_disagreement {
            let apart_s = (first.found_ns - first.expected_ns) as f64 * 1e-9;
            let (count, rtc) = (times.disagreements, first.rtc);
            parts.push(format!("{count} time packets disagree with the counter, the first by {apart_s:.3} s at count {rtc}"));
        }
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
        let read = read_block(&mut self.file, &mut self.block);
        let count = read.map_err(|source| RecordingError::Io { path: self.path.clone(), source })?;
        let Chapter10Recording { reader, relation, rows, waiting, block, .. } = self;
        let mut each = |row: &RecordingRow| waiting.push(row);
        let mut take = |packet: &Chapter10Packet<'_>| {
            // What cannot be read is in the tally.
            let _ = relation.packet(packet);
            rows.packet(packet, 0.0, &mut each);
        };
        let mut rest = block.get(..count).unwrap_or_default();
        while !rest.is_empty() {
            rest = rest.get(reader.take(rest)..).unwrap_or_default();
            while let Some(packet) = reader.next_packet() {
                take(&packet);
            }
        }
        if count == 0 {
            while let Some(packet) = reader.finish() {
                take(&packet);
            }
            rows.finish(&mut each);
            waiting.end();
        }
        Ok(())
    }

    fn nothing(&self) -> RecordingError {
        let tally = self.rows.decoder().tally();
        let of = match self.rows.channel() {
            Some(channel) => format!("channel {channel}"),
            None => "a PCM channel".to_owned(),
        };
        let sync = self.chosen.format.spec().sync;
        let pattern = match tally.minor_frames {
            0 => format!(" with the sync pattern {:X} ({} bits)", sync.pattern, sync.bits),
            _ => String::new(),
        };
        let found = format!("found {} packets and {} minor frames{pattern} of it", tally.packets, tally.minor_frames);
        let why = self.shortfall().map(|what| format!(": {what}")).unwrap_or_default();
        let what = format!("expected samples of {of}, {found}, and none that can be used{why}");
        RecordingError::Whole { path: self.path.clone(), what }
    }
}
