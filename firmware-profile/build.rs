//! Turns `budget.toml`, or the file that FIRMWARE_BUDGET names, into constants and the board's memory map, and says so where an
//! entry is missing, unknown or no number.

use std::fmt::Write as _;
use std::path::Path;

/// Every entry that the budget must have: section, key and the constant's name.
const ENTRIES: [(&str, &str, &str); 12] = [
    ("size", "profile", "PROFILE_BYTES"),
    ("size", "pipeline", "PIPELINE_BYTES"),
    ("size", "estimator", "ESTIMATOR_BYTES"),
    ("size", "filter", "FILTER_BYTES"),
    ("size", "regression", "REGRESSION_BYTES"),
    ("size", "tick", "TICK_BYTES"),
    ("size", "sample", "SAMPLE_BYTES"),
    ("stack", "step", "STEP_STACK_BYTES"),
    ("board", "code", "BOARD_CODE_BYTES"),
    ("board", "memory", "BOARD_MEMORY_BYTES"),
    ("board", "stack", "BOARD_STACK_BYTES"),
    ("board", "instructions", "BOARD_STEP_INSTRUCTIONS"),
];

fn main() -> Result<(), String> {
    println!("cargo::rerun-if-env-changed=FIRMWARE_BUDGET");
    let file = std::env::var("FIRMWARE_BUDGET").unwrap_or_else(|_| "budget.toml".to_owned());
    println!("cargo::rerun-if-changed={file}");
    let text = std::fs::read_to_string(&file).map_err(|error| format!("{file}: {error}"))?;
    let limits = limits(&text)?;
    let folder = std::env::var("OUT_DIR").map_err(|error| format!("OUT_DIR: {error}"))?;
    let write = |name: &str, text: String| {
        std::fs::write(Path::new(&folder).join(name), text).map_err(|error| format!("{folder}/{name}: {error}"))
    };
    write("budget.rs", constants(&limits)?)?;
    if std::env::var("CARGO_CFG_TARGET_OS").is_ok_and(|system| system == "none") {
        write("memory.x", memory(&limits)?)?;
        println!("cargo::rerun-if-changed=board/cortex-m7.ld");
        println!("cargo::rustc-link-search={folder}");
        let script = std::env::current_dir().map_err(|error| error.to_string())?.join("board/cortex-m7.ld");
        println!("cargo::rustc-link-arg-bin=board=-T{}", script.display());
    }
    Ok(())
}

/// The board's memory for the linker: program from address 0, memory from 0x20000000, as on Arm's MPS2 AN500.
fn memory(limits: &[usize]) -> Result<String, String> {
    let of = |name: &str| {
        let place = ENTRIES.iter().position(|entry| entry.2 == name);
        place.and_then(|place| limits.get(place)).ok_or_else(|| format!("{name} is no limit"))
    };
    Ok(format!(
        "MEMORY\n{{\n    CODE (rx) : ORIGIN = 0x00000000, LENGTH = {}\n    MEMORY (rw) : ORIGIN = 0x20000000, LENGTH = {}\n}}\n\
         STACK_BYTES = {};\n",
        of("BOARD_CODE_BYTES")?,
        of("BOARD_MEMORY_BYTES")?,
        of("BOARD_STACK_BYTES")?
    ))
}

/// The limits, in the order of [`ENTRIES`], in the small part of TOML that a budget is: sections, `key = number`, comments.
fn limits(text: &str) -> Result<Vec<usize>, String> {
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
    let limit_of = |((section, key, _), limit): (&(&str, &str, &str), Option<usize>)| {
        limit.ok_or_else(|| format!("budget.toml: [{section}] {key} is missing"))
    };
    ENTRIES.iter().zip(found).map(limit_of).collect()
}

/// A constant for every limit.
fn constants(limits: &[usize]) -> Result<String, String> {
    let mut out = String::new();
    for ((section, key, name), limit) in ENTRIES.iter().zip(limits) {
        writeln!(out, "/// `{key}` of `[{section}]` in `budget.toml`.\npub const {name}: usize = {limit};")
            .map_err(|error| error.to_string())?;
    }
    Ok(out)
}
