//! Payload of the estimator's acknowledgement of samples that request one.

use super::message::{MessageHeader, service};
use iceoryx2::prelude::ZeroCopySend;

/// How far the estimator has come: its answer to samples that ask for one.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, ZeroCopySend)]
#[type_name("sideslip.Taken.1")]
pub struct AcknowledgementPayload {
    /// Its own header.
    pub header: MessageHeader,
    /// Incarnation of the telemetry whose samples were taken.
    pub of_incarnation: u64,
    /// How many of its samples were taken, in order.
    pub taken: u64,
}
service!(AcknowledgementPayload, "sideslip/taken", "sideslip.Taken.1", buffer 64, history 1);
