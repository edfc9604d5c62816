//! Telemetry and estimator are killed at random, in the first 20 ms of their lives too: they come back, and the log is whole.
//!
//! `SIDESLIP_KILLS` sets how often (10). How soon they are back is printed, and held to 2 s only where `SIDESLIP_KILLS` is set: a
//! figure of a quiet machine, which a busy one does not disprove.

use super::sender::{Vehicle, samples};
use super::stage::{Running, left_behind, signal, stage, times};
use crate::support::asked::number;
use crate::support::patience::{PATIENCE, until};
use crate::support::program::{ended, own, path, sideslip};
use sideslip::io::bus::clock::monotonic_ns;
use sideslip::io::bus::reader::{Reader, VALID_FOR};
use sideslip::realtime::regression::record::Status;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

/// Back and estimating within, on a quiet machine.
const BACK: Duration = Duration::from_secs(2);
/// The log may lack so much, s.
const LOST_S: f64 = 0.3;

/// Numbers that look random, the same each time (xorshift64*).
struct Dice(u64);

impl Dice {
    fn below(&mut self, limit: u64) -> u64 {
        self.0 ^= self.0 >> 12;
        self.0 ^= self.0 << 25;
        self.0 ^= self.0 >> 27;
        self.0.wrapping_mul(0x2545_F491_4F6C_DD1D) % limit
    }
}

/// The newest process of that name, and when it was started.
fn newest(live: &Running, name: &str) -> (u32, Instant) {
    let mark = format!("sideslip: {name} is process ");
    let of = |(when, line): &(Instant, String)| Some((line.strip_prefix(&mark)?.parse().ok()?, *when));
    live.said().iter().filter_map(of).next_back().unwrap()
}

/// Waits for an estimate that rests on a sample from after `since_ns`: how long that took, and whether the estimate was stale
/// meanwhile, or the time between two looks so long that it may have been.
fn back(reader: &mut Reader, since_ns: u64) -> (Duration, bool) {
    let begun = Instant::now();
    let (mut stale, mut last_look) = (false, begun);
    loop {
        stale |= last_look.elapsed() > Duration::from_millis(20);
        last_look = Instant::now();
        if let Some(estimate) = reader.latest().unwrap() {
            let old = estimate.age > VALID_FOR;
            assert!(!old || estimate.status == Status::Stale, "an old estimate is stale whatever it says");
            stale |= estimate.status == Status::Stale;
            let sampled_ns = monotonic_ns() - u64::try_from(estimate.age.as_nanos()).unwrap();
            if sampled_ns > since_ns + 1_000_000 && !old {
                return (begun.elapsed(), stale);
            }
        }
        assert!(begun.elapsed() < PATIENCE, "not back within {PATIENCE:?}");
        std::thread::sleep(Duration::from_millis(1));
    }
}

fn long_flight(folder: &Path, seconds: u64) -> PathBuf {
    let flight = folder.join("flight.csv");
    let model = own("replay/models/puma-like.toml");
    let duration = seconds.to_string();
    let args = ["simulate", "--model", path(&model), "--input", "pedal:3211:0.02:0.7", "--rate", "50", "--noise", "flight"];
    let (status, _, said) = ended(&sideslip(&[args.as_slice(), &["--duration", &duration, "--out", path(&flight)]].concat()));
    assert_eq!(status, 0, "{said}");
    flight
}

/// Every sample of all logs, in order, each once.
fn logged(logs: &Path) -> Vec<f64> {
    let files = std::fs::read_dir(logs).unwrap().flatten();
    let mut all: Vec<f64> = files.flat_map(|file| times(&file.path())).collect();
    all.sort_by(f64::total_cmp);
    all.dedup();
    all
}

#[test]
fn who_is_killed_comes_back_and_the_log_is_whole() {
    let _turn = crate::alone();
    let kills = number("SIDESLIP_KILLS").unwrap_or(10);
    let stage = stage("kills");
    let flight = long_flight(&stage, 30 + 2 * kills);
    let (root, logs) = (stage.join("root"), stage.join("logs"));
    let vehicle = Vehicle::start(samples(&flight), 1.0);
    let mut live = Running::start(&["live", "--source", vehicle.url(), "--root", path(&root), "--out", path(&logs)]);
    until("a root", || root.join(".sideslip/runs").exists());
    let mut reader = Reader::open(&root).unwrap();
    back(&mut reader, monotonic_ns());
    let mut dice = Dice(0x5EED_0001);
    let (mut worst, mut early) = ([Duration::ZERO; 2], 0);
    for kill in 0..kills {
        let which = usize::from(dice.below(2) > 0);
        let name = ["estimate", "ingest"][which];
        let (mut number, _) = newest(&live, name);
        let mut since_ns = monotonic_ns();
        assert!(signal("KILL", number), "kill {kill}: {name} was not running");
        // Every other time its successor is killed too, in the first 20 ms of its life, up to three times.
        for _ in 0..(kill % 2) * (1 + dice.below(3)) {
            let mut next = newest(&live, name);
            until("started again", || {
                next = newest(&live, name);
                next.0 != number && signal("0", next.0)
            });
            let at = Duration::from_micros(dice.below(20_000));
            std::thread::sleep(at.saturating_sub(next.1.elapsed()));
            since_ns = monotonic_ns();
            early += u64::from(signal("KILL", next.0));
            number = next.0;
        }
        let (took, stale) = back(&mut reader, since_ns);
        assert!(stale || took <= VALID_FOR + Duration::from_millis(50), "kill {kill}: away for {took:?}, never stale");
        worst[which] = worst[which].max(took);
        std::thread::sleep(Duration::from_millis(100 + dice.below(400)));
    }
    drop(reader);
    assert!(signal("TERM", live.number()));
    assert_eq!(live.ended(), 3, "data were lost: {:?}", live.said());
    assert_eq!(left_behind(&root), [""; 0]);
    let found = logged(&logs);
    let all = times(&flight);
    let lost_s = found.windows(2).map(|pair| pair[1] - pair[0]).fold(0.0, f64::max) - 0.02;
    eprintln!(
        "{kills} kills and {early} in the first 20 ms of a life: back within {:?} (estimator), {:?} (telemetry); the logs lack at \
         most {lost_s:.3} s",
        worst[0], worst[1]
    );
    assert!(lost_s <= LOST_S, "{lost_s}");
    assert!(std::env::var_os("SIDESLIP_KILLS").is_none() || worst.iter().all(|&took| took <= BACK), "{worst:?}");
    assert_eq!(found.first(), all.first(), "from the first sample on");
}

#[test]
fn everybody_killed_at_once_leaves_nothing_that_blocks_the_next_start() {
    let _turn = crate::alone();
    let stage = stage("all-killed");
    let flight = long_flight(&stage, 60);
    let (root, source) = (stage.join("root"), format!("file://{}", flight.display()));
    let mut dice = Dice(0x5EED_0002);
    let rounds: u64 = std::env::var("SIDESLIP_KILLS").ok().and_then(|text| text.parse().ok()).unwrap_or(10);
    for round in 0..rounds {
        let mut estimate = Running::start(&["estimate", "--root", path(&root)]);
        let mut ingest = Running::start(&["ingest", "--source", &source, "--root", path(&root)]);
        std::thread::sleep(Duration::from_micros(dice.below(if round % 2 == 0 { 20_000 } else { 80_000 })));
        estimate.kill();
        ingest.kill();
    }
    let mut estimate = Running::start(&["estimate", "--root", path(&root)]);
    let mut ingest = Running::start(&["ingest", "--source", &source, "--root", path(&root)]);
    until("a root", || root.join(".sideslip/runs").exists());
    let mut reader = Reader::open(&root).unwrap();
    back(&mut reader, monotonic_ns());
    for process in [&mut ingest, &mut estimate] {
        assert!(signal("TERM", process.number()));
        process.ended();
    }
    drop(reader);
    assert_eq!(left_behind(&root), [""; 0]);
}

#[test]
fn of_two_alone_the_one_killed_is_missed_and_the_other_goes_on() {
    let _turn = crate::alone();
    let stage = stage("alone");
    let flight = long_flight(&stage, 60);
    let (root, log) = (stage.join("root"), stage.join("flight.mcap"));
    let call = ["estimate", "--root", path(&root), "--out", path(&log)];
    let source = format!("file://{}", flight.display());
    let mut ingest = Running::start(&["ingest", "--source", &source, "--root", path(&root)]);
    let mut estimate = Running::start(&call);
    until("a root", || root.join(".sideslip/runs").exists());
    let mut reader = Reader::open(&root).unwrap();
    back(&mut reader, monotonic_ns());
    std::thread::sleep(Duration::from_millis(300));
    let life = reader.latest().unwrap().unwrap().incarnation;
    estimate.kill();
    std::thread::sleep(VALID_FOR + Duration::from_millis(50));
    assert_eq!(reader.latest().unwrap().unwrap().status, Status::Stale);
    let mut estimate = Running::start(&call);
    back(&mut reader, monotonic_ns());
    let estimate_of_second = reader.latest().unwrap().unwrap();
    assert!(estimate_of_second.incarnation > life);
    ingest.kill();
    std::thread::sleep(VALID_FOR + Duration::from_millis(50));
    assert_eq!(reader.latest().unwrap().unwrap().status, Status::Stale, "an estimator without telemetry has nothing new");
    assert!(signal("TERM", estimate.number()));
    estimate.ended();
    let (first, second) = (times(&log), times(&stage.join("flight-2.mcap")));
    let seam = first.last().unwrap() - second.first().unwrap();
    assert!(seam > -LOST_S, "between the logs {seam} s are missing");
}
