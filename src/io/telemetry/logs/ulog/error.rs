//! Why a ULog cannot be read, and why a definition in it is refused.

/// What was expected and what was found.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[expect(missing_docs, reason = "the message of each says what its fields are")]
pub enum UlogError {
    #[error("byte 0: a ULog begins with 55 4c 6f 67 01 12 35; found {found:02x?}")]
    Magic { found: Vec<u8> },
    #[error("the header of a ULog is 16 bytes; found {found}")]
    HeaderCut { found: usize },
    #[error("byte {at}: incompatible flags {found:#04x} in byte {index} are not known: the log must not be read")]
    Incompatible { at: u64, index: usize, found: u8 },
    #[error("byte {at}: format {text:?}: {what}")]
    Format { at: u64, text: String, what: &'static str },
    #[error("byte {at}: {name} was defined in another way before; the new one is for later subscriptions")]
    Redefined { at: u64, name: String },
    #[error("byte {at}: {what}: at most {limit}")]
    Limit { at: u64, what: &'static str, limit: usize },
    #[error("byte {at}: subscription {id} is to {name}, which has no format")]
    NoFormat { at: u64, id: u16, name: String },
    #[error("byte {at}: subscription {id} to {name}: {what}")]
    Layout { at: u64, id: u16, name: String, what: LayoutError },
    #[error("byte {at}: subscription {id} was to {before} and is now to {after}")]
    Resubscribed { at: u64, id: u16, before: String, after: String },
    #[error("byte {at}: a message of kind {kind:?} is refused, since its content is not what its kind demands: {found:?}")]
    Content { at: u64, kind: char, found: String },
    #[error("byte {at}: appended data at byte {offset}, which is not behind what was read")]
    Offset { at: u64, offset: u64 },
}

/// Why the fields of a format cannot be laid out.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[expect(missing_docs, reason = "the message of each says what its fields are")]
pub enum LayoutError {
    #[error("the type {name} has no format")]
    NoType { name: String },
    #[error("formats within formats more than {limit} deep: does {name} contain itself?")]
    Depth { name: String, limit: usize },
    #[error("more than {limit} bytes")]
    Size { limit: usize },
    #[error("the formats of this log have more fields, or longer names, than are kept: {limit}")]
    Fields { limit: usize },
}
