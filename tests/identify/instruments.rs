//! Instruments that are wrong: `identify` does not tell numbers without a word about it.

use crate::support::identified::identified;
use crate::support::program::{ended, folder, own, path, sideslip};
use serde_json::Value;

/// What is noted of a pedal 3211 flown with this effect on an instrument.
fn notes(name: &str, effect: &str) -> Vec<String> {
    let folder = folder(&format!("identify-instruments-{name}"));
    let text = std::fs::read_to_string(own("replay/models/puma-like.toml")).unwrap();
    let (model, run) = (folder.join(format!("{name}.toml")), folder.join(format!("{name}.csv")));
    std::fs::write(&model, format!("{text}\n{effect}")).unwrap();
    let inputs = ["--input", "pedal:3211:0.02:0.7", "--input", "lat_cyclic:3211:0.008:0.5:10"];
    let call = [&["simulate", "--model", path(&model), "--noise", "--seed", "2", "--out", path(&run)], &inputs[..]].concat();
    let (status, _, said) = ended(&sideslip(&call));
    assert_eq!(status, 0, "{said}");
    let (status, answer) = identified(&[run.as_path()], &[]);
    // Wrong instruments may keep the search from converging.
    assert!(matches!(status, 0 | 4), "{status}");
    let notes = answer["notes"].as_array().unwrap();
    notes.iter().filter_map(Value::as_str).map(str::to_owned).collect()
}

#[test]
fn a_late_vane_is_suspected() {
    let late = notes("late", "[[effect]]\nkind = \"sensor_delay\"\nchannel = \"beta\"\ndelay = 0.2\n");
    let note = late.iter().find(|note| note.contains("late_beta")).unwrap_or_else(|| panic!("{late:?}"));
    assert!(note.contains("--doubt-instruments") && note.contains("N_r"), "{note}");
    let healthy = notes("healthy", "");
    assert!(!healthy.iter().any(|note| note.contains("late_beta") || note.contains("does not follow")), "{healthy:?}");
}

#[test]
fn an_output_that_the_model_does_not_follow_is_named() {
    let turned = notes("turned", "[[effect]]\nkind = \"sensor_scale\"\nchannel = \"phi\"\nfactor = 0.2\n");
    assert!(turned.iter().any(|note| note.contains("does not follow") && note.contains("`phi`")), "{turned:?}");
}
