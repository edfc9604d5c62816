//! What a ULog has defined so far: formats, layouts, subscriptions; and whether a payload agrees with it.
//!
//! Consumes payloads of definitions; refuses those that contradict themselves or exceed what is kept ([`FORMATS_MAX`] formats,
//! [`TEXT_MAX`] bytes of their text).

use super::definition::{UlogFormat, UlogSubscription, beginning, printable};
use super::error::UlogError;
use super::keyed::keyed;
use super::layout::{LayoutBudget, UlogLayout};
use super::shape::SYNC;
use super::tally::UlogTally;
use super::value::UlogType;
use std::collections::BTreeMap;

/// Formats that are kept at most.
pub(super) const FORMATS_MAX: usize = 4096;
/// Bytes of the text of formats that are kept at most.
pub(super) const TEXT_MAX: usize = 4 << 20;

/// What a payload is, by what the log has defined.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum UlogAgreement {
    Good,
    /// Data of an id that nothing is subscribed to.
    Unsubscribed,
    /// Data of another size than its format has.
    WrongSize,
    /// Something that it should contain is missing.
    Wrong,
}

#[derive(Debug, Default)]
pub(super) struct UlogState {
    pub(super) formats: BTreeMap<Box<str>, UlogFormat>,
    text: usize,
    pub(super) layouts: Vec<UlogLayout>,
    /// Layout by name of the format, as the formats now are.
    current: BTreeMap<Box<str>, usize>,
    pub(super) subscriptions: BTreeMap<u16, UlogSubscription>,
    budget: LayoutBudget,
    /// Latest time of all data.
    newest_us: u64,
}

/// Whether the value has the size that its key states. An array in a key, unlike one in a format, may be empty: so an empty
/// line of text is logged.
fn agrees_keyed(payload: &[u8]) -> bool {
    let Some(keyed) = keyed(payload) else { return false };
    let (kind, elements) = match keyed.kind.strip_suffix(']').and_then(|kind| kind.split_once('[')) {
        Some((kind, elements)) => (kind, elements.parse::<usize>().ok()),
        None => (keyed.kind, Some(1)),
    };
    let size = UlogType::of(kind).map(UlogType::size);
    let agrees = |elements: usize| size.is_none_or(|size| size.saturating_mul(elements) == keyed.bytes.len());
    !keyed.key.is_empty() && elements.is_some_and(agrees)
}

impl UlogState {
    /// Whether data of that id can have that size with its id.
    pub(super) fn data_size(&self, id: u16, size: usize) -> UlogAgreement {
        let layout = self.subscriptions.get(&id).and_then(|subscription| self.layouts.get(subscription.layout));
        match layout {
            None => UlogAgreement::Unsubscribed,
            Some(layout) if (layout.least + 2..=layout.most + 2).contains(&size) => UlogAgreement::Good,
            Some(_) => UlogAgreement::WrongSize,
        }
    }

    /// Whether a whole payload is what its kind should contain.
    pub(super) fn agrees(&self, kind: u8, payload: &[u8]) -> UlogAgreement {
        let good = match kind {
            b'D' => {
                let Some(id) = payload.first_chunk().map(|id| u16::from_le_bytes(*id)) else { return UlogAgreement::Wrong };
                return self.data_size(id, payload.len());
            }
            b'F' => UlogFormat::parse(payload, 0).is_ok(),
            b'I' | b'P' => agrees_keyed(payload),
            b'M' | b'Q' => agrees_keyed(payload.get(1..).unwrap_or_default()),
            b'A' => payload.get(3..).and_then(printable).is_some_and(|name| !name.is_empty()),
            b'S' => payload == SYNC,
            _ => true,
        };
        if good { UlogAgreement::Good } else { UlogAgreement::Wrong }
    }

    pub(super) fn define(&mut self, text: &[u8], at: u64, tally: &mut UlogTally) -> Option<Box<str>> {
        let format = match UlogFormat::parse(text, at) {
            Ok(format) => format,
            Err(error) => {
                tally.complain(error);
                return None;
            }
        };
        let name = format.name.clone();
        match self.formats.get(&name) {
            Some(before) if *before == format => {
                tally.repeated_formats += 1;
                return Some(name);
            }
            Some(_) => {
                tally.redefinitions += 1;
                tally.complain(UlogError::Redefined { at, name: name.to_string() });
                // Whatever contains it is another from here on.
                self.current.clear();
            }
            None => {}
        }
        self.text += text.len();
        if self.formats.len() >= FORMATS_MAX || self.text > TEXT_MAX {
            tally.complain(UlogError::Limit { at, what: "formats, or bytes of their text", limit: FORMATS_MAX.max(TEXT_MAX) });
            return None;
        }
        self.formats.insert(name.clone(), format);
        Some(name)
    }

    fn layout(&mut self, name: &str, id: u16, at: u64) -> Result<usize, UlogError> {
        if let Some(place) = self.current.get(name) {
            return Ok(*place);
        }
        let format = self.formats.get(name).ok_or_else(|| UlogError::NoFormat { at, id, name: beginning(name.as_bytes()) })?;
        let layout = UlogLayout::build(format, &self.formats, &mut self.budget).map_err(|what| UlogError::Layout {
            at,
            id,
            name: name.into(),
            what,
        })?;
        let place = self.layouts.len();
        self.layouts.push(layout);
        self.current.insert(name.into(), place);
        Ok(place)
    }

    pub(super) fn subscribe(&mut self, payload: &[u8], at: u64, tally: &mut UlogTally) -> Option<u16> {
        let [multi_id, low, high] = *payload.first_chunk::<3>()?;
        let id = u16::from_le_bytes([low, high]);
        let name = printable(payload.get(3..)?)?;
        let layout = match self.layout(name, id, at) {
            Ok(layout) => layout,
            Err(error) => {
                tally.complain(error);
                return None;
            }
        };
        let subscription = UlogSubscription { id, multi_id, name: name.into(), layout, last_us: None };
        if let Some(before) = self.subscriptions.get(&id) {
            if (&before.name, before.multi_id, before.layout) == (&subscription.name, multi_id, layout) {
                return Some(id);
            }
            let (before, after) = (before.name.to_string(), name.to_string());
            tally.complain(UlogError::Resubscribed { at, id, before, after });
        }
        self.subscriptions.insert(id, subscription);
        Some(id)
    }

    /// Takes in the time of data of that id; its 64 bits, and whether it is earlier than before.
    pub(super) fn time(&mut self, id: u16, data: &[u8]) -> Option<(u64, bool)> {
        let subscription = self.subscriptions.get_mut(&id)?;
        let layout = self.layouts.get(subscription.layout)?;
        let leaf = layout.leaves.get(layout.timestamp?)?;
        let bytes = data.get(leaf.offset..)?;
        let (stamp, bits, factor) = match leaf.kind {
            UlogType::UInt64 => (u64::from_le_bytes(*bytes.first_chunk()?), 64, 1),
            UlogType::UInt32 => (u32::from_le_bytes(*bytes.first_chunk()?).into(), 32, 1),
            UlogType::UInt16 => (u16::from_le_bytes(*bytes.first_chunk()?).into(), 16, 1),
            UlogType::UInt8 => (u64::from(*bytes.first()?), 8, 1000),
            _ => return None,
        };
        let time_us = if bits == 64 {
            stamp
        } else {
            // The first stamp is the nearest to the newest time, later ones are the next after the one before.
            let range = 1_u64 << bits;
            let last = subscription.last_us.map(|last| last / factor);
            let ahead = |from: u64| stamp.wrapping_sub(from) % range;
            let whole = match last {
                Some(last) => last.saturating_add(ahead(last)),
                None => {
                    let newest = self.newest_us / factor;
                    let ahead = ahead(newest);
                    let later = newest.checked_add(ahead).filter(|_| ahead < range / 2 || newest < range - ahead);
                    later.unwrap_or_else(|| newest.saturating_sub(range - ahead))
                }
            };
            whole.saturating_mul(factor)
        };
        let backward = subscription.last_us.replace(time_us).is_some_and(|last| time_us < last);
        self.newest_us = self.newest_us.max(time_us);
        Some((time_us, backward))
    }

    /// Begins the clock of the log.
    pub(super) fn start(&mut self, time_us: u64) {
        self.newest_us = time_us;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn subscribed(kind: &str) -> UlogState {
        let mut state = UlogState::default();
        let mut tally = UlogTally::default();
        state.define(format!("t:{kind} timestamp;").as_bytes(), 0, &mut tally).unwrap();
        assert_eq!(state.subscribe(b"\0\x05\0t", 0, &mut tally), Some(5));
        assert_eq!(tally.complaints_total, 0);
        state
    }

    #[test]
    fn narrow_stamps_go_on_across_their_wrap_arounds() {
        let mut state = subscribed("uint16_t");
        state.start(200_000);
        let mut of = |stamp: u16| state.time(5, &stamp.to_le_bytes());
        // 200000 is 3 * 65536 + 3392.
        assert_eq!(of(3392), Some((200_000, false)));
        assert_eq!(of(65_535), Some((262_143, false)));
        assert_eq!(of(0), Some((262_144, false)));
        let mut state = subscribed("uint16_t");
        state.start(200_000);
        assert_eq!(state.time(5, &65_535_u16.to_le_bytes()), Some((196_607, false)));
        let mut state = subscribed("uint8_t");
        state.start(1_000_000);
        assert_eq!([state.time(5, &[233]), state.time(5, &[1])], [Some((1_001_000, false)), Some((1_025_000, false))]);
        // At the end of 64 bits the nearest later time does not exist: 2^64 - 1 ends in 65535, and the 5 before it is taken.
        let mut state = subscribed("uint16_t");
        state.start(u64::MAX);
        assert_eq!(state.time(5, &5_u16.to_le_bytes()), Some((u64::MAX - 65_530, false)));
    }

    #[test]
    fn a_wide_stamp_that_goes_back_is_seen() {
        let mut state = subscribed("uint64_t");
        let mut of = |stamp: u64| state.time(5, &stamp.to_le_bytes());
        assert_eq!([of(u64::MAX), of(7)], [Some((u64::MAX, false)), Some((7, true))]);
    }

    #[test]
    fn an_id_that_is_given_again_is_reported() {
        let mut state = subscribed("uint64_t");
        let mut tally = UlogTally::default();
        state.define(b"u:uint64_t timestamp;", 0, &mut tally);
        state.subscribe(b"\0\x05\0t", 1, &mut tally);
        assert_eq!(tally.complaints_total, 0);
        state.subscribe(b"\0\x05\0u", 2, &mut tally);
        assert!(matches!(tally.complaints[..], [UlogError::Resubscribed { at: 2, id: 5, .. }]));
        state.subscribe(b"\0\x06\0nothing", 3, &mut tally);
        assert!(matches!(tally.complaints.last(), Some(UlogError::NoFormat { id: 6, .. })));
    }
}
