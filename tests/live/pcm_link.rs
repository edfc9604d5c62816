//! A stream of PCM over UDP, live: the samples that were sent, at their times, and a gap where bits are lost.

use super::stage::{Running, left_behind, signal, stage};
use crate::support::patience::until;
use crate::support::program::path;
use sideslip::flight::channel::Channel;
use sideslip::flight::sample::Sample;
use sideslip::io::bus::reader::Reader;
use sideslip::io::telemetry::pcm::encoder::PcmEncoder;
use sideslip::io::telemetry::pcm::layout::PcmFormat;
use sideslip::io::telemetry::recording::Recording;
use std::net::UdpSocket;
use std::path::Path;
use std::time::{Duration, Instant};

/// 50 minor frames a second of 272 bits: a word lasts 1.2 ms, so that the rates are not in one row.
pub(super) const FRAME_S: f64 = 0.02;
const CHANNELS: [&str; 6] = ["p", "q", "r", "phi", "theta", "tas"];

pub(super) fn format() -> String {
    let mut text = "bit_rate = 13_600\nwords = 16\nword_bits = 16\n[sync]\npattern = 0xFE6B_2840\nbits = 32\n".to_owned();
    for (word, name) in (1..).zip(CHANNELS) {
        text += &format!(
            "[[parameter]]\nname = \"{name}\"\nword = {word}\nencoding = \"twos_complement\"\n\
             calibration = {{ kind = \"polynomial\", coefficients = [0, 0.01] }}\n"
        );
    }
    text
}

/// What the parameter reads at that time: of each its own straight line or level, in steps of its word.
pub(super) fn truth(parameter: usize, time_s: f64) -> f64 {
    match parameter {
        0..3 => (time_s * 10.0).floor() * 0.01 * (parameter as f64 + 1.0),
        5 => 50.0,
        _ => 0.02,
    }
}

pub(super) fn logged(log: &Path) -> Vec<Sample> {
    let mut recording = Recording::open(log).unwrap();
    let mut samples = Vec::new();
    while let Some(row) = recording.next_row().unwrap() {
        samples.push(row.sample);
    }
    samples
}

/// Sends minor frames at their times, save those that are lost; what `live` has logged at the end, and what it said.
fn flown(name: &str, frames: u32, lost: impl Fn(u32) -> bool) -> (Vec<Sample>, Vec<String>) {
    let stage = stage(name);
    let (root, logs, file) = (stage.join("root"), stage.join("logs"), stage.join("frame.toml"));
    std::fs::write(&file, format()).unwrap();
    let port = UdpSocket::bind("127.0.0.1:0").unwrap().local_addr().unwrap().port();
    let url = format!("pcm+udp://127.0.0.1:{port}?format={}", path(&file));
    let mut live = Running::start(&["live", "--source", &url, "--root", path(&root), "--out", path(&logs)]);
    until("the link", || live.said().iter().any(|(_, line)| line.contains("listening at")));
    let sender = UdpSocket::bind("127.0.0.1:0").unwrap();
    let mut encoder = PcmEncoder::new(&PcmFormat::from_toml(&format()).unwrap(), 0.0).unwrap();
    let begun = Instant::now();
    for frame in 0..frames {
        let mut bytes = Vec::new();
        encoder.minor_frame(truth, &mut bytes).unwrap();
        std::thread::sleep(Duration::from_secs_f64(FRAME_S * f64::from(frame)).saturating_sub(begun.elapsed()));
        if !lost(frame) {
            sender.send_to(&bytes, ("127.0.0.1", port)).unwrap();
        }
    }
    std::thread::sleep(Duration::from_millis(300));
    assert!(signal("TERM", live.number()));
    assert_eq!(live.ended(), 3, "{:?}", live.said());
    assert_eq!(left_behind(&root), [""; 0]);
    (logged(&logs.join("live.mcap")), live.said().into_iter().map(|(_, line)| line).collect())
}

#[test]
fn a_single_lost_datagram_of_pcm_costs_its_frame_and_the_time_goes_on_right() {
    let _turn = crate::alone();
    let (samples, said) = flown("pcm-one-lost", 250, |frame| frame == 120);
    let lost: Vec<&String> = said.iter().filter(|line| line.contains("datagrams of 0.0200 s are lost")).collect();
    assert_eq!(lost.len(), 1, "{said:?}");
    let rates: Vec<(f64, f64)> = samples.iter().filter_map(|sample| Some((sample.time_s, sample.get(Channel::P)?))).collect();
    // 250 were made; the last waits for a pattern behind it no longer than the end.
    assert_eq!(rates.len(), 249, "{said:?}");
    let start_s = rates[0].0;
    for (time_s, rate) in rates.iter().map(|(time_s, rate)| (time_s - start_s, rate)) {
        // Words behind the loss are early until it is told, by less than the steps of the truth are apart.
        let own = truth(0, time_s + 32.0 / 13_600.0);
        assert!((rate - own).abs() < 0.011, "{rate} at {time_s}, {own} expected");
    }
    let last_s = rates[rates.len() - 1].0 - start_s;
    assert!((last_s - 249.0 * FRAME_S).abs() < 1e-6, "{last_s}");
}

#[test]
fn pcm_over_udp_is_estimated_and_lost_bits_are_a_gap() {
    let _turn = crate::alone();
    let stage = stage("pcm-link");
    let (root, logs, file) = (stage.join("root"), stage.join("logs"), stage.join("frame.toml"));
    std::fs::write(&file, format()).unwrap();
    let port = UdpSocket::bind("127.0.0.1:0").unwrap().local_addr().unwrap().port();
    let url = format!("pcm+udp://127.0.0.1:{port}?format={}", path(&file));
    let mut live = Running::start(&["live", "--source", &url, "--root", path(&root), "--out", path(&logs)]);
    until("the link", || live.said().iter().any(|(_, line)| line.contains("listening at")));
    let mut reader = Reader::open(&root).unwrap();
    let sender = UdpSocket::bind("127.0.0.1:0").unwrap();
    let mut encoder = PcmEncoder::new(&PcmFormat::from_toml(&format()).unwrap(), 0.0).unwrap();
    let begun = Instant::now();
    let mut sent = 0;
    for frame in 0_u32..260 {
        let mut bytes = Vec::new();
        encoder.minor_frame(truth, &mut bytes).unwrap();
        let due = Duration::from_secs_f64(FRAME_S * f64::from(frame));
        std::thread::sleep(due.saturating_sub(begun.elapsed()));
        // 50 frames, a second, are lost on the way.
        if !(130..180).contains(&frame) {
            sender.send_to(&bytes, ("127.0.0.1", port)).unwrap();
            sent += 1;
        }
    }
    until("estimates behind the gap", || {
        reader.latest().unwrap().is_some_and(|estimate| estimate.derivatives.time_s > 180.0 * FRAME_S)
    });
    drop(reader);
    std::thread::sleep(Duration::from_millis(300));
    assert!(signal("TERM", live.number()));
    assert_eq!(live.ended(), 3, "{:?}", live.said());
    assert!(live.said().iter().any(|(_, line)| line.contains("of the stream are lost")), "{:?}", live.said());
    let samples = logged(&logs.join("live.mcap"));
    let rates: Vec<(f64, f64)> = samples.iter().filter_map(|sample| Some((sample.time_s, sample.get(Channel::P)?))).collect();
    // A frame that no pattern confirmed, at each end, and one that waits.
    assert!(rates.len() + 8 >= sent, "{} of {sent}", rates.len());
    assert!(samples.len() > 3 * rates.len(), "a row holds words within half a millisecond");
    let gaps: Vec<f64> = rates.windows(2).map(|pair| pair[1].0 - pair[0].0).filter(|gap| *gap > 0.1).collect();
    assert_eq!(gaps.len(), 1, "{gaps:?}");
    assert!((gaps[0] - 51.0 * FRAME_S).abs() < 0.15, "{gaps:?}");
    for (time_s, rate) in rates.iter().filter(|(time_s, _)| *time_s < 130.0 * FRAME_S) {
        assert!((rate - truth(0, *time_s)).abs() < 0.011, "{rate} at {time_s}");
    }
    assert_eq!(left_behind(&root), [""; 0]);
}
