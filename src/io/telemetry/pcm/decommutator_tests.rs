//! Samples of minor frames written bit by bit, with times and flags worked out by hand.

use super::super::bits::write_bits;
use super::super::calibration::{Calibration, OutsideRange};
use super::super::encoding::RawEncoding;
use super::super::format::Parity;
use super::super::format::{
    CountDirection, FrameSet, ParameterLimits, ParameterPlace, ParityPlace, PcmFormatSpec, SpecialWord, SubframeId, WordPart,
};
use super::super::frame_sync::NextSync;
use super::*;

const CLOCK: BitClock = BitClock { start_s: 100.0, bit_rate: 1000.0 };

fn whole(word: u32) -> WordPart {
    WordPart { word, bits: None }
}

/// Pattern 16, then seven words: 1 the identifier, 6 of 12 bits with leading odd parity, else 16 bits.
fn format() -> PcmFormat {
    let one =
        |name: &str, place: ParameterPlace| ParameterSpec { name: name.into(), places: vec![place], ..ParameterSpec::default() };
    let pair = OutsideRange::Flag;
    let parameters = vec![
        ParameterSpec {
            encoding: RawEncoding::TwosComplement,
            calibration: Calibration::Polynomial { coefficients: vec![1.0, 0.5], range: None, outside: pair },
            limits: ParameterLimits { low: Some(-10.0), high: Some(10.0), step: None },
            ..one("rate", ParameterPlace { word_interval: Some(2), ..ParameterPlace::word(2) })
        },
        one("sub", ParameterPlace { frames: Some(FrameSet { first: 2, interval: Some(2) }), ..ParameterPlace::word(3) }),
        one(
            "long",
            ParameterPlace { parts: vec![whole(7), WordPart { word: 5, bits: Some((9, 16)) }], ..ParameterPlace::word(1) },
        ),
        ParameterSpec {
            encoding: RawEncoding::Bcd,
            ..one("digits", ParameterPlace { parts: vec![WordPart { word: 6, bits: Some((4, 11)) }], ..ParameterPlace::word(1) })
        },
    ];
    let special = SpecialWord { word: 6, bits: Some(12), parity: Some(Parity::Odd(ParityPlace::Leading)) };
    let subframe_id = Some(SubframeId { part: whole(1), first_value: 1, direction: CountDirection::Up });
    let sync = super::super::sync_pattern::SyncPattern::whole(0xEB90, 16);
    PcmFormat::new(PcmFormatSpec {
        bit_rate: 1000.0,
        sync,
        words: 8,
        special_words: vec![special],
        minor_frames: 4,
        subframe_id,
        parameters,
        ..PcmFormatSpec::default()
    })
    .unwrap()
}

/// Words 1 to 7.
fn bytes(words: [u64; 7]) -> Vec<u8> {
    let mut bytes = vec![0; 16];
    write_bits(&mut bytes, 0, 16, 0xEB90);
    let mut at = 16;
    for (word, bits) in words.into_iter().zip([16, 16, 16, 16, 16, 12, 16]) {
        write_bits(&mut bytes, at, bits, word);
        at += bits as usize;
    }
    bytes
}

fn samples(decommutator: &mut Decommutator, bytes: &[u8], first_bit: u64) -> Vec<PcmSample> {
    let mut found = Vec::new();
    decommutator.minor_frame(&MinorFrame::synchronised(bytes, 124, first_bit), &CLOCK, |sample| found.push(sample));
    found
}

#[test]
fn samples_have_values_times_and_flags_of_their_words() {
    let format = format();
    assert_eq!(format.minor_frame_bits(), 124);
    let mut decommutator = Decommutator::new(&format);
    // Word 6: its parity bit makes the four ones of 1001 0101 odd.
    let found = samples(&mut decommutator, &bytes([2, 0xFFFE, 77, 18, 0xAB34, 0b1000_1001_0101, 0x1234]), 2480);
    let sample = |parameter, bit: u32, raw, value: f64, flags| PcmSample {
        parameter,
        time_s: 100.0 + f64::from(2480 + bit) / 1000.0,
        raw,
        value: Some(value),
        flags,
    };
    let expected = [
        sample(0, 32, 0xFFFE, 0.0, SampleFlags::NONE),
        sample(1, 48, 77, 77.0, SampleFlags::NONE),
        sample(0, 64, 18, 10.0, SampleFlags::NONE),
        sample(2, 80, 0x12_3434, f64::from(0x12_3434), SampleFlags::NONE),
        sample(3, 96, 0x95, 95.0, SampleFlags::NONE),
        sample(0, 96, 0x895, f64::NAN, SampleFlags::NONE),
    ];
    assert_eq!(found.len(), 6);
    // Word 6 is also the third place of the first parameter: 11 data bits.
    let mut by_offset = found.clone();
    by_offset.sort_by_key(|sample| (sample.time_s.to_bits(), std::cmp::Reverse(sample.parameter)));
    for (found, expected) in by_offset.iter().zip(&expected).take(5) {
        assert_eq!(found, expected);
    }
    let third = by_offset[5];
    assert_eq!((third.parameter, third.raw, third.value, third.flags), (0, 0x95, Some(75.5), SampleFlags::HIGH));
    assert_eq!(decommutator.counters().out_of_limits, 1);
}

#[test]
fn what_is_wrong_is_flagged_and_counted() {
    let mut decommutator = Decommutator::new(&format());
    // Wrong parity, no decimal digit, beyond the low limit.
    let found = samples(&mut decommutator, &bytes([1, 0x8000, 0, 0, 0, 0b0000_1010_1010, 0]), 0);
    let flags = |parameter: usize| {
        found.iter().filter(|sample| sample.parameter == parameter).map(|sample| sample.flags).collect::<Vec<_>>()
    };
    assert_eq!(flags(0)[0], SampleFlags::LOW);
    assert_eq!(flags(3), [SampleFlags::PARITY.with(SampleFlags::NO_VALUE)]);
    assert_eq!(found.iter().find(|sample| sample.parameter == 3).unwrap().value, None);
    assert!(flags(1).is_empty(), "minor frame 1 has no such word");
    let counters = decommutator.counters();
    assert_eq!((counters.parity_errors, counters.no_value, counters.samples, counters.withheld_frames), (1, 1, 5, 0));
    // A doubtful frame; a short one.
    let whole = bytes([2, 0, 0, 0, 0, 0, 0]);
    let doubtful = MinorFrame { next_sync: NextSync::Slipped(1), ..MinorFrame::synchronised(&whole, 124, 124) };
    let mut all = true;
    let number = decommutator.minor_frame(&doubtful, &CLOCK, |sample| all &= sample.flags.contains(SampleFlags::DOUBTFUL_FRAME));
    assert!(all && number == Some(2));
    assert_eq!(decommutator.minor_frame(&MinorFrame::synchronised(&whole[..15], 124, 248), &CLOCK, |_| panic!()), None);
    assert_eq!(decommutator.minor_frame(&MinorFrame::synchronised(&whole, 128, 248), &CLOCK, |_| panic!()), None);
    assert_eq!(decommutator.counters().wrong_length, 2);
}

#[test]
fn subcommutated_words_are_left_out_where_the_number_is_in_doubt() {
    let mut decommutator = Decommutator::new(&format());
    let mut subs = Vec::new();
    for (k, id) in [1, 2, 3, 2, 1, 2].into_iter().enumerate() {
        let found = samples(&mut decommutator, &bytes([id, 0, 10 + k as u64, 0, 0, 0, 0]), 124 * k as u64);
        subs.extend(found.iter().filter(|sample| sample.parameter == 1).map(|sample| sample.raw));
    }
    assert_eq!(subs, [11, 15]);
    let counters = decommutator.counters();
    assert_eq!((counters.withheld_frames, counters.subframe_id.jumps), (1, 1));
}

#[test]
fn a_minor_frame_with_its_own_time_has_samples_from_there() {
    let mut decommutator = Decommutator::new(&format());
    let bytes = bytes([1, 0, 0, 0, 0, 0, 0]);
    let (mut times, clock) = (Vec::new(), BitClock { start_s: 7.0, bit_rate: 1000.0 });
    decommutator.timed_minor_frame(&MinorFrame::synchronised(&bytes, 124, 0), &clock, |sample| times.push(sample.time_s));
    assert!((times[0] - 7.032).abs() < 1e-12 && (times[1] - 7.064).abs() < 1e-12);
}
