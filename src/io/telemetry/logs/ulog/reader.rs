//! Messages of a ULog from bytes that arrive in pieces of any size, with damage between them.
//!
//! Consumes bytes; produces every whole message in order. In step, a message begins where the one before ended; it is believed
//! where its payload agrees with what the log has defined and a plausible header, or the end, follows it (messages of unknown
//! kinds of at most 4096 bytes, up to four, may stand between). One that nothing plausible follows is counted and not handed
//! on: bytes may be missing within it. Out of step, byte by byte, a synchronisation message is taken up, or any other whose
//! content can be verified (data with a subscribed id and the size of its format; definitions and text that are well formed).
//! Appended data begin in step at the offsets that the flags give; what stands before them may be cut. Memory: one buffer of
//! [`BUFFER`] bytes and the definitions.
//! Source: PX4 User Guide, "ULog File Format".

use super::definition::beginning;
use super::error::UlogError;
use super::message::UlogMessage;
use super::shape::{HEADER, LONG, fits, header, sizes};
use super::state::{UlogAgreement, UlogState};
use super::tally::{UlogTally, UlogTruncation};
use crate::io::telemetry::byte_window::ByteWindow;

/// Bytes that are kept at most: a message of any size and those that prove it.
pub const BUFFER: usize = 128 << 10;

const MAGIC: [u8; 7] = [0x55, 0x4C, 0x6F, 0x67, 0x01, 0x12, 0x35];
const FILE_HEADER: usize = 16;
const APPENDED: u8 = 1;
/// Messages of unknown kinds that may stand between a message and the one that proves it.
const HOPS: usize = 4;

/// What the bytes behind a message say of it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Followed {
    Plausibly,
    Otherwise,
    NotYet,
}

#[derive(Clone, Copy, Debug)]
struct UlogSpan {
    at: u64,
    size: usize,
    kind: u8,
    time_us: Option<u64>,
}

impl UlogSpan {
    fn payload<'a>(&self, bytes: &'a ByteWindow) -> &'a [u8] {
        bytes.at(self.at + HEADER as u64, self.size).unwrap_or_default()
    }
}

/// The 16 bytes that a ULog begins with.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct UlogHeader {
    /// Version of the format; 1 is known, others are read all the same.
    pub version: u8,
    /// When logging began, us since start.
    pub start_us: u64,
}

/// Reads messages.
pub struct UlogReader {
    bytes: ByteWindow,
    in_step: bool,
    header: Option<UlogHeader>,
    refused: Option<UlogError>,
    /// Where appended data begin, the nearest last.
    sections: Vec<u64>,
    state: UlogState,
    tally: UlogTally,
}

impl std::fmt::Debug for UlogReader {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("UlogReader").field("position", &self.bytes.position()).field("tally", &self.tally).finish_non_exhaustive()
    }
}

impl Default for UlogReader {
    fn default() -> Self {
        UlogReader::new()
    }
}

impl UlogReader {
    /// Nothing read yet.
    pub fn new() -> Self {
        UlogReader {
            bytes: ByteWindow::new(BUFFER),
            in_step: true,
            header: None,
            refused: None,
            sections: Vec::new(),
            state: UlogState::default(),
            tally: UlogTally::default(),
        }
    }

    /// Takes in what there is room for and says how many bytes that was; at least one where
    /// [`next_message`](Self::next_message) has just given `None`.
    pub fn take(&mut self, bytes: &[u8]) -> usize {
        self.bytes.take(bytes)
    }

    /// The next message in what was taken in; `None` where more bytes are needed.
    ///
    /// # Errors
    /// [`UlogError`] where it is no ULog, or one that must not be read; then again at every call.
    pub fn next_message(&mut self) -> Result<Option<UlogMessage<'_>>, UlogError> {
        self.proceed(false)
    }

    /// The next message where no more bytes will come; `None` after the last.
    ///
    /// # Errors
    /// As [`next_message`](Self::next_message), and where not even the header is whole.
    pub fn last_message(&mut self) -> Result<Option<UlogMessage<'_>>, UlogError> {
        self.proceed(true)
    }

    /// The header, once it was read.
    pub fn header(&self) -> Option<UlogHeader> {
        self.header
    }

    /// What was found so far.
    pub fn tally(&self) -> &UlogTally {
        &self.tally
    }

    fn proceed(&mut self, ended: bool) -> Result<Option<UlogMessage<'_>>, UlogError> {
        if let Some(error) = &self.refused {
            return Err(error.clone());
        }
        if self.header.is_none() && !self.read_header(ended).map_err(|error| self.refuse(error))? {
            return Ok(None);
        }
        let found = self.search(ended).map_err(|error| self.refuse(error))?;
        Ok(found.and_then(|found| self.message(found)))
    }

    fn refuse(&mut self, error: UlogError) -> UlogError {
        self.refused = Some(error.clone());
        error
    }

    fn read_header(&mut self, ended: bool) -> Result<bool, UlogError> {
        let window = self.bytes.bytes();
        // What is refused, and how that is said, must not depend on the pieces that the bytes come in.
        if window.len() < MAGIC.len() && !ended {
            return Ok(false);
        }
        let shown = window.len().min(MAGIC.len());
        if window.get(..shown) != MAGIC.get(..shown) {
            return Err(UlogError::Magic { found: window.get(..shown).unwrap_or_default().to_vec() });
        }
        let Some(bytes) = window.first_chunk::<FILE_HEADER>() else {
            let found = window.len();
            return if ended { Err(UlogError::HeaderCut { found }) } else { Ok(false) };
        };
        let [.., version, a, b, c, d, e, f, g, h] = *bytes;
        let start_us = u64::from_le_bytes([a, b, c, d, e, f, g, h]);
        self.header = Some(UlogHeader { version, start_us });
        self.state.start(start_us);
        self.bytes.advance(FILE_HEADER);
        Ok(true)
    }

    /// What is there up to the next section, and whether nothing more will come before it.
    fn window(&self, ended: bool) -> (&[u8], bool) {
        let window = self.bytes.bytes();
        let limit = self.sections.last().map(|section| section.saturating_sub(self.bytes.position()));
        match limit.and_then(|limit| window.get(..usize::try_from(limit).ok()?)) {
            Some(window) => (window, true),
            None => (window, ended),
        }
    }

    fn search(&mut self, ended: bool) -> Result<Option<UlogSpan>, UlogError> {
        loop {
            if self.sections.last() == Some(&self.bytes.position()) {
                self.sections.pop();
                self.tally.appended_sections += 1;
                self.in_step = true;
            }
            let (window, closed) = self.window(ended);
            if window.is_empty() {
                return Ok(None);
            }
            let Some((size, kind)) = header(window) else {
                if !closed {
                    return Ok(None);
                }
                self.no_message(closed);
                continue;
            };
            let length = HEADER + size;
            let agreement = if self.in_step { self.agreement(window, size, kind) } else { self.verified(window, size, kind) };
            let Some(agreement) = agreement.filter(|agreement| *agreement != UlogAgreement::WrongSize) else {
                self.tally.wrong_size += u64::from(agreement.is_some());
                self.lose_step();
                self.pass_over();
                continue;
            };
            if window.len() < length {
                if !closed {
                    return Ok(None);
                }
                self.no_message(closed);
                continue;
            }
            match self.followed(window, length, closed) {
                Followed::NotYet => return Ok(None),
                Followed::Plausibly => {}
                Followed::Otherwise => {
                    self.tally.doubtful += u64::from(self.in_step && agreement == UlogAgreement::Good && sizes(kind).is_some());
                    self.lose_step();
                    self.pass_over();
                    continue;
                }
            }
            if !std::mem::replace(&mut self.in_step, true) {
                self.tally.resynchronised += 1;
            }
            let found = UlogSpan { at: self.bytes.position(), size, kind, time_us: None };
            self.bytes.advance(length);
            if let Some(found) = self.accept(found, agreement)? {
                return Ok(Some(found));
            }
        }
    }

    /// What a message in step is, as far as it is there; `None` where its header shows that it is none.
    fn agreement(&self, window: &[u8], size: usize, kind: u8) -> Option<UlogAgreement> {
        if sizes(kind).is_none() {
            return (size > 0 && size <= LONG && kind != 0).then_some(UlogAgreement::Good);
        }
        if !fits(size, kind) {
            return None;
        }
        let rest = window.get(HEADER..).unwrap_or_default();
        Some(match (kind, rest.first_chunk(), rest.get(..size)) {
            (b'D', Some(id), _) => self.state.data_size(u16::from_le_bytes(*id), size),
            (b'D', None, _) | (_, _, None) => UlogAgreement::Good,
            (_, _, Some(payload)) => self.state.agrees(kind, payload),
        })
    }

    /// The same out of step: `None` also where its content proves nothing.
    fn verified(&self, window: &[u8], size: usize, kind: u8) -> Option<UlogAgreement> {
        if !fits(size, kind) || size > LONG || matches!(kind, b'B' | b'R' | b'O') {
            return None;
        }
        let good = |good: bool| good.then_some(UlogAgreement::Good);
        let rest = window.get(HEADER..).unwrap_or_default();
        match (kind, rest.first_chunk(), rest.get(..size)) {
            (b'D', Some(id), _) => good(self.state.data_size(u16::from_le_bytes(*id), size) == UlogAgreement::Good),
            (b'L' | b'C', Some([level, _]), Some(payload)) => {
                good((b'0'..=b'7').contains(level) && payload.get(11..).is_some_and(<[u8]>::is_ascii))
            }
            (_, _, Some(payload)) => good(self.state.agrees(kind, payload) == UlogAgreement::Good),
            _ => good(true),
        }
    }

    /// What stands behind the message at the start of the window.
    fn followed(&self, window: &[u8], length: usize, closed: bool) -> Followed {
        let mut rest = window.get(length..).unwrap_or_default();
        for _ in 0..=HOPS {
            let Some((size, kind)) = header(rest) else {
                return if closed { Followed::Plausibly } else { Followed::NotYet };
            };
            if fits(size, kind) {
                return Followed::Plausibly;
            }
            if sizes(kind).is_some() || size == 0 || size > LONG || kind == 0 {
                return Followed::Otherwise;
            }
            rest = match rest.get(HEADER + size..) {
                Some(rest) => rest,
                None if closed => return Followed::Otherwise,
                None => return Followed::NotYet,
            };
        }
        Followed::Otherwise
    }

    /// The bytes at the start are no whole message, and no more come before the end or the next section. In step that is a
    /// message cut short, unless whole ones begin within it: then its size is damaged.
    fn no_message(&mut self, closed: bool) {
        let (window, _) = self.window(closed);
        let found = window.len();
        if !self.in_step || (1..found).any(|before| self.proven(window.get(before..).unwrap_or_default(), closed)) {
            self.lose_step();
            return self.pass_over();
        }
        if self.sections.is_empty() {
            let (expected, kind) = header(window).map_or((0, None), |(size, kind)| (HEADER + size, Some(kind)));
            self.tally.truncated = Some(UlogTruncation { at: self.bytes.position(), kind, found, expected });
        } else {
            self.tally.cut_at_section += 1;
        }
        self.bytes.advance(found);
    }

    /// Whether a whole message that would be taken up out of step stands there.
    fn proven(&self, window: &[u8], closed: bool) -> bool {
        let Some((size, kind)) = header(window) else { return false };
        window.len() >= HEADER + size
            && self.verified(window, size, kind).is_some()
            && self.followed(window, HEADER + size, closed) == Followed::Plausibly
    }

    fn lose_step(&mut self) {
        if std::mem::replace(&mut self.in_step, false) {
            self.tally.first_damage_at.get_or_insert(self.bytes.position());
        }
    }

    fn pass_over(&mut self) {
        self.bytes.advance(1);
        self.tally.garbage_bytes += 1;
    }

    fn accept(&mut self, mut found: UlogSpan, agreement: UlogAgreement) -> Result<Option<UlogSpan>, UlogError> {
        let UlogSpan { kind, at, .. } = found;
        if sizes(kind).is_none() {
            self.tally.unknown_kinds += 1;
            return Ok(None);
        }
        self.tally.count(kind);
        let payload = found.payload(&self.bytes);
        match agreement {
            UlogAgreement::Good => {}
            UlogAgreement::Unsubscribed => {
                self.tally.unsubscribed += 1;
                return Ok(None);
            }
            UlogAgreement::WrongSize | UlogAgreement::Wrong => {
                self.tally.refused += 1;
                // The parser of a format says best what is wrong with it.
                if kind != b'F' || self.state.define(payload, at, &mut self.tally).is_some() {
                    self.tally.complain(UlogError::Content { at, kind: kind.into(), found: beginning(payload) });
                }
                return Ok(None);
            }
        }
        let first_two = payload.first_chunk().map(|bytes| u16::from_le_bytes(*bytes)).unwrap_or_default();
        let whole = match kind {
            b'B' => return self.flags(found).map(|good| good.then_some(found)),
            b'F' => self.state.define(payload, at, &mut self.tally).is_some(),
            b'A' => self.state.subscribe(payload, at, &mut self.tally).is_some(),
            b'R' => self.state.subscriptions.remove(&first_two).is_some(),
            b'O' => {
                self.tally.dropouts += 1;
                self.tally.dropout_ms += u64::from(first_two);
                true
            }
            b'D' => {
                let time = self.state.time(first_two, payload.get(2..).unwrap_or_default());
                self.tally.backward += u64::from(time.is_some_and(|(_, backward)| backward));
                found.time_us = time.map(|(time_us, _)| time_us);
                true
            }
            _ => true,
        };
        Ok(whole.then_some(found))
    }

    fn flags(&mut self, found: UlogSpan) -> Result<bool, UlogError> {
        let UlogSpan { at, .. } = found;
        if at != FILE_HEADER as u64 {
            self.tally.misplaced_flags += 1;
            return Ok(false);
        }
        let payload = found.payload(&self.bytes);
        let incompatible = payload.get(8..16).unwrap_or_default();
        for (index, bits) in incompatible.iter().enumerate() {
            let unknown = bits & !if index == 0 { APPENDED } else { 0 };
            if unknown != 0 {
                return Err(UlogError::Incompatible { at, index, found: unknown });
            }
        }
        if incompatible.first().is_some_and(|bits| bits & APPENDED != 0) {
            let offsets = payload.get(16..40).unwrap_or_default().chunks_exact(8);
            let offsets = offsets.filter_map(|bytes| bytes.first_chunk().map(|bytes| u64::from_le_bytes(*bytes)));
            let mut behind = self.bytes.position();
            for offset in offsets.filter(|offset| *offset != 0) {
                if offset <= behind {
                    self.tally.complain(UlogError::Offset { at, offset });
                } else {
                    behind = offset;
                    self.sections.insert(0, offset);
                }
            }
        }
        Ok(true)
    }

    fn message(&self, found: UlogSpan) -> Option<UlogMessage<'_>> {
        UlogMessage::of(&self.state, found.kind, found.payload(&self.bytes), found.at, found.time_us)
    }
}
