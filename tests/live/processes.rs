//! The processes as a user runs them: the same numbers through shared memory, a second one refused, an end in order.

use super::stage::{Running, left_behind, signal, stage, times};
use crate::support::patience::until;
use crate::support::program::{ended, folder, own, path, puma, real, sideslip, without_provenance};
use serde_json::Value;
use sideslip::io::bus::reader::{Reader, VALID_FOR};
use sideslip::realtime::regression::record::Status;
use std::path::{Path, PathBuf};
use std::time::Duration;

fn source(file: &Path) -> String {
    format!("file://{}", file.display())
}

/// What `replay` of these prints and writes: in this process, or through shared memory.
fn replayed(file: &Path, more: &[&str]) -> (i32, String, String, String) {
    let json = folder("live-replayed").join("answer.json");
    let (status, out, said) = ended(&sideslip(&[&["replay", path(file), "--json", path(&json)], more].concat()));
    (status, out, said, without_provenance(&std::fs::read_to_string(&json).unwrap()))
}

#[test]
fn through_shared_memory_the_numbers_are_the_same_bit_for_bit() {
    let _turn = crate::alone();
    let mut files: Vec<(PathBuf, Vec<&str>)> = vec![(puma(), vec![]), (puma(), vec!["--set", "vane_position_m=[5,0,0]"])];
    let recordings = ["attas-rud1.csv", "twin-otter-020213f1_018.csv", "attas-elv1.csv"];
    files.extend(recordings.iter().filter_map(|name| Some((real(name)?, vec!["--set", "vane_position_m=[13.08,0,0]"]))));
    for (file, more) in files {
        let here = replayed(&file, &more);
        let there = replayed(&file, &[more.as_slice(), &["--bus"]].concat());
        assert_eq!(here, there, "{}", file.display());
    }
}

/// Samples that wait to be taken reach an estimator that came after them: telemetry published no more before the first was taken,
/// so nothing connected them, and on a loaded machine `live --speed max` waited without end.
#[test]
fn an_estimator_that_comes_after_the_samples_takes_them_all() {
    let _turn = crate::alone();
    let stage = stage("late-estimator");
    let (root, long) = (stage.join("root"), puma());
    let short = stage.join("short.csv");
    let text = std::fs::read_to_string(&long).unwrap();
    // One that fits into shared memory whole, its end too, and one that does not.
    std::fs::write(&short, text.lines().take(300).map(|line| format!("{line}\n")).collect::<String>()).unwrap();
    for file in [&short, &long] {
        let log = stage.join("log.mcap");
        let _ = std::fs::remove_file(&log);
        let mut ingest = Running::start(&["ingest", "--source", &source(file), "--speed", "max", "--root", path(&root)]);
        until("samples that wait", || ingest.said().iter().any(|(_, line)| line.contains("waiting for an estimator")));
        let mut estimate = Running::start(&["estimate", "--root", path(&root), "--out", path(&log)]);
        assert_eq!(ingest.ended(), 0, "{:?}", ingest.said());
        assert!(signal("TERM", estimate.number()));
        assert_eq!(estimate.ended(), 0, "{:?}", estimate.said());
        assert_eq!(times(&log), times(file), "{}", file.display());
    }
    assert_eq!(left_behind(&root), [""; 0]);
}

/// Whatever is in a recording, `live` ends with it: one row, times that go back, jump or are none; one that cannot be read is
/// given up after some attempts.
#[test]
fn live_on_a_recording_ends_whatever_is_in_it() {
    let _turn = crate::alone();
    let stage = stage("odd-recordings");
    let (root, text) = (stage.join("root"), std::fs::read_to_string(puma()).unwrap());
    let table: Vec<&str> = text.lines().filter(|line| !line.starts_with('#')).take(300).collect();
    type TimeOf = fn(usize) -> String;
    let times: [(&str, TimeOf); 5] = [
        ("one", |row| if row == 0 { "0".to_owned() } else { String::new() }),
        ("back", |row| (300 - row).to_string()),
        ("jumps", |row| ((row % 3) * 5).to_string()),
        ("none", |_| "nan".to_owned()),
        ("huge", |row| format!("{row}e300")),
    ];
    for (name, time) in times {
        let file = stage.join(name).with_extension("csv");
        let rows = table[1..].iter().enumerate().map(|(row, line)| (time(row), line.split_once(',').unwrap().1));
        let rows = rows.filter(|(time, _)| !time.is_empty()).map(|(time, rest)| format!("{time},{rest}\n"));
        std::fs::write(&file, format!("{}\n{}", table[0], rows.collect::<String>())).unwrap();
        let mut live = Running::start(&["live", "--source", &source(&file), "--speed", "max", "--root", path(&root)]);
        assert!(matches!(live.ended(), 0 | 2 | 3), "{name}: {:?}", live.said());
    }
    // Reading its first byte is an error of the system's.
    let mut live = Running::start(&["live", "--source", "file:///proc/self/mem", "--speed", "max", "--root", path(&root)]);
    assert_eq!(live.ended(), 1, "{:?}", live.said());
    assert!(live.said().iter().any(|(_, line)| line.contains("ingest failed 5 times")), "{:?}", live.said());
}

#[test]
fn bits_without_a_frame_end_by_a_signal_and_with_the_parent() {
    let _turn = crate::alone();
    let stage = stage("no-lock");
    let (root, format) = (stage.join("root"), stage.join("frame.toml"));
    std::fs::write(&format, super::pcm_link::format()).unwrap();
    let url = format!("pcm+file:///dev/zero?format={}", path(&format));
    let ingest = ["ingest", "--source", &url, "--root", path(&root)];
    let mut running = Running::start(&ingest);
    until("the root", || root.exists());
    std::thread::sleep(Duration::from_millis(300));
    assert!(signal("TERM", running.number()));
    assert_eq!(running.ended(), 0, "{:?}", running.said());
    // Standard input, which says that the parent is there, has ended.
    let mut orphan = Running::start(&[&ingest[..], &["--supervised"]].concat());
    assert_eq!(orphan.ended(), 0, "{:?}", orphan.said());
    let mut replay = Running::start(&["replay", &url]);
    std::thread::sleep(Duration::from_millis(500));
    assert!(signal("INT", replay.number()));
    assert_eq!(replay.ended(), 1, "{:?}", replay.said());
    assert!(replay.said().iter().any(|(_, line)| line.contains("before its first sample")), "{:?}", replay.said());
    assert_eq!(left_behind(&root), [""; 0]);
}

#[test]
fn the_logs_of_both_ways_hold_the_same_samples_and_nothing_is_left() {
    let _turn = crate::alone();
    let stage = stage("replay-logs");
    let Some(flight) = real("twin-otter-020213f1_018.csv") else { return };
    let (here, there) = (stage.join("here.mcap"), stage.join("there.mcap"));
    let run = |log: &Path, more: &[&str]| {
        let (status, _, said) = ended(&sideslip(&[&["replay", path(&flight), "--out", path(log)], more].concat()));
        assert_eq!(status, 0, "{said}");
        let (status, out, said) = ended(&sideslip(&["replay", path(log), "--json", "-"]));
        assert_eq!(status, 0, "{said}");
        let inspected = ended(&sideslip(&["inspect", path(log), "--json", "-"])).1;
        let mut inspected: Value = serde_json::from_str(&inspected).unwrap();
        inspected.as_object_mut().unwrap().retain(|key, _| !matches!(key.as_str(), "file" | "path" | "provenance"));
        (without_provenance(&out), inspected)
    };
    assert_eq!(run(&here, &[]), run(&there, &["--bus"]), "samples and the columns that nobody knows");
}

#[test]
fn private_roots_go_with_their_process_and_those_of_the_killed_with_the_next() {
    let _turn = crate::alone();
    let temporary = stage("private-roots");
    let program = |args: &[&str]| {
        let mut program = std::process::Command::new(env!("CARGO_BIN_EXE_sideslip"));
        program.args(args).env("TMPDIR", &temporary).stdout(std::process::Stdio::null()).stderr(std::process::Stdio::null());
        program
    };
    let roots = || std::fs::read_dir(&temporary).unwrap().flatten().map(|entry| entry.path()).collect::<Vec<_>>();
    let replay = ["replay", path(&puma()), "--bus"].map(str::to_owned);
    let replay: Vec<&str> = replay.iter().map(String::as_str).collect();
    assert!(program(&replay).status().unwrap().success());
    assert!(roots().is_empty(), "{:?}", roots());
    let mut killed = program(&[replay.as_slice(), &["--speed", "1"]].concat()).spawn().unwrap();
    until("a private root with somebody in it", || roots().iter().any(|root| root.join(".sideslip/telemetry").exists()));
    killed.kill().unwrap();
    killed.wait().unwrap();
    let left = roots();
    assert_eq!(left.len(), 1);
    // Once its telemetry has ended too, and it is older than a minute.
    let inside = left[0].join(".sideslip/inside");
    until("its telemetry has left", || std::fs::File::open(&inside).is_ok_and(|file| file.try_lock().is_ok()));
    let old = std::time::SystemTime::now() - Duration::from_secs(100);
    // What its telemetry takes away at the last makes the folder young again.
    until("the next has taken it away", || {
        if let Ok(folder) = std::fs::File::open(&left[0]) {
            folder.set_modified(old).unwrap();
        }
        assert!(program(&replay).status().unwrap().success());
        roots().is_empty()
    });
}

#[test]
fn what_is_wrong_with_a_recording_is_said_the_same_way() {
    let _turn = crate::alone();
    let folder = folder("live-damaged");
    let damaged = folder.join("damaged.csv");
    let text = std::fs::read_to_string(puma()).unwrap();
    std::fs::write(&damaged, text.replacen("\n0.5,", "\nx,", 1).replacen("\n0.6", "\n0.6,0", 1)).unwrap();
    let (here, there) = (replayed(&damaged, &[]), replayed(&damaged, &["--bus"]));
    assert_eq!(here, there);
    assert_eq!(here.0, 3, "{}", here.2);
}

#[test]
fn telemetry_and_estimator_meet_whoever_comes_first_and_readers_see_them_go() {
    let _turn = crate::alone();
    let stage = stage("meeting");
    let (root, log, json) = (stage.join("root"), stage.join("flight.mcap"), stage.join("flight.json"));
    let mut ingest = Running::start(&["ingest", "--source", &source(&puma()), "--speed", "2.5", "--root", path(&root)]);
    until("telemetry announces its run", || root.join(".sideslip/runs").read_dir().is_ok_and(|mut heads| heads.next().is_some()));
    let call = ["estimate", "--root", path(&root), "--out", path(&log), "--json", path(&json)];
    let mut estimate = Running::start(&call);
    let mut reader = Reader::open(&root).unwrap();
    until("an estimate that holds", || reader.latest().unwrap().is_some_and(|estimate| estimate.is_valid()));
    // A second of each is refused in words.
    let (status, _, said) = ended(&sideslip(&call));
    assert!(status == 2 && said.contains("has the role `estimator` already"), "{said}");
    let (status, _, said) = ended(&sideslip(&["ingest", "--source", &source(&puma()), "--root", path(&root)]));
    assert!(status == 2 && said.contains(&format!("process {} has the role `telemetry`", ingest.number())), "{said}");
    // Watch shows it to a person and to a program.
    let (status, out, said) = ended(&sideslip(&["watch", "--root", path(&root), "--count", "2", "--every", "0.1", "--json"]));
    assert_eq!(status, 0, "{said}");
    let lines: Vec<Value> = out.lines().map(|line| serde_json::from_str(line).unwrap()).collect();
    assert_eq!(lines[1]["estimate"]["run"], "puma-100kn-pedal-3211", "{out}");
    assert!(lines[1]["sequence"].as_u64() > lines[0]["sequence"].as_u64() && lines[1]["age"].as_f64().unwrap() < 1.0);
    let (_, out, _) = ended(&sideslip(&["watch", "--root", path(&root), "--count", "1"]));
    assert!(out.contains("Lateral modes") && out.contains(" missed: "), "{out}");
    // The recording ends, the run with it; the estimator stays for the next.
    assert_eq!(ingest.ended(), 0);
    std::thread::sleep(VALID_FOR);
    assert_eq!(reader.latest().unwrap().unwrap().status, Status::Stale, "nobody estimates any more");
    let again = ["ingest", "--source", &source(&puma()), "--speed", "max", "--root", path(&root)];
    let (status, _, said) = ended(&sideslip(&again));
    assert_eq!(status, 0, "{said}");
    assert!(signal("TERM", estimate.number()));
    assert_eq!(estimate.ended(), 0, "{:?}", estimate.said());
    let all = times(&puma());
    assert_eq!((times(&log), times(&stage.join("flight-2.mcap"))), (all.clone(), all));
    let answer: Value = serde_json::from_str(&std::fs::read_to_string(&json).unwrap()).unwrap();
    let expected: Value = serde_json::from_str(&replayed(&puma(), &[]).3).unwrap();
    for run in answer["runs"].as_array().unwrap() {
        assert_eq!(run["equations"], expected["runs"][0]["equations"]);
        assert_eq!(run["modes"], expected["runs"][0]["modes"]);
    }
    assert_eq!(answer["runs"].as_array().unwrap().len(), 2);
    drop(reader);
    assert_eq!(left_behind(&root), [""; 0]);
}

#[test]
fn live_ends_with_its_source_and_the_answer_is_that_of_a_replay() {
    let _turn = crate::alone();
    let stage = stage("whole");
    let (root, logs, json) = (stage.join("root"), stage.join("logs"), stage.join("live.json"));
    let args = ["live", "--source", &source(&puma()), "--speed", "20", "--root", path(&root), "--out", path(&logs)];
    let (status, out, said) = ended(&sideslip(&[args.as_slice(), &["--json", path(&json)]].concat()));
    assert_eq!(status, 0, "{said}");
    assert!(out.contains("Dutch roll") && out.contains("1251 samples"), "{out}");
    // Output error has the wall clock's time here, and waits for the end of a manoeuvre there.
    let answer = |text: &str| {
        let mut run = serde_json::from_str::<Value>(text).unwrap()["runs"][0].clone();
        let fitted = run.as_object_mut().unwrap().remove("output_error").unwrap();
        // Twenty times as fast as the flight was, and after three seconds of patience, it may not have come far.
        assert!(fitted["status"].is_string(), "{fitted}");
        run
    };
    let (live, replay) = (answer(&std::fs::read_to_string(&json).unwrap()), answer(&replayed(&puma(), &[]).3));
    assert_eq!(live, replay, "live and replay are one pipeline");
    let log = logs.join("puma-100kn-pedal-3211.mcap");
    assert_eq!(times(&log), times(&puma()));
    // A file that is played has its own date, here none, and not that of the day on which it is played.
    let bytes = std::fs::read(&log).unwrap();
    let first = mcap::MessageStream::new(&bytes).unwrap().next().unwrap().unwrap();
    assert!(first.log_time < 1_000_000_000_000 && !first.channel.metadata["clock"].starts_with("UTC"), "{}", first.log_time);
    assert_eq!(left_behind(&root), [""; 0]);
}

#[test]
fn ctrl_c_and_sigterm_close_the_log_and_a_supervisor_that_dies_takes_its_processes_along() {
    let _turn = crate::alone();
    for name in ["INT", "TERM", "KILL"] {
        let stage = stage(&format!("signal-{name}"));
        let (root, logs) = (stage.join("root"), stage.join("logs"));
        let mut live = Running::start(&["live", "--source", &source(&puma()), "--root", path(&root), "--out", path(&logs)]);
        let log = logs.join("puma-100kn-pedal-3211.mcap");
        until("half a second in the log", || times(&log).len() > 25);
        let numbers: Vec<u32> = live
            .said()
            .iter()
            .filter_map(|(_, line)| line.rsplit_once(" is process ").and_then(|(_, number)| number.parse().ok()))
            .collect();
        assert_eq!(numbers.len(), 2);
        assert!(signal(name, live.number()));
        let status = live.ended();
        assert_eq!(status, if name == "KILL" { -1 } else { 0 }, "{:?}", live.said());
        until("nobody is left", || numbers.iter().all(|number| !signal("0", *number)));
        let (status, out, said) = ended(&sideslip(&["inspect", path(&log), "--json", "-"]));
        assert_eq!(status, 0, "the log is whole: {out}{said}");
        until("the last one out has swept", || left_behind(&root).is_empty() || name == "KILL");
    }
}

#[test]
fn a_call_that_cannot_work_is_not_tried_again() {
    let _turn = crate::alone();
    let stage = stage("wrong");
    let root = stage.join("root");
    let missing = source(&stage.join("missing.csv"));
    let (status, _, said) = ended(&sideslip(&["live", "--source", &missing, "--root", path(&root)]));
    assert_eq!(status, 2, "{said}");
    assert!(said.contains("missing.csv") && said.matches("is process").count() == 2, "{said}");
    for wrong in ["ftp://x", "file://"] {
        assert_eq!(ended(&sideslip(&["ingest", "--source", wrong, "--root", path(&root)])).0, 2);
    }
    let manifest = own("Cargo.toml");
    let out = ["estimate", "--root", path(&root), "--out", path(&manifest)];
    assert_eq!(ended(&sideslip(&out)).0, 2);
}

/// Process numbers of telemetry and estimator, as the supervisor says them; the newest of each.
fn children(live: &Running) -> [u32; 2] {
    ["ingest", "estimate"].map(|name| {
        let mark = format!("sideslip: {name} is process ");
        let number = |(_, line): &(_, String)| line.strip_prefix(&mark).and_then(|number| number.parse().ok());
        live.said().iter().filter_map(number).next_back().unwrap()
    })
}

#[test]
fn a_supervisor_that_was_killed_does_not_block_the_next() {
    let _turn = crate::alone();
    let stage = stage("next");
    let (root, source) = (stage.join("root"), source(&puma()));
    let call = ["live", "--source", &source, "--speed", "4", "--root", path(&root)];
    for _ in 0..3 {
        let mut live = Running::start(&call);
        until("both run", || live.said().iter().filter(|(_, line)| line.contains(" is process ")).count() == 2);
        std::thread::sleep(Duration::from_millis(300));
        live.kill();
    }
    let (status, out, said) = ended(&sideslip(&call));
    assert_eq!(status, 0, "{said}");
    assert!(out.contains("1251 samples"), "{out}");
    assert_eq!(left_behind(&root), [""; 0]);
}

#[test]
fn an_estimator_that_hangs_is_replaced_and_one_killed_at_the_end_is_a_failure() {
    let _turn = crate::alone();
    let stage = stage("hangs");
    let root = stage.join("root");
    let mut live = Running::start(&["live", "--source", &source(&puma()), "--root", path(&root)]);
    until("both run", || live.said().iter().filter(|(_, line)| line.contains(" is process ")).count() == 2);
    let mut reader = Reader::open(&root).unwrap();
    until("an estimate that holds", || reader.latest().unwrap().is_some_and(|estimate| estimate.is_valid()));
    let [_, estimator] = children(&live);
    assert!(signal("STOP", estimator));
    until("stale", || reader.latest().unwrap().is_some_and(|estimate| estimate.status == Status::Stale));
    until("another estimator", || children(&live)[1] != estimator);
    until("an estimate again", || reader.latest().unwrap().is_some_and(|estimate| estimate.status != Status::Stale));
    assert!(live.said().iter().any(|(_, line)| line.contains("takes samples no more")), "{:?}", live.said());
    // Killed while it ends: there is no answer, and that is no success.
    let [_, estimator] = children(&live);
    assert!(signal("STOP", estimator));
    assert!(signal("INT", live.number()));
    std::thread::sleep(Duration::from_millis(400));
    assert!(signal("KILL", estimator));
    assert_eq!(live.ended(), 1, "{:?}", live.said());
}

#[test]
fn what_cannot_be_written_is_said_before_the_flight_and_a_reader_that_goes_ends_watch() {
    let _turn = crate::alone();
    let stage = stage("unwritable");
    let (root, file) = (stage.join("root"), stage.join("file"));
    std::fs::write(&file, "").unwrap();
    let below = file.join("logs");
    let source = source(&puma());
    let (status, _, said) = ended(&sideslip(&["live", "--source", &source, "--out", path(&below), "--root", path(&root)]));
    assert!(status == 2 && said.contains("--out: expected a directory for logs"), "{status} {said}");
    let mut watch = std::process::Command::new(env!("CARGO_BIN_EXE_sideslip"));
    watch.args(["watch", "--root", path(&root), "--every", "0.02"]).stdout(std::process::Stdio::piped());
    let mut watch = watch.spawn().unwrap();
    drop(watch.stdout.take());
    until("watch ends", || watch.try_wait().unwrap().is_some());
    assert_eq!(watch.wait().unwrap().code(), Some(0));
}
