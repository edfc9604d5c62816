//! Formats: the fields of a topic or of a type within one, from their text.
//!
//! Consumes `name:type field;type[n] field;...`; produces a [`UlogFormat`]. A type is a basic one or the name of another
//! format.
//! Refused: text that is not printable ASCII, no fields or more than [`FIELDS_MAX`], an array of none or of more than
//! [`ARRAY_MAX`], a name that is empty or longer than [`NAME_MAX`].
//! Source: PX4 User Guide, "ULog File Format", 'F': Format Message.

use super::error::UlogError;
use super::value::UlogType;

/// Fields of a format at most.
pub const FIELDS_MAX: usize = 2048;
/// Elements of an array at most: no message is longer.
pub const ARRAY_MAX: usize = 65_535;
/// Bytes of a name at most.
pub const NAME_MAX: usize = 255;

/// The type of a field.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum UlogFieldType {
    /// A basic type.
    Basic(UlogType),
    /// Another format.
    Format(Box<str>),
}

/// A field of a format.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct UlogField {
    /// Its type.
    pub kind: UlogFieldType,
    /// Elements of an array; `None` where it is none.
    pub array: Option<usize>,
    /// Its name.
    pub name: Box<str>,
}

/// A format.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct UlogFormat {
    /// Its name.
    pub name: Box<str>,
    /// Its fields in their order.
    pub fields: Vec<UlogField>,
}

/// Whether all of it is printable ASCII.
pub(super) fn printable(text: &[u8]) -> Option<&str> {
    text.iter().all(|byte| (0x20..0x7F).contains(byte)).then(|| std::str::from_utf8(text).ok())?
}

/// A type and a name parted by a space, `float[3] xyz`.
fn typed_name(text: &str) -> Result<UlogField, &'static str> {
    let (kind, name) = text.split_once(' ').ok_or("a type and a name parted by a space are expected")?;
    let (kind, array) = match kind.split_once('[') {
        None => (kind, None),
        Some((kind, length)) => {
            let length = length.strip_suffix(']').and_then(|length| length.parse().ok());
            let length = length.filter(|length| (1..=ARRAY_MAX).contains(length));
            (kind, Some(length.ok_or("an array of 1 to 65535 is expected")?))
        }
    };
    let is_name = |name: &str| !name.is_empty() && name.len() <= NAME_MAX && !name.contains([' ', '[', ']', ':', ';']);
    if !is_name(kind) || !is_name(name) {
        return Err("a name of 1 to 255 characters is expected");
    }
    let kind = UlogType::of(kind).map_or_else(|| UlogFieldType::Format(kind.into()), UlogFieldType::Basic);
    Ok(UlogField { kind, array, name: name.into() })
}

/// The start of a text, for a complaint.
pub(super) fn beginning(text: &[u8]) -> String {
    const SHOWN: usize = 80;
    String::from_utf8_lossy(text.get(..SHOWN).unwrap_or(text)).into_owned()
}

impl UlogFormat {
    /// Reads the text of a format that stands at byte `at`.
    ///
    /// # Errors
    /// [`UlogError::Format`] where it is none.
    pub fn parse(text: &[u8], at: u64) -> Result<Self, UlogError> {
        let wrong = |what| UlogError::Format { at, text: beginning(text), what };
        let written = printable(text).ok_or_else(|| wrong("printable text is expected"))?;
        let (name, fields) = written.split_once(':').ok_or_else(|| wrong("a name and a colon are expected"))?;
        if name.is_empty() || name.len() > NAME_MAX || name.contains([' ', '[', ']', ';']) {
            return Err(wrong("a name of 1 to 255 characters is expected"));
        }
        let mut found = Vec::new();
        for field in fields.split(';').filter(|field| !field.is_empty()) {
            if found.len() >= FIELDS_MAX {
                return Err(wrong("at most 2048 fields are expected"));
            }
            found.push(typed_name(field).map_err(wrong)?);
        }
        if found.is_empty() {
            return Err(wrong("at least one field is expected"));
        }
        Ok(UlogFormat { name: name.into(), fields: found })
    }
}

/// A topic that is logged.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct UlogSubscription {
    /// Id in data messages.
    pub id: u16,
    /// Which of several instruments, from 0.
    pub multi_id: u8,
    /// Name of the topic.
    pub name: Box<str>,
    pub(super) layout: usize,
    pub(super) last_us: Option<u64>,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fields_are_basic_types_arrays_or_other_formats() {
        let format = UlogFormat::parse(b"gyro:uint64_t timestamp;float[3] xyz;device_s device;", 0).unwrap();
        assert_eq!(&*format.name, "gyro");
        let basic = |kind| UlogFieldType::Basic(kind);
        let expected = [
            (basic(UlogType::UInt64), None, "timestamp"),
            (basic(UlogType::Float), Some(3), "xyz"),
            (UlogFieldType::Format("device_s".into()), None, "device"),
        ];
        let found: Vec<_> = format.fields.iter().map(|field| (field.kind.clone(), field.array, &*field.name)).collect();
        assert_eq!(found, expected);
    }

    #[test]
    fn what_is_no_format_is_refused_with_the_reason() {
        let cases: [(&[u8], &str); 10] = [
            (b"gyro", "colon"),
            (b":float x;", "name"),
            (b"gyro:", "at least one field"),
            (b"gyro:float;", "space"),
            (b"gyro:float[0] x;", "array"),
            (b"gyro:float[65536] x;", "array"),
            (b"gyro:float[-1] x;", "array"),
            (b"gyro:float[3 x;", "array"),
            (b"gyro:float x y;", "name"),
            (b"gy\x01ro:float x;", "printable"),
        ];
        for (text, reason) in cases {
            let error = UlogFormat::parse(text, 7).unwrap_err();
            let UlogError::Format { at: 7, what, .. } = error else { panic!("{error}") };
            assert!(what.contains(reason), "{what}");
        }
        let many = format!("a:{}", "bool b;".repeat(FIELDS_MAX + 1));
        assert!(UlogFormat::parse(many.as_bytes(), 0).is_err());
        assert!(UlogFormat::parse(format!("a:bool {};", "b".repeat(256)).as_bytes(), 0).is_err());
    }
}
