//! The answer of `sideslip identify`, read.

use super::program::{ended, path, sideslip};
use serde_json::Value;
use std::path::Path;

/// `identify` on these recordings: exit status and answer.
pub(crate) fn identified(files: &[&Path], more: &[&str]) -> (i32, Value) {
    let mut args = vec!["identify"];
    args.extend(files.iter().map(|file| path(file)));
    args.extend(more);
    args.extend(["--json", "-"]);
    let (status, out, said) = ended(&sideslip(&args));
    eprintln!("{said}");
    (status, serde_json::from_str(&out).unwrap_or_default())
}

/// A derivative over all runs with its standard error.
pub(crate) fn derivative(answer: &Value, name: &str) -> (f64, f64) {
    let parameters = answer["output_error"]["parameters"].as_array().unwrap();
    let found = parameters.iter().find(|one| one["name"] == name).unwrap_or_else(|| panic!("{name} in {parameters:?}"));
    (found["value"].as_f64().unwrap(), found["std"].as_f64().unwrap())
}
