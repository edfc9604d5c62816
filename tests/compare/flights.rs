//! Simulated flights: a model is as good as its instruments' noise on its own flight, and what it lacks is what is gained.

use crate::support::program::{ended, folder, own, path, puma, sideslip};
use serde_json::Value;
use std::path::Path;

fn compared(args: &[&str]) -> Value {
    let mut call = vec!["compare"];
    call.extend(args);
    call.extend(["--json", "-"]);
    let (status, out, said) = ended(&sideslip(&call));
    assert_eq!(status, 0, "{said}");
    serde_json::from_str(&out).unwrap()
}

fn flown(folder: &Path, name: &str, model: &Path) -> std::path::PathBuf {
    let out = folder.join(name);
    let call =
        ["simulate", "--model", path(model), "--input", "pedal:doublet:0.02:1", "--duration", "15", "--noise", "--seed", "3"];
    let (status, _, said) = ended(&sideslip(&[&call[..], &["--pilot", "attitude", "--out", path(&out)]].concat()));
    assert_eq!(status, 0, "{said}");
    out
}

/// The recording that comes with the project against the model that flew it: nothing is left but noise and what the controls'
/// noise lets drift.
#[test]
fn a_model_on_its_own_flight_is_as_good_as_the_noise() {
    let model = own("replay/models/puma-like.toml");
    let answer = compared(&[path(&puma()), "--model", path(&model)]);
    let channels = &answer["runs"][0]["channels"];
    for channel in ["p", "r", "ay"] {
        let of = |key: &str| channels[channel][key].as_f64().unwrap();
        eprintln!("{channel}: rms {:.5}, noise {:.5}, TIC {:.4}, VAF {:.4}", of("rms"), of("noise_std"), of("theil"), of("vaf"));
        assert!(of("rms") < 2.0 * of("noise_std") && of("vaf") > 0.98 && of("theil") < 0.1, "{channels:#}");
    }
    assert!(answer["runs"][0]["pooled"]["over_noise"].as_f64().unwrap() < 3.0, "{answer:#}");
    assert!(answer["runs"][0]["diverged_at_s"].is_null());
}

/// An aircraft with a lag that the model lacks: the model with it is better on every channel that moves, and pictures are drawn.
#[test]
fn what_a_model_lacks_is_gained() {
    let folder = folder("compare-gain");
    let model = own("replay/models/puma-like.toml");
    let extended = folder.join("extended.toml");
    let lag = "\n[[effect]]\nkind = \"actuator_lag\"\ncontrol = \"pedal\"\ntau = 0.3\n";
    std::fs::write(&extended, std::fs::read_to_string(&model).unwrap() + lag).unwrap();
    let run = flown(&folder, "lagged.csv", &extended);
    let pictures = folder.join("pictures");
    let answer = compared(&[path(&run), "--model", path(&model), "--beside", path(&extended), "--out", path(&pictures)]);
    let pooled = &answer["runs"][0]["pooled"];
    eprintln!("{pooled:#}");
    assert_eq!(pooled["judged"], "gain");
    assert!(pooled["ratio"].as_f64().unwrap() < 0.6, "{answer:#}");
    assert_eq!(answer["runs"][0]["channels"]["r"]["judged"], "gain");
    let picture = std::fs::read_to_string(pictures.join("lagged.svg")).unwrap();
    assert!(["measured", "model beside", "controls"].iter().all(|words| picture.contains(words)));
    let written: Value = serde_json::from_str(&std::fs::read_to_string(pictures.join("compare.json")).unwrap()).unwrap();
    assert_eq!(written, answer);
    // The other way round it is a loss; a model beside itself is no gain.
    let back = compared(&[path(&run), "--model", path(&extended), "--beside", path(&model)]);
    assert_eq!(back["all"]["pooled"]["judged"], "loss");
    let same = compared(&[path(&run), "--model", path(&model), "--beside", path(&model)]);
    assert_eq!(same["all"]["pooled"]["judged"], "no gain");
}

/// A model that diverges is a result.
#[test]
fn a_model_that_diverges_is_cut_there() {
    let folder = folder("compare-diverges");
    let wild = folder.join("wild.toml");
    let text = std::fs::read_to_string(own("replay/models/puma-like.toml")).unwrap();
    std::fs::write(&wild, text.replace("p = -1.4939", "p = 3.0")).unwrap();
    let (status, out, said) = ended(&sideslip(&["compare", path(&puma()), "--model", path(&wild)]));
    assert!(status == 0 && out.contains("diverges at") && !out.contains("NaN"), "{status} {out} {said}");
}

/// One that diverges before its trim window ends has no score: the mean that is taken out was all there is.
#[test]
fn a_model_that_diverges_at_once_has_no_score_and_no_number_is_raw() {
    let folder = folder("compare-diverges-at-once");
    let wild = folder.join("wild.toml");
    let text = std::fs::read_to_string(own("replay/models/puma-like.toml")).unwrap();
    std::fs::write(&wild, text.replace("p = -1.4939", "p = 500.0")).unwrap();
    let (status, out, said) = ended(&sideslip(&["compare", path(&puma()), "--model", path(&wild)]));
    assert!(status == 0 && out.contains("the model DIVERGES at") && out.contains("no score"), "{status} {out} {said}");
    assert!(!out.contains("times the noise") && !out.contains("NaN") && !out.contains("0.00"), "{out}");
    let beside = own("replay/models/puma-like.toml");
    let (status, out, said) = ended(&sideslip(&["compare", path(&puma()), "--model", path(&beside), "--beside", path(&wild)]));
    assert!(status == 0 && out.contains("the model beside DIVERGES at") && !out.contains("no gain"), "{status} {out} {said}");
    let (status, out, _) = ended(&sideslip(&["compare", path(&puma()), "--model", path(&wild), "--json", "-"]));
    let answer: serde_json::Value = serde_json::from_str(&out).unwrap();
    assert!(status == 0 && answer["all"]["pooled"]["over_noise"].is_null() && answer["runs"][0]["scored"] == false, "{out}");
}

/// The Level-1 Puma on its own flight, all four controls and the rotor's speed.
#[test]
fn a_level1_model_is_compared_alike() {
    let folder = folder("compare-level1");
    let run = flown(&folder, "level1.csv", Path::new("puma"));
    let answer = compared(&[path(&run), "--model", "puma"]);
    let pooled = answer["all"]["pooled"]["over_noise"].as_f64().unwrap();
    eprintln!("level 1: {pooled:.2} times noise");
    assert!(pooled < 3.0, "{answer:#}");
    assert!(answer["runs"][0]["channels"]["torque"].is_object());
}
