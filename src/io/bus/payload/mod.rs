//! What travels: plain `#[repr(C)]` copies of the records, no padding, no pointers, every field of a fixed size.
//!
//! The schema's version stands in the type's name (`sideslip.Sample.1`): the middleware compares name, size and alignment
//! and nothing else, so a change of a field's meaning must change the number. `f64` keep their bits, NaN payloads too.
//! A place in a table (channel, axis, aid) travels as its index, absence as [`ABSENT`]. Reading checks every index: memory
//! of another process is input like any other.

mod acknowledgement;
mod derivatives;
mod event;
mod finding;
mod message;
mod modes;
mod output_error;
mod sample;
mod state;
mod status;

pub use acknowledgement::AcknowledgementPayload;
pub use derivatives::{DerivativesPayload, EquationBody, TermBody};
pub use event::EventPayload;
pub use finding::FindingPayload;
pub use message::{ABSENT, MessageHeader, Payload};
pub use modes::ModesPayload;
pub use output_error::{OutputErrorPayload, ParameterBody};
pub use sample::{OTHERS, SAMPLE, SAMPLE_TO_ACKNOWLEDGE, SamplePayload, THE_END};
pub use state::{InnovationBody, InnovationsPayload, SmoothedPayload, StateBody, StatePayload};
pub use status::StatusBody;
