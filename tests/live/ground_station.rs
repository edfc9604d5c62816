//! `--mavlink-out` of the real program: what arrives is what the JSON has, by a decoder that is not ours, and nothing else
//! arrives.

use super::links::pymavlink;
use super::stage::{Running, left_behind, signal, stage};
use super::station_peer::{KEY, Peer, key_file};
use crate::support::patience::until;
use crate::support::program::{ended, own, path, puma, sideslip};
use serde_json::Value;
use sideslip::io::telemetry::mavlink::packet::{Framer, Framing, Packet};
use std::collections::BTreeMap;
use std::net::UdpSocket;
use std::process::Command;
use std::time::Duration;

/// HEARTBEAT, NAMED_VALUE_FLOAT, STATUSTEXT.
const ALLOWED: [u64; 3] = [0, 251, 253];

/// Value and standard error that the JSON of a run has under a name of the table; the name as the guide has it.
fn in_json(run: &Value, name: &str) -> Option<(f64, f64)> {
    let number = |value: &Value, of: &str, std: &str| Some((value[of].as_f64()?, value[std].as_f64()?));
    let modes = &run["modes"];
    match name.rsplit_once('_') {
        None => number(&modes[name], "value", "std"),
        Some((pair @ ("DR" | "D6" | "LP"), of)) => {
            let pair =
                ["dutch_roll", "coupled_dutch_roll", "lateral_phugoid"][usize::from(pair != "DR") + usize::from(pair == "LP")];
            let (of, std) = if of == "wn" { ("omega", "std_omega") } else { ("zeta", "std_zeta") };
            number(&modes[pair], of, std)
        }
        Some((axis, _)) => {
            let terms = run["equations"][axis]["terms"].as_array()?;
            // A control's name is cut after three letters.
            let is = |term: &&Value| {
                let whole = term["name"].as_str().unwrap();
                whole == name || name.len() == 5 && whole.starts_with(name)
            };
            number(terms.iter().find(is)?, "value", "std")
        }
    }
}

/// Every name of the guide's table, of a rotorcraft.
const NAMES: [&str; 31] = [
    "DR_wn", "DR_zeta", "D6_wn", "D6_zeta", "LP_wn", "LP_zeta", "roll", "spiral", "Y_v", "Y_p", "Y_r", "Y_ped", "L_v", "L_p",
    "L_r", "L_lat", "L_ped", "N_v", "N_p", "N_r", "N_lat", "N_ped", "X_u", "X_w", "Z_w", "Z_lon", "Z_col", "M_u", "M_w", "M_q",
    "M_lon",
];

/// That the last values that arrived are those of the JSON, in single precision; gives how many numbers that were.
fn same_as_json(run: &Value, values: &BTreeMap<String, Vec<Option<f32>>>) -> usize {
    let mut compared = 0;
    for name in NAMES {
        let arrived = |name: &str| values.get(name).and_then(|all| all.iter().rev().find_map(|value| *value)).map(f32::to_bits);
        match in_json(run, name) {
            Some((value, std)) => {
                let (found, error) = (arrived(name), arrived(&format!("{name}_se")));
                assert_eq!((found, error), (Some((value as f32).to_bits()), Some((std as f32).to_bits())), "{name}");
                compared += 1;
            }
            // It may have had a number before the end, which was taken back then.
            None => assert!(values.get(name).is_none_or(|all| all.last() == Some(&None)), "{name}: {values:?}"),
        }
    }
    for name in values.keys().filter(|name| !name.ends_with("_status")) {
        assert!(NAMES.contains(&name.trim_end_matches("_se")), "{name} is not in the table");
    }
    compared
}

#[test]
fn a_recording_that_is_estimated_arrives_with_the_numbers_of_its_json() {
    let _turn = crate::alone();
    let stage = stage("station");
    let (root, json) = (stage.join("root"), stage.join("live.json"));
    let ground = UdpSocket::bind("127.0.0.1:0").unwrap();
    ground.set_read_timeout(Some(Duration::from_millis(100))).unwrap();
    let url = format!("udpout://{}", ground.local_addr().unwrap());
    let source = format!("file://{}", puma().display());
    let args = ["live", "--source", &source, "--speed", "10", "--root", path(&root), "--json", path(&json)];
    let args = [args.as_slice(), &["--mavlink-out", &url, "--mavlink-system", "9"]].concat();
    let (mut framer, mut buffer, mut packets) = (Framer::new(Framing::Bare), [0; 2048], Vec::<Packet>::new());
    let (status, _, said) = std::thread::scope(|scope| {
        let live = scope.spawn(|| ended(&sideslip(&args)));
        // Read as it comes: the system keeps some three hundred datagrams, and a slow machine sends more.
        loop {
            let over = live.is_finished();
            match ground.recv(&mut buffer) {
                Ok(count) => {
                    framer.take(&buffer[..count]);
                    packets.extend(std::iter::from_fn(|| framer.next_packet()));
                }
                Err(_) if over => break,
                Err(_) => {}
            }
        }
        live.join().unwrap()
    });
    assert_eq!(status, 0, "{said}");
    let sent = format!("{} messages sent to {url}", packets.len());
    assert!(said.contains(&sent), "{sent}: {said}");
    let mut values = BTreeMap::<String, Vec<Option<f32>>>::new();
    for packet in &packets {
        assert!(ALLOWED.contains(&u64::from(packet.id)) && packet.signature.is_none(), "{packet:?}");
        assert_eq!((packet.version, packet.system, packet.component), (2, 9, 191));
        if packet.id == 251 {
            let bytes = packet.payload();
            let value = f32::from_le_bytes(*bytes[4..].first_chunk().unwrap());
            let name = String::from_utf8(bytes[8..18].iter().copied().take_while(|byte| *byte != 0).collect()).unwrap();
            values.entry(name).or_default().push((!value.is_nan()).then_some(value));
        }
    }
    let answer: Value = serde_json::from_str(&std::fs::read_to_string(&json).unwrap()).unwrap();
    let compared = same_as_json(&answer["runs"][0], &values);
    eprintln!("{} messages, {compared} numbers as in the JSON", packets.len());
    assert!(compared >= 8, "{compared}");
    assert!(
        NAMES.iter().filter_map(|name| values.get(*name)).all(|all| all.last() == Some(&None)),
        "each is taken back at the end"
    );
    assert_eq!(values["N_status"].last(), Some(&Some(-1.0)));
    assert_eq!(left_behind(&root), [""; 0]);
}

#[test]
fn a_signed_flight_over_udp_is_estimated_without_what_is_forged_and_arrives_signed_at_the_ground() {
    let _turn = crate::alone();
    let Some(pymavlink) = pymavlink() else { return };
    let stage = stage("station-signed");
    let (flight, json, root) = (stage.join("flight.csv"), stage.join("live.json"), stage.join("root"));
    let (key, model) = (key_file(&stage), own("replay/models/puma-like.toml"));
    let simulate = ["simulate", "--model", path(&model), "--rate", "50", "--noise", "flight", "--seed", "7", "--duration", "14"];
    let (status, _, said) =
        ended(&sideslip(&[simulate.as_slice(), &["--input", "pedal:3211:0.02:0.7", "--out", path(&flight)]].concat()));
    assert_eq!(status, 0, "{said}");
    let mut peer = Peer::start(&pymavlink, Some(KEY));
    let url = format!("udpout://127.0.0.1:{}", peer.port());
    let port = UdpSocket::bind("127.0.0.1:0").unwrap().local_addr().unwrap().port().to_string();
    let source = format!("udpin://127.0.0.1:{port}");
    let call = ["live", "--source", &source, "--root", path(&root), "--json", path(&json), "--mavlink-out", &url];
    let mut live = Running::start(&[call.as_slice(), &["--signing-key", path(&key)]].concat());
    until("it listens", || live.said().iter().any(|(_, line)| line.contains("listening")));
    let mut sender = Command::new("python3");
    sender.arg(own("tests/live/sender.py")).args([path(&flight), "127.0.0.1", &port, KEY]).env("PYTHONPATH", &pymavlink);
    let sent = sender.output().unwrap();
    assert!(sent.status.success(), "{}", String::from_utf8_lossy(&sent.stderr));
    let rows: usize = String::from_utf8(sent.stdout).unwrap().trim().parse().unwrap();
    std::thread::sleep(Duration::from_millis(300));
    assert!(signal("TERM", live.number()));
    assert_eq!(live.ended(), 3, "{:?}", live.said());
    let said: Vec<String> = live.said().into_iter().map(|(_, line)| line).collect();
    assert!(said.iter().any(|line| line.contains(&format!("{rows} samples"))), "every instant is one sample: {said:#?}");
    for reason in
        ["without a signature", "of MAVLink 1", "with a wrong signature", "replayed or out of order", "more than a minute behind"]
    {
        let once = said.iter().filter(|line| line.contains(reason) && line.contains("because a key is set")).count();
        let counted = said.iter().filter(|line| line.contains(reason) && line.contains("refused: 14 messages")).count();
        assert_eq!((once, counted), (1, 1), "{reason}: {said:#?}");
    }
    assert!(said.iter().all(|line| !line.contains(&KEY[..8])), "{said:#?}");
    let received = peer.end();
    let mut values = BTreeMap::<String, Vec<Option<f32>>>::new();
    for line in &received {
        assert!(line["error"].is_null() && line["signed"] == true && line["link"] == 1, "{line}");
        assert!(ALLOWED.contains(&line["id"].as_u64().unwrap()), "{line}");
        assert_eq!((&line["system"], &line["component"]), (&1.into(), &191.into()), "{line}");
        let fields = &line["fields"];
        match line["name"].as_str().unwrap() {
            "HEARTBEAT" => assert_eq!((&fields["type"], &fields["autopilot"]), (&18.into(), &8.into()), "{line}"),
            "NAMED_VALUE_FLOAT" => {
                let value = fields["value"].as_f64().map(|value| value as f32);
                values.entry(fields["name"].as_str().unwrap().to_owned()).or_default().push(value);
            }
            "STATUSTEXT" => assert!(!fields["text"].as_str().unwrap().is_empty() || fields["chunk_seq"] != 0, "{line}"),
            other => panic!("{other}"),
        }
    }
    let beats: Vec<f64> = received.iter().filter(|line| line["id"] == 0).map(|line| line["at"].as_f64().unwrap()).collect();
    let apart_s = (beats.last().unwrap() - beats[0]) / (beats.len() - 1) as f64;
    assert!(beats.len() >= 14 && (0.9..1.1).contains(&apart_s), "{} heartbeats, {apart_s} s apart", beats.len());
    let texts = received.iter().filter_map(|line| line["fields"]["text"].as_str()).collect::<String>();
    assert!(texts.contains("Sideslip: run live begins") && texts.contains("equation: converg"), "{texts}");
    let answer: Value = serde_json::from_str(&std::fs::read_to_string(&json).unwrap()).unwrap();
    let compared = same_as_json(&answer["runs"][0], &values);
    eprintln!("{} messages, all signed; {compared} numbers as in the JSON; heartbeats {apart_s:.3} s apart", received.len());
    assert!(compared >= 8, "{compared}");
    assert_eq!(left_behind(&root), [""; 0]);
}
