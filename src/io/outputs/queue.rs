//! The bounded queue from the estimator to the writers: sending copies bytes and does not allocate.
//!
//! Two policies. [`QueuePolicy::RealTime`] never waits: when the queue is full a message is counted as lost, and the loss is
//! queued as a message when there is room. [`QueuePolicy::Lossless`] waits for room: for recordings played without pacing.
//!
//! Large messages, and those whose size depends on the run (derivatives, values of unknown columns), are in boxes allocated in
//! advance, which the receiver returns by [`QueueReceiver::recycle`]. Memory is bounded by `capacity`: some 400 B a slot, 5 kB
//! for each of [`DERIVATIVES_IN_FLIGHT`], 8 B a slot and unknown column.

use super::record::{EventRecord, Message};
use crate::flight::derivative::Axis;
use crate::flight::sample::Sample;
use crate::postflight::diagnosis::record::FindingRecord;
use crate::postflight::output_error::record::OutputErrorRecord;
use crate::realtime::estimation::record::{Innovation, LaggedRecord, StateRecord};
use crate::realtime::modes::record::ModesRecord;
use crate::realtime::regression::record::{DerivativesRecord, EquationRecord, Status};
use crossbeam::channel::{self, RecvTimeoutError, TrySendError};
use std::sync::Arc;
use std::time::Duration;

/// How many derivative records can be under way at once; at 10 Hz more than three seconds of them.
pub const DERIVATIVES_IN_FLIGHT: usize = 32;

/// The same of output error: it comes twice a second.
pub const OUTPUT_ERRORS_IN_FLIGHT: usize = 8;

/// The same of findings: a few at a time, at the end of a manoeuvre.
pub const FINDINGS_IN_FLIGHT: usize = 32;

/// How long a queue that closes waits for room to say what it lost.
const LAST_WORD: Duration = Duration::from_millis(500);

/// What happens where the queue is full.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum QueuePolicy {
    /// The message is lost and counted; sending never waits.
    RealTime,
    /// Sending waits for room.
    Lossless,
}

/// Messages that found no room.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LostMessages {
    /// Time of the first of them, s.
    pub time_s: f64,
    /// How many.
    pub count: u64,
}

/// A message as it lies in the queue.
#[derive(Debug)]
#[expect(missing_docs, reason = "variants are what their names say")]
pub enum QueueEntry {
    /// A sample with the values of the unknown columns, NaN where not sampled.
    Sample(Sample, Box<[f64]>),
    State(StateRecord),
    /// A smoothed state.
    Smoothed(LaggedRecord),
    Innovation(Innovation),
    Derivatives(Box<DerivativesRecord>),
    Modes(ModesRecord),
    OutputError(Box<OutputErrorRecord>),
    /// What the diagnosis says.
    Finding(Box<FindingRecord>),
    Event(EventRecord),
    /// What found no room before this.
    Lost(LostMessages),
}

/// Boxes that go round: fresh ones out, spent ones back.
#[derive(Debug)]
struct Boxes<T> {
    fresh: channel::Receiver<T>,
    spent: channel::Sender<T>,
}

impl<T> Clone for Boxes<T> {
    fn clone(&self) -> Self {
        Boxes { fresh: self.fresh.clone(), spent: self.spent.clone() }
    }
}

impl<T> Boxes<T> {
    fn filled(count: usize, make: impl Fn() -> T) -> Self {
        let (spent, fresh) = channel::bounded(count.max(1));
        (0..count).for_each(|_| {
            let _ = spent.try_send(make());
        });
        Boxes { fresh, spent }
    }

    /// Back to where it came from; there is room for every box.
    fn give_back(&self, spent: T) {
        let _ = self.spent.try_send(spent);
    }
}

/// The estimator's end.
#[derive(Debug)]
pub struct QueueSender {
    policy: QueuePolicy,
    queue: channel::Sender<QueueEntry>,
    derivatives: Boxes<Box<DerivativesRecord>>,
    output_errors: Boxes<Box<OutputErrorRecord>>,
    findings: Boxes<Box<FindingRecord>>,
    unknown: Boxes<Box<[f64]>>,
    /// Shared with the receiver alone: a count of one says that nobody listens any more.
    listener: Arc<()>,
    pending: Option<LostMessages>,
    lost: u64,
}

/// The writer's end.
#[derive(Debug)]
pub struct QueueReceiver {
    queue: channel::Receiver<QueueEntry>,
    derivatives: Boxes<Box<DerivativesRecord>>,
    output_errors: Boxes<Box<OutputErrorRecord>>,
    findings: Boxes<Box<FindingRecord>>,
    unknown: Boxes<Box<[f64]>>,
    _listener: Arc<()>,
}

/// A queue of that many messages, for runs with that many unknown columns. Everything is allocated here.
pub fn queue(policy: QueuePolicy, capacity: usize, unknown_columns: usize) -> (QueueSender, QueueReceiver) {
    let capacity = capacity.max(1);
    let (to_writer, from_estimator) = channel::bounded(capacity);
    let blank = DerivativesRecord {
        time_s: 0.0,
        equations: Axis::ALL.map(|axis| EquationRecord::empty(axis, Status::Waiting)),
        lateral: None,
        excited: false,
    };
    let derivatives = Boxes::filled(DERIVATIVES_IN_FLIGHT, || Box::new(blank.clone()));
    let output_errors = Boxes::filled(OUTPUT_ERRORS_IN_FLIGHT, || Box::new(OutputErrorRecord::EMPTY));
    let findings = Boxes::filled(FINDINGS_IN_FLIGHT, || Box::new(FindingRecord::EMPTY));
    // One box a slot, one in the hand of either end.
    let count = if unknown_columns == 0 { 0 } else { capacity + 2 };
    let unknown = Boxes::filled(count, || vec![f64::NAN; unknown_columns].into_boxed_slice());
    let listener = Arc::new(());
    let receiver = QueueReceiver {
        queue: from_estimator,
        derivatives: derivatives.clone(),
        output_errors: output_errors.clone(),
        findings: findings.clone(),
        unknown: unknown.clone(),
        _listener: Arc::clone(&listener),
    };
    (
        QueueSender { policy, queue: to_writer, derivatives, output_errors, findings, unknown, listener, pending: None, lost: 0 },
        receiver,
    )
}

impl QueueSender {
    /// Queues a sample with the values of its unknown columns (NaN where not sampled). Values beyond the number of
    /// unknown columns that the queue was made for are not carried; missing ones count as not sampled.
    pub fn send_sample(&mut self, sample: &Sample, unknown: &[f64]) {
        if unknown.is_empty() {
            return self.queue_entry(QueueEntry::Sample(*sample, Box::default()), sample.time_s);
        }
        let Some(mut values) = self.take(&self.unknown) else { return self.lose(sample.time_s) };
        let carried = values.len().min(unknown.len());
        let (front, rest) = values.split_at_mut(carried);
        front.iter_mut().zip(unknown).for_each(|(to, from)| *to = *from);
        rest.fill(f64::NAN);
        self.queue_entry(QueueEntry::Sample(*sample, values), sample.time_s);
    }

    /// Queues a message.
    pub fn send(&mut self, message: &Message) {
        match message {
            Message::Sample(sample) => self.send_sample(sample, &[]),
            Message::State(record) => self.queue_entry(QueueEntry::State(*record), record.time_s),
            Message::Smoothed(record) => self.queue_entry(QueueEntry::Smoothed(*record), record.state.time_s),
            Message::Innovation(record) => self.queue_entry(QueueEntry::Innovation(*record), record.time_s),
            Message::Modes(record) => self.queue_entry(QueueEntry::Modes(*record), record.time_s),
            Message::Event(record) => self.queue_entry(QueueEntry::Event(*record), record.time_s),
            Message::OutputError(record) => match self.take(&self.output_errors) {
                Some(mut boxed) => {
                    boxed.as_mut().clone_from(record);
                    self.queue_entry(QueueEntry::OutputError(boxed), record.time_s);
                }
                None => self.lose(record.time_s),
            },
            Message::Finding(record) => match self.take(&self.findings) {
                Some(mut boxed) => {
                    boxed.as_mut().clone_from(record);
                    self.queue_entry(QueueEntry::Finding(boxed), record.time_s);
                }
                None => self.lose(record.time_s),
            },
            Message::Derivatives(record) => match self.take(&self.derivatives) {
                Some(mut boxed) => {
                    boxed.as_mut().clone_from(record);
                    self.queue_entry(QueueEntry::Derivatives(boxed), record.time_s);
                }
                None => self.lose(record.time_s),
            },
        }
    }

    /// Whether more than half of the places are taken.
    pub fn is_half_full(&self) -> bool {
        self.queue.capacity().is_some_and(|capacity| 2 * self.queue.len() > capacity)
            || 2 * self.derivatives.fresh.len() < DERIVATIVES_IN_FLIGHT
    }

    /// How many messages found no room so far.
    pub fn lost(&self) -> u64 {
        self.lost
    }

    /// A fresh box; `None` where there is none and the policy does not wait, or nobody listens any more.
    fn take<T>(&self, boxes: &Boxes<T>) -> Option<T> {
        if let Ok(fresh) = boxes.fresh.try_recv() {
            return Some(fresh);
        }
        while self.policy == QueuePolicy::Lossless && Arc::strong_count(&self.listener) > 1 {
            if let Ok(fresh) = boxes.fresh.recv_timeout(Duration::from_millis(20)) {
                return Some(fresh);
            }
        }
        None
    }

    fn queue_entry(&mut self, entry: QueueEntry, time_s: f64) {
        if let Some(lost) = self.pending {
            if self.queue.try_send(QueueEntry::Lost(lost)).is_err() {
                self.give_back(entry);
                return self.lose(time_s);
            }
            self.pending = None;
        }
        let refused = match self.queue.try_send(entry) {
            Ok(()) => return,
            Err(TrySendError::Full(entry)) if self.policy == QueuePolicy::Lossless => match self.queue.send(entry) {
                Ok(()) => return,
                Err(channel::SendError(entry)) => entry,
            },
            Err(TrySendError::Full(entry) | TrySendError::Disconnected(entry)) => entry,
        };
        self.give_back(refused);
        self.lose(time_s);
    }

    fn give_back(&self, entry: QueueEntry) {
        match entry {
            QueueEntry::Sample(_, values) if !values.is_empty() => self.unknown.give_back(values),
            QueueEntry::Derivatives(boxed) => self.derivatives.give_back(boxed),
            QueueEntry::OutputError(boxed) => self.output_errors.give_back(boxed),
            QueueEntry::Finding(boxed) => self.findings.give_back(boxed),
            _ => {}
        }
    }

    fn lose(&mut self, time_s: f64) {
        self.lost += 1;
        match &mut self.pending {
            Some(lost) => lost.count += 1,
            None => self.pending = Some(LostMessages { time_s, count: 1 }),
        }
    }
}

impl Drop for QueueSender {
    fn drop(&mut self) {
        if let Some(lost) = self.pending.take() {
            let _ = self.queue.send_timeout(QueueEntry::Lost(lost), LAST_WORD);
        }
    }
}

/// What came out of the queue.
#[derive(Debug)]
#[expect(clippy::large_enum_variant, reason = "a message moves by value; a box would allocate for each")]
pub enum QueueReceived {
    /// A message; hand it back by [`QueueReceiver::recycle`] once written.
    Entry(QueueEntry),
    /// Nothing within the time.
    Nothing,
    /// The sender is gone and everything it sent has been received.
    Closed,
}

impl QueueReceiver {
    /// The next message, waiting for it at most that long.
    pub fn receive(&self, wait: Duration) -> QueueReceived {
        match self.queue.recv_timeout(wait) {
            Ok(entry) => QueueReceived::Entry(entry),
            Err(RecvTimeoutError::Timeout) => QueueReceived::Nothing,
            Err(RecvTimeoutError::Disconnected) => QueueReceived::Closed,
        }
    }

    /// Hands a written message's box back to the sender.
    pub fn recycle(&self, entry: QueueEntry) {
        match entry {
            QueueEntry::Sample(_, values) if !values.is_empty() => self.unknown.give_back(values),
            QueueEntry::Derivatives(boxed) => self.derivatives.give_back(boxed),
            QueueEntry::OutputError(boxed) => self.output_errors.give_back(boxed),
            QueueEntry::Finding(boxed) => self.findings.give_back(boxed),
            _ => {}
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::record::EventKind;
    use super::*;
    use crate::realtime::estimation::record::EstimationEvent;

    fn event(time_s: f64) -> Message {
        Message::Event(EventRecord { time_s, kind: EventKind::Estimation(EstimationEvent::Initialised) })
    }

    fn derivatives(time_s: f64) -> Message {
        Message::Derivatives(DerivativesRecord {
            time_s,
            equations: Axis::ALL.map(|axis| EquationRecord::empty(axis, Status::Exciting)),
            lateral: None,
            excited: true,
        })
    }

    fn drain(receiver: &QueueReceiver) -> Vec<QueueEntry> {
        let mut entries = Vec::new();
        while let QueueReceived::Entry(entry) = receiver.receive(Duration::ZERO) {
            entries.push(entry);
        }
        entries
    }

    #[test]
    fn in_real_time_a_full_queue_counts_and_says_so_as_soon_as_there_is_room() {
        let (mut sender, receiver) = queue(QueuePolicy::RealTime, 3, 0);
        for k in 0..5_u32 {
            sender.send(&event(f64::from(k)));
        }
        assert_eq!(sender.lost(), 2);
        assert_eq!(drain(&receiver).len(), 3);
        sender.send(&event(5.0));
        let entries = drain(&receiver);
        assert!(matches!(
            entries.as_slice(),
            [QueueEntry::Lost(LostMessages { time_s: 3.0, count: 2 }), QueueEntry::Event(e)] if (5.0..=5.0).contains(&e.time_s)
        ));
    }

    #[test]
    fn a_loss_at_the_very_end_is_said_too() {
        let (mut sender, receiver) = queue(QueuePolicy::RealTime, 1, 0);
        sender.send(&event(0.0));
        sender.send(&event(1.0));
        let listener = std::thread::spawn(move || {
            let mut lost = 0;
            loop {
                match receiver.receive(Duration::from_millis(5)) {
                    QueueReceived::Entry(QueueEntry::Lost(l)) => lost += l.count,
                    QueueReceived::Entry(_) => std::thread::sleep(Duration::from_millis(20)),
                    QueueReceived::Nothing => {}
                    QueueReceived::Closed => return lost,
                }
            }
        });
        drop(sender);
        assert_eq!(listener.join().unwrap(), 1);
    }

    #[test]
    fn boxes_go_round_and_their_number_bounds_what_is_under_way() {
        let (mut sender, receiver) = queue(QueuePolicy::RealTime, 100, 3);
        let mut said = 0;
        let mut places = std::collections::BTreeSet::new();
        for round in 0..3 {
            for k in 0..40 {
                sender.send(&derivatives(f64::from(k)));
                sender.send_sample(&Sample::new(f64::from(k)), &[1.0, f64::from(k)]);
            }
            assert_eq!(sender.lost(), 8 * (round + 1));
            for entry in drain(&receiver) {
                match &entry {
                    QueueEntry::Derivatives(record) => {
                        places.insert(std::ptr::from_ref(record.as_ref()).addr());
                        assert!(record.excited);
                    }
                    QueueEntry::Sample(sample, values) => {
                        assert_eq!((values[0], values[1]), (1.0, sample.time_s));
                        assert!(values[2].is_nan());
                    }
                    QueueEntry::Lost(lost) => said += lost.count,
                    other => panic!("{other:?}"),
                }
                receiver.recycle(entry);
            }
        }
        assert_eq!(places.len(), DERIVATIVES_IN_FLIGHT, "the same boxes every round: none was made by sending");
        assert!(said + 1 >= sender.lost(), "all but the last loss, which waits for the next message");
    }

    #[test]
    fn lossless_waits_for_room_and_gives_up_only_where_nobody_listens() {
        let (mut sender, receiver) = queue(QueuePolicy::Lossless, 2, 1);
        let listener = std::thread::spawn(move || {
            for k in 0..500_u32 {
                match receiver.receive(Duration::from_secs(10)) {
                    QueueReceived::Entry(entry) => {
                        assert!(matches!(
                            &entry,
                            QueueEntry::Sample(sample, values) if (sample.time_s, values[0]) == (f64::from(k), -f64::from(k))
                        ));
                        receiver.recycle(entry);
                    }
                    other => panic!("{other:?}"),
                }
            }
        });
        for k in 0..500_u32 {
            sender.send_sample(&Sample::new(f64::from(k)), &[-f64::from(k)]);
        }
        listener.join().unwrap();
        assert_eq!(sender.lost(), 0);
        for k in 0..100 {
            sender.send(&derivatives(f64::from(k)));
            sender.send_sample(&Sample::new(f64::from(k)), &[1.0]);
        }
        assert_eq!(sender.lost(), 200);
    }
}
