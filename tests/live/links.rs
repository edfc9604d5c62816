//! MAVLink over the loopback into the processes: derivatives from a sender that is not ours, boots, silence, broken links.

use super::sender::{Vehicle, samples};
use super::stage::{Running, left_behind, signal, stage, times};
use crate::support::patience::until;
use crate::support::program::{ended, folder, own, path, puma, sideslip};
use mavlink::dialects::ardupilotmega::{GLOBAL_POSITION_INT_DATA, HEARTBEAT_DATA, MavMessage};
use serde_json::Value;
use sideslip::flight::channel::ControlNames;
use sideslip::flight::derivative::{Axis, Variable};
use sideslip::flight::file::model_file::ModelFile;
use sideslip::flight::sample::Sample;
use sideslip::io::bus::reader::Reader;
use sideslip::io::telemetry::mavlink::encode::{Encoder, Frames, ME};
use sideslip::io::telemetry::mavlink::mapping::MavlinkConfig;
use sideslip::realtime::regression::record::Status;
use std::io::Write;
use std::net::UdpSocket;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

/// An estimate is fresh up to this age.
const FRESH: Duration = Duration::from_millis(200);

/// A folder that holds pymavlink; `None`, said loudly, where it cannot be installed.
pub(crate) fn pymavlink() -> Option<PathBuf> {
    let place = Path::new(env!("CARGO_TARGET_TMPDIR")).join("pymavlink");
    let there = || {
        let import = ["-c", "from pymavlink.dialects.v20 import ardupilotmega"];
        let tried = Command::new("python3").args(import).env("PYTHONPATH", &place).stderr(Stdio::null()).status();
        tried.is_ok_and(|status| status.success())
    };
    if !there() {
        // Without what it needs for other things than messages.
        let install = ["-m", "pip", "install", "--quiet", "--no-deps", "--target", path(&place), "pymavlink==2.4.50"];
        let _ = Command::new("python3").args(install).stdout(Stdio::null()).stderr(Stdio::null()).status();
    }
    let found = there();
    if !found {
        eprintln!("SKIPPED: pymavlink cannot be installed by pip");
    }
    found.then_some(place)
}

#[test]
fn pymavlink_at_50_hz_over_udp_gives_the_derivatives_of_the_simulated_truth() {
    let _turn = crate::alone();
    let Some(pymavlink) = pymavlink() else { return };
    let stage = stage("pymavlink");
    let (flight, json, root, logs) = (stage.join("flight.csv"), stage.join("live.json"), stage.join("root"), stage.join("logs"));
    let model = own("replay/models/puma-like.toml");
    let simulate = ["simulate", "--model", path(&model), "--rate", "50", "--noise", "flight", "--seed", "7", "--duration", "24"];
    let inputs = ["--input", "pedal:3211:0.02:0.7", "--input", "lat_cyclic:3211:0.008:0.5:9", "--out", path(&flight)];
    let (status, _, said) = ended(&sideslip(&[simulate.as_slice(), &inputs].concat()));
    assert_eq!(status, 0, "{said}");
    // A port that is free now; nothing else on this machine asks for it in the moment until it is taken.
    let port = UdpSocket::bind("127.0.0.1:0").unwrap().local_addr().unwrap().port().to_string();
    let source = format!("udpin://127.0.0.1:{port}");
    let call = ["live", "--source", &source, "--root", path(&root), "--out", path(&logs), "--json", path(&json)];
    let mut live = Running::start(&call);
    until("it listens", || live.said().iter().any(|(_, line)| line.contains("listening")));
    let mut sender = Command::new("python3");
    sender.arg(own("tests/live/sender.py")).args([path(&flight), "127.0.0.1", &port]).env("PYTHONPATH", &pymavlink);
    let sent = sender.output().unwrap();
    assert!(sent.status.success(), "{}", String::from_utf8_lossy(&sent.stderr));
    let rows: usize = String::from_utf8(sent.stdout).unwrap().trim().parse().unwrap();
    std::thread::sleep(Duration::from_millis(300));
    assert!(signal("TERM", live.number()));
    assert_eq!(live.ended(), 0, "{:?}", live.said());
    assert_eq!(times(&logs.join("live.mcap")).len(), rows, "every instant is one sample");
    let answer: Value = serde_json::from_str(&std::fs::read_to_string(&json).unwrap()).unwrap();
    let truth = ModelFile::parse(&std::fs::read_to_string(&model).unwrap()).unwrap().linear;
    for name in ["N_v", "N_p", "N_r", "N_pedal", "L_v", "L_p", "L_r", "L_lat_cyclic"] {
        let (axis, variable) = name.split_once('_').unwrap();
        let (axis, variable) = (Axis::from_name(axis).unwrap(), Variable::from_name(variable).unwrap());
        let terms = answer["runs"][0]["equations"][&name[..1]]["terms"].as_array().unwrap();
        let term = terms.iter().find(|term| term["name"] == name).unwrap_or_else(|| panic!("no {name}: {terms:?}"));
        let (value, std) = (term["value"].as_f64().unwrap(), term["std"].as_f64().unwrap());
        let errors = (value - truth.derivative(axis, variable)) / std;
        eprintln!("{name}: {value:.5} +- {std:.5}, {errors:+.1} standard errors from the truth");
        assert!(errors.abs() <= 3.0, "{name}");
    }
    assert_eq!(left_behind(&root), [""; 0]);
}

#[test]
fn telemetry_killed_on_a_link_loses_next_to_nothing_and_the_run_goes_on() {
    let _turn = crate::alone();
    let stage = stage("link-killed");
    let (root, logs) = (stage.join("root"), stage.join("logs"));
    let flight: Vec<_> = samples(&puma()).into_iter().take(900).collect();
    let mut vehicle = Vehicle::start(flight.clone(), 2.0);
    let mut live =
        Running::start(&["live", "--source", vehicle.url(), "--root", path(&root), "--out", path(&logs), "--set", "run=killed"]);
    // Each life is killed while it flies: once there is a new estimate, however long a busy machine took to start it.
    let mut killed = None;
    let mut newest_s = f64::NEG_INFINITY;
    for _ in 0..3 {
        until("a life of telemetry", || newest_ingest(&live).is_some_and(|number| Some(number) != killed));
        let mut reader = Reader::open(&root).unwrap();
        let time_s = |reader: &mut Reader| reader.latest().unwrap().map(|estimate| estimate.derivatives.time_s);
        until("new estimates", || time_s(&mut reader).is_some_and(|time_s| time_s > newest_s + 0.5));
        killed = newest_ingest(&live);
        assert!(signal("KILL", killed.unwrap()));
        // What the estimator still had of that life is not taken for the next one's.
        std::thread::sleep(Duration::from_millis(100));
        newest_s = time_s(&mut reader).unwrap();
    }
    assert_eq!(vehicle.flown(), flight.len());
    std::thread::sleep(Duration::from_millis(300));
    assert!(signal("TERM", live.number()));
    assert_eq!(live.ended(), 3, "{:?}", live.said());
    assert!(live.said().iter().any(|(_, line)| line.contains("telemetry began again; the run goes on")), "{:?}", live.said());
    let logged = times(&logs.join("live.mcap"));
    assert!(!logs.join("live-2.mcap").exists(), "one run, one log");
    // Each time what waited for late messages, 20 ms, is gone with its process, and nothing that came while it was away.
    let longest_s = logged.windows(2).map(|pair| pair[1] - pair[0]).fold(0.0, f64::max);
    eprintln!("{} of {} samples in the log, the longest gap {longest_s:.3} s", logged.len(), flight.len());
    assert!(longest_s <= 0.3 && logged.len() + 30 >= flight.len(), "{longest_s}");
    assert_eq!(left_behind(&root), [""; 0]);
}

#[test]
fn a_vehicle_that_starts_again_begins_a_run_and_a_log_of_its_own() {
    let _turn = crate::alone();
    let stage = stage("boots");
    let (root, logs, json) = (stage.join("root"), stage.join("logs"), stage.join("live.json"));
    let first: Vec<_> = samples(&puma())
        .into_iter()
        .take(200)
        .map(|mut sample| {
            sample.time_s += 600.0;
            sample
        })
        .collect();
    let flight: Vec<_> = first.iter().copied().chain(samples(&puma()).into_iter().take(300)).collect();
    let mut vehicle = Vehicle::start(flight, 10.0);
    let args = ["live", "--source", vehicle.url(), "--root", path(&root), "--out", path(&logs), "--json", path(&json)];
    let mut live = Running::start(&args);
    vehicle.flown();
    std::thread::sleep(Duration::from_millis(500));
    // A reader sees the second run.
    let mut reader = Reader::open(&root).unwrap();
    let _ = reader.latest().unwrap();
    assert!(signal("TERM", live.number()));
    live.ended();
    assert!(live.said().iter().any(|(_, line)| line.contains("started again: a new run")), "{:?}", live.said());
    let (one, two) = (times(&logs.join("live.mcap")), times(&logs.join("live-2.mcap")));
    assert_eq!((one.len(), one.first()), (200, Some(&600.0)));
    // Its first messages could be strays of the old clock, and are not used.
    assert!(two.len() >= 285 && two[0] > *one.last().unwrap(), "{} {:?}", two.len(), two.first());
    let answer: Value = serde_json::from_str(&std::fs::read_to_string(&json).unwrap()).unwrap();
    assert_eq!(answer["runs"].as_array().unwrap().len(), 2);
    drop(reader);
}

#[test]
fn what_cannot_be_opened_or_understood_is_said() {
    let _turn = crate::alone();
    let folder = folder("live-wrong-links");
    let root = folder.join("root");
    let taken = UdpSocket::bind("127.0.0.1:0").unwrap();
    let source = format!("udpin://{}", taken.local_addr().unwrap());
    let (status, _, said) = ended(&sideslip(&["live", "--source", &source, "--root", path(&root)]));
    assert!(status == 1 && said.contains(&source) && said.contains("in use"), "{status} {said}");
    for (wrong, words) in
        [("udpin://127.0.0.1", "host:port"), ("serial://", "serial://DEVICE"), ("http://x:1", "udpin://HOST:PORT")]
    {
        let (status, _, said) = ended(&sideslip(&["ingest", "--source", wrong, "--root", path(&root)]));
        assert!(status == 2 && said.contains(words), "{wrong}: {said}");
        let (status, _, said) = ended(&sideslip(&["live", "--source", wrong, "--root", path(&root)]));
        assert!(status == 2 && said.contains(words), "{wrong}: {said}");
    }
    let config = folder.join("mavlink.toml");
    std::fs::write(&config, "system = 300").unwrap();
    let call = ["ingest", "--source", "udpin://127.0.0.1:0", "--config", path(&config), "--root", path(&root)];
    let (status, _, said) = ended(&sideslip(&call));
    assert!(status == 2 && said.contains("mavlink.toml:1:10"), "{said}");
}

#[test]
fn a_connection_that_breaks_is_opened_again_and_noise_is_counted() {
    let _turn = crate::alone();
    let stage = stage("tcp");
    let (root, log) = (stage.join("root"), stage.join("flight.mcap"));
    let server = std::net::TcpListener::bind("127.0.0.1:0").unwrap();
    let source = format!("tcp://{}", server.local_addr().unwrap());
    let mut estimate = Running::start(&["estimate", "--root", path(&root), "--out", path(&log)]);
    until("an estimator", || root.join(".sideslip/estimator").exists());
    let mut ingest = Running::start(&["ingest", "--source", &source, "--root", path(&root)]);
    let flight = samples(&puma());
    let mut encoder = Encoder::new(ME, MavlinkConfig::default(), ControlNames::Rotorcraft);
    for half in flight.chunks(flight.len() / 2 + 1) {
        let (mut connection, _) = server.accept().unwrap();
        connection.write_all(b"no frame").unwrap();
        // Some twenty times as fast as it was flown: what comes all at once is more than a log takes.
        for some in half.chunks(20) {
            let mut bytes = Vec::new();
            some.iter().for_each(|sample| encoder.sample(sample, |frame| bytes.extend(frame)).unwrap());
            connection.write_all(&bytes).unwrap();
            std::thread::sleep(Duration::from_millis(20));
        }
        // The other end has read it all before this one goes.
        std::thread::sleep(Duration::from_millis(500));
    }
    until("said that it is open again", || ingest.said().iter().any(|(_, line)| line.contains("open again")));
    assert!(signal("TERM", ingest.number()));
    assert_eq!(ingest.ended(), 3, "{:?}", ingest.said());
    assert!(ingest.said().iter().any(|(_, line)| line.contains("16 bytes that belong to no frame")), "{:?}", ingest.said());
    assert!(signal("TERM", estimate.number()));
    assert_eq!(estimate.ended(), 0, "{:?}", estimate.said());
    assert_eq!(times(&log).len(), flight.len(), "both connections, one run");
}

/// The newest `ingest` of a supervisor.
fn newest_ingest(live: &Running) -> Option<u32> {
    let mark = "sideslip: ingest is process ";
    let number = |(_, line): &(_, String)| line.strip_prefix(mark).and_then(|number| number.parse().ok());
    live.said().iter().filter_map(number).next_back()
}

#[test]
fn what_waited_in_the_socket_while_telemetry_was_paused_is_not_taken_for_new() {
    let _turn = crate::alone();
    let stage = stage("paused");
    let root = stage.join("root");
    let vehicle = Vehicle::start(samples(&puma()), 1.0);
    let mut estimate = Running::start(&["estimate", "--root", path(&root)]);
    until("an estimator", || root.join(".sideslip/estimator").exists());
    let mut ingest = Running::start(&["ingest", "--source", vehicle.url(), "--root", path(&root)]);
    let mut reader = Reader::open(&root).unwrap();
    until("an estimate", || reader.latest().unwrap().is_some());
    // Now less age less the sample's own time is the same for every sample, if ages are true. Where this thread was held up
    // between the clock's readings, the origin lies between two values.
    let begun = Instant::now();
    let mut origin_s = |paused: bool| {
        let early_s = begun.elapsed().as_secs_f64();
        let estimate = reader.latest().unwrap().unwrap();
        assert!(!paused || estimate.age < FRESH || estimate.status == Status::Stale);
        let of = |now_s: f64| now_s - estimate.age.as_secs_f64() - estimate.derivatives.time_s;
        ([of(early_s), of(begun.elapsed().as_secs_f64())], estimate.age)
    };
    std::thread::sleep(Duration::from_secs(2));
    until("a fresh estimate", || origin_s(false).1 < FRESH);
    let ([before_s, _], _) = origin_s(false);
    assert!(signal("STOP", ingest.number()));
    std::thread::sleep(Duration::from_secs(2));
    assert!(signal("CONT", ingest.number()));
    let mut worst_s = 0.0_f64;
    let since = Instant::now();
    while since.elapsed() < Duration::from_secs(1) {
        let ([from_s, to_s], _) = origin_s(true);
        worst_s = worst_s.max(from_s - before_s).max(before_s - to_s);
    }
    until("a fresh estimate again", || origin_s(false).1 < FRESH);
    eprintln!("ages after a pause of 2 s are true within {worst_s:.4} s");
    assert!(worst_s < 0.1, "{worst_s}");
    assert!(ingest.said().iter().all(|(_, line)| !line.contains("nothing has come")), "{:?}", ingest.said());
    for process in [&mut ingest, &mut estimate] {
        assert!(signal("TERM", process.number()));
        process.ended();
    }
    drop(vehicle);
}

#[test]
fn telemetry_killed_after_the_vehicle_has_started_again_goes_on_with_the_second_run() {
    let _turn = crate::alone();
    let stage = stage("boots-killed");
    let (root, logs) = (stage.join("root"), stage.join("logs"));
    let late = |mut sample: Sample| {
        sample.time_s += 600.0;
        sample
    };
    let first: Vec<_> = samples(&puma()).into_iter().take(200).map(late).collect();
    let flight: Vec<_> = first.into_iter().chain(samples(&puma())).collect();
    let mut vehicle = Vehicle::start(flight, 4.0);
    let mut live = Running::start(&["live", "--source", vehicle.url(), "--root", path(&root), "--out", path(&logs)]);
    until("a second run", || live.said().iter().any(|(_, line)| line.contains("started again: a new run")));
    std::thread::sleep(Duration::from_millis(500));
    assert!(signal("KILL", newest_ingest(&live).unwrap()));
    vehicle.flown();
    std::thread::sleep(Duration::from_millis(300));
    assert!(signal("TERM", live.number()));
    live.ended();
    assert!(live.said().iter().any(|(_, line)| line.contains("telemetry began again; the run goes on")), "{:?}", live.said());
    assert!(!logs.join("live-3.mcap").exists(), "two boots, two logs: {:?}", live.said());
    let (one, two) = (times(&logs.join("live.mcap")), times(&logs.join("live-2.mcap")));
    let gap_s = two.windows(2).map(|pair| pair[1] - pair[0]).fold(0.0, f64::max);
    assert!(one.len() == 200 && two.len() + 10 >= samples(&puma()).len() && gap_s <= 0.3, "{} {} {gap_s}", one.len(), two.len());
}

#[test]
fn messages_without_motion_are_named_and_a_connection_refused_at_first_is_tried_again() {
    let _turn = crate::alone();
    let stage = stage("wordless");
    let root = stage.join("root");
    let server = std::net::TcpListener::bind("127.0.0.1:0").unwrap();
    let address = server.local_addr().unwrap();
    drop(server);
    let mut ingest = Running::start(&["ingest", "--source", &format!("tcp://{address}"), "--root", path(&root)]);
    let said = |ingest: &Running, word: &str| ingest.said().iter().any(|(_, line)| line.contains(word));
    until("refused", || said(&ingest, "refused"));
    let server = std::net::TcpListener::bind(address).unwrap();
    let (mut connection, _) = server.accept().unwrap();
    let mut frames = Frames::new(ME);
    until("said what is needed", || {
        let heartbeat = MavMessage::HEARTBEAT(HEARTBEAT_DATA::default());
        let position = MavMessage::GLOBAL_POSITION_INT(GLOBAL_POSITION_INT_DATA::default());
        let bytes: Vec<u8> = [heartbeat, position].iter().flat_map(|message| frames.frame(message).to_vec()).collect();
        connection.write_all(&bytes).unwrap();
        std::thread::sleep(Duration::from_millis(50));
        said(&ingest, "ATTITUDE_QUATERNION")
    });
    assert!(said(&ingest, "GLOBAL_POSITION_INT of 1/1"), "{:?}", ingest.said());
    assert!(signal("TERM", ingest.number()));
    assert_eq!(ingest.ended(), 3, "{:?}", ingest.said());
    assert!(said(&ingest, "0 samples"), "{:?}", ingest.said());
}
