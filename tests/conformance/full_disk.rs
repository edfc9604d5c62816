//! A disk that takes no more, as a limit of the size of a file: it is reported, what was written is readable, what is counted as
//! written can be read, and no part of a file is left where only a whole one is wanted.

#![cfg(unix)]

use super::example::{folder, read};
use crate::support::program::{ended, files_in, own, path, puma};
use sideslip::flight::file::log_head::LogHead;
use sideslip::io::outputs::log::mcap_log::McapLog;
use sideslip::io::outputs::record::Message;
use sideslip::io::telemetry::recording::Recording;
use std::fs::File;
use std::path::Path;
use std::process::Command;

/// Runs the program with files of so many blocks (of 512 or 1024 bytes, as the shell counts) at most.
fn limited(blocks: u32, args: &[&str]) -> (i32, String, String) {
    let script = format!("ulimit -f {blocks}; exec \"$0\" \"$@\"");
    let program = env!("CARGO_BIN_EXE_sideslip");
    ended(&Command::new("sh").args(["-c", &script, program]).args(args).output().unwrap())
}

#[test]
fn a_log_that_reaches_the_limit_goes_on_and_counts_nothing_that_cannot_be_read() {
    let folder = folder("full-disk");
    let log = folder.join("flight.mcap");
    let (status, out, said) = limited(600, &["replay", path(&puma()), "--out", path(&log)]);
    assert_eq!(status, 3, "{said}");
    assert!(said.contains("flight.mcap: writing failed (File too large"), "{said}");
    let files = files_in(&folder);
    let mut messages = 0;
    for name in &files {
        let file = folder.join(name);
        assert!(file.metadata().unwrap().len() > 0, "{name} is empty");
        messages += read(File::open(&file).unwrap()).unwrap().1.messages;
    }
    let number = |text: &str, before: &str, after: &str| -> u64 {
        let (_, rest) = text.split_once(before).unwrap_or_else(|| panic!("no `{before}`: {text}"));
        rest.split_once(after).unwrap().0.trim().parse().unwrap()
    };
    let written = number(&out, &format!("log: {}, ", log.display()), " messages");
    eprintln!("{files:?}: {messages} messages can be read, {written} are said to be written; {said}");
    // The beginning of a chunk that is torn may be read too.
    assert!(written > 0 && written <= messages, "{written} {messages}");
    assert!(said.contains("messages are not in the log"), "{said}");
}

#[test]
fn what_is_to_be_whole_leaves_nothing_and_is_named_as_it_was_asked_for() {
    let folder = folder("full-disk-whole");
    let model = own("replay/models/puma-like.toml");
    let simulate = ["simulate", "--model", path(&model), "--input", "pedal:3211:0.02:0.7", "--duration", "60", "--out"];
    let puma = puma();
    let calls: [(&[&str], &str); 5] = [
        (&["convert", path(&puma)], "c.csv"),
        (&["convert", path(&puma)], "c.mcap"),
        (&["replay", path(&puma), "--smoothed"], "s.csv"),
        (&["replay", path(&puma), "--smoothed"], "s.mcap"),
        (&simulate, "f.csv"),
    ];
    for (call, name) in calls {
        let target = folder.join(name);
        let (status, _, said) = limited(40, &[call, &[path(&target)]].concat());
        assert_eq!(status, 1, "{name}: {said}");
        assert!(said.contains(&format!("{name}: ")) && said.contains("File too large") && !said.contains("partial"), "{said}");
        assert!(!said.contains("goes on"), "{said}");
        assert!(files_in(&folder).is_empty(), "{:?}", files_in(&folder));
    }
}

/// A disk without any room, as a device: nothing is begun on it, and nothing is left there.
#[test]
fn a_log_for_which_there_is_no_room_at_all_is_refused_and_leaves_no_file() {
    let folder = folder("full-disk-none");
    let target = folder.join("flight.mcap");
    let (status, _, said) = limited(0, &["replay", path(&puma()), "--out", path(&target)]);
    assert!(status == 1 && said.contains("flight.mcap: ") && said.contains("File too large"), "{status} {said}");
    assert!(files_in(&folder).is_empty(), "{:?}", files_in(&folder));
    if !Path::new("/dev/full").exists() {
        eprintln!("SKIPPED: no /dev/full");
        return;
    }
    let mut recording = Recording::open(&puma()).unwrap();
    let head = LogHead {
        run_toml: String::new(),
        channels: Vec::new(),
        controls: recording.info().geometry().controls,
        ..LogHead::default()
    };
    let sample = recording.next_row().unwrap().unwrap().sample;
    match McapLog::create(Path::new("/dev/full"), head, Box::new(|_| ())) {
        Err(error) => assert!(error.to_string().contains("No space left on device"), "{error}"),
        Ok(mut log) => {
            log.message(&Message::Sample(sample));
            panic!("{:?}", log.close());
        }
    }
}
