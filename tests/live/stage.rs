//! What the tests stand on: a root that is gone at the end, processes that do not outlive their test, logs read back.

use crate::support::patience::PATIENCE;
use crate::support::program::folder;
use sideslip::io::telemetry::recording::Recording;
use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::sync::{Arc, Mutex};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

/// The longest wait for what a process said before it ended.
const LAST_WORDS: Duration = Duration::from_secs(1);

/// A folder of this test alone; its root is `root`.
pub(crate) fn stage(name: &str) -> PathBuf {
    folder(&format!("live-{name}"))
}

/// The program in the background; killed where the test ends before it does.
pub(crate) struct Running {
    child: Child,
    /// What it said so far, each line with when.
    said: Arc<Mutex<Vec<(Instant, String)>>>,
    listener: JoinHandle<()>,
}

impl Running {
    /// Starts it; its standard error is kept, its standard output goes nowhere.
    pub(crate) fn start(args: &[&str]) -> Self {
        let mut child = Command::new(env!("CARGO_BIN_EXE_sideslip"))
            .args(args)
            .stdin(Stdio::null())
            .stdout(Stdio::null())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
        let said = Arc::new(Mutex::new(Vec::new()));
        let (lines, kept) = (BufReader::new(child.stderr.take().unwrap()).lines(), Arc::clone(&said));
        let listener = std::thread::spawn(move || {
            lines.map_while(Result::ok).for_each(|line| kept.lock().unwrap().push((Instant::now(), line)))
        });
        Running { child, said, listener }
    }

    /// Its process number.
    pub(crate) fn number(&self) -> u32 {
        self.child.id()
    }

    /// Everything it said.
    pub(crate) fn said(&self) -> Vec<(Instant, String)> {
        self.said.lock().unwrap().clone()
    }

    /// Kills it at once.
    pub(crate) fn kill(&mut self) {
        self.child.kill().unwrap();
        self.child.wait().unwrap();
    }

    /// Waits for its end: the exit status.
    pub(crate) fn ended(&mut self) -> i32 {
        let begun = Instant::now();
        while begun.elapsed() < PATIENCE {
            if let Some(status) = self.child.try_wait().unwrap() {
                // Its last words are still on their way; a child of it that lives on keeps the way open.
                let ended = Instant::now();
                while !self.listener.is_finished() && ended.elapsed() < LAST_WORDS {
                    std::thread::sleep(Duration::from_millis(2));
                }
                return status.code().unwrap_or(-1);
            }
            std::thread::sleep(Duration::from_millis(2));
        }
        let said: Vec<String> = self.said().into_iter().map(|(_, line)| line).collect();
        panic!("still running after {PATIENCE:?}: {said:#?}");
    }
}

impl Drop for Running {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

/// Sends a signal by the system's own command.
pub(crate) fn signal(name: &str, process: u32) -> bool {
    Command::new("kill").args([&format!("-{name}"), &process.to_string()]).stderr(Stdio::null()).status().unwrap().success()
}

/// The times of the samples in a recording, s.
pub(crate) fn times(path: &Path) -> Vec<f64> {
    let Ok(mut recording) = Recording::open(path) else { return Vec::new() };
    let mut times = Vec::new();
    while let Ok(Some(row)) = recording.next_row() {
        times.push(row.sample.time_s);
    }
    times
}

/// What is left of a root in shared memory and in its directory: nothing, where everything ended in order.
pub(crate) fn left_behind(root: &Path) -> Vec<String> {
    let mut left: Vec<String> = Vec::new();
    let path = root.canonicalize().unwrap();
    let bytes = path.as_os_str().as_encoded_bytes();
    let hash = bytes.iter().fold(0xcbf2_9ce4_8422_2325_u64, |hash, &byte| (hash ^ u64::from(byte)).wrapping_mul(0x100_0000_01b3));
    let prefix = format!("sideslip_{hash:016x}_");
    for entry in std::fs::read_dir("/dev/shm").unwrap().flatten() {
        let name = entry.file_name().to_string_lossy().into_owned();
        if name.starts_with(&prefix) {
            left.push(name);
        }
    }
    left.extend(root.join(".sideslip/runs").exists().then(|| "runs".to_owned()));
    left
}
