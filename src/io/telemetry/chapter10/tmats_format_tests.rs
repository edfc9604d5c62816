//! Formats of setups written by hand.

use super::*;
use crate::io::telemetry::pcm::format::FrameSet;

const SETUP: &str = "R-1\\TK1-1:3;R-1\\CDLN-1:A;P-1\\DLN:A;P-1\\D1:NRZ-L;P-1\\D2:204800;P-1\\D4:N;P-1\\D7:N;P-1\\F1:16;P-1\\F2:M;\
    P-1\\F3:NO;P-1\\MF\\N:4;P-1\\MF1:31;P-1\\MF2:512;P-1\\MF4:32;P-1\\MF5:11111110011010110010100001000000;P-1\\ISF\\N:1;\
    P-1\\ISF1-1:S;P-1\\ISF2-1:ID;P-1\\IDC1-1:1;P-1\\IDC3-1:15;P-1\\IDC4-1:2;P-1\\IDC6-1:1;P-1\\IDC7-1:2;P-1\\IDC10-1:INC;\
    P-1\\MFW1-1:5;P-1\\MFW2-1:20;D-1\\DLN:A;D-1\\MN\\N-1:3;D-1\\MN-1-1:P;D-1\\WP-1-1-1-1:2;D-1\\WI-1-1-1-1:8;\
    D-1\\MN-1-2:OUTSIDE;D-1\\WP-1-2-1-1:99;D-1\\MN-1-3:SUB;D-1\\WP-1-3-1-1:3;D-1\\FP-1-3-1-1:2;D-1\\FI-1-3-1-1:2;\
    C-1\\DCN:P;C-1\\MN3:DEG/S;C-1\\BFM:TWO;C-1\\DCT:NON;";

#[test]
fn a_channel_is_a_format_with_its_measurements() {
    let found = TmatsChannel::of_channel(&Tmats::parse(SETUP.as_bytes()), 3, &MeasurementMap::default()).unwrap();
    let spec = found.format.spec();
    assert_eq!((spec.bit_rate, spec.words, spec.word_bits, spec.minor_frames), (204_800.0, 31, 16, 4));
    assert_eq!((spec.sync, spec.polarity), (SyncPattern::whole(0xFE6B_2840, 32), PolarityRule::Normal));
    let id = SubframeId { part: WordPart { word: 1, bits: Some((15, 16)) }, first_value: 0, direction: CountDirection::Up };
    assert_eq!(spec.subframe_id, Some(id));
    // 32 bits of pattern, 29 words of 16 and one of 20.
    assert_eq!(found.format.minor_frame_bits(), 32 + 29 * 16 + 20);
    let names: Vec<&str> = spec.parameters.iter().map(|parameter| parameter.name.as_str()).collect();
    assert_eq!(names, ["p", "SUB"]);
    assert_eq!(spec.parameters[0].places[0].word_interval, Some(8));
    assert_eq!(spec.parameters[1].places[0].frames, Some(FrameSet { first: 2, interval: Some(2) }));
    assert_eq!(found.left_out.len(), 1);
    assert!(found.left_out[0].contains("OUTSIDE"), "{:?}", found.left_out);
}

#[test]
fn what_the_setup_does_not_say_is_asked_for() {
    for (attribute, expected) in [
        ("P-1\\D2:204800;", "P-1\\D2: expected a value"),
        ("P-1\\MF1:31;", "P-1\\MF1"),
        ("P-1\\F1:16;", "P-1\\F1"),
        ("P-1\\MF5:11111110011010110010100001000000;", "P-1\\MF5"),
    ] {
        let without = SETUP.replace(attribute, "");
        assert_ne!(without, SETUP);
        let said = TmatsChannel::of_channel(&Tmats::parse(without.as_bytes()), 3, &MeasurementMap::default()).unwrap_err();
        assert!(said.contains(expected), "{said}");
    }
    let fast = SETUP.replace("P-1\\D2:204800;", "P-1\\D2:fast;");
    let said = TmatsChannel::of_channel(&Tmats::parse(fast.as_bytes()), 3, &MeasurementMap::default()).unwrap_err();
    assert_eq!(said, "P-1\\D2: expected a value, found one that cannot be read");
    let reversed = SETUP.replace("P-1\\F2:M;", "P-1\\F2:L;");
    assert!(
        TmatsChannel::of_channel(&Tmats::parse(reversed.as_bytes()), 3, &MeasurementMap::default())
            .unwrap_err()
            .contains("least significant")
    );
    assert!(TmatsChannel::of_channel(&Tmats::parse(SETUP.as_bytes()), 7, &MeasurementMap::default()).is_err());
}

#[test]
fn a_group_that_says_two_things_is_refused() {
    let of = |more: &str| {
        let text = format!("{SETUP}{more}");
        TmatsChannel::of_channel(&Tmats::parse(text.as_bytes()), 3, &MeasurementMap::default())
            .map(|found| found.format.spec().clone())
    };
    for more in ["P-1\\D2:409600;", "P-1\\F3:OD;", "P-1\\MFW2-1:12;", "P-1\\MF5:01;"] {
        assert!(of(more).unwrap_err().contains("stands twice, with different values"), "{more}");
    }
    assert!(of("P-2\\DLN:A;P-2\\D1:NRZ-L;").unwrap_err().contains("2 groups P describe the data link A"));
    assert_eq!(of("P-1\\D2:204800;P-2\\DLN:B;P-1\\TF:ONE;P-1\\TF:TWO;"), of(""));
}

#[test]
fn unpacked_words_whose_lengths_contradict_the_frame_are_refused() {
    let of = |text: &str| TmatsChannel::of_channel(&Tmats::parse(text.as_bytes()), 3, &MeasurementMap::default());
    // 32 bits of pattern, 29 words of 16 and one of 20: MF2 says 512.
    let unpacked = format!("{SETUP}R-1\\PDP-1:UN;");
    assert!(of(&unpacked).unwrap_err().contains("make 516: which of them is right is not known"), "{:?}", of(&unpacked));
    assert!(of(&unpacked.replace("P-1\\MF2:512;", "P-1\\MF2:516;")).is_ok());
    assert!(of(&unpacked.replace("PDP-1:UN", "PDP-1:TM")).is_ok());
}

#[test]
fn thousands_of_measurements_are_laid_out_once_each() {
    use std::fmt::Write;
    let mut text = SETUP.replace("D-1\\MN\\N-1:3;", "D-1\\MN\\N-1:4096;");
    for n in 4..=4096 {
        let word = n % 29 + 2;
        let _ = write!(text, "D-1\\MN-1-{n}:M{n};D-1\\WP-1-{n}-1-1:{word};C-{n}\\DCN:M{n};C-{n}\\BFM:UNS;");
    }
    let tmats = Tmats::parse(text.as_bytes());
    let begun = std::time::Instant::now();
    let found = TmatsChannel::of_channel(&tmats, 3, &MeasurementMap::default()).unwrap();
    let took = begun.elapsed();
    // Words 2 to 30, of which the last does not exist here, and the measurement that is outside before.
    assert_eq!(found.format.parameters().len() + found.left_out.len(), 4096, "{:?}", &found.left_out[..3]);
    eprintln!("4096 measurements in {took:?}");
    assert!(took < std::time::Duration::from_secs(2), "{took:?}");
}
