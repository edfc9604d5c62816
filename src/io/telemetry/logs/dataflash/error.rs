//! Why a definition in a dataflash log is refused.

/// A definition that cannot be used: what was expected and what was found.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[expect(missing_docs, reason = "the message of each says what its fields are")]
pub enum DataflashError {
    #[error("byte {at}: FMT of type {kind}: a length of at least 3 is expected, found {length}")]
    Length { at: u64, kind: u8, length: u8 },
    #[error("byte {at}: FMT of type {kind}: a name of printable characters is expected, found bytes {found:?}")]
    Name { at: u64, kind: u8, found: [u8; 4] },
    #[error("byte {at}: FMT of type {kind}, {name}: printable text is expected in its format and columns")]
    Text { at: u64, kind: u8, name: String },
    #[error("byte {at}: FMT of type {kind}, {name}: the format character {found:?} is not known; its messages are skipped")]
    Character { at: u64, kind: u8, name: String, found: char },
    #[error("byte {at}: FMT of type {kind}, {name}: the length is {stated}, its format characters make it {needed}")]
    Size { at: u64, kind: u8, name: String, stated: u8, needed: usize },
    #[error("byte {at}: FMT of type {kind}, {name}: {characters} format characters for {columns} columns")]
    Columns { at: u64, kind: u8, name: String, characters: usize, columns: usize },
    #[error("byte {at}: FMT of type 128 must be FMT, 89 bytes, BBnNZ; found {name}, {length} bytes, {format}")]
    Definition { at: u64, name: String, length: u8, format: String },
    #[error("byte {at}: type {kind} was {before} and is now {after}")]
    Redefined { at: u64, kind: u8, before: String, after: String },
    #[error("byte {at}: FMTU is about type {kind}, which no FMT has defined")]
    UnitsOfUnknown { at: u64, kind: u8 },
    #[error("byte {at}: {name}.{field}: the format says times {by_format}, MULT says times {by_mult}; MULT is used")]
    Scale { at: u64, name: String, field: String, by_format: f64, by_mult: f64 },
}
