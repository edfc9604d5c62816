//! ArduPilot dataflash logs: self-describing binary messages without checksums.
//!
//! In: bytes in pieces of any size ([`reader`]). Out: messages ([`message`]) whose layout the log itself gives by FMT
//! ([`mod@format`]), with units and multipliers by FMTU, UNIT and MULT ([`mod@unit`]), values by format character ([`field`]).
//! Assumed: little-endian bytes; a message is A3 95, a type, and as many bytes as its FMT says; FMT itself is type 128, 89
//! bytes.
//! Refused and counted: bytes in no message, messages of a type that no FMT defined, definitions that contradict themselves.
//! Source: ArduPilot, AP_Logger, README (format types, units, multipliers) and LogStructure.h, version 4.5.

pub mod error;
pub mod field;
pub mod format;
pub mod message;
pub mod reader;
pub mod tally;
pub mod unit;

#[cfg(test)]
mod reader_tests;
