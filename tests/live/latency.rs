//! Latency: from a sample on the bus to its estimate on the bus, beside two processes that only pass the payload on.
//!
//! Both are taken in the same run, one after the other; the stamps are those of the messages. It prints what it measured and
//! requires only that every sample has its estimate: a shared machine proves no deadline. Figures: run it in the release profile
//! with `--no-capture`. `SIDESLIP_LATENCY_S` sets how long (4 s).

use super::stage::{Running, stage};
use crate::support::patience::until;
use crate::support::program::path;
use sideslip::io::bus::payload::{Payload, SAMPLE, SamplePayload, StatePayload};
use sideslip::io::bus::service::{Bus, Publisher, Subscriber};
use sideslip::io::telemetry::recording::Recording;
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

const HZ: f64 = 256.0;
const ECHO: &str = "SIDESLIP_ECHO_ROOT";
/// The longest wait for the last estimate.
const LAST_ANSWER: Duration = Duration::from_secs(5);
/// As the estimator looks at the bus.
const LOOK: Duration = Duration::from_micros(100);

/// Not a test of its own: passes each sample on as a state, at once.
#[test]
#[ignore = "run by the test that measures"]
fn echoes() {
    let Some(root) = std::env::var_os(ECHO) else { return };
    let busy = std::env::var_os("SIDESLIP_ECHO_BUSY").is_some();
    let bus = Bus::enter(Path::new(&root)).unwrap();
    let (mut samples, mut states) = (bus.subscriber::<SamplePayload>().unwrap(), bus.publisher::<StatePayload>().unwrap());
    let begun = Instant::now();
    while begun.elapsed() < Duration::from_secs(120) && Path::new(&root).exists() {
        match samples.receive().unwrap() {
            Some(sample) => {
                states.publish(&StatePayload::default(), Some(sample.header.sampled_ns)).unwrap();
            }
            None if busy => std::hint::spin_loop(),
            None => std::thread::sleep(LOOK),
        }
    }
}

/// Publishes the recording's samples at 256 Hz for so long; latencies in us, sorted.
fn measure(
    publisher: &mut Publisher<SamplePayload>,
    states: &mut Subscriber<StatePayload>,
    seconds: f64,
    time_s: &mut f64,
    sample: &mut dyn FnMut() -> SamplePayload,
) -> Vec<f64> {
    while states.receive().unwrap().is_some() {}
    let mut latencies = Vec::new();
    let begun = Instant::now();
    for k in 0..(seconds * HZ) as u32 {
        std::thread::sleep(Duration::from_secs_f64(f64::from(k) / HZ).saturating_sub(begun.elapsed()));
        let mut payload = sample();
        *time_s += 1.0 / HZ;
        payload.header_mut().time_s = *time_s;
        publisher.publish(&payload, None).unwrap();
        while let Some(state) = states.receive().unwrap() {
            latencies.push((state.header.published_ns - state.header.sampled_ns) as f64 / 1e3);
        }
    }
    let (sent, begun) = ((seconds * HZ) as usize, Instant::now());
    // Where nobody has answered yet, nobody is there yet.
    let patience = if latencies.is_empty() { Duration::from_millis(50) } else { LAST_ANSWER };
    while latencies.len() < sent && begun.elapsed() < patience {
        match states.receive().unwrap() {
            Some(state) => latencies.push((state.header.published_ns - state.header.sampled_ns) as f64 / 1e3),
            None => std::thread::sleep(LOOK),
        }
    }
    latencies.sort_by(f64::total_cmp);
    latencies
}

fn percentiles(latencies: &[f64]) -> [f64; 3] {
    [0.5, 0.99, 0.999].map(|part| latencies[((latencies.len() - 1) as f64 * part).round() as usize])
}

#[test]
fn from_sample_to_estimate_beside_a_bare_echo() {
    let _turn = crate::alone();
    let seconds: f64 = std::env::var("SIDESLIP_LATENCY_S").ok().and_then(|text| text.parse().ok()).unwrap_or(4.0);
    let stage = stage("latency");
    let mut recording = Recording::open(&crate::support::program::puma()).unwrap();
    let mut rows = Vec::new();
    while let Some(row) = recording.next_row().unwrap() {
        rows.push(row.sample);
    }
    let mut next = rows.iter().cycle();
    let mut sample = move || SamplePayload::new(next.next().unwrap(), std::iter::empty(), SAMPLE);
    let mut answers = Vec::new();
    for (name, busy) in [("estimate", false), ("echo", false), ("echo, busy", true)] {
        let root = stage.join(name.replace(", ", "-"));
        let bus = Bus::enter(&root).unwrap();
        let mut states = bus.subscriber::<StatePayload>().unwrap();
        let mut publisher = bus.publisher::<SamplePayload>().unwrap();
        let mut echo = None;
        let _estimate = if name == "estimate" {
            Some(Running::start(&["estimate", "--root", path(&root), "--out", path(&stage.join("log.mcap"))]))
        } else {
            let mut command = Command::new(std::env::current_exe().unwrap());
            command.args(["live::latency::echoes", "--exact", "--ignored"]).env(ECHO, &root).stdout(Stdio::null());
            if busy {
                command.env("SIDESLIP_ECHO_BUSY", "1");
            }
            echo = Some(command.spawn().unwrap());
            None
        };
        let mut time_s = 0.0;
        until("an answer", || !measure(&mut publisher, &mut states, 0.1, &mut time_s, &mut sample).is_empty());
        measure(&mut publisher, &mut states, 1.5, &mut time_s, &mut sample);
        let latencies = measure(&mut publisher, &mut states, seconds, &mut time_s, &mut sample);
        if let Some(mut echo) = echo {
            echo.kill().unwrap();
            echo.wait().unwrap();
        }
        assert_eq!(latencies.len(), (seconds * HZ) as usize, "{name}: an estimate for every sample");
        answers.push((name, percentiles(&latencies)));
    }
    let [p50, p99, p999] = answers[0].1;
    eprintln!("sample on the bus to estimate on the bus, us: p50 {p50:.1}, p99 {p99:.1}, p99.9 {p999:.1}");
    for (name, bare) in &answers[1..] {
        let ratio = [p50 / bare[0], p99 / bare[1], p999 / bare[2]];
        eprintln!(
            "{name}: p50 {:.1}, p99 {:.1}, p99.9 {:.1}; estimate is {:.2}, {:.2}, {:.2} times that",
            bare[0], bare[1], bare[2], ratio[0], ratio[1], ratio[2]
        );
    }
}
