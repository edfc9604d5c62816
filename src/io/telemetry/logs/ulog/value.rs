//! Values of ULog fields: the basic types, little-endian.

/// A basic type.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[expect(missing_docs, reason = "named as in C")]
pub enum UlogType {
    Int8,
    UInt8,
    Int16,
    UInt16,
    Int32,
    UInt32,
    Int64,
    UInt64,
    Float,
    Double,
    Bool,
    Char,
}

impl UlogType {
    /// The type of that name in a format.
    pub fn of(name: &str) -> Option<UlogType> {
        Some(match name {
            "int8_t" => UlogType::Int8,
            "uint8_t" => UlogType::UInt8,
            "int16_t" => UlogType::Int16,
            "uint16_t" => UlogType::UInt16,
            "int32_t" => UlogType::Int32,
            "uint32_t" => UlogType::UInt32,
            "int64_t" => UlogType::Int64,
            "uint64_t" => UlogType::UInt64,
            "float" => UlogType::Float,
            "double" => UlogType::Double,
            "bool" => UlogType::Bool,
            "char" => UlogType::Char,
            _ => return None,
        })
    }

    /// Bytes.
    pub const fn size(self) -> usize {
        match self {
            UlogType::Int8 | UlogType::UInt8 | UlogType::Bool | UlogType::Char => 1,
            UlogType::Int16 | UlogType::UInt16 => 2,
            UlogType::Int32 | UlogType::UInt32 | UlogType::Float => 4,
            UlogType::Int64 | UlogType::UInt64 | UlogType::Double => 8,
        }
    }

    /// The value that stands at the start of the bytes; `None` where there are too few.
    pub fn read(self, bytes: &[u8]) -> Option<UlogValue> {
        Some(match self {
            UlogType::Int8 => UlogValue::Signed(i8::from_le_bytes(*bytes.first_chunk()?).into()),
            UlogType::UInt8 => UlogValue::Unsigned((*bytes.first()?).into()),
            UlogType::Int16 => UlogValue::Signed(i16::from_le_bytes(*bytes.first_chunk()?).into()),
            UlogType::UInt16 => UlogValue::Unsigned(u16::from_le_bytes(*bytes.first_chunk()?).into()),
            UlogType::Int32 => UlogValue::Signed(i32::from_le_bytes(*bytes.first_chunk()?).into()),
            UlogType::UInt32 => UlogValue::Unsigned(u32::from_le_bytes(*bytes.first_chunk()?).into()),
            UlogType::Int64 => UlogValue::Signed(i64::from_le_bytes(*bytes.first_chunk()?)),
            UlogType::UInt64 => UlogValue::Unsigned(u64::from_le_bytes(*bytes.first_chunk()?)),
            UlogType::Float => UlogValue::Single(f32::from_le_bytes(*bytes.first_chunk()?)),
            UlogType::Double => UlogValue::Double(f64::from_le_bytes(*bytes.first_chunk()?)),
            UlogType::Bool => UlogValue::Bool(*bytes.first()?),
            UlogType::Char => UlogValue::Char(*bytes.first()?),
        })
    }
}

/// One value.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum UlogValue {
    /// An integer with a sign.
    Signed(i64),
    /// An integer without.
    Unsigned(u64),
    /// Single precision.
    Single(f32),
    /// Double precision.
    Double(f64),
    /// A truth value: the byte as it stands, 0 for false.
    Bool(u8),
    /// A byte of text.
    Char(u8),
}

impl UlogValue {
    /// As a number.
    #[expect(clippy::cast_precision_loss, reason = "beyond 2^53 the nearest number is meant")]
    pub fn number(self) -> f64 {
        match self {
            UlogValue::Signed(number) => number as f64,
            UlogValue::Unsigned(number) => number as f64,
            UlogValue::Single(number) => number.into(),
            UlogValue::Double(number) => number,
            UlogValue::Bool(byte) | UlogValue::Char(byte) => byte.into(),
        }
    }
}

/// The values of a field: one, or those of an array.
#[derive(Clone, Copy, Debug)]
pub struct UlogValues<'a> {
    kind: UlogType,
    bytes: &'a [u8],
}

impl<'a> UlogValues<'a> {
    /// As many as fit into the bytes.
    pub(super) fn new(kind: UlogType, bytes: &'a [u8]) -> Self {
        UlogValues { kind, bytes }
    }

    /// Their type.
    pub fn kind(&self) -> UlogType {
        self.kind
    }

    /// How many.
    pub fn len(&self) -> usize {
        self.bytes.len() / self.kind.size()
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The one at that place, from 0.
    pub fn get(&self, index: usize) -> Option<UlogValue> {
        self.kind.read(self.bytes.get(index.checked_mul(self.kind.size())?..)?)
    }

    /// One after the other.
    pub fn iter(&self) -> impl Iterator<Item = UlogValue> + use<'a> {
        let kind = self.kind;
        self.bytes.chunks_exact(kind.size()).filter_map(move |bytes| kind.read(bytes))
    }

    /// Bytes of text up to the first zero; `None` of other types.
    pub fn text(&self) -> Option<&'a [u8]> {
        (self.kind == UlogType::Char).then(|| self.bytes.split(|byte| *byte == 0).next().unwrap_or_default())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn arrays_are_read_element_by_element() {
        let values = UlogValues::new(UlogType::Int16, &[1, 0, 0xFF, 0xFF, 7]);
        assert_eq!((values.len(), values.is_empty(), values.text()), (2, false, None));
        assert_eq!(values.iter().collect::<Vec<_>>(), [UlogValue::Signed(1), UlogValue::Signed(-1)]);
        assert_eq!([values.get(1), values.get(2), values.get(usize::MAX)], [Some(UlogValue::Signed(-1)), None, None]);
        assert_eq!(UlogValues::new(UlogType::Char, b"PX4\0\0").text(), Some(&b"PX4"[..]));
    }

    #[test]
    fn names_and_sizes_are_those_of_c() {
        let names = "int8_t uint8_t int16_t uint16_t int32_t uint32_t int64_t uint64_t float double bool char";
        let sizes: Vec<_> = names.split(' ').map(|name| UlogType::of(name).unwrap().size()).collect();
        assert_eq!(sizes, [1, 1, 2, 2, 4, 4, 8, 8, 4, 8, 1, 1]);
        assert_eq!([UlogType::of("int"), UlogType::of("float[3]"), UlogType::of("")], [None; 3]);
    }
}
