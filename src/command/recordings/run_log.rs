//! The log of a run and the thread that writes it.

use crate::command::message;
use ::replay::Pace;
use sideslip::error::Failure;
use sideslip::flight::file::log_head::LogHead;
use sideslip::io::outputs::log::log_thread::LogThread;
use sideslip::io::outputs::log::mcap_log::{LogError, McapLog};
use sideslip::io::outputs::queue::{QueuePolicy, QueueSender, queue};
use std::path::{Path, PathBuf};

/// Messages that the queue holds: a second of a fast run, some 10 MB.
const QUEUE: usize = 2048;

/// A log that is being written, in its place from the first byte on: whatever ends the process, what was logged is there.
pub(crate) struct RunLog {
    path: PathBuf,
    thread: LogThread,
}

#[derive(Debug)]
pub(crate) struct ClosedRunLog {
    pub(crate) path: PathBuf,
    pub(crate) written: u64,
    lost: u64,
}

impl ClosedRunLog {
    pub(crate) fn loss(&self) -> Option<String> {
        let ClosedRunLog { path, written, lost } = self;
        (*lost > 0).then(|| format!("{lost} of {} messages are not in the log {}", lost + written, path.display()))
    }
}

impl RunLog {
    /// Opens the log and starts its thread. As fast as it goes nothing may be lost; at a pace nothing may wait.
    pub(crate) fn start(path: &Path, head: LogHead, pace: Pace) -> Result<(QueueSender, Self), Failure> {
        let unknown_columns = head.unknown_columns();
        let report = Box::new(|line: &str| message(format_args!("sideslip: {line}")));
        let log = McapLog::create(path, head, report).map_err(|error| match error {
            LogError::File { source, .. } => Failure::io(path, &source),
            ambiguous @ LogError::AmbiguousColumn { .. } => Failure::file(path, ambiguous),
        })?;
        let policy = if pace == Pace::Max { QueuePolicy::Lossless } else { QueuePolicy::RealTime };
        let (sender, receiver) = queue(policy, QUEUE, unknown_columns);
        let thread = LogThread::spawn(receiver, log).map_err(|error| Failure::io(path, &error))?;
        Ok((sender, RunLog { path: path.into(), thread }))
    }

    /// Waits until everything is written and closes the log.
    pub(crate) fn finish(self) -> Result<ClosedRunLog, Failure> {
        let summary = self.thread.join().map_err(|error| Failure::io(&self.path, &error))?;
        Ok(ClosedRunLog { path: self.path, written: summary.written, lost: summary.lost })
    }
}
