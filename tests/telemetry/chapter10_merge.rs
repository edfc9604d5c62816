//! A simulated Puma in two PCM channels, rates, forces and attitude in one, air data and controls in the other that begins later:
//! of one recording with one counter, and of two recordings with a clock each. Merged by `convert`, the samples are at the
//! times at which they were measured and give the derivatives of the flight.
//!
//! Gate: a tenth of a standard error in each derivative that has a number.

use super::derivatives::{apart, derivatives};
use super::pcm_link::{ChannelWord, flown, words};
use crate::support::chapter10::{Recorder, Storage, in_setup_words, setup, setup_packet, time_packet};
use crate::support::program::{ended, folder, path, sideslip};
use sideslip::flight::channel::Channel;
use sideslip::flight::sample::Sample;
use sideslip::io::telemetry::pcm::encoder::PcmEncoder;
use sideslip::io::telemetry::pcm::layout::PcmFormat;
use sideslip::io::telemetry::recording::Recording;
use std::path::Path;

/// Samples a second of the flight, and counts of 10 MHz between them.
const SAMPLES_HZ: f64 = 256.0;
const TICKS: f64 = 1e7 / SAMPLES_HZ * (1.0 + 2e-6);
const FIRST_RTC: u64 = (1 << 48) - 100_000_000;
/// The recorder's number, the first sample, from one to the next, words of a minor frame.
const MOTION: Part = Part { number: 7, first: 0, every: 2, words: 244 };
const AIR: Part = Part { number: 9, first: 40, every: 4, words: 484 };

/// One PCM channel.
#[derive(Clone, Copy)]
struct Part {
    number: u16,
    first: usize,
    every: usize,
    words: u32,
}

impl Part {
    fn carries(self, channel: Channel) -> bool {
        let of_air = Channel::CONTROLS.contains(&channel) || [Channel::Tas, Channel::Alpha, Channel::Beta].contains(&channel);
        of_air == (self.number == AIR.number)
    }

    fn channels(self) -> Vec<ChannelWord> {
        words().into_iter().filter(|word| self.carries(word.channel)).collect()
    }

    fn format(self) -> PcmFormat {
        let (hz, bits) = (SAMPLES_HZ / self.every as f64, 32 + 16 * (self.words - 1));
        let mut text = format!(
            "bit_rate = {}\nwords = {}\nword_bits = 16\n[sync]\npattern = 0xFE6B_2840\nbits = 32\n",
            hz * f64::from(bits),
            self.words
        );
        for (number, word) in (1..).zip(self.channels()) {
            text += &format!(
                "[[parameter]]\nname = \"{}\"\nword = {number}\nencoding = \"twos_complement\"\n\
                 calibration = {{ kind = \"polynomial\", coefficients = [0.0, {:e}] }}\n",
                word.channel.name(Default::default()),
                word.span / 32768.0
            );
        }
        PcmFormat::from_toml(&text).unwrap()
    }

    fn instants(self, samples: &[Sample]) -> impl Iterator<Item = &Sample> {
        samples.iter().skip(self.first).step_by(self.every)
    }

    fn packets(self, samples: &[Sample], first_rtc: u64) -> Vec<Vec<u8>> {
        let (mut encoder, channels) = (PcmEncoder::new(&self.format(), 0.0).unwrap(), self.channels());
        let frame = |sample: &Sample| {
            let mut frame = Vec::new();
            encoder.minor_frame(|parameter, _| sample.get(channels[parameter].channel).unwrap(), &mut frame).unwrap();
            frame
        };
        let frames: Vec<Vec<u8>> = self.instants(samples).map(frame).collect();
        let frame_ticks = TICKS * self.every as f64;
        Recorder { channel: self.number, storage: Storage::Packed, first_rtc, frame_ticks, in_packet: 16 }.packets(&frames)
    }

    /// The setup of the channel as the n-th link of a recorder.
    fn setup(self, nth: u32) -> String {
        let unit = |name: &str| in_setup_words(Channel::from_name(name).unwrap().0.si_unit());
        let text = setup(self.number, &self.format(), Storage::Packed, unit);
        if nth == 1 {
            return text;
        }
        // Other numbers for the source, the link, its measurements and their conversions.
        let text = text.split_once("R-1\\TK1-2").unwrap().1;
        let text = format!("R-1\\TK1-3{text}").replace("R-1\\CDT-2", "R-1\\CDT-3").replace("R-1\\CDLN-2", "R-1\\CDLN-3");
        let text = text.replace("R-1\\PDP-2", "R-1\\PDP-3").replace("LINK", "SECOND").replace("P-1\\", "P-2\\");
        text.replace("D-1\\", "D-2\\").replace("C-", "C-9")
    }
}

/// What was measured, at its times, and the derivatives by it.
fn measured(samples: &[Sample]) -> Vec<Sample> {
    let mut all = Vec::new();
    for (k, sample) in samples.iter().enumerate() {
        let mut kept = Sample::new(sample.time_s);
        for part in [MOTION, AIR].into_iter().filter(|part| k >= part.first && (k - part.first) % part.every == 0) {
            part.channels().iter().for_each(|word| kept.set(word.channel, sample.get(word.channel).unwrap()));
        }
        all.extend((kept.present != 0).then_some(kept));
    }
    all
}

fn merged(call: &[&str], out: &Path, samples: &[Sample]) {
    let (status, _, said) = ended(&sideslip(&[&["convert"], call, &["--force"]].concat()));
    assert_eq!(status, 0, "{said}");
    let mut recording = Recording::open(out).unwrap();
    let mut found = Vec::new();
    while let Some(row) = recording.next_row().unwrap() {
        found.push(row.sample);
    }
    assert!(found.is_sorted_by(|one, other| one.time_s < other.time_s));
    for part in [MOTION, AIR] {
        for word in part.channels() {
            let own = found.iter().filter_map(|sample| Some((sample.time_s, sample.get(word.channel)?)));
            let own: Vec<(f64, f64)> = own.collect();
            assert_eq!(own.len(), part.instants(samples).count(), "{:?}", word.channel);
            for ((time_s, value), sent) in own.iter().zip(part.instants(samples)) {
                assert!((value - sent.get(word.channel).unwrap()).abs() <= word.span / 32768.0, "{:?} at {time_s}", word.channel);
                assert!((-2e-7..0.6e-3).contains(&(time_s - sent.time_s)), "{:?}: {time_s} {}", word.channel, sent.time_s);
            }
        }
    }
    let apart = apart(&derivatives(&measured(samples)), &derivatives(&found));
    eprintln!("{apart:?}");
    assert!(apart.compared > 12 && apart.largest <= 0.1 && apart.different.is_empty(), "{apart:?}");
}

#[test]
fn two_pcm_channels_of_one_recording_and_two_recordings_are_one_flight() {
    let folder = folder("chapter10-merge");
    let samples = flown(11);
    let file = |name: &str| folder.join(name);
    let [both, out] = [file("both.ch10"), file("both.csv")];
    // One recording: packets of both channels as they come, one setup, one counter.
    let air_rtc = FIRST_RTC + (AIR.first as f64 * TICKS).round() as u64;
    let air_start = AIR.first / (MOTION.every * 16);
    let mut packets = vec![setup_packet(&(MOTION.setup(1) + &AIR.setup(2))), time_packet(0, FIRST_RTC, 0)];
    let mut air = AIR.packets(&samples, air_rtc).into_iter();
    for (k, packet) in MOTION.packets(&samples, FIRST_RTC).into_iter().enumerate() {
        packets.push(packet);
        if k >= air_start && (k - air_start).is_multiple_of(2) {
            packets.extend(air.next());
        }
    }
    packets.extend(air);
    std::fs::write(&both, packets.concat()).unwrap();
    let maps = [MOTION, AIR].map(|part| {
        let map = file(&format!("{}.toml", part.number));
        std::fs::write(&map, format!("channel = {}\n[measurements]\n[run]\naircraft = \"Puma\"\n", part.number)).unwrap();
        format!("ch10+file://{}?format={}", path(&both), path(&map))
    });
    merged(&[&maps[0], path(&out), "--merge", &maps[1], "--clock-offset", "0"], &out, &samples);

    // Two recordings, the second by a recorder with another count, whose clock begins with its first packet.
    let [one, other] = [file("motion.ch10"), file("air.ch10")];
    for (file, part, first_rtc) in [(&one, MOTION, FIRST_RTC), (&other, AIR, 12_345_678)] {
        let mut packets = vec![setup_packet(&part.setup(1)), time_packet(0, first_rtc, 0)];
        packets.extend(part.packets(&samples, first_rtc));
        std::fs::write(file, packets.concat()).unwrap();
    }
    let offset = (AIR.first as f64 * TICKS * 1e-7).to_string();
    merged(&[path(&one), path(&out), "--merge", path(&other), "--clock-offset", &offset], &out, &samples);
}
