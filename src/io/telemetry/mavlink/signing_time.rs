//! Timestamps of signatures: steps of 10 us since 2015-01-01, each later than all before it, across restarts too.
//!
//! Consumes the system's clock, the timestamps of frames received, and the file that keeps what may have been used; produces
//! timestamps, never the same twice. The next one is the clock's, or one step after the newest where the clock is behind; a later
//! timestamp received moves the newest forward (mavlink.io, "Message Signing", timestamp handling). One that is more than
//! [`LEAD_MAX`] later than the clock is reported, with its lead: from then on this key's timestamps lead the clock for good.
//!
//! The file holds one number: every timestamp given out so far is below it. It is written ahead, [`AHEAD`] at a time and by a
//! thread of its own once the first has been written, so that neither a killed process nor a loss of power makes one come
//! twice, and giving one out does not wait for a disk. The first after a start that the clock does not exceed is the number in
//! the file. Refused: a file that is in use by another process or holds something else; a timestamp that is not on record yet
//! (none is given out, so that the frame is not sent).

use crossbeam::channel::{Sender, bounded};
use std::fs::{File, OpenOptions, TryLockError};
use std::io::{Error, ErrorKind};
use std::os::unix::fs::{FileExt, OpenOptionsExt};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::JoinHandle;
use std::time::SystemTime;

/// 2015-01-01 as seconds since 1970.
const EPOCH_S: u64 = 1_420_070_400;
/// Steps in a second.
pub const STEPS_PER_S: u64 = 100_000;
/// So far ahead of the newest timestamp is the number in the file, steps: ten seconds.
pub const AHEAD: u64 = 10 * STEPS_PER_S;
/// A timestamp received that leads the clock by more is reported, steps: a minute.
pub const LEAD_MAX: u64 = 60 * STEPS_PER_S;
/// The first timestamp that has no place in a frame.
const END: u64 = 1 << 48;
/// Digits of the number in the file: always as many, so that writing replaces all of it.
const DIGITS: usize = 15;

/// A clock that gives steps since 2015-01-01.
pub type StepClock = Box<dyn FnMut() -> u64 + Send>;

/// The system's clock in steps since 2015-01-01; zero before that.
pub fn system_steps() -> u64 {
    let since_1970 = SystemTime::now().duration_since(SystemTime::UNIX_EPOCH).unwrap_or_default();
    let steps = since_1970.as_micros() / 10;
    u64::try_from(steps).unwrap_or(u64::MAX).saturating_sub(EPOCH_S * STEPS_PER_S)
}

/// Gives out timestamps.
pub struct SigningTime {
    clock: StepClock,
    /// The newest that was given out or received.
    newest: u64,
    /// By how much the newest timestamp led the clock beyond [`LEAD_MAX`], steps; until it is reported.
    lead: Option<u64>,
    /// The largest lead that was reported.
    lead_reported: u64,
    record: Option<TimestampRecord>,
}

impl std::fmt::Debug for SigningTime {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("SigningTime").field("newest", &self.newest).finish_non_exhaustive()
    }
}

impl SigningTime {
    /// Timestamps that no file keeps: of a link that only receives, and of tests.
    pub fn unrecorded(clock: StepClock) -> Self {
        SigningTime { clock, newest: 0, lead: None, lead_reported: 0, record: None }
    }

    /// Timestamps by that clock, later than all on record in the file, which is made where it is missing.
    ///
    /// # Errors
    /// What the system says; `InvalidData` where the file holds something else, `ResourceBusy` where another process uses it.
    pub fn recorded(clock: StepClock, path: &Path) -> Result<Self, Error> {
        let (record, used_below) = TimestampRecord::open(path)?;
        let mut time = SigningTime::unrecorded(clock);
        time.record = Some(record);
        time.adopt(used_below.saturating_sub(1));
        Ok(time)
    }

    /// The time of this end: the clock's, or the newest timestamp where that is later.
    pub fn now(&mut self) -> u64 {
        (self.clock)().max(self.newest)
    }

    /// Takes a later timestamp, rightly signed by another, for the newest.
    pub fn adopt(&mut self, timestamp: u64) {
        self.newest = self.newest.max(timestamp);
        let lead = timestamp.saturating_sub((self.clock)());
        // Once for a lead, and again where it grows by as much.
        if lead > self.lead_reported.saturating_add(LEAD_MAX) {
            (self.lead, self.lead_reported) = (Some(lead), lead);
        }
    }

    /// By how many seconds a timestamp received, or the one on record, led the clock; once where that was more than [`LEAD_MAX`].
    pub fn take_lead_s(&mut self) -> Option<f64> {
        self.lead.take().map(|steps| steps as f64 / STEPS_PER_S as f64)
    }

    /// A timestamp that was never given out before; `None` where that cannot be warranted.
    pub fn next_timestamp(&mut self) -> Option<u64> {
        let next = (self.clock)().max(self.newest.saturating_add(1));
        if next >= END - AHEAD || !self.record.as_mut().is_none_or(|record| record.covers(next)) {
            return None;
        }
        self.newest = next;
        Some(next)
    }

    /// Why the file could not be written, once where that is so.
    pub fn take_fault(&mut self) -> Option<String> {
        self.record.as_ref()?.take_fault()
    }
}

impl Drop for SigningTime {
    /// An end in order leaves no gap: the next start goes on with the next timestamp.
    fn drop(&mut self) {
        if let Some(record) = self.record.take() {
            record.close(self.newest.saturating_add(1));
        }
    }
}

/// The file, and the thread that writes it.
struct TimestampRecord {
    file: Arc<File>,
    path: PathBuf,
    /// What the file warrants: every timestamp below it may be given out.
    below: Arc<AtomicU64>,
    asked: u64,
    fault: Arc<Mutex<Option<String>>>,
    /// The way to the thread that writes, and the thread, once the first number has been written.
    writer: Option<(Sender<u64>, JoinHandle<()>)>,
}

impl TimestampRecord {
    /// The record, and the number in it.
    fn open(path: &Path) -> Result<(Self, u64), Error> {
        let mut options = OpenOptions::new();
        let file = options.read(true).write(true).create(true).truncate(false).mode(0o600).open(path)?;
        if let Err(TryLockError::WouldBlock) = file.try_lock() {
            let what = "another process signs with the timestamps of this file";
            return Err(Error::new(ErrorKind::ResourceBusy, what));
        }
        let mut bytes = [0; 64];
        let count = file.read_at(&mut bytes, 0)?;
        let text = std::str::from_utf8(bytes.get(..count).unwrap_or_default()).map(str::trim);
        let used_below = match text {
            Ok("") => 0,
            Ok(text) if text.len() <= DIGITS => text.parse().ok().filter(|number| *number < END).ok_or_else(not_a_timestamp)?,
            _ => return Err(not_a_timestamp()),
        };
        let fault = Arc::default();
        let record =
            TimestampRecord { file: Arc::new(file), path: path.into(), below: Arc::default(), asked: 0, fault, writer: None };
        Ok((record, used_below))
    }

    /// Whether the file warrants that timestamp; asks in time for the next ones.
    fn covers(&mut self, next: u64) -> bool {
        if next.saturating_add(AHEAD / 2) > self.asked {
            self.ask(next.saturating_add(AHEAD));
        }
        next < self.below.load(Ordering::Acquire)
    }

    fn ask(&mut self, below: u64) {
        if let Some((way, _)) = &self.writer {
            if way.try_send(below).is_ok() {
                self.asked = below;
            }
            return;
        }
        // The first is waited for.
        let write =
            Writer { file: self.file.clone(), path: self.path.clone(), below: self.below.clone(), fault: self.fault.clone() };
        if !write.number(below) {
            return;
        }
        let (way, asked) = bounded(1);
        let thread = std::thread::Builder::new().name("sideslip-stamp".to_owned());
        match thread.spawn(move || {
            asked.into_iter().for_each(|below| {
                let _ = write.number(below);
            })
        }) {
            Ok(thread) => (self.writer, self.asked) = (Some((way, thread)), below),
            Err(error) => put(&self.fault, format!("no thread could be started: {error}")),
        }
    }

    fn take_fault(&self) -> Option<String> {
        self.fault.lock().unwrap_or_else(PoisonError::into_inner).take()
    }

    /// Writes the number that the next start begins with, where anything was given out.
    fn close(self, next: u64) {
        if let Some((way, thread)) = self.writer {
            drop(way);
            let _ = thread.join();
            // Where this fails the number ahead stands: a gap, and nothing twice.
            let _ = write(&self.file, next);
        }
    }
}

/// What the thread needs to write a number.
struct Writer {
    file: Arc<File>,
    path: PathBuf,
    below: Arc<AtomicU64>,
    fault: Arc<Mutex<Option<String>>>,
}

impl Writer {
    /// Writes it, and warrants it once it is on the disk.
    fn number(&self, below: u64) -> bool {
        match write(&self.file, below) {
            Ok(()) => self.below.store(below, Ordering::Release),
            Err(error) => put(&self.fault, format!("{}: {error}", self.path.display())),
        }
        self.below.load(Ordering::Acquire) == below
    }
}

fn write(file: &File, number: u64) -> Result<(), Error> {
    file.write_all_at(format!("{number:0DIGITS$}\n").as_bytes(), 0)?;
    file.sync_data()
}

fn put(fault: &Mutex<Option<String>>, what: String) {
    *fault.lock().unwrap_or_else(PoisonError::into_inner) = Some(what);
}

fn not_a_timestamp() -> Error {
    Error::new(ErrorKind::InvalidData, "expected a timestamp of signatures, found something else")
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::time::Duration;

    /// A clock that stands.
    fn at(steps: u64) -> StepClock {
        Box::new(move || steps)
    }

    fn place(name: &str) -> PathBuf {
        let path = std::env::temp_dir().join(format!("sideslip-timestamps-{name}-{}", std::process::id()));
        let _ = std::fs::remove_file(&path);
        path
    }

    #[test]
    fn the_epoch_is_that_of_2015() {
        // 2026-01-01 is 4018 days after 2015-01-01.
        let days = system_steps() / STEPS_PER_S / 86_400;
        assert!((4018..20_000).contains(&days), "{days}");
    }

    #[test]
    fn timestamps_follow_the_clock_and_never_come_twice() {
        let mut steps = [500, 500, 499, 0, 700].into_iter();
        let mut time = SigningTime::unrecorded(Box::new(move || steps.next().unwrap()));
        let given: Vec<_> = (0..5).filter_map(|_| time.next_timestamp()).collect();
        assert_eq!(given, [500, 501, 502, 503, 700]);
        let mut time = SigningTime::unrecorded(at(500));
        time.adopt(9000);
        assert_eq!((time.now(), time.next_timestamp()), (9000, Some(9001)));
        time.adopt(END - 1);
        assert_eq!(time.next_timestamp(), None, "there is none left");
    }

    #[test]
    fn a_timestamp_far_ahead_of_the_clock_is_reported_once() {
        let year = 365 * 86_400 * STEPS_PER_S;
        let mut time = SigningTime::unrecorded(at(500));
        time.adopt(500 + LEAD_MAX);
        assert_eq!(time.take_lead_s(), None);
        for step in 0..100 {
            time.adopt(500 + year + step * 1000);
        }
        assert_eq!((time.take_lead_s(), time.take_lead_s()), (Some(365.0 * 86_400.0), None));
        time.adopt(500 + 2 * year);
        assert_eq!(time.take_lead_s(), Some(2.0 * 365.0 * 86_400.0));
        assert_eq!(time.next_timestamp(), Some(500 + 2 * year + 1));
    }

    #[test]
    fn an_end_in_order_leaves_the_next_and_a_kill_leaves_what_may_have_been_used() {
        let path = place("ends");
        let mut time = SigningTime::recorded(at(1000), &path).unwrap();
        assert_eq!([(); 3].map(|()| time.next_timestamp()), [Some(1000), Some(1001), Some(1002)]);
        assert_eq!(std::fs::read_to_string(&path).unwrap(), format!("{:015}\n", 1000 + AHEAD));
        drop(time);
        assert_eq!(std::fs::read_to_string(&path).unwrap(), "000000000001003\n");
        // The clock is behind: on from what is stored.
        let mut time = SigningTime::recorded(at(10), &path).unwrap();
        assert_eq!(time.next_timestamp(), Some(1003));
        // As a kill would: nothing is written at the end, and the system lets go of the lock.
        let record = time.record.take().unwrap();
        record.file.unlock().unwrap();
        std::mem::forget(record);
        drop(time);
        let mut time = SigningTime::recorded(at(10), &path).unwrap();
        assert_eq!(time.next_timestamp(), Some(1003 + AHEAD), "all that may have been used is passed over");
        drop(time);
        let mut time = SigningTime::recorded(at(1 << 40), &path).unwrap();
        assert_eq!(time.next_timestamp(), Some(1 << 40), "the clock where it is ahead");
        drop(time);
        std::fs::remove_file(&path).unwrap();
    }

    #[test]
    fn one_file_serves_one_process_and_something_else_in_it_is_refused() {
        let path = place("locked");
        let first = SigningTime::recorded(at(1), &path).unwrap();
        assert_eq!(SigningTime::recorded(at(1), &path).unwrap_err().kind(), ErrorKind::ResourceBusy);
        drop(first);
        assert_eq!(std::fs::read(&path).unwrap(), b"", "nothing was given out");
        for wrong in ["seven", "-1", "281474976710656", "0000000000000000001"] {
            std::fs::write(&path, wrong).unwrap();
            assert_eq!(SigningTime::recorded(at(1), &path).unwrap_err().kind(), ErrorKind::InvalidData, "{wrong}");
        }
        std::fs::remove_file(&path).unwrap();
    }

    #[test]
    fn the_record_stays_ahead_while_timestamps_are_given_out() {
        let path = place("ahead");
        let steps = Arc::new(AtomicU64::new(0));
        let clock = Arc::clone(&steps);
        let mut time = SigningTime::recorded(Box::new(move || clock.load(Ordering::Relaxed)), &path).unwrap();
        // A frame a second, for five minutes; however slow the disk is, none is given out that is not on record.
        for second in 1..=300 {
            steps.store(second * STEPS_PER_S, Ordering::Relaxed);
            let given = loop {
                match time.next_timestamp() {
                    Some(given) => break given,
                    None => std::thread::sleep(Duration::from_millis(1)),
                }
            };
            let stored: u64 = std::fs::read_to_string(&path).unwrap().trim().parse().unwrap();
            assert!(given == second * STEPS_PER_S && stored > given, "{given} {stored}");
        }
        drop(time);
        // A file that takes nothing: no timestamp, and the reason once.
        let mut time = SigningTime::recorded(at(5), &path).unwrap();
        time.record.as_mut().unwrap().file = Arc::new(File::open(&path).unwrap());
        assert_eq!(time.next_timestamp(), None);
        assert!(time.take_fault().unwrap().contains("ahead"));
        assert_eq!(time.take_fault(), None);
        drop(time);
        std::fs::remove_file(&path).unwrap();
    }
}
