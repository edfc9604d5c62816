//! Rows out of the real recordings: their setups name no measurement, which is said; with a format of the frames their words
//! come out as the recordings are known to hold them (`chapter10.rs` has the independent reading).

use crate::support::program::{data, ended, folder, path, sideslip};
use sideslip::io::telemetry::chapter10::channel_choice::FrameDescription;
use sideslip::io::telemetry::recording::Recording;
use std::fmt::Write;
use std::path::Path;

/// Whole words of 16 bits behind a pattern of 32.
fn frames(channel: u16, bit_rate: u64, words: u32, pattern: u32) -> FrameDescription {
    let mut text = format!(
        "channel = {channel}\nbit_rate = {bit_rate}\nwords = {}\nword_bits = 16\n[sync]\npattern = {pattern}\nbits = 32\n",
        words + 1
    );
    for word in 1..=words {
        let _ = write!(text, "[[parameter]]\nname = \"w{word}\"\nword = {word}\n");
    }
    FrameDescription::from_toml(&text).unwrap()
}

/// Times and the words of each row.
fn rows(file: &Path, frames: &FrameDescription) -> (Vec<f64>, Vec<Vec<u64>>, Option<String>) {
    let mut recording = Recording::open_chapter10(file, frames).unwrap();
    let (mut times, mut words) = (Vec::new(), Vec::new());
    while let Some(row) = recording.next_row().unwrap() {
        times.push(row.sample.time_s);
        words.push(row.others.iter().map(|word| word.map_or(u64::MAX, |word| word as u64)).collect());
    }
    (times, words, recording.shortfall())
}

#[test]
fn without_measurements_in_the_setup_it_is_said_what_there_is_and_what_to_do() {
    for (name, expected) in [
        ("err.c10", "PCM channel 10"),
        ("pcm.c10", "PCM channel 52 (METS231 Pattern1)"),
        ("pcm_old_101348.c10", "PCM channel 10"),
    ] {
        let Some(file) = data("irig106", name) else { return };
        let said = Recording::open(&file).unwrap_err().to_string();
        eprintln!("{said}");
        assert!(said.contains(expected) && said.contains("--config FILE"), "{said}");
        let (status, out, said) = ended(&sideslip(&["replay", path(&file)]));
        assert_eq!((status, out.len(), said.lines().count()), (2, 0, 1), "{said}");
    }
}

#[test]
fn with_a_format_the_words_are_those_of_the_recording() {
    let (Some(pcm), Some(err)) = (data("irig106", "pcm.c10"), data("irig106", "err.c10")) else { return };
    for channel in [55, 56] {
        let (times, words, shortfall) = rows(&pcm, &frames(channel, 10_000_000, 30, 0xFE6B_2840));
        assert_eq!((words.len(), shortfall), (884, None), "channel {channel}");
        let rises = |word: usize| words.windows(2).all(|pair| pair[1][word] == (pair[0][word] + 1) % 65_536);
        assert!((0..30).any(rises), "channel {channel}: a word counts the frames");
        // 512 bits at 10 Mbit/s.
        assert!(times.windows(2).all(|pair| (pair[1] - pair[0] - 51.2e-6).abs() < 0.11e-6), "channel {channel}");
    }
    // Throughput mode: 511 frames and the last, behind which no pattern stands.
    let (times, words, shortfall) = rows(&pcm, &frames(52, 10_000_000, 30, 0xFE6B_2840));
    assert!((511..=512).contains(&words.len()), "{} {shortfall:?}", words.len());
    eprintln!("channel 52: {} rows in {} s, {shortfall:?}", words.len(), times[times.len() - 1] - times[0]);
    let (times, words, shortfall) = rows(&err, &frames(10, 1_666_666, 12, 0x1F74_E949));
    assert_eq!(words.len(), 9792);
    assert!(words.windows(2).all(|pair| pair[1][0] == pair[0][0] % 4 + 1));
    let rate = 9791.0 / (times[9791] - times[0]);
    assert!((rate - 1_666_666.0 / 224.0).abs() < 0.05, "{rate}");
    assert!(shortfall.clone().unwrap().contains("2532 bytes that belong to no packet"), "{shortfall:?}");
}

#[test]
fn the_program_reads_a_real_recording_with_a_format() {
    let Some(file) = data("irig106", "pcm.c10") else { return };
    let folder = folder("chapter10-real");
    let (format, csv) = (folder.join("frame.toml"), folder.join("out.csv"));
    let text = "channel = 55\nbit_rate = 10_000_000\nwords = 31\nword_bits = 16\n[sync]\npattern = 0xFE6B_2840\nbits = 32\n\
        [[parameter]]\nname = \"w1\"\nword = 1\n";
    std::fs::write(&format, text).unwrap();
    for args in [
        &["convert", path(&file), path(&csv), "--config", path(&format)][..],
        &["convert", &format!("ch10+file://{}?format={}", path(&file), path(&format)), path(&csv), "--force"],
    ] {
        let (status, _, said) = ended(&sideslip(args));
        assert_eq!(status, 0, "{said}");
        assert!(said.contains("884 samples") || said.contains("samples"), "{said}");
    }
}
