//! The log as the Python reader of the MCAP project sees it: index, counts, schemas, metadata, validity.
//!
//! The reader is installed with pip into a virtual environment under the target folder; where that cannot be done the
//! test says that it was skipped.

use super::example::{folder, rows, write};
use std::path::{Path, PathBuf};
use std::process::Command;

const PACKAGES: [&str; 3] = ["mcap==1.*", "lz4==4.*", "jsonschema==4.*"];

fn succeeds(command: &mut Command) -> bool {
    command.output().is_ok_and(|output| output.status.success())
}

/// A Python with the reader installed; `None` where there is none to be had.
fn python() -> Option<PathBuf> {
    let venv = Path::new(env!("CARGO_TARGET_TMPDIR")).join("mcap-reader");
    let python = venv.join("bin/python");
    let ready = |python: &Path| succeeds(Command::new(python).args(["-c", "import mcap, lz4, jsonschema"]));
    if ready(&python) {
        return Some(python);
    }
    let made = succeeds(Command::new("python3").args(["-m", "venv"]).arg(&venv))
        && succeeds(Command::new(&python).args(["-m", "pip", "install", "-q", "--disable-pip-version-check"]).args(PACKAGES));
    (made && ready(&python)).then_some(python)
}

#[test]
fn the_python_reader_finds_every_message_with_a_schema_that_it_obeys() {
    let Some(python) = python() else {
        eprintln!("SKIPPED: no Python with the packages {}", PACKAGES.join(", "));
        return;
    };
    let folder = folder("independent");
    let path = folder.join("run.mcap");
    // Finite numbers and absences only: a null is what a schema for viewers cannot allow.
    let mut rows = rows(200);
    for (sample, unknown) in &mut rows {
        for value in sample.values.iter_mut().chain(unknown) {
            *value = if value.is_finite() { *value } else { 1.5 };
        }
    }
    let summary = write(&path, &rows, 26);
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/conformance/read_log.py");
    let output = Command::new(&python).arg(&script).arg(&path).output().unwrap();
    let told = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{told}");
    let found: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    for (topic, count) in [
        ("/sample", 200),
        ("/state", 200),
        ("/smoothed", 25),
        ("/innovation", 200),
        ("/derivatives", 25),
        ("/modes", 25),
        ("/output_error", 25),
        ("/finding", 0),
        ("/event", 4),
    ] {
        let channel = &found["topics"][topic];
        assert_eq!(channel["count"], count, "{topic}");
        assert_eq!(channel["streamed"], count, "{topic}");
        assert_eq!((&channel["encoding"], &channel["schema"]), (&"json".into(), &"jsonschema".into()), "{topic}");
        assert_eq!(channel["invalid"], serde_json::json!([]), "{topic}");
    }
    assert_eq!(summary.written, 704);
    assert_eq!(found["metadata"]["toml"], "run = \"467/10/11\"\naircraft = \"P\u{fc}ma\"\n");
    assert_eq!(found["metadata"]["controls"], "fixed_wing");
    assert_eq!(found["units"]["fuel"].as_str().unwrap().split('[').nth(1), Some("litre]"));
    // Bits, by Python's own reading of the text.
    for (k, (sample, _)) in rows.iter().enumerate() {
        let time = found["sample_time_bits"][k].as_str().unwrap();
        assert_eq!(u64::from_str_radix(time, 16).unwrap(), sample.time_s.to_bits());
    }
    assert_eq!(found["first_log_times"], serde_json::json!([0, 0, 0, 1_718_750]));
}
