//! Packets of IRIG 106 Chapter 10 over UDP, live, with transfer headers 1 and 3: the samples that were sent at their own times,
//! lost datagrams and silences as gaps of their own length, telemetry that is killed and comes back.

use super::pcm_link::{FRAME_S, format, logged, truth};
use super::stage::{Running, left_behind, signal, stage};
use crate::support::chapter10::{Recorder, Storage, datagrams_1, datagrams_3, in_setup_words, setup, setup_packet};
use crate::support::patience::until;
use crate::support::program::path;
use sideslip::flight::channel::Channel;
use sideslip::io::telemetry::pcm::encoder::PcmEncoder;
use sideslip::io::telemetry::pcm::layout::PcmFormat;
use std::net::UdpSocket;
use std::time::{Duration, Instant};

const CHANNEL: u16 = 9;
/// Minor frames in a packet.
const IN_PACKET: usize = 2;
/// Of a roll rate: its word is the first behind the pattern.
const WORD_S: f64 = 32.0 / 13_600.0;

fn packets(frames: u32, storage: Storage) -> Vec<Vec<u8>> {
    let format = PcmFormat::from_toml(&format()).unwrap();
    let mut encoder = PcmEncoder::new(&format, 0.0).unwrap();
    let frame = |_| {
        let mut bytes = Vec::new();
        encoder.minor_frame(truth, &mut bytes).unwrap();
        bytes
    };
    let frames: Vec<Vec<u8>> = (0..frames).map(frame).collect();
    Recorder { channel: CHANNEL, storage, first_rtc: 5_000_000_000, frame_ticks: FRAME_S * 1e7, in_packet: IN_PACKET }
        .packets(&frames)
}

fn own_setup(storage: Storage) -> Vec<u8> {
    let unit = |name: &str| in_setup_words(Channel::from_name(name).unwrap().0.si_unit());
    setup_packet(&setup(CHANNEL, &PcmFormat::from_toml(&format()).unwrap(), storage, unit))
}

fn free_port() -> u16 {
    UdpSocket::bind("127.0.0.1:0").unwrap().local_addr().unwrap().port()
}

/// Sends what is due at those times.
fn send(port: u16, begun: Instant, datagrams: impl Iterator<Item = (f64, Vec<u8>)>) {
    let sender = UdpSocket::bind("127.0.0.1:0").unwrap();
    for (due_s, datagram) in datagrams {
        std::thread::sleep(Duration::from_secs_f64(due_s).saturating_sub(begun.elapsed()));
        sender.send_to(&datagram, ("127.0.0.1", port)).unwrap();
    }
}

#[test]
fn transfer_header_1_with_the_setup_on_the_way_and_telemetry_killed() {
    let _turn = crate::alone();
    let stage = stage("chapter10-link-1");
    let (root, logs, port) = (stage.join("root"), stage.join("logs"), free_port());
    let url = format!("ch10+udp://127.0.0.1:{port}");
    let mut live = Running::start(&["live", "--source", &url, "--root", path(&root), "--out", path(&logs)]);
    let says = |live: &Running, words: &str| live.said().iter().any(|(_, line)| line.contains(words));
    until("the link", || says(&live, "listening at"));
    // Ten packets come before the setup; one datagram of packet 40 is lost; a second, of packets 60 to 84, is silent.
    let all = packets(400, Storage::Packed);
    let due_s = |k: usize| FRAME_S * (IN_PACKET * (k + 1)) as f64;
    let mut sent: Vec<(usize, Vec<u8>)> = all.into_iter().enumerate().collect();
    sent.insert(10, (9, own_setup(Storage::Packed)));
    let datagrams = datagrams_1(&sent.iter().map(|(_, packet)| packet.clone()).collect::<Vec<_>>(), 100);
    let of_packet = sent.iter().flat_map(|(k, packet)| std::iter::repeat_n(*k, packet.len().div_ceil(100)));
    let mut lost = false;
    let mut kept = Vec::new();
    for (k, datagram) in of_packet.zip(datagrams) {
        if k == 40 && !std::mem::replace(&mut lost, true) || (60..85).contains(&k) {
            continue;
        }
        kept.push((due_s(k), datagram));
    }
    let begun = Instant::now();
    let sending = std::thread::spawn(move || send(port, begun, kept.into_iter()));
    std::thread::sleep(Duration::from_secs(5));
    let number = live.said().iter().find_map(|(_, line)| line.strip_prefix("sideslip: ingest is process ").map(str::to_owned));
    assert!(signal("KILL", number.unwrap().parse().unwrap()));
    sending.join().unwrap();
    std::thread::sleep(Duration::from_millis(300));
    assert!(signal("TERM", live.number()));
    assert_eq!(live.ended(), 3, "{:?}", live.said());
    let said: Vec<String> = live.said().into_iter().map(|(_, line)| line).collect();
    for words in ["PCM channel 9 is read", "setup (TMATS) is waited for"] {
        assert!(said.iter().any(|line| line.contains(words)), "{words}: {said:#?}");
    }
    let samples = logged(&logs.join("live.mcap"));
    let rates: Vec<(f64, f64)> = samples.iter().filter_map(|sample| Some((sample.time_s, sample.get(Channel::P)?))).collect();
    // Time counts from the packet behind the setup, frame 20, and goes on so behind the kill.
    let frame = |time_s: f64| 20.0 + (time_s - rates[0].0) / FRAME_S;
    let apart = rates.windows(2).filter(|pair| pair[1].0 - pair[0].0 > 1.5 * FRAME_S);
    let gaps: Vec<(f64, f64)> = apart.map(|pair| (frame(pair[0].0), frame(pair[1].0))).collect();
    eprintln!("{} samples of roll rate, gaps behind and before frames {gaps:?}", rates.len());
    assert!((gaps[0].0 - 79.0).abs() < 0.01 && (gaps[0].1 - 82.0).abs() < 0.01, "{gaps:?}");
    assert!((gaps[1].0 - 119.0).abs() < 0.01 && (gaps[1].1 - 170.0).abs() < 0.01, "{gaps:?}");
    for (time_s, rate) in &rates {
        let at = frame(*time_s);
        let own = truth(0, at.round() * FRAME_S + WORD_S);
        assert!((at - at.round()).abs() < 0.01 && (rate - own).abs() < 0.006, "{rate} at frame {at}, {own} expected");
    }
    assert!(rates.len() > 270, "{}", rates.len());
    assert_eq!(left_behind(&root), [""; 0]);
}

#[test]
fn transfer_header_3_with_a_format_file_and_a_lost_datagram() {
    let _turn = crate::alone();
    let stage = stage("chapter10-link-3");
    let (root, logs, file, port) = (stage.join("root"), stage.join("logs"), stage.join("frame.toml"), free_port());
    std::fs::write(&file, format()).unwrap();
    let url = format!("ch10+udp://127.0.0.1:{port}?format={}", path(&file));
    let mut live = Running::start(&["live", "--source", &url, "--root", path(&root), "--out", path(&logs)]);
    until("the link", || live.said().iter().any(|(_, line)| line.contains("listening at")));
    let all = packets(200, Storage::Throughput);
    let stream = all.concat().len();
    let piece = 80;
    let of_stream_s = 200.0 * FRAME_S / stream as f64;
    let datagrams = datagrams_3(&all, piece).into_iter().enumerate();
    let kept = datagrams.filter(|(k, _)| *k != 60).map(|(k, datagram)| (of_stream_s * (piece * (k + 1)) as f64, datagram));
    send(port, Instant::now(), kept);
    std::thread::sleep(Duration::from_millis(300));
    assert!(signal("TERM", live.number()));
    assert_eq!(live.ended(), 3, "{:?}", live.said());
    let said: Vec<String> = live.said().into_iter().map(|(_, line)| line).collect();
    assert!(said.iter().any(|line| line.contains("1 datagrams lost")), "{said:#?}");
    assert!(said.iter().any(|line| line.contains("packets missing")), "{said:#?}");
    let samples = logged(&logs.join("live.mcap"));
    let rates: Vec<(f64, f64)> = samples.iter().filter_map(|sample| Some((sample.time_s, sample.get(Channel::P)?))).collect();
    eprintln!("{} of 200 samples of roll rate", rates.len());
    // A datagram touches two packets of two frames, with the frames that span their ends.
    assert!((190..200).contains(&rates.len()), "{}", rates.len());
    for (time_s, rate) in &rates {
        let own = truth(0, time_s - rates[0].0 + WORD_S);
        assert!((rate - own).abs() < 0.011, "{rate} at {time_s}, {own} expected");
    }
    let last_s = rates[rates.len() - 1].0 - rates[0].0;
    assert!((last_s - 199.0 * FRAME_S).abs() < 1e-6, "{last_s}");
    assert_eq!(left_behind(&root), [""; 0]);
}

#[test]
fn packets_in_the_datagram_of_the_setup_are_read() {
    let _turn = crate::alone();
    let stage = stage("chapter10-link-setup");
    let (root, logs, port) = (stage.join("root"), stage.join("logs"), free_port());
    let url = format!("ch10+udp://127.0.0.1:{port}");
    let mut live = Running::start(&["live", "--source", &url, "--root", path(&root), "--out", path(&logs)]);
    until("the link", || live.said().iter().any(|(_, line)| line.contains("listening at")));
    let all = [vec![own_setup(Storage::Packed)], packets(100, Storage::Packed)].concat();
    // The first datagram has the setup and some packets behind it.
    let piece = all[0].len() + 5 * all[1].len() / 2;
    let datagrams = datagrams_3(&all, piece);
    let count = datagrams.len();
    let due_s = 100.0 * FRAME_S / count as f64;
    send(port, Instant::now(), datagrams.into_iter().enumerate().map(|(k, datagram)| (due_s * k as f64, datagram)));
    std::thread::sleep(Duration::from_millis(300));
    assert!(signal("TERM", live.number()));
    assert_eq!(live.ended(), 0, "{:?}", live.said());
    let samples = logged(&logs.join("live.mcap"));
    let rates: Vec<(f64, f64)> = samples.iter().filter_map(|sample| Some((sample.time_s, sample.get(Channel::P)?))).collect();
    assert_eq!(rates.len(), 100, "{count} datagrams: {:?}", live.said());
    for (frame, (time_s, rate)) in rates.iter().enumerate() {
        let own = truth(0, frame as f64 * FRAME_S + WORD_S);
        assert!(
            (time_s - rates[0].0 - frame as f64 * FRAME_S).abs() < 1e-6 && (rate - own).abs() < 0.011,
            "{frame}: {rate} {own}"
        );
    }
    assert_eq!(left_behind(&root), [""; 0]);
}
