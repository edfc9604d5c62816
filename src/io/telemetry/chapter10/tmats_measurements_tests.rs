//! Measurements of setups written by hand.

use super::*;

/// A setup of one list with the attributes of its only measurement, and of its conversion.
fn only(name: &str, location: &str, conversion: &str) -> TmatsMeasurements {
    let text = format!(
        "D-4\\DLN:L;D-4\\ML\\N:1;D-4\\MN\\N-1:1;D-4\\MN-1-1:{name};D-4\\LT-1-1:WDFR;{location}C-2\\DCN:{name};{conversion}"
    );
    TmatsMeasurements::of_link(&Tmats::parse(text.as_bytes()), "L", &MeasurementMap::default())
}

const WORD_2: &str = "D-4\\MML\\N-1-1:1;D-4\\MNF\\N-1-1-1:1;D-4\\WP-1-1-1-1:2;D-4\\WI-1-1-1-1:0;D-4\\FP-1-1-1-1:1;\
    D-4\\FI-1-1-1-1:1;D-4\\WFM-1-1-1-1:FW;D-4\\WFT-1-1-1-1:M;D-4\\WFP-1-1-1-1:1;";

#[test]
fn a_whole_word_with_coefficients_is_a_channel_in_its_unit() {
    let found = only("P", WORD_2, "C-2\\MN3:DEG/SEC;C-2\\BFM:TWO;C-2\\DCT:COE;C-2\\CO\\N:1;C-2\\CO:-1.5;C-2\\CO-1:.01;");
    let expected = ParameterSpec {
        name: "p".into(),
        unit: "deg/s".into(),
        places: vec![ParameterPlace::word(2)],
        encoding: RawEncoding::TwosComplement,
        calibration: Calibration::Polynomial { coefficients: vec![-1.5, 0.01], range: None, outside: OutsideRange::Refuse },
        ..ParameterSpec::default()
    };
    assert_eq!(found, TmatsMeasurements { parameters: vec![expected], left_out: vec![], assumed: vec![] });
}

#[test]
fn fragments_are_joined_by_position_and_masks_select_bits() {
    let location = "D-4\\MNF\\N-1-1-1:2;D-4\\WP-1-1-1-1:7;D-4\\FP-1-1-1-1:5;D-4\\FI-1-1-1-1:32;D-4\\WFM-1-1-1-1:1110000000000001;\
        D-4\\WFP-1-1-1-1:2;D-4\\WP-1-1-1-2:9;D-4\\FP-1-1-1-2:5;D-4\\FI-1-1-1-2:32;D-4\\WFM-1-1-1-2:FW;D-4\\WFP-1-1-1-2:1;";
    let found = only(
        "LONG",
        location,
        "C-2\\BFM:UNS;C-2\\DCT:PRS;C-2\\PS\\N:2;C-2\\PS1:N;C-2\\PS3-1:10;C-2\\PS4-1:1;C-2\\PS3-2:0;C-2\\PS4-2:0;",
    );
    let [parameter] = &found.parameters[..] else { panic!("{found:?}") };
    let part = |word, bits| WordPart { word, bits };
    let place = ParameterPlace {
        parts: vec![part(9, None), part(7, Some((1, 3))), part(7, Some((16, 16)))],
        word_interval: None,
        frames: Some(FrameSet { first: 5, interval: Some(32) }),
    };
    assert_eq!(parameter.places, [place]);
    let pairs = vec![(0.0, 0.0), (10.0, 1.0)];
    assert_eq!(parameter.calibration, Calibration::PairWiseLinear { pairs, outside: OutsideRange::Refuse });
}

#[test]
fn what_cannot_be_decommutated_is_left_out_with_its_reason() {
    let cases = [
        ("X", "D-4\\WP-1-1-1-1:2;D-4\\WFT-1-1-1-1:L;", "", "most significant bit first"),
        ("X", "D-4\\WP-1-1-1-1:2;D-4\\EWP-1-1-1-1:9;", "", "interval with an end"),
        ("X", "D-4\\WP-1-1-1-1:2;D-4\\WFM-1-1-1-1:12;", "", "zeros and ones"),
        ("X", "D-4\\WP-1-1-1-1:2;D-4\\WFM-1-1-1-1:0000;", "", "without a one"),
        ("X", "", "", "no word position"),
        (
            "X",
            "D-4\\MNF\\N-1-1-1:2;D-4\\WP-1-1-1-1:2;D-4\\WP-1-1-1-2:3;D-4\\WFP-1-1-1-1:1;D-4\\WFP-1-1-1-2:1;",
            "",
            "one position",
        ),
        ("X", "D-4\\MNF\\N-1-1-1:2;D-4\\WP-1-1-1-1:2;D-4\\WP-1-1-1-2:3;D-4\\FP-1-1-1-2:2;", "", "different minor frames"),
        ("X", WORD_2, "C-2\\DCT:DER;", "conversion of kind DER"),
        ("X", WORD_2, "C-2\\BFM:BWT;", "binary format BWT"),
        ("X", WORD_2, "C-2\\DCT:PRS;C-2\\PS\\N:2;C-2\\PS1:Y;", "curve fitted"),
        ("X", WORD_2, "C-2\\DCT:COE;C-2\\CO\\N:1;C-2\\CO:0;C-2\\CO-1:;", "coefficient CO-1: expected a number, found none"),
        ("X", WORD_2, "C-2\\DCT:COE;C-2\\CO\\N:1;C-2\\CO:0;C-2\\CO-1:NaN;", "coefficient CO-1: expected a number, found NaN"),
        ("X", WORD_2, "C-2\\DCT:COE;C-2\\CO:0;C-2\\CO-1:1;", "no order of its polynomial"),
        ("X", WORD_2, "C-2\\DCT:COE;C-2\\CO\\N:0;C-2\\CO:0;C-2\\CO-1:1;", "CO-1 stands beyond the 0 of CO\\N"),
        ("X", WORD_2, "C-2\\DCT:COE;C-2\\CO\\N:1;C-2\\CO:0;C-2\\CO-1:1;C-2\\CO-1:2;", "CO-1 stands twice"),
        ("X", WORD_2, "C-2\\CO\\N:1;C-2\\CO:0;C-2\\CO-1:1;", "CO without a kind of conversion"),
        ("X", WORD_2, "C-2\\PS\\N:1;C-2\\PS3-1:0;C-2\\PS4-1:0;", "without a kind of conversion"),
        ("X", WORD_2, "C-2\\DCT:PRS;C-2\\PS\\N:0;C-2\\PS3-1:0;", "PS3-1 stands beyond the 0 of PS\\N"),
        ("X", "D-4\\WP-1-1-1-1:2;D-4\\WP-1-1-1-1:3;", "", "WP-1-1-1-1 stands twice"),
        ("X", WORD_2, "C-2\\DCT:PRS;C-2\\PS\\N:1;C-2\\PS3-1:0;", "PS4-1: expected a number, found none"),
        ("X", "D-4\\WP-1-1-1-1:2;D-4\\FP-1-1-1-1:first;", "", "FP-1-1-1-1: expected a whole number, found first"),
        ("X", "D-4\\WP-1-1-1-1:2;D-4\\MN1-1-1:OD;", "", "parity of its own (MN1 OD)"),
        ("X", "D-4\\WP-1-1-1-1:2;D-4\\MN1-1-1:OD;P-4\\DLN:L;P-4\\F3:EV;", "", "parity of its own (MN1 OD)"),
        ("q", WORD_2, "C-2\\BFM:TWO;", "no engineering unit"),
        ("q", WORD_2, "C-2\\MN3:FURLONG;", "unknown unit"),
    ];
    for (name, location, conversion, expected) in cases {
        let found = only(name, location, conversion);
        assert!(found.parameters.is_empty(), "{expected}: {found:?}");
        assert!(found.left_out.iter().any(|why| why.contains(expected)), "{expected}: {found:?}");
    }
    assert_eq!(
        TmatsMeasurements::of_link(&Tmats::parse(b"P-1\\DLN:L;"), "L", &MeasurementMap::default()),
        TmatsMeasurements::default()
    );
}

#[test]
fn a_channel_without_binary_format_is_read_as_unsigned_and_said_so() {
    let found = only("P", WORD_2, "C-2\\MN3:DEG/S;");
    assert_eq!(found.parameters.len(), 1);
    assert_eq!(found.assumed, ["measurement P: no binary format (BFM of its group C): read as unsigned"]);
    assert_eq!(only("X", WORD_2, "").assumed, [""; 0]);
    assert_eq!(only("P", WORD_2, "C-2\\MN3:DEG/S;C-2\\BFM:TWO;").assumed, [""; 0]);
}

#[test]
fn parity_of_all_words_measurements_beyond_the_list_and_counts_as_units() {
    let same = only("X", "D-4\\WP-1-1-1-1:2;D-4\\MN1-1-1:OD;P-4\\DLN:L;P-4\\F3:OD;", "");
    assert_eq!((same.parameters.len(), same.left_out), (1, vec![]));
    let beyond = only("X", "D-4\\WP-1-1-1-1:2;D-4\\MN-1-2:R;D-4\\WP-1-2-1-1:3;", "");
    assert_eq!(
        (beyond.parameters.len(), &beyond.left_out[..]),
        (1, &["measurement R: stands beyond the 1 of MN\\N-1".to_owned()][..])
    );
    let counts = only("P", WORD_2, "C-2\\MN3:DEG/S;C-2\\BFM:TWO;C-2\\DCT:NON;");
    assert_eq!(counts.assumed, ["measurement P: no conversion (DCT NON): its counts are taken as deg/s"]);
    let float = only("P", WORD_2, "C-2\\MN3:DEG/S;C-2\\BFM:FPT;C-2\\FPF:IEEE 32;C-2\\DCT:NON;");
    assert_eq!(float.assumed, [""; 0]);
}

#[test]
fn units_as_setups_write_them_are_units_of_channels() {
    let rates = ["DEG/S", "DEG/SEC", "RAD/SEC"].map(|unit| ("P", unit));
    let accelerations = ["M/S2", "FT/S2", "M/SEC2", "M/S^2", "FT/S^2", "G", "G'S", "M/S/S"].map(|unit| ("AX", unit));
    let speeds = ["KT", "KTS", "KNOTS", "FPS", "MPS", "M/SEC", "FT/SEC", "KM/H"].map(|unit| ("TAS", unit));
    for (name, unit) in rates.into_iter().chain(accelerations).chain(speeds) {
        let found = only(name, WORD_2, &format!("C-2\\MN3:{unit};C-2\\BFM:TWO;"));
        assert_eq!(found.left_out, [""; 0], "{unit}");
        assert_eq!(found.parameters.len(), 1, "{unit}");
    }
}

#[test]
fn a_map_says_which_measurement_is_which_channel() {
    let text = "D-4\\DLN:L;D-4\\MN\\N-1:3;D-4\\MN-1-1:ROLL RATE;D-4\\WP-1-1-1-1:2;D-4\\MN-1-2:NX;D-4\\WP-1-2-1-1:3;\
        D-4\\MN-1-3:P;D-4\\WP-1-3-1-1:4;C-1\\DCN:Roll Rate;C-1\\MN3:DEG/S;C-1\\BFM:TWO;C-2\\DCN:NX;C-2\\MN3:COUNTS;\
        C-3\\DCN:P;C-3\\MN3:DEG/S;";
    let tmats = Tmats::parse(text.as_bytes());
    let map = MeasurementMap::from_toml("[measurements]\np = \"roll rate\"\nax = { name = \"NX\", unit = \"g\" }\n").unwrap();
    let found = TmatsMeasurements::of_link(&tmats, "L", &map);
    let named: Vec<(&str, &str, RawEncoding)> =
        found.parameters.iter().map(|one| (one.name.as_str(), one.unit.as_str(), one.encoding)).collect();
    assert_eq!(named, [("p", "deg/s", RawEncoding::TwosComplement), ("ax", "g", RawEncoding::Unsigned)]);
    assert_eq!(found.left_out, ["measurement P: roll rate is the channel p, as the map says"]);
}
