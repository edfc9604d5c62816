//! Logs from values, for tests and demonstrations: both formats, and a simulated flight in either.
//!
//! In: definitions and values. Out: bytes of a dataflash log ([`dataflash`]), of a ULog ([`ulog`]), of a flight whose channels
//! are known in closed form ([`flight`]). Assumed: whoever writes means what he writes; nothing is checked but what cannot be
//! written.
//! Refused: values that do not fit their format.

pub mod dataflash;
pub mod flight;
pub mod ulog;

/// Why something cannot be written.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[expect(missing_docs, reason = "the message of each says what its fields are")]
pub enum LogEncodeError {
    #[error("type {kind} was not defined")]
    NotDefined { kind: u8 },
    #[error("the definition of type {kind} cannot be written: {what}")]
    Definition { kind: u8, what: String },
    #[error("{name} has {expected} columns; found {found} values")]
    Count { name: String, expected: usize, found: usize },
    #[error("{name}.{field}: {value} does not fit")]
    Value { name: String, field: String, value: String },
    #[error("a message of kind {kind:?} has at most 65535 bytes; found {found}")]
    Long { kind: char, found: usize },
}
