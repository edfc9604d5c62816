//! The MCAP log: every message on its topic as JSON, readable up to the last flush after a crash.
//!
//! The head of the run is written as the metadata record `run` and flushed before the first message. Chunks are buffered and
//! written whole (lz4, no seeking), so that flushed data survive the process. After a failed write the file is left as it is,
//! with the chunks that are in it whole; the loss is reported and counted (a chunk that is torn counts as lost, though a reader
//! may recover its beginning), and the log continues in a new file `name.1.mcap`. If that cannot be begun, nothing is left of it,
//! attempts follow after 1 s, 2 s and so on, at most once a minute, and dropped messages are counted. A log that is to be one
//! file ([`McapLog::one_file`]) has no further files.
//!
//! `log_time` and `publish_time` are UTC, nanoseconds since 1970, where the run says when it was recorded (`recorded_at`, of its
//! first message): with t0 that message's time,
//!     log_time = recorded_at + round(1e9 (t - t0))                                                     (1)
//! else the message's own time in whole nanoseconds, max(0, round(1e9 t)): 0 for a negative time or NaN, `i64::MAX` at most. The
//! exact time is in the payload. The metadata of each channel say which (`clock`), and the unit of each number.

use super::log_clock::LogClock;
use super::whole_chunks::{CountingWriter, WholeChunks};
use crate::flight::channel::ControlNames;
use crate::flight::file::log_head::{ColumnTarget, RUN_METADATA};
use crate::flight::sample::Sample;
use crate::io::outputs::json::finding_json::FindingJson;
use crate::io::outputs::json::json_schema::{TOPICS, Topic, schema, units};
use crate::io::outputs::json::message_json::{DerivativesJson, EventJson, InnovationJson, SampleJson, SmoothedJson, StateJson};
use crate::io::outputs::json::modes_json::ModesJson;
use crate::io::outputs::json::output_error_json::OutputErrorJson;
use crate::io::outputs::queue::{LostMessages, QueueEntry};
use crate::io::outputs::record::{EventRecord, Message};
use mcap::records::MessageHeader;
use mcap::write::{Metadata, NoSeek};
use mcap::{Compression, McapError, WriteOptions, Writer};
use std::fs::{File, OpenOptions, TryLockError};
use std::io::{self, BufWriter};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

pub use crate::flight::file::log_head::LogHead;

/// Pause before another attempt to open a file; doubles up to [`LONGEST_RETRY`].
const FIRST_RETRY: Duration = Duration::from_secs(1);
const LONGEST_RETRY: Duration = Duration::from_secs(60);

/// Faults that the summary keeps as text; more are only counted in the messages lost.
const FAULTS_KEPT: usize = 16;

/// Why a log cannot be opened.
#[derive(Debug, thiserror::Error)]
#[expect(missing_docs, reason = "the message of each says what its fields are")]
pub enum LogError {
    #[error("{}: {source}", path.display())]
    File { path: PathBuf, source: io::Error },
    #[error("two columns are called `{name}`")]
    AmbiguousColumn { name: String },
}

/// How a log ended.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct LogSummary {
    /// Every file, in order; more than one where writing failed in between.
    pub files: Vec<PathBuf>,
    /// Messages written.
    pub written: u64,
    /// Messages that did not reach a file: those that the queue lost, and those around a write error.
    pub lost: u64,
    /// What went wrong, as sentences.
    pub faults: Vec<String>,
}

/// Told of every fault as it happens.
pub type LogFaultReport = Box<dyn FnMut(&str) + Send>;

type FileWriter = Writer<NoSeek<CountingWriter<BufWriter<CountingWriter<File>>>>>;

struct OpenFile {
    writer: FileWriter,
    path: PathBuf,
    channels: [u16; TOPICS],
    sequence: [u32; TOPICS],
    whole: WholeChunks,
}

/// An open log.
pub struct McapLog {
    path: PathBuf,
    head: LogHead,
    targets: Vec<ColumnTarget>,
    file: Option<OpenFile>,
    rotations: u32,
    /// Whether it goes on in a further file after a fault.
    goes_on: bool,
    retry: Duration,
    retry_at: Instant,
    payload: Vec<u8>,
    unsaid: u64,
    newest_s: f64,
    clock: LogClock,
    summary: LogSummary,
    report: LogFaultReport,
}

impl McapLog {
    /// Opens the log, replacing a file of that name, and writes its head.
    ///
    /// # Errors
    /// [`LogError`] where the file cannot be made, or two columns of the head share a name.
    pub fn create(path: &Path, head: LogHead, report: LogFaultReport) -> Result<Self, LogError> {
        if let Some(name) = head.ambiguous_name() {
            return Err(LogError::AmbiguousColumn { name: name.to_owned() });
        }
        let clock = LogClock::of(&head);
        let file = OpenFile::create(path, &head, OpenOptions::new().create(true).truncate(false))
            .map_err(|source| LogError::File { path: path.to_owned(), source })?;
        Ok(McapLog {
            path: path.to_owned(),
            targets: head.targets(),
            head,
            summary: LogSummary { files: vec![file.path.clone()], ..LogSummary::default() },
            file: Some(file),
            rotations: 0,
            goes_on: true,
            retry: FIRST_RETRY,
            retry_at: Instant::now(),
            payload: Vec::new(),
            unsaid: 0,
            newest_s: 0.0,
            clock,
            report,
        })
    }

    /// The same log, but without further files after a fault: what comes then is lost.
    pub fn one_file(mut self) -> Self {
        self.goes_on = false;
        self
    }

    /// How the controls are called.
    pub fn controls(&self) -> ControlNames {
        self.head.controls
    }

    /// Logs a sample with the values of its unknown columns, in their order, NaN where not sampled.
    pub fn sample(&mut self, sample: &Sample, unknown: &[f64]) {
        let mut payload = std::mem::take(&mut self.payload);
        payload.clear();
        let json = SampleJson { sample, unknown, head: &self.head, targets: &self.targets };
        let encoded = serde_json::to_writer(&mut payload, &json);
        self.finish_payload(Topic::Sample, sample.time_s, payload, encoded);
    }

    /// Logs a message.
    pub fn message(&mut self, message: &Message) {
        let controls = self.head.controls;
        match message {
            Message::Sample(sample) => self.sample(sample, &[]),
            Message::State(record) => self.object(Topic::State, record.time_s, &StateJson(record)),
            Message::Smoothed(record) => self.object(Topic::Smoothed, record.state.time_s, &SmoothedJson(record)),
            Message::Innovation(record) => {
                self.object(Topic::Innovation, record.time_s, &InnovationJson::new(record, controls));
            }
            Message::Derivatives(record) => {
                self.object(Topic::Derivatives, record.time_s, &DerivativesJson::new(record, controls));
            }
            Message::Modes(record) => self.object(Topic::Modes, record.time_s, &ModesJson::new(record, controls)),
            Message::OutputError(record) => {
                self.object(Topic::OutputError, record.time_s, &OutputErrorJson::new(record, controls));
            }
            Message::Finding(record) => self.object(Topic::Finding, record.time_s, &FindingJson::new(record, controls)),
            Message::Event(record) => self.event(record),
        }
    }

    /// Logs what came out of the queue.
    pub fn entry(&mut self, entry: &QueueEntry) {
        let controls = self.head.controls;
        match entry {
            QueueEntry::Sample(sample, unknown) => self.sample(sample, unknown),
            QueueEntry::State(record) => self.object(Topic::State, record.time_s, &StateJson(record)),
            QueueEntry::Smoothed(record) => self.object(Topic::Smoothed, record.state.time_s, &SmoothedJson(record)),
            QueueEntry::Innovation(record) => {
                self.object(Topic::Innovation, record.time_s, &InnovationJson::new(record, controls));
            }
            QueueEntry::Derivatives(record) => {
                self.object(Topic::Derivatives, record.time_s, &DerivativesJson::new(record, controls));
            }
            QueueEntry::Modes(record) => self.object(Topic::Modes, record.time_s, &ModesJson::new(record, controls)),
            QueueEntry::OutputError(record) => {
                self.object(Topic::OutputError, record.time_s, &OutputErrorJson::new(record, controls));
            }
            QueueEntry::Finding(record) => self.object(Topic::Finding, record.time_s, &FindingJson::new(record, controls)),
            QueueEntry::Event(record) => self.event(record),
            QueueEntry::Lost(lost) => self.lost(lost),
        }
    }

    /// Logs that messages found no room in the queue.
    pub fn lost(&mut self, lost: &LostMessages) {
        self.summary.lost += lost.count;
        self.object(Topic::Event, lost.time_s, &EventJson::lost(lost));
    }

    /// Brings everything logged so far into the file, past what dies with the process.
    pub fn flush(&mut self) {
        let Some(file) = &mut self.file else { return };
        match file.writer.flush() {
            Ok(()) => file.whole.flushed(),
            Err(error) => {
                self.file_failed(&error);
            }
        }
    }

    /// Ends the log with its index.
    pub fn close(mut self) -> LogSummary {
        if let Some(mut file) = self.file.take() {
            let ended = file.writer.finish().map(|_| ()).map_err(into_io);
            let ended = ended.and_then(|()| {
                let buffered = file.writer.into_inner().into_inner().inner;
                let counted = buffered.into_inner().map_err(|error| error.into_error())?;
                match counted.inner.sync_all() {
                    // A pipe or a device cannot be synchronised; everything has been handed over to it.
                    Err(error) if error.kind() == io::ErrorKind::InvalidInput => Ok(()),
                    other => other,
                }
            });
            if let Err(error) = ended {
                self.unsaid += file.whole.lost();
                let line = format!("{}: could not be closed: {error}", file.path.display());
                self.fault(line);
            }
        }
        self.summary.written -= self.unsaid.min(self.summary.written);
        self.summary.lost += self.unsaid;
        std::mem::take(&mut self.summary)
    }

    fn event(&mut self, event: &EventRecord) {
        let json = EventJson::new(event, self.head.controls);
        self.object(Topic::Event, event.time_s, &json);
    }

    fn object(&mut self, topic: Topic, time_s: f64, object: &impl serde::Serialize) {
        let mut payload = std::mem::take(&mut self.payload);
        payload.clear();
        let encoded = serde_json::to_writer(&mut payload, object);
        self.finish_payload(topic, time_s, payload, encoded);
    }

    fn finish_payload(&mut self, topic: Topic, time_s: f64, payload: Vec<u8>, encoded: serde_json::Result<()>) {
        match encoded {
            Ok(()) => self.write(topic, time_s, &payload),
            Err(error) => {
                self.summary.lost += 1;
                self.fault(format!("a message for {} cannot be encoded: {error}", topic.name()));
            }
        }
        self.payload = payload;
    }

    /// Writes a payload; after a failure once more into the next file.
    fn write(&mut self, topic: Topic, time_s: f64, payload: &[u8]) {
        if time_s.is_finite() {
            self.newest_s = time_s;
        }
        self.summary.written += 1;
        let time_ns = self.clock.log_time(time_s);
        for _ in 0..2 {
            self.reopen_when_due();
            let Some(file) = &mut self.file else { break };
            match file.write(topic, time_ns, payload) {
                Ok(()) => return,
                Err(error) => self.file_failed(&error),
            }
        }
        self.unsaid += 1;
    }

    fn file_failed(&mut self, error: &McapError) {
        let Some(file) = self.file.take() else { return };
        self.unsaid += file.whole.lost();
        if self.summary.files.len() > 1 && !file.whole.holds_any() {
            // Begun after a fault and no more than begun.
            let _ = std::fs::remove_file(&file.path);
            self.summary.files.pop();
        }
        let goes_on = if self.goes_on { "; the log goes on in a new file" } else { "" };
        let line = match error {
            McapError::Io(error) => format!("{}: writing failed ({error}){goes_on}", file.path.display()),
            other => format!("{}: writing failed ({other}){goes_on}", file.path.display()),
        };
        self.retry = FIRST_RETRY;
        self.retry_at = Instant::now();
        self.fault(line);
    }

    fn reopen_when_due(&mut self) {
        if self.file.is_some() || !self.goes_on || Instant::now() < self.retry_at {
            return;
        }
        let mut next = self.rotations + 1;
        let opened = loop {
            let path = numbered(&self.path, next);
            match OpenFile::create(&path, &self.head, OpenOptions::new().create_new(true)) {
                Err(error) if error.kind() == io::ErrorKind::AlreadyExists && next < u32::MAX => next += 1,
                other => break other.map_err(|error| (path, error)),
            }
        };
        match opened {
            Ok(file) => {
                self.rotations = next;
                self.summary.files.push(file.path.clone());
                self.file = Some(file);
                self.retry = FIRST_RETRY;
                self.say_what_was_dropped();
            }
            Err((path, error)) => {
                self.retry_at = Instant::now() + self.retry;
                self.retry = (self.retry * 2).min(LONGEST_RETRY);
                self.fault(format!("{}: {error}; the log drops messages until it can be opened", path.display()));
            }
        }
    }

    /// The new file opens with how many messages the failure cost.
    fn say_what_was_dropped(&mut self) {
        let dropped = std::mem::take(&mut self.unsaid);
        self.summary.lost += dropped;
        self.summary.written -= dropped.min(self.summary.written);
        let text = format!("writing the log failed; {dropped} messages were lost before this file");
        let event = EventJson::loss(self.newest_s, "log_write_failed", dropped, text);
        let (Ok(payload), Some(file)) = (serde_json::to_vec(&event), &mut self.file) else { return };
        match file.write(Topic::Event, self.clock.log_time(self.newest_s), &payload) {
            Ok(()) => self.summary.written += 1,
            Err(error) => self.file_failed(&error),
        }
    }

    fn fault(&mut self, line: String) {
        (self.report)(&line);
        if self.summary.faults.len() < FAULTS_KEPT {
            self.summary.faults.push(line);
        }
    }
}

impl OpenFile {
    fn create(path: &Path, head: &LogHead, options: &mut OpenOptions) -> io::Result<Self> {
        let was_there = path.symlink_metadata().is_ok();
        let file = options.write(true).open(path)?;
        OpenFile::begin(path, file, head).inspect_err(|_| {
            // It holds no message.
            if !was_there {
                let _ = std::fs::remove_file(path);
            }
        })
    }

    fn begin(path: &Path, file: File, head: &LogHead) -> io::Result<Self> {
        // Two writers in one file would leave neither log.
        match file.try_lock() {
            Err(TryLockError::WouldBlock) => {
                return Err(io::Error::new(io::ErrorKind::ResourceBusy, "another process is writing this log"));
            }
            // A file system without locks; the log is still wanted.
            Ok(()) | Err(TryLockError::Error(_)) => {}
        }
        if file.metadata()?.is_file() {
            file.set_len(0)?;
        }
        let whole = WholeChunks::default();
        let counted = CountingWriter::new(file, &whole.taken);
        let mut writer = WriteOptions::new()
            .compression(Some(Compression::Lz4))
            .disable_seeking(true)
            .repeat_schemas(true)
            .repeat_channels(true)
            .library(program())
            .create(NoSeek::new(CountingWriter::new(BufWriter::new(counted), &whole.given)))
            .map_err(into_io)?;
        writer
            .write_metadata(&Metadata { name: RUN_METADATA.to_owned(), metadata: head.to_metadata(&program()) })
            .map_err(into_io)?;
        let mut channels = [0; TOPICS];
        for (topic, channel) in Topic::ALL.into_iter().zip(&mut channels) {
            let id = writer.add_schema(topic.schema_name(), "jsonschema", schema(topic, head).as_bytes()).map_err(into_io)?;
            let mut about = units(topic, head);
            about.insert("clock".to_owned(), LogClock::of(head).name().to_owned());
            *channel = writer.add_channel(id, topic.name(), "json", &about).map_err(into_io)?;
        }
        writer.flush().map_err(into_io)?;
        Ok(OpenFile { writer, path: path.to_owned(), channels, sequence: [0; TOPICS], whole })
    }

    fn write(&mut self, topic: Topic, time: u64, payload: &[u8]) -> Result<(), McapError> {
        let place = topic.index();
        let (Some(&channel_id), Some(sequence)) = (self.channels.get(place), self.sequence.get_mut(place)) else {
            return Ok(());
        };
        let header = MessageHeader { channel_id, sequence: *sequence, log_time: time, publish_time: time };
        *sequence = sequence.wrapping_add(1);
        let writer = &mut self.writer;
        self.whole.message(|| writer.write_to_known_channel(&header, payload))
    }
}

/// The program and its version, as written in a log.
pub fn program() -> String {
    concat!("sideslip ", env!("CARGO_PKG_VERSION")).to_owned()
}

/// `dir/name.mcap` as `dir/name.K.mcap`.
fn numbered(path: &Path, number: u32) -> PathBuf {
    let stem = path.file_stem().unwrap_or_default().to_string_lossy();
    let name = match path.extension() {
        Some(extension) => format!("{stem}.{number}.{}", extension.to_string_lossy()),
        None => format!("{stem}.{number}"),
    };
    path.with_file_name(name)
}

fn into_io(error: McapError) -> io::Error {
    match error {
        McapError::Io(error) => error,
        other => io::Error::other(other.to_string()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn further_files_are_numbered_before_the_extension() {
        assert_eq!(numbered(Path::new("a/run.mcap"), 1), Path::new("a/run.1.mcap"));
        assert_eq!(numbered(Path::new("run"), 2), Path::new("run.2"));
    }
}
