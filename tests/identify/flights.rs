//! Flights of a model of kind `linear`, whose derivatives are known to every digit; the motion itself is not linear.

use crate::support::identified::{derivative, identified};
use crate::support::program::{ended, folder, own, path, sideslip};
use serde_json::Value;
use std::path::{Path, PathBuf};

fn model() -> PathBuf {
    own("replay/models/puma-like.toml")
}

/// A flight with the usual instruments' noise.
fn flown(folder: &Path, name: &str, input: &str, seed: &str) -> PathBuf {
    let (file, model) = (folder.join(name), model());
    let args = ["simulate", "--model", path(&model), "--input", input, "--noise", "--seed", seed, "--out", path(&file)];
    let (status, _, said) = ended(&sideslip(&args));
    assert_eq!(status, 0, "{said}");
    file
}

#[test]
fn all_eight_states_come_back_from_four_runs_and_predict_a_fifth() {
    let folder = folder("identify-puma");
    let inputs = [
        ("pedal.csv", "pedal:3211:0.01:0.7", "1"),
        ("lateral.csv", "lat_cyclic:3211:0.01:0.5", "2"),
        ("longitudinal.csv", "lon_cyclic:3211:0.01:0.7", "4"),
        ("collective.csv", "collective:doublet:0.01:1.0", "5"),
    ];
    let runs: Vec<PathBuf> = inputs.iter().map(|(name, input, seed)| flown(&folder, name, input, seed)).collect();
    let runs: Vec<&Path> = runs.iter().map(PathBuf::as_path).collect();
    let kept = flown(&folder, "kept.csv", "pedal:doublet:0.01:1.0", "3");
    let out = folder.join("out");
    let more = [
        "--states",
        "u,v,w,p,q,r,phi,theta",
        "--inputs",
        "lat_cyclic,pedal,lon_cyclic,collective",
        "--outputs",
        "tas,beta,alpha,p,q,r,phi,theta,ax,ay,az",
        "--holdout",
        path(&kept),
        "--out",
        path(&out),
    ];
    let (status, answer) = identified(&runs, &more);
    assert!(status == 0 && answer["output_error"]["converged"] == true);
    let model_file = model();
    let (_, text, _) = ended(&sideslip(&["linearise", "--model", path(&model_file), "--json", "-"]));
    let truth: Value = serde_json::from_str(&text).unwrap();
    let (mut off, mut count) = (0.0, 0.0);
    for axis in ["L", "M", "N"] {
        for variable in ["v", "w", "p", "q", "r", "lat_cyclic", "lon_cyclic", "collective", "pedal"] {
            let Some(known) = truth["derivatives"][axis][variable].as_f64() else { continue };
            let (found, std) = derivative(&answer, &format!("{axis}_{variable}"));
            let errors = (found - known) / std;
            eprintln!("{axis}_{variable} {found:.5} +- {std:.5}, truth {known:.5}: {errors:.1} s.e.");
            off += errors * errors;
            count += 1.0;
            // Beside chance: the noise of the controls' transducers, which the model flies and no standard error has. Over all
            // errors are 1.9 standard errors rms (of a percent and less).
            assert!(
                (found - known).abs() < 3.0 * std + 0.01 * known.abs() + 0.005,
                "{axis}_{variable}: {found} +- {std}, truth {known}"
            );
        }
    }
    let rms = f64::sqrt(off / count);
    eprintln!("errors {rms:.2} standard errors rms, of {count}");
    assert!(rms < 2.5, "{rms}");
    for channel in ["p", "r", "beta"] {
        let vaf = answer["holdout"][0]["channels"][channel]["vaf"].as_f64().unwrap();
        assert!(vaf > 0.98, "{channel}: {vaf}");
    }
    let page = std::fs::read_to_string(out.join("report.html")).unwrap();
    assert!(page.contains("<svg") && page.contains("kept") && !page.contains("<script") && !page.contains("src="));
    let again = folder.join("again.csv");
    let found = out.join("model.toml");
    let (status, _, said) =
        ended(&sideslip(&["simulate", "--model", path(&found), "--input", "pedal:doublet:0.01:1", "--out", path(&again)]));
    assert_eq!(status, 0, "the identified model is flown: {said}");
    let (_, text, _) = ended(&sideslip(&["linearise", "--model", path(&found), "--json", "-"]));
    let written: Value = serde_json::from_str(&text).unwrap();
    let (n_r, _) = derivative(&answer, "N_r");
    assert!((written["derivatives"]["N"]["r"].as_f64().unwrap() - n_r).abs() < 1e-3 * n_r.abs());
}
