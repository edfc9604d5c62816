//! A recording, whatever its format: what the run says of itself, its columns, and its rows one by one.
//!
//! Consumes a path; produces [`RecordingRow`]s with the known channels in SI and the others as they came. The order of time is
//! not judged here. A row that cannot be read is skipped and counted ([`SkippedByReason`]), never guessed; a file of which no
//! row can be read is an error. Memory is bounded by the longest row, not by the file.

use super::channel_map::map_file::{ChannelMap, MapKind};
use super::chapter10::channel_choice::FrameDescription;
use super::chapter10::recording::Chapter10Recording;
use super::csv::CsvRecording;
use super::format::{HEAD_BYTES, RecordingFormat};
use super::log_recording::LogRecording;
use super::logs::recording::{AutopilotLog, AutopilotRecording};
use super::mapped_log::MappedLog;
use super::mavlink::packet::Framing;
use super::mavlink::recording::{MavlinkRecording, Traffic};
use super::pcm::format_file::PcmFormatFile;
use super::pcm::recording::PcmRecording;
use super::read_recording::{KeptRecording, ReadRecording};
use super::record::{RecordingError, RecordingRow, SkippedByReason};
use super::recording_config::RecordingConfig;
use super::table::files::TablesRecording;
use crate::flight::file::run_file::{RecordingColumn, RunInfo};
use std::fs::File;
use std::io::{Cursor, Read, Seek, SeekFrom};
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

/// A recording that is being read.
#[derive(Debug)]
pub enum Recording {
    /// A run file in text.
    Csv(Box<CsvRecording>),
    /// Tables in several files.
    Tables(Box<TablesRecording>),
    /// A log of this program.
    Mcap(Box<LogRecording>),
    /// A log of another program, by a map.
    MappedLog(Box<MappedLog>),
    /// Messages of MAVLink.
    Mavlink(Box<MavlinkRecording>),
    /// A log of an autopilot.
    Autopilot(Box<AutopilotRecording>),
    /// A stream of PCM.
    Pcm(Box<PcmRecording>),
    /// Packets after IRIG 106 Chapter 10.
    Chapter10(Box<Chapter10Recording>),
    /// One that was read before.
    Kept(KeptRecording),
}

impl Recording {
    /// Opens a recording; its format is recognised by its content.
    ///
    /// # Errors
    /// [`RecordingError`] where the file cannot be read, is of another format, or its preamble or header is wrong.
    pub fn open(path: &Path) -> Result<Self, RecordingError> {
        Recording::open_with(path, &RecordingConfig::default())
    }

    /// The same, with a configuration of which message or measurement gives which channel.
    ///
    /// # Errors
    /// As [`Recording::open`].
    pub fn open_with(path: &Path, config: &RecordingConfig) -> Result<Self, RecordingError> {
        let whole = |what: String| RecordingError::Whole { path: path.into(), what };
        let cannot = |error: std::io::Error| whole(format!("cannot be opened: {error}"));
        if let Some(map) = config.map.as_ref().filter(|map| map.kind == MapKind::Files) {
            return TablesRecording::open(path, map).map(|tables| Recording::Tables(Box::new(tables)));
        }
        let mut file = File::open(path).map_err(cannot)?;
        if file.metadata().map_err(cannot)?.is_dir() {
            let what = "expected a recording, found a directory; one that stands in several files is read by a map with [[file]], which \
                        `sideslip inspect DIRECTORY --map-template map.toml` writes";
            return Err(whole(what.into()));
        }
        let mut head = Vec::with_capacity(HEAD_BYTES);
        let limit = u64::try_from(HEAD_BYTES).unwrap_or(u64::MAX);
        file.by_ref().take(limit).read_to_end(&mut head).map_err(|source| RecordingError::Io { path: path.into(), source })?;
        if let Some(map) = &config.map {
            return Recording::open_mapped(path, map, head, file);
        }
        match RecordingFormat::of(&head) {
            RecordingFormat::Csv => {
                CsvRecording::new(path, Box::new(Cursor::new(head).chain(file))).map(|text| Recording::Csv(Box::new(text)))
            }
            RecordingFormat::Mcap => {
                file.seek(SeekFrom::Start(0)).map_err(|source| RecordingError::Io { path: path.into(), source })?;
                LogRecording::new(path, file).map(|log| Recording::Mcap(Box::new(log)))
            }
            RecordingFormat::Tlog => MavlinkRecording::new(path, file, Framing::Stamped, config.mavlink.clone())
                .map(|recording| Recording::Mavlink(Box::new(recording))),
            RecordingFormat::Mavlink => MavlinkRecording::new(path, file, Framing::Bare, config.mavlink.clone())
                .map(|recording| Recording::Mavlink(Box::new(recording))),
            RecordingFormat::Dataflash => AutopilotRecording::new(path, file, AutopilotLog::Dataflash)
                .map(|recording| Recording::Autopilot(Box::new(recording))),
            RecordingFormat::Ulog => {
                AutopilotRecording::new(path, file, AutopilotLog::Ulog).map(|recording| Recording::Autopilot(Box::new(recording)))
            }
            RecordingFormat::Chapter10 => Recording::open_chapter10(path, &config.chapter10),
            RecordingFormat::Named(name) => Err(whole(format!("recognised as {name}, which this version does not read yet"))),
            RecordingFormat::Empty => Err(whole("expected a recording, found an empty file".into())),
            RecordingFormat::Unknown(bytes) => {
                let hex: Vec<String> = bytes.iter().map(|byte| format!("{byte:02x}")).collect();
                Err(whole(format!("expected a recording, found no known format: it starts with the bytes {}", hex.join(" "))))
            }
        }
    }

    /// Opens a recording of another program, whose first bytes are read already.
    fn open_mapped(path: &Path, map: &ChannelMap, head: Vec<u8>, file: File) -> Result<Self, RecordingError> {
        let wrong = |what: String| Err(RecordingError::Whole { path: path.into(), what });
        match (RecordingFormat::of(&head), map.kind, map.sections.first()) {
            (RecordingFormat::Csv, MapKind::Table, Some(section)) => {
                let mut info = map.info.clone();
                info.set_controls(map.controls());
                CsvRecording::mapped(path, Box::new(Cursor::new(head).chain(file)), section, info)
                    .map(|text| Recording::Csv(Box::new(text)))
            }
            (RecordingFormat::Mcap, MapKind::Topics, _) => {
                MappedLog::new(path, file, map).map(|log| Recording::MappedLog(Box::new(log)))
            }
            (RecordingFormat::Mcap, ..) => wrong("--map: expected a map of topics ([[topic]]), found one of tables".to_owned()),
            (RecordingFormat::Csv, ..) => wrong("--map: expected a map of one table, found one of topics of a log".to_owned()),
            (format, ..) => wrong(format!(
                "--map: expected a table in text (CSV) or an MCAP log of another program, found {}; without --map it is read by \
                 what it says itself",
                format.words()
            )),
        }
    }

    /// Opens a stream of PCM whose frames have the format of that file: bits have no signature of their own.
    ///
    /// # Errors
    /// [`RecordingError`] where one of the files cannot be read, or the format is wrong.
    pub fn open_pcm(path: &Path, format: &Path) -> Result<Self, RecordingError> {
        let format = PcmFormatFile::read(format)?;
        PcmRecording::open(path, format).map(|recording| Recording::Pcm(Box::new(recording)))
    }

    /// Opens packets after IRIG 106 Chapter 10, whatever the file begins with.
    ///
    /// # Errors
    /// [`RecordingError`] where the file cannot be read, or nothing says which channels its frames carry.
    pub fn open_chapter10(path: &Path, description: &FrameDescription) -> Result<Self, RecordingError> {
        Chapter10Recording::open(path, description).map(|recording| Recording::Chapter10(Box::new(recording)))
    }

    /// The format in a word.
    pub fn format(&self) -> &'static str {
        match self {
            Recording::Csv(_) => "CSV",
            Recording::Tables(_) => "CSV in several files",
            Recording::Mcap(_) | Recording::MappedLog(_) => "MCAP",
            Recording::Mavlink(recording) => recording.format(),
            Recording::Autopilot(recording) => recording.format(),
            Recording::Pcm(_) => "PCM",
            Recording::Chapter10(_) => "IRIG 106 Chapter 10",
            Recording::Kept(recording) => recording.read.format,
        }
    }

    /// What rows are numbered by, in a word for messages.
    pub fn counted_in(&self) -> &'static str {
        match self {
            Recording::Csv(_) => "line",
            Recording::Tables(_)
            | Recording::Mcap(_)
            | Recording::MappedLog(_)
            | Recording::Mavlink(_)
            | Recording::Autopilot(_)
            | Recording::Pcm(_)
            | Recording::Chapter10(_) => "sample",
            Recording::Kept(recording) => recording.read.counted_in,
        }
    }

    /// What the run says of itself.
    pub fn info(&self) -> &RunInfo {
        match self {
            Recording::Csv(recording) => recording.info(),
            Recording::Tables(recording) => recording.info(),
            Recording::Mcap(recording) => recording.info(),
            Recording::MappedLog(recording) => recording.info(),
            Recording::Mavlink(recording) => recording.info(),
            Recording::Autopilot(recording) => recording.info(),
            Recording::Pcm(recording) => recording.info(),
            Recording::Chapter10(recording) => recording.info(),
            Recording::Kept(recording) => &recording.read.info,
        }
    }

    /// The columns in the order of the file.
    pub fn columns(&self) -> &[RecordingColumn] {
        match self {
            Recording::Csv(recording) => recording.columns(),
            Recording::Tables(recording) => recording.columns(),
            Recording::Mcap(recording) => recording.columns(),
            Recording::MappedLog(recording) => recording.columns(),
            Recording::Mavlink(recording) => recording.columns(),
            Recording::Autopilot(recording) => recording.columns(),
            Recording::Pcm(recording) => recording.columns(),
            Recording::Chapter10(recording) => recording.columns(),
            Recording::Kept(recording) => &recording.read.columns,
        }
    }

    /// Ends the search for rows where that flag is set: in bits that are not in lock it could last without end.
    pub fn stop_by(&mut self, stop: Arc<AtomicBool>) {
        match self {
            Recording::Pcm(recording) => recording.stop_by(stop),
            Recording::Chapter10(recording) => recording.stop_by(stop),
            // Each of the others is found by its first bytes, and has an end.
            Recording::Csv(_)
            | Recording::Tables(_)
            | Recording::Mcap(_)
            | Recording::MappedLog(_)
            | Recording::Mavlink(_)
            | Recording::Autopilot(_)
            | Recording::Kept(_) => {}
        }
    }

    /// Reads it to its end and keeps everything.
    ///
    /// # Errors
    /// As [`Recording::next_row`].
    pub fn read_to_end(mut self) -> Result<ReadRecording, RecordingError> {
        let mut rows = Vec::new();
        while let Some(row) = self.next_row()? {
            rows.push(row.clone());
        }
        Ok(ReadRecording {
            format: self.format(),
            counted_in: self.counted_in(),
            info: self.info().clone(),
            columns: self.columns().to_vec(),
            rows,
            skipped: self.skipped().clone(),
            left_out: self.left_out().to_vec(),
            assumed: self.assumed().to_vec(),
            found_out: self.found_out().to_vec(),
            shortfall: self.shortfall(),
            ends_abruptly: self.ends_abruptly(),
            traffic: self.traffic().cloned(),
        })
    }

    /// The next row that can be read; `None` at the end.
    ///
    /// # Errors
    /// [`RecordingError`] where reading fails, a row is longer than memory allows for, or the end comes without a single
    /// good row.
    pub fn next_row(&mut self) -> Result<Option<&RecordingRow>, RecordingError> {
        match self {
            Recording::Csv(recording) => recording.next_row(),
            Recording::Tables(recording) => recording.next_row(),
            Recording::Mcap(recording) => recording.next_row(),
            Recording::MappedLog(recording) => recording.next_row(),
            Recording::Mavlink(recording) => recording.next_row(),
            Recording::Autopilot(recording) => recording.next_row(),
            Recording::Pcm(recording) => recording.next_row(),
            Recording::Chapter10(recording) => recording.next_row(),
            Recording::Kept(recording) => Ok(recording.next_row()),
        }
    }

    /// What was skipped so far.
    pub fn skipped(&self) -> &SkippedByReason {
        match self {
            Recording::Csv(recording) => recording.skipped(),
            Recording::Tables(recording) => recording.skipped(),
            Recording::Mcap(recording) => recording.skipped(),
            Recording::MappedLog(recording) => recording.skipped(),
            Recording::Mavlink(recording) => recording.skipped(),
            Recording::Autopilot(recording) => recording.skipped(),
            Recording::Pcm(recording) => recording.skipped(),
            Recording::Chapter10(recording) => recording.skipped(),
            Recording::Kept(recording) => &recording.read.skipped,
        }
    }

    /// Measurements of a setup that are not read, each with the reason.
    pub fn left_out(&self) -> &[String] {
        match self {
            Recording::Chapter10(recording) => recording.left_out(),
            Recording::Kept(recording) => &recording.read.left_out,
            _ => &[],
        }
    }

    /// What a setup does not say of channels and was assumed, each in a sentence.
    pub fn assumed(&self) -> &[String] {
        match self {
            Recording::Chapter10(recording) => recording.assumed(),
            Recording::Kept(recording) => &recording.read.assumed,
            _ => &[],
        }
    }

    /// What of the file's form was found out and not stated, and which columns may be channels, in sentences.
    pub fn found_out(&self) -> &[String] {
        match self {
            Recording::Csv(recording) => recording.found_out(),
            Recording::Tables(recording) => recording.found_out(),
            Recording::Kept(recording) => &recording.read.found_out,
            _ => &[],
        }
    }

    /// What of the file could not be read, besides the rows that [`Recording::skipped`] counts, in words; complete after
    /// the last row.
    pub fn shortfall(&self) -> Option<String> {
        match self {
            Recording::Csv(_) | Recording::Tables(_) => None,
            Recording::Mcap(recording) => recording.shortfall(),
            Recording::MappedLog(recording) => recording.shortfall(),
            Recording::Mavlink(recording) => recording.shortfall(),
            Recording::Autopilot(recording) => recording.shortfall(),
            Recording::Pcm(recording) => recording.shortfall(),
            Recording::Chapter10(recording) => recording.shortfall(),
            Recording::Kept(recording) => recording.read.shortfall.clone(),
        }
    }

    /// Whether the recording stops without its proper end (no end of line, no footer): it may have been cut short.
    pub fn ends_abruptly(&self) -> bool {
        match self {
            Recording::Csv(recording) => recording.ends_abruptly(),
            Recording::Mcap(recording) => recording.ends_abruptly(),
            Recording::MappedLog(recording) => recording.ends_abruptly(),
            Recording::Tables(_)
            | Recording::Mavlink(_)
            | Recording::Autopilot(_)
            | Recording::Pcm(_)
            | Recording::Chapter10(_) => false,
            Recording::Kept(recording) => recording.read.ends_abruptly,
        }
    }

    /// Who sent what, of messages.
    pub fn traffic(&self) -> Option<&Traffic> {
        match self {
            Recording::Csv(_)
            | Recording::Tables(_)
            | Recording::Mcap(_)
            | Recording::MappedLog(_)
            | Recording::Autopilot(_)
            | Recording::Pcm(_)
            | Recording::Chapter10(_) => None,
            Recording::Mavlink(recording) => Some(recording.traffic()),
            Recording::Kept(recording) => recording.read.traffic.as_ref(),
        }
    }
}
