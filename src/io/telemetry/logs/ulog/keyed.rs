//! A keyed value of a ULog: key with its type, and the bytes of the value (messages `I`, `P`, `M`, `Q`).

use super::definition::printable;
use super::value::{UlogType, UlogValue, UlogValues};
use std::borrow::Cow;

/// A key with its type, and a value.
#[derive(Clone, Copy, Debug)]
pub struct UlogKeyed<'a> {
    /// Type as it stands in the log, `char[40]`.
    pub kind: &'a str,
    /// Name.
    pub key: &'a str,
    /// Bytes of the value.
    pub bytes: &'a [u8],
}

impl<'a> UlogKeyed<'a> {
    /// The values of a basic type, or of an array of one.
    pub fn values(&self) -> Option<UlogValues<'a>> {
        let name = self.kind.split_once('[').map_or(self.kind, |(name, _)| name);
        UlogType::of(name).map(|kind| UlogValues::new(kind, self.bytes))
    }

    /// The one value of a basic type.
    pub fn value(&self) -> Option<UlogValue> {
        UlogType::of(self.kind)?.read(self.bytes)
    }

    /// The text of characters.
    pub fn text(&self) -> Option<Cow<'a, str>> {
        self.values()?.text().map(String::from_utf8_lossy)
    }
}

/// The keyed value that a payload of `I`, `P` is, or one of `M`, `Q` behind its first byte.
pub(super) fn keyed(payload: &[u8]) -> Option<UlogKeyed<'_>> {
    let (length, rest) = payload.split_first()?;
    let (key, bytes) = rest.split_at_checked(usize::from(*length))?;
    let (kind, key) = printable(key)?.split_once(' ')?;
    Some(UlogKeyed { kind, key, bytes })
}
