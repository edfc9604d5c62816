//! Turns `budget.toml` into constants, and says so where an entry is missing, unknown or no number.

use std::fmt::Write as _;
use std::path::Path;

/// Every entry that the budget must have: section, key and the constant's name.
const ENTRIES: [(&str, &str, &str); 8] = [
    ("size", "profile", "PROFILE_BYTES"),
    ("size", "pipeline", "PIPELINE_BYTES"),
    ("size", "estimator", "ESTIMATOR_BYTES"),
    ("size", "filter", "FILTER_BYTES"),
    ("size", "regression", "REGRESSION_BYTES"),
    ("size", "tick", "TICK_BYTES"),
    ("size", "sample", "SAMPLE_BYTES"),
    ("stack", "step", "STEP_STACK_BYTES"),
];

fn main() -> Result<(), String> {
    println!("cargo::rerun-if-changed=budget.toml");
    let text = std::fs::read_to_string("budget.toml").map_err(|error| format!("budget.toml: {error}"))?;
    let constants = constants(&text)?;
    let folder = std::env::var("OUT_DIR").map_err(|error| format!("OUT_DIR: {error}"))?;
    std::fs::write(Path::new(&folder).join("budget.rs"), constants).map_err(|error| format!("{folder}: {error}"))
}

/// The constants of the small part of TOML that a budget is: sections, `key = bytes`, comments.
fn constants(text: &str) -> Result<String, String> {
    let mut section = String::new();
    let mut found = [None; ENTRIES.len()];
    for (number, line) in text.lines().enumerate() {
        let at = format!("budget.toml:{}", number + 1);
        let line = line.split('#').next().unwrap_or_default().trim();
        if let Some(name) = line.strip_prefix('[').and_then(|rest| rest.strip_suffix(']')) {
            section = name.trim().to_owned();
        } else if let Some((key, bytes)) = line.split_once('=') {
            let (key, bytes) = (key.trim(), bytes.trim());
            let place = ENTRIES
                .iter()
                .position(|entry| (entry.0, entry.1) == (section.as_str(), key))
                .ok_or_else(|| format!("{at}: [{section}] {key} is no entry of the budget"))?;
            let bytes: usize = bytes
                .replace('_', "")
                .parse()
                .map_err(|_| format!("{at}: expected a number of bytes for {key}, found {bytes:?}"))?;
            if found[place].replace(bytes).is_some() {
                return Err(format!("{at}: {key} stands here a second time"));
            }
        } else if !line.is_empty() {
            return Err(format!("{at}: expected `key = bytes`, found {line:?}"));
        }
    }
    let mut out = String::new();
    for ((section, key, name), bytes) in ENTRIES.iter().zip(found) {
        let bytes = bytes.ok_or_else(|| format!("budget.toml: [{section}] {key} is missing"))?;
        writeln!(out, "/// `{key}` of `[{section}]` in `budget.toml`, bytes.\npub const {name}: usize = {bytes};")
            .map_err(|error| error.to_string())?;
    }
    Ok(out)
}
