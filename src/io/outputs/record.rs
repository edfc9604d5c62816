//! The published vocabulary of outputs: one message, as it passes through the queue to log and terminal.

use crate::flight::sample::Sample;
#[cfg(feature = "std")]
use crate::postflight::diagnosis::record::FindingRecord;
#[cfg(feature = "std")]
use crate::postflight::output_error::record::OutputErrorRecord;
use crate::realtime::estimation::record::{EstimationEvent, Innovation, LaggedRecord, StateRecord};
use crate::realtime::modes::record::ModesRecord;
use crate::realtime::regression::record::{DerivativesRecord, RegressionEvent};

/// Something that a stage noticed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum EventKind {
    /// In the state estimation.
    Estimation(EstimationEvent),
    /// In the regression.
    Regression(RegressionEvent),
}

/// An event with its time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EventRecord {
    /// When, s.
    pub time_s: f64,
    /// What.
    pub kind: EventKind,
}

/// One message to the outputs, of fixed size: sending it moves bytes and allocates nothing.
#[derive(Clone, Debug, PartialEq)]
#[expect(clippy::large_enum_variant, reason = "fixed size on purpose: a box would allocate between sample and estimate")]
pub enum Message {
    /// A sample as it came in.
    Sample(Sample),
    /// The state at a sample.
    State(StateRecord),
    /// The smoothed state of a while ago.
    Smoothed(LaggedRecord),
    /// What an aid did.
    Innovation(Innovation),
    /// The derivatives so far.
    Derivatives(DerivativesRecord),
    /// The modes so far.
    Modes(ModesRecord),
    /// Output error so far.
    #[cfg(feature = "std")]
    OutputError(OutputErrorRecord),
    /// What the diagnosis says.
    #[cfg(feature = "std")]
    Finding(FindingRecord),
    /// An event.
    Event(EventRecord),
}
