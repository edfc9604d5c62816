//! A process that logs at 256 Hz is killed at any time: all but the last 0.3 s comes back.
//!
//! The child is this test program itself. It prints what it has sent and when, by its own clock: a row counts as lost where the
//! child went on for 0.3 s after it, however late a busy machine let it send the row. `SIDESLIP_KILLS` sets how often (20).

use super::example::{Dice, folder, head, read, state};
use sideslip::flight::sample::Sample;
use sideslip::io::outputs::log::log_thread::LogThread;
use sideslip::io::outputs::log::mcap_log::McapLog;
use sideslip::io::outputs::queue::{QueuePolicy, queue};
use std::fs::File;
use std::io::{Read, Write};
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

const CHILD: &str = "SIDESLIP_LOG_OF_CHILD";
const HZ: f64 = 256.0;

/// Not a test of its own: what the child does.
#[test]
#[ignore = "run by the test that kills it"]
fn logs_until_killed() {
    let Some(path) = std::env::var_os(CHILD) else { return };
    let log = McapLog::create(Path::new(&path), head(), Box::new(|line| panic!("{line}"))).unwrap();
    let (mut sender, receiver) = queue(QueuePolicy::RealTime, 4096, 2);
    let thread = LogThread::spawn(receiver, log).unwrap();
    let started = Instant::now();
    for k in 0..20_000_u32 {
        let time_s = f64::from(k) / HZ;
        std::thread::sleep(Duration::from_secs_f64(time_s).saturating_sub(started.elapsed()));
        sender.send_sample(&Sample::new(time_s), &[f64::from(k), f64::NAN]);
        sender.send(&state(time_s));
        // Past the test harness, which keeps what is printed.
        writeln!(std::io::stdout().lock(), "sent {k} at {}", started.elapsed().as_secs_f64()).unwrap();
    }
    drop(sender);
    thread.join().unwrap();
}

#[test]
fn all_but_the_last_moment_survives_a_kill() {
    let _turn = crate::alone();
    let kills: usize = std::env::var("SIDESLIP_KILLS").ok().and_then(|text| text.parse().ok()).unwrap_or(20);
    let folder = folder("killed");
    let mut dice = Dice(20);
    let mut worst_s: f64 = 0.0;
    for kill in 0..kills {
        let path = folder.join(format!("{kill}.mcap"));
        let mut child = Command::new(std::env::current_exe().unwrap())
            .args(["conformance::killed::logs_until_killed", "--exact", "--ignored", "--nocapture"])
            .env(CHILD, &path)
            .stdout(Stdio::piped())
            .spawn()
            .unwrap();
        std::thread::sleep(Duration::from_micros(50_000 + dice.bits() % 1_200_000));
        child.kill().unwrap();
        child.wait().unwrap();
        let mut said = String::new();
        child.stdout.take().unwrap().read_to_string(&mut said).unwrap();
        // The last line may be cut.
        let whole = said.rsplit_once('\n').map_or("", |(whole, _)| whole);
        let sent_s: Vec<f64> = whole
            .lines()
            .filter(|line| line.contains("sent "))
            .map(|line| line.rsplit_once(" at ").unwrap().1.parse().unwrap())
            .collect();
        let found = match File::open(&path) {
            Ok(file) => read(file).map(|(rows, _)| rows).unwrap_or_default(),
            Err(_) => Vec::new(),
        };
        for (k, (sample, unknown)) in found.iter().enumerate() {
            assert_eq!((sample.time_s * HZ, unknown[0]), (k as f64, k as f64), "no hole");
        }
        let first_missing_s = sent_s.get(found.len()).copied();
        let missing_s = first_missing_s.map_or(0.0, |from_s| sent_s[sent_s.len() - 1] - from_s);
        worst_s = worst_s.max(missing_s);
        assert!(missing_s <= 0.3, "kill {kill}: sent {}, came back {}", sent_s.len(), found.len());
    }
    eprintln!("{kills} kills: at most {worst_s:.3} s lost");
}
