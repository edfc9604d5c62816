//! A wrong Level-1 model file, assignment or trim is refused where it is wrong, by the library and by the program.

use crate::support::program::{ended, folder, own, path, sideslip};
use sideslip::simulation::flight_model::{FlightModel, FlightRequest, ModelError, PUMA};

/// The built-in file with the line that begins so replaced, and the number of that line.
fn puma_with(begins: &str, instead: &str) -> (String, usize) {
    let place = PUMA.lines().position(|line| line.starts_with(begins)).unwrap();
    let lines: Vec<&str> = PUMA.lines().enumerate().map(|(at, kept)| if at == place { instead } else { kept }).collect();
    (lines.join("\n"), place + 1)
}

#[test]
fn each_wrong_line_is_named_with_its_place() {
    for (begins, instead, column, part) in [
        ("hub =", "hub = 'publish'", 7, "nearest is `published`"),
        ("flapping =", "flaping = 'quasi_steady'", 1, "nearest is `flapping`"),
        ("mass =", "mass = 0", 8, "more than zero"),
        ("ixz =", "ixz = 16000.0", 7, "sqrt(ixx izz)"),
        ("rotation =", "rotation = 'left'", 12, "clockwise anticlockwise"),
        ("lift_slope =", "lift_slope = 'steep'", 14, "finite number"),
        ("pitch_flap_coupling =", "pitch_flap_coupling = 1.0", 23, "zero or less"),
        ("near_x =", "near_x = [1.0, 2.0]", 10, "expected 4 finite numbers, found 2 numbers"),
        ("far_y =", "far_y = [[0.0, 1.0], [0.0, 2.0]]", 9, "angles that increase"),
        ("far_z =", "far_z = [1.0]", 9, "pairs of finite numbers"),
        ("far_limit_deg =", "far_limit_deg = 20.0", 17, "more than near_limit_deg"),
        ("blades =", "blades = 4.5", 10, "whole number from 1 to 32"),
        ("pedal =", "pedal = { tau = 0.05 }", 1, "lacks `rate`"),
        ("kind =", "kind = 'level2'", 8, "nearest is `level1`"),
        ("[level1.engine]", "[level1.engin]", 9, "nearest is `engine`"),
    ] {
        let (text, line) = puma_with(begins, instead);
        match FlightModel::parse(&text, &FlightRequest::default()) {
            Err(ModelError::Misread(misread)) => {
                assert_eq!((misread.line, misread.column), (line, column), "{instead}: {misread}");
                assert!(misread.what.contains(part), "{instead}: {misread}");
            }
            other => panic!("{instead}: {:?}", other.map(|_| ())),
        }
    }
}

#[test]
fn a_simulation_without_a_finite_linear_model_is_refused() {
    // Differences of 50 rad/s leave what the rotor's equations hold for.
    let (text, _) = puma_with("rate = 0.05", "rate = 50.05");
    match FlightModel::parse(&text, &FlightRequest::default()) {
        Err(wrong @ ModelError::NotFinite { .. }) => assert!(wrong.to_string().contains("is not finite"), "{wrong}"),
        other => panic!("{:?}", other.map(|_| ())),
    }
}

#[test]
fn no_cut_or_flipped_byte_breaks_the_reader() {
    for end in (0..PUMA.len()).step_by(7).filter(|&end| PUMA.is_char_boundary(end)) {
        let _ = FlightModel::parse(&PUMA[..end], &FlightRequest::default());
    }
    for place in (0..PUMA.len()).step_by(11) {
        for byte in [b'-', b'9', b'=', b'\n'] {
            let mut bytes = PUMA.as_bytes().to_vec();
            bytes[place] = byte;
            let _ = std::str::from_utf8(&bytes).map(|text| FlightModel::parse(text, &FlightRequest::default()));
        }
    }
}

#[test]
fn the_program_trims_flies_and_says_where_it_cannot() {
    let linearise = ["linearise", "--model", "puma", "--speed", "51.44", "--density", "1.024", "--json", "-"];
    let (status, out, said) = ended(&sideslip(&linearise));
    assert_eq!(status, 0, "{said}");
    let json: serde_json::Value = serde_json::from_str(&out).unwrap();
    assert!((json["derivatives"]["N"]["p"].as_f64().unwrap() + 0.21).abs() < 0.01, "{json}");
    let linear = own("replay/models/puma-like.toml");
    for (arguments, part) in [
        (["linearise", "--model", "puma", "--speed", "200"], "no trim at 200.00 m/s"),
        (["linearise", "--model", "puma", "--density", "-1"], "--density from 0.1 to 1.6 kg/m^3"),
        (["linearise", "--model", "puma", "--set", "hub=round"], "nearest is `exact`"),
        (["linearise", "--model", "puma", "--speed", "380"], "the inflow of a rotor has no solution"),
        (["linearise", "--model", path(&linear), "--climb", "2"], "holds at its own trim only"),
    ] {
        let (status, out, said) = ended(&sideslip(&arguments));
        assert_eq!((status, out.as_str()), (2, ""), "{said}");
        assert!(said.contains(part), "{said}");
    }
    let out = folder("level1").join("run.csv");
    let input = ["simulate", "--model", "puma", "--input", "pedal:doublet:0.02:1.0", "--noise", "--out", path(&out)];
    let climbing = ["--climb", "5.08", "--set", "flapping=second_order"];
    let (status, _, said) = ended(&sideslip(&[&input[..], &climbing].concat()));
    assert_eq!(status, 0, "{said}");
    let text = std::fs::read_to_string(&out).unwrap();
    assert!(text.contains("flight_path = \"climb\"") && text.lines().count() > 1000);
}
