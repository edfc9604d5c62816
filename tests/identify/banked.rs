//! A trim with bank and sideslip, where every known entry of the equations of motion counts.

use crate::support::identified::identified;
use crate::support::program::{ended, folder, own, path, sideslip};
use serde_json::Value;

/// Excites both planes.
const INPUTS: [&str; 4] =
    ["pedal:3211:0.01:0.7", "lat_cyclic:3211:0.005:0.7:8", "lon_cyclic:3211:0.01:0.7:14", "collective:doublet:0.01:1:20"];

#[test]
fn the_modes_are_those_of_the_banked_aircraft_and_so_is_the_model_that_is_written() {
    let folder = folder("identify-banked");
    // 9.4 degrees of sideslip and 8.6 of bank: there the Dutch roll grows.
    let text = std::fs::read_to_string(own("replay/models/puma-like.toml")).unwrap();
    let text = text.replace("\nv = 0.0\n", "\nv = 8.5\n").replace("phi = 0.026149", "phi = 0.15");
    assert!(text.contains("v = 8.5") && text.contains("phi = 0.15"));
    let (model, run, out) = (folder.join("banked.toml"), folder.join("banked.csv"), folder.join("out"));
    std::fs::write(&model, text).unwrap();
    let flown: Vec<&str> = INPUTS.iter().flat_map(|input| ["--input", input]).collect();
    let call = [&["simulate", "--model", path(&model), "--noise", "--seed", "1", "--out", path(&run)], &flown[..]].concat();
    let (status, _, said) = ended(&sideslip(&call));
    assert_eq!(status, 0, "{said}");
    let (status, answer) = identified(&[run.as_path()], &["--out", path(&out)]);
    assert!(status == 0 && answer["output_error"]["converged"] == true);
    let linearised = |file: &std::path::Path| -> Value {
        let (status, text, said) = ended(&sideslip(&["linearise", "--model", path(file), "--json", "-"]));
        assert_eq!(status, 0, "{said}");
        serde_json::from_str(&text).unwrap()
    };
    let truth = linearised(&model);
    let known = &truth["modes"]["dutch_roll"];
    let found = &answer["modes"]["dutch_roll"];
    for part in ["real", "imag"] {
        let (found, std) = (found[part].as_f64().unwrap(), found[format!("std_{part}")].as_f64().unwrap());
        let known = known[part].as_f64().unwrap();
        eprintln!("{part} {found:.5} +- {std:.5}, truth {known:.5}");
        assert!((found - known).abs() < 4.0 * std && std < 2e-3, "{part}: {found} +- {std}, truth {known}");
    }
    assert!(known["real"].as_f64().unwrap() > 0.01 && found["probability_unstable"].as_f64().unwrap() > 0.999);
    // What is written is the same aircraft: its sideslip in trim is there, and its modes are those that were told.
    let written = linearised(&out.join("model.toml"));
    assert!((written["trim"]["v"].as_f64().unwrap() - 8.5).abs() < 0.3, "{}", written["trim"]);
    let again = written["modes"]["dutch_roll"]["real"].as_f64().unwrap();
    assert!((again - found["real"].as_f64().unwrap()).abs() < 1e-4, "{again}");
}
