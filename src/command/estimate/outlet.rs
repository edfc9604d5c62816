//! The estimator's way out to shared memory: what each sample brought, on its service.

use sideslip::bus::clock::monotonic_ns;
use sideslip::bus::error::BusError;
use sideslip::bus::payload::{
    DerivativesPayload, EventPayload, FindingPayload, Header, InnovationsPayload, ModesPayload, OutputErrorPayload,
    SAMPLE_TO_ACKNOWLEDGE, SamplePayload, SmoothedPayload, StatePayload, THE_END, TakenPayload,
};
use sideslip::bus::service::{Bus, Publisher};
use sideslip::diagnosis::record::FindingRecord;
use sideslip::identification::record::OutputErrorRecord;
use sideslip::outputs::record::{EventKind, EventRecord};
use sideslip::pipeline::Tick;

/// Between two signs of life.
const SIGN_OF_LIFE_NS: u64 = 100_000_000;

/// One publisher a service.
pub(crate) struct Outlet {
    state: Publisher<StatePayload>,
    smoothed: Publisher<SmoothedPayload>,
    innovation: Publisher<InnovationsPayload>,
    derivatives: Publisher<DerivativesPayload>,
    modes: Publisher<ModesPayload>,
    output_error: Publisher<OutputErrorPayload>,
    finding: Publisher<FindingPayload>,
    event: Publisher<EventPayload>,
    taken: Publisher<TakenPayload>,
    newest_s: f64,
    said_taken_ns: u64,
}

impl Outlet {
    /// Every publisher of the estimator; all memory is taken here.
    pub(crate) fn new(bus: &Bus) -> Result<Self, BusError> {
        Ok(Outlet {
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
    pub(crate) fn meet(&mut self) -> Result<(), BusError> {
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

    /// What a sample brought; `sample` is the header that it came with. Derivatives go before modes, so that a reader
    /// who has modes finds their derivatives.
    pub(crate) fn tick(&mut self, sample: &Header, tick: &Tick) -> Result<(), BusError> {
        let sampled_ns = Some(sample.sampled_ns);
        if sample.time_s.is_finite() {
            self.newest_s = sample.time_s;
        }
        if let Some(state) = &tick.state {
            self.state.publish(&state.into(), sampled_ns)?;
        }
        if let Some(smoothed) = &tick.smoothed {
            self.smoothed.publish(&smoothed.into(), sampled_ns)?;
        }
        if let Some(derivatives) = &tick.derivatives {
            self.derivatives.publish(&derivatives.into(), sampled_ns)?;
        }
        if let Some(modes) = &tick.modes {
            self.modes.publish(&modes.into(), sampled_ns)?;
        }
        if let Some(first) = tick.innovations.first() {
            self.innovation.publish(&InnovationsPayload::new(first.time_s, &tick.innovations), sampled_ns)?;
        }
        let estimation = tick.estimation_events.iter().map(|event| EventKind::Estimation(*event));
        let regression = tick.regression_events.iter().map(|event| EventKind::Regression(*event));
        for kind in estimation.chain(regression) {
            self.event.publish(&(&EventRecord { time_s: self.newest_s, kind }).into(), sampled_ns)?;
        }
        Ok(())
    }

    /// What output error came to.
    pub(crate) fn output_error(&mut self, sample: &Header, record: &OutputErrorRecord) -> Result<(), BusError> {
        self.output_error.publish(&record.into(), Some(sample.sampled_ns)).map(|_| ())
    }

    /// What the diagnosis says.
    pub(crate) fn finding(&mut self, sample: &Header, record: &FindingRecord) -> Result<(), BusError> {
        self.finding.publish(&record.into(), Some(sample.sampled_ns)).map(|_| ())
    }

    /// Says that a sample was taken: each, where its publisher waits for that; else now and then, as a sign of life.
    pub(crate) fn taken(&mut self, sample: &SamplePayload) -> Result<(), BusError> {
        let now_ns = monotonic_ns();
        let due = now_ns.saturating_sub(self.said_taken_ns) >= SIGN_OF_LIFE_NS;
        if due || sample.kind == SAMPLE_TO_ACKNOWLEDGE || sample.kind == THE_END {
            self.said_taken_ns = now_ns;
            let Header { incarnation, sequence, sampled_ns, time_s, .. } = sample.header;
            let header = Header { time_s, ..Header::default() };
            let taken = TakenPayload { header, of_incarnation: incarnation, taken: sequence + 1 };
            self.taken.publish(&taken, Some(sampled_ns))?;
        }
        Ok(())
    }
}
