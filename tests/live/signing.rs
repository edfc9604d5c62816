//! Signing with another implementation at the other end, in both directions, and timestamps that outlive a kill.

use super::links::pymavlink;
use super::stage::{Running, signal, stage};
use super::station_peer::{KEY, Peer, key_file};
use crate::support::patience::until;
use crate::support::program::{ended, own, path, puma, sideslip};
use sideslip::io::ground_station::message::{StationFrames, StationMessage};
use sideslip::io::telemetry::mavlink::packet::{Framer, Framing};
use sideslip::io::telemetry::mavlink::signing::{LinkSigning, SigningRefusal};
use sideslip::io::telemetry::mavlink::signing_key::SigningKey;
use sideslip::io::telemetry::mavlink::signing_time::{SigningTime, system_steps};
use std::io::Write;
use std::process::{Command, Stdio};

fn ours(key: &[u8; 32]) -> LinkSigning {
    LinkSigning::new(SigningKey::new(*key).unwrap(), 1, SigningTime::unrecorded(Box::new(system_steps)))
}

/// The bytes of the key that the other end is called with.
fn key() -> [u8; 32] {
    std::array::from_fn(|i| u8::from_str_radix(&KEY[2 * i..2 * i + 2], 16).unwrap())
}

#[test]
fn what_pymavlink_signs_is_accepted_and_what_must_be_refused_is_refused_for_its_reason() {
    let Some(pymavlink) = pymavlink() else { return };
    let mut peer = Command::new("python3");
    peer.arg(own("tests/live/station_peer.py")).args(["sign", KEY]).env("PYTHONPATH", pymavlink);
    let frames = peer.output().unwrap();
    assert!(frames.status.success(), "{}", String::from_utf8_lossy(&frames.stderr));
    let mut signing = ours(&key());
    let mut judged = 0;
    for line in String::from_utf8(frames.stdout).unwrap().lines() {
        let (expected, hex) = line.split_once(' ').unwrap();
        let frame: Vec<u8> = (0..hex.len() / 2).map(|i| u8::from_str_radix(&hex[2 * i..2 * i + 2], 16).unwrap()).collect();
        let mut framer = Framer::new(Framing::Bare);
        framer.take(&frame);
        let found = signing.accept(&framer.last_packet().unwrap());
        let expected = match expected {
            "accepted" => Ok(()),
            "not-later" => Err(SigningRefusal::NotLater),
            "wrong-signature" => Err(SigningRefusal::WrongSignature),
            "unsigned" => Err(SigningRefusal::Unsigned),
            "version-1" => Err(SigningRefusal::Version1),
            "behind" => Err(SigningRefusal::Behind),
            other => panic!("{other}"),
        };
        assert_eq!(found, expected, "{line}");
        judged += 1;
    }
    assert_eq!(judged, 13);
}

#[test]
fn what_we_sign_pymavlink_accepts_and_refuses_replayed_changed_or_under_another_key() {
    let Some(pymavlink) = pymavlink() else { return };
    let (mut signing, mut other) = (ours(&key()), ours(&[9; 32]));
    let mut frames = StationFrames::new(1);
    let mut expected = Vec::new();
    let mut lines = String::new();
    let mut put = |word: &'static str, frame: &[u8]| {
        expected.push(word);
        frame.iter().for_each(|byte| lines.push_str(&format!("{byte:02x}")));
        lines.push('\n');
    };
    for k in 0..20_u8 {
        let message = match k % 2 {
            0 => StationMessage::Heartbeat,
            _ => StationMessage::named("N_v", f32::from(k), u32::from(k)),
        };
        let frame = frames.frame(&message).to_vec();
        let signed = signing.sign(&frame).unwrap().to_vec();
        put("ok", &signed);
        put("refused", &signed);
        put("refused", other.sign(&frame).unwrap());
        let mut changed = signing.sign(&frame).unwrap().to_vec();
        *changed.last_mut().unwrap() ^= 1;
        put("refused", &changed);
        put("refused", &frame);
    }
    let mut peer = Command::new("python3");
    peer.arg(own("tests/live/station_peer.py")).args(["verify", KEY]).env("PYTHONPATH", pymavlink);
    let mut peer = peer.stdin(Stdio::piped()).stdout(Stdio::piped()).spawn().unwrap();
    peer.stdin.take().unwrap().write_all(lines.as_bytes()).unwrap();
    let answer = String::from_utf8(peer.wait_with_output().unwrap().stdout).unwrap();
    assert_eq!(answer.lines().collect::<Vec<_>>(), expected);
}

#[test]
fn timestamps_go_on_after_a_kill_and_another_implementation_accepts_every_frame() {
    let _turn = crate::alone();
    let Some(pymavlink) = pymavlink() else { return };
    let stage = stage("signing-killed");
    let (root, key) = (stage.join("root"), key_file(&stage));
    let mut peer = Peer::start(&pymavlink, Some(KEY));
    let url = format!("udpout://127.0.0.1:{}", peer.port());
    for life in 1..=4_usize {
        let call = ["estimate", "--root", path(&root), "--mavlink-out", &url, "--signing-key", path(&key)];
        let mut estimate = Running::start(&call);
        // Each life sends one heartbeat a second, and seven statuses.
        let sent = peer.received().len();
        until("its messages", || peer.received().len() >= sent + 16);
        match life % 2 {
            0 => assert!(signal("TERM", estimate.number())),
            _ => estimate.kill(),
        }
        if life % 2 == 0 {
            assert_eq!(estimate.ended(), 0, "{:?}", estimate.said());
        }
    }
    let received = peer.end();
    assert!(received.len() >= 64 && received.iter().all(|line| line["error"].is_null() && line["link"] == 1), "{received:?}");
    let timestamps: Vec<u64> = received.iter().map(|line| line["timestamp"].as_u64().unwrap()).collect();
    assert!(timestamps.is_sorted_by(|a, b| a < b), "{timestamps:?}");
    let ahead_s = (timestamps.last().unwrap().saturating_sub(system_steps())) as f64 / 1e5;
    assert!(ahead_s < 25.0, "{ahead_s}");
    let stored: u64 = std::fs::read_to_string(stage.join("flight.key.timestamp-1")).unwrap().trim().parse().unwrap();
    assert!(stored > *timestamps.last().unwrap());
}

#[test]
fn a_key_that_others_can_read_or_that_is_none_is_refused_before_the_flight() {
    let _turn = crate::alone();
    let stage = stage("signing-wrong");
    let (root, key) = (stage.join("root"), key_file(&stage));
    let flight = format!("file://{}", puma().display());
    let call = |args: &[&str]| {
        let (status, _, said) = ended(&sideslip(&[args, &["--root", path(&root)]].concat()));
        (status, said)
    };
    let out = ["--mavlink-out", "udpout://127.0.0.1:9"];
    let (status, said) = call(&["live", "--source", &flight, "--signing-key", path(&key)]);
    assert!(status == 2 && said.contains("with a link of MAVLink as the source, or with --mavlink-out"), "{said}");
    let (status, said) = call(&["ingest", "--source", &flight, "--signing-key", path(&key)]);
    assert!(status == 2 && said.contains("expected with a link"), "{said}");
    let (status, said) = call(&["estimate", "--signing-key", path(&key)]);
    assert!(status == 2 && said.contains("--mavlink-out"), "{said}");
    assert!(Command::new("chmod").args(["644", path(&key)]).status().unwrap().success());
    for command in [&["live", "--source", &flight][..], &["estimate"], &["ingest", "--source", "udpin://127.0.0.1:0"]] {
        let out: &[&str] = if command[0] == "ingest" { &[] } else { &out };
        let (status, said) = call(&[command, out, &["--signing-key", path(&key)]].concat());
        assert!(status == 2 && said.contains("permissions 644") && !said.contains(&KEY[..8]), "{said}");
    }
    for wrong in ["udpout://127.0.0.1", "file://x", "14550"] {
        let (status, said) = call(&["estimate", "--mavlink-out", wrong]);
        assert!(status == 2 && said.contains("expected"), "{said}");
    }
}
