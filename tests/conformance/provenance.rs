//! Where an answer comes from stands in it: program, call, files with SHA-256, date of the flight, units; and in logs UTC.

use crate::support::program::{ended, folder, own, path, puma, sideslip};
use serde_json::Value;
use sha2::{Digest, Sha256};
use std::path::Path;

const DATE: &str = "2024-05-17T09:30:01.500Z";
/// date -d '2024-05-17T09:30:01Z' +%s = 1715938201.
const DATE_NS: u64 = 1_715_938_201_500_000_000;

fn sha256(file: &Path) -> String {
    Sha256::digest(std::fs::read(file).unwrap()).iter().map(|byte| format!("{byte:02x}")).collect()
}

/// The document that a call writes to standard output.
fn document(args: &[&str]) -> Value {
    let (status, text, said) = ended(&sideslip(&[args, &["--json", "-"]].concat()));
    assert!(matches!(status, 0 | 3 | 4), "{args:?}: {status} {said}");
    serde_json::from_str(&text).unwrap()
}

#[test]
fn every_document_says_program_call_files_and_date() {
    let (puma, model) = (puma(), own("replay/models/puma-like.toml"));
    let (run, date, model) = (path(&puma), format!("recorded_at={DATE}"), path(&model));
    let dated = ["--set", &date];
    let calls: [(&[&str], bool); 6] = [
        (&["inspect", run], false),
        (&["check", run, dated[0], dated[1]], true),
        (&["replay", run, dated[0], dated[1]], true),
        (&["identify", run, dated[0], dated[1], "--states", "v,p,phi,r"], true),
        (&["compare", run, "--model", model, dated[0], dated[1]], true),
        (&["linearise", "--model", model], false),
    ];
    for (call, has_date) in calls {
        let provenance = &document(call)["provenance"];
        assert_eq!(provenance["program"], concat!("sideslip ", env!("CARGO_PKG_VERSION")), "{call:?}");
        let line = provenance["command_line"].as_str().unwrap();
        assert!(line.starts_with(&format!("sideslip {} ", call[0])) && line.ends_with(" --json -"), "{line}");
        let files = provenance["files"].as_array().unwrap();
        let named: Vec<&str> = files.iter().map(|file| file["file"].as_str().unwrap()).collect();
        for expected in [run, model].iter().filter(|file| call.contains(*file)) {
            let place = named.iter().position(|name| name == expected).unwrap_or_else(|| panic!("{call:?}: {named:?}"));
            assert_eq!(files[place]["sha256"], sha256(Path::new(expected)), "{call:?}");
            assert_eq!(files[place]["bytes"], std::fs::metadata(expected).unwrap().len());
            if has_date && *expected == run {
                assert_eq!(files[place]["recorded_at"], DATE, "{call:?}");
            }
        }
    }
    let (status, _, said) = ended(&sideslip(&["check", run, "--set", "recorded_at=in May"]));
    assert!(status == 2 && said.contains("2024-05-17T09:30:01Z") && said.contains("in May"), "{status} {said}");
}

#[test]
fn a_page_ends_with_its_files_and_their_hashes() {
    let (puma, folder) = (puma(), folder("provenance-page"));
    let (status, _, said) = ended(&sideslip(&["identify", path(&puma), "--states", "p,r", "--out", path(&folder)]));
    assert_eq!(status, 0, "{said}");
    let page = std::fs::read_to_string(folder.join("report.html")).unwrap();
    let foot = page.split_once("<footer>").unwrap().1;
    assert!(foot.contains(&sha256(&puma)) && foot.contains("sideslip identify ") && foot.contains("not stated"), "{foot}");
    assert!(page.trim_end().ends_with("</html>"));
}

#[test]
fn a_log_has_its_origin_the_units_of_its_fields_and_utc_where_the_run_is_dated() {
    let (puma, folder) = (puma(), folder("provenance-log"));
    let log = |name: &str, more: &[&str]| {
        let file = folder.join(name);
        let (status, _, said) = ended(&sideslip(&[&["replay", path(&puma), "--out", path(&file)], more].concat()));
        assert_eq!(status, 0, "{said}");
        std::fs::read(file).unwrap()
    };
    let date = format!("recorded_at={DATE}");
    let (dated, plain) = (log("dated.mcap", &["--set", &date]), log("plain.mcap", &[]));
    let first = |bytes: &[u8], topic: &str| {
        let found = mcap::MessageStream::new(bytes).unwrap().map(Result::unwrap).find(|message| message.channel.topic == topic);
        found.unwrap()
    };
    let sample = first(&dated, "/sample");
    assert_eq!((sample.log_time, sample.publish_time), (DATE_NS, DATE_NS));
    assert!(sample.channel.metadata["clock"].starts_with("UTC"));
    let begin: Value = serde_json::from_slice(&sample.data).unwrap();
    let last = mcap::MessageStream::new(&dated).unwrap().map(Result::unwrap).filter(|one| one.channel.topic == "/sample").last();
    let last = last.unwrap();
    let end: Value = serde_json::from_slice(&last.data).unwrap();
    let lasts_s = end["time"].as_f64().unwrap() - begin["time"].as_f64().unwrap();
    assert!(lasts_s > 5.0 && ((last.log_time - DATE_NS) as f64 * 1e-9 - lasts_s).abs() < 1e-8, "{lasts_s}");
    let own = first(&plain, "/sample");
    assert!((own.log_time as f64 * 1e-9 - begin["time"].as_f64().unwrap()).abs() < 1e-9);
    let units = |topic: &str, field: &str| first(&plain, topic).channel.metadata[field].clone();
    assert_eq!([units("/sample", "p"), units("/sample", "time"), units("/state", "u")], ["rad/s", "s", "m/s"]);
    assert_eq!([units("/modes", "dutch_roll.omega"), units("/derivatives", "equations.N.r2")], ["rad/s", "1"]);
    let metadata = mcap::read::LinearReader::new(&plain).unwrap().find_map(|record| match record.unwrap() {
        mcap::records::Record::Metadata(metadata) if metadata.name == "run" => Some(metadata.metadata),
        _ => None,
    });
    let metadata = metadata.unwrap();
    assert!(
        metadata["command_line"].starts_with("sideslip replay ") && metadata["files"].contains(&sha256(&puma)),
        "{metadata:?}"
    );
    // The same numbers come back from either log.
    let estimates = |name: &str| document(&["replay", path(&folder.join(name))])["runs"].clone();
    assert_eq!(estimates("dated.mcap")[0]["equations"], estimates("plain.mcap")[0]["equations"]);
}

#[test]
fn a_part_of_a_dated_run_has_the_date_of_its_own_first_sample() {
    let (puma, folder) = (puma(), folder("provenance-part"));
    let (date, moved) = (format!("recorded_at={DATE}"), "2024-05-17T09:30:03.500Z");
    let call = |command: &[&str]| {
        let (status, _, said) = ended(&sideslip(&[command, &["--set", &date, "--from", "2"]].concat()));
        assert_eq!(status, 0, "{said}");
    };
    let table = folder.join("part.csv");
    call(&["convert", path(&puma), path(&table)]);
    assert!(std::fs::read_to_string(&table).unwrap().contains(&format!("recorded_at = \"{moved}\"")));
    for (name, more) in [("own.mcap", None), ("bus.mcap", Some("--bus"))] {
        let log = folder.join(name);
        call(&[&["replay", path(&puma), "--out", path(&log)][..], more.as_slice()].concat());
        let bytes = std::fs::read(&log).unwrap();
        let times = mcap::MessageStream::new(&bytes).unwrap().map(Result::unwrap);
        let first = times.filter(|message| message.channel.topic == "/sample").map(|message| message.log_time).min();
        assert_eq!(first, Some(DATE_NS + 2_000_000_000), "{name}");
    }
    let seen = document(&["inspect", path(&puma), "--set", &date, "--from", "2"]);
    assert_eq!((&seen["run"]["recorded_at"], &seen["provenance"]["files"][0]["recorded_at"]), (&moved.into(), &moved.into()));
}

#[test]
fn a_telemetry_log_of_mavlink_has_the_date_of_its_first_stamp() {
    let (folder, model) = (folder("provenance-tlog"), own("replay/models/puma-like.toml"));
    let file = folder.join("flight.tlog");
    let call = ["simulate", "--model", path(&model), "--input", "pedal:doublet:0.01:1", "--duration", "4", "--out", path(&file)];
    let (status, _, said) = ended(&sideslip(&call));
    assert!(matches!(status, 0 | 3), "{said}");
    assert_eq!(document(&["inspect", path(&file)])["provenance"]["files"][0]["recorded_at"], "2026-01-01T00:00:00Z");
}

#[test]
fn derivatives_against_time_end_with_the_numbers_of_the_answer() {
    let (puma, folder) = (puma(), folder("provenance-derivatives"));
    let file = folder.join("history.csv");
    let answer = document(&["replay", path(&puma), "--derivatives", path(&file)]);
    let text = std::fs::read_to_string(&file).unwrap();
    let mut lines = text.lines().filter(|line| !line.starts_with('#'));
    let head: Vec<&str> = lines.next().unwrap().split(',').collect();
    let rows: Vec<Vec<&str>> = lines.map(|line| line.split(',').collect()).collect();
    assert!(rows.len() > 20 && rows.iter().all(|row| row.len() == head.len()), "{} rows", rows.len());
    let times: Vec<f64> = rows.iter().map(|row| row[0].parse().unwrap()).collect();
    assert!(times.array_windows().all(|[before, after]| after > before) && head[0] == "time[s]");
    let at_end = |name: &str| {
        let place = head.iter().position(|head| *head == name).unwrap_or_else(|| panic!("{name} in {head:?}"));
        rows.last().unwrap()[place].parse::<f64>().unwrap()
    };
    let terms = answer["runs"][0]["equations"]["N"]["terms"].as_array().unwrap();
    let n_r = terms.iter().find(|term| term["name"] == "N_r").unwrap();
    assert_eq!((at_end("N_r[1/s]"), at_end("std_N_r[1/s]")), (n_r["value"].as_f64().unwrap(), n_r["std"].as_f64().unwrap()));
    let omega = answer["modes"]["dutch_roll"]["omega"].as_f64().unwrap();
    assert_eq!(at_end("dutch_roll_omega[rad/s]").to_bits(), omega.to_bits());
    // A table of the program's own form: it reads it back.
    let seen = document(&["inspect", path(&file)]);
    assert_eq!(seen["rows"], rows.len());
    let (status, _, said) = ended(&sideslip(&["replay", path(&puma), "--derivatives", path(&file), "--smoothed", path(&file)]));
    assert!(status == 2 && said.contains("--derivatives"), "{status} {said}");
}
