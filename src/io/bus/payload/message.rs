//! Common part of all messages: the header, the service of each type, and checks of indices, flags and texts on reading.

use crate::io::bus::error::BusError;
use iceoryx2::prelude::ZeroCopySend;
use std::fmt::Debug;

/// In place of an index: there is none.
pub const ABSENT: u32 = u32::MAX;

/// What every message begins with.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, ZeroCopySend)]
#[type_name("sideslip.Header.1")]
pub struct MessageHeader {
    /// Counts the messages of this service from one publisher, from 0.
    pub sequence: u64,
    /// Which life of the publisher: the monotonic clock when it began, ns. A later life has the larger number.
    pub incarnation: u64,
    /// Time of the sample that it rests on, s, on the recording's own clock.
    pub time_s: f64,
    /// When that sample came onto the bus, monotonic clock, ns.
    pub sampled_ns: u64,
    /// When this message came onto the bus, monotonic clock, ns.
    pub published_ns: u64,
}

/// A message of a service.
pub trait Payload: ZeroCopySend + Copy + Debug + 'static {
    /// The service's name.
    const SERVICE: &'static str;
    /// The schema with its version: the type's name on the bus.
    const SCHEMA: &'static str;
    /// Messages that a subscriber can be behind before it loses the oldest.
    const BUFFER: usize;
    /// Messages that a subscriber gets which comes later than they did.
    const HISTORY: usize;
    /// What it begins with.
    fn header(&self) -> &MessageHeader;
    /// What it begins with, to be filled in by the publisher.
    fn header_mut(&mut self) -> &mut MessageHeader;
}

/// Gives a payload its place on the bus.
macro_rules! service {
    ($payload:ty, $service:literal, $schema:literal, buffer $buffer:expr, history $history:expr) => {
        impl $crate::io::bus::payload::message::Payload for $payload {
            const SERVICE: &'static str = $service;
            const SCHEMA: &'static str = $schema;
            const BUFFER: usize = $buffer;
            const HISTORY: usize = $history;
            fn header(&self) -> &$crate::io::bus::payload::message::MessageHeader {
                &self.header
            }
            fn header_mut(&mut self) -> &mut $crate::io::bus::payload::message::MessageHeader {
                &mut self.header
            }
        }
    };
}
pub(super) use service;

/// The entry of a table at an index that came from elsewhere.
pub(super) fn at<T: Copy>(table: &[T], index: u32, schema: &'static str, field: &'static str) -> Result<T, BusError> {
    let found = usize::try_from(index).ok().and_then(|index| table.get(index)).copied();
    found.ok_or(BusError::Payload { schema, field, expected: "a place in its table", found: index.into() })
}

/// A flag that came from elsewhere.
pub(super) fn flag(value: u32, schema: &'static str, field: &'static str) -> Result<bool, BusError> {
    match value {
        0 => Ok(false),
        1 => Ok(true),
        found => Err(BusError::Payload { schema, field, expected: "0 or 1", found: found.into() }),
    }
}

/// A text as it travels: UTF-8, zeros behind it.
pub(super) fn bytes_of<const N: usize>(text: &str) -> [u8; N] {
    let mut bytes = [0; N];
    bytes.iter_mut().zip(text.as_bytes()).for_each(|(to, from)| *to = *from);
    bytes
}

/// The text of so many bytes that came from elsewhere.
pub(super) fn text_of<'a>(bytes: &'a [u8], count: u32, schema: &'static str, field: &'static str) -> Result<&'a str, BusError> {
    let text = usize::try_from(count).ok().and_then(|count| core::str::from_utf8(bytes.get(..count)?).ok());
    text.ok_or(BusError::Payload { schema, field, expected: "a text of so many bytes", found: count.into() })
}

/// A place in a table as it travels; every table here is short.
pub(super) fn place(index: usize) -> u32 {
    u32::try_from(index).unwrap_or(ABSENT)
}
