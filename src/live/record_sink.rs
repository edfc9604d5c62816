//! The sink of a run's records: to the log and to a ground station; the newest of each kind, the events and the findings are
//! kept for the end.

use crate::io::outputs::event_ring::EventRing;
use crate::io::outputs::queue::QueueSender;
use crate::io::outputs::record::{EventKind, EventRecord, Message};
use crate::io::telemetry::record::RecordingRow;
use crate::postflight::diagnosis::record::{FindingRecord, FindingsSoFar};
use crate::postflight::output_error::record::OutputErrorRecord;
use crate::realtime::estimation::record::{EstimationEvent, StateRecord};
use crate::realtime::modes::record::ModesRecord;
use crate::realtime::pipeline::Tick;
use crate::realtime::regression::record::DerivativesRecord;

/// Different events that are kept: more than there are kinds and subjects.
pub const EVENTS: usize = 128;

/// The newest records, the events, and the ways to the log and to a ground station.
pub struct RecordSink {
    to_log: Option<QueueSender>,
    /// Derivatives, modes, events and findings alone go there.
    to_station: Option<QueueSender>,
    /// Values of the unknown columns, NaN where not sampled, as the queue takes them.
    others: Vec<f64>,
    newest_s: f64,
    /// The newest state.
    pub state: Option<StateRecord>,
    /// The newest derivatives.
    pub derivatives: Option<DerivativesRecord>,
    /// Time of the newest derivatives that an excited aircraft contributed to, s: those after it rest on the same data.
    pub excited_until_s: Option<f64>,
    /// The newest modes.
    pub modes: Option<ModesRecord>,
    /// The newest fit of output error.
    pub output_error: Option<OutputErrorRecord>,
    /// The findings that stand.
    pub findings: FindingsSoFar,
    /// Events, folded by kind and subject.
    pub events: Box<EventRing<EVENTS>>,
    /// Samples that the estimation dropped for their time, and values that it did not use.
    dropped_samples: u64,
    unused_values: u64,
}

impl RecordSink {
    /// A sink with a way to the log, where there is one.
    pub fn new(to_log: Option<QueueSender>) -> Self {
        RecordSink {
            to_log,
            to_station: None,
            others: Vec::new(),
            newest_s: 0.0,
            state: None,
            derivatives: None,
            excited_until_s: None,
            modes: None,
            output_error: None,
            findings: FindingsSoFar::new(),
            events: Box::new(EventRing::new()),
            dropped_samples: 0,
            unused_values: 0,
        }
    }

    /// Sends to a ground station too, from now on.
    pub fn set_station(&mut self, to_station: Option<QueueSender>) {
        self.to_station = to_station;
    }

    /// A row as it came, before the pipeline sees it.
    pub fn row(&mut self, row: &RecordingRow) {
        if row.sample.time_s.is_finite() {
            self.newest_s = row.sample.time_s;
        }
        if let Some(to_log) = &mut self.to_log {
            self.others.clear();
            self.others.extend(row.others.iter().map(|other| other.unwrap_or(f64::NAN)));
            to_log.send_sample(&row.sample, &self.others);
        }
    }

    /// What a sample brought. An event without a time of its own has that of the newest sample that has one.
    pub fn tick(&mut self, tick: &Tick) {
        for event in &tick.estimation_events {
            match event {
                EstimationEvent::TimeNotFinite | EstimationEvent::DuplicateTime | EstimationEvent::TimeWentBack { .. } => {
                    self.dropped_samples += 1;
                }
                EstimationEvent::NotFinite { .. } | EstimationEvent::OutOfRange { .. } => self.unused_values += 1,
                _ => {}
            }
            self.event(EventKind::Estimation(*event));
        }
        for innovation in &tick.innovations {
            self.log(|| Message::Innovation(*innovation));
        }
        if let Some(state) = tick.state {
            self.state = Some(state);
            self.log(|| Message::State(state));
        }
        if let Some(smoothed) = tick.smoothed {
            self.log(|| Message::Smoothed(smoothed));
        }
        for event in &tick.regression_events {
            self.event(EventKind::Regression(*event));
        }
        if let Some(derivatives) = &tick.derivatives {
            self.log_and_send(|| Message::Derivatives(derivatives.clone()));
            if derivatives.excited {
                self.excited_until_s = Some(derivatives.time_s);
            }
            self.derivatives = Some(derivatives.clone());
        }
        if let Some(modes) = tick.modes {
            self.modes = Some(modes);
            self.log_and_send(|| Message::Modes(modes));
        }
    }

    /// What output error came to.
    pub fn output_error(&mut self, record: &OutputErrorRecord) {
        self.log(|| Message::OutputError(record.clone()));
        self.output_error = Some(record.clone());
    }

    /// What the diagnosis says.
    pub fn finding(&mut self, record: &FindingRecord) {
        self.log_and_send(|| Message::Finding(record.clone()));
        self.findings.update(record);
    }

    /// Whether more than half of the queue to the log is taken.
    pub fn is_half_full(&self) -> bool {
        self.to_log.as_ref().is_some_and(QueueSender::is_half_full)
    }

    /// What of so many samples was not used, a sentence each.
    pub fn losses(&self, rows: u64) -> Vec<String> {
        let mut losses = Vec::new();
        if self.dropped_samples > 0 {
            losses.push(format!("{} of {rows} samples dropped for their time", self.dropped_samples));
        }
        if self.unused_values > 0 {
            losses.push(format!("{} values not used: no number, or none that an aircraft reaches", self.unused_values));
        }
        losses
    }

    /// A line of progress for a person.
    pub fn progress(&self, run: &str, time_s: f64) -> String {
        let name: String = run.chars().take(30).collect();
        match self.modes.and_then(|modes| modes.dutch_roll) {
            Some(pair) => format!("{name}: {time_s:.1} s, Dutch roll omega {:.3} rad/s, zeta {:.3}", pair.omega, pair.zeta),
            None => format!("{name}: {time_s:.1} s"),
        }
    }

    /// Ends the ways to the log and to the ground station.
    pub fn close(&mut self) {
        self.to_log = None;
        self.to_station = None;
    }

    fn event(&mut self, kind: EventKind) {
        let event = EventRecord { time_s: self.newest_s, kind };
        self.events.push(&event);
        self.log_and_send(|| Message::Event(event));
    }

    fn log_and_send(&mut self, message: impl FnOnce() -> Message) {
        if self.to_log.is_none() && self.to_station.is_none() {
            return;
        }
        let message = message();
        for way in [&mut self.to_log, &mut self.to_station].into_iter().flatten() {
            way.send(&message);
        }
    }

    fn log(&mut self, message: impl FnOnce() -> Message) {
        if let Some(to_log) = &mut self.to_log {
            to_log.send(&message());
        }
    }
}
