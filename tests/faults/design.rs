//! `design`: its numbers are numbers, its picture a picture, and what it found can be flown as it is written.

use crate::support::program::{ended, folder, own, path, sideslip};
use serde_json::Value;

#[test]
fn the_sequence_that_is_found_flies_and_beats_the_ones_that_everybody_knows() {
    let folder = folder("design");
    let (picture, json, flown) = (folder.join("pedal.svg"), folder.join("pedal.json"), folder.join("flown.csv"));
    let model = own("replay/models/puma-like.toml");
    let args = ["design", "--model", path(&model), "--control", "pedal", "--clock", "1", "--longest", "6", "--clocks", "0.5,1"];
    let more = ["--derivatives", "N_v,N_p,N_r,N_pedal", "--svg", path(&picture), "--json", path(&json)];
    let (status, _, said) = ended(&sideslip(&[args.as_slice(), &more].concat()));
    assert_eq!(status, 0, "{said}");
    let result: Value = serde_json::from_str(&std::fs::read_to_string(&json).unwrap()).unwrap();
    let candidates = result["candidates"].as_array().unwrap();
    let names: Vec<&str> = candidates.iter().map(|one| one["name"].as_str().unwrap()).collect();
    assert_eq!(names, ["step", "doublet", "3211", "best found"]);
    let costs: Vec<f64> = candidates.iter().map(|one| one["criterion"].as_f64().unwrap()).collect();
    assert!(costs[..3].iter().all(|cost| *cost > costs[3]), "{costs:?}");
    // The paper's Fig 3: a 3211 of 1 s has its node at 2 pi rad/s; the hand's finite speed moves it a little.
    let nodes: Vec<f64> = candidates[2]["nodes"].as_array().unwrap().iter().map(|node| node.as_f64().unwrap()).collect();
    assert!(nodes.iter().any(|node| (node - std::f64::consts::TAU).abs() < 0.1), "{nodes:?}");
    let drawn = std::fs::read_to_string(&picture).unwrap();
    assert!(drawn.starts_with("<svg") && drawn.contains("best found") && drawn.contains("frequency, rad/s"));
    let best = candidates[3]["input"].as_str().unwrap();
    let (status, _, said) = ended(&sideslip(&["simulate", "--model", path(&model), "--input", best, "--out", path(&flown)]));
    assert_eq!(status, 0, "{best}: {said}");
}

#[test]
fn wrong_calls_are_refused_in_words() {
    let model = own("replay/models/puma-like.toml");
    for (wrong, words) in [
        (["--control", "flaps"], "name of a control"),
        (["--derivatives", "N_x"], "N_x"),
        (["--derivatives", "X_pedal"], "not zero"),
        (["--limit", "phi"], "phi=0.35"),
        (["--limit", "psi=1"], "u w q theta v p phi r"),
        (["--limit", "phi=1e-12"], "no input fits: even with 0.00001 rad it takes phi beyond the limit of 0.000000000001"),
        (["--weights", "1"], "expected 12 numbers"),
        (["--clocks", "0.5,0.5"], "found 0.5 twice"),
        (["--free", "some"], "--free"),
        (["--weights", "nan"], "expected 12 numbers"),
        (["--speed", "40"], "holds at its own trim only"),
        (["--criterion", "min"], "trace or logdet"),
        (["--clock", "0"], "0.05 to 10"),
        (["--amplitude", "nan"], "expected"),
    ] {
        let mut call = vec!["design", "--model", path(&model)];
        if wrong[0] != "--control" {
            call.extend(["--control", "pedal"]);
        }
        call.extend(wrong);
        let (status, _, said) = ended(&sideslip(&call));
        assert!(status == 2 && said.contains(words), "{wrong:?}: {status} {said}");
    }
}

#[test]
fn what_is_unknown_besides_makes_the_promise_smaller_and_is_named() {
    let designed = |free: &str| {
        let call =
            ["design", "--model", "puma", "--speed", "40", "--control", "pedal", "--derivatives", "N_v,N_r", "--longest", "2"];
        let (status, out, said) = ended(&sideslip(&[&call[..], &["--clocks", "0.7", "--free", free, "--json", "-"]].concat()));
        assert_eq!(status, 0, "{said}");
        // Progress is for a terminal; a person is told the flight and what is free.
        assert!(!said.contains('\r') && said.contains("speed 40 m/s"), "{said}");
        (serde_json::from_str::<Value>(&out).unwrap(), said)
    };
    let ((all, said), (named, _)) = (designed("all"), designed("named"));
    assert!(said.contains("unknown besides: N_u N_w N_p N_q N_pedal"), "{said}");
    assert_eq!(all["level1"]["flight"]["speed"].as_f64(), Some(40.0));
    assert_eq!((all["free"].as_array().unwrap().len(), named["free"].as_array().unwrap().len()), (5, 0));
    let std = |result: &Value, place: usize| result["candidates"][2]["parameters"][place]["std"].as_f64().unwrap();
    for place in [0, 1] {
        assert!(std(&all, place) > 1.2 * std(&named, place), "{place}: {} {}", std(&all, place), std(&named, place));
    }
}
