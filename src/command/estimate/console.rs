//! Messages and tables of the estimator, on a thread of its own: a terminal that has stopped, or a pipe that nobody reads, must
//! not hold up estimates.

use crate::command::message;
use crate::command::terminal::output_file::print;
use crossbeam::channel::{Sender, bounded};
use sideslip::error::Failure;
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

/// Lines that may wait; more are not said.
const WAITING: usize = 64;

enum ConsoleLine {
    /// For standard error.
    Said(String),
    /// For standard output.
    Answer(String),
}

/// The way to standard error and standard output.
pub(super) struct ConsoleThread {
    lines: Sender<ConsoleLine>,
    thread: JoinHandle<()>,
}

impl ConsoleThread {
    pub(super) fn start() -> Result<Self, Failure> {
        let (lines, heard) = bounded(WAITING);
        let speak = move || {
            for line in heard {
                match line {
                    ConsoleLine::Said(text) => message(format_args!("{text}")),
                    // Nobody reads the answer any more: it stands in the log and in the JSON too.
                    ConsoleLine::Answer(text) => drop(print(&text)),
                }
            }
        };
        let started = std::thread::Builder::new().name("sideslip-term".to_owned()).spawn(speak);
        let thread = started.map_err(|error| Failure::Running(format!("no thread could be started: {error}")))?;
        Ok(ConsoleThread { lines, thread })
    }

    /// A line on standard error.
    pub(super) fn message(&self, text: String) {
        let _ = self.lines.try_send(ConsoleLine::Said(text));
    }

    /// Text on standard output.
    pub(super) fn answer(&self, text: String) {
        let _ = self.lines.try_send(ConsoleLine::Answer(text));
    }

    /// Waits until everything was said, so long.
    pub(super) fn finish(self, limit: Duration) {
        let ConsoleThread { lines, thread } = self;
        drop(lines);
        let begun = Instant::now();
        while !thread.is_finished() && begun.elapsed() < limit {
            std::thread::sleep(Duration::from_millis(2));
        }
    }
}
