//! One line on a terminal that says how far a run is; nothing where standard error goes elsewhere.

use super::console::progress;
use sideslip::io::outputs::words::printable::printable;
use std::io::IsTerminal;
use std::time::{Duration, Instant};

/// How often the line is written anew.
const EVERY: Duration = Duration::from_millis(100);

#[derive(Debug)]
pub(crate) struct ProgressLine {
    shown: bool,
    next: Option<Instant>,
}

impl ProgressLine {
    /// A line where standard error is a terminal.
    pub(crate) fn new() -> Self {
        ProgressLine { shown: false, next: std::io::stderr().is_terminal().then(|| Instant::now() + EVERY) }
    }

    /// Writes the line where it is due.
    pub(crate) fn show(&mut self, line: impl FnOnce() -> String) {
        let Some(next) = self.next else { return };
        let now = Instant::now();
        if now >= next {
            self.next = Some(now + EVERY);
            self.shown = true;
            progress(format!("\r\x1b[K{}", printable(&line())));
        }
    }
}

impl Drop for ProgressLine {
    fn drop(&mut self) {
        if self.shown {
            progress("\r\x1b[K".to_owned());
        }
    }
}
