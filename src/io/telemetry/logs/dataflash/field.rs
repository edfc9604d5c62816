//! Format characters of dataflash messages: size, type and scale of a field, and its value from bytes.
//!
//! Consumes a format character and the bytes of a field, little-endian; produces a [`DataflashValue`]. The characters:
//! | b B h H i I q Q | integers of 8, 16, 32, 64 bits, signed and unsigned |
//! | f d g | IEEE 754 of 32, 64, 16 bits |
//! | n N Z | text of 4, 16, 64 bytes, filled up with zeros |
//! | a | 32 integers of 16 bits, signed |
//! | M | flight mode, 8 bits |
//! | c C e E | h H i I times 100: the value is a hundredth of the number |
//! | L | degrees of latitude or longitude times 10^7 |
//! Source: ArduPilot, AP_Logger, README, "Format Types".

/// The type of a field.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DataflashType {
    /// `a`
    Array,
    /// `b`
    Signed8,
    /// `B`, `M`
    Unsigned8,
    /// `h`, `c`
    Signed16,
    /// `H`, `C`
    Unsigned16,
    /// `i`, `e`, `L`
    Signed32,
    /// `I`, `E`
    Unsigned32,
    /// `q`
    Signed64,
    /// `Q`
    Unsigned64,
    /// `g`
    Half,
    /// `f`
    Single,
    /// `d`
    Double,
    /// `n`, `N`, `Z`: that many bytes.
    Text(u8),
}

/// How a number becomes a value. A division by a power of ten is exact to the last bit where a product with its inverse is not.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum DataflashScale {
    /// Value = number * factor.
    Times(f64),
    /// Value = number / divisor.
    Over(f64),
}

impl DataflashScale {
    /// Value = number.
    pub const ONE: DataflashScale = DataflashScale::Times(1.0);

    /// The scale that a multiplier stands for. Logs hold single-precision multipliers: one within 1e-6 of the inverse of a
    /// whole number is taken for that.
    pub fn of_multiplier(multiplier: f64) -> Option<DataflashScale> {
        if !(multiplier.is_finite() && multiplier > 0.0) {
            return None;
        }
        let inverse = 1.0 / multiplier;
        let whole = libm::round(inverse);
        if multiplier < 1.0 && whole <= 1e12 && (inverse / whole - 1.0).abs() < 1e-6 {
            return Some(DataflashScale::Over(whole));
        }
        let rounded = libm::round(multiplier * 1e3) / 1e3;
        let exact = if (multiplier / rounded - 1.0).abs() < 1e-6 { rounded } else { multiplier };
        Some(DataflashScale::Times(exact))
    }

    /// The value of a number.
    pub fn apply(self, number: f64) -> f64 {
        match self {
            DataflashScale::Times(factor) => number * factor,
            DataflashScale::Over(divisor) => number / divisor,
        }
    }

    /// As one factor.
    pub fn factor(self) -> f64 {
        self.apply(1.0)
    }
}

impl DataflashType {
    /// Type and scale of a format character; `None` of one that is not known.
    pub const fn of(character: u8) -> Option<(DataflashType, DataflashScale)> {
        const HUNDREDTH: DataflashScale = DataflashScale::Over(100.0);
        Some(match character {
            b'a' => (DataflashType::Array, DataflashScale::ONE),
            b'b' => (DataflashType::Signed8, DataflashScale::ONE),
            b'B' | b'M' => (DataflashType::Unsigned8, DataflashScale::ONE),
            b'h' => (DataflashType::Signed16, DataflashScale::ONE),
            b'H' => (DataflashType::Unsigned16, DataflashScale::ONE),
            b'i' => (DataflashType::Signed32, DataflashScale::ONE),
            b'I' => (DataflashType::Unsigned32, DataflashScale::ONE),
            b'q' => (DataflashType::Signed64, DataflashScale::ONE),
            b'Q' => (DataflashType::Unsigned64, DataflashScale::ONE),
            b'g' => (DataflashType::Half, DataflashScale::ONE),
            b'f' => (DataflashType::Single, DataflashScale::ONE),
            b'd' => (DataflashType::Double, DataflashScale::ONE),
            b'n' => (DataflashType::Text(4), DataflashScale::ONE),
            b'N' => (DataflashType::Text(16), DataflashScale::ONE),
            b'Z' => (DataflashType::Text(64), DataflashScale::ONE),
            b'c' => (DataflashType::Signed16, HUNDREDTH),
            b'C' => (DataflashType::Unsigned16, HUNDREDTH),
            b'e' => (DataflashType::Signed32, HUNDREDTH),
            b'E' => (DataflashType::Unsigned32, HUNDREDTH),
            b'L' => (DataflashType::Signed32, DataflashScale::Over(1e7)),
            _ => return None,
        })
    }

    /// Bytes.
    pub const fn size(self) -> usize {
        match self {
            DataflashType::Signed8 | DataflashType::Unsigned8 => 1,
            DataflashType::Signed16 | DataflashType::Unsigned16 | DataflashType::Half => 2,
            DataflashType::Signed32 | DataflashType::Unsigned32 | DataflashType::Single => 4,
            DataflashType::Signed64 | DataflashType::Unsigned64 | DataflashType::Double => 8,
            DataflashType::Array => 64,
            DataflashType::Text(bytes) => bytes as usize,
        }
    }

    /// The value that stands at the start of the bytes; `None` where there are too few.
    pub fn read(self, bytes: &[u8]) -> Option<DataflashValue<'_>> {
        let signed = |number: i64| Some(DataflashValue::Signed(number));
        let unsigned = |number: u64| Some(DataflashValue::Unsigned(number));
        match self {
            DataflashType::Signed8 => signed(i8::from_le_bytes(*bytes.first_chunk()?).into()),
            DataflashType::Unsigned8 => unsigned((*bytes.first()?).into()),
            DataflashType::Signed16 => signed(i16::from_le_bytes(*bytes.first_chunk()?).into()),
            DataflashType::Unsigned16 => unsigned(u16::from_le_bytes(*bytes.first_chunk()?).into()),
            DataflashType::Signed32 => signed(i32::from_le_bytes(*bytes.first_chunk()?).into()),
            DataflashType::Unsigned32 => unsigned(u32::from_le_bytes(*bytes.first_chunk()?).into()),
            DataflashType::Signed64 => signed(i64::from_le_bytes(*bytes.first_chunk()?)),
            DataflashType::Unsigned64 => unsigned(u64::from_le_bytes(*bytes.first_chunk()?)),
            DataflashType::Half => Some(DataflashValue::Single(half(u16::from_le_bytes(*bytes.first_chunk()?)))),
            DataflashType::Single => Some(DataflashValue::Single(f32::from_le_bytes(*bytes.first_chunk()?))),
            DataflashType::Double => Some(DataflashValue::Double(f64::from_le_bytes(*bytes.first_chunk()?))),
            DataflashType::Array => Some(DataflashValue::Array(DataflashArray(bytes.first_chunk()?))),
            DataflashType::Text(length) => Some(DataflashValue::Text(bytes.get(..usize::from(length))?)),
        }
    }
}

/// Half precision: sign, 5 bits of exponent with bias 15, 10 of fraction (IEEE 754-2019, 3.6, binary16). Every one of them is a
/// number of single precision.
fn half(bits: u16) -> f32 {
    let sign = u32::from(bits >> 15) << 31;
    let exponent = u32::from(bits >> 10 & 0x1F);
    let fraction = u32::from(bits & 0x3FF);
    match exponent {
        0 => {
            // A subnormal number is its fraction times 2^-24.
            #[expect(clippy::cast_precision_loss, reason = "ten bits")]
            let size = fraction as f32 / 16_777_216.0;
            f32::from_bits(size.to_bits() | sign)
        }
        0x1F => f32::from_bits(sign | 0x7F80_0000 | fraction << 13),
        _ => f32::from_bits(sign | (exponent + 112) << 23 | fraction << 13),
    }
}

/// The value of a field, as it stands in the log.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum DataflashValue<'a> {
    /// An integer with a sign.
    Signed(i64),
    /// An integer without.
    Unsigned(u64),
    /// Single precision, or half.
    Single(f32),
    /// Double precision.
    Double(f64),
    /// Text with the zeros that fill it up.
    Text(&'a [u8]),
    /// 32 integers.
    Array(DataflashArray<'a>),
}

impl<'a> DataflashValue<'a> {
    /// As a number; `None` of a text or an array.
    #[expect(clippy::cast_precision_loss, reason = "beyond 2^53 the nearest number is meant")]
    pub fn number(self) -> Option<f64> {
        match self {
            DataflashValue::Signed(number) => Some(number as f64),
            DataflashValue::Unsigned(number) => Some(number as f64),
            DataflashValue::Single(number) => Some(number.into()),
            DataflashValue::Double(number) => Some(number),
            DataflashValue::Text(_) | DataflashValue::Array(_) => None,
        }
    }

    /// The bytes of a text up to its first zero.
    pub fn text(self) -> Option<&'a [u8]> {
        match self {
            DataflashValue::Text(bytes) => Some(until_zero(bytes)),
            _ => None,
        }
    }
}

/// 32 integers of 16 bits.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct DataflashArray<'a>(&'a [u8; 64]);

impl<'a> DataflashArray<'a> {
    /// One after the other.
    pub fn iter(self) -> impl Iterator<Item = i16> + 'a {
        self.0.chunks_exact(2).filter_map(|pair| pair.first_chunk().map(|bytes| i16::from_le_bytes(*bytes)))
    }
}

/// What stands before the first zero.
pub(super) fn until_zero(bytes: &[u8]) -> &[u8] {
    bytes.split(|byte| *byte == 0).next().unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_character_has_the_size_that_its_c_type_has() {
        let sizes = [
            (b'a', 64),
            (b'b', 1),
            (b'B', 1),
            (b'h', 2),
            (b'H', 2),
            (b'i', 4),
            (b'I', 4),
            (b'f', 4),
            (b'd', 8),
            (b'n', 4),
            (b'N', 16),
            (b'Z', 64),
            (b'c', 2),
            (b'C', 2),
            (b'e', 4),
            (b'E', 4),
            (b'L', 4),
            (b'M', 1),
            (b'q', 8),
            (b'Q', 8),
            (b'g', 2),
        ];
        for (character, size) in sizes {
            let (kind, _) = DataflashType::of(character).unwrap();
            assert_eq!(kind.size(), size, "{}", char::from(character));
            assert!(kind.read(&[1; 64]).is_some() && kind.read(&vec![1; size - 1]).is_none());
        }
        assert_eq!((0..=255).filter(|c| DataflashType::of(*c).is_some()).count(), sizes.len());
    }

    #[test]
    fn values_are_little_endian_and_signed_where_they_should_be() {
        let read = |c, bytes: &'static [u8]| DataflashType::of(c).unwrap().0.read(bytes).unwrap();
        assert_eq!(read(b'h', &[0xFE, 0xFF]), DataflashValue::Signed(-2));
        assert_eq!(read(b'H', &[0xFE, 0xFF]), DataflashValue::Unsigned(65534));
        assert_eq!(read(b'i', &[0, 0, 0, 0x80]), DataflashValue::Signed(-2_147_483_648));
        assert_eq!(read(b'Q', &[0xFF; 8]), DataflashValue::Unsigned(u64::MAX));
        assert_eq!(read(b'f', &[0, 0, 0x80, 0x3F]), DataflashValue::Single(1.0));
        assert_eq!(read(b'n', b"IMU\0").text(), Some(&b"IMU"[..]));
        let DataflashValue::Array(array) = read(b'a', &[0xFF; 64]) else { panic!() };
        assert_eq!(array.iter().collect::<Vec<_>>(), [-1; 32]);
    }

    #[test]
    fn half_precision_is_that_of_the_standard() {
        let cases = [
            (0x3C00, 1.0),
            (0xC000, -2.0),
            (0x7BFF, 65504.0),
            (0x0400, 6.103_515_6e-5),
            (0x0001, 5.960_464_5e-8),
            (0x83FF, -6.097_555e-5),
            (0x3555, 0.333_251_95),
            (0x7C00, f32::INFINITY),
            (0x0000, 0.0),
        ];
        for (bits, value) in cases {
            assert_eq!(half(bits).to_bits(), f32::to_bits(value), "{bits:04x}");
        }
        assert!(half(0x7E00).is_nan() && half(0x8000).is_sign_negative());
    }

    #[test]
    fn single_precision_multipliers_are_taken_for_the_numbers_they_stand_for() {
        let of = |multiplier: f64| DataflashScale::of_multiplier(multiplier);
        assert_eq!(of(0.01_f32.into()), Some(DataflashScale::Over(100.0)));
        assert_eq!(of(1e-7_f32.into()), Some(DataflashScale::Over(1e7)));
        assert_eq!(of(3.6_f32.into()), Some(DataflashScale::Times(3.6)));
        assert_eq!([of(1.0), of(3600.0)], [Some(DataflashScale::ONE), Some(DataflashScale::Times(3600.0))]);
        assert_eq!([of(0.0), of(f64::NAN), of(-1.0), of(f64::INFINITY)], [None; 4]);
    }
}
