//! Streams against minor frames written by hand, and the way back through frame synchroniser and decommutator.

use super::super::calibration::{Calibration, OutsideRange};
use super::super::decommutator::{Decommutator, PcmSample, SampleFlags};
use super::super::encoding::RawEncoding;
use super::super::format::{
    CountDirection, FrameSet, ParameterPlace, ParameterSpec, PcmFormatSpec, SpecialWord, SubframeId, WordPart,
};
use super::super::frame_sync::FrameSynchronizer;
use super::super::sync_pattern::SyncPattern;
use super::*;

fn whole(word: u32) -> WordPart {
    WordPart { word, bits: None }
}

/// Every encoding and calibration, super- and subcommutation, concatenation, parity of both kinds; words of 11 bits.
fn rich(line_code: LineCode) -> PcmFormat {
    let one = |name: &str, encoding, calibration, place| ParameterSpec {
        name: name.into(),
        encoding,
        calibration,
        places: vec![place],
        ..ParameterSpec::default()
    };
    let word = ParameterPlace::word;
    let frames = |first, interval| Some(FrameSet { first, interval });
    let parts = |words: &[u32]| ParameterPlace { parts: words.iter().map(|w| whole(*w)).collect(), ..word(1) };
    let line = |slope| Calibration::Polynomial { coefficients: vec![-3.0, slope], range: None, outside: OutsideRange::Refuse };
    let pairs = vec![(-1024.0, -8.0), (0.0, 0.0), (1023.0, 30.0)];
    let parameters = vec![
        one("a", RawEncoding::TwosComplement, line(0.01), ParameterPlace { word_interval: Some(5), ..word(2) }),
        one("b", RawEncoding::OffsetBinary, Calibration::PairWiseLinear { pairs, outside: OutsideRange::Refuse }, word(3)),
        one(
            "c",
            RawEncoding::Unsigned,
            Calibration::Polynomial { coefficients: vec![1.0, 0.0, 1e-4], range: None, outside: OutsideRange::Refuse },
            ParameterPlace { frames: frames(1, Some(4)), ..word(4) },
        ),
        one("d", RawEncoding::SignMagnitude, Calibration::Identity, ParameterPlace { frames: frames(2, Some(2)), ..word(4) }),
        one("e", RawEncoding::Ieee754Single, Calibration::Identity, parts(&[5, 6, 8])),
        one("f", RawEncoding::Mil1750A32, Calibration::Identity, parts(&[11, 10, 9])),
        one("g", RawEncoding::Bcd, Calibration::Identity, word(13)),
        one("h", RawEncoding::OnesComplement, Calibration::Identity, ParameterPlace { frames: frames(3, None), ..word(14) }),
    ];
    let special = |word, bits, parity| SpecialWord { word, bits: Some(bits), parity: Some(parity) };
    let special_words = vec![
        special(8, 11, Parity::Odd(ParityPlace::Trailing)),
        special(11, 11, Parity::Even(ParityPlace::Leading)),
        special(1, 4, Parity::None),
        special(13, 12, Parity::None),
    ];
    let id = SubframeId { part: WordPart { word: 1, bits: Some((2, 4)) }, first_value: 7, direction: CountDirection::Down };
    PcmFormat::new(PcmFormatSpec {
        bit_rate: 1e5,
        line_code,
        words: 17,
        word_bits: 11,
        special_words,
        sync: SyncPattern::whole(0xFA_F320, 24),
        minor_frames: 8,
        subframe_id: Some(id),
        parameters,
        ..PcmFormatSpec::default()
    })
    .unwrap()
}

/// Something smooth for each parameter that its word can hold.
fn truth(parameter: usize, time_s: f64) -> f64 {
    let turn = libm::sin(time_s * 300.0 + parameter as f64);
    match parameter {
        0 => 5.0 * turn,
        1 => 11.0 + 18.0 * turn,
        2 => 200.0 + 150.0 * turn,
        6 => (400.0 + 390.0 * turn).round(),
        4 | 5 => 1e3 * turn,
        _ => (900.0 * turn).round(),
    }
}

fn decoded(format: &PcmFormat, line: &[u8]) -> (Vec<PcmSample>, Decommutator) {
    let spec = format.spec();
    let mut synchronizer =
        FrameSynchronizer::new(spec.sync, format.rules(), spec.polarity, spec.line_code, format.minor_frame_bits());
    let mut decommutator = Decommutator::new(format);
    let clock = BitClock { start_s: 5.0, bit_rate: spec.bit_rate };
    let mut samples = Vec::new();
    let mut rest = line;
    while !rest.is_empty() {
        rest = &rest[synchronizer.take(rest)..];
        while let Some(frame) = synchronizer.next_frame() {
            decommutator.minor_frame(&frame, &clock, |sample| samples.push(sample));
        }
    }
    while let Some(frame) = synchronizer.last_frame() {
        decommutator.minor_frame(&frame, &clock, |sample| samples.push(sample));
    }
    (samples, decommutator)
}

#[test]
fn values_come_back_at_their_times_within_half_a_step() {
    for (code, inverted) in [(LineCode::NrzL, false), (LineCode::NrzL, true), (LineCode::RnrzL, false), (LineCode::RnrzL, true)] {
        let format = rich(code);
        let mut encoder = PcmEncoder::new(&format, 5.0).unwrap();
        if inverted {
            encoder = encoder.inverted();
        }
        let mut line = Vec::new();
        let mut asked = Vec::new();
        for _ in 0..64 {
            let value = |parameter, time_s| {
                let value = truth(parameter, time_s);
                asked.push((parameter, time_s, value));
                value
            };
            encoder.minor_frame(value, &mut line).unwrap();
        }
        encoder.finish(&mut line);
        assert_eq!((encoder.saturated(), line.len()), (0, (64 * format.minor_frame_bits()).div_ceil(8)));
        let (samples, decommutator) = decoded(&format, &line);
        let counters = decommutator.counters();
        assert_eq!((counters.minor_frames, counters.parity_errors, counters.withheld_frames), (64, 0, 0), "{code:?}");
        assert_eq!((counters.no_value, counters.subframe_id.jumps), (0, 0));
        assert_eq!(samples.len(), asked.len());
        for (sample, (parameter, time_s, value)) in samples.iter().zip(&asked) {
            assert_eq!((sample.parameter, sample.flags), (*parameter, SampleFlags::NONE));
            assert!((sample.time_s - time_s).abs() < 1e-9);
            let step = match parameter {
                0 => 0.01,
                1 => 30.0 / 1023.0,
                2 => 0.41,
                4 | 5 => 2e-4,
                _ => 0.0,
            };
            let found = sample.value.unwrap();
            assert!((found - value).abs() <= step / 2.0 + 1e-9, "{parameter} at {time_s}: {value} came back as {found}");
        }
    }
}

#[test]
fn a_minor_frame_is_the_one_written_by_hand() {
    let parity = SpecialWord { word: 2, bits: Some(9), parity: Some(Parity::Even(ParityPlace::Trailing)) };
    let parameter = ParameterSpec { name: "x".into(), places: vec![ParameterPlace::word(2)], ..ParameterSpec::default() };
    let id = SubframeId { part: whole(1), first_value: 0, direction: CountDirection::Up };
    let spec = PcmFormatSpec {
        sync: SyncPattern::whole(0xEB90, 16),
        words: 3,
        word_bits: 8,
        special_words: vec![parity],
        minor_frames: 2,
        subframe_id: Some(id),
        parameters: vec![parameter],
        ..PcmFormatSpec::default()
    };
    let format = PcmFormat::new(spec).unwrap();
    let mut encoder = PcmEncoder::new(&format, 0.0).unwrap();
    let mut line = Vec::new();
    encoder.minor_frame(|_, _| f64::from(0b1010_0100), &mut line).unwrap();
    encoder.minor_frame(|_, _| 255.4, &mut line).unwrap();
    encoder.minor_frame(|_, _| 300.0, &mut line).unwrap();
    encoder.finish(&mut line);
    // 33 bits each: EB90 00 A4+1, EB90 01 FF+0, EB90 00 FF+0.
    let bits = "111010111001000000000000101001001\
                111010111001000000000001111111110\
                111010111001000000000000111111110";
    let expected: Vec<u8> = format!("{bits}00000")
        .as_bytes()
        .chunks(8)
        .map(|byte| u8::from_str_radix(std::str::from_utf8(byte).unwrap(), 2).unwrap())
        .collect();
    assert_eq!((line, encoder.saturated(), encoder.bit()), (expected, 1, 99));
}

#[test]
fn what_cannot_be_sent_is_refused() {
    let mut spec = rich(LineCode::NrzL).spec().clone();
    spec.parameters[0].calibration =
        Calibration::Polynomial { coefficients: vec![0.0, 0.0, 1.0], range: None, outside: OutsideRange::Flag };
    let format = PcmFormat::new(spec).unwrap();
    let error = PcmEncoder::new(&format, 0.0).unwrap_err().to_string();
    assert!(
        error.starts_with("parameter 1: its calibration has no inverse: it is not strictly monotone from -1024 to 1023"),
        "{error}"
    );
    let mut encoder = PcmEncoder::new(&rich(LineCode::NrzL), 0.0).unwrap();
    let mut line = Vec::new();
    let error = encoder.minor_frame(|parameter, _| if parameter == 1 { f64::NAN } else { 0.0 }, &mut line).unwrap_err();
    assert!(matches!(error, PcmEncoderError::NoNumber { parameter: 1, .. }) && line.is_empty());
}
