//! IRIG 106 Chapter 10: packets of a recording with what is read in their bodies, UDP datagrams, and the setup (TMATS).
//!
//! Packets are read as they are and with the checksums of their headers put right, so that what stands behind them is reached.

use super::{Steps, chapter10_rows, pieces};
use sideslip::io::telemetry::chapter10::header::PacketLimits;
use sideslip::io::telemetry::chapter10::packet::{Chapter10Packet, Chapter10Reader, Integrity, PacketTally};
use sideslip::io::telemetry::chapter10::pcm_data::{PcmAlignment, PcmMode, PcmPacket};
use sideslip::io::telemetry::chapter10::pcm_layout::{PcmLayout, UnpackedForm};
use sideslip::io::telemetry::chapter10::survey::RecordingSurvey;
use sideslip::io::telemetry::chapter10::time::TimePacket;
use sideslip::io::telemetry::chapter10::tmats::Tmats;
use sideslip::io::telemetry::chapter10::tmats_check::own_contradictions;
use sideslip::io::telemetry::chapter10::tmats_pcm::TmatsPcmFormat;
use sideslip::io::telemetry::chapter10::udp::{LinkFormat, TransferHeader};
use sideslip::io::telemetry::chapter10::udp_receiver::UdpReceiver;
use sideslip::io::telemetry::format::RecordingFormat;

/// Limits so short that small inputs come up against them.
const SHORT: PacketLimits = PacketLimits { setup_record: 4096, other: 2048 };

pub(super) fn recording(bytes: &[u8]) -> usize {
    let _ = RecordingFormat::of(bytes);
    let right = with_checksums(bytes);
    let mut things = 0;
    for bytes in [bytes, &right] {
        for limits in [PacketLimits::default(), SHORT] {
            let whole = read(bytes, limits, std::iter::once(bytes));
            let cut = read(bytes, limits, pieces(bytes));
            assert!(whole == cut, "pieces change what is found: {:?} {:?}", whole.0, cut.0);
            things += whole.1.len() + chapter10_rows::rows(bytes, limits);
        }
    }
    things
}

/// Place, channel, sequence number, integrity and length of each packet.
type Packets = Vec<(u64, u16, u8, Integrity, usize)>;

fn read<'a>(bytes: &[u8], limits: PacketLimits, pieces: impl Iterator<Item = &'a [u8]>) -> (PacketTally, Packets, String) {
    let mut reader = Chapter10Reader::new(limits);
    let (mut survey, mut packets, mut end, mut handed) = (RecordingSurvey::default(), Packets::new(), 0, 0);
    let mut steps = Steps::of(bytes, 1);
    let mut one = |packet: &Chapter10Packet<'_>| {
        steps.one();
        assert!(packet.at >= end, "packets overlap");
        end = packet.at + u64::from(packet.header.packet_length);
        handed += u64::from(packet.header.packet_length);
        assert!(end <= bytes.len() as u64, "a packet is longer than the recording");
        packets.push((packet.at, packet.header.channel, packet.header.sequence, packet.integrity, packet.body.len()));
        survey.packet(packet);
        body(packet);
    };
    for mut piece in pieces {
        while !piece.is_empty() {
            piece = &piece[reader.take(piece)..];
            while let Some(packet) = reader.next_packet() {
                one(&packet);
            }
        }
    }
    while let Some(packet) = reader.finish() {
        one(&packet);
    }
    let tally = reader.tally();
    assert_eq!(handed + tally.skipped_bytes, bytes.len() as u64, "bytes that are neither handed out nor skipped");
    let text = format!("{} {:?}", survey.summary.table(&tally, &survey.relation), survey.contradictions());
    (tally, packets, text)
}

/// Reads a body by several layouts of frames, whatever its data type says.
fn body(packet: &Chapter10Packet<'_>) {
    let _ = TimePacket::parse(packet.body);
    let Ok(pcm) = PcmPacket::parse(packet) else { return };
    let mut scratch = Vec::new();
    let run = pcm.bits(&mut scratch);
    assert_eq!(run.bits, 8 * scratch.len() as u64);
    for layout in [PcmLayout::uniform(32, 16, 3), PcmLayout::new(24, vec![12, 7, 64, 1, 33])] {
        let layout = layout.unwrap();
        let Some(map) = layout.map(pcm.word.mode, pcm.word.alignment, UnpackedForm::default()) else { continue };
        let Ok(frames) = pcm.frames(&map, &mut scratch) else { continue };
        let mut steps = Steps::of(packet.body, 1);
        for frame in frames {
            steps.one();
            assert_eq!(frame.words().count(), layout.widths().len(), "a frame without some of its words");
            let _ = frame.sync();
        }
    }
}

/// Datagrams one after the other, each behind its length (16 bits, little-endian).
pub(super) fn datagrams(bytes: &[u8]) -> usize {
    let mut things = 0;
    for link in [LinkFormat::OneOrThree, LinkFormat::Two] {
        for limits in [PacketLimits::default(), SHORT] {
            let (mut receiver, mut rest) = (UdpReceiver::new(link, limits), bytes);
            let mut steps = Steps::of(bytes, 1);
            while let Some((length, after)) = rest.split_first_chunk::<2>() {
                let length = usize::from(u16::from_le_bytes(*length)).min(after.len());
                let (datagram, later) = after.split_at(length);
                rest = later;
                if let Ok((header, payload)) = TransferHeader::parse(datagram, link) {
                    assert!(payload.len() < datagram.len());
                    let _ = (header.number(), header.source());
                }
                let right = with_checksums(datagram);
                let _ = receiver.datagram(&right, |packet| {
                    steps.one();
                    things += 1;
                    body(packet);
                });
            }
            receiver.finish(|packet| {
                steps.one();
                things += 1;
                body(packet);
            });
            let tally = receiver.tally();
            assert!(tally.refused + tally.late + tally.repeated + tally.restarts <= tally.datagrams, "{tally:?}");
            let _ = (receiver.segments(), receiver.packets().count());
        }
    }
    things
}

/// A setup text: its attributes, and the format of each of some channels.
pub(super) fn setup(bytes: &[u8]) -> usize {
    let tmats = Tmats::parse(bytes);
    let tally = tmats.tally();
    let statements = bytes.iter().filter(|byte| **byte == b';').count() as u64;
    assert!(tally.attributes + tally.comments + tally.unreadable + tally.too_many <= statements, "{tally:?}");
    assert!(tmats.attributes().count() as u64 <= tally.attributes);
    for (code, value) in tmats.attributes() {
        assert_eq!(tmats.get(code), Some(value));
    }
    let of_channels = (0..8).filter_map(|channel| TmatsPcmFormat::of_channel(&tmats, channel).ok());
    let of_groups = (0..4).map(|group| TmatsPcmFormat::of_group(&tmats, group));
    let mut things = 0;
    for format in of_channels.chain(of_groups) {
        for contradiction in own_contradictions(&format) {
            let _ = contradiction.to_string();
        }
        let Some(layout) = format.layout() else { continue };
        things += 1;
        for mode in [PcmMode::Unpacked, PcmMode::Packed, PcmMode::Throughput] {
            for alignment in [PcmAlignment::Bits16, PcmAlignment::Bits32] {
                let map = layout.map(mode, alignment, UnpackedForm::default());
                assert!(map.is_none_or(|map| map.words().len() == layout.widths().len()));
            }
        }
    }
    things
}

/// The bytes with a right checksum in the header of everything that begins as a packet.
fn with_checksums(bytes: &[u8]) -> Vec<u8> {
    let mut right = bytes.to_vec();
    let mut at = 0;
    while let Some(rest) = right.get_mut(at..).filter(|rest| rest.len() >= 24) {
        at += 1;
        if rest[..2] != [0x25, 0xEB] {
            continue;
        }
        let words = rest[..22].chunks(2).map(|word| u16::from_le_bytes([word[0], word[1]]));
        let sum = words.fold(0_u16, u16::wrapping_add);
        rest[22..24].copy_from_slice(&sum.to_le_bytes());
        at += 23;
    }
    right
}
