//! The layout of a message, as an FMT defines it.
//!
//! Consumes the 86 bytes of an FMT's body: type (1), length with the header (1), name (4), format characters (16), names of the
//! columns parted by commas (64), texts filled up with zeros. Produces a [`DataflashFormat`]. Refused is one whose characters
//! do not add up to its length: where its messages end is not known. One with a character that is not known has no fields: its
//! messages can be skipped, not read. Names beyond the characters are left out, characters beyond the names make fields
//! without a name; both are reported.
//! Source: ArduPilot, AP_Logger, LogStructure.h, `log_Format`.

use super::error::DataflashError;
use super::field::{DataflashScale, DataflashType, until_zero};

/// The type of FMT.
pub const FMT_TYPE: u8 = 128;
/// Bytes of an FMT message.
pub const FMT_LENGTH: u8 = 89;
/// Header of a message: A3 95 and its type.
pub const HEADER: usize = 3;
const FMT_CHARACTERS: &str = "BBnNZ";

/// What the log itself uses a message for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum DataflashRole {
    Fmt,
    Fmtu,
    Unit,
    Mult,
    Other,
}

/// One column.
#[derive(Clone, Debug, PartialEq)]
pub struct DataflashField {
    /// Its name; empty where the FMT gives none.
    pub name: Box<str>,
    /// Its type.
    pub kind: DataflashType,
    /// The scale that its format character implies.
    pub implied: DataflashScale,
    /// Its first byte, from the end of the header.
    pub offset: usize,
    /// Identifier of its unit by FMTU; 0 before there is one.
    pub unit_id: u8,
    /// Identifier of its multiplier by FMTU; 0 before there is one.
    pub mult_id: u8,
}

/// The layout of a message.
#[derive(Clone, Debug, PartialEq)]
pub struct DataflashFormat {
    /// Type, the third byte of a message.
    pub kind: u8,
    /// Bytes of a message with its header.
    pub length: u8,
    /// Name.
    pub name: Box<str>,
    /// Format characters.
    pub characters: Box<str>,
    /// Names of the columns, as they stand in the log.
    pub columns: Box<str>,
    /// Columns in their order; none where the definition contradicts itself.
    pub fields: Vec<DataflashField>,
    pub(super) role: DataflashRole,
    /// Place of the time in `fields`, and how many microseconds one of it is.
    pub(super) time: Option<(usize, u64)>,
}

fn printable(bytes: &[u8]) -> Option<&str> {
    let text = std::str::from_utf8(bytes).ok()?;
    text.bytes().all(|byte| (0x20..0x7F).contains(&byte)).then_some(text)
}

impl DataflashFormat {
    /// The FMT of FMT, which every log begins with.
    pub(super) fn of_fmt() -> Self {
        let columns = "Type,Length,Name,Format,Columns";
        let mut offset = 0;
        let mut fields = Vec::new();
        for (name, character) in columns.split(',').zip(FMT_CHARACTERS.bytes()) {
            if let Some((kind, implied)) = DataflashType::of(character) {
                fields.push(DataflashField { name: name.into(), kind, implied, offset, unit_id: 0, mult_id: 0 });
                offset += kind.size();
            }
        }
        DataflashFormat {
            kind: FMT_TYPE,
            length: FMT_LENGTH,
            name: "FMT".into(),
            characters: FMT_CHARACTERS.into(),
            columns: columns.into(),
            fields,
            role: DataflashRole::Fmt,
            time: None,
        }
    }

    /// Reads the body of an FMT that began at byte `at`; with the layout what is wrong with it, if it can be used all the same.
    ///
    /// # Errors
    /// [`DataflashError`] where it is no definition of a message.
    pub fn parse(body: &[u8], at: u64) -> Result<(Self, Option<DataflashError>), DataflashError> {
        let part = |from: usize, length: usize| until_zero(body.get(from..from + length).unwrap_or_default());
        let [kind, length] = [0, 1].map(|at| body.get(at).copied().unwrap_or_default());
        if usize::from(length) < HEADER {
            return Err(DataflashError::Length { at, kind, length });
        }
        let found = body.get(2..6).and_then(|bytes| bytes.first_chunk().copied()).unwrap_or_default();
        let name = printable(part(2, 4)).filter(|name| !name.is_empty());
        let name = name.ok_or(DataflashError::Name { at, kind, found })?;
        let text = || DataflashError::Text { at, kind, name: name.into() };
        let characters = printable(part(6, 16)).ok_or_else(text)?;
        let columns = printable(part(22, 64)).ok_or_else(text)?;
        if kind == FMT_TYPE && (name != "FMT" || length != FMT_LENGTH || characters != FMT_CHARACTERS) {
            return Err(DataflashError::Definition { at, name: name.into(), length, format: characters.into() });
        }
        let mut warning = None;
        let names: Vec<&str> = columns.split(',').filter(|column| !column.is_empty()).collect();
        if names.len() != characters.len() {
            let (characters, columns) = (characters.len(), names.len());
            warning = Some(DataflashError::Columns { at, kind, name: name.into(), characters, columns });
        }
        let mut fields = Vec::with_capacity(characters.len());
        let mut offset = 0;
        for (place, character) in characters.bytes().enumerate() {
            let Some((kind_of_field, implied)) = DataflashType::of(character) else {
                fields.clear();
                warning = Some(DataflashError::Character { at, kind, name: name.into(), found: character.into() });
                break;
            };
            let name = names.get(place).copied().unwrap_or_default().into();
            fields.push(DataflashField { name, kind: kind_of_field, implied, offset, unit_id: 0, mult_id: 0 });
            offset += kind_of_field.size();
        }
        let needed = offset + HEADER;
        if fields.len() == characters.len() && needed != usize::from(length) {
            return Err(DataflashError::Size { at, kind, name: name.into(), stated: length, needed });
        }
        let role = match name {
            "FMT" if kind == FMT_TYPE => DataflashRole::Fmt,
            "FMTU" => DataflashRole::Fmtu,
            "UNIT" => DataflashRole::Unit,
            "MULT" => DataflashRole::Mult,
            _ => DataflashRole::Other,
        };
        let whole = |field: &DataflashField| matches!(field.kind, DataflashType::Unsigned64 | DataflashType::Unsigned32);
        let time_of = |name: &str, factor: u64| {
            let place = fields.iter().position(|field: &DataflashField| &*field.name == name && whole(field))?;
            Some((place, factor))
        };
        let time = time_of("TimeUS", 1).or_else(|| time_of("TimeMS", 1000));
        let (name, characters, columns) = (name.into(), characters.into(), columns.into());
        Ok((DataflashFormat { kind, length, name, characters, columns, fields, role, time }, warning))
    }

    /// Whether another definition says the same.
    pub fn same_layout(&self, other: &DataflashFormat) -> bool {
        let of = |format: &DataflashFormat| (format.kind, format.length);
        of(self) == of(other) && self.name == other.name && self.characters == other.characters && self.columns == other.columns
    }

    /// In a line: name, characters, columns.
    pub fn words(&self) -> String {
        format!("{} ({} bytes) {} {}", self.name, self.length, self.characters, self.columns)
    }

    /// The column of that name.
    pub fn field(&self, name: &str) -> Option<&DataflashField> {
        self.fields.iter().find(|field| &*field.name == name)
    }

    /// The column that tells which of several instruments a message is of: unit `#` by FMTU, else one byte named `I`.
    pub fn instance_field(&self) -> Option<&DataflashField> {
        let named = |field: &&DataflashField| &*field.name == "I" && field.kind == DataflashType::Unsigned8;
        self.fields.iter().find(|field| field.unit_id == b'#').or_else(|| self.fields.iter().find(named))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn body(kind: u8, length: u8, name: &[u8], characters: &[u8], columns: &[u8]) -> Vec<u8> {
        let mut bytes = vec![kind, length];
        for (text, size) in [(name, 4), (characters, 16), (columns, 64)] {
            bytes.extend_from_slice(text);
            bytes.resize(bytes.len() + size - text.len(), 0);
        }
        bytes
    }

    #[test]
    fn columns_stand_one_after_the_other() {
        let (format, warning) = DataflashFormat::parse(&body(133, 19, b"GYR2", b"QHcn", b"TimeUS,N,X,Name"), 0).unwrap();
        assert_eq!((warning, format.time, &*format.name), (None, Some((0, 1)), "GYR2"));
        let places: Vec<_> = format.fields.iter().map(|field| (field.offset, &*field.name)).collect();
        assert_eq!(places, [(0, "TimeUS"), (8, "N"), (10, "X"), (12, "Name")]);
    }

    #[test]
    fn a_definition_that_contradicts_itself_is_kept_for_its_length_alone() {
        let parse = |length, characters: &[u8], columns: &[u8]| {
            DataflashFormat::parse(&body(7, length, b"X", characters, columns), 9).unwrap()
        };
        let (format, warning) = parse(12, b"QB", b"TimeUS,A,B");
        assert!(matches!(warning, Some(DataflashError::Columns { characters: 2, columns: 3, at: 9, .. })));
        assert_eq!((format.fields.len(), format.length), (2, 12));
        let (format, warning) = parse(12, b"Q!", b"TimeUS,A");
        assert!(matches!(warning, Some(DataflashError::Character { found: '!', .. })));
        assert!(format.fields.is_empty());
    }

    #[test]
    fn what_is_no_definition_is_refused() {
        let parse = |bytes: Vec<u8>| DataflashFormat::parse(&bytes, 0).unwrap_err();
        assert!(matches!(parse(body(7, 2, b"X", b"", b"")), DataflashError::Length { length: 2, .. }));
        assert!(matches!(parse(body(7, 9, b"\x01", b"", b"")), DataflashError::Name { .. }));
        assert!(matches!(parse(body(7, 9, b"", b"", b"")), DataflashError::Name { .. }));
        assert!(matches!(parse(body(7, 9, b"X", b"\xFF", b"")), DataflashError::Text { .. }));
        assert!(matches!(parse(body(128, 90, b"FMT", b"BBnNZ", b"")), DataflashError::Definition { length: 90, .. }));
        let size = parse(body(7, 13, b"X", b"QB", b"TimeUS,A"));
        assert!(matches!(size, DataflashError::Size { stated: 13, needed: 12, .. }));
        assert!(matches!(parse(Vec::new()), DataflashError::Length { .. }));
    }
}
