//! The program itself, replaying at real time into a log, is killed: the log is in its place and all but the last 0.3 s is in it.

use super::example::{Dice, folder, read};
use std::fs::File;
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

/// How much later than its start the program may begin to play, s: reading the preamble, making the log.
const START_S: f64 = 0.5;

#[test]
fn a_replay_that_is_killed_leaves_its_log_in_its_place() {
    let _turn = crate::alone();
    let kills: u64 = std::env::var("SIDESLIP_KILLS").ok().and_then(|text| text.parse().ok()).unwrap_or(5);
    let folder = folder("killed_program");
    let recording = Path::new(env!("CARGO_MANIFEST_DIR")).join("replay/recordings/puma-100kn-pedal-3211.csv");
    let mut dice = Dice(21);
    for kill in 0..kills {
        let log = folder.join(format!("{kill}.mcap"));
        let started = Instant::now();
        let mut child = Command::new(env!("CARGO_BIN_EXE_sideslip"))
            .args(["replay".as_ref(), recording.as_os_str(), "--speed".as_ref(), "1".as_ref(), "--out".as_ref(), log.as_os_str()])
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .spawn()
            .unwrap();
        std::thread::sleep(Duration::from_millis(700 + dice.bits() % 1500));
        child.kill().unwrap();
        let ran_s = started.elapsed().as_secs_f64();
        child.wait().unwrap();
        let (rows, _) = read(File::open(&log).expect("the log is in its place")).unwrap();
        let last_s = rows.last().map_or(0.0, |(sample, _)| sample.time_s);
        assert!(last_s > ran_s - 0.3 - START_S, "kill {kill}: ran {ran_s:.2} s, the log ends at {last_s:.2} s");
        assert!(rows.windows(2).all(|pair| pair[1].0.time_s > pair[0].0.time_s));
    }
}
