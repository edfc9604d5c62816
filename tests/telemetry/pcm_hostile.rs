//! Whatever comes in: no panic, no endless loop, no unbounded memory.

use super::line::{Random, format, sent};
use sideslip::io::telemetry::pcm::decoder::PcmDecoder;
use sideslip::io::telemetry::pcm::format::{
    CountDirection, FrameSet, ParameterPlace, ParameterSpec, PcmFormatSpec, SpecialWord, SubframeId, WordPart,
};
use sideslip::io::telemetry::pcm::layout::PcmFormat;
use sideslip::io::telemetry::pcm::sync_pattern::{SyncPattern, SyncRules};

const TEXT: &str = "bit_rate = 2e6\nwords = 9\nword_bits = 16\nparity = \"odd\"\nminor_frames = 4\n[sync]\npattern = 0xFE6B2840\n\
    bits = 32\nmask = 0xFFFFFFFF\n[subframe_id]\nword = 1\nfirst_value = 3\ncounts = \"down\"\n[[word]]\nnumber = 2\nbits = 12\n\
    [[parameter]]\nname = \"p\"\nword = 2\nword_interval = 3\nencoding = \"twos_complement\"\n\
    calibration = { kind = \"polynomial\", coefficients = [0, 1e-3], range = [-9, 9], outside = \"flag\" }\n\
    [[parameter]]\nname = \"q\"\nparts = [{ word = 4 }, { word = 5, bits = [1, 8] }]\nframe = 2\nlimits = { low = 1 }\n";

#[test]
fn changed_format_files_are_read_or_refused() {
    PcmFormat::from_toml(TEXT).unwrap();
    let mut random = Random(71);
    let mut read = 0;
    let digits = b"0123456789-.eExXinf[]{}=\"\n, ";
    for _ in 0..20_000 {
        let mut text = TEXT.as_bytes().to_vec();
        for _ in 0..1 + random.below(4) {
            let place = random.below(text.len());
            match random.below(3) {
                0 => text[place] = digits[random.below(digits.len())],
                1 => drop(text.remove(place)),
                _ => text.insert(place, digits[random.below(digits.len())]),
            }
        }
        if let Ok(format) = PcmFormat::from_toml(&String::from_utf8_lossy(&text)) {
            read += 1;
            let mut decoder = PcmDecoder::new(&format, f64::NAN);
            let bytes: Vec<u8> = (0..100).map(|_| random.next() as u8).collect();
            decoder.feed(&bytes, |_| {});
            decoder.finish(|_| {});
        }
    }
    assert!(read > 500, "{read}");
}

#[test]
fn descriptions_with_any_numbers_are_refused_or_work() {
    let mut random = Random(72);
    let mut made = 0;
    for _ in 0..100_000 {
        let mut number = |usual: u32| match random.below(12) {
            0 => 0,
            1 => u32::MAX,
            2 => random.next() as u32,
            3 => 1 + random.below(40) as u32,
            _ => usual,
        };
        let part = WordPart { word: number(2), bits: if number(0) == 1 { Some((number(1), number(8))) } else { None } };
        let place = ParameterPlace {
            parts: vec![part, WordPart { word: number(3), bits: None }],
            word_interval: Some(number(4)),
            frames: Some(FrameSet { first: number(1), interval: Some(number(2)) }),
        };
        let (bits, mask) = (number(32), u64::from(number(u32::MAX)));
        let spec = PcmFormatSpec {
            sync: SyncPattern { pattern: u64::from(number(0xFE6B_2840)), mask, bits },
            rules: Some(SyncRules {
                search_errors: number(1),
                check_errors: number(1),
                lock_errors: number(3),
                check_frames: number(2),
                flywheel_frames: number(3),
                slip_bits: number(2),
            }),
            words: number(20),
            word_bits: number(16),
            special_words: vec![SpecialWord { word: number(5), bits: Some(number(12)), parity: None }],
            minor_frames: number(8),
            subframe_id: Some(SubframeId {
                part: WordPart { word: number(1), bits: None },
                first_value: number(0),
                direction: CountDirection::Up,
            }),
            parameters: vec![ParameterSpec { name: "p".into(), places: vec![place], ..ParameterSpec::default() }],
            ..PcmFormatSpec::default()
        };
        if let Ok(format) = PcmFormat::new(spec) {
            made += 1;
            if made % 50 == 0 {
                let sent = sent_zeros(&format);
                let mut decoder = PcmDecoder::new(&format, 0.0);
                decoder.feed(&sent, |_| {});
                decoder.finish(|_| {});
            }
        }
    }
    assert!(made > 100, "{made}");
}

fn sent_zeros(format: &PcmFormat) -> Vec<u8> {
    let mut encoder = sideslip::io::telemetry::pcm::encoder::PcmEncoder::new(format, 0.0).unwrap();
    let mut line = Vec::new();
    for _ in 0..40 {
        encoder.minor_frame(|_, _| 0.0, &mut line).unwrap();
    }
    line
}

#[test]
fn samples_are_the_same_in_any_pieces() {
    let format = format("rnrz_l", "odd");
    let mut random = Random(73);
    let mut line = sent(&format, 300, false, &mut random).line;
    for _ in 0..2000 {
        let place = random.below(line.len());
        line[place] ^= 1 << random.below(8);
    }
    line.drain(5000..5001);
    let run = |most: usize, seed: u64| {
        let mut random = Random(seed);
        let mut decoder = PcmDecoder::new(&format, 3.0);
        let mut samples = Vec::new();
        let mut rest = line.as_slice();
        while !rest.is_empty() {
            let (piece, after) = rest.split_at(rest.len().min(1 + random.below(most)));
            decoder.feed(piece, |sample| samples.push(sample));
            rest = after;
        }
        decoder.finish(|sample| samples.push(sample));
        (samples, decoder.synchronizer.counters(), decoder.decommutator.counters())
    };
    let whole = run(1 << 20, 0);
    assert!(whole.0.len() > 5000);
    for (most, seed) in [(1, 1), (3, 2), (100, 3), (2000, 4), (50_000, 5)] {
        assert_eq!(run(most, seed), whole);
    }
}
