//! MAVLink, as a tlog and as a bare stream: frames, senders, samples of the vehicle, and the file reader on top.
//!
//! Each input is read as it is and with the checksums of its frames put right, so that what stands behind the checksum is
//! reached too.

use super::{Steps, bits, pieces, temporary};
use mavlink::Message as _;
use mavlink::dialects::ardupilotmega::MavMessage;
use sideslip::flight::channel::ControlNames;
use sideslip::flight::sample::Sample;
use sideslip::io::telemetry::format::RecordingFormat;
use sideslip::io::telemetry::mavlink::encode::{Encoder, ME};
use sideslip::io::telemetry::mavlink::mapping::MavlinkConfig;
use sideslip::io::telemetry::mavlink::packet::{FrameTally, Framer, Framing, Packet};
use sideslip::io::telemetry::mavlink::recording::MavlinkRecording;
use sideslip::io::telemetry::mavlink::senders::Senders;
use sideslip::io::telemetry::mavlink::stream::VehicleStream;
use std::path::Path;

pub(super) fn stream(bytes: &[u8]) -> usize {
    let _ = RecordingFormat::of(bytes);
    let right = with_checksums(bytes);
    let mut things = 0;
    for bytes in [bytes, &right] {
        for framing in [Framing::Stamped, Framing::Bare] {
            let whole = read(bytes, framing, std::iter::once(bytes));
            let cut = read(bytes, framing, pieces(bytes));
            assert_eq!(whole.tally, cut.tally, "pieces change what is found");
            assert!(whole.senders == cut.senders && whole.rows == cut.rows, "pieces change the samples");
            encode(&whole.samples);
            as_file(bytes, framing);
            things += whole.samples.len();
        }
    }
    things
}

struct Found {
    tally: FrameTally,
    senders: Senders,
    samples: Vec<Sample>,
    rows: Vec<u64>,
}

fn read<'a>(bytes: &[u8], framing: Framing, pieces: impl Iterator<Item = &'a [u8]>) -> Found {
    let mut framer = Framer::new(framing);
    let mut stream = VehicleStream::new(MavlinkConfig::default(), None);
    let (mut senders, mut samples, mut rows) = (Senders::default(), Vec::new(), Vec::new());
    let mut steps = Steps::of(bytes, 1);
    let mut end = 0;
    let mut packet = |packet: Packet, stream: &mut VehicleStream| {
        steps.one();
        assert!(packet.at >= end && packet.end > packet.at && packet.end <= bytes.len() as u64, "frames overlap");
        end = packet.end;
        senders.count(&packet);
        stream.packet(&packet, packet.stamp_us);
        while let Some(timed) = stream.next_sample() {
            rows.extend(bits(std::iter::once(timed.sample.time_s).chain(timed.sample.values)));
            rows.push(u64::from(timed.boot));
            samples.push(timed.sample);
        }
    };
    for mut piece in pieces {
        while !piece.is_empty() {
            piece = &piece[framer.take(piece)..];
            while let Some(found) = framer.next_packet() {
                packet(found, &mut stream);
            }
        }
    }
    while let Some(found) = framer.last_packet() {
        packet(found, &mut stream);
    }
    stream.flush();
    while let Some(timed) = stream.next_sample() {
        samples.push(timed.sample);
    }
    assert!(samples.len() <= bytes.len(), "more samples than bytes");
    Found { tally: framer.tally(), senders, samples, rows }
}

/// What was read can be sent, and every frame of it is found.
fn encode(samples: &[Sample]) {
    let mut encoder = Encoder::new(ME, MavlinkConfig::default(), ControlNames::FixedWing);
    let (mut line, mut sent) = (Vec::new(), 0);
    for sample in samples.iter().take(50) {
        let _ = encoder.sample(sample, |frame| {
            line.extend_from_slice(frame);
            sent += 1;
        });
    }
    let tally = read(&line, Framing::Bare, std::iter::once(&line[..])).tally;
    assert_eq!((tally.good, tally.garbage_bytes, tally.bad_checksum), (sent, 0, 0), "frames that were sent are not found");
}

fn as_file(bytes: &[u8], framing: Framing) {
    let file = temporary::file(bytes);
    let Ok(mut recording) = MavlinkRecording::new(Path::new("fuzz"), file, framing, MavlinkConfig::default()) else { return };
    let (mut steps, mut newest_s) = (Steps::of(bytes, 1), f64::NEG_INFINITY);
    while let Ok(Some(row)) = recording.next_row() {
        steps.one();
        assert!(row.sample.time_s >= newest_s, "time goes back from {newest_s} to {}", row.sample.time_s);
        newest_s = row.sample.time_s;
    }
    let _ = recording.shortfall();
}

/// The bytes with a right checksum in everything that looks like a frame.
fn with_checksums(bytes: &[u8]) -> Vec<u8> {
    let mut right = bytes.to_vec();
    let mut at = 0;
    while let Some(frame) = right.get_mut(at..).filter(|rest| !rest.is_empty()) {
        at += put_right(frame).unwrap_or(1);
    }
    right
}

fn put_right(frame: &mut [u8]) -> Option<usize> {
    let payload = usize::from(*frame.get(1)?);
    let (header, id) = match *frame.first()? {
        0xFE => (6, u32::from(*frame.get(5)?)),
        0xFD => (10, u32::from_le_bytes([*frame.get(7)?, *frame.get(8)?, *frame.get(9)?, 0])),
        _ => return None,
    };
    let end = header + payload;
    let sum = mavlink::calculate_crc(frame.get(1..end)?, MavMessage::extra_crc(id));
    frame.get_mut(end..end + 2)?.copy_from_slice(&sum.to_le_bytes());
    Some(end + 2)
}
