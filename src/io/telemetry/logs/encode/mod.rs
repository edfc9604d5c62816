//! Logs from values: both formats, and flights in either.
//!
//! In: definitions and values, or the samples of a flight. Out: bytes of a dataflash log ([`dataflash`]), of a ULog ([`ulog`]),
//! of samples as ArduPilot ([`sample_dataflash`]) and PX4 ([`sample_ulog`]) log them at the rates of [`sample_rates`], and of a
//! flight whose channels are known in closed form ([`flight`], for tests). Assumed: whoever writes means what he writes;
//! nothing is checked but what cannot be written.
//! Refused: values that do not fit their format.

pub mod dataflash;
pub mod flight;
pub mod sample_dataflash;
pub mod sample_rates;
pub mod sample_ulog;
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
    #[error("expected a time from 0 s on, found {0} s")]
    Time(f64),
    #[error("expected an altitude of -2000 to 11000 m, found {0} m")]
    Altitude(f64),
    #[error("a message of kind {kind:?} has at most 65535 bytes; found {found}")]
    Long { kind: char, found: usize },
}
