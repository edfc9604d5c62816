//! MAVLink over the loopback whose airspeed and sideslip were stamped late, in datagrams that overtake each other and come twice:
//! with `latency_s` the derivatives are those of the flight without lateness.

use super::sender::samples;
use super::stage::{Running, left_behind, signal, stage};
use crate::support::patience::until;
use crate::support::program::{ended, path, sideslip};
use serde_json::Value;
use sideslip::flight::channel::{Channel, ControlNames};
use sideslip::flight::sample::Sample;
use sideslip::io::telemetry::mavlink::encode::{Encoder, ME};
use sideslip::io::telemetry::mavlink::mapping::MavlinkConfig;
use std::net::UdpSocket;
use std::path::Path;
use std::time::{Duration, Instant};

/// Late by so many samples, 10 ms each.
const LATE: [(Channel, usize); 2] = [(Channel::Tas, 25), (Channel::Beta, 10)];

/// The flight with the channels of [`LATE`] at the stamps of later samples.
fn late(flight: &[Sample]) -> Vec<Sample> {
    let at = |(k, sample): (usize, &Sample)| {
        let mut sample = *sample;
        for (channel, by) in LATE {
            sample.clear(channel);
            if let Some(value) = k.checked_sub(by).and_then(|before| flight[before].get(channel)) {
                sample.set(channel, value);
            }
        }
        sample
    };
    flight.iter().enumerate().map(at).collect()
}

/// The datagrams with their times, neighbours exchanged here and there, some sent again.
fn datagrams(flight: &[Sample]) -> Vec<(f64, Vec<u8>)> {
    let mut encoder = Encoder::new(ME, MavlinkConfig::default(), ControlNames::Rotorcraft);
    let mut all = Vec::new();
    for sample in flight {
        let after_s = sample.time_s - flight[0].time_s;
        encoder.sample(sample, |frame| all.push((after_s, frame.to_vec()))).unwrap();
    }
    let mut state = 7_u64;
    let mut random = || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        state >> 33
    };
    for k in (0..all.len() - 4).step_by(4) {
        if random() % 5 == 0 {
            let other = k + 1 + (random() % 3) as usize;
            let [one, two] = all.get_disjoint_mut([k, other]).unwrap();
            std::mem::swap(&mut one.1, &mut two.1);
        }
        if random() % 10 == 0 {
            let again = all[k].1.clone();
            all[k + 3].1.extend(again);
        }
    }
    all
}

fn equations(json: &Path) -> Value {
    let all: Value = serde_json::from_str(&std::fs::read_to_string(json).unwrap()).unwrap();
    all["runs"][0]["equations"].clone()
}

#[test]
fn late_channels_in_disordered_datagrams_give_the_derivatives_of_the_flight() {
    let _turn = crate::alone();
    let stage = stage("latencies");
    let [flight, replayed, json, root, logs] =
        ["flight.csv", "replayed.json", "live.json", "root", "logs"].map(|name| stage.join(name));
    let simulate = ["simulate", "--model", "puma", "--rate", "100", "--noise", "--seed", "7", "--duration", "22"];
    let inputs = ["--input", "pedal:3211:0.02:0.7", "--input", "lat_cyclic:3211:0.008:0.5:7", "--out", path(&flight)];
    let (status, _, said) = ended(&sideslip(&[simulate.as_slice(), &inputs].concat()));
    assert_eq!(status, 0, "{said}");
    assert_eq!(ended(&sideslip(&["replay", path(&flight), "--json", path(&replayed)])).0, 0);

    let port = UdpSocket::bind("127.0.0.1:0").unwrap().local_addr().unwrap().port();
    let source = format!("udpin://127.0.0.1:{port}");
    let set = "latency_s={ tas = 0.25, beta = 0.1 }";
    let call = ["live", "--source", &source, "--root", path(&root), "--out", path(&logs), "--json", path(&json), "--set", set];
    let mut live = Running::start(&call);
    until("it listens", || live.said().iter().any(|(_, line)| line.contains("listening")));
    let sender = UdpSocket::bind("127.0.0.1:0").unwrap();
    let begun = Instant::now();
    for (due_s, bytes) in datagrams(&late(&samples(&flight))) {
        std::thread::sleep(Duration::from_secs_f64(due_s).saturating_sub(begun.elapsed()));
        sender.send_to(&bytes, ("127.0.0.1", port)).unwrap();
    }
    std::thread::sleep(Duration::from_millis(500));
    assert!(signal("TERM", live.number()));
    let status = live.ended();
    let said: Vec<String> = live.said().into_iter().map(|(_, line)| line).collect();
    assert!([0, 3].contains(&status), "{said:?}");
    assert!(
        said.iter().any(|line| line.contains("rows wait 0.25 s and to the next row") && line.contains("tas 0.25 s, beta 0.1 s"))
    );
    assert_eq!(left_behind(&root), [""; 0]);

    let (wanted, found) = (equations(&replayed), equations(&json));
    let (mut compared, mut worst) = (0, 0.0_f64);
    for axis in ["L", "N", "Y"] {
        for term in wanted[axis]["terms"].as_array().unwrap() {
            let there = found[axis]["terms"].as_array().unwrap().iter().find(|one| one["name"] == term["name"]);
            let Some(there) = there else { continue };
            let number = |one: &Value, key: &str| one[key].as_f64().unwrap();
            let errors = (number(there, "value") - number(term, "value")).abs() / number(term, "std");
            eprintln!("{}: {errors:.3} standard errors", term["name"]);
            (compared, worst) = (compared + 1, worst.max(errors));
        }
    }
    assert!(compared > 8 && worst < 0.5, "{compared} {worst} {said:?}");
    // What the log holds is at the times of its measurement: each channel ends earlier by its latency.
    let logged = samples(&logs.join("live.mcap"));
    let last_s = |channel| logged.iter().rev().find(|sample| sample.get(channel).is_some()).unwrap().time_s;
    let last_rate_s = last_s(Channel::P);
    for (channel, by) in LATE {
        let early_s = last_rate_s - last_s(channel);
        assert!((early_s - 0.01 * by as f64).abs() < 0.021, "{channel:?}: {early_s}");
    }
}
