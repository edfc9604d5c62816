//! A log of an autopilot as a recording: its channels, and their samples row by row in order of time.
//!
//! Consumes a dataflash log or a ULog in two passes: the first finds the channels and where they come from, the second reads
//! the samples. A row holds the channels of one time stamp; rows wait [`HOLD_US`] for streams that are logged later, and what
//! comes later still is counted and left out. Time is that of the autopilot's clock, s since it started; where the clock began
//! anew, the column `restart` counts it and time goes back. What the channels are (instruments, estimates of the autopilot,
//! commands) is in the run's table `sources`.
//! Refused: a file without a single channel.

use super::dataflash::reader::DataflashReader;
use super::mapping::dataflash::DataflashMapping;
use super::mapping::ulog::UlogMapping;
use super::mapping::{LogNature, LogRow, LogSource};
use super::ulog::error::UlogError;
use super::ulog::message::UlogMessage;
use super::ulog::reader::UlogReader;
use crate::flight::channel::Channel;
use crate::flight::file::run_file::{RecordingColumn, RecordingHeader, RunInfo};
use crate::flight::sample::Sample;
use crate::io::telemetry::byte_window::read_block;
use crate::io::telemetry::record::{RecordingError, RecordingRow, SkippedByReason};
use std::collections::BTreeMap;
use std::fs::File;
use std::io::{Seek, SeekFrom};
use std::path::{Path, PathBuf};

/// How long a row waits for channels of the same time, us of the log's clock.
pub const HOLD_US: u64 = 1_000_000;
/// Rows that wait at most; the oldest goes when there are more.
const WAITING_MAX: usize = 8192;
/// How much is read at once, bytes.
const BLOCK: usize = 64 << 10;

/// Which autopilot wrote it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum AutopilotLog {
    /// ArduPilot dataflash.
    Dataflash,
    /// PX4 ULog.
    Ulog,
}

/// Bytes to values of channels.
#[derive(Debug)]
enum ChannelReader {
    Dataflash(Box<DataflashReader>, DataflashMapping),
    Ulog(Box<UlogReader>, UlogMapping),
}

impl ChannelReader {
    fn new(log: AutopilotLog) -> Self {
        match log {
            AutopilotLog::Dataflash => ChannelReader::Dataflash(Box::<DataflashReader>::default(), DataflashMapping::new()),
            AutopilotLog::Ulog => ChannelReader::Ulog(Box::<UlogReader>::default(), UlogMapping::new()),
        }
    }

    /// Takes in bytes, or the end where there are none, and hands on every value.
    fn take(&mut self, mut bytes: &[u8], put: &mut dyn FnMut(LogRow)) -> Result<(), UlogError> {
        let ended = bytes.is_empty();
        loop {
            match self {
                ChannelReader::Dataflash(reader, mapping) => {
                    bytes = bytes.get(reader.take(bytes)..).unwrap_or_default();
                    while let Some(message) = if ended { reader.last_message() } else { reader.next_message() } {
                        mapping.map(&message, &mut *put);
                    }
                    if ended {
                        mapping.finish();
                    }
                }
                ChannelReader::Ulog(reader, mapping) => {
                    bytes = bytes.get(reader.take(bytes)..).unwrap_or_default();
                    while let Some(message) = if ended { reader.last_message()? } else { reader.next_message()? } {
                        match message {
                            UlogMessage::Data(data) => mapping.map(&data, &mut *put),
                            UlogMessage::Parameter(keyed) => mapping.parameter(&keyed),
                            _ => {}
                        }
                    }
                    if ended {
                        mapping.finish();
                    }
                }
            }
            if bytes.is_empty() {
                return Ok(());
            }
        }
    }

    /// What was damaged or not used, in words.
    fn shortfall(&self) -> Vec<(u64, &'static str)> {
        match self {
            ChannelReader::Dataflash(reader, mapping) => {
                let (tally, mapped) = (reader.tally(), mapping.tally());
                vec![
                    (tally.garbage_bytes, "bytes that belong to no message"),
                    (tally.unreadable + tally.doubtful, "messages that contradict their definition or what follows"),
                    (tally.truncated.is_some().into(), "message cut short by the end"),
                    (mapped.out_of_order, "messages whose time contradicts the others"),
                    (mapped.wrong_unit, "values with a unit of another quantity"),
                ]
            }
            ChannelReader::Ulog(reader, mapping) => {
                let (tally, mapped) = (reader.tally(), mapping.tally());
                vec![
                    (tally.dropout_ms, "ms that the logger lost"),
                    (tally.garbage_bytes, "bytes that belong to no message"),
                    (tally.wrong_size + tally.refused + tally.doubtful, "messages that contradict their definition"),
                    (tally.truncated.is_some().into(), "message cut short by the end"),
                    (mapped.out_of_order, "messages whose time contradicts the others"),
                ]
            }
        }
    }
}

/// Known channels and the others, of one time stamp.
type WaitingRow = (Sample, Vec<Option<f64>>);

/// A log that is being read.
pub struct AutopilotRecording {
    path: PathBuf,
    file: File,
    log: AutopilotLog,
    reader: ChannelReader,
    block: Box<[u8]>,
    info: RunInfo,
    columns: Vec<RecordingColumn>,
    /// Place among the other columns, by name.
    others: BTreeMap<&'static str, usize>,
    waiting: BTreeMap<(u32, u64), WaitingRow>,
    newest: (u32, u64),
    released: Option<(u32, u64)>,
    late: u64,
    row: RecordingRow,
    skipped: SkippedByReason,
    ended: bool,
}

impl std::fmt::Debug for AutopilotRecording {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("AutopilotRecording").field("path", &self.path).field("log", &self.log).finish_non_exhaustive()
    }
}

/// What the first pass finds.
#[derive(Default)]
struct Found {
    channels: Vec<(&'static str, &'static str)>,
    sources: Vec<&'static LogSource>,
    restarts: u32,
}

impl Found {
    fn row(&mut self, row: &LogRow) {
        if !self.channels.iter().any(|(name, _)| *name == row.channel.name) {
            self.channels.push((row.channel.name, row.channel.unit));
        }
        if !self.sources.iter().any(|source| std::ptr::eq(*source, row.source)) {
            self.sources.push(row.source);
        }
        self.restarts = self.restarts.max(row.restart);
    }

    fn info(&self, log: AutopilotLog) -> String {
        let mut text = format!("source = {}\n\n[sources]\n", toml::Value::from(format!("log of {}", writer(log))));
        for (place, source) in (1..).zip(&self.sources) {
            let nature = match source.nature {
                LogNature::Instrument => "instrument",
                LogNature::Processed => "processed reading",
                LogNature::Estimate => "estimate of the autopilot",
                LogNature::Command => "command",
            };
            let words = format!("{}: {}, {nature} ({})", source.channels, source.message, source.note);
            text.push_str(&format!("source_{place:02} = {}\n", toml::Value::from(words)));
        }
        text
    }
}

const fn writer(log: AutopilotLog) -> &'static str {
    match log {
        AutopilotLog::Dataflash => "ArduPilot (dataflash)",
        AutopilotLog::Ulog => "PX4 (ULog)",
    }
}

impl AutopilotRecording {
    /// Reads the file once to see what is in it; `path` is named in messages only.
    ///
    /// # Errors
    /// [`RecordingError`] where reading fails, the bytes are no such log, or it holds no channel.
    pub fn new(path: &Path, mut file: File, log: AutopilotLog) -> Result<Self, RecordingError> {
        let whole = |what: String| RecordingError::Whole { path: path.into(), what };
        let io = |source| RecordingError::Io { path: path.into(), source };
        file.seek(SeekFrom::Start(0)).map_err(io)?;
        let (mut reader, mut block, mut found) = (ChannelReader::new(log), vec![0; BLOCK].into_boxed_slice(), Found::default());
        loop {
            let count = read_block(&mut file, &mut block).map_err(io)?;
            let bytes = block.get(..count).unwrap_or_default();
            reader.take(bytes, &mut |row| found.row(&row)).map_err(|error| whole(error.to_string()))?;
            if count == 0 {
                break;
            }
        }
        if found.channels.is_empty() {
            return Err(whole(format!("expected channels of an aircraft in the log of {}, found none", writer(log))));
        }
        found.channels.sort_by_key(|(name, _)| Channel::from_name(name).map_or(usize::MAX, |(channel, _)| channel.index()));
        let mut columns = vec![RecordingColumn::new("time", None).map_err(whole)?];
        let mut others = BTreeMap::new();
        for &(name, unit) in &found.channels {
            let is_known = Channel::from_name(name).is_some();
            columns.push(RecordingColumn::new(name, Some(unit).filter(|unit| !is_known && !unit.is_empty())).map_err(whole)?);
            if !is_known {
                others.insert(name, others.len());
            }
        }
        if found.restarts > 0 {
            columns.push(RecordingColumn::new("restart", None).map_err(whole)?);
            others.insert("restart", others.len());
        }
        let mut info = RunInfo::from_toml(&found.info(log)).map_err(|place| whole(place.to_string()))?;
        let RecordingHeader { columns, controls, .. } = RecordingHeader::from_columns(columns).map_err(whole)?;
        info.set_controls(controls);
        file.seek(SeekFrom::Start(0)).map_err(io)?;
        Ok(AutopilotRecording {
            path: path.into(),
            file,
            log,
            reader: ChannelReader::new(log),
            block,
            info,
            columns,
            row: RecordingRow { number: 0, sample: Sample::new(0.0), others: vec![None; others.len()] },
            others,
            waiting: BTreeMap::new(),
            newest: (0, 0),
            released: None,
            late: 0,
            skipped: SkippedByReason::default(),
            ended: false,
        })
    }

    /// The format in a word.
    pub fn format(&self) -> &'static str {
        match self.log {
            AutopilotLog::Dataflash => "ArduPilot dataflash",
            AutopilotLog::Ulog => "PX4 ULog",
        }
    }

    /// What the run says of itself.
    pub fn info(&self) -> &RunInfo {
        &self.info
    }

    /// The time, the known channels in the order of their places, the others.
    pub fn columns(&self) -> &[RecordingColumn] {
        &self.columns
    }

    /// No row is skipped: what is damaged is no row yet.
    pub fn skipped(&self) -> &SkippedByReason {
        &self.skipped
    }

    /// What of the file could not be read or used, in words; complete after the last row.
    pub fn shortfall(&self) -> Option<String> {
        let late = [(self.late, "values later than a second behind the others")];
        let parts = self.reader.shortfall().into_iter().chain(late);
        let parts: Vec<String> = parts.filter(|(count, _)| *count > 0).map(|(count, what)| format!("{count} {what}")).collect();
        (!parts.is_empty()).then(|| format!("passed over: {}", parts.join(", ")))
    }

    /// The next row; `None` at the end.
    ///
    /// # Errors
    /// [`RecordingError`] where reading fails.
    pub fn next_row(&mut self) -> Result<Option<&RecordingRow>, RecordingError> {
        loop {
            let (restart, time_us) = self.newest;
            let is_due = |key: &(u32, u64)| key.0 < restart || key.1.saturating_add(HOLD_US) < time_us;
            let is_full = self.waiting.len() > WAITING_MAX;
            if let Some(first) = self.waiting.first_entry()
                && (self.ended || is_full || is_due(first.key()))
            {
                let (key, (sample, others)) = first.remove_entry();
                self.released = Some(key);
                self.row = RecordingRow { number: self.row.number + 1, sample, others };
                if let Some(place) = self.others.get("restart").and_then(|place| self.row.others.get_mut(*place)) {
                    *place = Some(f64::from(key.0));
                }
                return Ok(Some(&self.row));
            }
            if self.ended {
                return Ok(None);
            }
            self.read_on()?;
        }
    }

    fn read_on(&mut self) -> Result<(), RecordingError> {
        let AutopilotRecording { path, file, reader, block, others, waiting, newest, released, late, .. } = self;
        let count = read_block(file, block).map_err(|source| RecordingError::Io { path: path.clone(), source })?;
        let mut put = |row: LogRow| {
            let key = (row.restart, row.time_us);
            if released.is_some_and(|released| key <= released) {
                *late += 1;
                return;
            }
            *newest = (*newest).max(key);
            let (sample, beside) = waiting.entry(key).or_insert_with(|| (Sample::new(row.time_s()), vec![None; others.len()]));
            match Channel::from_name(row.channel.name) {
                Some((channel, _)) => sample.set(channel, row.value),
                None => {
                    if let Some(place) = others.get(row.channel.name).and_then(|place| beside.get_mut(*place)) {
                        *place = Some(row.value);
                    }
                }
            }
        };
        let taken = reader.take(block.get(..count).unwrap_or_default(), &mut put);
        taken.map_err(|error| RecordingError::Whole { path: path.clone(), what: error.to_string() })?;
        self.ended = count == 0;
        Ok(())
    }
}
