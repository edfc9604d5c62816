//! The part with processes: a run that is stopped.

use crate::live::stage::times;
use crate::support::patience::until;
use crate::support::program::{ended, files_in, folder, path, puma, replayed};
use std::process::{Command, Stdio};

#[test]
fn a_signal_stops_a_run_with_its_log_closed_and_what_there_was_printed() {
    let _turn = crate::alone();
    for signal in ["INT", "TERM"] {
        let log = folder(&format!("replay-{signal}")).join("run.mcap");
        let child = Command::new(env!("CARGO_BIN_EXE_sideslip"))
            .args(["replay", path(&puma()), "--speed", "4", "--out", path(&log)])
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
        until("four seconds in the log", || times(&log).len() > 100);
        assert!(Command::new("kill").args([&format!("-{signal}"), &child.id().to_string()]).status().unwrap().success());
        let (status, table, said) = ended(&child.wait_with_output().unwrap());
        assert_eq!((status, said.lines().count()), (1, 1), "{said}");
        assert!(said.contains("stopped by a signal at "), "{said}");
        assert!(table.contains("Lateral modes at") && table.contains("log: "), "{table}");
        let (status, run, said) = replayed(&log, &[]);
        // Of the first seconds there is no derivative yet.
        assert!(matches!(status, 0 | 4) && !said.contains("truncated"), "the log has its end: {status} {said}");
        assert!((1.0..20.0).contains(&run["time"].as_f64().unwrap()), "{}", run["time"]);
        assert_eq!(files_in(log.parent().unwrap()), ["run.mcap"]);
    }
}
