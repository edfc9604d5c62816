//! The command on recordings: what is known of them comes out, and JSON has its form.

use crate::support::program::{ended, path, puma, real, sideslip};
use serde_json::Value;

fn checked(files: &[&std::path::Path]) -> (i32, Value) {
    let mut args = vec!["check"];
    args.extend(files.iter().map(|file| path(file)));
    args.extend(["--json", "-"]);
    let (status, out, _) = ended(&sideslip(&args));
    (status, serde_json::from_str(&out).unwrap_or_default())
}

/// The vane's offset ahead in a run's corrections, with its standard error.
fn vane(run: &Value) -> Option<(f64, f64)> {
    let corrections = run["corrections"].as_array()?;
    let vane = corrections.iter().find(|one| one["sensor"] == "vane")?;
    Some((vane["offset_m"][0].as_f64()?, vane["std"].as_f64()?))
}

#[test]
fn sideslip_of_the_attas_is_measured_13_m_ahead() {
    let Some(file) = real("attas-rud1.csv") else { return };
    let (status, answer) = checked(&[&file]);
    let run = &answer["runs"][0];
    let (ahead, std) = vane(run).unwrap();
    assert!(status == 0 && (ahead - 13.1).abs() < 0.5 && std < 1.0, "{ahead} +- {std}");
    let r2 = &run["consistency"]["beta"];
    assert!((r2["r2_before"].as_f64().unwrap() - 0.965).abs() < 0.004 && r2["r2_after"].as_f64().unwrap() > 0.99, "{r2}");
    assert_eq!(run["verdict"], "fit after corrections");
}

#[test]
#[ignore = "a study"]
fn all_three_agree_on_it() {
    let files: Option<Vec<_>> = ["attas-rud1.csv", "attas-ail1.csv", "attas-elv1.csv"].into_iter().map(real).collect();
    let Some(files) = files else { return };
    for file in &files {
        let (ahead, std) = vane(&checked(&[file]).1["runs"][0]).unwrap();
        assert!((ahead - 13.1).abs() < 3.0 * std && std < 1.0, "{}: {ahead} +- {std}", file.display());
    }
    let together: Vec<&std::path::Path> = files.iter().map(|file| file.as_path()).collect();
    let (status, answer) = checked(&together);
    let (ahead, std) = vane(&answer["runs"][2]).unwrap();
    assert!(status == 0 && (ahead - 13.1).abs() < 3.0 * std && std < 0.6, "{ahead} +- {std}");
}

#[test]
fn without_accelerometers_it_says_what_is_left() {
    let Some(file) = real("citation-2018-dutchroll.csv") else { return };
    let run = &checked(&[&file]).1["runs"][0];
    let said = run["not_observable"].to_string();
    assert!(said.contains("ax ay az: not measured") && said.contains("only attitude and rates are compared"), "{said}");
    assert!(run["consistency"].as_object().unwrap().is_empty());
}

#[test]
fn the_recording_that_comes_along_is_fit() {
    let (status, answer) = checked(&[&puma()]);
    assert!(status == 0 && answer["runs"][0]["verdict"] == "fit", "{answer}");
    let (status, out, said) = ended(&sideslip(&["check", path(&puma()), "--set", "vane_position_m=[10,0,0]"]));
    assert!(status == 0 && out.contains("behind where the run says") && said.is_empty(), "{status} {out} {said}");
}
