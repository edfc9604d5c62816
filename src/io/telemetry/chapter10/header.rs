//! Packet header and packet secondary header of a recording.
//!
//! Consumes the first bytes of a packet; produces [`PacketHeader`] and [`SecondaryHeader`]. All fields are little-endian.
//! | byte | field | | byte | field |
//! | --- | --- | --- | --- | --- |
//! | 0 | sync pattern EB25 | | 13 | sequence number, one more with every packet of the channel |
//! | 2 | channel | | 14 | packet flags |
//! | 4 | packet length: headers, body, filler and checksum, bytes | | 15 | data type |
//! | 8 | data length: body without filler and checksum, bytes | | 16 | relative time counter, 48 bits, 10 MHz |
//! | 12 | data type version | | 22 | sum of the eleven 16-bit words before it |
//!
//! Packet flags: bit 7 secondary header present, 6 intra-packet times have the format of the secondary header, 5 error of the
//! relative time counter, 4 data overflow, 3-2 format of the secondary header's time, 1-0 data checksum (none, 8, 16, 32
//! bits). The secondary header is 8 bytes of time, 2 reserved and a checksum. The standard calls that checksum the sum of the
//! *bytes* before it, while that of the packet header is one of words; readers of either kind exist, so either is accepted.
//! Refused: a wrong sync pattern or checksum, lengths that contradict each other or the limits.
//! Source: IRIG 106-09 Chapter 10, 10.6.1 (common packet elements); since 106-17 Chapter 11, 11.2.1. The third time format
//! (extended relative time counter) came after 106-09. The layout of the first one (Chapter 4 binary weighted time) was not
//! verified: it is handed out as it stands.

use super::error::Chapter10Error;

/// The first two bytes of every packet, as a little-endian number.
pub const SYNC: u16 = 0xEB25;
/// Length of the packet header, bytes.
pub const HEADER: usize = 24;
/// Length of the secondary header, bytes.
pub const SECONDARY: usize = 12;
/// Ticks of the relative time counter in a second.
pub const TICKS_PER_SECOND: u64 = 10_000_000;
/// The relative time counter counts modulo this.
pub const RTC_MODULUS: u64 = 1 << 48;

/// Data types of which this module reads the body.
pub mod data_type {
    /// Computer generated data, format 1: the setup record.
    pub const SETUP_RECORD: u8 = 0x01;
    /// PCM data, format 1.
    pub const PCM_1: u8 = 0x09;
    /// Time data, format 1.
    pub const TIME_1: u8 = 0x11;
}

/// The longest packets that are read, bytes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PacketLimits {
    /// Setup records (data type 01).
    pub setup_record: u32,
    /// All other packets.
    pub other: u32,
}

impl Default for PacketLimits {
    /// The standard's 524,288 bytes, and 4 MiB for setup records (of which the standard allows 128).
    fn default() -> Self {
        PacketLimits { setup_record: 4 << 20, other: 512 << 10 }
    }
}

impl PacketLimits {
    /// The longest packet of all.
    pub fn longest(&self) -> u32 {
        self.setup_record.max(self.other)
    }
}

/// How the body is protected.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DataChecksum {
    /// Not at all.
    None,
    /// Sum of its bytes.
    Bits8,
    /// Sum of its 16-bit words.
    Bits16,
    /// Sum of its 32-bit words.
    Bits32,
}

impl DataChecksum {
    /// Bytes that it takes at the end of the packet.
    pub const fn bytes(self) -> u32 {
        match self {
            DataChecksum::None => 0,
            DataChecksum::Bits8 => 1,
            DataChecksum::Bits16 => 2,
            DataChecksum::Bits32 => 4,
        }
    }

    /// Whether the last bytes are the sum of those before them; `None` where there is no checksum. `trailer` is everything
    /// behind the headers: body, filler and checksum.
    pub fn verify(self, trailer: &[u8]) -> Option<bool> {
        let width = usize::try_from(self.bytes()).unwrap_or(0);
        let at = trailer.len().checked_sub(width)?;
        let (data, sum) = trailer.split_at_checked(at)?;
        match self {
            DataChecksum::None => None,
            DataChecksum::Bits8 => {
                Some(data.iter().fold(0_u8, |sum, byte| sum.wrapping_add(*byte)) == sum.first().copied().unwrap_or(0))
            }
            DataChecksum::Bits16 => {
                let (words, rest) = data.as_chunks::<2>();
                let total = words.iter().fold(0_u16, |sum, word| sum.wrapping_add(u16::from_le_bytes(*word)));
                Some(total.wrapping_add(u16::from(rest.first().copied().unwrap_or(0))) == u16_at(sum, 0).unwrap_or(0))
            }
            DataChecksum::Bits32 => {
                let (words, rest) = data.as_chunks::<4>();
                let total = words.iter().fold(0_u32, |sum, word| sum.wrapping_add(u32::from_le_bytes(*word)));
                let last = rest.iter().rev().fold(0_u32, |value, byte| value << 8 | u32::from(*byte));
                Some(total.wrapping_add(last) == u32_at(sum, 0).unwrap_or(0))
            }
        }
    }
}

/// The packet header.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PacketHeader {
    /// The channel.
    pub channel: u16,
    /// Length of the whole packet, bytes.
    pub packet_length: u32,
    /// Length of the body without filler and checksum, bytes.
    pub data_length: u32,
    /// Version of the data type: 1 is 106-04, 2 106-05, 3 106-07, 4 106-09, and so on.
    pub data_version: u8,
    /// Running number of the packets of the channel.
    pub sequence: u8,
    /// Flags, see the head of this file.
    pub flags: u8,
    /// Kind of data.
    pub data_type: u8,
    /// Relative time counter, 10 MHz, 48 bits: the time of the first bit of the body's data.
    pub rtc: u64,
}

impl PacketHeader {
    /// Reads a header. The length may exceed the bytes that are there, not the limits.
    ///
    /// # Errors
    /// [`Chapter10Error`] where this is no header.
    pub fn parse(bytes: &[u8], limits: &PacketLimits) -> Result<Self, Chapter10Error> {
        let short = Chapter10Error::Short { what: "packet header", expected: HEADER as u64, found: bytes.len() as u64 };
        let bytes = bytes.get(..HEADER).ok_or(short)?;
        let found = u16_at(bytes, 0).ok_or(short)?;
        if found != SYNC {
            return Err(Chapter10Error::Sync { found });
        }
        let expected = sum_of_words(bytes.get(..HEADER - 2).ok_or(short)?);
        let found = u16_at(bytes, 22).ok_or(short)?;
        if expected != found {
            return Err(Chapter10Error::HeaderChecksum { expected, found });
        }
        let byte = |at: usize| bytes.get(at).copied().ok_or(short);
        let header = PacketHeader {
            channel: u16_at(bytes, 2).ok_or(short)?,
            packet_length: u32_at(bytes, 4).ok_or(short)?,
            data_length: u32_at(bytes, 8).ok_or(short)?,
            data_version: byte(12)?,
            sequence: byte(13)?,
            flags: byte(14)?,
            data_type: byte(15)?,
            rtc: u64_at(bytes, 16).ok_or(short)? & (RTC_MODULUS - 1),
        };
        header.check_lengths(limits)?;
        Ok(header)
    }

    fn check_lengths(&self, limits: &PacketLimits) -> Result<(), Chapter10Error> {
        let overhead = self.headers_u32() + self.checksum().bytes();
        let found = self.packet_length;
        if !found.is_multiple_of(4) || found < overhead {
            return Err(Chapter10Error::PacketLength { least: overhead, found });
        }
        let setup = self.data_type == data_type::SETUP_RECORD;
        let limit = if setup { limits.setup_record } else { limits.other };
        if found > limit {
            return Err(Chapter10Error::TooLong { limit, found });
        }
        let room = found - overhead;
        if self.data_length > room {
            return Err(Chapter10Error::DataLength { room, found: self.data_length });
        }
        Ok(())
    }

    /// Whether there is a secondary header.
    pub const fn has_secondary(&self) -> bool {
        self.flags & 0x80 != 0
    }

    /// Whether intra-packet time stamps have the format of the secondary header's time, and are not relative time counters.
    pub const fn intra_packet_time_is_secondary(&self) -> bool {
        self.flags & 0x40 != 0
    }

    /// Whether the recorder reports an error of its relative time counter.
    pub const fn time_error(&self) -> bool {
        self.flags & 0x20 != 0
    }

    /// Whether the recorder lost data before or in this packet.
    pub const fn overflow(&self) -> bool {
        self.flags & 0x10 != 0
    }

    /// How the body is protected.
    pub const fn checksum(&self) -> DataChecksum {
        match self.flags & 3 {
            0 => DataChecksum::None,
            1 => DataChecksum::Bits8,
            2 => DataChecksum::Bits16,
            _ => DataChecksum::Bits32,
        }
    }

    /// Length of both headers, bytes.
    pub const fn headers(&self) -> usize {
        if self.has_secondary() { HEADER + SECONDARY } else { HEADER }
    }

    const fn headers_u32(&self) -> u32 {
        if self.has_secondary() { 36 } else { 24 }
    }

    /// Reads a time of 8 bytes in the format that this packet's secondary header has.
    pub fn secondary_time(&self, bytes: &[u8]) -> Option<SecondaryTime> {
        let raw = u64_at(bytes, 0)?;
        let [low, high] = [u32_at(bytes, 0)?, u32_at(bytes, 4)?];
        Some(match self.flags >> 2 & 3 {
            0 => SecondaryTime::Chapter4(raw),
            1 => SecondaryTime::Ieee1588 { seconds: high, nanoseconds: low },
            2 => SecondaryTime::ExtendedRtc(raw),
            _ => SecondaryTime::Reserved(raw),
        })
    }
}

/// A time of the secondary header.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SecondaryTime {
    /// Binary weighted time after Chapter 4, as its 8 bytes stand.
    Chapter4(u64),
    /// IEEE 1588.
    Ieee1588 {
        /// Seconds.
        seconds: u32,
        /// Nanoseconds.
        nanoseconds: u32,
    },
    /// A counter of 64 bits and 1 GHz.
    ExtendedRtc(u64),
    /// A format that the standard does not define, as its 8 bytes stand.
    Reserved(u64),
}

/// The packet secondary header.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SecondaryHeader {
    /// Time of the first bit of the body's data.
    pub time: SecondaryTime,
}

impl SecondaryHeader {
    /// Reads the secondary header that follows `header`.
    ///
    /// # Errors
    /// [`Chapter10Error`] where its checksum is wrong or bytes are missing.
    pub fn parse(header: &PacketHeader, bytes: &[u8]) -> Result<Self, Chapter10Error> {
        let short = Chapter10Error::Short { what: "secondary header", expected: SECONDARY as u64, found: bytes.len() as u64 };
        let covered = bytes.get(..SECONDARY - 2).ok_or(short)?;
        let found = u16_at(bytes, SECONDARY - 2).ok_or(short)?;
        let expected = covered.iter().fold(0_u16, |sum, byte| sum.wrapping_add(u16::from(*byte)));
        if found != expected && found != sum_of_words(covered) {
            return Err(Chapter10Error::SecondaryChecksum { expected, found });
        }
        header.secondary_time(covered).map(|time| SecondaryHeader { time }).ok_or(short)
    }
}

/// Sum of the little-endian 16-bit words, modulo 65,536.
pub(super) fn sum_of_words(bytes: &[u8]) -> u16 {
    let (words, _) = bytes.as_chunks::<2>();
    words.iter().fold(0, |sum, word| sum.wrapping_add(u16::from_le_bytes(*word)))
}

/// The little-endian number at a place.
pub(super) fn u16_at(bytes: &[u8], at: usize) -> Option<u16> {
    bytes.get(at..)?.first_chunk().map(|word| u16::from_le_bytes(*word))
}

/// The little-endian number at a place.
pub(super) fn u32_at(bytes: &[u8], at: usize) -> Option<u32> {
    bytes.get(at..)?.first_chunk().map(|word| u32::from_le_bytes(*word))
}

/// The little-endian number at a place.
pub(super) fn u64_at(bytes: &[u8], at: usize) -> Option<u64> {
    bytes.get(at..)?.first_chunk().map(|word| u64::from_le_bytes(*word))
}

/// What a data type is called.
pub const fn type_name(data_type: u8) -> &'static str {
    match data_type {
        0x00 => "computer generated data, user defined",
        data_type::SETUP_RECORD => "setup record",
        0x02 => "recording events",
        0x03 => "recording index",
        0x04 => "streaming configuration",
        0x05..=0x07 => "computer generated data",
        0x08 => "PCM data, format 0",
        data_type::PCM_1 => "PCM data",
        data_type::TIME_1 => "time data",
        0x12 => "network time data",
        0x19 => "MIL-STD-1553 bus",
        0x1A => "16PP194 bus",
        0x21 => "analog data",
        0x29 => "discrete data",
        0x30 => "message data",
        0x38 => "ARINC 429 bus",
        0x40..=0x44 => "video data",
        0x48..=0x4A => "image data",
        0x50 => "UART data",
        0x58 | 0x59 => "IEEE 1394 bus",
        0x60 => "parallel data",
        0x68 | 0x69 => "Ethernet data",
        0x70..=0x72 => "position and course data",
        0x78 => "CAN bus",
        0x79 | 0x7A => "Fibre Channel data",
        _ => "unknown data type",
    }
}

#[cfg(test)]
mod tests {
    use super::super::packet_test::packet;
    use super::*;

    #[test]
    fn fields_stand_where_the_standard_says_and_every_wrong_one_is_refused() {
        let limits = PacketLimits::default();
        let bytes = packet(0x1234, data_type::TIME_1, 7, 0xABCD_EF01_2345, &[1, 2, 3, 4, 5], 2);
        let header = PacketHeader::parse(&bytes, &limits).unwrap();
        assert_eq!((header.channel, header.sequence, header.data_type), (0x1234, 7, data_type::TIME_1));
        assert_eq!((header.packet_length, header.data_length, header.rtc), (32, 5, 0xABCD_EF01_2345));
        assert_eq!(header.checksum(), DataChecksum::Bits16);
        let changed = |at: usize, value: u8| {
            let mut bytes = bytes.clone();
            bytes[at] = value;
            let sum = sum_of_words(&bytes[..22]);
            bytes[22..24].copy_from_slice(&sum.to_le_bytes());
            PacketHeader::parse(&bytes, &limits)
        };
        assert_eq!(changed(0, 0x26), Err(Chapter10Error::Sync { found: 0xEB26 }));
        assert_eq!(changed(4, 33), Err(Chapter10Error::PacketLength { least: 26, found: 33 }));
        assert_eq!(changed(4, 24), Err(Chapter10Error::PacketLength { least: 26, found: 24 }));
        assert_eq!(changed(7, 1), Err(Chapter10Error::TooLong { limit: 524_288, found: 0x0100_0020 }));
        assert_eq!(changed(8, 7), Err(Chapter10Error::DataLength { room: 6, found: 7 }));
        let mut wrong = bytes.clone();
        wrong[16] ^= 1;
        assert!(matches!(PacketHeader::parse(&wrong, &limits), Err(Chapter10Error::HeaderChecksum { .. })));
        assert!(matches!(PacketHeader::parse(&bytes[..23], &limits), Err(Chapter10Error::Short { found: 23, .. })));
    }

    #[test]
    fn data_checksums_cover_body_and_filler() {
        assert_eq!(DataChecksum::None.verify(&[1, 2]), None);
        assert_eq!(DataChecksum::Bits8.verify(&[200, 100, 0, 44]), Some(true));
        assert_eq!(DataChecksum::Bits16.verify(&[0xFF, 0xFF, 0x02, 0x01, 0x01, 0x01]), Some(true));
        assert_eq!(DataChecksum::Bits32.verify(&[1, 0, 0, 0x80, 2, 0, 0, 0x80, 3, 0, 0, 0]), Some(true));
        assert_eq!(DataChecksum::Bits32.verify(&[1, 0, 0, 0x80, 2, 0, 0, 0x80, 4, 0, 0, 0]), Some(false));
        assert_eq!(DataChecksum::Bits32.verify(&[1]), None);
    }

    #[test]
    fn the_secondary_header_carries_the_time_in_the_format_of_the_flags() {
        let mut header = PacketHeader::parse(&packet(1, 0x09, 0, 0, &[0; 4], 0), &PacketLimits::default()).unwrap();
        header.flags = 0x84;
        let mut bytes = vec![0x10, 0x27, 0, 0, 0x40, 0xE2, 1, 0, 0, 0];
        let sum: u16 = bytes.iter().map(|byte| u16::from(*byte)).sum();
        bytes.extend(sum.to_le_bytes());
        let time = SecondaryTime::Ieee1588 { seconds: 123_456, nanoseconds: 10_000 };
        assert_eq!(SecondaryHeader::parse(&header, &bytes), Ok(SecondaryHeader { time }));
        let words = sum_of_words(&bytes[..10]);
        bytes[10..].copy_from_slice(&words.to_le_bytes());
        assert!(SecondaryHeader::parse(&header, &bytes).is_ok());
        bytes[10] ^= 1;
        assert!(matches!(SecondaryHeader::parse(&header, &bytes), Err(Chapter10Error::SecondaryChecksum { .. })));
        header.flags = 0x88;
        assert_eq!(header.secondary_time(&[1, 0, 0, 0, 0, 0, 0, 1]), Some(SecondaryTime::ExtendedRtc(1 << 56 | 1)));
    }
}
