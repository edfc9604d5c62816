//! A terminal that takes nothing (ctrl-S, a stopped pager, a pipe that nobody reads) holds up nobody: neither estimates, nor
//! their supervision, nor ctrl-C, nor the numbers at the end.

use super::sender::{Vehicle, samples};
use super::stage::{left_behind, signal, stage};
use crate::support::patience::{PATIENCE, until};
use crate::support::program::{path, puma};
use rustix::fs::{OFlags, fcntl_getfl, fcntl_setfl};
use serde_json::Value;
use sideslip::io::bus::reader::Reader;
use std::io::{PipeReader, PipeWriter, Write, pipe};
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::Instant;

/// A pipe that is full, and that nobody reads.
fn full_pipe() -> (PipeReader, PipeWriter) {
    let (reader, mut writer) = pipe().unwrap();
    let flags = fcntl_getfl(&writer).unwrap();
    fcntl_setfl(&writer, flags | OFlags::NONBLOCK).unwrap();
    for piece in [4096, 1] {
        while writer.write(&vec![b'.'; piece]).is_ok() {}
    }
    fcntl_setfl(&writer, flags).unwrap();
    (reader, writer)
}

/// The program with both streams full; killed where the test ends before it does.
struct Unheard(Child);

impl Unheard {
    fn start(args: &[&str], [output, error]: [&PipeWriter; 2]) -> Self {
        let mut call = Command::new(env!("CARGO_BIN_EXE_sideslip"));
        call.args(args).stdin(Stdio::null()).stdout(output.try_clone().unwrap()).stderr(error.try_clone().unwrap());
        Unheard(call.spawn().unwrap())
    }

    /// Waits for its end: the exit status.
    fn ended(&mut self) -> i32 {
        let begun = Instant::now();
        loop {
            if let Some(status) = self.0.try_wait().unwrap() {
                return status.code().unwrap_or(-1);
            }
            assert!(begun.elapsed() < PATIENCE, "still running after {PATIENCE:?}");
            std::thread::sleep(std::time::Duration::from_millis(2));
        }
    }
}

impl Drop for Unheard {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

/// The child of a process that runs that command.
fn child_of(parent: u32, command: &str) -> Option<u32> {
    let children = std::fs::read_to_string(format!("/proc/{parent}/task/{parent}/children")).ok()?;
    children.split_whitespace().filter_map(|number| number.parse().ok()).find(|number: &u32| {
        let call = std::fs::read_to_string(format!("/proc/{number}/cmdline")).unwrap_or_default();
        call.split('\0').nth(1) == Some(command)
    })
}

/// How many runs the numbers are of.
fn runs_in(json: &Path) -> usize {
    let answer: Value = serde_json::from_str(&std::fs::read_to_string(json).unwrap()).unwrap();
    answer["runs"].as_array().map_or(0, Vec::len)
}

#[test]
fn live_estimates_and_ends_with_its_numbers_though_its_terminal_has_stopped() {
    let _turn = crate::alone();
    let stage = stage("stopped-terminal");
    let (root, logs, json) = (stage.join("root"), stage.join("logs"), stage.join("live.json"));
    let ((_unread, output), (_unheard, error)) = (full_pipe(), full_pipe());
    let source = format!("file://{}", puma().display());
    let call = ["live", "--source", &source, "--speed", "8", "--root", path(&root), "--out", path(&logs), "--json", path(&json)];
    let mut live = Unheard::start(&call, [&output, &error]);
    assert_eq!(live.ended(), 0);
    assert!(runs_in(&json) == 1 && logs.read_dir().unwrap().count() == 1);
    assert_eq!(left_behind(&root), [""; 0]);
}

#[test]
fn who_is_killed_comes_back_and_ctrl_c_ends_it_though_the_terminal_has_stopped() {
    let _turn = crate::alone();
    let stage = stage("stopped-terminal-killed");
    let (root, json) = (stage.join("root"), stage.join("live.json"));
    let ((_unread, output), (_unheard, error)) = (full_pipe(), full_pipe());
    let vehicle = Vehicle::start(samples(&puma()), 1.0);
    let call = ["live", "--source", vehicle.url(), "--root", path(&root), "--json", path(&json)];
    let mut live = Unheard::start(&call, [&output, &error]);
    for command in ["estimate", "ingest"] {
        until("a child", || child_of(live.0.id(), command).is_some());
        let mut reader = Reader::open(&root).unwrap();
        until("an estimate", || reader.latest().unwrap().is_some());
        let before = child_of(live.0.id(), command).unwrap();
        assert!(signal("KILL", before));
        until("another", || child_of(live.0.id(), command).is_some_and(|number| number != before));
        let time_s = |reader: &mut Reader| reader.latest().unwrap().map_or(0.0, |estimate| estimate.derivatives.time_s);
        let then_s = time_s(&mut reader);
        until("new estimates", || time_s(&mut reader) > then_s);
    }
    assert!(signal("INT", live.0.id()));
    assert_eq!(live.ended(), 3, "done, with restarts");
    assert!(runs_in(&json) > 0);
    assert_eq!(left_behind(&root), [""; 0]);
}

#[test]
fn watch_ends_by_ctrl_c_though_its_terminal_has_stopped() {
    let _turn = crate::alone();
    let root = stage("stopped-terminal-watch").join("root");
    let ((_unread, output), (_unheard, error)) = (full_pipe(), full_pipe());
    let mut watch = Unheard::start(&["watch", "--every", "0.02", "--root", path(&root)], [&output, &error]);
    until("it reads", || root.join(".sideslip").exists());
    std::thread::sleep(std::time::Duration::from_secs(1));
    assert!(watch.0.try_wait().unwrap().is_none(), "it waits for its reader");
    assert!(signal("INT", watch.0.id()));
    assert_eq!(watch.ended(), 0);
}
