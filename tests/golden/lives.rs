//! `live`: processes over shared memory, fed by a link that loses nothing and by a file.
//!
//! Records are compared by the vehicle's time; nothing in a log depends on the clock of this machine. Left out: output error,
//! which works beside the flight on what had come by then, so that its records depend on the machine's load (`replay` has
//! them); and standard error, which names processes and arrives from several at once.

use super::case::{Case, program};
use super::flights::LINEAR;
use super::log::Whole;
use super::vehicle::{answer, fly, frames};
use mcap::read::Options;
use std::net::TcpListener;
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

/// The longest wait for a process on a busy machine.
const PATIENCE: Duration = Duration::from_secs(60);
/// How much faster than it was flown: 10 s, fewer samples than the places in shared memory hold.
const SPEED: f64 = 2.0;
const FLIGHT: &str = "--rate 50 --noise flight --seed 8 --duration 10 --input pedal:3211:0.02:0.7";

/// The program in the background, ended with the test.
struct Running(Child);

impl Drop for Running {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

/// Times of the samples in a log that may still be growing, ns.
fn sampled(log: &Path) -> Vec<u64> {
    let bytes = std::fs::read(log).unwrap_or_default();
    let Ok(messages) = mcap::MessageStream::new_with_options(&bytes, Options::IgnoreEndMagic.into()) else { return Vec::new() };
    let samples = messages.map_while(Result::ok).filter(|message| message.channel.topic == "/sample");
    samples.map(|message| message.log_time).collect()
}

/// MAVLink over TCP: the frames of a simulated recording, sent twice as fast as they were flown.
pub(crate) fn link(case: &mut Case) {
    case.prepare(&format!("simulate --model {LINEAR} {FLIGHT} --out flight.tlog"));
    let frames = frames(&std::fs::read(case.folder.join("flight.tlog")).unwrap());
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let source = format!("tcp://{}", listener.local_addr().unwrap());
    let call = ["live", "--source", &source, "--output-error", "off", "--root", "root", "--out", "logs", "--json", "answer.json"];
    let mut started = Command::new(program());
    started.args(call).current_dir(&case.folder).stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::null());
    let mut live = Running(started.spawn().unwrap());
    let mut stream = answer(&listener, PATIENCE);
    let log = case.folder.join("logs/live.mcap");
    fly(&mut stream, &frames, SPEED, &log);
    // The recording's last sample, by the vehicle's time.
    let replayed = case.folder.join("replayed.mcap");
    case.prepare("replay flight.tlog --output-error off --out replayed.mcap");
    let expected = sampled(&replayed);
    let begun = Instant::now();
    while sampled(&log).len() < expected.len() {
        assert!(begun.elapsed() < PATIENCE, "{} of {} samples", sampled(&log).len(), expected.len());
        std::thread::sleep(Duration::from_millis(50));
    }
    let ended = Command::new("kill").args(["-TERM", &live.0.id().to_string()]).status().unwrap();
    assert!(ended.success());
    let mut printed = String::new();
    std::io::Read::read_to_string(live.0.stdout.as_mut().unwrap(), &mut printed).unwrap();
    let status = live.0.wait().unwrap().code().unwrap();
    case.title("sideslip live --source tcp://127.0.0.1:PORT --output-error off --root root --out logs --json answer.json");
    case.number("frames sent", frames.len());
    case.number("exit status", status);
    case.said("standard output", printed.as_bytes());
    case.json("answer.json");
    case.log("logs/live.mcap", Whole::Ends);
}

/// A recording at twice its pace.
pub(crate) fn file(case: &mut Case) {
    case.prepare(&format!("simulate --model {LINEAR} {FLIGHT} --out flight.csv"));
    let call = "live --source file://flight.csv --speed 2 --output-error off --root root --out logs --json answer.json";
    let args: Vec<&str> = call.split_whitespace().collect();
    let output = Command::new(program()).args(args).current_dir(&case.folder).stderr(Stdio::null()).output().unwrap();
    case.title(&format!("sideslip {call}"));
    case.number("exit status", output.status.code().unwrap());
    case.said("standard output", &output.stdout);
    case.json("answer.json");
    case.log("logs/flight.mcap", Whole::Ends);
}
