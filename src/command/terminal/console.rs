//! What the program says, on its way to standard error and standard output: a bounded queue and a thread for each.
//!
//! Nobody who says something waits for a terminal: one that was stopped (ctrl-S), or a pipe that nobody reads, holds up neither
//! estimates, nor their supervision, nor ctrl-C. What finds no room is counted, and the count is said once, at the end. Only
//! [`print`] waits, for its text is the result: until it was taken, or until the process was asked to end and nothing moves.
//!
//! Lines and texts keep their order across both streams while both are read.

use super::stop::is_asked_to_stop;
use crossbeam::channel::{Receiver, RecvTimeoutError, SendTimeoutError, Sender, bounded};
use sideslip::error::Failure;
use sideslip::io::outputs::tables::terminal::Style;
use sideslip::io::outputs::words::printable::printable_json;
use std::collections::BTreeSet;
use std::fmt::Arguments;
use std::io::{Error, ErrorKind, Result as IoResult, Write};
use std::path::Path;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Mutex, OnceLock};
use std::thread::{Builder, sleep};
use std::time::{Duration, Instant};

/// Lines that may wait; more are dropped.
const WAITING: usize = 256;
/// A stream that has taken nothing for so long has stopped.
const STOPPED: Duration = Duration::from_secs(1);
/// The longest wait at the end of the process for a terminal that takes lines slowly.
const LAST_WORDS: Duration = Duration::from_secs(5);
/// The longest wait of one stream for what was said before on the other.
const ORDER: Duration = Duration::from_millis(100);
/// Polling interval of such waits.
const POLL: Duration = Duration::from_millis(1);
/// Pause before another attempt where a stream does not block and has no room.
const NO_ROOM: Duration = Duration::from_millis(5);

/// What a thread writes to.
type Stream = fn() -> Box<dyn Write>;

/// A text in a queue.
struct ConsoleText {
    text: String,
    /// Bytes that the other stream had been given before.
    after: u64,
    /// Where it is said that the text was taken, if anybody waits for that.
    taken: Option<Sender<IoResult<()>>>,
}

/// The way to one stream.
struct StreamQueue {
    texts: Sender<ConsoleText>,
    /// Bytes that were given to the thread, and that the stream has taken or refused.
    given: AtomicU64,
    taken: AtomicU64,
    dropped: AtomicU64,
}

/// Both.
struct Console {
    error: StreamQueue,
    output: StreamQueue,
}

static CONSOLE: OnceLock<Option<Console>> = OnceLock::new();

/// The console with its threads, started with the first word; `None` where there are no threads: then who speaks waits.
fn console() -> Option<&'static Console> {
    let start = || {
        let (error, errors) = StreamQueue::new();
        let (output, outputs) = StreamQueue::new();
        let speak = |name: &str, texts: Receiver<ConsoleText>, which: fn(&Console) -> [&StreamQueue; 2], stream: Stream| {
            let work = move || {
                let Some(console) = CONSOLE.wait() else { return };
                let [own, other] = which(console);
                own.write_all_of(&texts, other, &mut *stream());
            };
            Builder::new().name(name.to_owned()).spawn(work).ok()
        };
        speak("sideslip-error", errors, |console| [&console.error, &console.output], || Box::new(std::io::stderr()))?;
        speak("sideslip-output", outputs, |console| [&console.output, &console.error], || Box::new(std::io::stdout()))?;
        Some(Console { error, output })
    };
    CONSOLE.get_or_init(start).as_ref()
}

impl StreamQueue {
    fn new() -> (Self, Receiver<ConsoleText>) {
        let (texts, heard) = bounded(WAITING);
        let [given, taken, dropped] = [const { AtomicU64::new(0) }; 3];
        (StreamQueue { texts, given, taken, dropped }, heard)
    }

    /// Puts a text into the queue; where there is no room it is dropped and counted.
    fn offer(&self, text: String, other: &StreamQueue) {
        let (bytes, after) = (text.len() as u64, other.given.load(Ordering::Acquire));
        self.given.fetch_add(bytes, Ordering::AcqRel);
        if self.texts.try_send(ConsoleText { text, after, taken: None }).is_err() {
            self.given.fetch_sub(bytes, Ordering::AcqRel);
            self.dropped.fetch_add(1, Ordering::AcqRel);
        }
    }

    fn waiting(&self) -> u64 {
        self.given.load(Ordering::Acquire).saturating_sub(self.taken.load(Ordering::Acquire))
    }

    /// The thread: writes what comes, as long as the process lives.
    fn write_all_of(&self, texts: &Receiver<ConsoleText>, other: &StreamQueue, stream: &mut dyn Write) {
        // How much the other stream had taken when it was waited for in vain.
        let mut stopped_at = None;
        for ConsoleText { text, after, taken } in texts {
            let begun = Instant::now();
            let behind = || Some(other.taken.load(Ordering::Acquire)).filter(|taken| *taken < after);
            while let Some(behind) = behind().filter(|behind| stopped_at != Some(*behind)) {
                if begun.elapsed() >= ORDER {
                    stopped_at = Some(behind);
                }
                sleep(POLL);
            }
            let written = self.write(text.as_bytes(), stream);
            if let Some(taken) = taken {
                let _ = taken.try_send(written);
            }
        }
    }

    /// Writes a text piece by piece, each counted; where the stream fails, what is left counts as refused.
    fn write(&self, bytes: &[u8], stream: &mut dyn Write) -> IoResult<()> {
        let mut rest = bytes;
        let written = loop {
            match stream.write(rest) {
                _ if rest.is_empty() => break flushed(stream),
                Ok(0) => break Err(Error::from(ErrorKind::WriteZero)),
                Ok(count) => {
                    rest = rest.get(count..).unwrap_or_default();
                    self.taken.fetch_add(count as u64, Ordering::AcqRel);
                }
                Err(error) if error.kind() == ErrorKind::Interrupted => {}
                Err(error) if error.kind() == ErrorKind::WouldBlock => sleep(NO_ROOM),
                Err(error) => break Err(error),
            }
        };
        self.taken.fetch_add(rest.len() as u64, Ordering::AcqRel);
        written
    }

    /// Waits until everything was taken: while something moves, and not beyond `end`. Whether it was.
    fn is_taken_by(&self, end: Instant) -> bool {
        let mut moved = (self.taken.load(Ordering::Acquire), Instant::now());
        while self.waiting() > 0 {
            let (now, taken) = (Instant::now(), self.taken.load(Ordering::Acquire));
            if taken != moved.0 {
                moved = (taken, now);
            }
            if now >= end || now.duration_since(moved.1) >= STOPPED {
                return false;
            }
            sleep(POLL);
        }
        true
    }

    /// The last words: everything that waits, and how many lines found no room.
    fn finish(&self, end: Instant, other: &StreamQueue) {
        let (all_taken, dropped) = (self.is_taken_by(end), self.dropped.swap(0, Ordering::AcqRel));
        if all_taken && dropped > 0 {
            self.offer(format!("sideslip: {dropped} messages were dropped while the terminal took none\n"), other);
            self.is_taken_by(end);
        }
    }
}

fn flushed(stream: &mut dyn Write) -> IoResult<()> {
    loop {
        match stream.flush() {
            Err(error) if error.kind() == ErrorKind::Interrupted => {}
            Err(error) if error.kind() == ErrorKind::WouldBlock => sleep(NO_ROOM),
            other => return other,
        }
    }
}

/// A line for the person at the terminal, on standard error; it never waits, and a closed terminal is no reason to stop. Names of
/// files and runs in it cannot steer the terminal, and make no second line.
pub(crate) fn message(line: Arguments<'_>) {
    message_text(&line.to_string().replace('\n', "\\n").replace('\t', "\\t"));
}

/// A text of several lines, said as [`message`] says one.
pub(crate) fn message_text(text: &str) {
    let text = format!("{}\n", Style::of_stream(&std::io::stderr()).shown(text));
    match console() {
        Some(Console { error, output }) => error.offer(text, output),
        None => drop(std::io::stderr().write_all(text.as_bytes())),
    }
}

/// The same, said once: a recording that is read several times, a manoeuvre at a time, has one note.
pub(crate) fn message_once(line: Arguments<'_>) {
    static SAID: Mutex<BTreeSet<String>> = Mutex::new(BTreeSet::new());
    let line = line.to_string();
    if SAID.lock().is_ok_and(|mut said| said.insert(line.clone())) {
        message(format_args!("{line}"));
    }
}

/// A line of progress on standard error, where nothing waits: the next one replaces it.
pub(crate) fn progress(text: String) {
    match console() {
        Some(Console { error, output }) if error.waiting() == 0 => error.offer(text, output),
        Some(_) => {}
        None => drop(std::io::stderr().write_all(text.as_bytes())),
    }
}

/// A text for standard output that never waits: of a process that has more to do than to be read.
pub(crate) fn answer(text: &str) {
    let text = Style::of_stream(&std::io::stdout()).shown(text).into_owned();
    match console() {
        Some(Console { error, output }) => output.offer(text, error),
        None => drop(std::io::stdout().write_all(text.as_bytes())),
    }
}

/// Text to standard output, where names of files and runs cannot steer the terminal; a reader that has seen enough is no failure.
pub(crate) fn print(text: &str) -> Result<(), Failure> {
    match written(&Style::of_stream(&std::io::stdout()).shown(text)) {
        Err(error) if error.kind() != ErrorKind::BrokenPipe => Err(Failure::io(Path::new("standard output"), &error)),
        _ => Ok(()),
    }
}

/// A picture or a line of a sequence that ends when the program is asked to; whether anybody still reads.
pub(crate) fn print_while_read(text: &str) -> Result<bool, Failure> {
    write_while_read(&Style::of_stream(&std::io::stdout()).shown(text))
}

/// A JSON document to standard output; whether anybody still reads.
pub(crate) fn print_json(text: &str) -> Result<bool, Failure> {
    write_while_read(&printable_json(text))
}

/// An empty terminal.
pub(crate) fn clear_terminal() -> Result<(), Failure> {
    write_while_read("\x1b[H\x1b[2J").map(drop)
}

fn write_while_read(text: &str) -> Result<bool, Failure> {
    match written(text) {
        Ok(()) => Ok(true),
        Err(error) if matches!(error.kind(), ErrorKind::BrokenPipe | ErrorKind::TimedOut) => Ok(false),
        Err(error) => Err(Failure::io(Path::new("standard output"), &error)),
    }
}

/// Waits until the text was taken; where the process was asked to end, only while the stream takes anything.
fn written(text: &str) -> IoResult<()> {
    let Some(Console { error, output }) = console() else {
        return std::io::stdout().write_all(text.as_bytes()).and_then(|()| std::io::stdout().flush());
    };
    let (done, taken) = bounded(1);
    let after = error.given.load(Ordering::Acquire);
    output.given.fetch_add(text.len() as u64, Ordering::AcqRel);
    let mut next = Some(ConsoleText { text: text.to_owned(), after, taken: Some(done) });
    let mut moved = (output.taken.load(Ordering::Acquire), Instant::now());
    let gone = || Error::other("the thread that writes to it has ended");
    loop {
        if let Some(text) = next.take() {
            match output.texts.send_timeout(text, NO_ROOM) {
                Ok(()) => {}
                Err(SendTimeoutError::Timeout(text)) => next = Some(text),
                Err(SendTimeoutError::Disconnected(_)) => return Err(gone()),
            }
        } else {
            match taken.recv_timeout(NO_ROOM) {
                Ok(written) => return written,
                Err(RecvTimeoutError::Timeout) => {}
                Err(RecvTimeoutError::Disconnected) => return Err(gone()),
            }
        }
        let taken = output.taken.load(Ordering::Acquire);
        if taken != moved.0 {
            moved = (taken, Instant::now());
        }
        if is_asked_to_stop() && moved.1.elapsed() >= STOPPED {
            let what = "expected a reader, found one that takes nothing; given up because the program was asked to end";
            return Err(Error::new(ErrorKind::TimedOut, what));
        }
    }
}

/// Before the process ends: waits for what was said, as long as it is taken, some seconds at most.
pub(crate) fn finish() {
    let Some(Some(Console { error, output })) = CONSOLE.get() else { return };
    let end = Instant::now() + LAST_WORDS;
    output.is_taken_by(end);
    error.dropped.fetch_add(output.dropped.swap(0, Ordering::AcqRel), Ordering::AcqRel);
    error.finish(end, output);
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::{Arc, Mutex};

    /// A stream that takes nothing until it is opened.
    #[derive(Clone, Default)]
    struct Gate {
        open: Arc<OnceLock<()>>,
        took: Arc<Mutex<Vec<u8>>>,
    }

    impl Write for Gate {
        fn write(&mut self, bytes: &[u8]) -> IoResult<usize> {
            self.open.wait();
            self.took.lock().unwrap().extend_from_slice(bytes);
            Ok(bytes.len())
        }

        fn flush(&mut self) -> IoResult<()> {
            Ok(())
        }
    }

    /// A queue whose thread writes into the gate, and one beside it to which nothing is said.
    fn gated(gate: &Gate) -> (Arc<StreamQueue>, Arc<StreamQueue>) {
        let (queue, texts) = StreamQueue::new();
        let (other, _) = StreamQueue::new();
        let (queue, other, mut gate) = (Arc::new(queue), Arc::new(other), gate.clone());
        let (own, beside) = (Arc::clone(&queue), Arc::clone(&other));
        std::thread::spawn(move || own.write_all_of(&texts, &beside, &mut gate));
        (queue, other)
    }

    #[test]
    fn who_speaks_to_a_stopped_terminal_does_not_wait_and_what_is_dropped_is_counted_and_said() {
        let gate = Gate::default();
        let (queue, other) = gated(&gate);
        let lines = WAITING as u64 + 100;
        (0..lines).for_each(|line| queue.offer(format!("{line}\n"), &other));
        let dropped = queue.dropped.load(Ordering::Acquire);
        // One may be in the hands of the thread.
        assert!((99..=100).contains(&dropped), "{dropped}");
        let begun = Instant::now();
        queue.finish(begun + LAST_WORDS, &other);
        assert!(begun.elapsed() >= STOPPED, "it was waited for");
        assert!(gate.took.lock().unwrap().is_empty());
        queue.dropped.store(dropped, Ordering::Release);
        gate.open.set(()).unwrap();
        queue.finish(Instant::now() + Duration::from_secs(60), &other);
        let took = String::from_utf8(gate.took.lock().unwrap().clone()).unwrap();
        assert_eq!(took.lines().count() as u64, lines - dropped + 1);
        assert!(took.starts_with("0\n1\n2\n"));
        assert!(took.ends_with(&format!("sideslip: {dropped} messages were dropped while the terminal took none\n")), "{took}");
    }

    #[test]
    fn what_was_said_before_on_the_other_stream_comes_first_but_is_not_waited_for_where_that_has_stopped() {
        let (first, second) = (Gate::default(), Gate::default());
        second.open.set(()).unwrap();
        let ((error, errors), (output, outputs)) = (StreamQueue::new(), StreamQueue::new());
        let (error, output) = (Arc::new(error), Arc::new(output));
        for (own, texts, beside, mut gate) in
            [(&error, errors, &output, first.clone()), (&output, outputs, &error, second.clone())]
        {
            let (own, beside) = (Arc::clone(own), Arc::clone(beside));
            std::thread::spawn(move || own.write_all_of(&texts, &beside, &mut gate));
        }
        error.offer("before".to_owned(), &output);
        output.offer("after".to_owned(), &error);
        assert!(output.is_taken_by(Instant::now() + Duration::from_secs(60)));
        assert_eq!((first.took.lock().unwrap().len(), second.took.lock().unwrap().len()), (0, 5));
    }
}
