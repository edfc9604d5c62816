//! The program itself, replaying at real time into a log, is killed: the log is in its place and lacks nothing that it once held.
//!
//! How much of the last moment is lost is measured in `killed`, whose child reports what it has sent.

use super::example::{Dice, Row, folder, read};
use crate::support::patience::until;
use std::fs::File;
use std::path::Path;
use std::process::{Command, Stdio};

/// The rows that the log holds now.
fn rows_of(log: &Path) -> Vec<Row> {
    File::open(log).ok().and_then(read).map(|(rows, _)| rows).unwrap_or_default()
}

#[test]
fn a_replay_that_is_killed_leaves_its_log_in_its_place() {
    let _turn = crate::alone();
    let kills: u64 = std::env::var("SIDESLIP_KILLS").ok().and_then(|text| text.parse().ok()).unwrap_or(5);
    let folder = folder("killed_program");
    let recording = Path::new(env!("CARGO_MANIFEST_DIR")).join("replay/recordings/puma-100kn-pedal-3211.csv");
    let mut dice = Dice(21);
    for kill in 0..kills {
        let log = folder.join(format!("{kill}.mcap"));
        let mut child = Command::new(env!("CARGO_BIN_EXE_sideslip"))
            .args(["replay".as_ref(), recording.as_os_str(), "--speed".as_ref(), "1".as_ref(), "--out".as_ref(), log.as_os_str()])
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .spawn()
            .unwrap();
        let (enough, mut before) = (1 + dice.below(40), Vec::new());
        until("rows in the log", || {
            before = rows_of(&log);
            before.len() >= enough
        });
        child.kill().unwrap();
        child.wait().unwrap();
        let (after, _) = read(File::open(&log).expect("the log is in its place")).unwrap();
        assert!(after.len() >= before.len(), "kill {kill}: {} rows were logged, {} are left", before.len(), after.len());
        let times = |rows: &[Row]| rows.iter().map(|(sample, _)| sample.time_s).collect::<Vec<_>>();
        let (before, after) = (times(&before), times(&after));
        assert_eq!(after[..before.len()], before, "kill {kill}");
        assert!(after.windows(2).all(|pair| pair[1] > pair[0]));
    }
}
