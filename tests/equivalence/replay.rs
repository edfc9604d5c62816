//! `sideslip replay`: the same samples give the same numbers, from whatever file and at whatever pace.

use crate::support::program::{ended, folder, own, path, puma, real, replayed, sideslip, without_provenance};
use serde_json::Value;
use std::path::Path;

const VANE: &str = "vane_position_m=[13.08,0,0]";

/// The JSON of a replay, byte by byte, but for the call and its files.
fn json(files: &[&Path], more: &[&str]) -> String {
    let mut args = vec!["replay", "--json", "-"];
    args.extend(files.iter().map(|file| path(file)));
    args.extend(more);
    let (status, out, said) = ended(&sideslip(&args));
    assert_eq!(status, 0, "{said}");
    without_provenance(&out)
}

#[test]
fn a_replay_and_the_replay_of_its_log_give_the_same_bytes() {
    let Some(flight) = real("attas-rud1.csv") else { return };
    let log = folder("replay-log").join("rud1.mcap");
    let first = json(&[&flight], &["--set", VANE, "--out", path(&log)]);
    assert_eq!(json(&[&flight], &["--set", VANE]), first, "twice the same, with a log or without");
    assert_eq!(json(&[&log], &[]), first, "the log holds the key that was set");
    let again = log.with_file_name("again.mcap");
    json(&[&log], &["--out", path(&again)]);
    assert_eq!(json(&[&again], &[]), first, "the log of a log too");
    assert_ne!(json(&[&flight], &[]), first, "the key matters");
}

#[test]
fn columns_that_nobody_knows_travel_along() {
    let Some(flight) = real("twin-otter-020213f1_018.csv") else { return };
    let log = folder("replay-others").join("otter.mcap");
    let first = json(&[&flight], &["--out", path(&log)]);
    assert_eq!(json(&[&log], &[]), first);
    let channels = |file: &Path| {
        let (status, out, said) = ended(&sideslip(&["inspect", path(file), "--json", "-"]));
        assert_eq!(status, 0, "{said}");
        let answer: Value = serde_json::from_str(&out).unwrap();
        let of = |channel: &Value| {
            (channel["name"].clone(), channel["samples"].clone(), channel["min"].clone(), channel["max"].clone())
        };
        answer["channels"].as_array().unwrap().iter().map(of).collect::<Vec<_>>()
    };
    assert_eq!(channels(&log), channels(&flight), "qhat, Cm, CZ and CX with their values");
}

#[test]
fn the_pace_does_not_change_the_numbers() {
    let short = folder("replay-pace").join("short.csv");
    let model = own("replay/models/puma-like.toml");
    let args = ["simulate", "--model", path(&model), "--input", "pedal:3211:0.02:0.5", "--duration", "12", "--rate", "40"];
    let (status, _, said) = ended(&sideslip(&[args.as_slice(), &["--noise", "flight", "--out", path(&short)]].concat()));
    assert_eq!(status, 0, "{said}");
    let log = short.with_extension("mcap");
    let fast = json(&[&short], &[]);
    let started = std::time::Instant::now();
    assert_eq!(json(&[&short], &["--speed", "50", "--out", path(&log)]), fast);
    assert!(started.elapsed().as_secs_f64() > 12.0 / 50.0, "it was paced");
    assert_eq!(json(&[&log], &[]), fast);
}

#[test]
fn several_runs_are_each_their_own() {
    let folder = folder("replay-several");
    let other = folder.join("other.csv");
    let text = std::fs::read_to_string(puma()).unwrap();
    std::fs::write(&other, text.replace("run = \"puma-100kn-pedal-3211\"", "run = \"other\"")).unwrap();
    let logs = folder.join("logs");
    let both: Value = serde_json::from_str(&json(&[&puma(), &other], &["--out", path(&logs)])).unwrap();
    let alone: Value = serde_json::from_str(&json(&[&puma()], &[])).unwrap();
    assert_eq!(both["runs"][0], alone["runs"][0]);
    assert_eq!(both["runs"][1]["run"], "other");
    assert_eq!(both["runs"][1]["equations"], alone["runs"][0]["equations"]);
    let mut names: Vec<_> = std::fs::read_dir(&logs).unwrap().map(|entry| entry.unwrap().file_name()).collect();
    names.sort();
    assert_eq!(names, ["other.mcap", "puma-100kn-pedal-3211.mcap"], "and nothing half written beside them");
}

#[test]
fn the_bundled_recording_is_made_again_to_the_byte() {
    let made = folder("replay-bundled").join("puma-100kn-pedal-3211.csv");
    let model = own("replay/models/puma-like.toml");
    let args = ["simulate", "--model", path(&model), "--input", "pedal:3211:0.02:0.7", "--input", "lat_cyclic:doublet:0.01:1:14"];
    let more = ["--duration", "25", "--rate", "50", "--noise", "flight", "--seed", "3211", "--out", path(&made)];
    let (status, _, said) = ended(&sideslip(&[args.as_slice(), &more].concat()));
    assert_eq!(status, 0, "{said}");
    assert!(std::fs::read(&made).unwrap() == std::fs::read(puma()).unwrap(), "make it again: replay/recordings/README.md");
}

#[test]
fn the_bundled_recording_gives_the_derivatives_of_its_model() {
    let text = std::fs::read_to_string(own("replay/models/puma-like.toml")).unwrap();
    let model: toml::Table = text.parse().unwrap();
    let (status, run, said) = replayed(&puma(), &[]);
    assert_eq!(status, 0, "{said}");
    let (mut all, mut outside) = (0, Vec::new());
    for (axis, equation) in run["equations"].as_object().unwrap() {
        for term in equation["terms"].as_array().unwrap() {
            let name = term["name"].as_str().unwrap();
            let variable = name.split_once('_').unwrap().1;
            if variable == "0" {
                continue;
            }
            let known = model["derivatives"][axis].get(variable).map_or(0.0, |value| value.as_float().unwrap());
            let off = (term["value"].as_f64().unwrap() - known) / term["std"].as_f64().unwrap();
            all += 1;
            if off.is_nan() || off.abs() >= 3.0 {
                outside.push(format!("{name} {off:.1}"));
            }
        }
    }
    // Normal errors leave one in 370 outside three standard errors; one of forty is allowed for.
    assert!(all >= 30 && outside.len() <= 1, "{all} terms, outside: {outside:?}");
    // Roots of the model's lateral 4 by 4 matrix: -0.155 +- 1.043i.
    let pair = &run["modes"]["dutch_roll"];
    assert!((pair["real"].as_f64().unwrap() + 0.155).abs() < 0.005, "{pair}");
    assert!((pair["imag"].as_f64().unwrap() - 1.043).abs() < 0.005, "{pair}");
}

#[test]
fn a_simulated_log_and_a_simulated_run_file_are_one_flight() {
    let folder = folder("simulated");
    let model = own("replay/models/puma-like.toml");
    let fly = |name: &str| {
        let out = folder.join(name);
        let args = ["simulate", "--model", path(&model), "--input", "pedal:doublet:0.02:1", "--duration", "10"];
        let more = ["--noise", "flight", "--set", "vane_position_m=[5,0,0]", "--set", "run=flight", "--out", path(&out)];
        let (status, _, said) = ended(&sideslip(&[args.as_slice(), &more].concat()));
        assert_eq!(status, 0, "{said}");
        json(&[&out], &[])
    };
    assert_eq!(fly("flight.csv"), fly("flight.mcap"));
    let controls = folder.join("flight.mcap");
    let out = folder.join("again.csv");
    let (status, _, said) =
        ended(&sideslip(&["simulate", "--model", path(&model), "--controls", path(&controls), "--out", path(&out)]));
    assert_eq!(status, 0, "{said}");
    assert!(said.contains("1001 samples"), "{said}");
}
