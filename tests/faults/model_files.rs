//! A wrong model file is refused at the right line and column, with what was found and the nearest valid name.

use sideslip::flight::file::model_file::ModelFile;
use sideslip::flight::file::toml_reader::TomlError;

const GOOD: &str = r#"name = "good"
kind = "linear"
[trim]
u = 51.3
theta = 0.031
rotor_speed = 27.0
[trim.controls]
pedal = 0.1
[tolerance]
derivatives = 0.05
[derivatives.N]
v = 0.018
"v*|v|" = 0.001
pedal = -1.9
[[effect]]
kind = "actuator_lag"
control = "pedal"
tau = 0.15
[[effect]]
kind = "nonlinear"
axis = "N"
term = "p*v"
coefficient = 0.1
std = 0.01
"#;

/// The error of the good file with one line replaced.
fn error_with(line: usize, instead: &str) -> Option<TomlError> {
    let lines: Vec<&str> = GOOD.lines().enumerate().map(|(at, kept)| if at + 1 == line { instead } else { kept }).collect();
    ModelFile::parse(&lines.join("\n")).err()
}

/// A line, what it is replaced with, line and column of the error, what the error says.
type Case<'c> = (usize, &'c str, (usize, usize), &'c [&'c str]);

#[test]
fn the_good_file_is_good() {
    ModelFile::parse(GOOD).unwrap();
}

#[test]
fn each_wrong_line_is_named_with_its_place() {
    let cases: &[Case<'_>] = &[
        (1, "nmae = 'x'", (1, 1), &["nmae", "nearest is `name`"]),
        (2, "kind = 'level1'", (3, 2), &["expected a key of the file", "found `trim`"]),
        (2, "kind = 'liner'", (2, 8), &["found `liner`", "nearest is `linear`"]),
        (2, "", (1, 1), &["lacks `kind`"]),
        (4, "U = 51.3", (4, 1), &["found `U`", "nearest is `u`"]),
        (4, "", (3, 2), &["[trim] lacks `u`"]),
        (5, "", (3, 2), &["[trim] lacks `theta`"]),
        (5, "theta = nan", (5, 9), &["finite number", "nan"]),
        (5, "theta = 'up'", (5, 9), &["finite number", "string"]),
        (6, "rotor_speed = -27", (6, 15), &["more than zero", "-27"]),
        (8, "pedl = 0.1", (8, 1), &["expected a control", "nearest is `pedal`"]),
        (8, "rudder = 0.1", (14, 9), &["expected `rudder`", "found `pedal`"]),
        (10, "derivatives = -1", (10, 15), &["zero or more"]),
        (11, "[derivatives.n]", (11, 14), &["expected an axis", "nearest is `N`"]),
        (12, "beta = 1.0", (12, 1), &["found `beta`"]),
        (12, "v = [1]", (12, 5), &["array"]),
        (13, "\"v*p\" = 0.1", (13, 9), &["p*v"]),
        (13, "\"p*pedal\" = 0.1", (13, 13), &["control"]),
        (14, "lat_ciclic = 1", (14, 1), &["nearest is `lat_cyclic`"]),
        (14, "rudder = -1.9", (14, 10), &["expected `pedal`", "found `rudder`"]),
        (16, "kind = 'actuator_lagg'", (16, 8), &["nearest is `actuator_lag`"]),
        (16, "", (15, 1), &["lacks `kind`"]),
        (17, "control = 'p'", (17, 11), &["expected a control"]),
        (18, "tau = -0.1", (18, 7), &["zero or more"]),
        (18, "tau = inf", (18, 7), &["finite"]),
        (18, "tua = 0.1", (18, 1), &["nearest is `tau`"]),
        (18, "", (15, 1), &["lacks `tau`"]),
        (21, "axis = 'Q'", (21, 8), &["expected an axis"]),
        (22, "term = 'v'", (22, 8), &["derivative"]),
        (22, "term = 'v*|v'", (22, 8), &["v*|v"]),
        (24, "std = -1", (24, 7), &["zero or more"]),
        (12, "v = ", (12, 5), &["not TOML"]),
    ];
    for (line, instead, place, parts) in cases {
        let error = error_with(*line, instead).unwrap_or_else(|| panic!("accepted: {instead}"));
        assert_eq!((error.line, error.column), *place, "{instead}: {error}");
        for part in *parts {
            assert!(error.what.contains(part), "{instead}: {error}");
        }
    }
}

#[test]
fn no_cut_or_flipped_byte_breaks_the_reader() {
    for end in 0..GOOD.len() {
        let _ = ModelFile::parse(&GOOD[..end]);
    }
    for place in 0..GOOD.len() {
        for byte in [b' ', b'"', b'[', b'-', b'9', b'\n', b'=', 0] {
            let mut bytes = GOOD.as_bytes().to_vec();
            bytes[place] = byte;
            let _ = ModelFile::parse(std::str::from_utf8(&bytes).unwrap());
        }
    }
}
