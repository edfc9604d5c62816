//! A ground station on the loopback, by pymavlink: what it received, as JSON.

use crate::support::patience::until;
use crate::support::program::own;
use serde_json::Value;
use std::io::{BufRead, BufReader};
use std::os::unix::fs::OpenOptionsExt;
use std::path::{Path, PathBuf};
use std::process::{Child, ChildStdin, Command, Stdio};
use std::sync::{Arc, Mutex};
use std::thread::JoinHandle;

/// A key, as hexadecimal digits.
pub(crate) const KEY: &str = "5a3f1c9e77d0b2486ae1f09c3d5b8274c1e6a90f4b7d2835ee61fc0a9d48b317";

/// A file with the key that only its owner can read.
pub(crate) fn key_file(folder: &Path) -> PathBuf {
    let file = folder.join("flight.key");
    let mut options = std::fs::OpenOptions::new();
    let mut open = options.write(true).create(true).truncate(true).mode(0o600).open(&file).unwrap();
    std::io::Write::write_all(&mut open, format!("{KEY}\n").as_bytes()).unwrap();
    file
}

/// The ground station, in the background.
pub(crate) struct Peer {
    child: Child,
    input: Option<ChildStdin>,
    port: u16,
    received: Arc<Mutex<Vec<Value>>>,
    reader: Option<JoinHandle<()>>,
}

impl Peer {
    /// Starts it; with a key it takes only what is signed with that.
    pub(crate) fn start(pymavlink: &Path, key: Option<&str>) -> Self {
        let mut call = Command::new("python3");
        call.arg(own("tests/live/station_peer.py")).arg("receive").args(key).env("PYTHONPATH", pymavlink);
        let mut child = call.stdin(Stdio::piped()).stdout(Stdio::piped()).spawn().unwrap();
        let mut lines = BufReader::new(child.stdout.take().unwrap()).lines();
        let port = lines.next().unwrap().unwrap().parse().unwrap();
        let received = Arc::new(Mutex::new(Vec::new()));
        let kept = Arc::clone(&received);
        let read = move || {
            lines.map_while(Result::ok).for_each(|line| kept.lock().unwrap().push(serde_json::from_str(&line).unwrap()));
        };
        Peer { input: child.stdin.take(), child, port, received, reader: Some(std::thread::spawn(read)) }
    }

    /// Where it listens on the loopback.
    pub(crate) fn port(&self) -> u16 {
        self.port
    }

    /// Everything so far.
    pub(crate) fn received(&self) -> Vec<Value> {
        self.received.lock().unwrap().clone()
    }

    /// Ends it: everything that it received.
    pub(crate) fn end(&mut self) -> Vec<Value> {
        self.input = None;
        until("the peer's end", || self.reader.as_ref().is_none_or(JoinHandle::is_finished));
        self.reader.take().map(JoinHandle::join).transpose().unwrap();
        self.received()
    }
}

impl Drop for Peer {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}
