//! Instruments that fall silent, or come on rows of their own: nothing is put in their place, and what is told stays true.

use crate::support::program::{RunFile, folder, own, path, puma, replayed, sideslip, warns};
use serde_json::Value;
use std::path::Path;

/// A term of an equation: value and standard error.
fn term(run: &Value, name: &str) -> (f64, f64) {
    let terms = run["equations"][&name[..1]]["terms"].as_array().unwrap_or_else(|| panic!("{name}: {run}"));
    let term = terms.iter().find(|term| term["name"] == name).unwrap_or_else(|| panic!("{name} is in {terms:?}"));
    (term["value"].as_f64().unwrap(), term["std"].as_f64().unwrap())
}

/// Each of these derivatives within `sigmas` standard errors of the model that flew.
fn true_within(run: &Value, sigmas: f64, derivatives: &[(&str, f64)]) {
    for &(name, truth) in derivatives {
        let (value, std) = term(run, name);
        assert!(std > 0.0 && (value - truth).abs() < sigmas * std, "{name}: {value} +- {std}, flown {truth}");
    }
}

const LATERAL: [(&str, f64); 8] = [
    ("L_v", -0.058736),
    ("L_p", -1.4939),
    ("L_r", 0.16511),
    ("L_pedal", 2.4861),
    ("N_v", 0.015487),
    ("N_p", -0.155),
    ("N_r", -0.66163),
    ("N_pedal", -9.9086),
];

/// What the regression can run on.
const STATES: [&str; 2] = ["smoothed", "filtered"];

/// The bundled recording with a channel left out from one row to another.
fn silent(states: &str, name: &str, channels: &[&str], rows: std::ops::Range<usize>) -> (i32, Value, String) {
    let mut run = RunFile::read(&puma());
    for channel in channels {
        let place = run.place(channel);
        run.rows[rows.clone()].iter_mut().for_each(|row| row[place].clear());
    }
    let file = folder(&format!("silent-{name}-{states}")).join("run.csv");
    run.write(&file);
    replayed(&file, &["--states", states])
}

#[test]
fn a_control_that_falls_silent_is_not_taken_for_still() {
    for states in STATES {
        // A second in the middle of the pedal's 3211.
        let (status, run, said) = silent(states, "pedal", &["pedal"], 150..200);
        assert_eq!(status, 0, "{said}");
        assert!(warns(&run, &["pedal was silent"]), "{}", run["warnings"]);
        true_within(&run, 4.0, &LATERAL);
    }
}

#[test]
fn an_accelerometer_that_falls_silent_is_not_taken_for_zero() {
    for states in STATES {
        let (status, run, said) = silent(states, "ay", &["ay"], 150..200);
        assert_eq!(status, 0, "{said}");
        assert!(warns(&run, &["ay was silent"]), "{}", run["warnings"]);
        true_within(&run, 4.0, &[("Y_v", -0.16077), ("Y_p", -0.67396), ("Y_pedal", 4.9951)]);
    }
}

#[test]
fn a_control_without_a_trim_is_left_out_and_said() {
    for states in STATES {
        let (_, run, said) = silent(states, "no-trim", &["lat_cyclic"], 0..500);
        assert!(warns(&run, &["lat_cyclic was not sampled in the trim window"]), "{said} {}", run["warnings"]);
        let terms = run["equations"]["L"]["terms"].as_array().unwrap();
        assert!(terms.iter().all(|term| term["name"] != "L_lat_cyclic"), "no number from a perturbation about nothing");
    }
}

#[test]
fn an_accelerometer_without_a_trim_gives_no_force_derivatives() {
    for states in STATES {
        let (_, run, _) = silent(states, "no-force", &["ay"], 0..500);
        let reason = run["equations"]["Y"]["reason"].as_str().unwrap();
        assert!(reason.contains("ay was not sampled in the trim window"), "{reason}");
        assert!(run["equations"]["Y"]["terms"].as_array().is_none_or(Vec::is_empty));
        true_within(&run, 4.0, &LATERAL);
    }
}

#[test]
fn gyros_that_fall_silent_start_the_filter_again() {
    for states in STATES {
        let (status, run, said) = silent(states, "gyros", &["p"], 150..300);
        assert_eq!(status, 0, "{said}");
        assert!(warns(&run, &["p, q and r were silent for 0.5"]), "{}", run["warnings"]);
        true_within(&run, 4.0, &LATERAL);
    }
}

#[test]
fn a_rate_that_comes_too_rarely_is_a_reason_and_not_an_endless_wait() {
    let mut run = RunFile::read(&puma());
    let r = run.place("r");
    // Once in two seconds.
    for (_, row) in run.rows.iter_mut().enumerate().filter(|(k, _)| k % 100 != 0) {
        row[r].clear();
    }
    let file = folder("rates-apart").join("run.csv");
    run.write(&file);
    let (_, run, _) = replayed(&file, &[]);
    let reason = run["equations"]["N"]["reason"].as_str().unwrap();
    assert!(reason.contains("p, q and r come together too rarely"), "{reason}");
}

/// Every group of instruments at 50 Hz, each on rows of its own, 4 ms after the one before.
#[test]
fn instruments_on_rows_of_their_own_are_all_used() {
    let folder = folder("own-rows");
    let (whole, apart) = (folder.join("whole.csv"), folder.join("apart.csv"));
    let model = own("replay/models/puma-like.toml");
    let simulated = |out: &Path| {
        sideslip(&[
            "simulate",
            "--model",
            path(&model),
            "--input",
            "pedal:3211:0.02:0.7",
            "--input",
            "lat_cyclic:doublet:0.01:1:14",
            "--duration",
            "25",
            "--rate",
            "250",
            "--noise",
            "flight",
            "--seed",
            "1",
            "--out",
            path(out),
        ])
    };
    assert!(simulated(&whole).status.success());
    let mut run = RunFile::read(&whole);
    let groups: [&[&str]; 5] = [
        &["ax", "ay", "az"],
        &["p", "q", "r"],
        &["phi", "theta", "psi", "tas", "alpha", "beta", "altitude"],
        &["lon_cyclic", "lat_cyclic", "collective", "pedal", "rotor_speed"],
        &[],
    ];
    for (k, row) in run.rows.iter_mut().enumerate() {
        for (cell, name) in row.iter_mut().zip(&run.header).skip(1) {
            if !groups[k % 5].contains(&name.as_str()) {
                cell.clear();
            }
        }
    }
    run.write(&apart);
    let (status, run, said) = replayed(&apart, &[]);
    assert_eq!(status, 0, "{said}");
    for (name, truth) in LATERAL.into_iter().chain([("Y_v", -0.16077), ("Y_pedal", 4.9951)]) {
        let (value, std) = term(&run, name);
        // Between the rates' own rows the filter runs on their last values, which costs a little.
        let error = (value - truth).abs();
        assert!(std > 0.0 && error < 0.05 * truth.abs() + 4.0 * std, "{name}: {value} +- {std}, flown {truth}");
    }
}
