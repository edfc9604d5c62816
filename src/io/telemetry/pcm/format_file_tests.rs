//! Files against the format that they stand for, and every mistake against its line and column.

use super::*;

const WHOLE: &str = r#"
name = "basic aircraft"
bit_rate = 2_000_000
line_code = "rnrz_l"
polarity = "normal"
words = 63
word_bits = 16
parity = "odd"
parity_place = "leading"
minor_frames = 16
[sync]
pattern = 0xFE6B_2840
bits = 32
mask = 0xFFFF_FFFE
lock_errors = 2
slip_bits = 1
[subframe_id]
word = 1
bits = [12, 15]
first_value = 15
counts = "down"
[[word]]
number = 4
bits = 12
parity = "none"
[[word]]
number = 5
parity_place = "trailing"
[[parameter]]
name = "p"
unit = "deg/s"
word = 2
word_interval = 16
encoding = "twos_complement"
calibration = { kind = "polynomial", coefficients = [0.0, 0.01], range = [-32000, 32000], outside = "flag" }
limits = { low = -200, high = 200 }
[[parameter]]
name = "oil_temperature"
word = 3
bits = [1, 12]
frame = 5
frame_interval = 8
calibration = { kind = "pair_wise_linear", pairs = [[0, 233], [4095, 433]] }
[[parameter]]
name = "altitude"
parts = [{ word = 10 }, { word = 11, bits = [1, 8] }]
[[parameter]]
name = "gear"
places = [{ word = 20, bits = [3, 3] }, { word = 40, bits = [3, 3], frame = 2 }]
calibration = { kind = "table", pairs = [[0, 0], [1, 100]] }
"#;

#[test]
fn every_key_is_read() {
    let place = ParameterPlace::word;
    let part = |word, bits| WordPart { word, bits };
    let frames = |first, interval| Some(FrameSet { first, interval });
    let named = |name: &str, places| ParameterSpec { name: name.into(), places, ..ParameterSpec::default() };
    let sync = SyncPattern { pattern: 0xFE6B_2840, mask: 0xFFFF_FFFE, bits: 32 };
    let expected = PcmFormatSpec {
        name: "basic aircraft".into(),
        bit_rate: 2e6,
        line_code: LineCode::RnrzL,
        polarity: PolarityRule::Normal,
        sync,
        rules: Some(SyncRules { lock_errors: 2, slip_bits: 1, ..SyncRules::for_length(31) }),
        words: 63,
        word_bits: 16,
        parity: Parity::Odd(ParityPlace::Leading),
        special_words: vec![
            SpecialWord { word: 4, bits: Some(12), parity: Some(Parity::None) },
            SpecialWord { word: 5, bits: None, parity: Some(Parity::Odd(ParityPlace::Trailing)) },
        ],
        minor_frames: 16,
        subframe_id: Some(SubframeId { part: part(1, Some((12, 15))), first_value: 15, direction: CountDirection::Down }),
        parameters: vec![
            ParameterSpec {
                unit: "deg/s".into(),
                encoding: RawEncoding::TwosComplement,
                calibration: Calibration::Polynomial {
                    coefficients: vec![0.0, 0.01],
                    range: Some((-32000.0, 32000.0)),
                    outside: OutsideRange::Flag,
                },
                limits: ParameterLimits { low: Some(-200.0), high: Some(200.0), step: None },
                ..named("p", vec![ParameterPlace { word_interval: Some(16), ..place(2) }])
            },
            ParameterSpec {
                calibration: Calibration::PairWiseLinear {
                    pairs: vec![(0.0, 233.0), (4095.0, 433.0)],
                    outside: OutsideRange::Refuse,
                },
                ..named(
                    "oil_temperature",
                    vec![ParameterPlace { parts: vec![part(3, Some((1, 12)))], frames: frames(5, Some(8)), ..place(3) }],
                )
            },
            named("altitude", vec![ParameterPlace { parts: vec![part(10, None), part(11, Some((1, 8)))], ..place(10) }]),
            ParameterSpec {
                calibration: Calibration::Table { pairs: vec![(0.0, 0.0), (1.0, 100.0)] },
                ..named(
                    "gear",
                    vec![
                        ParameterPlace { parts: vec![part(20, Some((3, 3)))], ..place(20) },
                        ParameterPlace { parts: vec![part(40, Some((3, 3)))], frames: frames(2, None), ..place(40) },
                    ],
                )
            },
        ],
    };
    let format = PcmFormat::from_toml(WHOLE).unwrap();
    assert_eq!(*format.spec(), expected);
    assert_eq!(format.minor_frame_bits(), 32 + 61 * 16 + 12);
}

#[test]
fn the_example_at_the_head_of_the_file_is_a_format() {
    let head = include_str!("format_file.rs").lines().map_while(|line| line.strip_prefix("//!"));
    let lines = head.skip_while(|line| *line != " ```toml").skip(1).take_while(|line| *line != " ```");
    let format = PcmFormat::from_toml(&lines.collect::<Vec<_>>().join("\n")).unwrap();
    assert_eq!(format.parameters().len(), 4);
}

#[test]
fn what_is_left_out_has_its_default() {
    let text = "bit_rate = 1e5\nwords = 9\nword_bits = 8\nsync = { pattern = 0xEB90, bits = 16 }\n";
    let expected = PcmFormatSpec {
        bit_rate: 1e5,
        words: 9,
        word_bits: 8,
        sync: SyncPattern::whole(0xEB90, 16),
        rules: Some(SyncRules::for_length(16)),
        ..PcmFormatSpec::default()
    };
    assert_eq!(*PcmFormat::from_toml(text).unwrap().spec(), expected);
}

#[test]
fn every_mistake_is_found_where_it_stands() {
    for (from, to, line, column, word) in [
        ("bit_rate", "bitrate", 3, 1, "nearest is `bit_rate`"),
        ("bit_rate = 2_000_000", "bit_rate = -1", 3, 12, "1 to 100000000000 bits a second, found -1"),
        ("\"rnrz_l\"", "\"rnrzl\"", 4, 13, "nearest is \"rnrz_l\""),
        ("\"normal\"", "\"upright\"", 5, 12, "automatic, normal, inverted, found \"upright\""),
        ("words = 63", "words = 6300", 6, 9, "2 to 4096, found 6300"),
        ("minor_frames = 16", "minor_frames = 300", 10, 16, "1 to 256, found 300"),
        ("bits = 32", "bits = 31", 12, 11, "pattern and a mask of 31 bits"),
        ("mask = 0xFFFF_FFFE", "mask = 1", 14, 8, "at least 8 compared bits"),
        ("lock_errors = 2", "lock_error = 2", 15, 1, "nearest is `lock_errors`"),
        ("slip_bits = 1", "slip_bits = 9", 16, 13, "0 to 8, found 9"),
        ("bits = [12, 15]", "bits = [13, 15]", 17, 1, "16 minor frames do not fit 3 bits"),
        ("counts = \"down\"", "counts = \"backwards\"", 21, 10, "up, down"),
        ("number = 4", "number = 63", 22, 1, "1 to 62, found 63"),
        ("parity = \"none\"", "parity = \"no\"", 25, 10, "none, odd, even"),
        ("word = 2\n", "word = 63\n", 32, 8, "1 to 62, found 63"),
        ("word_interval = 16", "word_interval = 0", 33, 17, "1 to 62, found 0"),
        ("\"twos_complement\"", "\"two_complement\"", 34, 12, "nearest is \"twos_complement\""),
        ("\"twos_complement\"", "\"ieee754_single\"", 34, 12, "takes 32 bits, found 15"),
        ("kind = \"polynomial\"", "kind = \"table\"", 35, 24, "table: expected pairs, found none"),
        ("[0.0, 0.01]", "[0.0, 0.01], pairs = []", 35, 15, "polynomial: expected no pairs"),
        ("low = -200", "low = 300", 36, 10, "low limit below"),
        ("frame = 5\n", "", 41, 18, "expected frame beside it"),
        ("frame = 5\n", "frame = 17\n", 41, 9, "1 to 16, found 17"),
        ("[[0, 233], [4095, 433]]", "[[0, 233], [0, 433]]", 43, 15, "0 behind 0 at pair 2"),
        ("parts = [{ word = 10 }", "word = 10\nparts = [{ word = 10 }", 47, 9, "found both"),
        ("places = [", "word = 9\nplaces = [", 50, 10, "nothing else"),
        ("{ word = 20, bits = [3, 3] }", "{ bits = [3, 3] }", 49, 11, "word, parts or places"),
        ("name = \"gear\"", "name = \"p\"", 49, 10, "a name that no other parameter has"),
        ("[sync]", "[[sync]]", 11, 1, "invalid type"),
        ("bit_rate = 2_000_000\n", "", 1, 1, "missing field `bit_rate`"),
    ] {
        let changed = WHOLE.replacen(from, to, 1);
        assert_ne!(changed, WHOLE, "{from}");
        let error = PcmFormat::from_toml(&changed).unwrap_err();
        assert!(error.what.contains(word), "{from} -> {to}: {error}");
        assert!((error.line, error.column) == (line, column), "{from} -> {to}: {error}");
    }
    assert_eq!(PcmFormat::from_toml("x").unwrap_err().line, 1);
}
