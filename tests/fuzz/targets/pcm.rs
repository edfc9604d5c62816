//! PCM: a stream of bits by several formats, and the files that describe formats.
//!
//! What a clean stream held is sent again and must be read again: raw numbers of integers bit for bit, other values but for
//! rounding.

use super::pieces;
use sideslip::io::telemetry::pcm::bits::LineCode;
use sideslip::io::telemetry::pcm::decoder::PcmDecoder;
use sideslip::io::telemetry::pcm::decommutator::PcmSample;
use sideslip::io::telemetry::pcm::encoder::PcmEncoder;
use sideslip::io::telemetry::pcm::frame_sync::SyncCounters;
use sideslip::io::telemetry::pcm::layout::PcmFormat;
use std::collections::BTreeMap;
use std::sync::OnceLock;

/// The formats of the stream: each line code, polarity, parity and kind of commutation, words of unlike lengths.
pub(crate) const FORMATS: [&str; 4] = [
    "bit_rate = 1e6\nwords = 5\nword_bits = 8\nminor_frames = 4\n[sync]\npattern = 0xEB90\nbits = 16\n[subframe_id]\nword = 1\n\
     bits = [7, 8]\n[[parameter]]\nname = \"p\"\nword = 2\n[[parameter]]\nname = \"q\"\nword = 3\nencoding = \"twos_complement\"\n\
     frame = 2\n[[parameter]]\nname = \"r\"\nword = 4\nframe = 1\nframe_interval = 2\n",
    "bit_rate = 2e6\nline_code = \"rnrz_l\"\nwords = 9\nword_bits = 16\nparity = \"odd\"\nminor_frames = 3\n[sync]\n\
     pattern = 0xFE6B2840\nbits = 32\nflywheel_frames = 2\n[subframe_id]\nword = 1\nfirst_value = 3\ncounts = \"down\"\n\
     [[word]]\nnumber = 2\nbits = 12\n[[parameter]]\nname = \"p\"\nword = 2\nword_interval = 3\nencoding = \"twos_complement\"\n\
     calibration = { kind = \"polynomial\", coefficients = [0, 1e-3], range = [-9, 9], outside = \"flag\" }\n\
     [[parameter]]\nname = \"q\"\nparts = [{ word = 4 }, { word = 6, bits = [1, 8] }]\nframe = 2\nlimits = { low = 1 }\n",
    "bit_rate = 1e5\npolarity = \"inverted\"\nwords = 4\nword_bits = 32\nparity = \"even\"\nparity_place = \"leading\"\n[sync]\n\
     pattern = 0xFAF320\nbits = 24\ncheck_frames = 1\nflywheel_frames = 0\nslip_bits = 0\n[[parameter]]\nname = \"p\"\nword = 1\n\
     bits = [1, 31]\n[[parameter]]\nname = \"q\"\nparts = [{ word = 2, bits = [1, 16] }, { word = 3, bits = [1, 16] }]\n\
     encoding = \"ieee754_single\"\n",
    "bit_rate = 8e3\nwords = 3\nword_bits = 5\n[sync]\npattern = 0x1\nbits = 17\nmask = 0x1FFFF\nslip_bits = 0\n[[parameter]]\n\
     name = \"p\"\nplaces = [{ word = 1 }, { word = 2, bits = [2, 5] }]\n",
];

/// Words that are sent of one format at most: the memory of the test itself stays below that of the parser.
const SENT_MOST: usize = 50_000;

fn formats() -> &'static [PcmFormat] {
    static MADE: OnceLock<Vec<PcmFormat>> = OnceLock::new();
    MADE.get_or_init(|| FORMATS.iter().map(|text| PcmFormat::from_toml(text).unwrap_or_else(|e| panic!("{e}\n{text}"))).collect())
}

/// The first byte says which format, the others are the line.
pub(super) fn stream(bytes: &[u8]) -> usize {
    let Some((choice, line)) = bytes.split_first() else { return 0 };
    let formats = formats();
    let format = &formats[usize::from(*choice) % formats.len()];
    let whole = read(format, std::iter::once(line));
    let cut = read(format, pieces(line));
    assert_eq!(whole.counters, cut.counters, "pieces change what is found");
    assert!(same(&whole.samples, &cut.samples), "pieces change the samples");
    assert_eq!(whole.counters.bits, 8 * line.len() as u64);
    // A frame that lock was lost behind may hold the start of another.
    let frames = 2 * whole.counters.bits / format.minor_frame_bits() as u64 + 1;
    assert!(whole.counters.minor_frames <= frames, "{:?}", whole.counters);
    sent_again(format, line);
    whole.samples.len()
}

/// A format as TOML; of one that can be, a stream is sent and read.
pub(super) fn format_file(bytes: &[u8]) -> usize {
    let Ok(format) = PcmFormat::from_toml(&String::from_utf8_lossy(bytes)) else { return 0 };
    let _ = read(&format, pieces(bytes));
    sent_again(&format, bytes)
}

struct Found {
    samples: Vec<PcmSample>,
    counters: SyncCounters,
}

impl Found {
    /// Whether the synchroniser had no doubt from the first bit to the last.
    fn is_clean(&self) -> bool {
        let of = self.counters;
        (of.candidates, of.locks) == (1, 1) && (of.losses, of.slips, of.missed_syncs, of.polarity_changes) == (0, 0, 0, 0)
    }
}

fn read<'a>(format: &PcmFormat, pieces: impl Iterator<Item = &'a [u8]>) -> Found {
    let (mut decoder, mut samples) = (PcmDecoder::new(format, 0.0), Vec::new());
    for piece in pieces {
        decoder.feed(piece, |sample| samples.push(sample));
    }
    decoder.finish(|sample| samples.push(sample));
    Found { samples, counters: decoder.synchronizer.counters() }
}

fn same(one: &[PcmSample], other: &[PcmSample]) -> bool {
    let key = |sample: &PcmSample| {
        let value = sample.value.map(|value| if value.is_nan() { u64::MAX } else { value.to_bits() });
        (sample.parameter, sample.time_s.to_bits(), sample.raw, value, sample.flags)
    };
    one.iter().map(key).eq(other.iter().map(key))
}

/// Sends words made of the bytes, reads them, sends what was read, and reads that.
fn sent_again(format: &PcmFormat, bytes: &[u8]) -> usize {
    let rules = format.rules();
    let frames = (rules.check_frames + 3).max(format.spec().minor_frames.min(20));
    let mut words = bytes.chunks(4).cycle().map(|chunk| chunk.iter().fold(0_u64, |word, byte| word << 8 | u64::from(*byte)));
    let Some(first) = sent(format, frames, |parameter, _| {
        let parameter = &format.parameters()[parameter];
        let (_, bits) = parameter.encoding.widths();
        let word = words.next().unwrap_or_default() & (u64::MAX >> (64 - bits.min(12)));
        let raw = parameter.encoding.decode(word, bits).unwrap_or_default();
        parameter.calibration.apply(raw).map_or(0.0, |calibrated| calibrated.value)
    }) else {
        return 0;
    };
    let key = |sample: &PcmSample| (sample.parameter, sample.time_s.to_bits());
    let values: BTreeMap<(usize, u64), Option<f64>> = first.samples.iter().map(|sample| (key(sample), sample.value)).collect();
    if values.len() < first.samples.len() {
        // Two places of a parameter that begin at the same bit: which of them a value is asked for cannot be told.
        return first.samples.len();
    }
    let value = |parameter, time_s: f64| values.get(&(parameter, time_s.to_bits())).copied().flatten().unwrap_or_default();
    let Some(second) = sent(format, frames, value) else { return 0 };
    if !(first.is_clean() && second.is_clean()) {
        return 0;
    }
    assert_eq!(first.samples.len(), second.samples.len(), "samples are lost");
    for (one, other) in first.samples.iter().zip(&second.samples) {
        assert_eq!(key(one), key(other));
        let (Some(value), Some(again)) = (one.value, other.value) else { continue };
        let near = (value - again).abs() <= 1e-6 * value.abs().max(again.abs());
        assert!(near || one.raw == other.raw, "{one:?} sent again is {other:?}");
    }
    second.samples.len()
}

fn sent(format: &PcmFormat, frames: u32, mut value: impl FnMut(usize, f64) -> f64) -> Option<Found> {
    let mut encoder = PcmEncoder::new(format, 0.0).ok()?;
    let (mut line, mut asked) = (Vec::new(), 0);
    for _ in 0..frames {
        let counted = |parameter, time_s| {
            asked += 1;
            value(parameter, time_s)
        };
        encoder.minor_frame(counted, &mut line).ok()?;
        if asked > SENT_MOST {
            return None;
        }
    }
    encoder.finish(&mut line);
    if format.spec().line_code == LineCode::NrzL {
        assert!(line.len() as u64 * 8 >= encoder.bit());
    }
    let found = read(format, std::iter::once(&line[..]));
    assert!(!found.is_clean() || found.samples.len() <= asked, "more samples than were sent");
    Some(found)
}
