//! Real recordings against what is known of them: counts, words and bits as pychapter10 reads them
//! (`tests/pychapter10_words.py` prints the expected values), sync patterns as a slow search over text finds them.

use crate::support::program::data;
use sideslip::io::telemetry::chapter10::header::data_type;
use sideslip::io::telemetry::chapter10::packet::{Chapter10Packet, Chapter10Reader, PacketTally};
use sideslip::io::telemetry::chapter10::pcm_data::{BitTime, FrameLock, PcmMode, PcmPacket};
use sideslip::io::telemetry::chapter10::pcm_layout::{PcmLayout, UnpackedForm};
use sideslip::io::telemetry::chapter10::summary::RecordingSummary;
use sideslip::io::telemetry::chapter10::time::{DAY_NS, NS};
use sideslip::io::telemetry::chapter10::time_relation::{TimeRelation, TimeScale};
use std::collections::BTreeMap;

/// Bytes of a recording; `None`, said loudly, where it is absent.
pub(super) fn recording(name: &str) -> Option<Vec<u8>> {
    data("irig106", name).map(|file| std::fs::read(file).unwrap())
}

/// Hands every packet to `each`, fed in pieces of one size.
pub(super) fn read(bytes: &[u8], piece: usize, mut each: impl FnMut(&Chapter10Packet<'_>)) -> PacketTally {
    let mut reader = Chapter10Reader::default();
    for mut rest in bytes.chunks(piece) {
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
    reader.tally()
}

/// FNV-1a, 64 bits.
struct Digest(u64);

impl Digest {
    fn new() -> Self {
        Digest(0xCBF2_9CE4_8422_2325)
    }

    fn bytes(&mut self, bytes: &[u8]) {
        bytes.iter().for_each(|byte| self.0 = (self.0 ^ u64::from(*byte)).wrapping_mul(0x100_0000_01B3));
    }
}

/// Frames, digest and frame lock of a channel in unpacked or packed mode with 16-bit words.
fn words(bytes: &[u8], channel: u16, words: u32, piece: usize) -> (u64, u64, PcmMode, Vec<u64>) {
    let layout = PcmLayout::uniform(32, 16, words).unwrap();
    let (mut digest, mut frames, mut scratch, mut mode) = (Digest::new(), 0, Vec::new(), PcmMode::Throughput);
    let mut first_words = Vec::new();
    read(bytes, piece, |packet| {
        if packet.header.channel != channel || packet.header.data_type != data_type::PCM_1 {
            return;
        }
        let pcm = PcmPacket::parse(packet).unwrap();
        mode = pcm.word.mode;
        let map = layout.map(mode, pcm.word.alignment, UnpackedForm::default()).unwrap();
        for frame in pcm.frames(&map, &mut scratch).unwrap() {
            let BitTime::Rtc(rtc) = frame.time else { panic!("{:?}", frame.time) };
            assert_eq!((frame.lock.minor, frame.lock.major), (FrameLock::Lock, FrameLock::Lock));
            for value in [rtc, frame.sync()].into_iter().chain(frame.words()) {
                digest.bytes(&value.to_le_bytes());
            }
            first_words.push(frame.words().next().unwrap());
            frames += 1;
        }
    });
    (frames, digest.0, mode, first_words)
}

#[test]
fn minor_frames_agree_word_for_word_with_pychapter10() {
    let (Some(err), Some(pcm)) = (recording("err.c10"), recording("pcm.c10")) else { return };
    for piece in [usize::MAX, 1 << 16, 97] {
        let (frames, digest, mode, identifiers) = words(&err, 10, 12, piece.min(err.len()));
        assert_eq!((frames, digest, mode), (9792, 0xF6F9_FB49_3752_CCE9, PcmMode::Unpacked));
        assert!(identifiers.windows(2).all(|pair| pair[1] == pair[0] % 4 + 1));
        let (frames, digest, mode, counter) = words(&pcm, 55, 30, piece.min(pcm.len()));
        assert_eq!((frames, digest, mode), (884, 0xB6B6_CC26_ECD8_D394, PcmMode::Packed));
        assert!(counter.iter().all(|word| *word == 1));
        let (frames, digest, mode, _) = words(&pcm, 56, 30, piece.min(pcm.len()));
        assert_eq!((frames, digest, mode), (884, 0x27DE_D2D0_B2D4_3164, PcmMode::Unpacked));
    }
}

#[test]
fn the_counter_word_of_the_packed_and_the_unpacked_channel_rises_by_one_a_frame() {
    let Some(bytes) = recording("pcm.c10") else { return };
    for channel in [55, 56] {
        let layout = PcmLayout::uniform(32, 16, 30).unwrap();
        let mut columns: Vec<Vec<u64>> = vec![Vec::new(); 30];
        let mut times = Vec::new();
        read(&bytes, bytes.len(), |packet| {
            if packet.header.channel != channel {
                return;
            }
            let pcm = PcmPacket::parse(packet).unwrap();
            let map = layout.map(pcm.word.mode, pcm.word.alignment, UnpackedForm::default()).unwrap();
            for frame in pcm.frames(&map, &mut Vec::new()).unwrap() {
                assert_eq!(frame.sync(), 0xFE6B_2840);
                frame.words().zip(&mut columns).for_each(|(word, column)| column.push(word));
                if let BitTime::Rtc(rtc) = frame.time {
                    times.push(rtc);
                }
            }
        });
        let rises = |column: &Vec<u64>| column.windows(2).all(|pair| pair[1] == (pair[0] + 1) % 65536);
        assert!(columns.iter().any(rises), "channel {channel}");
        // 512 bits at 10 Mbit/s are 512 counts.
        assert!(times.windows(2).all(|pair| (511..=513).contains(&(pair[1] - pair[0]))), "channel {channel}");
    }
}

/// Bits of a channel in throughput mode.
fn stream(bytes: &[u8], channel: u16) -> Vec<u8> {
    let mut bits = Vec::new();
    read(bytes, 1 << 16, |packet| {
        if packet.header.channel == channel && packet.header.data_type == data_type::PCM_1 {
            assert_eq!(PcmPacket::parse(packet).unwrap().bits(&mut bits).rest_bytes, 0);
        }
    });
    bits
}

/// Places of a pattern, by comparing text.
fn slow_search(bits: &[u8], pattern: u32) -> (String, Vec<usize>) {
    let text: String = bits.iter().map(|byte| format!("{byte:08b}")).collect();
    let pattern = format!("{pattern:032b}");
    let places = (0..text.len()).filter(|at| text[*at..].starts_with(&pattern)).collect();
    (text, places)
}

#[test]
fn throughput_bits_agree_with_pychapter10_and_hold_the_known_frames() {
    let (Some(old), Some(pcm)) = (recording("pcm_old_101348.c10"), recording("pcm.c10")) else { return };
    let expected = [(&old, 10, 0x2C4C_23B6_4F64_55BD), (&old, 11, 0x2AF0_08DD_A545_DF58), (&pcm, 51, 0x5AB4_20C1_2B53_EFFB)];
    let more = [(&pcm, 52, 0xE2CE_1E98_86F2_8C2C), (&pcm, 53, 0xE1FE_0C23_1131_322F), (&pcm, 54, 0xFAB3_E2EA_DDFA_369A)];
    for (bytes, channel, expected) in expected.into_iter().chain(more) {
        let mut digest = Digest::new();
        digest.bytes(&stream(bytes, channel));
        assert_eq!(digest.0, expected, "channel {channel}");
    }
    for (channel, first) in [(10, 503), (11, 783)] {
        let (text, places) = slow_search(&stream(&old, channel), 0x1F74_E949);
        assert_eq!((places[0], places.len(), places[0] % 8), (first, 84, 7));
        assert!(places.windows(2).all(|pair| pair[1] - pair[0] == 4096));
        assert_eq!(places.iter().filter(|at| *at + 4096 <= text.len()).count(), 83);
        let identifier = |at: &usize| u32::from_str_radix(&text[at + 32..at + 48], 2).unwrap();
        let identifiers: Vec<u32> = places.iter().map(identifier).collect();
        assert!(identifiers.windows(2).all(|pair| pair[1] == pair[0] % 16 + 1), "channel {channel}");
    }
    let (_, places) = slow_search(&stream(&pcm, 52), 0xFE6B_2840);
    assert_eq!((places[0], places.len()), (393, 512));
    assert!(places.windows(2).all(|pair| pair[1] - pair[0] == 512));
    for channel in [51, 53, 54] {
        assert_eq!(slow_search(&stream(&pcm, channel), 0xFE6B_2840).1, Vec::<usize>::new());
    }
}

#[test]
fn every_packet_is_found_and_the_cut_one_is_told() {
    let count = |name: &str| {
        let bytes = recording(name)?;
        let (mut counts, mut summary) = (BTreeMap::new(), RecordingSummary::default());
        let mut relation = TimeRelation::default();
        let tally = read(&bytes, 4096, |packet| {
            *counts.entry((packet.header.channel, packet.header.data_type)).or_insert(0) += 1;
            relation.packet(packet).unwrap();
            summary.packet(packet);
        });
        println!("{name}\n{}\n", summary.table(&tally, &relation));
        Some((counts, tally))
    };
    let Some((err, tally)) = count("err.c10") else { return };
    let expected = [((0, 1), 1), ((1, 17), 2), ((2, 25), 25), ((3, 25), 24), ((4, 25), 24), ((5, 25), 42), ((6, 25), 43)];
    let more = [((7, 25), 35), ((8, 25), 15), ((9, 25), 15), ((10, 9), 24)];
    assert_eq!(err, expected.into_iter().chain(more).collect());
    // The setup record has a data checksum of 17BF where its words make 0979: its text was changed.
    assert_eq!((tally.packets, tally.damaged, tally.unprotected, tally.missing_packets), (250, 1, 0, 0));
    assert_eq!((tally.skipped_bytes, tally.cut_short, tally.first_cut), (2532, 1, Some((1_046_044, 3184, 2532))));
    let Some((pcm, tally)) = count("pcm.c10") else { return };
    assert_eq!((pcm.len(), tally.packets, tally.unprotected, tally.damaged, tally.skipped_bytes), (39, 53, 2, 0, 0));
    let Some((old, tally)) = count("pcm_old_101348.c10") else { return };
    assert_eq!(old, [((0, 1), 1), ((10, 9), 12), ((11, 9), 12)].into());
    assert_eq!((tally.packets, tally.unprotected, tally.skipped_bytes, tally.missing_packets), (25, 1, 0, 0));
}

#[test]
fn times_are_those_of_the_time_packets() {
    let Some(bytes) = recording("err.c10") else { return };
    let mut relation = TimeRelation::default();
    read(&bytes, bytes.len(), |packet| relation.packet(packet).unwrap());
    let tally = relation.tally();
    assert_eq!((tally.references, tally.disagreements, tally.largest_drift_ns), (2, 0, 1100));
    let first = relation.at(722_999_999_987).unwrap();
    assert_eq!((first.ns, first.scale), (131 * DAY_NS + (20 * 60 + 5) * 60 * NS, TimeScale::YearStart));
    // The frames of channel 10: 7,440 a second.
    let layout = PcmLayout::uniform(32, 16, 12).unwrap();
    let mut times = Vec::new();
    read(&bytes, bytes.len(), |packet| {
        if packet.header.channel == 10 {
            let pcm = PcmPacket::parse(packet).unwrap();
            let map = layout.map(pcm.word.mode, pcm.word.alignment, UnpackedForm::default()).unwrap();
            for frame in pcm.frames(&map, &mut Vec::new()).unwrap() {
                if let BitTime::Rtc(rtc) = frame.time {
                    times.push(relation.at(rtc).unwrap().ns);
                }
            }
        }
    });
    let span_s = (times[9791] - times[0]) as f64 / 1e9;
    assert!((9791.0 / span_s - 1_666_666.0 / 224.0).abs() < 0.05, "{}", 9791.0 / span_s);
}
