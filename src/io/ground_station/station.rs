//! The thread that sends to a ground station: takes records from a run's queue, sends once a second what is due.
//!
//! Consumes a queue for each run, one after another; produces frames on a link, signed where a key is set, and a
//! [`StationReport`] at the end. Nothing waits for it: a link that is slow or away fills the queue, whose losses are counted. A
//! link that cannot be opened, or breaks, is said once and tried again; meanwhile nothing is put together, so that what stands
//! at the other end is known. What comes in on the link is read and not looked at.

use super::message::{StationFrames, StationMessage, StationSeverity};
use super::numbers::StationNumbers;
use super::texts::{StatusTexts, TextSubject};
use crate::flight::channel::ControlNames;
use crate::io::outputs::queue::{QueueEntry, QueuePolicy, QueueReceived, QueueReceiver, QueueSender, queue};
use crate::io::outputs::record::EventRecord;
use crate::io::outputs::words::event_text::{EventText, Severity, event_place, event_severity, event_subject};
use crate::io::telemetry::mavlink::link::{Link, LinkEvent, Url};
use crate::io::telemetry::mavlink::signing::LinkSigning;
use crate::postflight::diagnosis::record::{FindingRecord, FindingStatus};
use crossbeam::channel::{Receiver, RecvTimeoutError, Sender, bounded};
use std::io;
use std::thread::{Builder, JoinHandle};
use std::time::{Duration, Instant};

/// Between heartbeats, and between two values of one name.
pub const PERIOD: Duration = Duration::from_secs(1);
/// The longest wait for a record.
const WAKE: Duration = Duration::from_millis(50);
/// The longest wait for bytes from the other end, which are not looked at.
const LISTEN: Duration = Duration::from_millis(1);
/// Reads at once: more comes from no ground station in a second.
const READS: usize = 64;
/// Between attempts to open a link.
const REOPEN: Duration = Duration::from_secs(1);
/// Records that the queue holds: derivatives, modes and events of several seconds.
const QUEUE: usize = 512;
/// Runs that may wait for the thread.
const RUNS: usize = 8;
/// The system whose computer this is, until a run says it.
const SYSTEM: u8 = 1;

/// What the thread is started with.
pub struct StationSettings {
    /// Where the ground station is.
    pub url: Url,
    /// The system whose onboard computer this is; `None` takes the vehicle's of the run.
    pub system: Option<u8>,
    /// Signing, where a key is set.
    pub signing: Option<LinkSigning>,
}

/// How the sending went.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct StationReport {
    /// Messages sent.
    pub sent: u64,
    /// Messages that the link did not take, or nobody was there to take.
    pub refused: u64,
    /// Messages that could not be signed, and were not sent.
    pub unsigned: u64,
    /// Records that found no room in the queue.
    pub lost: u64,
    /// Texts that found no room among those that wait for their turn.
    pub texts_dropped: u64,
}

/// Told of what happens to the link.
pub type StationReporter = Box<dyn FnMut(&str) + Send>;

/// The running thread.
pub struct GroundStation {
    runs: Sender<StationRun>,
    thread: JoinHandle<StationReport>,
}

/// A run as the thread gets it.
struct StationRun {
    receiver: QueueReceiver,
    name: String,
    controls: ControlNames,
    system: Option<u8>,
}

impl GroundStation {
    /// Starts the thread; the link is opened there.
    ///
    /// # Errors
    /// Where the system gives no thread.
    pub fn start(settings: StationSettings, say: StationReporter) -> io::Result<Self> {
        let (runs, coming) = bounded(RUNS);
        let station = Sending::new(settings, say, Instant::now());
        let thread = Builder::new().name("sideslip-station".to_owned()).spawn(move || station.work(&coming))?;
        Ok(GroundStation { runs, thread })
    }

    /// Begins a run of the vehicle of that system: the way for its records, which ends with the run. `None` where the thread is
    /// so far behind that it takes no other run.
    pub fn begin_run(&self, name: &str, controls: ControlNames, system: Option<u8>) -> Option<QueueSender> {
        let (sender, receiver) = queue(QueuePolicy::RealTime, QUEUE, 0);
        let run = StationRun { receiver, name: name.to_owned(), controls, system };
        self.runs.try_send(run).is_ok().then_some(sender)
    }

    /// Lets it send what is left, for so long; `None` where the link holds it up for longer.
    pub fn finish(self, limit: Duration) -> Option<StationReport> {
        let GroundStation { runs, thread } = self;
        drop(runs);
        let begun = Instant::now();
        while !thread.is_finished() {
            if begun.elapsed() >= limit {
                return None;
            }
            std::thread::sleep(Duration::from_millis(2));
        }
        thread.join().ok()
    }
}

/// What the thread works with.
struct Sending {
    settings: StationSettings,
    say: StationReporter,
    link: Option<Link>,
    /// When the link is tried next, and what was said of it last.
    try_at: Instant,
    said: String,
    frames: StationFrames,
    numbers: StationNumbers,
    texts: StatusTexts,
    controls: ControlNames,
    beat_at: Instant,
    report: StationReport,
}

impl Sending {
    fn new(settings: StationSettings, say: StationReporter, now: Instant) -> Self {
        let frames = StationFrames::new(settings.system.unwrap_or(SYSTEM));
        Sending {
            settings,
            say,
            link: None,
            try_at: now,
            said: String::new(),
            frames,
            numbers: StationNumbers::new(),
            texts: StatusTexts::new(now),
            controls: ControlNames::Rotorcraft,
            beat_at: now,
            report: StationReport::default(),
        }
    }

    fn work(mut self, runs: &Receiver<StationRun>) -> StationReport {
        let mut run: Option<StationRun> = None;
        loop {
            let now = Instant::now();
            self.due(now);
            let wait = self.beat_at.saturating_duration_since(now).min(WAKE);
            match &run {
                None => match runs.recv_timeout(wait) {
                    Ok(next) => {
                        self.begin_run(&next);
                        run = Some(next);
                    }
                    Err(RecvTimeoutError::Timeout) => {}
                    Err(RecvTimeoutError::Disconnected) => return self.end(),
                },
                Some(current) => match current.receiver.receive(wait) {
                    QueueReceived::Entry(entry) => {
                        self.take(&entry, Instant::now());
                        current.receiver.recycle(entry);
                    }
                    QueueReceived::Nothing => {}
                    QueueReceived::Closed => {
                        self.end_run(&current.name);
                        run = None;
                    }
                },
            }
        }
    }

    fn begin_run(&mut self, run: &StationRun) {
        let known = run.system.filter(|system| self.settings.system.is_none() && *system != self.frames.sender().system);
        if let Some(system) = known {
            self.frames.set_system(system);
            (self.say)(&format!("estimates are sent as {}, of the vehicle's system", self.frames.sender()));
        }
        self.controls = run.controls;
        let mut ended = Vec::new();
        self.numbers.begin_run(run.controls, &mut |message| ended.push(message));
        self.send_all(&ended);
        self.texts.push(TextSubject::Run, StationSeverity::Info, format!("run {} begins", run.name));
    }

    /// The last numbers of a run are sent, however short it was; then they are of a run that has ended.
    fn end_run(&mut self, name: &str) {
        if self.numbers.is_fresh() && self.is_heard() {
            self.send_numbers(Instant::now());
        }
        self.numbers.end_run();
        self.texts.push(TextSubject::Run, StationSeverity::Info, format!("run {name} has ended"));
    }

    fn take(&mut self, entry: &QueueEntry, now: Instant) {
        match entry {
            QueueEntry::Modes(record) => self.numbers.take_modes(record, now),
            QueueEntry::Derivatives(record) => self.numbers.take_derivatives(record, now),
            QueueEntry::Event(record) => self.event(record),
            QueueEntry::Finding(record) => self.finding(record),
            QueueEntry::Lost(lost) => {
                self.report.lost += lost.count;
                let words = format!("{} records found no room on the way to the ground station", self.report.lost);
                self.texts.push(TextSubject::Lost, StationSeverity::Warning, words);
            }
            QueueEntry::Sample(..)
            | QueueEntry::State(_)
            | QueueEntry::Smoothed(_)
            | QueueEntry::Innovation(_)
            | QueueEntry::OutputError(_) => {}
        }
    }

    fn event(&mut self, record: &EventRecord) {
        let EventRecord { time_s, kind } = record;
        let severity = match event_severity(kind) {
            Severity::Info => StationSeverity::Info,
            Severity::Warning | Severity::DataLost => StationSeverity::Warning,
        };
        let subject = TextSubject::Event(event_place(kind), event_subject(kind, self.controls));
        let words = EventText { kind, controls: self.controls };
        self.texts.push(subject, severity, format!("{words} (at {time_s:.2} s)"));
    }

    fn finding(&mut self, record: &FindingRecord) {
        let words = match record.standing {
            FindingStatus::Waiting => return,
            FindingStatus::Found if record.probability.is_finite() => {
                format!("{} (probability {:.2})", record.statement, record.probability)
            }
            FindingStatus::Found | FindingStatus::Retracted | FindingStatus::Failed => record.statement.to_string(),
        };
        self.texts.push(TextSubject::Finding(record.number), StationSeverity::Notice, words);
    }

    /// Does what is due now.
    fn due(&mut self, now: Instant) {
        if self.link.is_none() && now >= self.try_at {
            self.open(now);
        }
        if now >= self.beat_at {
            // After a pause there is no beat to make up for.
            self.beat_at = (self.beat_at + PERIOD).max(now);
            self.listen();
            self.send(&StationMessage::Heartbeat);
            if self.is_heard() {
                self.send_numbers(now);
            }
            let fault = self.settings.signing.as_mut().and_then(LinkSigning::take_fault);
            if let Some(fault) = fault {
                (self.say)(&format!("{fault}; nothing is sent that cannot be signed"));
            }
        }
        if self.is_heard() {
            let mut due = Vec::new();
            self.texts.due(now, &mut |message| due.push(message));
            self.send_all(&due);
        }
    }

    /// Whether there is a link, and somebody known at its other end.
    fn is_heard(&self) -> bool {
        self.link.as_ref().is_some_and(Link::has_peer)
    }

    fn open(&mut self, now: Instant) {
        self.try_at = now + REOPEN;
        match Link::open(self.settings.url.clone(), LISTEN) {
            Ok(link) => {
                (self.say)(&format!("estimates go to {} as {}", self.settings.url, self.frames.sender()));
                self.said.clear();
                self.link = Some(link);
            }
            Err(wrong) => self.say_once(format!("{wrong}; no estimates go there, it is tried again")),
        }
    }

    /// The same is said once, until the link is open.
    fn say_once(&mut self, what: String) {
        if what != self.said {
            (self.say)(&what);
            self.said = what;
        }
    }

    fn broken(&mut self, why: &str) {
        self.link = None;
        self.try_at = Instant::now() + REOPEN;
        (self.say)(&format!("{}: {why}; it is opened again", self.settings.url));
    }

    /// Reads what has come, and who is there; nothing of it is looked at.
    fn listen(&mut self) {
        let mut buffer = [0; 2048];
        for _ in 0..READS {
            let Some(link) = &mut self.link else { return };
            match link.receive(&mut buffer) {
                Ok(LinkEvent::Bytes(_)) => {}
                Ok(LinkEvent::Silence) => return,
                Ok(LinkEvent::Closed) => return self.broken("the other end has closed it"),
                Err(error) => return self.broken(&error.to_string()),
            }
        }
    }

    fn send_numbers(&mut self, now: Instant) {
        let mut due = Vec::new();
        self.numbers.due(now, &mut |message| due.push(message));
        self.send_all(&due);
    }

    fn send_all(&mut self, messages: &[StationMessage]) {
        messages.iter().for_each(|message| self.send(message));
    }

    /// The only place where anything leaves.
    fn send(&mut self, message: &StationMessage) {
        let Some(link) = &mut self.link else {
            self.report.refused += 1;
            return;
        };
        let frame = self.frames.frame(message);
        let bytes = match &mut self.settings.signing {
            None => frame,
            Some(signing) => match signing.sign(frame) {
                Some(signed) => signed,
                None => {
                    self.report.unsigned += 1;
                    return;
                }
            },
        };
        match link.send(bytes) {
            Ok(true) => self.report.sent += 1,
            Ok(false) => self.report.refused += 1,
            Err(error) => {
                self.report.refused += 1;
                self.broken(&error.to_string());
            }
        }
    }

    /// The end: every number is taken back, and what may be said at once is said.
    fn end(mut self) -> StationReport {
        if self.is_heard() {
            self.send_numbers(Instant::now());
            self.due(Instant::now());
        }
        StationReport { texts_dropped: self.texts.dropped() + self.texts.waiting() as u64, ..self.report }
    }
}

#[cfg(test)]
#[path = "station_tests.rs"]
mod tests;
