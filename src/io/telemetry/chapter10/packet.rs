//! Packets out of a stream of bytes that arrive in pieces of any size, read on after damage.
//!
//! Consumes bytes; produces every [`Chapter10Packet`] in order, with what its data checksum says. A packet begins with a
//! header whose checksum is right and whose lengths agree. Its data checksum decides what it is: right, it is complete; wrong
//! or absent, it is handed out (marked) if a further header, or the end of the bytes, follows where it ends. Otherwise bytes
//! are missing in it, and if a header stands inside, the packet is cut short and the search goes on there. Where no header
//! is, the search goes on one byte later; every byte skipped is counted. Nothing is repaired. Memory: one buffer of the
//! longest packet and [`BLOCK`] bytes. A false header delays what follows by at most its supposed length. Time: a region of
//! damage is summed at most [`SUSPECT_CHECKS`] times, whatever headers stand in it. Source: IRIG 106-09 Chapter 10, 10.6.1;
//! since 106-17 Chapter 11, 11.2.1.

use super::error::Chapter10Error;
use super::header::{HEADER, PacketHeader, PacketLimits, SYNC, SecondaryHeader};
use super::sequence::{SequenceCheck, SequenceStep};

/// Bytes that the buffer holds beyond the longest packet.
pub const BLOCK: usize = 64 << 10;
/// Packets with a wrong checksum that are summed within one region of damage.
pub const SUSPECT_CHECKS: u32 = 16;

/// What the data checksum says.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Integrity {
    /// It is right.
    Verified,
    /// There is none.
    Unprotected,
    /// It is wrong: the body has errors.
    Damaged,
}

/// One packet.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Chapter10Packet<'a> {
    /// Its header.
    pub header: PacketHeader,
    /// Its secondary header, where it has one.
    pub secondary: Option<SecondaryHeader>,
    /// Its body, from the channel specific data word, without filler and checksum.
    pub body: &'a [u8],
    /// Where its first byte stood, bytes from the start of the stream.
    pub at: u64,
    /// What its data checksum says.
    pub integrity: Integrity,
    /// What its sequence number says.
    pub sequence: SequenceStep,
}

impl Chapter10Packet<'_> {
    /// The same with another body, such as a copy of its own that outlives the stream's buffer.
    #[must_use]
    pub fn with_body(self, body: &[u8]) -> Chapter10Packet<'_> {
        let Chapter10Packet { header, secondary, at, integrity, sequence, .. } = self;
        Chapter10Packet { header, secondary, body, at, integrity, sequence }
    }
}

/// What was found so far.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct PacketTally {
    /// Packets that were handed out.
    pub packets: u64,
    /// Of these, those with a wrong data checksum.
    pub damaged: u64,
    /// Of these, those without a data checksum.
    pub unprotected: u64,
    /// Sync patterns that begin no packet: damaged headers, or data that look like one.
    pub refused_headers: u64,
    /// Headers whose packet does not reach as far as they say.
    pub cut_short: u64,
    /// Bytes that belong to no packet that was handed out.
    pub skipped_bytes: u64,
    /// Packets that the sequence numbers say are missing.
    pub missing_packets: u64,
    /// Packets with the sequence number of the one before.
    pub repeated_packets: u64,
    /// Where the first bytes were skipped, bytes from the start.
    pub first_skipped_at: Option<u64>,
    /// The first header that was refused: where it stood, and why.
    pub first_refusal: Option<(u64, Chapter10Error)>,
    /// The first packet that was cut short: where it stood, the bytes that it should have, and those that were there.
    pub first_cut: Option<(u64, u32, u64)>,
}

/// What the bytes at a place are.
enum HeaderVerdict {
    Wait,
    Skip(usize, Option<Refusal>),
    Take(PacketHeader, Option<SecondaryHeader>, Integrity),
}

enum Refusal {
    Header(Chapter10Error),
    CutShort { expected: u32, found: u64, summed: bool },
}

/// Finds packets.
#[derive(Debug)]
pub struct Chapter10Reader {
    limits: PacketLimits,
    buffer: Vec<u8>,
    start: usize,
    /// Place of `start` in the stream.
    position: u64,
    sequences: SequenceCheck,
    /// End of the region of damage, and how many packets were summed in it in vain.
    suspect: (u64, u32),
    tally: PacketTally,
}

impl Default for Chapter10Reader {
    fn default() -> Self {
        Chapter10Reader::new(PacketLimits::default())
    }
}

impl Chapter10Reader {
    /// Nothing seen yet.
    pub fn new(limits: PacketLimits) -> Self {
        Chapter10Reader {
            limits,
            buffer: Vec::new(),
            start: 0,
            position: 0,
            sequences: SequenceCheck::default(),
            suspect: (0, 0),
            tally: PacketTally::default(),
        }
    }

    /// What was found so far.
    pub fn tally(&self) -> PacketTally {
        self.tally
    }

    /// Takes in what there is room for and says how many bytes that was; at least one where [`Chapter10Reader::next_packet`] has
    /// just given `None`.
    pub fn take(&mut self, bytes: &[u8]) -> usize {
        if self.start >= BLOCK || self.start == self.buffer.len() {
            self.buffer.drain(..self.start.min(self.buffer.len()));
            self.start = 0;
        }
        let longest = usize::try_from(self.limits.longest()).unwrap_or(usize::MAX);
        let capacity = longest.saturating_add(HEADER + BLOCK);
        let count = capacity.saturating_sub(self.buffer.len()).min(bytes.len());
        self.buffer.extend_from_slice(bytes.get(..count).unwrap_or_default());
        count
    }

    /// The next packet in what was taken in; `None` where more bytes are needed.
    pub fn next_packet(&mut self) -> Option<Chapter10Packet<'_>> {
        self.search(false)
    }

    /// The next packet where no more bytes belong to those taken in (the end, or a loss); `None` after the last.
    /// Afterwards further bytes may be taken in.
    pub fn finish(&mut self) -> Option<Chapter10Packet<'_>> {
        self.search(true)
    }

    fn search(&mut self, ended: bool) -> Option<Chapter10Packet<'_>> {
        let (header, secondary, integrity) = loop {
            match self.judge(ended) {
                HeaderVerdict::Wait => return None,
                HeaderVerdict::Skip(count, refusal) => self.skip(count, refusal),
                HeaderVerdict::Take(header, secondary, integrity) => break (header, secondary, integrity),
            }
        };
        self.accept(header, secondary, integrity)
    }

    /// What stands at `start`.
    fn judge(&self, ended: bool) -> HeaderVerdict {
        let window = self.buffer.get(self.start..).unwrap_or_default();
        let wait_or = |verdict: HeaderVerdict| if ended { verdict } else { HeaderVerdict::Wait };
        if window.is_empty() {
            return HeaderVerdict::Wait;
        }
        match sync_at(window, 0) {
            Some(0) => {}
            Some(skip) => return HeaderVerdict::Skip(skip, None),
            None if window.last() == SYNC.to_le_bytes().first() => {
                let rest = window.len() - 1;
                return if rest > 0 { HeaderVerdict::Skip(rest, None) } else { wait_or(HeaderVerdict::Skip(1, None)) };
            }
            None => return HeaderVerdict::Skip(window.len(), None),
        }
        let header = match PacketHeader::parse(window, &self.limits) {
            Ok(header) => header,
            Err(Chapter10Error::Short { .. }) => return wait_or(HeaderVerdict::Skip(1, None)),
            Err(error) => return HeaderVerdict::Skip(1, Some(Refusal::Header(error))),
        };
        let length = usize::try_from(header.packet_length).unwrap_or(usize::MAX);
        let cut = |skip: usize, summed: bool| {
            let found = window.len().min(if summed { skip } else { length }) as u64;
            HeaderVerdict::Skip(skip, Some(Refusal::CutShort { expected: header.packet_length, found, summed }))
        };
        let Some((packet, behind)) = window.split_at_checked(length) else { return wait_or(cut(1, false)) };
        let secondary = if header.has_secondary() {
            match SecondaryHeader::parse(&header, packet.get(HEADER..).unwrap_or_default()) {
                Ok(secondary) => Some(secondary),
                Err(error) => return HeaderVerdict::Skip(1, Some(Refusal::Header(error))),
            }
        } else {
            None
        };
        let weary = self.position < self.suspect.0 && self.suspect.1 >= SUSPECT_CHECKS;
        let trailer = packet.get(header.headers()..).unwrap_or_default();
        let mut integrity = None;
        if !weary {
            integrity = Some(integrity_of(&header, trailer));
            if integrity == Some(Integrity::Verified) {
                return HeaderVerdict::Take(header, secondary, Integrity::Verified);
            }
        }
        let followed = match PacketHeader::parse(behind, &self.limits) {
            Ok(_) => true,
            Err(Chapter10Error::Short { .. }) if !ended => return HeaderVerdict::Wait,
            Err(_) => behind.is_empty(),
        };
        if followed {
            return HeaderVerdict::Take(header, secondary, integrity.unwrap_or_else(|| integrity_of(&header, trailer)));
        }
        match (integrity, inner_header(packet, &self.limits)) {
            (_, Some(inner)) => cut(inner, true),
            (Some(integrity), None) => HeaderVerdict::Take(header, secondary, integrity),
            (None, None) => cut(1, false),
        }
    }

    fn skip(&mut self, count: usize, refusal: Option<Refusal>) {
        let at = self.position;
        match refusal {
            None => {}
            Some(Refusal::Header(error)) => {
                self.tally.refused_headers += 1;
                self.tally.first_refusal.get_or_insert((at, error));
            }
            Some(Refusal::CutShort { expected, found, summed }) => {
                self.tally.cut_short += 1;
                self.tally.first_cut.get_or_insert((at, expected, found));
                if summed {
                    let checks = if at < self.suspect.0 { self.suspect.1 + 1 } else { 1 };
                    self.suspect = (self.suspect.0.max(at + u64::from(expected)), checks);
                }
            }
        }
        self.tally.first_skipped_at.get_or_insert(at);
        self.tally.skipped_bytes += count as u64;
        self.start += count;
        self.position += count as u64;
    }

    fn accept(
        &mut self,
        header: PacketHeader,
        secondary: Option<SecondaryHeader>,
        integrity: Integrity,
    ) -> Option<Chapter10Packet<'_>> {
        let length = usize::try_from(header.packet_length).ok()?;
        let (from, at) = (self.start + header.headers(), self.position);
        self.start += length;
        self.position += u64::from(header.packet_length);
        self.tally.packets += 1;
        match integrity {
            Integrity::Verified => {}
            Integrity::Unprotected => self.tally.unprotected += 1,
            Integrity::Damaged => self.tally.damaged += 1,
        }
        let sequence = self.sequences.step(header.channel, header.sequence);
        match sequence {
            SequenceStep::Gap(missing) => self.tally.missing_packets += u64::from(missing),
            SequenceStep::Repeated => self.tally.repeated_packets += 1,
            SequenceStep::First | SequenceStep::Next => {}
        }
        let data_length = usize::try_from(header.data_length).ok()?;
        let body = self.buffer.get(from..from.checked_add(data_length)?)?;
        Some(Chapter10Packet { header, secondary, body, at, integrity, sequence })
    }
}

fn integrity_of(header: &PacketHeader, trailer: &[u8]) -> Integrity {
    match header.checksum().verify(trailer) {
        None => Integrity::Unprotected,
        Some(true) => Integrity::Verified,
        Some(false) => Integrity::Damaged,
    }
}

/// The place of the next sync pattern at or behind `from`.
fn sync_at(bytes: &[u8], from: usize) -> Option<usize> {
    let pattern = SYNC.to_le_bytes();
    bytes.get(from..)?.windows(2).position(|pair| pair == pattern).map(|at| at + from)
}

/// The place of a header inside a packet, behind the packet's own.
fn inner_header(packet: &[u8], limits: &PacketLimits) -> Option<usize> {
    let mut from = 2;
    loop {
        let at = sync_at(packet, from)?;
        // A header that the end of the packet cuts off is found where the search goes on.
        match PacketHeader::parse(packet.get(at..)?, limits) {
            Ok(_) | Err(Chapter10Error::Short { .. }) => return Some(at),
            Err(_) => from = at + 2,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::packet_test::{Noise, packet};
    use super::*;

    /// Channel, sequence and integrity of every packet, and the tally.
    fn read(bytes: &[u8], mut piece: impl FnMut() -> usize) -> (Vec<(u16, u8, Integrity, u64)>, PacketTally) {
        let mut reader = Chapter10Reader::new(PacketLimits { setup_record: 4096, other: 2048 });
        let mut found = Vec::new();
        let mut rest = bytes;
        while !rest.is_empty() {
            let (now, later) = rest.split_at(piece().clamp(1, rest.len()));
            let mut taken = 0;
            while taken < now.len() {
                taken += reader.take(&now[taken..]);
                while let Some(packet) = reader.next_packet() {
                    found.push((packet.header.channel, packet.header.sequence, packet.integrity, packet.at));
                }
            }
            rest = later;
        }
        while let Some(packet) = reader.finish() {
            found.push((packet.header.channel, packet.header.sequence, packet.integrity, packet.at));
        }
        (found, reader.tally())
    }

    fn sample(noise: &mut Noise, sequence: u8) -> Vec<u8> {
        let body: Vec<u8> = (0..4 + noise.below(300)).map(|_| noise.next() as u8).collect();
        packet(1 + noise.below(3) as u16, 0x09, sequence, noise.next(), &body, noise.below(4) as u8)
    }

    #[test]
    fn whole_packets_come_as_they_are_in_pieces_of_any_size() {
        let mut noise = Noise(11);
        let packets: Vec<_> = (0..60).map(|k| sample(&mut noise, k)).collect();
        let bytes = packets.concat();
        let (whole, tally) = read(&bytes, || usize::MAX);
        assert_eq!((whole.len(), tally.skipped_bytes, tally.damaged, tally.refused_headers), (60, 0, 0, 0));
        let mut pieces = Noise(12);
        for most in [1, 2, 3, 30, 700] {
            assert_eq!(read(&bytes, || 1 + pieces.below(most)), (whole.clone(), tally), "{most}");
        }
    }

    #[test]
    fn damage_of_any_kind_costs_little_and_is_the_same_in_pieces_of_any_size() {
        for seed in 1..200 {
            let mut noise = Noise(seed * 7919);
            let packets: Vec<_> = (0..30).map(|k| sample(&mut noise, k)).collect();
            let mut bytes = packets.concat();
            for _ in 0..5 {
                let at = noise.below(bytes.len());
                match noise.below(3) {
                    0 => bytes[at] ^= 1 << noise.below(8),
                    1 => drop(bytes.drain(at..(at + noise.below(40)).min(bytes.len()))),
                    _ => drop(bytes.splice(at..at, [0x25, 0xEB, 1, 2, 3])),
                }
            }
            let (whole, tally) = read(&bytes, || usize::MAX);
            let verified = whole.iter().filter(|found| found.2 != Integrity::Damaged).count();
            assert!(verified >= 18, "seed {seed}: {verified} of 30, {tally:?}");
            let mut pieces = Noise(seed);
            assert_eq!(read(&bytes, || 1 + pieces.below(50)), (whole, tally), "seed {seed}");
        }
    }

    #[test]
    fn each_kind_of_loss_has_its_counter() {
        let good = |sequence| packet(5, 0x09, sequence, 9, &[7; 20], 2);
        let mut damaged = good(1);
        damaged[30] ^= 4;
        let mut broken = good(2);
        broken[9] ^= 1;
        let short = &good(3)[..30];
        let bytes =
            [vec![0x25, 9, 9], good(0), damaged, broken, good(3), short.to_vec(), good(4), good(5)[..40].to_vec()].concat();
        let (found, tally) = read(&bytes, || usize::MAX);
        let expected = [(5, 0, Integrity::Verified, 3), (5, 1, Integrity::Damaged, 51), (5, 3, Integrity::Verified, 147)];
        assert_eq!(found, [&expected[..], &[(5, 4, Integrity::Verified, 225)]].concat());
        assert_eq!((tally.damaged, tally.refused_headers, tally.cut_short, tally.missing_packets), (1, 1, 2, 1));
        assert_eq!(tally.skipped_bytes, 3 + 48 + 30 + 40);
        assert_eq!(tally.first_refusal.map(|(at, _)| at), Some(99));
        assert_eq!((tally.first_cut, tally.first_skipped_at), (Some((195, 48, 30)), Some(0)));
    }

    #[test]
    fn noise_makes_no_packets_and_hostile_headers_do_not_take_time() {
        let mut noise = Noise(3);
        let bytes: Vec<u8> = (0..200_000).map(|_| noise.next() as u8).collect();
        let (found, tally) = read(&bytes, || 1000);
        assert_eq!((found.len(), tally.skipped_bytes), (0, 200_000));
        // Headers that each claim the whole rest, with a checksum that is wrong.
        let header = packet(1, 0x09, 0, 0, &[1; 2000], 3)[..24].to_vec();
        let bytes: Vec<u8> = header.iter().copied().cycle().take(24 * 100_000).collect();
        let begun = std::time::Instant::now();
        let (_, tally) = read(&bytes, || 5000);
        assert!(tally.refused_headers + tally.cut_short + tally.packets > 1000);
        assert!(begun.elapsed().as_secs() < 5, "{:?}", begun.elapsed());
    }
}
