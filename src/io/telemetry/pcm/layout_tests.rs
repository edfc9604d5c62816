//! Formats against places counted by hand, and every mistake against its message.

use super::super::calibration::Calibration;
use super::super::format::{ParameterLimits, SpecialWord};
use super::*;

fn parameter(name: &str, places: Vec<ParameterPlace>) -> ParameterSpec {
    ParameterSpec { name: name.into(), places, ..ParameterSpec::default() }
}

fn whole(word: u32) -> WordPart {
    WordPart { word, bits: None }
}

fn spec() -> PcmFormatSpec {
    let subframe_id = SubframeId { part: whole(1), first_value: 0, direction: CountDirection::Up };
    PcmFormatSpec { words: 13, minor_frames: 8, subframe_id: Some(subframe_id), ..PcmFormatSpec::default() }
}

#[test]
fn places_are_bits_of_the_minor_frame() {
    let twelve = SpecialWord { word: 3, bits: Some(12), parity: Some(Parity::Odd(ParityPlace::Leading)) };
    let parity = SpecialWord { word: 4, bits: None, parity: Some(Parity::Even(ParityPlace::Trailing)) };
    let mut spec = PcmFormatSpec { special_words: vec![parity, twelve], ..spec() };
    let frames = Some(FrameSet { first: 3, interval: Some(4) });
    spec.parameters = vec![
        parameter("super", vec![ParameterPlace { word_interval: Some(4), ..ParameterPlace::word(2) }]),
        parameter("sub", vec![ParameterPlace { frames, ..ParameterPlace::word(12) }]),
        parameter(
            "long",
            vec![ParameterPlace { parts: vec![whole(5), WordPart { word: 3, bits: Some((2, 11)) }], ..ParameterPlace::word(1) }],
        ),
        parameter(
            "bit",
            vec![ParameterPlace { parts: vec![WordPart { word: 4, bits: Some((15, 15)) }], ..ParameterPlace::word(1) }],
        ),
    ];
    let format = PcmFormat::new(spec).unwrap();
    // Pattern 32, words 1 and 2 of 16, word 3 of 12, nine more of 16.
    assert_eq!(format.minor_frame_bits(), 32 + 2 * 16 + 12 + 9 * 16);
    let found: Vec<(usize, u32, u32)> = format.places().iter().map(|place| (place.parameter, place.offset, place.bits)).collect();
    // Of the long one the first word sent is word 3, which begins with its parity bit.
    assert_eq!(found, [(0, 48, 16), (2, 64, 26), (3, 76, 1), (0, 108, 16), (0, 172, 16), (1, 204, 16)]);
    let long = &format.places()[1].parts;
    assert_eq!(*long, [PartLayout { word: 5, offset: 92, bits: 16 }, PartLayout { word: 3, offset: 66, bits: 10 }]);
    assert_eq!(format.places()[2].parts, [PartLayout { word: 4, offset: 90, bits: 1 }]);
    assert_eq!(format.subframe_part(), Some(PartLayout { word: 1, offset: 32, bits: 16 }));
    assert_eq!(format.rules(), SyncRules::for_length(32));
}

#[test]
fn every_mistake_has_its_place_and_numbers() {
    let refused = |change: &dyn Fn(&mut PcmFormatSpec)| {
        let mut spec = spec();
        change(&mut spec);
        PcmFormat::new(spec).unwrap_err().to_string()
    };
    let one = |change: &dyn Fn(&mut ParameterSpec)| {
        let mut changed = parameter("p", vec![ParameterPlace::word(2)]);
        change(&mut changed);
        refused(&|spec| spec.parameters = vec![changed.clone()])
    };
    let rules = SyncRules::for_length(32);
    for (found, expected) in [
        (refused(&|spec| spec.bit_rate = f64::NAN), "bit_rate: expected 1 to 100000000000 bits a second, found NaN"),
        (refused(&|spec| spec.bit_rate = 1e300), "bit_rate: expected 1 to 100000000000 bits a second, found 1"),
        (refused(&|spec| spec.bit_rate = 0.0), "bit_rate: expected 1 to 100000000000 bits a second, found 0"),
        (refused(&|spec| spec.sync.bits = 34), "sync.bits: expected 16 to 33, found 34"),
        (refused(&|spec| spec.sync.bits = 24), "sync.pattern: expected a pattern and a mask of 24 bits"),
        (refused(&|spec| spec.sync.mask = 0x7F), "sync.mask: expected at least 8 compared bits, found 7"),
        (refused(&|spec| spec.sync = SyncPattern::whole(0xAAAA, 16)), "differs from itself 2 bits further in 0 bits only"),
        (
            refused(&|spec| spec.rules = Some(SyncRules { check_frames: 0, ..rules })),
            "sync.check_frames: expected 1 to 16, found 0",
        ),
        (refused(&|spec| spec.rules = Some(SyncRules { lock_errors: 9, ..rules })), "sync.lock_errors: expected 0 to 8, found 9"),
        (refused(&|spec| spec.words = 1), "words: expected 2 to 4096, found 1"),
        (refused(&|spec| spec.word_bits = 33), "word_bits: expected 4 to 32, found 33"),
        (
            refused(&|spec| (spec.words, spec.word_bits) = (1024, 17)),
            "words: expected at most 16384 bits a minor frame, found 17423",
        ),
        (refused(&|spec| spec.minor_frames = 257), "minor_frames: expected 1 to 256, found 257"),
        (
            refused(&|spec| spec.special_words = vec![SpecialWord { word: 13, bits: None, parity: None }]),
            "special word 1: expected 1 to 12, found 13",
        ),
        (
            refused(&|spec| spec.special_words = vec![SpecialWord { word: 2, bits: None, parity: None }; 2]),
            "special word 2: word 2 is listed twice",
        ),
        (
            refused(&|spec| spec.special_words = vec![SpecialWord { word: 2, bits: Some(3), parity: None }]),
            "special word 1: expected 4 to 32, found 3",
        ),
        (
            refused(&|spec| spec.subframe_id.as_mut().unwrap().part = WordPart { word: 1, bits: Some((15, 16)) }),
            "subframe_id: 8 minor frames do not fit 2 bits counted from 0 up",
        ),
        (
            refused(&|spec| spec.subframe_id.as_mut().unwrap().direction = CountDirection::Down),
            "subframe_id: 8 minor frames do not fit 16 bits counted from 0 down",
        ),
        (one(&|p| p.name.clear()), "parameter 1 (\"\"), name: expected a name, found none"),
        (one(&|p| p.places.clear()), "parameter 1 (\"p\"), places: expected 1 to 4096 places, found 0"),
        (one(&|p| p.places = vec![ParameterPlace::word(13)]), "word: expected 1 to 12, found 13"),
        (one(&|p| p.places = vec![ParameterPlace::word(0)]), "word: expected 1 to 12, found 0"),
        (one(&|p| p.places[0].parts[0].bits = Some((9, 17))), "expected data bits 1 to 16 of word 2, found 9 to 17"),
        (one(&|p| p.places[0].parts[0].bits = Some((9, 8))), "found 9 to 8"),
        (one(&|p| p.places[0].parts = vec![whole(2); 5]), "encoding: unsigned takes 1 to 64 bits, found 80"),
        (one(&|p| p.encoding = RawEncoding::Ieee754Single), "encoding: ieee754_single takes 32 bits, found 16"),
        (one(&|p| p.places[0].word_interval = Some(0)), "word_interval: expected 1 to 12, found 0"),
        (one(&|p| p.places[0].frames = Some(FrameSet { first: 9, interval: None })), "frame: expected 1 to 8, found 9"),
        (
            one(&|p| p.places[0].frames = Some(FrameSet { first: 1, interval: Some(0) })),
            "frame_interval: expected 1 to 8, found 0",
        ),
        (
            one(&|p| p.limits = ParameterLimits { low: Some(2.0), high: Some(1.0), step: None }),
            "limits: expected a low limit below",
        ),
        (one(&|p| p.limits.step = Some(0.0)), "limits: expected a finite number above zero, found 0"),
        (one(&|p| p.calibration = Calibration::Table { pairs: vec![] }), "calibration: expected 1 to 65536 pairs, found 0"),
    ] {
        assert!(found.contains(expected), "{found}\n  for {expected}");
    }
    let mut twice = spec();
    twice.parameters = vec![parameter("p", vec![ParameterPlace::word(2)]); 2];
    assert!(PcmFormat::new(twice).unwrap_err().to_string().starts_with("parameter 2 (\"p\"), name"));
    let frames = Some(FrameSet { first: 1, interval: None });
    let without = PcmFormatSpec {
        subframe_id: None,
        parameters: vec![parameter("p", vec![ParameterPlace { frames, ..ParameterPlace::word(2) }])],
        ..spec()
    };
    assert!(PcmFormat::new(without).unwrap_err().to_string().contains("frame: expected a subframe identifier"));
}
