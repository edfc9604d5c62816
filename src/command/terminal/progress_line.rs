//! One line on a terminal that says how far a run is; nothing where standard error goes elsewhere.

use super::console::progress;
use super::stop::stop_flag;
use sideslip::error::Failure;
use sideslip::io::outputs::words::printable::printable;
use sideslip::postflight::work_progress::WorkProgress;
use std::io::IsTerminal;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::Thread;
use std::time::{Duration, Instant};

/// How often the line is written anew.
const EVERY: Duration = Duration::from_millis(100);
/// Before this nothing is known of how long work takes.
const KNOWN_AFTER: Duration = Duration::from_secs(1);

#[derive(Debug)]
pub(crate) struct ProgressLine {
    shown: bool,
    begun: Instant,
    next: Option<Instant>,
}

impl ProgressLine {
    /// A line where standard error is a terminal.
    pub(crate) fn new() -> Self {
        let begun = Instant::now();
        ProgressLine { shown: false, begun, next: std::io::stderr().is_terminal().then(|| begun + EVERY) }
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

    /// The same, with the time that is left where so much of all is done.
    pub(crate) fn show_part(&mut self, done: u64, all: u64, line: impl FnOnce() -> String) {
        let begun = self.begun;
        self.show(|| format!("{}{}", line(), time_left(begun.elapsed(), done, all)));
    }
}

impl Drop for ProgressLine {
    fn drop(&mut self) {
        if self.shown {
            progress("\r\x1b[K".to_owned());
        }
    }
}

/// `, about 12 s left` by how long it took so far; nothing as long as that says nothing.
fn time_left(elapsed: Duration, done: u64, all: u64) -> String {
    if elapsed < KNOWN_AFTER || done == 0 || done >= all {
        return String::new();
    }
    let left_s = elapsed.as_secs_f64() * (all - done) as f64 / done as f64;
    match left_s {
        ..90.0 => format!(", about {left_s:.0} s left"),
        ..5400.0 => format!(", about {:.0} min left", left_s / 60.0),
        _ => format!(", about {:.0} h left", left_s / 3600.0),
    }
}

/// Runs an analysis that tells its progress, which a line on the terminal shows; a signal asks it to end with what it has.
/// Whether one did is the second result.
pub(crate) fn watched<T>(what: &str, analysis: impl FnOnce(&'static WorkProgress) -> T) -> Result<(T, bool), Failure> {
    // A command has one analysis at a time, each with its own count.
    let work: &'static WorkProgress = Box::leak(Box::default());
    let (stop, ended) = (stop_flag()?, AtomicBool::new(false));
    if stop.load(Ordering::Relaxed) {
        work.stop();
    }
    let result = std::thread::scope(|scope| {
        let shown = scope.spawn(|| {
            let mut line = ProgressLine::new();
            while !ended.load(Ordering::Acquire) {
                if stop.load(Ordering::Relaxed) {
                    work.stop();
                }
                let (done, all) = work.counts();
                line.show_part(done, all, || {
                    let percent = (100 * done.min(all)).checked_div(all);
                    let part = percent.map_or_else(String::new, |percent| format!(": {percent} %"));
                    let ending = if work.is_stopped() { ", asked to stop, ending" } else { "" };
                    format!("{what}{part}{ending}")
                });
                std::thread::park_timeout(EVERY);
            }
        });
        let _end = End { ended: &ended, shown: shown.thread() };
        analysis(work)
    });
    Ok((result, stop.load(Ordering::Relaxed)))
}

/// Ends the line with the analysis, however that ends.
struct End<'s> {
    ended: &'s AtomicBool,
    shown: &'s Thread,
}

impl Drop for End<'_> {
    fn drop(&mut self) {
        self.ended.store(true, Ordering::Release);
        self.shown.unpark();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_time_left_is_that_of_the_pace_so_far() {
        let left = |elapsed_s: f64, done: u64, all: u64| time_left(Duration::from_secs_f64(elapsed_s), done, all);
        assert_eq!(left(10.0, 50, 150), ", about 20 s left");
        assert_eq!(left(60.0, 1, 11), ", about 10 min left");
        assert_eq!(left(60.0, 1, 200), ", about 3 h left");
        for (elapsed_s, done, all) in [(0.5, 5, 10), (10.0, 0, 10), (10.0, 10, 10), (10.0, 0, 0), (10.0, 12, 10)] {
            assert_eq!(left(elapsed_s, done, all), "", "{elapsed_s} {done} {all}");
        }
    }
}
