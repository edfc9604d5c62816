//! What the estimator says and prints, on a thread of its own: a terminal that has stopped, or a pipe that nobody reads, must
//! not hold up estimates.

use super::super::message;
use super::super::output_file::print;
use crossbeam::channel::{Sender, bounded};
use sideslip::error::Failure;
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

/// Lines that may wait; more are not said.
const WAITING: usize = 64;

enum Line {
    /// For standard error.
    Said(String),
    /// For standard output.
    Answer(String),
}

/// The way to standard error and standard output.
pub(super) struct Voice {
    lines: Sender<Line>,
    thread: JoinHandle<()>,
}

impl Voice {
    /// Starts the thread.
    pub(super) fn start() -> Result<Self, Failure> {
        let (lines, heard) = bounded(WAITING);
        let speak = move || {
            for line in heard {
                match line {
                    Line::Said(text) => message(format_args!("{text}")),
                    // Nobody reads the answer any more: it stands in the log and in the JSON too.
                    Line::Answer(text) => drop(print(&text)),
                }
            }
        };
        let started = std::thread::Builder::new().name("sideslip-voice".to_owned()).spawn(speak);
        let thread = started.map_err(|error| Failure::Running(format!("no thread to be had: {error}")))?;
        Ok(Voice { lines, thread })
    }

    /// A line on standard error.
    pub(super) fn say(&self, text: String) {
        let _ = self.lines.try_send(Line::Said(text));
    }

    /// Text on standard output.
    pub(super) fn answer(&self, text: String) {
        let _ = self.lines.try_send(Line::Answer(text));
    }

    /// Waits until everything was said, so long.
    pub(super) fn finish(self, limit: Duration) {
        let Voice { lines, thread } = self;
        drop(lines);
        let begun = Instant::now();
        while !thread.is_finished() && begun.elapsed() < limit {
            std::thread::sleep(Duration::from_millis(2));
        }
    }
}
