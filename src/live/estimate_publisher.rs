//! The records of the estimator in shared memory: one service a kind of record.

use super::wiring::RecordPublisher;
use crate::io::bus::clock::monotonic_ns;
use crate::io::bus::error::BusError;
use crate::io::bus::payload::{
    AcknowledgementPayload, DerivativesPayload, EventPayload, FindingPayload, InnovationsPayload, MessageHeader, ModesPayload,
    OutputErrorPayload, SAMPLE_TO_ACKNOWLEDGE, SamplePayload, SmoothedPayload, StatePayload, THE_END,
};
use crate::io::bus::service::{Bus, Publisher};
use crate::io::outputs::record::{EventKind, EventRecord};
use crate::postflight::diagnosis::record::FindingRecord;
use crate::postflight::output_error::record::OutputErrorRecord;
use crate::realtime::pipeline::Tick;

const SIGN_OF_LIFE_NS: u64 = 100_000_000;

/// One publisher a service.
pub struct EstimatePublisher {
    state: Publisher<StatePayload>,
    smoothed: Publisher<SmoothedPayload>,
    innovation: Publisher<InnovationsPayload>,
    derivatives: Publisher<DerivativesPayload>,
    modes: Publisher<ModesPayload>,
    output_error: Publisher<OutputErrorPayload>,
    finding: Publisher<FindingPayload>,
    event: Publisher<EventPayload>,
    taken: Publisher<AcknowledgementPayload>,
    newest_s: f64,
    said_taken_ns: u64,
}

impl EstimatePublisher {
    /// Every publisher of the estimator; all memory is taken here.
    pub fn new(bus: &Bus) -> Result<Self, BusError> {
        Ok(EstimatePublisher {
            state: bus.publisher()?,
            smoothed: bus.publisher()?,
            innovation: bus.publisher()?,
            derivatives: bus.publisher()?,
            modes: bus.publisher()?,
            output_error: bus.publisher()?,
            finding: bus.publisher()?,
            event: bus.publisher()?,
            taken: bus.publisher()?,
            newest_s: 0.0,
            said_taken_ns: 0,
        })
    }

    /// Meets the readers that came since, on every service: so that the first message of a service that speaks late opens no
    /// connection on the way from a sample to its estimates.
    pub fn meet(&mut self) -> Result<(), BusError> {
        self.state.meet()?;
        self.smoothed.meet()?;
        self.innovation.meet()?;
        self.derivatives.meet()?;
        self.modes.meet()?;
        self.output_error.meet()?;
        self.finding.meet()?;
        self.event.meet()?;
        self.taken.meet()
    }

    /// The publisher of the records of one sample.
    pub fn of_sample(&mut self, header: MessageHeader) -> SamplePublication<'_> {
        SamplePublication { publisher: self, header }
    }

    /// Says that a sample was taken: each, where its publisher waits for that; else now and then, as a heartbeat.
    pub fn taken(&mut self, sample: &SamplePayload) -> Result<(), BusError> {
        let now_ns = monotonic_ns();
        let due = now_ns.saturating_sub(self.said_taken_ns) >= SIGN_OF_LIFE_NS;
        if due || sample.kind == SAMPLE_TO_ACKNOWLEDGE || sample.kind == THE_END {
            self.said_taken_ns = now_ns;
            let MessageHeader { incarnation, sequence, sampled_ns, time_s, .. } = sample.header;
            let header = MessageHeader { time_s, ..MessageHeader::default() };
            let taken = AcknowledgementPayload { header, of_incarnation: incarnation, taken: sequence + 1 };
            self.taken.publish(&taken, Some(sampled_ns))?;
        }
        Ok(())
    }
}

/// Publishes records with the times of the sample that they belong to.
pub struct SamplePublication<'a> {
    publisher: &'a mut EstimatePublisher,
    header: MessageHeader,
}

impl RecordPublisher for SamplePublication<'_> {
    type Error = BusError;

    /// Derivatives go before modes, so that a reader who has modes finds their derivatives.
    fn tick(&mut self, tick: &Tick) -> Result<(), BusError> {
        let SamplePublication { publisher, header: sample } = self;
        let sampled_ns = Some(sample.sampled_ns);
        if sample.time_s.is_finite() {
            publisher.newest_s = sample.time_s;
        }
        if let Some(state) = &tick.state {
            publisher.state.publish(&state.into(), sampled_ns)?;
        }
        if let Some(smoothed) = &tick.smoothed {
            publisher.smoothed.publish(&smoothed.into(), sampled_ns)?;
        }
        if let Some(derivatives) = &tick.derivatives {
            publisher.derivatives.publish(&derivatives.into(), sampled_ns)?;
        }
        if let Some(modes) = &tick.modes {
            publisher.modes.publish(&modes.into(), sampled_ns)?;
        }
        if let Some(first) = tick.innovations.first() {
            publisher.innovation.publish(&InnovationsPayload::new(first.time_s, &tick.innovations), sampled_ns)?;
        }
        let estimation = tick.estimation_events.iter().map(|event| EventKind::Estimation(*event));
        let regression = tick.regression_events.iter().map(|event| EventKind::Regression(*event));
        for kind in estimation.chain(regression) {
            publisher.event.publish(&(&EventRecord { time_s: publisher.newest_s, kind }).into(), sampled_ns)?;
        }
        Ok(())
    }

    fn output_error(&mut self, record: &OutputErrorRecord) -> Result<(), BusError> {
        self.publisher.output_error.publish(&record.into(), Some(self.header.sampled_ns)).map(|_| ())
    }

    fn finding(&mut self, record: &FindingRecord) -> Result<(), BusError> {
        self.publisher.finding.publish(&record.into(), Some(self.header.sampled_ns)).map(|_| ())
    }
}
