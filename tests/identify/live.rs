//! Output error beside a replay: in its JSON, its log and its table, the same every time and through shared memory.

use crate::support::program::{RunFile, ended, folder, own, path, puma, sideslip, without_provenance};
use serde_json::Value;
use std::path::Path;

/// Standard output and JSON of a replay, the JSON without the call.
fn replayed(folder: &Path, file: &Path, more: &[&str]) -> (String, String) {
    let (json, log) = (folder.join("answer.json"), folder.join("log.mcap"));
    let args = [&["replay", path(file), "--json", path(&json), "--out", path(&log), "--force"], more].concat();
    let (status, out, said) = ended(&sideslip(&args));
    assert_eq!(status, 0, "{said}");
    assert!(log.metadata().unwrap().len() > 10_000);
    (out, without_provenance(&std::fs::read_to_string(&json).unwrap()))
}

/// The recording's first eleven seconds.
fn short(folder: &Path) -> std::path::PathBuf {
    let mut run = RunFile::read(&puma());
    let place = run.place("time");
    run.rows.retain(|row| row[place].parse::<f64>().unwrap() < 11.0);
    let file = folder.join("short.csv");
    std::fs::write(&file, run.text()).unwrap();
    file
}

#[test]
fn streaming_is_repeatable_byte_for_byte_and_the_same_through_shared_memory() {
    let folder = folder("identify-live");
    let file = short(&folder);
    let streaming = ["--output-error", "streaming"];
    let first = replayed(&folder, &file, &streaming);
    assert!(first == replayed(&folder, &file, &streaming), "another answer the second time");
    let through = replayed(&folder, &file, &[&streaming[..], &["--bus"]].concat());
    assert!(first == through, "another answer through shared memory: {}", through.0);
    assert!(first.0.contains("Output error at "), "{}", first.0);
    let answer: Value = serde_json::from_str(&first.1).unwrap();
    assert_eq!(answer["output_error"], answer["runs"][0]["output_error"]);
    assert!(matches!(answer["output_error"]["status"].as_str(), Some("converging" | "converged")));
    let names: Vec<&str> =
        answer["output_error"]["parameters"].as_array().unwrap().iter().map(|one| one["name"].as_str().unwrap()).collect();
    assert!(["N_v", "N_p", "N_r", "N_pedal"].iter().all(|name| names.contains(name)), "{names:?}");
    assert!(answer["output_error"]["age"].as_f64().unwrap() < 1.0);
}

#[test]
fn what_something_else_acts_on_is_not_converged() {
    let folder = folder("identify-live-lag");
    let text = std::fs::read_to_string(own("replay/models/puma-like.toml")).unwrap();
    let (model, run) = (folder.join("lag.toml"), folder.join("lag.csv"));
    let lag = "[[effect]]\nkind = \"actuator_lag\"\ncontrol = \"pedal\"\ntau = 0.2\n";
    std::fs::write(&model, format!("{text}\n{lag}")).unwrap();
    let input = ["--input", "pedal:3211:0.02:0.7", "--noise", "--seed", "1"];
    let (status, _, said) = ended(&sideslip(&[&["simulate", "--model", path(&model), "--out", path(&run)], &input[..]].concat()));
    assert_eq!(status, 0, "{said}");
    let (out, json) = replayed(&folder, &run, &[]);
    let answer: Value = serde_json::from_str(&json).unwrap();
    // By the covariance of output error N_r would be ten standard errors off, with the wrong sign.
    assert_eq!(answer["output_error"]["status"], "converging", "{out}");
    assert!(out.contains("residuals not white"), "{out}");
    let truth = [("N_v", 0.015487), ("N_r", -0.66163), ("N_pedal", -9.9086), ("L_v", -0.058736), ("L_p", -1.4939)];
    let number = |name: &str| answer["output_error"]["parameters"].as_array().unwrap().iter().find(|one| one["name"] == name);
    for (name, truth) in truth {
        // The regression has no number of N_r, so neither has output error.
        assert_eq!(number(name).is_none(), name == "N_r", "{out}");
        let Some(one) = number(name) else { continue };
        let (value, std) = (one["value"].as_f64().unwrap(), one["std"].as_f64().unwrap());
        assert!((value - truth).abs() < 3.0 * std, "{name} {value} +- {std}, true {truth}");
    }
}

#[test]
fn it_can_be_left_out() {
    let folder = folder("identify-live-off");
    let (out, json) = replayed(&folder, &short(&folder), &["--output-error", "off"]);
    let answer: Value = serde_json::from_str(&json).unwrap();
    assert!(!out.contains("Output error") && answer.get("output_error").is_none());
}
