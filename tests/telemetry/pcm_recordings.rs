//! Recordings of real streams in throughput mode (IRIG 106 Chapter 10 PCM format 1), bit-synchronised here.
use crate::support::program::data;
use sideslip::io::telemetry::pcm::bits::{LineCode, read_bits};
use sideslip::io::telemetry::pcm::frame_sync::{FrameSynchronizer, SyncCounters};
use sideslip::io::telemetry::pcm::sync_pattern::{PolarityRule, SyncPattern, SyncRules};

/// Bytes of a recording; `None`, said loudly, where it is absent.
fn recording(name: &str) -> Option<Vec<u8>> {
    data("irig106", name).map(|file| std::fs::read(file).unwrap())
}

/// The bits of a channel: of all its packets of PCM format 1, words of 16 bits turned from little-endian, and without the header
/// of each minor frame of that many bytes where the packets are packed.
fn bits(file: &[u8], channel: u16, frame_bytes: Option<usize>) -> Vec<u8> {
    let short = |at: usize| u16::from_le_bytes([file[at], file[at + 1]]);
    let long = |at: usize| u32::from(short(at)) | u32::from(short(at + 2)) << 16;
    let mut found = Vec::new();
    let mut at = 0;
    while at + 28 <= file.len() {
        if short(at) != 0xEB25 {
            at += 1;
            continue;
        }
        let (packet, data) = (long(at + 4) as usize, long(at + 8) as usize);
        if short(at + 2) == channel && file[at + 15] == 9 {
            let body = &file[at + 28..at + 24 + data];
            let frames = body.chunks(frame_bytes.map_or(body.len(), |bytes| bytes + 10));
            let words = frames.flat_map(|frame| frame[if frame_bytes.is_some() { 10 } else { 0 }..].chunks_exact(2));
            found.extend(words.flat_map(|word| [word[1], word[0]]));
        }
        at += packet.max(24);
    }
    found
}

/// First bit and bytes of each minor frame.
fn minor_frames(stream: &[u8], pattern: u64, bits: u32, length: usize) -> (Vec<(u64, Vec<u8>)>, SyncCounters) {
    let sync = SyncPattern::whole(pattern, bits);
    let mut synchronizer =
        FrameSynchronizer::new(sync, SyncRules::for_length(bits), PolarityRule::Automatic, LineCode::NrzL, length);
    let mut found = Vec::new();
    let mut rest = stream;
    while !rest.is_empty() {
        rest = &rest[synchronizer.take(rest)..];
        while let Some(frame) = synchronizer.next_frame() {
            found.push((frame.first_bit, frame.bytes.to_vec()));
        }
    }
    while let Some(frame) = synchronizer.last_frame() {
        found.push((frame.first_bit, frame.bytes.to_vec()));
    }
    (found, synchronizer.counters())
}

#[test]
fn minor_frames_of_throughput_mode_are_those_known() {
    let Some(file) = recording("pcm_old_101348.c10") else { return };
    for channel in [10, 11] {
        let stream = bits(&file, channel, None);
        let (frames, counters) = minor_frames(&stream, 0x1F74_E949, 32, 4096);
        // The identifier goes from 1 to 16 and begins again.
        let ids: Vec<u64> = frames.iter().map(|(_, bytes)| read_bits(bytes, 32, 16).unwrap()).collect();
        assert!(ids.windows(2).all(|two| two[1] == two[0] % 16 + 1), "channel {channel}: {ids:?}");
        assert_eq!(frames.len(), 83, "channel {channel}");
        assert_eq!((counters.locks, counters.losses, counters.sync_bit_errors), (1, 0, 0));
    }
    // What the description of channel 10 says instead, 224 bits, never locks.
    let stream = bits(&file, 10, None);
    assert_eq!(minor_frames(&stream, 0x1F74_E949, 32, 224).1.locks, 0);
}

#[test]
fn pseudorandom_channels_never_lock_and_counted_ones_do() {
    let Some(file) = recording("pcm.c10") else { return };
    for (channel, pattern, bits_of, length) in
        [(51, 0xFE6B_2840, 32, 512), (53, 0xFE6B_2840, 32, 4096), (54, 0xEB90, 16, 88), (54, 0xFE6B_2840, 32, 512)]
    {
        let stream = bits(&file, channel, None);
        let (frames, counters) = minor_frames(&stream, pattern, bits_of, length);
        assert!(frames.is_empty() && counters.locks == 0 && counters.bits > 8000, "channel {channel}: {counters:?}");
    }
    let (frames, counters) = minor_frames(&bits(&file, 52, None), 0xFE6B_2840, 32, 512);
    assert_eq!((frames.len(), counters.locks, counters.losses), (511, 1, 0));
    // Packed: the headers taken away, the minor frames stand one behind the other.
    let (frames, counters) = minor_frames(&bits(&file, 55, Some(64)), 0xFE6B_2840, 32, 512);
    assert_eq!((frames.len(), counters.locks, counters.losses), (884, 1, 0));
    let steps = |words: usize| {
        let word = |frame: &(u64, Vec<u8>)| read_bits(&frame.1, 32 + 16 * words, 16).unwrap();
        frames.windows(2).filter(|two| word(&two[1]) == (word(&two[0]) + 1) % 65_536).count()
    };
    assert_eq!((0..30).map(steps).max(), Some(883), "one word counts up by one a minor frame");
}
