//! The log of a run: where it goes, as any file that each recording has, and the thread that writes it.

use super::super::message;
use super::super::output_file::refuse_to_overwrite;
use ::replay::Pace;
use sideslip::error::Failure;
use sideslip::flight::log_head::LogHead;
use sideslip::outputs::log_thread::LogThread;
use sideslip::outputs::mcap_log::{LogError, McapLog};
use sideslip::outputs::queue::{Policy, Sender, queue};
use std::collections::BTreeSet;
use std::ffi::OsStr;
use std::path::{Path, PathBuf};

/// Messages that the queue holds: a second of a fast run, some 10 MB.
const QUEUE: usize = 2048;

/// An option that gives a file for each recording.
pub(crate) struct PerRecording {
    /// As it is called.
    pub(crate) option: &'static str,
    /// Endings that its files can have; the first where only a directory was named.
    pub(crate) endings: &'static [&'static str],
}

/// The logs of `--out`.
pub(crate) const LOGS: PerRecording = PerRecording { option: "--out", endings: &["mcap"] };

impl PerRecording {
    /// The file of each recording, in their order; nothing is made yet.
    pub(crate) fn places(&self, out: Option<&Path>, files: &[PathBuf]) -> Result<Vec<Option<PathBuf>>, Failure> {
        let Some(out) = out else { return Ok(vec![None; files.len()]) };
        let PerRecording { option, endings } = self;
        let usual = endings.first().copied().unwrap_or_default();
        let places: Vec<PathBuf> = if files.len() == 1 && !names_directory(out) {
            vec![out.to_path_buf()]
        } else if out.exists() && !out.is_dir() {
            let what = format_args!("{option}: expected a directory for the files of {} recordings, found a file", files.len());
            return Err(Failure::file(out, what));
        } else {
            files.iter().map(|file| out.join(file.with_extension(usual).file_name().unwrap_or_default())).collect()
        };
        let mut seen = BTreeSet::new();
        for place in &places {
            // Without an ending it is clear only where there is one format.
            let unclear =
                |ending: Option<&OsStr>| ending.map_or(endings.len() > 1, |ending| endings.iter().all(|known| ending != *known));
            if unclear(place.extension()) || place.as_os_str() == "-" {
                let what = format_args!("{option}: expected a name that ends in .{}", endings.join(" or ."));
                return Err(Failure::file(place, what));
            }
            if !seen.insert(place) {
                let what = format_args!("{option}: two recordings of that name would have the same file");
                return Err(Failure::file(place, what));
            }
            refuse_to_overwrite(option, place, files)?;
        }
        Ok(places.into_iter().map(Some).collect())
    }
}

/// Whether the path stands for a directory: it is one, or ends as one.
fn names_directory(path: &Path) -> bool {
    path.is_dir() || path.as_os_str().to_string_lossy().ends_with('/')
}

/// Makes the directory of such files where it is missing.
pub(crate) fn make_directory(out: Option<&Path>, logs: &[Option<PathBuf>]) -> Result<(), Failure> {
    match out {
        Some(out) if logs.len() > 1 || names_directory(out) => {
            std::fs::create_dir_all(out).map_err(|error| Failure::io(out, &error))
        }
        _ => Ok(()),
    }
}

/// A log that is being written, in its place from the first byte on: whatever ends the process, what was logged is there.
pub(crate) struct Log {
    path: PathBuf,
    thread: LogThread,
}

/// How a log ended.
#[derive(Debug)]
pub(crate) struct Logged {
    /// Where it stands.
    pub(crate) path: PathBuf,
    /// Messages in it.
    pub(crate) written: u64,
    /// Messages that it lacks.
    lost: u64,
}

impl Logged {
    /// What it lacks, in words.
    pub(crate) fn loss(&self) -> Option<String> {
        let Logged { path, written, lost } = self;
        (*lost > 0).then(|| format!("{lost} of {} messages are not in the log {}", lost + written, path.display()))
    }
}

impl Log {
    /// Opens the log and starts its thread. As fast as it goes nothing may be lost; at a pace nothing may wait.
    pub(crate) fn start(path: &Path, head: LogHead, pace: Pace) -> Result<(Sender, Self), Failure> {
        let unknown_columns = head.unknown_columns();
        let report = Box::new(|line: &str| message(format_args!("sideslip: {line}")));
        let was_there = path.symlink_metadata().is_ok();
        let log = McapLog::create(path, head, report).map_err(|error| {
            // Nothing could be written: an empty file is no log.
            if !was_there && path.metadata().is_ok_and(|left| left.len() == 0) {
                let _ = std::fs::remove_file(path);
            }
            match error {
                LogError::File { source, .. } => Failure::io(path, &source),
                ambiguous @ LogError::AmbiguousColumn { .. } => Failure::file(path, ambiguous),
            }
        })?;
        let policy = if pace == Pace::Max { Policy::Lossless } else { Policy::RealTime };
        let (sender, receiver) = queue(policy, QUEUE, unknown_columns);
        let thread = LogThread::spawn(receiver, log).map_err(|error| Failure::io(path, &error))?;
        Ok((sender, Log { path: path.into(), thread }))
    }

    /// Waits until everything is written and closes the log.
    pub(crate) fn finish(self) -> Result<Logged, Failure> {
        let summary = self.thread.join().map_err(|error| Failure::io(&self.path, &error))?;
        Ok(Logged { path: self.path, written: summary.written, lost: summary.lost })
    }
}
