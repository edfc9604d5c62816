//! Raw words as numbers, and numbers as raw words.
//!
//! Consumes the bits of a parameter, 1 to 64 of them, most significant first; produces their value. What is no number (a
//! decimal digit above 9, the infinities and not-a-numbers of IEEE 754) gives none. Whole numbers beyond 2^53 are rounded to
//! the nearest
//! `f64`; the raw bits are exact.
//!
//! | encoding | bits | value |
//! | --- | --- | --- |
//! | unsigned | 1-64 | `r` |
//! | two's complement | 2-64 | `r` below `2^(n-1)`, else `r - 2^n` |
//! | ones' complement | 2-64 | `r` below `2^(n-1)`, else `r - (2^n - 1)`: two zeros |
//! | sign and magnitude | 2-64 | first bit the sign: two zeros |
//! | offset binary | 2-64 | `r - 2^(n-1)` |
//! | BCD | 4-64 | decimal digits of four bits from the last bit on; the first digit may have fewer |
//! | IEEE 754 | 32, 64 | single, double precision |
//! | MIL-STD-1750A | 32 | `m 2^e`: mantissa of 24 bits, from -1 to below 1, then exponent of 8, both two's complement |
//! | | 48 | the same with the mantissa's 16 lower bits behind the exponent (extended precision) |
//!
//! The floating-point formats are also listed in IRIG 106-07 Appendix O.

/// How a number stands in bits.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[expect(missing_docs, reason = "the table above")]
pub enum RawEncoding {
    #[default]
    Unsigned,
    TwosComplement,
    OnesComplement,
    SignMagnitude,
    OffsetBinary,
    Bcd,
    Ieee754Single,
    Ieee754Double,
    Mil1750A32,
    Mil1750A48,
}

/// Raw bits for a number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct RawWord {
    /// The bits, the last in the lowest place.
    pub raw: u64,
    /// Whether the number was out of the encoding's range and the nearest end was taken.
    pub saturated: bool,
}

impl RawEncoding {
    /// Every encoding with its name in files.
    pub const ALL: [(RawEncoding, &'static str); 10] = [
        (RawEncoding::Unsigned, "unsigned"),
        (RawEncoding::TwosComplement, "twos_complement"),
        (RawEncoding::OnesComplement, "ones_complement"),
        (RawEncoding::SignMagnitude, "sign_magnitude"),
        (RawEncoding::OffsetBinary, "offset_binary"),
        (RawEncoding::Bcd, "bcd"),
        (RawEncoding::Ieee754Single, "ieee754_single"),
        (RawEncoding::Ieee754Double, "ieee754_double"),
        (RawEncoding::Mil1750A32, "mil_std_1750a_32"),
        (RawEncoding::Mil1750A48, "mil_std_1750a_48"),
    ];

    /// The name in files.
    #[must_use]
    pub fn name(self) -> &'static str {
        Self::ALL.iter().find(|(encoding, _)| *encoding == self).map_or("", |(_, name)| name)
    }

    /// The fewest and the most bits.
    #[must_use]
    pub const fn widths(self) -> (u32, u32) {
        match self {
            RawEncoding::Unsigned => (1, 64),
            RawEncoding::TwosComplement
            | RawEncoding::OnesComplement
            | RawEncoding::SignMagnitude
            | RawEncoding::OffsetBinary => (2, 64),
            RawEncoding::Bcd => (4, 64),
            RawEncoding::Ieee754Single | RawEncoding::Mil1750A32 => (32, 32),
            RawEncoding::Ieee754Double => (64, 64),
            RawEncoding::Mil1750A48 => (48, 48),
        }
    }

    /// The value of that many bits; `None` where they are no number, or not as many as the encoding has.
    #[must_use]
    #[inline]
    pub fn decode(self, raw: u64, bits: u32) -> Option<f64> {
        let (least, most) = self.widths();
        if !(least..=most).contains(&bits) {
            return None;
        }
        let raw = raw & u64::MAX >> (64 - bits);
        let sign = 1_u64 << (bits - 1);
        let signed = (raw << (64 - bits)).cast_signed() >> (64 - bits);
        match self {
            RawEncoding::Unsigned => Some(raw as f64),
            RawEncoding::TwosComplement => Some(signed as f64),
            RawEncoding::OnesComplement => Some(if raw & sign == 0 { raw as f64 } else { (signed + 1) as f64 }),
            RawEncoding::SignMagnitude => {
                let size = (raw & (sign - 1)) as f64;
                Some(if raw & sign == 0 { size } else { 0.0 - size })
            }
            RawEncoding::OffsetBinary => Some((i128::from(raw) - i128::from(sign)) as f64),
            RawEncoding::Bcd => decimal(raw).map(|value| value as f64),
            RawEncoding::Ieee754Single => Some(f64::from(f32::from_bits(raw as u32))).filter(|value| value.is_finite()),
            RawEncoding::Ieee754Double => Some(f64::from_bits(raw)).filter(|value| value.is_finite()),
            RawEncoding::Mil1750A32 => Some(scaled(signed >> 8, raw as u8, 23)),
            RawEncoding::Mil1750A48 => Some(scaled(signed >> 24 << 16 | (raw & 0xFFFF).cast_signed(), (raw >> 16) as u8, 39)),
        }
    }

    /// Bits that are no number; `None` where every pattern is one, or the encoding is one of whole numbers.
    #[must_use]
    pub const fn no_number(self) -> Option<u64> {
        match self {
            RawEncoding::Ieee754Single => Some(0x7FC0_0000),
            RawEncoding::Ieee754Double => Some(0x7FF8_0000_0000_0000),
            _ => None,
        }
    }

    /// The bits nearest to a value, halves away from zero; `None` where the value is no number, or the encoding has not so
    /// many bits.
    #[must_use]
    pub fn encode(self, value: f64, bits: u32) -> Option<RawWord> {
        let (low, high) = self.range(bits)?;
        if value.is_nan() {
            return None;
        }
        let within = value.clamp(low, high);
        let fractions = matches!(
            self,
            RawEncoding::Ieee754Single | RawEncoding::Ieee754Double | RawEncoding::Mil1750A32 | RawEncoding::Mil1750A48
        );
        let saturated = !(low..=high).contains(&if fractions { value } else { value.round() });
        let mask = u64::MAX >> (64 - bits);
        let whole = within.round() as i128;
        let raw = match self {
            // The highest whole number of 64 bits is no `f64`.
            RawEncoding::Unsigned => whole.min(i128::from(mask)) as u64,
            RawEncoding::TwosComplement => whole.min(i128::from(mask >> 1)) as u64,
            RawEncoding::OnesComplement => {
                let whole = whole.clamp(-i128::from(mask >> 1), i128::from(mask >> 1));
                (if whole < 0 { whole - 1 } else { whole }) as u64
            }
            RawEncoding::SignMagnitude => {
                let size = whole.unsigned_abs().min(u128::from(mask >> 1)) as u64;
                if whole < 0 { size | 1 << (bits - 1) } else { size }
            }
            RawEncoding::OffsetBinary => (whole + (1_i128 << (bits - 1))).min(i128::from(mask)) as u64,
            RawEncoding::Bcd => packed_decimal((whole as u64).min(most_decimal(bits))),
            RawEncoding::Ieee754Single => u64::from((within as f32).to_bits()),
            RawEncoding::Ieee754Double => within.to_bits(),
            RawEncoding::Mil1750A32 => {
                let (mantissa, exponent) = normalised(within, 23);
                (mantissa << 8).cast_unsigned() | u64::from(exponent)
            }
            RawEncoding::Mil1750A48 => {
                let (mantissa, exponent) = normalised(within, 39);
                (mantissa >> 16 << 24).cast_unsigned() | u64::from(exponent) << 16 | mantissa.cast_unsigned() & 0xFFFF
            }
        };
        Some(RawWord { raw: raw & mask, saturated })
    }

    /// The least and the greatest value of that many bits.
    #[must_use]
    pub fn range(self, bits: u32) -> Option<(f64, f64)> {
        let (least, most) = self.widths();
        if !(least..=most).contains(&bits) {
            return None;
        }
        let (all, half) = ((u64::MAX >> (64 - bits)) as f64, power_of_two(bits.cast_signed() - 1));
        let most_1750 = |places| power_of_two(127) - power_of_two(127 - places);
        Some(match self {
            RawEncoding::Unsigned => (0.0, all),
            RawEncoding::TwosComplement | RawEncoding::OffsetBinary => (-half, half - 1.0),
            RawEncoding::OnesComplement | RawEncoding::SignMagnitude => (1.0 - half, half - 1.0),
            RawEncoding::Bcd => (0.0, most_decimal(bits) as f64),
            RawEncoding::Ieee754Single => (f64::from(f32::MIN), f64::from(f32::MAX)),
            RawEncoding::Ieee754Double => (f64::MIN, f64::MAX),
            RawEncoding::Mil1750A32 => (-power_of_two(127), most_1750(23)),
            RawEncoding::Mil1750A48 => (-power_of_two(127), most_1750(39)),
        })
    }
}

/// 2 to a power from -1022 to 1023.
fn power_of_two(power: i32) -> f64 {
    f64::from_bits(u64::from((power.clamp(-1022, 1023) + 1023).cast_unsigned()) << 52)
}

/// The value of a mantissa with so many binary places and of an exponent.
fn scaled(mantissa: i64, exponent: u8, places: i32) -> f64 {
    mantissa as f64 * power_of_two(i32::from(exponent.cast_signed()) - places)
}

/// Mantissa with so many binary places, from 1/2 to below 1 or from -1 to below -1/2, and exponent. A value smaller than the
/// smallest becomes zero.
fn normalised(value: f64, places: i32) -> (i64, u8) {
    let power = (value.to_bits() >> 52 & 0x7FF) as i32 - 1022;
    // What rounding brings to 1, and what is exactly -1/2, has another exponent.
    for exponent in [power - 1, power, power + 1] {
        if !(-128..=127).contains(&exponent) {
            continue;
        }
        let mantissa = (value * power_of_two(-exponent) * power_of_two(places)).round() as i64;
        let half = 1_i64 << (places - 1);
        if (half..2 * half).contains(&mantissa) || (-2 * half..-half).contains(&mantissa) {
            return (mantissa, (exponent as i8).cast_unsigned());
        }
    }
    (0, 0)
}

fn decimal(raw: u64) -> Option<u64> {
    (0..16).rev().map(|digit| raw >> (4 * digit) & 0xF).try_fold(0_u64, |sum, digit| (digit <= 9).then_some(sum * 10 + digit))
}

fn packed_decimal(mut value: u64) -> u64 {
    let mut raw = 0;
    for digit in 0..16 {
        raw |= (value % 10) << (4 * digit);
        value /= 10;
    }
    raw
}

/// The greatest decimal number of that many bits: nines behind a first digit that may be smaller.
fn most_decimal(bits: u32) -> u64 {
    let first = if bits.is_multiple_of(4) { 0 } else { (1 << (bits % 4)) - 1 };
    (0..bits / 4).fold(first, |sum, _| sum * 10 + 9)
}

#[cfg(test)]
#[path = "encoding_tests.rs"]
mod tests;
