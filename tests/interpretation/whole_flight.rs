//! One flight with several test inputs: its manoeuvres listed, one taken as a run of its own by every command, parts by time,
//! keys of one run.

use crate::support::program::{ended, folder, path, puma, sideslip, without_provenance};
use serde_json::Value;
use std::path::{Path, PathBuf};

/// Pedal at 2 s, lateral stick at 40 s, pedal at 70 s.
fn flight(folder: &Path) -> PathBuf {
    let file = folder.join("flight.csv");
    let inputs =
        ["--input", "pedal:3211:0.02:0.7", "--input", "lat_cyclic:doublet:0.01:1:40", "--input", "pedal:doublet:0.015:1:70"];
    let call =
        [&["simulate", "--model", "puma", "--pilot", "attitude", "--noise", "--rate", "25", "--duration", "90"], &inputs[..]];
    let (status, _, said) = ended(&sideslip(&[&call.concat()[..], &["--out", path(&file)]].concat()));
    assert_eq!(status, 0, "{said}");
    file
}

fn json(args: &[&str]) -> Value {
    let (status, out, said) = ended(&sideslip(args));
    assert!(status == 0 || status == 3, "{args:?}: {status} {said}");
    serde_json::from_str(&out).unwrap()
}

#[test]
fn a_manoeuvre_of_a_flight_is_a_run_of_its_own_on_every_command() {
    let folder = folder("whole-flight");
    let flight = flight(&folder);
    let file = path(&flight);
    let listed = json(&["inspect", file, "--manoeuvres", "--json", "-"]);
    let manoeuvres = listed["manoeuvres"].as_array().unwrap();
    let found: Vec<(&str, &str)> =
        manoeuvres.iter().map(|one| (one["control"].as_str().unwrap(), one["shape"].as_str().unwrap())).collect();
    assert_eq!(found, [("pedal", "3211"), ("lat_cyclic", "doublet"), ("pedal", "doublet")]);
    let second = &manoeuvres[1];
    let times = ["from_s", "start_s", "end_s", "to_s"].map(|key| second[key].as_f64().unwrap());
    assert!(times.is_sorted() && (times[1] - 40.0).abs() < 0.2 && (times[2] - 42.0).abs() < 0.2, "{times:?}");
    assert!((second["trim"]["tas"]["value"].as_f64().unwrap() - 51.5).abs() < 1.0);

    let read = json(&["replay", file, "--manoeuvre", "2", "--output-error", "off", "--json", "-"]);
    assert_eq!(read["runs"][0]["run"], "flight manoeuvre 2");
    let seen = json(&["inspect", file, "--manoeuvre", "2", "--json", "-"]);
    let (start, end) = (seen["time"]["start"].as_f64().unwrap(), seen["time"]["end"].as_f64().unwrap());
    assert!((start - times[0]).abs() < 0.05 && (end - times[3]).abs() < 0.05, "{start} {end} {times:?}");
    let compared = json(&["compare", file, "--model", "puma", "--manoeuvre", "1,3", "--json", "-"]);
    assert_eq!(compared["runs"].as_array().unwrap().len(), 2);
    let checked = json_of_check(file);
    assert_eq!(checked["interpretation"]["runs"].as_array().unwrap().len(), 3);
    let third = folder.join("third.csv");
    let (status, _, said) = ended(&sideslip(&["convert", file, path(&third), "--manoeuvre", "3"]));
    assert_eq!(status, 0, "{said}");
    let (response, candidates) = (["--response", "r"], ["--candidates", "p;beta;pedal"]);
    let call =
        [&["identify", file, "--manoeuvre", "flight:1,2", "--holdout", path(&third), "--json", "-"], &response[..], &candidates];
    let identified = json(&call.concat());
    let holdout = &identified["regression"]["holdout"][0];
    assert_eq!(holdout["run"], "flight manoeuvre 3");
    assert!(holdout["r2"].as_f64().unwrap() > 0.5 && holdout["samples"].as_u64().unwrap() > 100, "{holdout}");
    let flown = folder.join("flown.csv");
    let (status, _, said) =
        ended(&sideslip(&["simulate", "--model", "puma", "--controls", file, "--manoeuvre", "3", "--out", path(&flown)]));
    assert!(status == 0 && said.contains(": "), "{said}");
    assert!((json(&["inspect", path(&flown), "--json", "-"])["time"]["start"].as_f64().unwrap() - 67.0).abs() < 0.5);

    let (status, _, said) = ended(&sideslip(&["check", file, "--manoeuvre", "7"]));
    assert!(status == 2 && said.contains("found 3 in it") && said.contains("inspect --manoeuvres"), "{said}");
    let (status, _, said) = ended(&sideslip(&["check", file, "--manoeuvre", "1", "--from", "3"]));
    assert!(status == 2 && said.contains("found both"), "{said}");
}

/// A pipe cannot be read twice: the flight is read once, whatever number of manoeuvres is taken from it.
#[test]
fn a_flight_out_of_a_pipe_is_cut_into_its_manoeuvres() {
    let folder = folder("whole-flight-pipe");
    let (file, pipe) = (flight(&folder), folder.join("pipe"));
    assert!(std::process::Command::new("mkfifo").arg(&pipe).status().unwrap().success());
    let (bytes, end) = (std::fs::read(&file).unwrap(), pipe.clone());
    // It ends with this process, should nobody read.
    std::thread::spawn(move || std::fs::write(end, bytes));
    let (from_pipe, from_file) = (json_of_check(path(&pipe)), json_of_check(path(&file)));
    assert_eq!(from_pipe["interpretation"]["runs"].as_array().unwrap().len(), 3);
    let verdicts =
        |answer: &Value| answer["runs"].as_array().unwrap().iter().map(|run| run["verdict"].clone()).collect::<Vec<_>>();
    assert_eq!(verdicts(&from_pipe), verdicts(&from_file));
}

#[test]
fn a_number_of_a_manoeuvre_is_of_one_recording() {
    let folder = folder("whole-flight-numbers");
    let file = flight(&folder);
    let other = folder.join("other.csv");
    std::fs::copy(puma(), &other).unwrap();
    for command in ["identify", "check"] {
        let second = if command == "identify" { ["--holdout", path(&other)].to_vec() } else { vec![path(&other)] };
        let (status, _, said) = ended(&sideslip(&[&[command, path(&file)], &second[..], &["--manoeuvre", "1"]].concat()));
        assert!(status == 2 && said.contains("such as flight:1, for 2 recordings are read"), "{command}: {said}");
    }
}

/// Whatever its verdict is.
fn json_of_check(file: &str) -> Value {
    let (_, out, _) = ended(&sideslip(&["check", file, "--manoeuvre", "all", "--json", "-"]));
    serde_json::from_str(&out).unwrap()
}

#[test]
fn times_and_keys_are_for_every_run_or_for_the_one_that_is_named() {
    let folder = folder("parts-of-runs");
    let (one, other) = (folder.join("one.csv"), folder.join("other.csv"));
    std::fs::copy(puma(), &one).unwrap();
    std::fs::copy(puma(), &other).unwrap();
    let parts = ["--from", "1", "--to", "9", "--to", "other:7", "--set", "run=A", "--set", "other.csv:run=B"];
    let call = [&["replay", path(&one), path(&other), "--output-error", "off"], &parts[..]].concat();
    let (status, out, said) = ended(&sideslip(&call));
    assert!(status == 0 || status == 3, "{said}");
    let headings: Vec<&str> = out.lines().filter(|line| line.contains(".csv: ") || line.starts_with("run ")).collect();
    assert!(headings[0].contains("1.00 to 9.00 s") && headings[1].starts_with("run A"), "{headings:?}");
    assert!(headings[2].contains("1.00 to 7.00 s") && headings[3].starts_with("run B"), "{headings:?}");
    // Through shared memory the same part.
    let (_, in_process, _) = ended(&sideslip(&["replay", path(&one), "--from", "1", "--to", "9", "--json", "-"]));
    let (_, by_bus, said) = ended(&sideslip(&["replay", path(&one), "--from", "1", "--to", "9", "--json", "-", "--bus"]));
    assert_eq!(without_provenance(&in_process), without_provenance(&by_bus), "{said}");
    for command in ["replay", "check", "inspect", "identify"] {
        let (status, _, said) = ended(&sideslip(&[command, path(&one), "--from", "500"]));
        assert!(status == 2 && said.contains("expected rows from 500 s on"), "{command}: {said}");
    }
    let (status, _, said) = ended(&sideslip(&["replay", path(&one), "--set", "third:run=C"]));
    assert!(status == 2 && said.contains("one.csv") && said.contains("found `third:run=C`"), "{said}");
}
