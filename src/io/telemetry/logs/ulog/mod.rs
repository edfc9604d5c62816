//! PX4 ULog files: self-describing messages of an autopilot's topics.
//!
//! In: bytes in pieces of any size ([`reader`]). Out: messages ([`message`]): data of subscribed topics with the fields that
//! their format defines ([`definition`], [`layout`], [`value`]), information, parameters, logged text, dropouts.
//! Assumed: little-endian bytes; a message is its size (2 bytes, without the header), its type (1), its payload.
//! Refused: what does not begin as a ULog does, and a file whose incompatible flags are not known: it must not be read. Refused
//! and counted: damaged bytes, messages that contradict their definition, definitions that are too large or contain themselves.
//! Source: PX4 User Guide, "ULog File Format", file version 1, main branch of 2024 (with default parameters and tagged text).

pub mod definition;
pub mod error;
pub mod keyed;
pub mod layout;
pub mod message;
pub mod reader;
mod shape;
pub mod tally;
pub mod value;

mod state;

#[cfg(test)]
mod reader_tests;
