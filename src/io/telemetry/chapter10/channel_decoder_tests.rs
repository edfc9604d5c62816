//! Packets made by hand: each mode, cells of either size, inverted frames, times of either kind.

use super::super::header::PacketLimits;
use super::super::packet::Chapter10Reader;
use super::super::packet_test::packet;
use super::*;

/// Two words of 12 bits behind a pattern of 24, 1000 frames a second.
fn format() -> PcmFormat {
    let text = "bit_rate = 48_000\nwords = 3\nword_bits = 12\n[sync]\npattern = 0xFA_F320\nbits = 24\nlock_errors = 1\n\
        [[parameter]]\nname = \"p\"\nword = 1\n[[parameter]]\nname = \"q\"\nword = 2\n";
    PcmFormat::from_toml(text).unwrap()
}

/// Bytes whose first bit came first, as 16-bit little-endian words, or 32-bit ones.
fn stored(bytes: &[u8], alignment: usize) -> Vec<u8> {
    let mut padded = bytes.to_vec();
    padded.resize(bytes.len().next_multiple_of(alignment), 0);
    padded.chunks(alignment).flat_map(|word| word.iter().rev().copied().collect::<Vec<_>>()).collect()
}

fn iph(rtc: u64, alignment: usize, lock: u16) -> Vec<u8> {
    let mut bytes = rtc.to_le_bytes()[..6].to_vec();
    bytes.extend([0, 0]);
    bytes.extend(lock.to_le_bytes());
    bytes.resize(if alignment == 4 { 12 } else { 10 }, 0);
    bytes
}

/// Parameter, time in tenths of a microsecond, raw bits and flags of each sample.
fn samples(packets: &[Vec<u8>]) -> (Vec<(usize, i64, u64, SampleFlags)>, ChannelTally) {
    let (mut reader, mut decoder) = (Chapter10Reader::new(PacketLimits::default()), ChannelDecoder::new(&format()).unwrap());
    let mut found = Vec::new();
    let mut each =
        |sample: PcmSample| found.push((sample.parameter, (sample.time_s * 1e7).round() as i64, sample.raw, sample.flags));
    reader.take(&packets.concat());
    while let Some(packet) = reader.finish() {
        decoder.packet(&packet, &mut each);
    }
    decoder.finish(&mut each);
    (found, decoder.tally())
}

use crate::io::telemetry::pcm::decommutator::SampleFlags;

/// Where the two words stand: 24 and 36 bits of 48,000 a second behind the frame, 100 ns.
const WORDS: [i64; 2] = [5000, 7500];
const FRAME: [u8; 6] = [0xFA, 0xF3, 0x20, 0xAB, 0xC1, 0x23];

fn expected(frames: &[(i64, SampleFlags)]) -> Vec<(usize, i64, u64, SampleFlags)> {
    let words = [(0, WORDS[0], 0xABC), (1, WORDS[1], 0x123)];
    frames.iter().flat_map(|(at, flags)| words.map(|(parameter, by, raw)| (parameter, at + by, raw, *flags))).collect()
}

#[test]
fn packed_and_unpacked_frames_of_any_cell_are_read_at_the_time_of_their_headers() {
    let unpacked_16 = [0xFA, 0xF3, 0x20, 0, 0xAB, 0xC0, 0x12, 0x30];
    let unpacked_32 = [0xFA, 0xF3, 0x20, 0, 0xAB, 0xC0, 0, 0, 0x12, 0x30, 0, 0];
    for (word, alignment, frame) in [
        (0x4008_0000_u32, 2, &FRAME[..]),
        (0x4028_0000, 4, &FRAME),
        (0x4004_0000, 2, &unpacked_16),
        (0x4024_0000, 4, &unpacked_16),
        (0x4024_0000, 4, &unpacked_32),
    ] {
        let mut body = word.to_le_bytes().to_vec();
        for rtc in [1_000_000, 1_010_000, 1_020_001] {
            body.extend(iph(rtc, alignment, 0xF000));
            body.extend(stored(frame, alignment));
        }
        let (found, tally) = samples(&[packet(3, 9, 0, 1_000_000, &body, 2)]);
        assert_eq!(
            found,
            expected(&[(0, SampleFlags::NONE), (10_000, SampleFlags::NONE), (20_001, SampleFlags::NONE)]),
            "{word:X}"
        );
        assert_eq!((tally.packets, tally.minor_frames, tally.unreadable, tally.doubtful), (1, 3, 0, 0));
    }
}

#[test]
fn inverted_frames_are_turned_and_frames_without_pattern_are_doubtful() {
    let inverted: Vec<u8> = FRAME.iter().map(|byte| !byte).collect();
    let mut body = 0x4008_0000_u32.to_le_bytes().to_vec();
    for (rtc, frame, lock) in
        [(0, inverted.as_slice(), 0xF000), (10_000, &FRAME, 0x8000), (20_000, &[1, 2, 3, 0xAB, 0xC1, 0x23], 0xF000)]
    {
        body.extend(iph(rtc, 2, lock));
        body.extend(stored(frame, 2));
    }
    let (found, tally) = samples(&[packet(3, 9, 0, 0, &body, 2)]);
    let doubtful = SampleFlags::DOUBTFUL_FRAME;
    assert_eq!(found, expected(&[(0, SampleFlags::NONE), (10_000, doubtful), (20_000, doubtful)]));
    assert_eq!(tally.doubtful, 2);
    // A body that is no whole number of such frames.
    body.truncate(body.len() - 2);
    let (found, tally) = samples(&[packet(3, 9, 0, 0, &body, 2)]);
    assert!(found.is_empty() && matches!(tally.first_unreadable, Some(Chapter10Error::PcmRest { .. })), "{tally:?}");
}

#[test]
fn frames_of_throughput_mode_have_the_time_of_their_packet_and_a_missing_packet_is_a_gap() {
    // 12 frames of 48 bits in packets of 8 words, with the clock of the recorder 10 us behind the bit rate in each packet.
    let bytes: Vec<u8> = FRAME.repeat(12);
    let packets: Vec<Vec<u8>> = (0..)
        .zip(bytes.chunks(16))
        .map(|(k, part)| {
            let body = [&0x0010_0000_u32.to_le_bytes()[..], &stored(part, 2)].concat();
            // 128 bits last 2 2/3 ms.
            packet(3, 9, k, 26_667 * u64::from(k) + 100 * u64::from(k), &body, 2)
        })
        .collect();
    let (found, tally) = samples(&packets);
    let time = |frame: i64| {
        let packet = frame * 48 / 128;
        packet * 26_767 + (frame * 48 - packet * 128) * 10_000_000 / 48_000
    };
    let all: Vec<(i64, SampleFlags)> = (0..12).map(|frame| (time(frame), SampleFlags::NONE)).collect();
    let close = |found: &[(usize, i64, u64, SampleFlags)], wanted: &[(usize, i64, u64, SampleFlags)]| {
        assert_eq!(found.len(), wanted.len(), "{found:?}");
        for (one, other) in found.iter().zip(wanted) {
            assert!((one.1 - other.1).abs() <= 1 && (one.0, one.2, one.3) == (other.0, other.2, other.3), "{one:?} {other:?}");
        }
    };
    close(&found, &expected(&all));
    assert_eq!((tally.minor_frames, tally.missing), (12, 0));
    let mut lossy = packets;
    lossy.remove(2);
    let (found, tally) = samples(&lossy);
    // Packet 2 holds bits 256 to 383: of frames 5 (from 240), 6 and 7 (to 384); a search behind it begins with frame 8.
    let left: Vec<(i64, SampleFlags)> =
        all.iter().copied().enumerate().filter(|(k, _)| !(5..8).contains(k)).map(|(_, one)| one).collect();
    close(&found, &expected(&left));
    assert_eq!((tally.missing, tally.packets), (1, 4));
}
