//! Messages in shared memory: `#[repr(C)]` copies of the records without padding or pointers, every field of fixed size.
//!
//! The version of the schema is part of the type's name (`sideslip.Sample.1`): the middleware compares name, size and alignment
//! only, so a change of a field's meaning requires a new number. An `f64` keeps its bits, those of NaN included. A row of a table
//! (channel, axis, aid) is transmitted as its index, absence as [`ABSENT`]. Every index is checked on reading, because the memory
//! is written by another process.

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
