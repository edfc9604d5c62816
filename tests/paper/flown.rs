//! Flights of the paper's models with instruments of flight quality, and what `identify` says of them.

use crate::support::paper_cases::PaperCase;
use crate::support::program::{ended, own, path, sideslip};
use serde_json::Value;
use std::path::{Path, PathBuf};

/// Pedal, then lateral cyclic.
pub(crate) const INPUTS: [(&str, &str); 2] = [("pedal", "pedal:3211:0.01:0.7"), ("lat_cyclic", "lat_cyclic:3211:0.006:0.6")];

/// The model as a file, and a run with each input.
pub(crate) fn flights(folder: &Path, case: &PaperCase, seed: u64) -> Vec<PathBuf> {
    flown_by(folder, case, &case.model_file(), seed)
}

/// The same of a model file of that text.
pub(crate) fn flown_by(folder: &Path, case: &PaperCase, text: &str, seed: u64) -> Vec<PathBuf> {
    let model = folder.join(format!("{}.toml", case.name));
    std::fs::write(&model, text).unwrap();
    let instruments = own("replay/instruments/flight-test.toml");
    let one = |(place, (control, input)): (usize, &(&str, &str))| {
        let file = folder.join(format!("{}-{control}-{seed}.csv", case.name));
        let seed = (2 * seed + place as u64).to_string();
        let call =
            ["simulate", "--model", path(&model), "--input", input, "--instruments", path(&instruments), "--duration", "18"];
        let (status, _, said) = ended(&sideslip(&[&call[..], &["--seed", &seed, "--out", path(&file)]].concat()));
        assert_eq!(status, 0, "{said}");
        file
    };
    INPUTS.iter().enumerate().map(one).collect()
}

/// `identify` on these runs.
pub(crate) fn identified(files: &[PathBuf], more: &[&str]) -> Value {
    let mut call = vec!["identify"];
    call.extend(files.iter().map(|file| path(file)));
    call.extend(more);
    call.extend(["--json", "-"]);
    let (status, out, said) = ended(&sideslip(&call));
    eprintln!("{said}");
    assert!(status == 0 || status == 3, "{said}");
    serde_json::from_str(&out).unwrap()
}
