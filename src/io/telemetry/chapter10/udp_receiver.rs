//! Packets from datagrams, with every datagram that was lost, late or repeated counted.
//!
//! Consumes datagrams in the order of their arrival; hands out packets. Format 1, full: the datagram holds whole packets.
//! Segmented packets (formats 1 and 2) are put together by [`super::udp_segments`]. Format 3 is a stream for each source:
//! datagrams that come out of order cannot be put in place and are dropped; behind a loss the next header is searched (its
//! checksum tells it, so that the offset of the first packet is not needed). A packet in a stream without a data checksum
//! waits for the header behind it. Numbers that fall back by
//! more than [`WINDOW`] or leap ahead by more than [`AHEAD_MAX`] mean that the sender started again. No
//! sockets, no clock. Memory: that of the segments, and a packet reader for each of at most [`SOURCES`] sources and one.
//! Source: as in [`super::udp`]. Format 1 does not say who sends: each sender needs a receiver of its own.

use super::error::Chapter10Error;
use super::header::PacketLimits;
use super::packet::{Chapter10Packet, Chapter10Reader, PacketTally};
use super::udp::{LinkFormat, TransferHeader};
use super::udp_segments::{SegmentAssembly, SegmentPlace, SegmentTally};
use std::collections::BTreeMap;

/// Sources of format 3 that are followed at most.
pub const SOURCES: usize = 16;
/// How far back a number may be to count as late.
pub const WINDOW: u32 = 64;
/// A number further ahead than any outage makes it is another count: at 10,000 datagrams a second, 100 s.
pub const AHEAD_MAX: u32 = 1_000_000;

/// What arrived so far.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct UdpTally {
    /// Datagrams.
    pub datagrams: u64,
    /// Datagrams whose transfer header cannot be read.
    pub refused: u64,
    /// Numbers that are missing and did not come late.
    pub lost: u64,
    /// Datagrams that came out of order (in format 3 their bytes are lost).
    pub late: u64,
    /// Datagrams that came twice; they are dropped.
    pub repeated: u64,
    /// Times that a sender started again.
    pub restarts: u64,
    /// Datagrams of more sources than are followed.
    pub other_sources: u64,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Arrival {
    InOrder,
    AfterLoss(u32),
    Late,
    Repeated,
    Restart,
}

/// The numbers of one sender.
#[derive(Clone, Copy, Debug, Default)]
struct NumberWindow {
    next: Option<u32>,
    /// Bit k: the number k + 1 before `next` came.
    seen: u64,
}

impl NumberWindow {
    fn step(&mut self, number: u32, bits: u32) -> Arrival {
        let mask = u32::MAX >> (32 - bits.clamp(1, 32));
        let Some(next) = self.next.replace(number.wrapping_add(1) & mask) else {
            self.seen = 1;
            return Arrival::InOrder;
        };
        let ahead = number.wrapping_sub(next) & mask;
        if ahead <= (mask / 2).min(AHEAD_MAX) {
            self.seen = self.seen.checked_shl(ahead.saturating_add(1)).unwrap_or(0) | 1;
            return if ahead == 0 { Arrival::InOrder } else { Arrival::AfterLoss(ahead) };
        }
        let behind = next.wrapping_sub(number) & mask;
        if behind > WINDOW {
            self.seen = 1;
            return Arrival::Restart;
        }
        self.next = Some(next);
        let bit = 1_u64 << (behind - 1);
        let repeated = self.seen & bit != 0;
        self.seen |= bit;
        if repeated { Arrival::Repeated } else { Arrival::Late }
    }
}

/// A source of format 3.
#[derive(Debug)]
struct StreamSource {
    numbers: NumberWindow,
    reader: Chapter10Reader,
}

/// Receives datagrams.
#[derive(Debug)]
pub struct UdpReceiver {
    link: LinkFormat,
    limits: PacketLimits,
    numbers: NumberWindow,
    whole: Chapter10Reader,
    assembly: SegmentAssembly,
    sources: BTreeMap<u32, StreamSource>,
    tally: UdpTally,
}

impl UdpReceiver {
    /// Nothing received yet.
    pub fn new(link: LinkFormat, limits: PacketLimits) -> Self {
        UdpReceiver {
            link,
            limits,
            numbers: NumberWindow::default(),
            whole: Chapter10Reader::new(limits),
            assembly: SegmentAssembly::new(limits),
            sources: BTreeMap::new(),
            tally: UdpTally::default(),
        }
    }

    /// What arrived so far.
    pub fn tally(&self) -> UdpTally {
        self.tally
    }

    /// What became of segments.
    pub fn segments(&self) -> SegmentTally {
        self.assembly.tally()
    }

    /// The packets found: of formats 1 and 2 (`None`), then of each source of format 3. Places are bytes of payload.
    pub fn packets(&self) -> impl Iterator<Item = (Option<u32>, PacketTally)> {
        let streams = self.sources.iter().map(|(source, stream)| (Some(*source), stream.reader.tally()));
        std::iter::once((None, self.whole.tally())).chain(streams)
    }

    /// Takes in a datagram and hands out the packets that it completes.
    ///
    /// # Errors
    /// [`Chapter10Error`] where its transfer header cannot be read; this is counted, too.
    pub fn datagram(&mut self, datagram: &[u8], mut each: impl FnMut(&Chapter10Packet<'_>)) -> Result<(), Chapter10Error> {
        self.tally.datagrams += 1;
        let (header, payload) = match TransferHeader::parse(datagram, self.link) {
            Ok(parsed) => parsed,
            Err(error) => {
                self.tally.refused += 1;
                return Err(error);
            }
        };
        let (number, bits) = header.number();
        match header {
            TransferHeader::Stream { source, .. } => self.stream(source, number, bits, payload, each),
            TransferHeader::Full { .. } => {
                if self.arrived(number, bits) {
                    read_whole(&mut self.whole, payload, &mut each);
                }
            }
            TransferHeader::Segment { channel, sequence, offset, .. } => {
                if self.arrived(number, bits)
                    && let Some(packet) = self.assembly.segment(SegmentPlace { channel, sequence, offset }, payload)
                {
                    read_whole(&mut self.whole, &packet, &mut each);
                }
            }
        }
        Ok(())
    }

    /// Hands out what waits, and gives up what is incomplete.
    pub fn finish(&mut self, mut each: impl FnMut(&Chapter10Packet<'_>)) {
        self.assembly.finish();
        for stream in self.sources.values_mut() {
            while let Some(packet) = stream.reader.finish() {
                each(&packet);
            }
        }
    }

    /// Whether a datagram of format 1 or 2 is to be read.
    fn arrived(&mut self, number: u32, bits: u32) -> bool {
        let arrival = self.numbers.step(number, bits);
        self.count(arrival);
        if arrival == Arrival::Late {
            self.tally.lost = self.tally.lost.saturating_sub(1);
        }
        arrival != Arrival::Repeated
    }

    fn count(&mut self, arrival: Arrival) {
        match arrival {
            Arrival::InOrder => {}
            Arrival::AfterLoss(lost) => self.tally.lost += u64::from(lost),
            Arrival::Late => self.tally.late += 1,
            Arrival::Repeated => self.tally.repeated += 1,
            Arrival::Restart => self.tally.restarts += 1,
        }
    }

    fn stream(&mut self, source: u32, number: u32, bits: u32, payload: &[u8], mut each: impl FnMut(&Chapter10Packet<'_>)) {
        if self.sources.len() >= SOURCES && !self.sources.contains_key(&source) {
            self.tally.other_sources += 1;
            return;
        }
        let limits = self.limits;
        let new = || StreamSource { numbers: NumberWindow::default(), reader: Chapter10Reader::new(limits) };
        let stream = self.sources.entry(source).or_insert_with(new);
        let arrival = stream.numbers.step(number, bits);
        if matches!(arrival, Arrival::AfterLoss(_) | Arrival::Restart) {
            while let Some(packet) = stream.reader.finish() {
                each(&packet);
            }
        }
        if !matches!(arrival, Arrival::Late | Arrival::Repeated) {
            take_all(&mut stream.reader, payload, &mut each);
        }
        self.count(arrival);
    }
}

fn take_all(reader: &mut Chapter10Reader, bytes: &[u8], each: &mut impl FnMut(&Chapter10Packet<'_>)) {
    let mut rest = bytes;
    while !rest.is_empty() {
        let taken = reader.take(rest);
        rest = rest.get(taken..).unwrap_or_default();
        while let Some(packet) = reader.next_packet() {
            each(&packet);
        }
    }
}

/// Reads bytes that begin and end with a packet.
fn read_whole(reader: &mut Chapter10Reader, bytes: &[u8], each: &mut impl FnMut(&Chapter10Packet<'_>)) {
    take_all(reader, bytes, each);
    while let Some(packet) = reader.finish() {
        each(&packet);
    }
}

#[cfg(test)]
mod tests {
    use super::super::packet_test::{Noise, packet};
    use super::*;

    fn packets(count: u8, noise: &mut Noise) -> Vec<Vec<u8>> {
        (0..count).map(|k| packet(2, 9, k, 5, &vec![k; 4 + noise.below(2000)], noise.below(4) as u8)).collect()
    }

    fn received(datagrams: &[Vec<u8>], link: LinkFormat) -> (Vec<u8>, UdpReceiver) {
        let mut receiver = UdpReceiver::new(link, PacketLimits { setup_record: 4096, other: 4096 });
        let mut found = Vec::new();
        for datagram in datagrams {
            let _ = receiver.datagram(datagram, |packet| found.push(packet.header.sequence));
        }
        receiver.finish(|packet| found.push(packet.header.sequence));
        (found, receiver)
    }

    fn format_1(packets: &[Vec<u8>], size: usize) -> Vec<Vec<u8>> {
        let mut number = 0xFF_FFF0_u32;
        let mut first = move |kind: u8| {
            number = (number + 1) & 0xFF_FFFF;
            ((number << 8) | u32::from(kind) << 4 | 1).to_le_bytes()
        };
        let mut datagrams = Vec::new();
        for packet in packets {
            if packet.len() <= size {
                datagrams.push([&first(0)[..], packet].concat());
                continue;
            }
            for (index, part) in packet.chunks(size).enumerate() {
                let offset = (index * size) as u32;
                datagrams.push([&first(1)[..], &packet[2..4], &[packet[13], 0], &offset.to_le_bytes(), part].concat());
            }
        }
        datagrams
    }

    #[test]
    fn format_1_full_and_segmented_in_any_order() {
        let mut noise = Noise(31);
        let packets = packets(60, &mut noise);
        let all: Vec<u8> = (0..60).collect();
        let mut datagrams = format_1(&packets, 500);
        let (found, receiver) = received(&datagrams, LinkFormat::OneOrThree);
        assert_eq!((&found, receiver.tally().lost, receiver.tally().refused), (&all, 0, 0));
        for index in (0..datagrams.len() - 3).step_by(3) {
            datagrams.swap(index, index + noise.below(3));
        }
        let twice = datagrams[7].clone();
        datagrams.insert(9, twice);
        let (mut found, receiver) = received(&datagrams, LinkFormat::OneOrThree);
        found.sort_unstable();
        let tally = receiver.tally();
        assert_eq!((&found, tally.lost, tally.repeated, tally.restarts), (&all, 0, 1, 0));
        assert!(tally.late > 20 && receiver.segments().incomplete == 0, "{tally:?}");
    }

    #[test]
    fn format_1_lost_datagrams_cost_their_packets_only() {
        let mut noise = Noise(32);
        let packets = packets(60, &mut noise);
        let mut datagrams = format_1(&packets, 500);
        datagrams.remove(70);
        datagrams.remove(20);
        datagrams.push(vec![5, 0, 0, 0]);
        let (found, receiver) = received(&datagrams, LinkFormat::OneOrThree);
        assert_eq!((found.len(), receiver.tally().lost, receiver.tally().refused), (58, 2, 1));
        let segments = receiver.segments();
        assert!(segments.incomplete <= 2 && segments.complete > 10, "{segments:?}");
    }

    #[test]
    fn format_2_segments() {
        let mut noise = Noise(33);
        let packets = packets(20, &mut noise);
        let mut datagrams = Vec::new();
        for packet in &packets {
            for (index, part) in packet.chunks(400).enumerate() {
                let number = datagrams.len() as u32;
                let (offset, size) = (100 * index as u32, packet.len() as u32 / 4);
                let words = [number << 8 | 0x12, offset >> 16 << 24 | size, offset << 16 | 2];
                datagrams.push([&words.map(u32::to_be_bytes).concat()[..], part].concat());
            }
        }
        let (found, receiver) = received(&datagrams, LinkFormat::Two);
        assert_eq!((found, receiver.tally().lost), ((0..20).collect::<Vec<u8>>(), 0));
    }

    #[test]
    fn format_3_is_a_stream_for_each_source() {
        let mut noise = Noise(34);
        let packets = packets(60, &mut noise);
        let stream = packets.concat();
        let of = |source: u32, skip: &[usize]| -> Vec<Vec<u8>> {
            let pieces = stream.chunks(700).enumerate().filter(|(index, _)| !skip.contains(index));
            pieces
                .map(|(index, part)| {
                    let second = source << 24 | (0xFF_FFFA + index as u32) & 0xFF_FFFF;
                    [&[0x23, 0, 0, 0][..], &second.to_le_bytes(), part].concat()
                })
                .collect()
        };
        let both: Vec<Vec<u8>> = of(1, &[]).into_iter().zip(of(0xAB, &[])).flat_map(|(a, b)| [a, b]).collect();
        let (found, receiver) = received(&both, LinkFormat::OneOrThree);
        assert_eq!((found.len(), receiver.tally().lost), (120, 0));
        assert!(receiver.packets().all(|(_, tally)| tally.skipped_bytes == 0));
        let mut lossy = of(1, &[10, 11, 40]);
        lossy.swap(50, 51);
        let (found, receiver) = received(&lossy, LinkFormat::OneOrThree);
        let tally = receiver.tally();
        assert_eq!((tally.lost, tally.late), (4, 1));
        assert!((50..58).contains(&found.len()), "{}", found.len());
        assert_eq!(found.windows(2).filter(|pair| pair[1] <= pair[0]).count(), 0);
        let many: Vec<Vec<u8>> = (0..40).flat_map(|source| of(source, &[])[..1].to_vec()).collect();
        assert_eq!(received(&many, LinkFormat::OneOrThree).1.tally().other_sources, 24);
    }

    #[test]
    fn noise_is_refused_or_yields_nothing() {
        let mut noise = Noise(35);
        let datagrams: Vec<Vec<u8>> = (0..5000).map(|_| (0..noise.below(60)).map(|_| noise.next() as u8).collect()).collect();
        for link in [LinkFormat::OneOrThree, LinkFormat::Two] {
            let (found, receiver) = received(&datagrams, link);
            assert_eq!((found.len(), receiver.tally().datagrams), (0, 5000));
        }
    }
}
