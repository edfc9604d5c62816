//! Decommutation of PCM: a stream of 16-bit words, times for `compare.py`, and its cost live.
//!
//! Without an argument it prints, a line each: words a second of the stream by the decoder (synchroniser and decommutator, in
//! pieces of 1000 bytes), of a Chapter 10 recording of the same minor frames by its reader, the sums of all words, and the busy
//! fraction of 128 Ki words a second that come every 5 ms in real time, by processor time of this thread. With a path it writes
//! that recording and ends. `--live SECONDS` says for how long the stream comes live; 5 without it.

#![expect(clippy::unwrap_used, clippy::print_stdout, reason = "a benchmark stops where its data are wrong, and prints")]

#[path = "../../support/processor_clock.rs"]
mod processor_clock;

use processor_clock::Clock;
use sideslip::io::telemetry::chapter10::header::data_type;
use sideslip::io::telemetry::chapter10::packet::{BLOCK, Chapter10Reader};
use sideslip::io::telemetry::chapter10::pcm_data::PcmPacket;
use sideslip::io::telemetry::chapter10::pcm_layout::{PcmLayout, UnpackedForm};
use sideslip::io::telemetry::pcm::decoder::PcmDecoder;
use sideslip::io::telemetry::pcm::encoder::PcmEncoder;
use sideslip::io::telemetry::pcm::layout::PcmFormat;
use std::hint::black_box;
use std::time::{Duration, Instant};

/// Words behind the pattern of 32 bits.
const WORDS: u32 = 64;
/// Minor frames of the stream.
const FRAMES: usize = 4096;
/// Minor frames of a packet, and the recording's channel.
const PACKET_FRAMES: usize = 128;
const CHANNEL: u16 = 7;
/// Words a second of the live stream.
const LIVE_WORDS: f64 = 131_072.0;
const PERIOD: Duration = Duration::from_millis(5);
/// Measurements, and passes of each: the kernel counts processor time in steps of milliseconds.
const REPEATS: usize = 9;
const PASSES: usize = 100;

fn format() -> PcmFormat {
    let frames_hz = LIVE_WORDS / f64::from(WORDS);
    let mut text = format!(
        "bit_rate = {:?}\nwords = {}\nword_bits = 16\n[sync]\npattern = 0xFE6B_2840\nbits = 32\n",
        frames_hz * f64::from(32 + 16 * WORDS),
        WORDS + 1
    );
    for word in 1..=WORDS {
        text += &format!("[[parameter]]\nname = \"w{word}\"\nword = {word}\n");
        text += "calibration = { kind = \"polynomial\", coefficients = [-10.0, 0.001] }\nlimits = { low = -9.9, high = 60.0 }\n";
    }
    PcmFormat::from_toml(&text).unwrap()
}

/// The bytes of the line; words of a linear congruential generator.
fn line(format: &PcmFormat) -> Vec<u8> {
    let mut encoder = PcmEncoder::new(format, 0.0).unwrap();
    let (mut line, mut state) = (Vec::new(), 5_u64);
    for _ in 0..FRAMES {
        let value = |_, _| {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            -10.0 + 0.001 * ((state >> 48) as f64)
        };
        encoder.minor_frame(value, &mut line).unwrap();
    }
    encoder.finish(&mut line);
    line
}

/// Those minor frames in packets of PCM format 1, packed, 16-bit alignment, an intra-packet header each.
fn recording(line: &[u8]) -> Vec<u8> {
    let frame_bytes = line.len() / FRAMES;
    let (mut file, mut frame_number) = (Vec::new(), 0_u64);
    for (sequence, frames) in line.chunks(frame_bytes * PACKET_FRAMES).enumerate() {
        // Packed, a minor frame first, headers.
        let mut body = (1_u32 << 19 | 0xF << 24 | 1 << 28 | 1 << 30).to_le_bytes().to_vec();
        for frame in frames.chunks(frame_bytes) {
            body.extend((frame_number * 4883).to_le_bytes());
            body.extend(0xF000_u16.to_le_bytes());
            body.extend(frame.chunks(2).flat_map(|word| [word[1], word[0]]));
            frame_number += 1;
        }
        let filler = body.len().next_multiple_of(4) - body.len();
        let mut header = vec![0x25, 0xEB];
        header.extend(CHANNEL.to_le_bytes());
        header.extend(u32::try_from(24 + body.len() + filler).unwrap().to_le_bytes());
        header.extend(u32::try_from(body.len()).unwrap().to_le_bytes());
        header.extend([3, sequence as u8, 0, data_type::PCM_1]);
        header.extend(&(frame_number * 4883).to_le_bytes()[..6]);
        let sum: u32 = header.chunks(2).map(|word| u32::from(word[0]) + 256 * u32::from(word[1])).sum();
        header.extend((sum as u16).to_le_bytes());
        file.extend(header);
        file.extend(body);
        file.extend(vec![0; filler]);
    }
    file
}

/// Samples and the sum of their raw words.
fn by_stream(format: &PcmFormat, line: &[u8]) -> (u64, u64) {
    let (mut decoder, mut count, mut sum, mut values) = (PcmDecoder::new(format, 0.0), 0, 0, 0.0);
    let mut each = |sample: sideslip::io::telemetry::pcm::decommutator::PcmSample| {
        count += 1;
        sum += sample.raw;
        values += sample.value.unwrap_or_default();
    };
    line.chunks(1000).for_each(|bytes| decoder.feed(bytes, &mut each));
    decoder.finish(&mut each);
    black_box(values);
    (count, sum)
}

/// The same of the recording.
fn by_recording(file: &[u8]) -> (u64, u64) {
    let layout = PcmLayout::uniform(32, 16, WORDS).unwrap();
    let (mut reader, mut scratch, mut count, mut sum) = (Chapter10Reader::default(), Vec::new(), 0, 0);
    let mut each = |packet: &sideslip::io::telemetry::chapter10::packet::Chapter10Packet<'_>| {
        let pcm = PcmPacket::parse(packet).unwrap();
        let map = layout.map(pcm.word.mode, pcm.word.alignment, UnpackedForm::default()).unwrap();
        for frame in pcm.frames(&map, &mut scratch).unwrap() {
            count += map.words().len() as u64;
            sum += frame.words().sum::<u64>();
        }
    };
    // In blocks, as files are read.
    for mut rest in file.chunks(BLOCK) {
        while !rest.is_empty() {
            rest = &rest[reader.take(rest)..];
            while let Some(packet) = reader.next_packet() {
                each(&packet);
            }
        }
    }
    while let Some(packet) = reader.finish() {
        each(&packet);
    }
    (count, sum)
}

/// Words a second, by the median of processor times.
fn rate(mut once: impl FnMut() -> (u64, u64)) -> f64 {
    let clock = Clock::new();
    let mut times: Vec<f64> = (0..REPEATS)
        .map(|_| {
            let begin = clock.seconds();
            (0..PASSES).for_each(|_| {
                black_box(once());
            });
            clock.seconds() - begin
        })
        .collect();
    times.sort_by(f64::total_cmp);
    (PASSES * FRAMES * WORDS as usize) as f64 / times[REPEATS / 2]
}

/// Fraction of a processor that the stream takes while it comes, and words a second that came out.
fn live(format: &PcmFormat, line: &[u8], seconds: f64) -> (f64, f64) {
    let bytes_a_period = (format.spec().bit_rate / 8.0 * PERIOD.as_secs_f64()).round() as usize;
    let mut pieces = line.chunks(bytes_a_period).cycle();
    let (mut decoder, mut count, mut values) = (PcmDecoder::new(format, 0.0), 0_u64, 0.0);
    let (clock, wall) = (Clock::new(), Instant::now());
    let begin = clock.seconds();
    let mut due = PERIOD;
    while wall.elapsed().as_secs_f64() < seconds {
        if let Some(wait) = due.checked_sub(wall.elapsed()) {
            std::thread::sleep(wait);
        }
        due += PERIOD;
        decoder.feed(pieces.next().unwrap(), |sample| {
            count += 1;
            values += sample.value.unwrap_or_default();
        });
    }
    let (busy, elapsed) = (clock.seconds() - begin, wall.elapsed().as_secs_f64());
    black_box(values);
    (busy / elapsed, count as f64 / elapsed)
}

fn main() {
    let arguments: Vec<String> = std::env::args().skip(1).filter(|argument| argument != "--bench").collect();
    let format = format();
    let line = line(&format);
    let file = recording(&line);
    if let Some(path) = arguments.first().filter(|argument| !argument.starts_with("--")) {
        std::fs::write(path, &file).unwrap();
        return;
    }
    let seconds = arguments.iter().position(|argument| argument == "--live").map_or(5.0, |at| arguments[at + 1].parse().unwrap());
    let (stream, recorded) = (by_stream(&format, &line), by_recording(&file));
    println!("words {}", recorded.0);
    println!("sum {}", recorded.1);
    // The last minor frame has no pattern behind it; it is handed out all the same.
    println!("stream_words {}", stream.0);
    println!("stream_sum {}", stream.1);
    println!("stream_words_per_s {:.4e}", rate(|| by_stream(&format, &line)));
    println!("recording_words_per_s {:.4e}", rate(|| by_recording(&file)));
    let (busy, words) = live(&format, &line, seconds);
    println!("live_words_per_s {words:.0}");
    println!("live_busy_fraction {busy:.5}");
}
