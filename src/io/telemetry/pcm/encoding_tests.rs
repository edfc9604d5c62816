//! Encodings against values worked out by hand, the standard's own examples, and each against its inverse.

use super::super::test_random::Random;
use super::*;

fn close(found: f64, expected: f64) -> bool {
    (found - expected).abs() <= 1e-15 * expected.abs()
}

#[test]
fn whole_numbers_of_four_bits_are_those_of_the_table() {
    let of =
        |encoding: RawEncoding| (0..16).map(|raw| encoding.decode(raw, 4).map_or(99, |value| value as i32)).collect::<Vec<_>>();
    assert_eq!(of(RawEncoding::Unsigned), (0..16).collect::<Vec<_>>());
    assert_eq!(of(RawEncoding::TwosComplement), [0, 1, 2, 3, 4, 5, 6, 7, -8, -7, -6, -5, -4, -3, -2, -1]);
    assert_eq!(of(RawEncoding::OnesComplement), [0, 1, 2, 3, 4, 5, 6, 7, -7, -6, -5, -4, -3, -2, -1, 0]);
    assert_eq!(of(RawEncoding::SignMagnitude), [0, 1, 2, 3, 4, 5, 6, 7, 0, -1, -2, -3, -4, -5, -6, -7]);
    assert_eq!(of(RawEncoding::OffsetBinary), (-8..8).collect::<Vec<_>>());
    assert_eq!(of(RawEncoding::Bcd), [0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 99, 99, 99, 99, 99, 99]);
}

#[test]
fn decimals_have_four_bits_a_digit() {
    assert_eq!(RawEncoding::Bcd.decode(0x1994, 16), Some(1994.0));
    assert_eq!(RawEncoding::Bcd.decode(0x3_9999, 18), Some(39_999.0));
    assert_eq!(RawEncoding::Bcd.decode(0x19A4, 16), None);
    assert_eq!(RawEncoding::Bcd.range(18), Some((0.0, 39_999.0)));
    assert_eq!(RawEncoding::Bcd.encode(4e4, 18), Some(RawWord { raw: 0x3_9999, saturated: true }));
}

#[test]
fn floating_point_of_1750a_is_as_in_the_examples_of_the_standard() {
    let two = |power: i32| f64::from(power).exp2();
    // Floating point, then extended precision.
    let single = [
        (0x7FFF_FF7F, (1.0 - two(-23)) * two(127)),
        (0x4000_007F, 0.5 * two(127)),
        (0x5000_0004, 0.625 * two(4)),
        (0x4000_0001, 0.5 * two(1)),
        (0x4000_0000, 0.5),
        (0x4000_00FF, 0.5 * two(-1)),
        (0x4000_0080, 0.5 * two(-128)),
        (0x0000_0000, 0.0),
        (0x8000_0000, -1.0),
        (0xBFFF_FF80, -(0.5 + two(-23)) * two(-128)),
        (0x9FFF_FF04, -(0.75 + two(-23)) * two(4)),
    ];
    for (raw, value) in single {
        assert!(close(RawEncoding::Mil1750A32.decode(raw, 32).unwrap(), value), "{raw:X}");
        assert_eq!(RawEncoding::Mil1750A32.encode(value, 32), Some(RawWord { raw, saturated: false }), "{raw:X}");
    }
    let double = [
        (0x4000_007F_0000, 0.5 * two(127)),
        (0x4000_0000_0000, 0.5),
        (0x4000_00FF_0000, 0.5 * two(-1)),
        (0x4000_0080_0000, 0.5 * two(-128)),
        (0x8000_007F_0000, -two(127)),
        (0x8000_0000_0000, -1.0),
        (0x8000_0080_0000, -two(-128)),
        (0xA000_00FF_0000, -0.75 * two(-1)),
        (0x4000_0001_0001, 1.0 + two(-38)),
    ];
    for (raw, value) in double {
        assert!(close(RawEncoding::Mil1750A48.decode(raw, 48).unwrap(), value), "{raw:X}");
        assert_eq!(RawEncoding::Mil1750A48.encode(value, 48), Some(RawWord { raw, saturated: false }), "{raw:X}");
    }
    // Rounding up to the next power of two; below the smallest; beyond the greatest.
    assert_eq!(RawEncoding::Mil1750A32.encode(1.0 - 1e-9, 32).unwrap().raw, 0x4000_0001);
    assert_eq!(RawEncoding::Mil1750A32.encode(1e-40, 32).unwrap().raw, 0);
    assert_eq!(RawEncoding::Mil1750A32.encode(1e39, 32), Some(RawWord { raw: 0x7FFF_FF7F, saturated: true }));
}

#[test]
fn ieee_754_is_that_of_the_machine_and_its_infinities_are_no_numbers() {
    assert_eq!(RawEncoding::Ieee754Single.decode(0x4148_0000, 32), Some(12.5));
    assert_eq!(RawEncoding::Ieee754Double.decode(0xC029_0000_0000_0000, 64), Some(-12.5));
    assert_eq!(RawEncoding::Ieee754Single.decode(0x7F80_0000, 32), None);
    assert_eq!(RawEncoding::Ieee754Double.decode(f64::NAN.to_bits(), 64), None);
}

#[test]
fn what_is_encoded_is_decoded_again() {
    let mut random = Random(5);
    for (encoding, _) in RawEncoding::ALL {
        let (least, most) = encoding.widths();
        for bits in least..=most {
            let (low, high) = encoding.range(bits).unwrap();
            for _ in 0..200 {
                let raw = random.next() & u64::MAX >> (64 - bits);
                let Some(value) = encoding.decode(raw, bits) else { continue };
                assert!((low..=high).contains(&value), "{encoding:?} {bits} {raw:X}");
                if matches!(encoding, RawEncoding::Mil1750A32 | RawEncoding::Mil1750A48) && value.abs() < f64::exp2(-128.0) {
                    // Not normalised, and below what can be: it is encoded as zero.
                    continue;
                }
                let again = encoding.encode(value, bits).unwrap();
                assert!(!again.saturated);
                let back = encoding.decode(again.raw, bits).unwrap();
                assert!(close(back, value) || bits > 53 && (back / value - 1.0).abs() < 1e-9, "{encoding:?} {bits} {raw:X}");
            }
            for (value, end) in [(f64::INFINITY, high), (f64::NEG_INFINITY, low)] {
                let word = encoding.encode(value, bits).unwrap();
                assert!(word.saturated, "{encoding:?} {bits}");
                assert!(close(encoding.decode(word.raw, bits).unwrap(), end), "{encoding:?} {bits} {end}");
            }
        }
        assert_eq!((encoding.decode(0, least - 1), encoding.decode(0, most + 1)), (None, None));
        assert_eq!(encoding.encode(f64::NAN, least), None);
    }
}

#[test]
fn bits_that_are_no_number_are_read_as_none() {
    for (encoding, name) in RawEncoding::ALL {
        let (bits, _) = encoding.widths();
        let none = encoding.no_number().map(|raw| encoding.decode(raw, bits));
        assert_eq!(none, name.starts_with("ieee754").then_some(None), "{name}");
    }
}
