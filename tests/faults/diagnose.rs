//! `diagnose`: what it cannot use it refuses in words, and a lag that is put into a simulated flight comes back as the answer.

use crate::support::program::{RunFile, ended, folder, own, path, sideslip};
use serde_json::Value;
use std::path::{Path, PathBuf};

/// A flight of a model file, pedal and cyclic moved, noise as flight-test instruments have it.
fn flown(folder: &Path, name: &str, model: &Path, input: &str, seed: &str) -> PathBuf {
    let file = folder.join(name);
    let args = ["simulate", "--model", path(model), "--input", input, "--out", path(&file), "--duration", "12", "--seed", seed];
    let (status, _, said) =
        ended(&sideslip(&[args.as_slice(), &["--noise", "--rate", "64", "--pilot", "attitude", "--force"]].concat()));
    assert_eq!(status, 0, "{said}");
    file
}

/// The answer for a run to fit and a hold-out run.
fn diagnosed(model: &Path, [fit, holdout]: [&Path; 2], json: &Path, extended: &Path) -> Value {
    let args = ["diagnose", "--model", path(model), "--fit", path(fit), "--holdout", path(holdout), "--force"];
    let (status, _, said) = ended(&sideslip(&[&args[..], &["--json", path(json), "--extended", path(extended)]].concat()));
    assert_eq!(status, 0, "{said}");
    serde_json::from_str(&std::fs::read_to_string(json).unwrap()).unwrap()
}

#[test]
fn a_lag_in_the_flight_is_the_answer_and_its_extension_flies() {
    let folder = folder("diagnose");
    let model = own("replay/models/puma-like.toml");
    let (lagging, json, extended) = (folder.join("lagging.toml"), folder.join("answer.json"), folder.join("extended.toml"));
    let text = std::fs::read_to_string(&model).unwrap();
    std::fs::write(&lagging, format!("{text}\n[[effect]]\nkind = \"actuator_lag\"\ncontrol = \"pedal\"\ntau = 0.2\n")).unwrap();
    let fit = flown(&folder, "fit.csv", &lagging, "pedal:3211:0.02:0.7", "1");
    let holdout = flown(&folder, "holdout.csv", &lagging, "pedal:doublet:0.02:0.8", "2");
    let answer = diagnosed(&model, [&fit, &holdout], &json, &extended);
    let verdict = &answer["verdict"];
    assert_eq!((verdict["kind"].as_str(), verdict["control"].as_str()), (Some("actuator_lag"), Some("pedal")), "{verdict}");
    let (tau, std) = (verdict["tau"].as_f64().unwrap(), verdict["std"].as_f64().unwrap());
    assert!((tau - 0.2).abs() < 4.0 * std && std < 0.02, "{tau} +- {std}");
    assert!(verdict["statement"].as_str().unwrap().contains("lag") && verdict["probability"].as_f64().unwrap() > 0.9);
    assert!(answer["ranking"].as_array().unwrap().len() > 1);
    assert_eq!(answer["gain"]["holdout"]["pooled"]["judged"], "gain");
    assert_eq!(answer["extended_model"].as_str(), extended.to_str());
    let again = flown(&folder, "again.csv", &extended, "pedal:step:0.01:1", "3");
    assert!(again.exists());
}

/// A clock that jumps to the time since 1970, and a gap of three hours: what lies between is diagnosed, at the cost of its rows.
#[test]
fn parts_of_a_record_between_gaps_are_runs_however_long_the_gaps_are() {
    let folder = folder("diagnose-gaps");
    let model = own("replay/models/puma-like.toml");
    let lagging = folder.join("lagging.toml");
    let text = std::fs::read_to_string(&model).unwrap();
    std::fs::write(&lagging, format!("{text}\n[[effect]]\nkind = \"actuator_lag\"\ncontrol = \"pedal\"\ntau = 0.2\n")).unwrap();
    let rows = |input: &str, seed: &str, later_s: f64| -> (String, String) {
        let text = std::fs::read_to_string(flown(&folder, "part.csv", &lagging, input, seed)).unwrap();
        let (head, rows): (Vec<&str>, Vec<&str>) = text.lines().partition(|line| line.starts_with(['#', 't']));
        let moved = rows.iter().map(|row| {
            let (time, rest) = row.split_once(',').unwrap();
            format!("{:.6},{rest}\n", time.parse::<f64>().unwrap() + later_s)
        });
        (head.join("\n") + "\n", moved.collect())
    };
    let (head, first) = rows("pedal:3211:0.02:0.7", "1", 0.0);
    let (joined, json) = (folder.join("joined.csv"), folder.join("answer.json"));
    for (later_s, scrap_s) in [(1.0e4, 5.0e3), (1.7e9, 1.6e9)] {
        let second = rows("pedal:doublet:0.02:0.8", "2", later_s).1;
        // A second of it by itself, which is too short to be used.
        let scrap: String = rows("pedal:step:0.001", "3", scrap_s).1.split_inclusive('\n').take(64).collect();
        std::fs::write(&joined, [head.as_str(), &first, &scrap, &second].concat()).unwrap();
        let args = ["diagnose", "--model", path(&model), "--fit", path(&joined), "--json", path(&json), "--force"];
        let (status, _, said) = ended(&sideslip(&args));
        assert_eq!(status, 3, "{said}");
        assert!(said.contains("the longest of 2 gaps: diagnosed as 2 run(s)"), "{said}");
        assert!(said.contains("1 part(s) between gaps left out, the first from"), "{said}");
        let answer: Value = serde_json::from_str(&std::fs::read_to_string(&json).unwrap()).unwrap();
        let verdict = &answer["verdict"];
        assert_eq!((verdict["kind"].as_str(), verdict["control"].as_str()), (Some("actuator_lag"), Some("pedal")), "{verdict}");
        assert!((verdict["tau"].as_f64().unwrap() - 0.2).abs() < 0.03, "{verdict}");
    }
}

#[test]
fn a_turned_vane_and_exchanged_gyros_are_the_answer_and_the_extended_model_predicts_the_records() {
    let folder = folder("diagnose-recording");
    let model = own("replay/models/puma-like.toml");
    let text = std::fs::read_to_string(&model).unwrap();
    let (json, extended) = (folder.join("answer.json"), folder.join("extended.toml"));
    for (table, words) in [
        ("kind = \"sensor_scale\"\nchannel = \"beta\"\nfactor = -1.1\n", "beta is recorded with the sign turned"),
        ("kind = \"exchanged\"\nchannels = [\"p\", \"r\"]\n", "p and r are exchanged"),
        ("kind = \"exchanged\"\nchannels = [\"pedal\", \"lat_cyclic\"]\n", "lat_cyclic and pedal are exchanged"),
    ] {
        let spoilt = folder.join("spoilt.toml");
        std::fs::write(&spoilt, format!("{text}\n[[effect]]\n{table}")).unwrap();
        let fit = flown(&folder, "fit.csv", &spoilt, "pedal:3211:0.02:0.7", "1");
        let holdout = flown(&folder, "holdout.csv", &spoilt, "pedal:doublet:0.02:0.8", "2");
        let answer = diagnosed(&model, [&fit, &holdout], &json, &extended);
        let verdict = &answer["verdict"];
        assert!(verdict["statement"].as_str().unwrap().contains(words), "{verdict}");
        assert_eq!(answer["findings"].as_array().unwrap().len(), 1, "{answer}");
        assert_eq!(answer["findings"][0]["holdout"], "borne out");
        if let Some(factor) = verdict["factor"].as_f64() {
            let std = verdict["std"].as_f64().unwrap();
            assert!((factor + 1.1).abs() < 4.0 * std && std < 0.02, "{factor} +- {std}");
        }
        // The extended model predicts what is recorded, wrong as it is.
        let compared = folder.join("compared.json");
        let call = ["compare", path(&holdout), "--model", path(&model), "--beside", path(&extended), "--json", path(&compared)];
        let (status, _, said) = ended(&sideslip(&[&call[..], &["--force"]].concat()));
        assert_eq!(status, 0, "{said}");
        let text = std::fs::read_to_string(&compared).unwrap();
        let compared: Value = serde_json::from_str(&text).unwrap();
        let ratio = compared["all"]["pooled"]["ratio"].as_f64().unwrap();
        assert!(ratio < 0.5, "{words}: {ratio} {text}");
    }
}

#[test]
fn what_cannot_be_used_is_refused_in_words() {
    let folder = folder("diagnose-wrong");
    let model = own("replay/models/puma-like.toml");
    let text = std::fs::read_to_string(&model).unwrap();
    let good = flown(&folder, "good.csv", &model, "pedal:doublet:0.02:1", "1");
    let still = flown(&folder, "still.csv", &model, "pedal:doublet:0.0000001:1", "1");
    let other = folder.join("other.csv");
    let flight = std::fs::read_to_string(&good).unwrap();
    std::fs::write(&other, flight.replace("# aircraft = \"", "# aircraft = \"another ")).unwrap();
    let short = folder.join("short.csv");
    let head = flight.lines().take_while(|line| line.starts_with('#')).count() + 1;
    std::fs::write(&short, flight.lines().take(head + 60).collect::<Vec<_>>().join("\n") + "\n").unwrap();
    let empty = folder.join("empty.toml");
    let until = text.find("[derivatives.").unwrap();
    std::fs::write(&empty, &text[..until]).unwrap();
    let misspelt = folder.join("misspelt.toml");
    std::fs::write(&misspelt, text.replace("pedal = ", "peddal = ")).unwrap();
    for (model, fit, words) in [
        (&model, vec![&still], "no control moves"),
        (&model, vec![&good, &other], "runs of one aircraft"),
        (&model, vec![&short], "at least 3 s"),
        (&model, vec![&good, &good], "found the same file twice"),
        (&empty, vec![&good], "has no derivatives on any axis"),
        (&misspelt, vec![&good], "peddal"),
    ] {
        let mut call = vec!["diagnose", "--model", path(model), "--fit"];
        call.extend(fit.iter().map(|file| path(file)));
        let (status, _, said) = ended(&sideslip(&call));
        assert!(status == 2 && said.contains(words), "{words}: {status} {said}");
        assert_eq!(said.trim().lines().count(), 1, "{said}");
    }
}

/// A run that begins elsewhere than in the model's trim is looked at about its own, and that is said.
#[test]
fn another_trim_than_the_models_is_said() {
    let folder = folder("diagnose-trim");
    let run = folder.join("climb.csv");
    let fly = ["simulate", "--model", "puma", "--speed", "51.4", "--climb", "5", "--input", "pedal:3211:0.02:0.7", "--noise"];
    let (status, _, said) = ended(&sideslip(&[fly.as_slice(), &["--duration", "10", "--out", path(&run)]].concat()));
    assert_eq!(status, 0, "{said}");
    let call = ["diagnose", "--model", "puma", "--speed", "51.4", "--fit", path(&run), "--json", "-"];
    let (_, out, said) = ended(&sideslip(&call));
    let answer: Value = serde_json::from_str(&out).unwrap_or_else(|wrong| panic!("{wrong}: {said}"));
    let difference = &answer["trim_difference"]["collective"];
    assert!(difference["value"].as_f64().unwrap() > 5.0 * difference["std"].as_f64().unwrap(), "{answer}");
    assert!(said.contains("do not begin in the model's trim"), "{said}");
    assert!(answer["findings"].as_array().unwrap().iter().all(|one| one["channel"] != "collective"), "{answer}");
}

/// Instruments are judged first, with no model in the loop: a run whose sign is turned is named and set aside, the others stand.
#[test]
fn a_run_whose_instruments_disagree_is_set_aside() {
    let folder = folder("diagnose-aside");
    let model = own("replay/models/puma-like.toml");
    let turned = flown(&folder, "turned.csv", &model, "pedal:3211:0.02:0.7", "1");
    let good = flown(&folder, "good.csv", &model, "pedal:doublet:0.02:0.8", "2");
    let mut run = RunFile::read(&turned);
    let q = run.place("q");
    for cell in run.rows.iter_mut().filter_map(|row| row.get_mut(q)).filter(|cell| !cell.is_empty()) {
        *cell = format!("{}", -cell.parse::<f64>().unwrap());
    }
    run.write(&turned);
    let call = ["diagnose", "--model", path(&model), "--fit", path(&turned), path(&good), "--json", "-"];
    let (status, out, said) = ended(&sideslip(&call));
    assert_eq!(status, 3, "{said}");
    let answer: Value = serde_json::from_str(&out).unwrap();
    let aside = answer["set_aside"].as_array().unwrap();
    assert!(aside.len() == 1 && aside[0]["reason"].as_str().unwrap().contains("instruments do not agree"), "{aside:?}");
    assert!(said.contains("set aside") && answer["verdict"]["kind"] == "none", "{said}");
}
