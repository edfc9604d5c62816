//! Real tlogs, read in place: the same messages as pymavlink 2.4.50 finds, sender by sender, boots apart.
//!
//! In the plane's log pymavlink finds 32,076 messages and calls 13 bytes bad; those belong to two frames with right
//! checksums (a HEARTBEAT and a COMMAND_LONG of sender 254/0), which a byte-by-byte search finds too: 32,078.

use sideslip::io::telemetry::mavlink::packet::FrameTally;
use sideslip::io::telemetry::mavlink::senders::Sender;
use sideslip::io::telemetry::recording::Recording;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// A real tlog; `None`, said loudly, where it is absent.
fn tlog(name: &str) -> Option<PathBuf> {
    let default = || Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared/data");
    let file = std::env::var_os("SIDESLIP_DATA").map_or_else(default, PathBuf::from).join("mavlink").join(name);
    if !file.is_file() {
        use std::io::Write;
        let _ = writeln!(std::io::stderr(), "SKIPPED: no recording {}", file.display());
        return None;
    }
    Some(file)
}

/// Totals by sender; how often some messages of the vehicle came; frames and damage; boots; times of the samples.
struct Found {
    by_sender: Vec<((u8, u8), u64)>,
    vehicle: BTreeMap<String, u64>,
    tally: FrameTally,
    boots: u32,
    times_s: Vec<f64>,
}

fn read(file: &Path) -> Found {
    let mut recording = Recording::open(file).unwrap();
    let mut times_s = Vec::new();
    while let Some(row) = recording.next_row().unwrap() {
        times_s.push(row.sample.time_s);
    }
    let traffic = recording.traffic().unwrap();
    let ids = |Sender { system, component }| (system, component);
    Found {
        by_sender: traffic.senders.iter().map(|(sender, tally)| (ids(sender), tally.total())).collect(),
        vehicle: traffic.senders.of(traffic.vehicle).unwrap().by_name(),
        tally: traffic.tally,
        boots: traffic.boots,
        times_s,
    }
}

fn span_s(found: &Found) -> f64 {
    assert!(found.times_s.is_sorted_by(|a, b| a < b), "the time of the samples goes back or stands");
    found.times_s.last().unwrap() - found.times_s.first().unwrap()
}

#[test]
fn a_plane_with_two_ground_stations() {
    let Some(file) = tlog("plane-canberra.tlog") else { return };
    let found = read(&file);
    assert_eq!(found.by_sender, [((2, 1), 31_490), ((254, 0), 582), ((255, 0), 6)]);
    assert_eq!(found.tally, FrameTally { good: 32_078, ..FrameTally::default() });
    for (name, count) in [("RAW_IMU", 572), ("SCALED_IMU3", 571), ("ATTITUDE", 1088), ("RPM", 150), ("AIRSPEED_AUTOCAL", 48)] {
        assert_eq!(found.vehicle[name], count, "{name}");
    }
    // The stamps of the log cover 128 s, the vehicle's own clock 589 s.
    assert!((span_s(&found) - 589.07).abs() < 0.1, "{}", span_s(&found));
    assert_eq!(found.boots, 1);
}

#[test]
fn a_quadcopter_that_booted_twice_with_bad_frames_between() {
    let Some(file) = tlog("quad-dronekit-v1.tlog") else { return };
    let found = read(&file);
    assert_eq!(found.by_sender, [((1, 1), 70_977), ((51, 68), 2740), ((255, 0), 1760)]);
    assert_eq!((found.tally.good, found.tally.bad_checksum, found.tally.unknown), (75_477, 1314, 0));
    for (name, count) in [("RAW_IMU", 2856), ("RC_CHANNELS_RAW", 2831), ("TERRAIN_REPORT", 2675), ("COMMAND_ACK", 2)] {
        assert_eq!(found.vehicle[name], count, "{name}");
    }
    assert_eq!(found.boots, 2);
    // The second boot stands behind the first one by the host's clock: 17.5 s without a sample.
    let longest = found.times_s.windows(2).map(|pair| pair[1] - pair[0]).fold(0.0, f64::max);
    assert!((longest - 17.5).abs() < 0.5, "{longest}");
    span_s(&found);
}

#[test]
fn a_submarine_and_a_vtol() {
    if let Some(file) = tlog("sub-v2.tlog") {
        let found = read(&file);
        assert_eq!(found.by_sender, [((1, 1), 1136), ((255, 230), 290)]);
        assert_eq!((found.tally, found.boots), (FrameTally { good: 1426, ..FrameTally::default() }, 1));
        span_s(&found);
    }
    // One COMMAND_ACK holds a result that the dialect's enum lacks: it counts like the others.
    if let Some(file) = tlog("vtol-sitl-v1.tlog") {
        let found = read(&file);
        assert_eq!(found.by_sender, [((1, 1), 23_894)]);
        assert_eq!((found.tally, found.boots), (FrameTally { good: 23_894, ..FrameTally::default() }, 1));
        assert_eq!((found.vehicle["COMMAND_ACK"], found.vehicle["ATTITUDE"]), (6, 888));
        span_s(&found);
    }
}
