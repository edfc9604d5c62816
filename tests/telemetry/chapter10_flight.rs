//! A simulated Puma recorded after IRIG 106 Chapter 10, in every mode, against the same samples as they were measured: the same
//! derivatives, by the recording's own setup. The packets are written by a writer of the tests, straight from the standard.
//!
//! Gate: a tenth of a standard error in each derivative that has a number.

use super::derivatives::{apart, derivatives};
use super::pcm_flight::kept;
use super::pcm_link::{Guard, flown, format, words};
use crate::support::chapter10::{Recorder, Storage, in_setup_words, setup, setup_packet, time_packet};
use crate::support::program::{ended, folder, path, sideslip};
use crate::support::recorded_samples::remaining_samples;
use serde_json::Value;
use sideslip::flight::channel::Channel;
use sideslip::flight::sample::Sample;
use sideslip::io::telemetry::pcm::encoder::PcmEncoder;
use sideslip::io::telemetry::recording::Recording;
use std::path::Path;

const CHANNEL: u16 = 7;
/// 10 MHz counts that a minor frame lasts, 256 a second, by a counter that is 2 ppm fast. Where frames and counter are exactly in
/// step, a schedule of the pipeline falls on a sample exactly, and goes to the next where a count is rounded down by 100 ns: the
/// derivatives of throughput mode then differ by 0.126 standard errors.
const FRAME_TICKS: f64 = 1e7 / 256.0 * (1.0 + 2e-6);

/// The minor frames of a flight.
fn frames(samples: &[Sample]) -> Vec<Vec<u8>> {
    let mut encoder = PcmEncoder::new(&format(Guard::None), 0.0).unwrap();
    let frame = |sample: &Sample| {
        let mut frame = Vec::new();
        encoder.minor_frame(|parameter, _| sample.get(words()[parameter].channel).unwrap(), &mut frame).unwrap();
        frame
    };
    samples.iter().map(frame).collect()
}

fn unit(name: &str) -> String {
    in_setup_words(Channel::from_name(name).unwrap().0.si_unit())
}

/// Setup, then a time packet a second among those of PCM; the counter wraps in the middle.
fn packets(samples: &[Sample], storage: Storage) -> Vec<Vec<u8>> {
    let first_rtc = (1 << 48) - 100_000_000;
    let recorder = Recorder { channel: CHANNEL, storage, first_rtc, frame_ticks: FRAME_TICKS, in_packet: 20 };
    let mut packets = vec![setup_packet(&setup(CHANNEL, &format(Guard::None), storage, unit))];
    let mut second = 0;
    for (k, packet) in recorder.packets(&frames(samples)).into_iter().enumerate() {
        while f64::from(second) * 256.0 <= 20.0 * k as f64 {
            let rtc = recorder.rtc(256.0 * f64::from(second)) % (1 << 48);
            packets.push(time_packet(second, rtc, second));
            second += 1;
        }
        packets.push(packet);
    }
    packets
}

/// The setup of a recording of the flight.
pub(super) fn setup_of() -> String {
    setup(CHANNEL, &format(Guard::None), Storage::Packed, unit)
}

/// So many samples of the flight behind that setup.
pub(super) fn with_setup(text: &str, count: usize) -> Vec<u8> {
    let samples: Vec<Sample> = flown(11).into_iter().take(count).collect();
    let mut packets = packets(&samples, Storage::Packed);
    packets[0] = setup_packet(text);
    packets.concat()
}

/// The rows of a recording, and what of it was lost.
fn read(file: &Path) -> (Vec<Sample>, Option<String>) {
    let mut recording = Recording::open(file).unwrap();
    let samples = remaining_samples(&mut recording);
    (samples, recording.shortfall())
}

#[test]
fn a_puma_by_chapter_10_has_the_derivatives_of_its_samples_in_every_mode() {
    let folder = folder("chapter10-flight");
    let samples = flown(11);
    let measured = kept(&samples);
    let wanted = derivatives(measured.iter());
    for storage in Storage::ALL {
        let file = folder.join(format!("{storage:?}.ch10"));
        std::fs::write(&file, packets(&samples, storage).concat()).unwrap();
        let (received, shortfall) = read(&file);
        assert_eq!((received.len(), shortfall), (measured.len(), None), "{storage:?}");
        for (sent, got) in measured.iter().zip(&received) {
            assert_eq!(sent.present, got.present, "{storage:?}");
            // The words of a frame are one row: a third of a millisecond. The counter has 100 ns, and 2 ppm are 44 us at the end.
            assert!((-1e-7..0.4e-3).contains(&(got.time_s - sent.time_s)), "{storage:?}: {} {}", got.time_s, sent.time_s);
        }
        let found = apart(&wanted, &derivatives(received.iter()));
        eprintln!("{storage:?}: {found:?}");
        assert!(found.compared > 12 && found.largest <= 0.1 && found.different.is_empty(), "{storage:?}: {found:?}");
    }
}

#[test]
fn every_command_reads_it_and_a_damaged_and_a_missing_packet_are_told() {
    let folder = folder("chapter10-commands");
    let (file, csv) = (folder.join("puma.ch10"), folder.join("puma.csv"));
    let samples = flown(11);
    std::fs::write(&file, packets(&samples, Storage::Packed).concat()).unwrap();
    let file = path(&file);
    for args in
        [&["replay", file][..], &["check", file], &["identify", file, "--states", "v,p,phi,r"], &["convert", file, path(&csv)]]
    {
        let (status, out, said) = ended(&sideslip(args));
        assert!(status == 0 || (args[0] == "check" && status == 4), "{args:?}: {status} {out} {said}");
    }
    let text = std::fs::read_to_string(&csv).unwrap();
    assert!(text.contains("# time_zero = \"day 131 20:05:00.000000\""), "{}", &text[..300]);
    // The same numbers from what was converted.
    let by = |file: &str| {
        let (_, out, _) = ended(&sideslip(&["replay", file, "--json", "-"]));
        let answer: Value = serde_json::from_str(&out).unwrap();
        answer["runs"][0]["equations"].clone()
    };
    assert_eq!(by(file), by(path(&csv)));
    let (status, out, said) = ended(&sideslip(&["inspect", file]));
    assert!(status == 0 && out.contains("PCM data, packed") && out.contains("rows"), "{status} {out} {said}");

    let mut packets = packets(&samples, Storage::Packed);
    packets[50][200] ^= 1;
    packets.remove(150);
    std::fs::write(file, packets.concat()).unwrap();
    let (received, shortfall) = read(Path::new(file));
    let shortfall = shortfall.unwrap();
    assert_eq!(received.len() + 40, samples.len());
    assert!(shortfall.contains("1 packets with a wrong checksum") && shortfall.contains("1 packets missing"), "{shortfall}");
    // Each sample behind them still has its own time.
    let mut sent = samples.iter();
    for got in &received {
        let same = sent.find(|sent| (-1e-7..0.4e-3).contains(&(got.time_s - sent.time_s)));
        let (got, same) = (got.get(Channel::Flap0).unwrap(), same.unwrap().get(Channel::Flap0).unwrap());
        assert!((got - same).abs() < 1.0 / 65_536.0, "{got} {same}");
    }
    let (status, out, said) = ended(&sideslip(&["replay", file]));
    assert!(status == 3 && (out + &said).contains("wrong checksum"), "{status} {said}");
    let (status, _, said) = ended(&sideslip(&["inspect", file]));
    assert!(status == 3, "{said}");
}

#[test]
fn a_setup_that_contradicts_its_data_is_told_or_refused() {
    let folder = folder("chapter10-setup");
    let file = folder.join("wrong.ch10");
    let samples: Vec<Sample> = flown(11).into_iter().take(1000).collect();
    let with = |storage: Storage, from: &str, to: &str| {
        let mut packets = packets(&samples, storage);
        let text = setup(CHANNEL, &format(Guard::None), storage, unit);
        assert!(text.contains(from), "{from}");
        packets[0] = setup_packet(&text.replace(from, to));
        std::fs::write(&file, packets.concat()).unwrap();
    };
    with(Storage::Throughput, "P-1\\D2:999424", "P-1\\D2:1020000");
    let (received, shortfall) = read(&file);
    assert!(shortfall.clone().unwrap().contains("TMATS says 1020000 bits a second"), "{shortfall:?}");
    // A packet is 20 frames, so that its own time holds the error down to a fiftieth of it.
    assert!(received.len() > 900 && received.last().unwrap().time_s < 1000.0 / 256.0);
    // So far off that no packet follows the one before it: words are dated by the times of the packets after eight of them.
    with(Storage::Throughput, "P-1\\D2:999424", "P-1\\D2:1600000");
    let (received, shortfall) = read(&file);
    assert!(shortfall.clone().unwrap().contains("bits come at 999422 a second by the recorder's times"), "{shortfall:?}");
    let late: Vec<&Sample> = received.iter().filter(|sample| sample.time_s > 1.0).collect();
    assert!(late.len() > 740, "{} samples", late.len());
    for got in late {
        let frames = 256.0 * got.time_s;
        assert!((frames - frames.round()).abs() < 0.2, "{}", got.time_s);
    }
    for (storage, from, to, expected) in [
        (Storage::Throughput, "MF1:243", "MF1:200", "TMATS says 3904 bits in a minor frame (P-1\\MF2), but its words"),
        (Storage::Packed, "MF1:243", "MF1:200", "the data say 3904"),
        (Storage::Packed, "MF5:1111111001101011", "MF5:0000000110010100", "FE6B2840 recurs every"),
    ] {
        with(storage, from, to);
        let mut recording = Recording::open(&file).unwrap();
        let said = recording.next_row().unwrap_err().to_string();
        assert!(said.contains(expected) && said.contains("none that can be used"), "{said}");
        let (status, _, said) = ended(&sideslip(&["replay", path(&file)]));
        assert!(status == 2 || status == 1, "{status} {said}");
    }
}

#[test]
fn measurements_with_other_names_need_a_map_or_a_format() {
    let folder = folder("chapter10-names");
    let (file, map, frame) = (folder.join("named.ch10"), folder.join("map.toml"), folder.join("frame.toml"));
    let samples: Vec<Sample> = flown(11).into_iter().take(512).collect();
    let mut packets = packets(&samples, Storage::Unpacked);
    let mut text = setup(CHANNEL, &format(Guard::None), Storage::Unpacked, unit);
    for channel in words().into_iter().map(|word| word.channel) {
        let name = channel.name(Default::default()).to_ascii_uppercase();
        text = text.replace(&format!(":{name};"), &format!(":PARAM_{name};"));
    }
    packets[0] = setup_packet(&text);
    std::fs::write(&file, packets.concat()).unwrap();
    let said = Recording::open(&file).unwrap_err().to_string();
    assert!(said.contains("`PARAM_FLAP_0`") || said.contains("`PARAM_"), "{said}");
    assert!(said.contains("[measurements]") && said.contains("--config FILE"), "{said}");
    let (status, out, _) = ended(&sideslip(&["inspect", path(&file)]));
    assert!(status == 0 && out.contains("Nothing can be estimated from it") && out.contains("PARAM_P"), "{out}");
    std::fs::write(&map, "[measurements]\np = \"PARAM_P\"\nr = \"param_r\"\n[run]\naircraft = \"Puma\"\n").unwrap();
    let csv = folder.join("named.csv");
    let converted = |args: &[&str]| {
        let (status, _, said) = ended(&sideslip(&[&["convert"], args, &[path(&csv), "--force"]].concat()));
        assert_eq!(status, 0, "{said}");
        std::fs::read_to_string(&csv).unwrap()
    };
    let text = converted(&[path(&file), "--config", path(&map)]);
    let header = text.lines().find(|line| line.starts_with("time")).unwrap();
    assert!(header.contains(",p,") && header.contains(",r,") && header.contains(",PARAM_TAS"), "{header}");
    assert!(text.starts_with("# aircraft = \"Puma\""), "{}", &text[..100]);
    // A format of the frames instead, its columns under their own names.
    let toml = "channel = 7\nbit_rate = 999_424\nwords = 243\nword_bits = 16\nminor_frames = 8\n[sync]\npattern = 0xFE6B_2840\n\
        bits = 32\n[[parameter]]\nname = \"flap_0\"\nunit = \"rad\"\nword = 2\nencoding = \"twos_complement\"\n\
        calibration = { kind = \"polynomial\", coefficients = [0.0, 1.52587890625e-5] }\n";
    std::fs::write(&frame, toml.replace("flap_0", Channel::Flap0.name(Default::default()))).unwrap();
    let text = converted(&[&format!("ch10+file://{}?format={}", path(&file), path(&frame))]);
    assert_eq!(text.lines().filter(|line| line.starts_with(|first: char| first.is_ascii_digit())).count(), samples.len());
}
