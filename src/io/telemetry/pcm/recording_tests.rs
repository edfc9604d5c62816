//! A file written by the encoder, read as a recording.

use super::super::encoder::PcmEncoder;
use super::*;
use crate::flight::channel::Channel;

const FORMAT: &str = r#"
name = "test"
bit_rate = 100_000
words = 9
word_bits = 16
minor_frames = 2
[sync]
pattern = 0xFE6B_2840
bits = 32
[subframe_id]
word = 1
[[parameter]]
name = "p"
unit = "deg/s"
word = 2
word_interval = 4
encoding = "twos_complement"
calibration = { kind = "polynomial", coefficients = [0.0, 0.01] }
[[parameter]]
name = "tas"
unit = "kn"
word = 8
frame = 2
calibration = { kind = "polynomial", coefficients = [0.0, 0.01] }
[run]
aircraft = "Test"
vane_position_m = [1, 0, 0]
"#;

/// A file in the system's place for such, gone afterwards.
struct Scratch(PathBuf);

impl Scratch {
    fn with(name: &str, bytes: &[u8]) -> Self {
        let path = std::env::temp_dir().join(format!("sideslip-pcm-{}-{name}", std::process::id()));
        std::fs::write(&path, bytes).unwrap();
        Scratch(path)
    }
}

impl Drop for Scratch {
    fn drop(&mut self) {
        let _ = std::fs::remove_file(&self.0);
    }
}

#[test]
fn rows_have_the_times_of_their_words_and_the_values_that_were_sent() {
    let format = PcmFormatFile::from_toml(FORMAT).unwrap();
    let mut encoder = PcmEncoder::new(&format.format, 0.0).unwrap();
    let mut bytes = Vec::new();
    for _ in 0..40 {
        encoder.minor_frame(|parameter, time_s| if parameter == 0 { 100.0 * time_s } else { 90.0 }, &mut bytes).unwrap();
    }
    encoder.finish(&mut bytes);
    let file = Scratch::with("rows", &bytes);
    let mut recording = PcmRecording::open(&file.0, format).unwrap();
    assert_eq!((recording.info().aircraft(), recording.info().geometry().vane_position_m[0]), (Some("Test"), 1.0));
    let (mut p, mut tas, mut last_s) = (0, 0, f64::NEG_INFINITY);
    while let Some(row) = recording.next_row().unwrap() {
        assert!(row.sample.time_s > last_s);
        last_s = row.sample.time_s;
        if let Some(rate) = row.sample.get(Channel::P) {
            p += 1;
            // A quarter of a millisecond from its own time, and half a step of the word.
            assert!((rate.to_degrees() - 100.0 * last_s).abs() <= 0.025 + 0.005, "{rate} at {last_s}");
        }
        if let Some(speed) = row.sample.get(Channel::Tas) {
            tas += 1;
            assert!((speed * 3600.0 / 1852.0 - 90.0).abs() < 0.01);
        }
    }
    // Words 2 and 6 of 40 minor frames, word 8 of every other; the first word behind the pattern and one more.
    assert_eq!((p, tas), (80, 20));
    assert_eq!(recording.shortfall(), None);
}

#[test]
fn a_file_without_frames_is_an_error_that_says_what_was_expected() {
    let file = Scratch::with("none", &[0x55; 4096]);
    let mut recording = PcmRecording::open(&file.0, PcmFormatFile::from_toml(FORMAT).unwrap()).unwrap();
    let said = recording.next_row().unwrap_err().to_string();
    assert!(said.contains("sync pattern FE6B2840 (32 bits), found none in 32768 bits"), "{said}");
}

#[test]
fn words_without_the_parity_that_the_format_says_give_no_values() {
    let mut encoder = PcmEncoder::new(&PcmFormatFile::from_toml(FORMAT).unwrap().format, 0.0).unwrap();
    let mut bytes = Vec::new();
    for _ in 0..400 {
        encoder.minor_frame(|parameter, time_s| if parameter == 0 { 40.0 * time_s } else { 90.0 }, &mut bytes).unwrap();
    }
    encoder.finish(&mut bytes);
    let file = Scratch::with("parity", &bytes);
    let words = "[[word]]\nnumber = 2\nparity = \"odd\"\n[[word]]\nnumber = 6\nparity = \"odd\"\n[[parameter]]\nname = \"p\"";
    let format = PcmFormatFile::from_toml(&FORMAT.replacen("[[parameter]]\nname = \"p\"", words, 1)).unwrap();
    let mut recording = PcmRecording::open(&file.0, format).unwrap();
    let (mut p, mut tas) = (0, 0);
    while let Some(row) = recording.next_row().unwrap() {
        p += u32::from(row.sample.get(Channel::P).is_some());
        tas += u32::from(row.sample.get(Channel::Tas).is_some());
    }
    assert!(p <= 6 && tas == 200, "{p} {tas}");
    let said = recording.shortfall().unwrap();
    assert!(said.contains("of 800 words have wrong parity") && said.contains("or none"), "{said}");
}
