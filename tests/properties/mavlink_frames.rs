//! Every valid MAVLink frame is found, whatever stands around it and however the bytes are cut; nothing grows or panics.
//!
//! `SIDESLIP_FUZZ_BYTES=1e8` makes the last study as long as that; a million bytes otherwise.

use crate::support::uniform::Uniform;
use mavlink::dialects::ardupilotmega::{ATTITUDE_DATA, HIGHRES_IMU_DATA, MavMessage, SERVO_OUTPUT_RAW_DATA, VFR_HUD_DATA};
use mavlink::{MavHeader, MavlinkVersion, write_versioned_msg};
use proptest::prelude::*;
use sideslip::io::telemetry::mavlink::mapping::MavlinkConfig;
use sideslip::io::telemetry::mavlink::packet::{FrameTally, Framer, Framing, Packet};
use sideslip::io::telemetry::mavlink::senders::{SENDERS_MAX, Senders};
use sideslip::io::telemetry::mavlink::stream::VehicleStream;
use std::collections::BTreeSet;

/// A frame as the dialect's own writer makes it; which message and version, by the number.
fn frame(number: u32) -> Vec<u8> {
    let x = number as f32 * 0.01;
    let message = match number % 4 {
        0 => MavMessage::ATTITUDE(ATTITUDE_DATA { time_boot_ms: number * 10, roll: x.sin(), ..Default::default() }),
        1 => {
            MavMessage::HIGHRES_IMU(HIGHRES_IMU_DATA { time_usec: u64::from(number) * 10_000, zacc: -9.8, ..Default::default() })
        }
        2 => MavMessage::SERVO_OUTPUT_RAW(SERVO_OUTPUT_RAW_DATA { servo1_raw: 1500, ..Default::default() }),
        _ => MavMessage::VFR_HUD(VFR_HUD_DATA { airspeed: 50.0 + x, ..Default::default() }),
    };
    let version = if number.is_multiple_of(3) { MavlinkVersion::V1 } else { MavlinkVersion::V2 };
    let mut bytes = Vec::new();
    let header = MavHeader { system_id: 1, component_id: 1, sequence: number as u8 };
    write_versioned_msg(&mut bytes, version, header, &message).unwrap();
    bytes
}

/// Everything that is found when the bytes come in pieces of those lengths, in turn.
fn found(bytes: &[u8], framing: Framing, pieces: &[usize]) -> (Vec<Packet>, FrameTally) {
    let mut framer = Framer::new(framing);
    let mut packets = Vec::new();
    let (mut rest, mut lengths) = (bytes, pieces.iter().copied().cycle());
    while !rest.is_empty() {
        let (mut piece, after) = rest.split_at(lengths.next().unwrap().clamp(1, rest.len()));
        while !piece.is_empty() {
            piece = &piece[framer.take(piece)..];
            packets.extend(std::iter::from_fn(|| framer.next_packet()));
        }
        rest = after;
    }
    packets.extend(std::iter::from_fn(|| framer.last_packet()));
    (packets, framer.tally())
}

#[test]
fn garbage_between_frames_costs_no_frame_wherever_the_bytes_are_cut() {
    // Garbage that looks like beginnings of both versions, with lengths that reach into and over the next frames.
    let garbage: [&[u8]; 6] =
        [&[0xFE], &[0xFD, 0xFF], &[0xFE, 0x00, 0xFD], &[0xFD, 0x02, 0x01, 0, 0, 0], &[0xFE, 200, 7], &[0, 1, 2, 3, 4]];
    for (i, garbage) in garbage.iter().enumerate() {
        let (first, second) = (frame(i as u32), frame(i as u32 + 1));
        let bytes = [&first, *garbage, &second, &frame(9)].concat();
        for cut in 1..bytes.len() {
            let (packets, tally) = found(&bytes, Framing::Bare, &[cut, bytes.len()]);
            let places: Vec<u64> = packets.iter().map(|packet| packet.at).collect();
            let middle = (first.len() + garbage.len()) as u64;
            assert_eq!(places, [0, middle, middle + second.len() as u64], "garbage {garbage:?}, cut at {cut}");
            assert_eq!((tally.good, tally.garbage_bytes), (3, garbage.len() as u64));
        }
    }
}

#[test]
fn a_frame_cut_short_anywhere_costs_only_itself() {
    for framing in [Framing::Bare, Framing::Stamped] {
        let record = |number: u32| {
            let stamp = if framing == Framing::Stamped { 1_600_000_000_000_000_u64.to_be_bytes().to_vec() } else { Vec::new() };
            [stamp, frame(number)].concat()
        };
        let whole = record(5);
        for kept in 0..whole.len() {
            let bytes = [record(4), whole[..kept].to_vec(), record(6), record(7)].concat();
            let sequences: Vec<u8> = found(&bytes, framing, &[bytes.len()]).0.iter().map(|packet| packet.sequence).collect();
            assert_eq!(sequences, [4, 6, 7], "{framing:?}, {kept} bytes kept");
        }
    }
}

proptest! {
    #![proptest_config(super::cases(256))]

    #[test]
    fn how_the_bytes_are_cut_changes_nothing(
        parts in prop::collection::vec(
            prop_oneof![(0..1000_u32).prop_map(frame), prop::collection::vec(any::<u8>(), 0..40)],
            1..20,
        ),
        pieces in prop::collection::vec(1..400_usize, 1..8),
        stamped in any::<bool>(),
    ) {
        let framing = if stamped { Framing::Stamped } else { Framing::Bare };
        let bytes = parts.concat();
        let whole = found(&bytes, framing, &[bytes.len()]);
        prop_assert_eq!(&found(&bytes, framing, &pieces), &whole);
        prop_assert_eq!(&found(&bytes, framing, &[1]), &whole);
    }
}

/// Resident memory of this process, bytes, where the system tells.
fn resident() -> Option<u64> {
    let text = std::fs::read_to_string("/proc/self/statm").ok()?;
    text.split_whitespace().nth(1)?.parse::<u64>().ok().map(|pages| pages * 4096)
}

/// One piece of the long study: random bytes, a frame with flipped bits, or a frame that must be found.
fn piece(random: &mut Uniform, number: &mut u32) -> (Vec<u8>, bool) {
    match random.bits() % 4 {
        0 => {
            let length = random.bits() % 300;
            ((0..length).map(|_| random.bits() as u8).collect(), false)
        }
        1 => {
            let mut bytes = frame(random.bits() as u32 % 100_000);
            for _ in 0..=random.bits() % 4 {
                let place = random.bits() as usize % bytes.len();
                bytes[place] ^= 1 << (random.bits() % 8);
            }
            bytes.truncate(1 + random.bits() as usize % (2 * bytes.len()));
            (bytes, false)
        }
        _ => {
            *number += 1;
            (frame(*number % 400_000), true)
        }
    }
}

#[test]
fn every_frame_among_random_and_mutated_bytes_is_found_and_nothing_grows() {
    let length = std::env::var("SIDESLIP_FUZZ_BYTES").ok().and_then(|text| text.parse::<f64>().ok()).unwrap_or(1e6);
    let (mut random, mut number, mut total) = (Uniform(11), 0, 0_u64);
    let mut framer = Framer::new(Framing::Bare);
    let mut stream = VehicleStream::new(MavlinkConfig::default(), None);
    let mut senders = Senders::default();
    let (mut sent, mut samples, mut covered) = (0_u64, 0_u64, 0_u64);
    let mut wanted: BTreeSet<u64> = BTreeSet::new();
    let mut before = None;
    let mut take = |packet: Packet, wanted: &mut BTreeSet<u64>| {
        senders.count(&packet);
        stream.packet(&packet, None);
        samples += std::iter::from_fn(|| stream.next_sample()).count() as u64;
        wanted.remove(&packet.at);
        // Random bytes are a valid frame once in some ten million; what begins inside one cannot be told from its payload.
        let inside: Vec<u64> = wanted.range(packet.at..packet.end).copied().collect();
        if !inside.is_empty() {
            eprintln!("{packet:?} at {} to {} covers {inside:?}", packet.at, packet.end);
        }
        covered += inside.len() as u64;
        wanted.retain(|place| !inside.contains(place));
    };
    while (total as f64) < length {
        let (bytes, valid) = piece(&mut random, &mut number);
        if valid {
            wanted.insert(total);
            sent += 1;
        }
        total += bytes.len() as u64;
        let mut rest = &bytes[..];
        while !rest.is_empty() {
            rest = &rest[framer.take(rest)..];
            std::iter::from_fn(|| framer.next_packet()).for_each(|packet| take(packet, &mut wanted));
        }
        // Whatever is wanted is either found or still waits in the buffer.
        assert!(wanted.first().is_none_or(|oldest| total - oldest <= 4096), "a frame was passed over at {:?}", wanted.first());
        if before.is_none() && total > 500_000 {
            before = resident();
        }
    }
    std::iter::from_fn(|| framer.last_packet()).for_each(|packet| take(packet, &mut wanted));
    let tally = framer.tally();
    let growth = before.zip(resident()).map(|(before, after)| after.saturating_sub(before));
    eprintln!(
        "{total} bytes, {sent} valid frames, {covered} of them inside a frame that chance made, {samples} samples; {tally:?}; \
         {} senders; memory grew by {growth:?} bytes",
        senders.iter().count()
    );
    assert!(wanted.is_empty(), "not found: {:?}", wanted.iter().take(5).collect::<Vec<_>>());
    assert!(tally.good + covered >= sent && covered <= 2 + total / 1_000_000);
    assert!(senders.iter().count() <= SENDERS_MAX);
    assert!(growth.is_none_or(|growth| growth < 4 << 20), "{growth:?}");
}
