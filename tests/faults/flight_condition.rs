//! One set of options for the flight condition: `simulate`, `linearise` and `design` take and refuse the same.

use crate::support::program::{ended, folder, own, path, sideslip};
use serde_json::Value;
use std::path::Path;

/// The calls that take a model, without what is said of its flight.
fn calls<'c>(model: &'c str, out: &'c Path) -> [Vec<&'c str>; 3] {
    [
        vec!["linearise", "--model", model],
        vec!["design", "--model", model, "--control", "pedal", "--longest", "1", "--derivatives", "N_pedal"],
        vec!["simulate", "--model", model, "--input", "pedal:doublet:0.01:0.5", "--duration", "3", "--force", "--out", path(out)],
    ]
}

#[test]
fn help_says_the_same_of_the_flight_condition_everywhere() {
    let helps = ["linearise", "simulate", "design"].map(|command| {
        let (status, out, said) = ended(&sideslip(&[command, "--help"]));
        assert_eq!(status, 0, "{said}");
        let from = out.find("Flight condition").unwrap();
        let end = out[from..].find("\n\n\n").or(out[from..].find("\nExample")).unwrap();
        out[from..from + end].trim().to_owned()
    });
    for option in ["--speed <M/S>", "--climb <M/S>", "--sideslip <RAD>", "--density <KG/M3>", "--set <KEY=VALUE>"] {
        assert!(helps[0].contains(option), "{option}: {}", helps[0]);
    }
    assert_eq!(helps[0], helps[1]);
    assert_eq!(helps[0], helps[2]);
}

#[test]
fn what_is_wrong_is_refused_in_the_same_words_by_all_three() {
    let folder = folder("flight_condition");
    let (out, linear) = (folder.join("run.csv"), own("replay/models/puma-like.toml"));
    for (options, of_linear, part) in [
        (["--speed", "100kn"], false, "finite number, in m/s"),
        (["--density", "nan"], false, "finite number, in kg/m^3"),
        (["--speed", "-5"], false, "an airspeed from 0 to 1000 m/s"),
        (["--speed", "1e6"], false, "an airspeed from 0 to 1000 m/s"),
        (["--density", "0"], false, "--density from 0.1 to 1.6 kg/m^3"),
        (["--sideslip", "10"], false, "a sideslip from -1.5 to 1.5 rad"),
        (["--speed", "380"], false, "the inflow of a rotor has no solution"),
        (["--set", "huub=exact"], false, "hub flapping inflow rotor_speed actuators perturbation"),
        (["--set", "level1.hub=exact"], false, "found `level1.hub`"),
        (["--set", "main_rotor.shaft_tlt=0"], false, "a key of [level1.main_rotor]"),
        (["--set", "main_rotor.blades=4.5"], false, "whole number from 1 to 32"),
        (["--set", "flight.density=nan"], false, "finite number"),
        (["--speed", "30"], true, "--speed: a model of kind `linear` holds at its own trim only"),
        (["--density", "1"], true, "--density: a model of kind `linear` holds at its own trim only"),
        (["--set", "hub=exact"], true, "--set: a model of kind `linear` holds at its own trim only"),
    ] {
        for mut call in calls(if of_linear { path(&linear) } else { "puma" }, &out) {
            call.extend(options);
            let (status, printed, said) = ended(&sideslip(&call));
            assert_eq!((status, printed.as_str()), (2, ""), "{call:?}: {said}");
            assert!(said.contains(part), "{call:?}: {said}");
            assert!(!out.exists(), "{call:?}");
        }
    }
    for mut call in calls("puma", &out) {
        call.extend(["--speed", "2", "--climb", "3"]);
        let (status, _, said) = ended(&sideslip(&call));
        assert!(status == 0 && said.contains("note: climb exceeds the airspeed"), "{call:?}: {status} {said}");
    }
    let (_, _, said) = ended(&sideslip(&[&calls("puma", &out)[2][..], &["--set", "vanes=1"]].concat()));
    assert!(said.contains("vane_position_m"), "{said}");
}

#[test]
fn a_recording_holds_the_flight_that_it_was_flown_in() {
    let folder = folder("flight_condition_head");
    let flown = ["--speed", "51.44", "--climb", "5.08", "--sideslip", "0.02", "--density", "1.024"];
    let set = ["--set", "hub=exact", "--set", "main_rotor.shaft_tilt=0.08", "--set", "run=first"];
    let mut runs = Vec::new();
    for name in ["run.csv", "run.mcap"] {
        let out = folder.join(name);
        let call = [&calls("puma", &out)[2][..], &flown, &set].concat();
        let (status, _, said) = ended(&sideslip(&call));
        assert_eq!(status, 0, "{said}");
        let (status, shown, said) = ended(&sideslip(&["inspect", path(&out)]));
        assert_eq!(status, 0, "{said}");
        for part in ["climb 5.08 m/s, density 1.024 kg/m^3, sideslip 0.02 rad, speed 51.44 m/s", "hub exact", "shaft_tilt 0.08"] {
            assert!(shown.contains(part), "{part}: {shown}");
        }
        let (_, json, _) = ended(&sideslip(&["inspect", path(&out), "--json", "-"]));
        let answer: Value = serde_json::from_str(&json).unwrap();
        let altitude = answer["channels"].as_array().unwrap().iter().find(|channel| channel["name"] == "altitude").unwrap();
        // The standard atmosphere has 1.024 kg/m^3 at 1828 m (ISO 2533: 1.0269 at 1800, 1.0218 at 1850).
        assert!((altitude["min"].as_f64().unwrap() - 1828.0).abs() < 2.0, "{altitude}");
        runs.push(answer["run"].clone());
    }
    assert_eq!(runs[0], runs[1]);
    let level1 = &runs[0]["level1"];
    assert_eq!((level1["flight"]["speed"].as_f64(), level1["flight"]["density"].as_f64()), (Some(51.44), Some(1.024)));
    assert_eq!((level1["options"]["hub"].as_str(), runs[0]["model"].as_str()), (Some("exact"), Some("puma")));
    assert_eq!(level1["options"].as_object().unwrap().len(), 6);
}

#[test]
fn an_effect_on_a_channel_that_the_run_lacks_is_told() {
    let folder = folder("unread_channel");
    let text = std::fs::read_to_string(own("replay/models/puma-like.toml")).unwrap();
    let biased = folder.join("biased.toml");
    std::fs::write(&biased, text + "\n[[effect]]\nkind = \"sensor_bias\"\nchannel = \"tail_pitch\"\nvalue = 0.1\n").unwrap();
    let out = folder.join("run.csv");
    let call = calls(path(&biased), &out)[2].clone();
    let (status, _, said) = ended(&sideslip(&call));
    assert_eq!(status, 0, "{said}");
    assert!(said.contains("`sensor_bias` on `tail_pitch` does nothing") && said.contains("[channel.tail_pitch]"), "{said}");
    let instruments = folder.join("instruments.toml");
    std::fs::write(&instruments, "[channel.tail_pitch]\nnoise = 0.001\n").unwrap();
    let (status, _, said) = ended(&sideslip(&[&call[..], &["--instruments", path(&instruments)]].concat()));
    assert!(status == 0 && !said.contains("does nothing"), "{said}");
}
