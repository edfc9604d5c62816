//! PCM data packets, format 1: minor frames with their times, or bits as they came.
//!
//! Consumes packets of data type 09; produces, in unpacked and packed mode, every [`RecordedFrame`] with its time and lock
//! status, in throughput mode the bits and the time of the first one. The channel specific word (32 bits, little-endian):
//! | bits | | | bits | |
//! | --- | --- | --- | --- | --- |
//! | 17-0 | word offset into the major frame of the first word | | 25-24 | major frame: 0 not locked, 2 check, 3 lock |
//! | 18 19 20 | unpacked, packed, throughput mode | | 28 29 | the first word begins a minor, a major frame |
//! | 21 | alignment 16 (0) or 32 bits (1) | | 30 | intra-packet headers (always in the first two modes) |
//! | 27-26 | minor frame: 2 check, 3 lock | | 23-22 31 | reserved |
//!
//! The intra-packet header before each frame is 8 bytes of time (the relative time counter in the lower 48 bits, or the
//! format of the secondary header) and a word of 16 or, in 32-bit alignment, 32 bits whose bits 15-12 are the lock status.
//! The bits of the link stand in little-endian words of 16 or 32 bits, the bit that came first at the most significant place:
//! they are handed out as bytes whose most significant bit came first. Times are those of the first bit of frame or packet.
//! Refused: a packet that names no mode or several, frames without headers, data that are no whole number of frames.
//! Source: IRIG 106-09 Chapter 10, 10.6.2 and figures 10-14 to 10-19; since 106-17 Chapter 11, 11.2.2.

use super::error::Chapter10Error;
use super::header::{PacketHeader, RTC_MODULUS, SecondaryTime, data_type, u16_at, u32_at, u64_at};
use super::packet::Chapter10Packet;
pub use super::pcm_layout::{PcmAlignment, PcmMode, WordMap};
use super::recorded_words::RecordedWords;

/// A frame synchroniser's state.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FrameLock {
    /// Not locked (of a minor frame: a code that the standard reserves).
    None,
    /// A code that the standard reserves.
    Reserved,
    /// Checking after the lock was lost.
    Check,
    /// Locked.
    Lock,
}

impl FrameLock {
    const fn of(bits: u32) -> Self {
        match bits & 3 {
            0 => FrameLock::None,
            1 => FrameLock::Reserved,
            2 => FrameLock::Check,
            _ => FrameLock::Lock,
        }
    }
}

/// What the recorder's frame synchroniser says.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct LockStatus {
    /// Of minor frames.
    pub minor: FrameLock,
    /// Of major frames.
    pub major: FrameLock,
}

impl LockStatus {
    /// Of four bits.
    const fn of(bits: u32) -> Self {
        LockStatus { minor: FrameLock::of(bits >> 2), major: FrameLock::of(bits) }
    }
}

/// The channel specific word.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PcmChannelWord {
    /// Word offset into the major frame of the first word (unpacked mode).
    pub sync_offset: u32,
    /// Mode.
    pub mode: PcmMode,
    /// Alignment.
    pub alignment: PcmAlignment,
    /// Lock status (not in throughput mode).
    pub lock: LockStatus,
    /// Whether the first word begins a minor frame.
    pub begins_minor_frame: bool,
    /// Whether the first word begins a major frame.
    pub begins_major_frame: bool,
    /// Whether a header stands before each frame.
    pub intra_packet_headers: bool,
}

impl PcmChannelWord {
    /// Reads the word.
    ///
    /// # Errors
    /// [`Chapter10Error`] where it names no mode or several.
    pub fn parse(word: u32) -> Result<Self, Chapter10Error> {
        let mode = match word >> 18 & 7 {
            1 => PcmMode::Unpacked,
            2 => PcmMode::Packed,
            4 => PcmMode::Throughput,
            bits => return Err(Chapter10Error::PcmMode { bits: bits as u8 }),
        };
        Ok(PcmChannelWord {
            sync_offset: word & 0x3_FFFF,
            mode,
            alignment: if word >> 21 & 1 == 1 { PcmAlignment::Bits32 } else { PcmAlignment::Bits16 },
            lock: LockStatus::of(word >> 24),
            begins_minor_frame: word >> 28 & 1 == 1,
            begins_major_frame: word >> 29 & 1 == 1,
            intra_packet_headers: word >> 30 & 1 == 1,
        })
    }
}

/// The time of a first bit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BitTime {
    /// Relative time counter, 10 MHz, 48 bits.
    Rtc(u64),
    /// A time in a format of the secondary header.
    Secondary(SecondaryTime),
}

/// The bits of a packet in throughput mode.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BitRun {
    /// Time of the first bit.
    pub time: BitTime,
    /// How many bits there are.
    pub bits: u64,
    /// Bytes at the end that make no whole word of the alignment and were left out.
    pub rest_bytes: usize,
}

/// A PCM packet.
#[derive(Clone, Copy, Debug)]
pub struct PcmPacket<'a> {
    /// Its channel specific word.
    pub word: PcmChannelWord,
    header: PacketHeader,
    packet_time: BitTime,
    data: &'a [u8],
}

impl<'a> PcmPacket<'a> {
    /// Reads the channel specific word of a packet.
    ///
    /// # Errors
    /// [`Chapter10Error`] where it is another kind of packet or cannot be read.
    pub fn parse(packet: &Chapter10Packet<'a>) -> Result<Self, Chapter10Error> {
        let (header, found) = (packet.header, packet.header.data_type);
        if found != data_type::PCM_1 {
            return Err(Chapter10Error::DataType { expected: data_type::PCM_1, found });
        }
        let short = Chapter10Error::Short { what: "PCM packet", expected: 4, found: packet.body.len() as u64 };
        let word = PcmChannelWord::parse(u32_at(packet.body, 0).ok_or(short)?)?;
        let packet_time = match packet.secondary {
            Some(secondary) if header.intra_packet_time_is_secondary() => BitTime::Secondary(secondary.time),
            _ => BitTime::Rtc(header.rtc),
        };
        Ok(PcmPacket { word, header, packet_time, data: packet.body.get(4..).ok_or(short)? })
    }

    /// Length of the header before each frame, bytes.
    pub fn intra_packet_header(&self) -> usize {
        match (self.word.mode, self.word.alignment) {
            (PcmMode::Throughput, _) => 0,
            (_, PcmAlignment::Bits16) => 10,
            (_, PcmAlignment::Bits32) => 12,
        }
    }

    /// Appends the data to `out`, the bit that came first at the most significant place of the first byte. In throughput mode
    /// these are the bits of the link, otherwise frames with their headers.
    pub fn bits(&self, out: &mut Vec<u8>) -> BitRun {
        let before = out.len();
        match self.word.alignment {
            PcmAlignment::Bits16 => extend_reversed::<2>(out, self.data),
            PcmAlignment::Bits32 => extend_reversed::<4>(out, self.data),
        }
        let bytes = out.len() - before;
        BitRun { time: self.packet_time, bits: 8 * bytes as u64, rest_bytes: self.data.len() - bytes }
    }

    /// The minor frames; `map` must be made for the mode and alignment of the packet. `scratch` is cleared and holds
    /// their bits.
    ///
    /// # Errors
    /// [`Chapter10Error`] where the packet has no frames, or its data are no whole number of such frames.
    pub fn frames<'b>(&self, map: &'b WordMap, scratch: &'b mut Vec<u8>) -> Result<MinorFrames<'b>, Chapter10Error>
    where
        'a: 'b,
    {
        if self.word.mode == PcmMode::Throughput {
            return Err(Chapter10Error::PcmThroughput);
        }
        if !self.word.intra_packet_headers {
            return Err(Chapter10Error::PcmNoIntraPacketHeader);
        }
        if (map.mode, map.alignment) != (self.word.mode, self.word.alignment) {
            let what = "a word map for the mode and alignment of the packet";
            return Err(Chapter10Error::PcmLayout { what, found: map.bytes as u64 });
        }
        let frame = self.intra_packet_header() + map.bytes;
        let rest = self.data.len() % frame;
        if rest != 0 {
            let (frame, found, rest) = (frame as u64, self.data.len() as u64, rest as u64);
            return Err(Chapter10Error::PcmRest { frame, found, rest });
        }
        scratch.clear();
        self.bits(scratch);
        Ok(MinorFrames { header: self.header, iph: self.intra_packet_header(), frame, data: self.data, bits: scratch, map })
    }
}

/// The minor frames of a packet.
#[derive(Clone, Debug)]
pub struct MinorFrames<'b> {
    header: PacketHeader,
    iph: usize,
    frame: usize,
    data: &'b [u8],
    bits: &'b [u8],
    map: &'b WordMap,
}

impl<'b> Iterator for MinorFrames<'b> {
    type Item = RecordedFrame<'b>;

    fn next(&mut self) -> Option<RecordedFrame<'b>> {
        let (data, later) = self.data.split_at_checked(self.frame)?;
        let (bits, bits_later) = self.bits.split_at_checked(self.frame)?;
        let time = if self.header.intra_packet_time_is_secondary() {
            BitTime::Secondary(self.header.secondary_time(data)?)
        } else {
            BitTime::Rtc(u64_at(data, 0)? & (RTC_MODULUS - 1))
        };
        let lock = LockStatus::of(u32::from(u16_at(data, 8)?) >> 12);
        (self.data, self.bits) = (later, bits_later);
        Some(RecordedFrame { time, lock, bits: bits.get(self.iph..)?, map: self.map })
    }
}

/// One minor frame.
#[derive(Clone, Copy, Debug)]
pub struct RecordedFrame<'b> {
    /// Time of its first bit.
    pub time: BitTime,
    /// Lock status of the recorder's frame synchroniser.
    pub lock: LockStatus,
    /// Its recorded bits, with the filler of the mode; the most significant bit came first.
    pub bits: &'b [u8],
    map: &'b WordMap,
}

impl RecordedFrame<'_> {
    /// The sync pattern, its first bit the most significant.
    pub fn sync(&self) -> u64 {
        self.map.sync.read(self.bits).unwrap_or(0)
    }

    /// The words behind the sync pattern, their first bits the most significant.
    pub fn words(&self) -> RecordedWords<'_> {
        self.map.words_of(self.bits)
    }
}

/// Appends the whole groups of so many bytes, each in the reverse order.
fn extend_reversed<const BYTES: usize>(out: &mut Vec<u8>, data: &[u8]) {
    let before = out.len();
    let (groups, _) = data.as_chunks::<BYTES>();
    out.extend_from_slice(groups.as_flattened());
    let (groups, _) = out.get_mut(before..).unwrap_or_default().as_chunks_mut::<BYTES>();
    groups.iter_mut().for_each(|group| group.reverse());
}

#[cfg(test)]
mod tests {
    use super::super::packet::{Chapter10Reader, PacketTally};
    use super::super::packet_test::packet;
    use super::super::pcm_layout::{PcmLayout, UnpackedForm};
    use super::*;

    fn with<T>(body: &[u8], mut each: impl FnMut(&Chapter10Packet<'_>) -> T) -> T {
        let mut reader = Chapter10Reader::default();
        reader.take(&packet(1, 0x09, 0, 777, body, 3));
        let found = reader.next_packet().map(|packet| each(&packet)).unwrap();
        assert_eq!(reader.tally(), PacketTally { packets: 1, ..PacketTally::default() });
        found
    }

    type FoundFrame = (BitTime, LockStatus, u64, Vec<u64>);

    fn frames(body: &[u8], layout: &PcmLayout) -> Result<Vec<FoundFrame>, Chapter10Error> {
        with(body, |packet| {
            let pcm = PcmPacket::parse(packet)?;
            let map = layout.map(pcm.word.mode, pcm.word.alignment, UnpackedForm::default()).unwrap();
            let mut scratch = Vec::new();
            let frames = pcm.frames(&map, &mut scratch)?;
            Ok(frames.map(|frame| (frame.time, frame.lock, frame.sync(), frame.words().collect())).collect())
        })
    }

    #[test]
    fn unpacked_words_in_16_bit_alignment() {
        let layout = PcmLayout::uniform(32, 12, 2).unwrap();
        let iph = |rtc: u8, lock: u8| [rtc, 0, 0, 0, 0, 0, 0, 0, 0, lock];
        // FE6B 2840, then ABC and 123 with four bits of filler behind them.
        let words = [0x6B, 0xFE, 0x40, 0x28, 0xC0, 0xAB, 0x30, 0x12];
        let body = [&[5, 0, 0x04, 0x7B][..], &iph(9, 0xF0), &words, &iph(12, 0x80), &words].concat();
        let lock = LockStatus { minor: FrameLock::Lock, major: FrameLock::Lock };
        let check = LockStatus { minor: FrameLock::Check, major: FrameLock::None };
        let expected = vec![
            (BitTime::Rtc(9), lock, 0xFE6B_2840, vec![0xABC, 0x123]),
            (BitTime::Rtc(12), check, 0xFE6B_2840, vec![0xABC, 0x123]),
        ];
        assert_eq!(frames(&body, &layout), Ok(expected));
        let word = with(&body, |packet| PcmPacket::parse(packet).unwrap().word);
        assert_eq!((word.sync_offset, word.mode, word.alignment), (5, PcmMode::Unpacked, PcmAlignment::Bits16));
        assert_eq!(word.lock, LockStatus { minor: FrameLock::Check, major: FrameLock::Lock });
        assert!(word.begins_minor_frame && word.begins_major_frame && word.intra_packet_headers);
        assert_eq!(frames(&body[..body.len() - 2], &layout), Err(Chapter10Error::PcmRest { frame: 18, found: 34, rest: 16 }));
    }

    #[test]
    fn packed_words_in_32_bit_alignment() {
        // Sync EB9, then the words 3, 7F and 155 of 2, 7 and 9 bits: 1110 1011 1001 11 1111111 101010101 00, in 32-bit words.
        let bits: u32 = 0b1110_1011_1001_1111_1111_1101_0101_0100;
        let iph = [1, 2, 3, 4, 5, 6, 0xFF, 0xFF, 0, 0x40, 0, 0];
        let body = [&[0, 0, 0x28, 0x40][..], &iph, &bits.to_le_bytes()].concat();
        let layout = PcmLayout::new(12, vec![2, 7, 9]).unwrap();
        let found = frames(&body, &layout).unwrap();
        let lock = LockStatus { minor: FrameLock::Reserved, major: FrameLock::None };
        assert_eq!(found, [(BitTime::Rtc(0x0605_0403_0201), lock, 0xEB9, vec![3, 0x7F, 0x155])]);
    }

    #[test]
    fn throughput_hands_out_bits_in_the_order_in_which_they_came() {
        let run = |body: &[u8]| {
            with(body, |packet| {
                let mut bits = vec![0xAA];
                let run = PcmPacket::parse(packet).unwrap().bits(&mut bits);
                (bits, run)
            })
        };
        let (bits, found) = run(&[0, 0, 0x10, 0, 0x6B, 0xFE, 0x40, 0x28, 9]);
        assert_eq!(bits, [0xAA, 0xFE, 0x6B, 0x28, 0x40]);
        assert_eq!(found, BitRun { time: BitTime::Rtc(777), bits: 32, rest_bytes: 1 });
        assert_eq!(run(&[0, 0, 0x30, 0, 0x40, 0x28, 0x6B, 0xFE]).0, [0xAA, 0xFE, 0x6B, 0x28, 0x40]);
        let layout = PcmLayout::uniform(32, 16, 1).unwrap();
        let map = layout.map(PcmMode::Packed, PcmAlignment::Bits16, UnpackedForm::default()).unwrap();
        let refused = |body: &[u8]| {
            with(body, |packet| {
                let mut scratch = Vec::new();
                PcmPacket::parse(packet).and_then(|pcm| pcm.frames(&map, &mut scratch).map(|_| ()))
            })
        };
        assert_eq!(refused(&[0, 0, 0x10, 0]), Err(Chapter10Error::PcmThroughput));
        assert_eq!(refused(&[0, 0, 0x18, 0]), Err(Chapter10Error::PcmMode { bits: 6 }));
        assert_eq!(refused(&[0, 0, 0x08, 0]), Err(Chapter10Error::PcmNoIntraPacketHeader));
        assert!(matches!(refused(&[0, 0, 0x04, 0x40]), Err(Chapter10Error::PcmLayout { .. })));
        assert!(matches!(refused(&[0, 0]), Err(Chapter10Error::Short { .. })));
    }
}
