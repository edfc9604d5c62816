//! One message of a ULog, borrowed from the reader; nothing is copied.
//!
//! Time is microseconds since the autopilot started, of 64 bits: where a topic's own stamp is narrower, the reader continues it
//! across its wrap-arounds. ULog states no units: those are of each topic's definition in PX4.

use super::definition::{UlogFormat, UlogSubscription};
use super::keyed::{UlogKeyed, keyed};
use super::layout::{UlogLayout, UlogLeaf};
use super::state::UlogState;
use super::value::{UlogValue, UlogValues};
use std::borrow::Cow;

/// A message.
#[derive(Clone, Copy, Debug)]
pub enum UlogMessage<'a> {
    /// The flags behind the header: compatible, incompatible.
    Flags {
        /// Bits that a reader may ignore.
        compatible: [u8; 8],
        /// Bits that a reader must know.
        incompatible: [u8; 8],
    },
    /// A format was defined.
    Format(&'a UlogFormat),
    /// Information, of which the log has one with that key.
    Information(UlogKeyed<'a>),
    /// Information that may come in parts and more than once with one key.
    MultiInformation {
        /// Whether it continues the one before with the same key.
        continued: bool,
        /// Key and value.
        keyed: UlogKeyed<'a>,
    },
    /// A parameter, at the start or where it changes.
    Parameter(UlogKeyed<'a>),
    /// The default of a parameter.
    DefaultParameter {
        /// Bit 0: of the system, bit 1: of the vehicle's configuration.
        types: u8,
        /// Key and value.
        keyed: UlogKeyed<'a>,
    },
    /// A topic is logged from here on.
    Subscription(&'a UlogSubscription),
    /// A topic is not logged any more.
    Removed {
        /// Its id.
        id: u16,
    },
    /// Data of a topic.
    Data(UlogData<'a>),
    /// Text.
    Logged(UlogText<'a>),
    /// A place where a reader can begin.
    Sync,
    /// The logger lost messages.
    Dropout {
        /// For so long.
        duration_ms: u16,
    },
}

impl<'a> UlogMessage<'a> {
    /// The message that a payload is, once the state has taken it in.
    pub(super) fn of(state: &'a UlogState, kind: u8, payload: &'a [u8], at: u64, time_us: Option<u64>) -> Option<Self> {
        let id = u16::from_le_bytes(*payload.first_chunk()?);
        let first = *payload.first()?;
        Some(match kind {
            b'B' => UlogMessage::Flags { compatible: *payload.first_chunk()?, incompatible: *payload.get(8..)?.first_chunk()? },
            b'F' => {
                let name = payload.split(|byte| *byte == b':').next().and_then(|name| std::str::from_utf8(name).ok())?;
                UlogMessage::Format(state.formats.get(name)?)
            }
            b'I' => UlogMessage::Information(keyed(payload)?),
            b'P' => UlogMessage::Parameter(keyed(payload)?),
            b'M' => UlogMessage::MultiInformation { continued: first != 0, keyed: keyed(payload.get(1..)?)? },
            b'Q' => UlogMessage::DefaultParameter { types: first, keyed: keyed(payload.get(1..)?)? },
            b'A' => {
                let id = u16::from_le_bytes(*payload.get(1..)?.first_chunk()?);
                UlogMessage::Subscription(state.subscriptions.get(&id)?)
            }
            b'R' => UlogMessage::Removed { id },
            b'O' => UlogMessage::Dropout { duration_ms: id },
            b'S' => UlogMessage::Sync,
            b'L' | b'C' => {
                let (tag, rest) = payload.get(1..)?.split_at_checked(if kind == b'C' { 2 } else { 0 })?;
                let tag = tag.first_chunk().map(|tag| u16::from_le_bytes(*tag));
                let (time, bytes) = rest.split_first_chunk()?;
                UlogMessage::Logged(UlogText { level: first, tag, time_us: u64::from_le_bytes(*time), bytes })
            }
            b'D' => {
                let subscription = state.subscriptions.get(&id)?;
                let layout = state.layouts.get(subscription.layout)?;
                UlogMessage::Data(UlogData { subscription, layout, time_us, bytes: payload.get(2..)?, at })
            }
            _ => return None,
        })
    }
}

/// A line of text.
#[derive(Clone, Copy, Debug)]
pub struct UlogText<'a> {
    /// Level, the character `0` (emergency) to `7` (debug).
    pub level: u8,
    /// Who wrote it, where the log says so.
    pub tag: Option<u16>,
    /// When, us.
    pub time_us: u64,
    /// What, as bytes.
    pub bytes: &'a [u8],
}

impl<'a> UlogText<'a> {
    /// What, with replacement characters for bytes that are no UTF-8.
    pub fn text(&self) -> Cow<'a, str> {
        String::from_utf8_lossy(self.bytes)
    }
}

/// Data of a topic at one time.
#[derive(Clone, Copy, Debug)]
pub struct UlogData<'a> {
    pub(super) subscription: &'a UlogSubscription,
    pub(super) layout: &'a UlogLayout,
    pub(super) time_us: Option<u64>,
    pub(super) bytes: &'a [u8],
    pub(super) at: u64,
}

/// A field of data.
#[derive(Clone, Copy, Debug)]
pub struct UlogReading<'a> {
    /// Its name, with those of the fields that it is in.
    pub name: &'a str,
    /// Whether it is an array, be it of one.
    pub is_array: bool,
    /// Its values.
    pub values: UlogValues<'a>,
}

impl<'a> UlogData<'a> {
    /// Name of the topic.
    pub fn name(&self) -> &'a str {
        &self.subscription.name
    }

    /// Which of several instruments, from 0.
    pub fn multi_id(&self) -> u8 {
        self.subscription.multi_id
    }

    /// The subscription.
    pub fn subscription(&self) -> &'a UlogSubscription {
        self.subscription
    }

    /// The layout.
    pub fn layout(&self) -> &'a UlogLayout {
        self.layout
    }

    /// Where the message began, bytes from the start of the log.
    pub fn at(&self) -> u64 {
        self.at
    }

    /// Its time stamp, us; `None` where the topic has none.
    pub fn time_us(&self) -> Option<u64> {
        self.time_us
    }

    /// Its fields in their order, without what fills up.
    pub fn fields(&self) -> impl Iterator<Item = UlogReading<'a>> + use<'a> {
        let data = *self;
        data.layout.leaves.iter().filter(|leaf| !leaf.padding).filter_map(move |leaf| {
            Some(UlogReading { name: &leaf.name, is_array: leaf.array.is_some(), values: data.values(leaf)? })
        })
    }

    /// The values of the field of that name.
    pub fn field(&self, name: &str) -> Option<UlogValues<'a>> {
        self.values(self.layout.leaf(name)?)
    }

    /// The one value of the field of that name, or the first.
    pub fn number(&self, name: &str) -> Option<f64> {
        self.field(name)?.get(0).map(UlogValue::number)
    }

    fn values(&self, leaf: &UlogLeaf) -> Option<UlogValues<'a>> {
        let bytes = self.bytes.get(leaf.offset..leaf.offset.checked_add(leaf.size())?)?;
        Some(UlogValues::new(leaf.kind, bytes))
    }
}
