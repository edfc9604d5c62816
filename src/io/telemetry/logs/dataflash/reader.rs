//! Messages of a dataflash log from bytes that arrive in pieces of any size, with damage between them.
//!
//! Consumes bytes; produces every whole message in order. There are no checksums: what proves a message is that another header
//! (A3 95) or the end of the log follows it. One that is followed by something else is doubtful (bytes within it are missing,
//! or its type is damaged), and is counted and not handed on: a false message costs more than a lost one. The search then goes
//! on one byte after its header, and takes up the first message of a defined type that is followed so, an FMT only if it
//! contradicts nothing.
//! Memory: one buffer of [`BUFFER`] bytes and 256 definitions. A message waits for the three bytes behind it.
//! Source: ArduPilot, AP_Logger, LogStructure.h (header, FMT, FMTU, UNIT, MULT).

use super::error::DataflashError;
use super::field::{DataflashScale, DataflashValue};
use super::format::{DataflashFormat, DataflashRole, FMT_TYPE, HEADER};
use super::message::DataflashMessage;
use super::tally::{DataflashTally, DataflashTruncation};
use super::unit::DataflashUnits;
use crate::io::telemetry::byte_window::ByteWindow;

/// Bytes that are kept at most.
pub const BUFFER: usize = 16 << 10;

const MARK: [u8; 2] = [0xA3, 0x95];

/// What the bytes behind a message say of it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Behind {
    /// A header, or the end.
    Header,
    /// Something else.
    Other,
    /// Not yet known.
    Unknown,
}

/// Where a message stands in the log, and its length with its header.
#[derive(Clone, Copy, Debug)]
struct DataflashSpan {
    at: u64,
    length: usize,
    kind: u8,
}

/// Reads messages.
pub struct DataflashReader {
    window: ByteWindow,
    in_step: bool,
    formats: Vec<Option<DataflashFormat>>,
    units: DataflashUnits,
    /// Time of the last message by type and instrument (the first 16).
    times: Vec<Option<u64>>,
    tally: DataflashTally,
}

impl std::fmt::Debug for DataflashReader {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("DataflashReader")
            .field("position", &self.window.position())
            .field("tally", &self.tally)
            .finish_non_exhaustive()
    }
}

impl Default for DataflashReader {
    fn default() -> Self {
        DataflashReader::new()
    }
}

/// Instruments of one type whose times are compared.
const INSTANCES: usize = 16;

impl DataflashReader {
    /// Nothing read yet.
    pub fn new() -> Self {
        let mut formats = vec![None; 256];
        if let Some(place) = formats.get_mut(usize::from(FMT_TYPE)) {
            *place = Some(DataflashFormat::of_fmt());
        }
        DataflashReader {
            window: ByteWindow::new(BUFFER),
            in_step: true,
            formats,
            units: DataflashUnits::default(),
            times: vec![None; 256 * INSTANCES],
            tally: DataflashTally::default(),
        }
    }

    /// Takes in what there is room for and says how many bytes that was; at least one where
    /// [`next_message`](Self::next_message) has just given `None`.
    pub fn take(&mut self, bytes: &[u8]) -> usize {
        self.window.take(bytes)
    }

    /// The next message in what was taken in; `None` where more bytes are needed.
    pub fn next_message(&mut self) -> Option<DataflashMessage<'_>> {
        let found = self.search(false)?;
        self.message(found)
    }

    /// The next message where no more bytes will come; `None` after the last.
    pub fn last_message(&mut self) -> Option<DataflashMessage<'_>> {
        let found = self.search(true)?;
        self.message(found)
    }

    /// What was found so far.
    pub fn tally(&self) -> &DataflashTally {
        &self.tally
    }

    /// The layouts that the log has defined so far.
    pub fn formats(&self) -> impl Iterator<Item = &DataflashFormat> {
        self.formats.iter().flatten()
    }

    /// The units and multipliers that the log has defined so far.
    pub fn units(&self) -> &DataflashUnits {
        &self.units
    }

    fn message(&self, found: DataflashSpan) -> Option<DataflashMessage<'_>> {
        let format = self.formats.get(usize::from(found.kind))?.as_ref()?;
        let body = self.window.at(found.at, found.length).and_then(|message| message.get(HEADER..))?;
        Some(DataflashMessage { format, units: &self.units, body, at: found.at })
    }

    /// Length by definition of the message whose header stands there.
    fn length_at(&self, window: &[u8]) -> Option<usize> {
        let [first, second, kind] = *window.first_chunk::<HEADER>()?;
        let format = self.formats.get(usize::from(kind))?.as_ref()?;
        ([first, second] == MARK).then_some(usize::from(format.length))
    }

    fn behind(window: &[u8], length: usize, ended: bool) -> Behind {
        match window.get(length..) {
            Some([]) if ended => Behind::Header,
            Some([first]) if ended && *first == MARK[0] => Behind::Header,
            Some([first, second, ..]) if [*first, *second] == MARK => Behind::Header,
            None | Some([]) if !ended => Behind::Unknown,
            Some([first]) if !ended && *first == MARK[0] => Behind::Unknown,
            _ => Behind::Other,
        }
    }

    fn search(&mut self, ended: bool) -> Option<DataflashSpan> {
        loop {
            let window = self.window.bytes();
            if window.is_empty() || (window.len() < HEADER && !ended) {
                return None;
            }
            let Some(length) = self.length_at(window) else {
                self.no_message(ended);
                continue;
            };
            let kind = window.get(2).copied()?;
            if window.len() < length {
                if !ended {
                    return None;
                }
                self.no_message(ended);
                continue;
            }
            match Self::behind(window, length, ended) {
                Behind::Unknown => return None,
                Behind::Header if self.in_step || self.trusted(window, length) => {}
                Behind::Other if self.in_step => {
                    self.tally.doubtful += 1;
                    self.lose_step();
                    self.pass_over();
                    continue;
                }
                _ => {
                    self.no_message(ended);
                    continue;
                }
            }
            if !std::mem::replace(&mut self.in_step, true) {
                self.tally.resynchronised += 1;
            }
            let found = DataflashSpan { at: self.window.position(), length, kind };
            self.window.advance(length);
            self.tally.messages += 1;
            if self.accept(found) {
                return Some(found);
            }
        }
    }

    /// Whether a message out of step may be believed.
    fn trusted(&self, window: &[u8], length: usize) -> bool {
        let is_fmt = window.get(2) == Some(&FMT_TYPE);
        let body = window.get(HEADER..length).unwrap_or_default();
        !is_fmt || matches!(DataflashFormat::parse(body, 0), Ok((_, None)))
    }

    /// The byte at the start begins no message.
    fn no_message(&mut self, ended: bool) {
        let window = self.window.bytes();
        if self.in_step {
            let known = self.length_at(window);
            let marked = window.iter().zip(MARK).all(|(byte, mark)| *byte == mark);
            let kind = window.get(2).copied();
            if marked && ended && (known.is_some() || window.len() < HEADER) {
                let name =
                    kind.and_then(|kind| self.formats.get(usize::from(kind))?.as_ref()).map(|format| format.name.to_string());
                self.tally.truncated = Some(DataflashTruncation {
                    at: self.window.position(),
                    kind,
                    name: name.unwrap_or_default(),
                    found: window.len(),
                    expected: known.unwrap_or_default(),
                });
                let rest = window.len();
                self.window.advance(rest);
                return;
            }
            if marked {
                self.tally.unknown_types += 1;
            }
            self.lose_step();
        }
        self.pass_over();
    }

    fn lose_step(&mut self) {
        self.in_step = false;
        self.tally.first_damage_at.get_or_insert(self.window.position());
    }

    /// Drops bytes up to the next one that can begin a message.
    fn pass_over(&mut self) {
        let window = self.window.bytes();
        let next = window.iter().skip(1).position(|byte| *byte == MARK[0]).map_or(window.len(), |at| at + 1);
        self.window.advance(next);
        self.tally.garbage_bytes += next as u64;
    }

    /// Takes from a message what it defines; `false` where it cannot be read.
    fn accept(&mut self, found: DataflashSpan) -> bool {
        let Some(message) = self.message(found) else { return false };
        if message.format.fields.is_empty() && !message.body.is_empty() {
            self.tally.unreadable += 1;
            return false;
        }
        let role = message.format.role;
        let instance = message.instance().unwrap_or_default();
        if let (Some(time_us), Ok(instance)) = (message.time_us(), usize::try_from(instance))
            && instance < INSTANCES
            && let Some(last) = self.times.get_mut(usize::from(found.kind) * INSTANCES + instance)
            && last.replace(time_us).is_some_and(|before| time_us < before)
        {
            self.tally.backward += 1;
        }
        match role {
            DataflashRole::Fmt => self.define(found),
            DataflashRole::Fmtu => self.define_units(found),
            DataflashRole::Unit | DataflashRole::Mult => self.define_table(found, role),
            DataflashRole::Other => {}
        }
        true
    }

    fn define(&mut self, found: DataflashSpan) {
        let body = self.window.at(found.at, found.length).and_then(|message| message.get(HEADER..)).unwrap_or_default();
        let (format, warning) = match DataflashFormat::parse(body, found.at) {
            Ok(parsed) => parsed,
            Err(error) => return self.tally.complain(error),
        };
        let Some(place) = self.formats.get_mut(usize::from(format.kind)) else { return };
        match place {
            Some(before) if before.same_layout(&format) => {
                self.tally.repeated_formats += 1;
                return;
            }
            Some(before) => {
                let (before, after) = (before.words(), format.words());
                self.tally.redefinitions += 1;
                self.tally.complain(DataflashError::Redefined { at: found.at, kind: format.kind, before, after });
            }
            None => {}
        }
        if let Some(warning) = warning {
            self.tally.complain(warning);
        }
        *place = Some(format);
    }

    fn define_units(&mut self, found: DataflashSpan) {
        let Some(message) = self.message(found) else { return };
        let value = |name: &str| message.field(name).map(|field| field.value);
        let Some(DataflashValue::Unsigned(kind)) = value("FmtType") else { return };
        let ids = |name: &str| {
            let mut ids = [0; 16];
            let text = value(name).and_then(DataflashValue::text).unwrap_or_default();
            ids.iter_mut().zip(text).for_each(|(id, byte)| *id = *byte);
            ids
        };
        let (units, mults) = (ids("UnitIds"), ids("MultIds"));
        let place = usize::try_from(kind).ok().and_then(|kind| self.formats.get_mut(kind)?.as_mut());
        let Some(format) = place else {
            let kind = u8::try_from(kind).unwrap_or(u8::MAX);
            return self.tally.complain(DataflashError::UnitsOfUnknown { at: found.at, kind });
        };
        for ((field, unit), mult) in format.fields.iter_mut().zip(units).zip(mults) {
            (field.unit_id, field.mult_id) = (unit, mult);
            let by_mult = self.units.scale(mult).map(DataflashScale::factor);
            let by_format = field.implied.factor();
            if let Some(by_mult) = by_mult
                && field.implied != DataflashScale::ONE
                && !((by_mult / by_format - 1.0).abs() < 1e-6)
            {
                let (name, field) = (format.name.to_string(), field.name.to_string());
                self.tally.complain(DataflashError::Scale { at: found.at, name, field, by_format, by_mult });
            }
        }
    }

    fn define_table(&mut self, found: DataflashSpan, role: DataflashRole) {
        let Some(message) = self.message(found) else { return };
        let id = match message.field("Id").map(|field| field.value) {
            Some(DataflashValue::Signed(id)) => u8::try_from(id).ok(),
            Some(DataflashValue::Unsigned(id)) => u8::try_from(id).ok(),
            _ => None,
        };
        let Some(id) = id else { return };
        if role == DataflashRole::Unit {
            let mut label = [0; 64];
            let text = message.field("Label").and_then(|field| field.value.text()).unwrap_or_default();
            let length = text.len().min(label.len());
            label.iter_mut().zip(text).for_each(|(to, from)| *to = *from);
            self.units.set_label(id, label.get(..length).unwrap_or_default());
        } else if let Some(multiplier) = message.field("Mult").and_then(|field| field.value.number()) {
            self.units.set_multiplier(id, multiplier);
        }
    }
}
