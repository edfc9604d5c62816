//! `sideslip inspect` as a user runs it: exit status, one line of complaint, table and JSON where each belongs.

use serde_json::Value;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

fn inspect(file: &Path, more: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_sideslip")).arg("inspect").arg(file).args(more).output().unwrap()
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8(bytes.to_vec()).unwrap()
}

fn written(name: &str, content: &[u8]) -> PathBuf {
    let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
    std::fs::write(&path, content).unwrap();
    path
}

/// The folder of real recordings, where it is.
fn recordings() -> Option<PathBuf> {
    let default = || Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared/data");
    let root = std::env::var_os("SIDESLIP_DATA").map_or_else(default, PathBuf::from);
    if !root.join("flight").is_dir() {
        eprintln!("SKIPPED: no recordings at {}", root.display());
        return None;
    }
    Some(root)
}

#[test]
fn a_good_file_gives_a_table_and_nothing_else() {
    let file = written("good.csv", b"# run = \"7\"\ntime,p[deg/s],q,r\n0,1,0,0\n0.1,2,0,0\n0.2,3,0,0\n");
    let output = inspect(&file, &[]);
    assert_eq!(output.status.code(), Some(0));
    assert!(output.stderr.is_empty());
    let table = text(&output.stdout);
    for words in ["3 rows", "median rate 10 Hz", "`beta`: v is not observed", "never moves"] {
        assert!(table.contains(words), "{words} is not in\n{table}");
    }
}

#[test]
fn skipped_rows_end_with_status_3_and_are_said() {
    let file = written("skips.csv", b"time,p\n0,1\n0.1,x\n0.2,3\n0.3");
    let output = inspect(&file, &["--json", "-"]);
    assert_eq!(output.status.code(), Some(3));
    let answer: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!((&answer["rows"], &answer["skipped"]["rows"]), (&Value::from(2), &Value::from(2)));
    assert_eq!(answer["skipped"]["reasons"][0]["first"], Value::from(3));
    assert_eq!(answer["channels"][0]["max"], Value::from(3.0));
    let said = text(&output.stderr);
    assert!(said.contains("2 of 4 rows skipped") && said.contains("What the channels allow"), "{said}");
}

#[test]
fn wrong_files_end_with_status_2_and_one_line() {
    for (name, content, words) in [
        ("unit.csv", b"time,tas[furlong]\n0,1\n".as_slice(), ["unit.csv:1:6:", "`tas`"]),
        ("preamble.csv", b"# run = 3\ntime\n0\n", ["preamble.csv:1:9:", "text in quotes"]),
        ("empty.csv", b"", ["empty.csv:", "empty file"]),
        ("rows.csv", b"time,p\n", ["rows.csv:1:1:", "rows after the header"]),
        ("program.csv", b"\x7fELF\x01\x00\x00", ["7f 45 4c 46", "no known format"]),
        ("log.csv", b"\x25\xEB\x01\x00", ["Chapter 10", "found none"]),
    ] {
        let output = inspect(&written(name, content), &[]);
        let said = text(&output.stderr);
        assert_eq!((output.status.code(), output.stdout.len(), said.lines().count()), (Some(2), 0, 1), "{said}");
        assert!(words.iter().all(|word| said.contains(word)), "{said}");
    }
    assert_eq!(inspect(Path::new("/nowhere/at/all.csv"), &[]).status.code(), Some(2));
}

#[test]
fn a_json_file_is_written_whole_or_not_at_all() {
    let file = written("whole.csv", b"time,p\n0,1\n");
    let target = Path::new(env!("CARGO_TARGET_TMPDIR")).join("whole.json");
    let _ = std::fs::remove_file(&target);
    assert_eq!(inspect(&file, &["--json", target.to_str().unwrap()]).status.code(), Some(0));
    let answer: Value = serde_json::from_slice(&std::fs::read(&target).unwrap()).unwrap();
    assert_eq!(answer["rows"], Value::from(1));
    assert_eq!(inspect(&file, &["--json", "/nowhere/at/all.json"]).status.code(), Some(1));
}

#[test]
fn real_recordings_are_read_whole() {
    let Some(root) = recordings() else { return };
    for (name, rate_hz, dutch_roll) in [
        ("attas-rud1", 25.0, true),
        ("attas-ail1", 25.0, true),
        ("attas-elv1", 25.0, true),
        ("citation-2018-dutchroll", 10.0, false),
        ("citation-2018-short-period", 10.0, false),
        ("twin-otter-020213f1_018", 50.0, true),
    ] {
        let file = root.join(format!("flight/{name}.csv"));
        let output = inspect(&file, &["--json", "-"]);
        assert_eq!(output.status.code(), Some(0), "{name}");
        let answer: Value = serde_json::from_slice(&output.stdout).unwrap();
        let lines = std::fs::read_to_string(&file).unwrap().lines().filter(|line| !line.starts_with('#')).count();
        assert_eq!(answer["rows"], Value::from(lines - 1), "{name}");
        assert!((answer["time"]["rate_hz"].as_f64().unwrap() - rate_hz).abs() < 1e-6, "{name}");
        assert_eq!(answer["estimable"]["dutch_roll"]["possible"], Value::from(dutch_roll), "{name}");
        let altitude = answer["channels"].as_array().unwrap().iter().find(|channel| channel["name"] == "altitude").unwrap();
        assert_eq!((&altitude["unit"], &altitude["unit_in_file"]), (&Value::from("m"), &Value::from("ft")));
    }
}

#[test]
fn logs_of_autopilots_show_their_channels_and_what_they_are() {
    let Some(root) = recordings() else { return };
    // Counts of pymavlink and pyulog: 45 IMU and 24 ATT messages; the last message of the dataflash is cut short.
    for (file, status, format, channel, samples, source) in [
        ("logs/plane-3.8.2.BIN", 3, "ArduPilot dataflash", "p", 45, "command"),
        ("logs/plane-3.8.2.BIN", 3, "ArduPilot dataflash", "phi", 24, "estimate of the autopilot"),
        ("logs/sample_log_small.ulg", 3, "PX4 ULog", "p", 0, "instrument"),
    ] {
        let output = inspect(&root.join(file), &["--json", "-"]);
        let said = text(&output.stderr);
        assert_eq!(output.status.code(), Some(status), "{file}: {said}");
        assert!(said.contains(format) && said.contains(source) && said.contains("passed over"), "{said}");
        let answer: Value = serde_json::from_slice(&output.stdout).unwrap();
        let found = answer["channels"].as_array().unwrap().iter().find(|one| one["name"] == channel).unwrap();
        let count = found["samples"].as_u64().unwrap();
        assert!(if samples > 0 { count == samples } else { count > 1000 }, "{file}: {found}");
    }
}

#[test]
fn chapter_10_recordings_show_their_channels_and_a_setup_that_contradicts_its_data() {
    let Some(root) = recordings() else { return };
    let output = inspect(&root.join("irig106/pcm_old_101348.c10"), &["--json", "-"]);
    let said = text(&output.stderr);
    assert_eq!(output.status.code(), Some(3), "{said}");
    assert!(said.contains("224 bits") && said.contains("4096"), "{said}");
    let answer: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!((&answer["packets"], answer["contradictions"].as_array().unwrap().len()), (&Value::from(25), 1), "{answer}");
    let output = inspect(&root.join("irig106/err.c10"), &[]);
    assert_eq!(output.status.code(), Some(3), "the last packet is cut short");
    assert!(text(&output.stdout).contains("cut short"), "{}", text(&output.stdout));
}
