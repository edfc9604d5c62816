//! What is said and written where there is no answer, and where the states were nobody's choice.

use crate::support::program::{RunFile, ended, files_in, folder, path, puma, real, sideslip};
use serde_json::Value;

#[test]
fn a_search_that_has_not_converged_writes_no_model_and_ends_with_4() {
    let folder = folder("identify-not-converged");
    let (run, out) = (folder.join("run.csv"), folder.join("out"));
    // The pilot moves the other controls too, which this model leaves out.
    let flown =
        ["--input", "pedal:3211:0.02:0.7", "--pilot", "attitude", "--noise", "--seed", "3", "--rate", "25", "--duration", "23"];
    let (status, _, said) = ended(&sideslip(&[&["simulate", "--model", "puma", "--out", path(&run)], &flown[..]].concat()));
    assert_eq!(status, 0, "{said}");
    let call = ["identify", path(&run), "--states", "v,p,phi,r", "--inputs", "pedal", "--out", path(&out)];
    let (status, table, said) = ended(&sideslip(&call));
    assert!(status == 4 && table.contains("NOT converged"), "{status} {table} {said}");
    assert!(said.contains("model.toml is not written") && said.contains("--states"), "{said}");
    assert_eq!(files_in(&out), ["derivatives.json", "report.html"]);
}

#[test]
fn a_replay_without_a_single_derivative_ends_with_4_and_says_where_to_look() {
    let folder = folder("replay-nothing");
    let file = folder.join("no-rates.csv");
    RunFile::read(&puma()).without("p").without("q").write(&file);
    let (status, _, said) = ended(&sideslip(&["replay", path(&file), "--output-error", "off"]));
    assert!(status == 4 && said.contains("no derivative could be estimated") && said.contains("inspect"), "{status} {said}");
}

#[test]
fn runs_of_elevator_and_of_rudder_together_are_identified_in_both_planes_and_it_is_said() {
    let runs = ["attas-ail1.csv", "attas-elv1.csv", "attas-rud1.csv"].map(real);
    let [Some(aileron), Some(elevator), Some(rudder)] = runs else { return };
    let call = ["identify", path(&aileron), path(&elevator), path(&rudder), "--json", "-"];
    let (status, out, said) = ended(&sideslip(&call));
    assert_eq!(status, 0, "{said}");
    let answer: Value = serde_json::from_str(&out).unwrap();
    let parameters = answer["output_error"]["parameters"].as_array().unwrap();
    let value = |name: &str| parameters.iter().find(|one| one["name"] == name).map(|one| one["value"].as_f64().unwrap());
    assert!(value("M_elevator").unwrap() < 0.0 && value("N_rudder").unwrap() < 0.0 && value("M_q").unwrap() < 0.0);
    assert!(value("M_rudder").is_none() && value("N_elevator").is_none());
    let modes = answer["modes"].as_object().unwrap();
    assert!(modes.contains_key("dutch_roll") && modes.contains_key("short_period"), "{modes:?}");
    let note = answer["notes"][0].as_str().unwrap();
    assert!(note.contains("both planes") && note.contains("fAttasElv1") && note.contains("--states"), "{note}");
}

#[test]
fn runs_of_one_name_are_told_apart_by_their_files_and_what_was_lost_is_said_once() {
    let folder = folder("one-name");
    let (one, other) = (folder.join("monday.csv"), folder.join("tuesday.csv"));
    let mut damaged = RunFile::read(&puma());
    damaged.rows[50][1] = "x".to_owned();
    damaged.write(&one);
    std::fs::copy(puma(), &other).unwrap();
    let files = [path(&one), path(&other)];
    let (status, out, said) = ended(&sideslip(&[&["replay", "--output-error", "off", "--json", "-"], &files[..]].concat()));
    assert_eq!(status, 3, "{said}");
    let answer: Value = serde_json::from_str(&out).unwrap();
    let names: Vec<&str> = answer["runs"].as_array().unwrap().iter().map(|run| run["run"].as_str().unwrap()).collect();
    assert!(names[0].ends_with("(monday)") && names[1].ends_with("(tuesday)"), "{names:?}");
    assert_eq!(said.matches("rows skipped").count(), 1, "{said}");
    let (_, out, _) = ended(&sideslip(&[&["check", "--json", "-"], &files[..]].concat()));
    let answer: Value = serde_json::from_str(&out).unwrap();
    assert!(answer["runs"][0]["run"] != answer["runs"][1]["run"], "{}", answer["runs"]);
}
