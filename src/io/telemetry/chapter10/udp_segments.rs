//! Packets put together from segments, in bounded memory.
//!
//! Consumes segments with channel, sequence number and offset, in any order; produces the bytes of every packet whose
//! segments are all there. Its length is what its header says, which stands in the segment at offset 0. Segments that come
//! twice are dropped; such as overlap others are refused, for one of the two is wrong. Without sequence numbers (format 2) a
//! segment at offset 0 begins a new packet of its channel. Where there is no room, the packet that was begun first goes,
//! counted.
//! Memory: [`PACKETS`] packets of [`SEGMENTS`] segments, together at most twice the longest packet.
//! Source: as in [`super::udp`].

use super::header::{PacketHeader, PacketLimits};
use std::collections::{BTreeMap, VecDeque};

/// Packets that are put together at a time.
pub const PACKETS: usize = 64;
/// Segments of a packet at most.
pub const SEGMENTS: usize = 8192;

/// What became of the segments.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct SegmentTally {
    /// Packets that were put together.
    pub complete: u64,
    /// Packets that were given up.
    pub incomplete: u64,
    /// Bytes of these.
    pub incomplete_bytes: u64,
    /// Segments that came twice.
    pub repeated: u64,
    /// Segments that overlap others, are empty, too many, or reach beyond the packet or the longest packet.
    pub refused: u64,
}

/// Where a segment belongs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SegmentPlace {
    /// Channel of the packet.
    pub channel: u16,
    /// Sequence number of the packet, where the format tells it.
    pub sequence: Option<u8>,
    /// Where it belongs in the packet, bytes.
    pub offset: u32,
}

#[derive(Debug)]
struct PendingPacket {
    channel: u16,
    sequence: Option<u8>,
    /// End of what is there without a gap, from the start.
    contiguous: u32,
    length: Option<u32>,
    bytes: usize,
    segments: BTreeMap<u32, Vec<u8>>,
}

/// Puts packets together.
#[derive(Debug)]
pub struct SegmentAssembly {
    limits: PacketLimits,
    /// The one that was begun first is in front.
    pending: VecDeque<PendingPacket>,
    bytes: usize,
    tally: SegmentTally,
}

impl SegmentAssembly {
    /// Nothing pending.
    pub fn new(limits: PacketLimits) -> Self {
        SegmentAssembly { limits, pending: VecDeque::new(), bytes: 0, tally: SegmentTally::default() }
    }

    /// What became of the segments so far.
    pub fn tally(&self) -> SegmentTally {
        self.tally
    }

    /// Bytes that wait for others.
    pub fn pending_bytes(&self) -> usize {
        self.bytes
    }

    /// Takes in a segment; gives the packet if it was the last that was missing.
    pub fn segment(&mut self, place: SegmentPlace, payload: &[u8]) -> Option<Vec<u8>> {
        let end = u32::try_from(payload.len()).ok().and_then(|length| place.offset.checked_add(length));
        let Some(end) = end.filter(|end| !payload.is_empty() && *end <= self.limits.longest()) else {
            self.tally.refused += 1;
            return None;
        };
        let same = |pending: &PendingPacket| (pending.channel, pending.sequence) == (place.channel, place.sequence);
        let mut index = self.pending.iter().position(same);
        if let Some(found) = index
            && place.sequence.is_none()
            && place.offset == 0
        {
            self.give_up(found);
            index = None;
        }
        let index = match index {
            Some(index) => index,
            None => {
                self.pending.push_back(PendingPacket {
                    channel: place.channel,
                    sequence: place.sequence,
                    contiguous: 0,
                    length: None,
                    bytes: 0,
                    segments: BTreeMap::new(),
                });
                self.pending.len() - 1
            }
        };
        let fate = self.pending.get_mut(index).map(|packet| packet.insert(place.offset, end, payload, &self.limits));
        match fate {
            Some(SegmentFate::Taken) => self.bytes += payload.len(),
            Some(SegmentFate::Repeated) => self.tally.repeated += 1,
            Some(SegmentFate::Refused) | None => self.tally.refused += 1,
        }
        if self.pending.get(index).is_some_and(PendingPacket::is_complete) {
            let packet = self.pending.remove(index)?;
            self.bytes = self.bytes.saturating_sub(packet.bytes);
            self.tally.complete += 1;
            return Some(packet.segments.into_values().flatten().collect());
        }
        let room = 2 * usize::try_from(self.limits.longest()).unwrap_or(usize::MAX / 2);
        while self.pending.len() > PACKETS || self.bytes > room {
            self.give_up(0);
        }
        None
    }

    /// Gives up what is not complete.
    pub fn finish(&mut self) {
        while !self.pending.is_empty() {
            self.give_up(0);
        }
    }

    fn give_up(&mut self, index: usize) {
        if let Some(packet) = self.pending.remove(index) {
            self.bytes = self.bytes.saturating_sub(packet.bytes);
            self.tally.incomplete += 1;
            self.tally.incomplete_bytes += packet.bytes as u64;
        }
    }
}

enum SegmentFate {
    Taken,
    Repeated,
    Refused,
}

impl PendingPacket {
    fn insert(&mut self, offset: u32, end: u32, payload: &[u8], limits: &PacketLimits) -> SegmentFate {
        let ends = |(at, bytes): (&u32, &Vec<u8>)| at.saturating_add(u32::try_from(bytes.len()).unwrap_or(u32::MAX));
        let before = self.segments.range(..=offset).next_back();
        if before.is_some_and(|(at, bytes)| *at == offset && bytes == payload) {
            return SegmentFate::Repeated;
        }
        let overlaps = before.is_some_and(|segment| ends(segment) > offset)
            || self.segments.range(offset..).next().is_some_and(|(at, _)| *at < end);
        if overlaps || self.segments.len() >= SEGMENTS || self.length.is_some_and(|length| end > length) {
            return SegmentFate::Refused;
        }
        self.segments.insert(offset, payload.to_vec());
        self.bytes += payload.len();
        while let Some(bytes) = self.segments.get(&self.contiguous) {
            self.contiguous = self.contiguous.saturating_add(u32::try_from(bytes.len()).unwrap_or(u32::MAX));
        }
        if self.length.is_none()
            && let Some(first) = self.segments.get(&0)
        {
            self.length = PacketHeader::parse(first, limits).ok().map(|header| header.packet_length);
        }
        SegmentFate::Taken
    }

    fn is_complete(&self) -> bool {
        self.length.is_some_and(|length| self.contiguous >= length)
    }
}

#[cfg(test)]
mod tests {
    use super::super::packet_test::{Noise, packet};
    use super::*;

    const LIMITS: PacketLimits = PacketLimits { setup_record: 4096, other: 4096 };

    fn place(sequence: Option<u8>, offset: usize) -> SegmentPlace {
        SegmentPlace { channel: 3, sequence, offset: offset as u32 }
    }

    #[test]
    fn segments_in_any_order_make_the_packet() {
        let mut noise = Noise(8);
        for round in 0..50 {
            let whole = packet(3, 9, round, 5, &vec![round; 100 + noise.below(3000)], 3);
            let mut segments: Vec<(usize, Vec<u8>)> = Vec::new();
            let size = 24 + noise.below(200);
            whole.chunks(size).enumerate().for_each(|(index, part)| segments.push((index * size, part.to_vec())));
            for index in (1..segments.len()).rev() {
                segments.swap(index, noise.below(index + 1));
            }
            let mut assembly = SegmentAssembly::new(LIMITS);
            let found: Vec<Vec<u8>> = segments
                .iter()
                .flat_map(|(offset, part)| [assembly.segment(place(Some(round), *offset), part)])
                .flatten()
                .collect();
            assert_eq!(found, [whole], "{round}");
            assert_eq!((assembly.pending_bytes(), assembly.tally().complete, assembly.tally().incomplete), (0, 1, 0));
        }
    }

    #[test]
    fn what_does_not_fit_is_refused_and_what_stays_incomplete_is_counted() {
        let whole = packet(3, 9, 0, 5, &[7; 200], 3);
        let mut assembly = SegmentAssembly::new(LIMITS);
        assert_eq!(assembly.segment(place(Some(0), 0), &whole[..100]), None);
        assert_eq!(assembly.segment(place(Some(0), 0), &whole[..100]), None);
        assert_eq!(assembly.segment(place(Some(0), 50), &whole[50..100]), None);
        assert_eq!(assembly.segment(place(Some(0), whole.len()), &[1]), None);
        assert_eq!(assembly.segment(place(Some(0), 4090), &[1; 7]), None);
        assert_eq!(assembly.segment(place(Some(0), 100), &[]), None);
        assert_eq!(assembly.tally(), SegmentTally { repeated: 1, refused: 4, ..SegmentTally::default() });
        assert_eq!(assembly.segment(place(Some(0), 100), &whole[100..]), Some(whole.clone()));
        // Without sequence numbers, a new start gives up the packet before it.
        assert_eq!(assembly.segment(place(None, 0), &whole[..100]), None);
        assert_eq!(assembly.segment(place(None, 0), &whole), Some(whole));
        assert_eq!((assembly.tally().incomplete, assembly.tally().incomplete_bytes), (1, 100));
    }

    #[test]
    fn memory_is_bounded_by_the_longest_packet() {
        let mut assembly = SegmentAssembly::new(LIMITS);
        for round in 0..10_000_u32 {
            let place = SegmentPlace { channel: round as u16, sequence: Some(1), offset: 1000 };
            assert_eq!(assembly.segment(place, &[0; 500]), None);
            assert!(assembly.pending_bytes() <= 8192 + 500);
        }
        assembly.finish();
        assert_eq!((assembly.tally().incomplete, assembly.pending_bytes()), (10_000, 0));
    }
}
