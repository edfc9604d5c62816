//! Recordings with damage, in pieces, and sent as datagrams.

use super::chapter10::{read, recording};
use sideslip::io::telemetry::chapter10::header::PacketLimits;
use sideslip::io::telemetry::chapter10::packet::{Chapter10Packet, Integrity};
use sideslip::io::telemetry::chapter10::pcm_data::PcmPacket;
use sideslip::io::telemetry::chapter10::pcm_layout::{PcmLayout, UnpackedForm};
use sideslip::io::telemetry::chapter10::time_relation::TimeRelation;
use sideslip::io::telemetry::chapter10::tmats::{SetupRecord, Tmats};
use sideslip::io::telemetry::chapter10::tmats_check::PcmEvidence;
use sideslip::io::telemetry::chapter10::tmats_pcm::TmatsPcmFormat;
use sideslip::io::telemetry::chapter10::udp::LinkFormat;
use sideslip::io::telemetry::chapter10::udp_receiver::UdpReceiver;

/// Channel, sequence number and place of every packet that is not damaged.
fn whole_packets(bytes: &[u8], piece: usize) -> Vec<(u16, u8, u64)> {
    let mut found = Vec::new();
    read(bytes, piece, |packet| {
        if packet.integrity != Integrity::Damaged {
            found.push((packet.header.channel, packet.header.sequence, packet.at));
        }
    });
    found
}

fn next(state: &mut u64) -> usize {
    *state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
    (*state >> 33) as usize
}

#[test]
fn pieces_of_any_size_give_the_same() {
    let Some(bytes) = recording("err.c10") else { return };
    let whole = whole_packets(&bytes, bytes.len());
    for piece in [1, 7, 1000, 4096, 300_000] {
        assert_eq!(whole_packets(&bytes, piece), whole, "{piece}");
    }
}

#[test]
fn each_damage_costs_at_most_two_packets() {
    let Some(bytes) = recording("err.c10") else { return };
    let whole = whole_packets(&bytes, bytes.len()).len();
    let mut state = 7;
    let mut least = whole;
    for _ in 0..60 {
        let mut damaged = bytes.clone();
        let (at, kind, length) = (next(&mut state) % (bytes.len() - 3000), next(&mut state) % 3, next(&mut state) % 2000);
        match kind {
            0 => damaged[at] ^= 1 << (length % 8),
            1 => drop(damaged.drain(at..at + length)),
            _ => damaged[at..at + length].fill(0),
        }
        let found = whole_packets(&damaged, damaged.len()).len();
        least = least.min(found);
        // 2,000 bytes can touch two packets of 500 bytes and those between.
        assert!(found + 4 >= whole, "at {at}, kind {kind}, {length} bytes: {found} of {whole}");
        let one = if kind == 0 { 1 } else { 4 };
        assert!(found + one >= whole, "at {at}, kind {kind}: {found} of {whole}");
    }
    println!("the worst of 60 kinds of damage left {least} of {whole} packets");
}

#[test]
fn datagrams_of_formats_1_and_3_give_the_recording_back() {
    let Some(bytes) = recording("pcm.c10") else { return };
    let whole: Vec<(u16, u8)> = whole_packets(&bytes, bytes.len()).iter().map(|found| (found.0, found.1)).collect();
    let mut packets = Vec::new();
    read(&bytes, bytes.len(), |packet| {
        let from = packet.at as usize;
        packets.push(bytes[from..from + packet.header.packet_length as usize].to_vec());
    });
    let mut receiver = UdpReceiver::new(LinkFormat::OneOrThree, PacketLimits::default());
    let (mut found, mut number) = (Vec::new(), 0_u32);
    for packet in &packets {
        for (index, part) in packet.chunks(1400).enumerate() {
            let first = (number << 8 | 0x11).to_le_bytes();
            let offset = (1400 * index as u32).to_le_bytes();
            let datagram = [&first[..], &packet[2..4], &[packet[13], 0], &offset, part].concat();
            receiver.datagram(&datagram, |packet| found.push((packet.header.channel, packet.header.sequence))).unwrap();
            number += 1;
        }
    }
    receiver.finish(|packet| found.push((packet.header.channel, packet.header.sequence)));
    assert_eq!((&found, receiver.tally().lost, receiver.segments().incomplete), (&whole, 0, 0));
    let mut receiver = UdpReceiver::new(LinkFormat::OneOrThree, PacketLimits::default());
    found.clear();
    for (number, part) in bytes.chunks(1400).enumerate() {
        let datagram = [&[0x13, 0, 0xFF, 0xFF][..], &(0x5000_0000 | number as u32).to_le_bytes(), part].concat();
        receiver.datagram(&datagram, |packet| found.push((packet.header.channel, packet.header.sequence))).unwrap();
    }
    receiver.finish(|packet| found.push((packet.header.channel, packet.header.sequence)));
    assert_eq!((found, receiver.tally().lost), (whole, 0));
}

#[test]
fn bodies_with_any_errors_are_refused_or_read_but_never_panic() {
    let layouts = [PcmLayout::uniform(32, 16, 12), PcmLayout::new(24, vec![12, 7, 64, 1, 33])].map(Result::unwrap);
    let mut state = 99;
    for name in ["err.c10", "pcm.c10", "pcm_old_101348.c10"] {
        let Some(bytes) = recording(name) else { return };
        let (mut relation, mut evidence, mut scratch) = (TimeRelation::default(), PcmEvidence::new(None, &[]), Vec::new());
        let (mut read_on, mut refused) = (0, 0);
        read(&bytes, bytes.len(), |packet| {
            if !matches!(packet.header.data_type, 0x01 | 0x09 | 0x11) {
                return;
            }
            for _ in 0..30 {
                let mut body = packet.body[..packet.body.len().min(4000)].to_vec();
                for _ in 0..1 + next(&mut state) % 4 {
                    let at =
                        if next(&mut state).is_multiple_of(2) { next(&mut state) % body.len() } else { next(&mut state) % 10 };
                    body[at] = next(&mut state) as u8;
                }
                body.truncate(body.len() - next(&mut state) % 10);
                let mut header = packet.header;
                header.flags = next(&mut state) as u8;
                header.rtc = header.rtc.wrapping_add((next(&mut state) as u64) << (next(&mut state) % 33)) % (1 << 48);
                let changed = Chapter10Packet { header, body: &body, ..*packet };
                let _ = relation.packet(&changed);
                let _ = relation.at(header.rtc);
                evidence.packet(&changed);
                if let Ok(setup) = SetupRecord::parse(&changed) {
                    let tmats = Tmats::parse(setup.text);
                    for channel in 0..12 {
                        let _ = TmatsPcmFormat::of_channel(&tmats, channel).map(|format| evidence.contradictions(&format));
                    }
                }
                let Ok(pcm) = PcmPacket::parse(&changed) else { continue };
                for layout in &layouts {
                    let Some(map) = layout.map(pcm.word.mode, pcm.word.alignment, UnpackedForm::default()) else { continue };
                    match pcm.frames(&map, &mut scratch) {
                        Ok(frames) => read_on += frames.map(|frame| frame.words().count()).sum::<usize>(),
                        Err(_) => refused += 1,
                    }
                }
            }
        });
        println!("{name}: {read_on} words read, {refused} packets refused, {:?}", relation.tally());
    }
}
