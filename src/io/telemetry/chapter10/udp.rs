//! UDP transfer headers: how packets are sent in datagrams.
//!
//! Consumes a datagram; produces [`TransferHeader`] and where its payload begins.
//! | format | byte order | bits of each 32-bit word of the header |
//! | --- | --- | --- |
//! | 1 | little-endian | 3-0 format, 7-4 type (0 full, 1 segmented), 31-8 number of the datagram |
//! | | | segmented only: 15-0 channel, 23-16 sequence number of the packet, 31-24 reserved |
//! | | | segmented only: 31-0 offset of the segment, bytes |
//! | 2 | big-endian | 3-0 format, 7-4 type, 31-8 number of the datagram |
//! | | | 23-0 packet size, 31-24 bits 23-16 of the offset; both in units of 32 bits |
//! | | | 15-0 channel, 31-16 bits 15-0 of the offset |
//! | 3 | little-endian | 3-0 format, 7-4 n, 15-8 reserved, 31-16 offset of the first packet start, bytes |
//! | | | upper 4 n bits source identifier, the others number of the datagram |
//!
//! Formats 1 and 3 are told from the first byte, format 2 from the fourth; a datagram of format 1 or 3 can look like one of
//! format 2, so that the latter is read only where it is expected. Refused: other formats and types, and source identifiers
//! of more than 16 bits.
//! Source: format 1: IRIG 106-07 Chapter 10, figures 10-2 and 10-3 (10.3.9.1.2 in 106-11). Formats 2 and 3 came later (format
//! 3 is 10.3.9.1.5); the text of these clauses was not seen. Their fields are those of irig106lib and AcraNetwork, which agree,
//! save that only AcraNetwork gives the byte order and the unit of format 2.

use super::error::Chapter10Error;
use super::header::{u16_at, u32_at};

/// The formats of a link.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum LinkFormat {
    /// Format 1 or 3, told by each datagram.
    #[default]
    OneOrThree,
    /// Format 2.
    Two,
}

/// What stands before the payload of a datagram.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TransferHeader {
    /// Format 1: one or more whole packets.
    Full {
        /// Number of the datagram, 24 bits.
        number: u32,
    },
    /// Format 1 or 2: part of a packet.
    Segment {
        /// Number of the datagram, 24 bits.
        number: u32,
        /// Channel of the packet.
        channel: u16,
        /// Sequence number of the packet (format 1).
        sequence: Option<u8>,
        /// Where the part belongs in the packet, bytes.
        offset: u32,
        /// Length of the packet (format 2), bytes.
        packet_bytes: Option<u32>,
    },
    /// Format 3: a piece of a stream of packets.
    Stream {
        /// Number of the datagram, as many bits as the source identifier leaves of 32.
        number: u32,
        /// Bits of the number.
        number_bits: u32,
        /// Who sends.
        source: u32,
        /// Where a packet begins in the payload, bytes, as written.
        first_packet: u16,
    },
}

impl TransferHeader {
    /// Reads a header; the payload follows.
    ///
    /// # Errors
    /// [`Chapter10Error`] where this is none.
    pub fn parse(datagram: &[u8], link: LinkFormat) -> Result<(Self, &[u8]), Chapter10Error> {
        let short = |expected: usize| Chapter10Error::Short {
            what: "UDP transfer header",
            expected: expected as u64,
            found: datagram.len() as u64,
        };
        let after = |length: usize| datagram.get(length..).ok_or(short(length));
        let word = u32_at(datagram, 0).ok_or(short(4))?;
        if link == LinkFormat::Two {
            return two(datagram, word.swap_bytes()).ok_or(short(12))?.and_then(|header| Ok((header, after(12)?)));
        }
        let (format, upper) = (word & 0xF, word >> 4 & 0xF);
        match (format, upper) {
            (1, 0) => Ok((TransferHeader::Full { number: word >> 8 }, after(4)?)),
            (1, 1) => {
                let [channel, sequence] = [u16_at(datagram, 4).ok_or(short(12))?, u16_at(datagram, 6).ok_or(short(12))?];
                let offset = u32_at(datagram, 8).ok_or(short(12))?;
                let header = TransferHeader::Segment {
                    number: word >> 8,
                    channel,
                    sequence: Some((sequence & 0xFF) as u8),
                    offset,
                    packet_bytes: None,
                };
                Ok((header, after(12)?))
            }
            (1, found) => Err(Chapter10Error::Udp { what: "type 0 (full) or 1 (segmented)", at: 0, found: found.into() }),
            (3, nibbles) if nibbles > 4 => {
                let what = "a source identifier of at most 16 bits";
                Err(Chapter10Error::Udp { what, at: 0, found: u64::from(nibbles) * 4 })
            }
            (3, nibbles) => {
                let second = u32_at(datagram, 4).ok_or(short(8))?;
                let number_bits = 32 - 4 * nibbles;
                let number = second & u32::MAX >> (32 - number_bits);
                let source = second.checked_shr(number_bits).unwrap_or(0);
                let first_packet = (word >> 16) as u16;
                Ok((TransferHeader::Stream { number, number_bits, source, first_packet }, after(8)?))
            }
            (found, _) => Err(Chapter10Error::Udp { what: "format 1 or 3", at: 0, found: found.into() }),
        }
    }

    /// Number of the datagram, and how many bits it has.
    pub fn number(&self) -> (u32, u32) {
        match self {
            TransferHeader::Full { number } | TransferHeader::Segment { number, .. } => (*number, 24),
            TransferHeader::Stream { number, number_bits, .. } => (*number, *number_bits),
        }
    }

    /// Who sends; formats 1 and 2 do not say.
    pub fn source(&self) -> u32 {
        match self {
            TransferHeader::Full { .. } | TransferHeader::Segment { .. } => 0,
            TransferHeader::Stream { source, .. } => *source,
        }
    }
}

/// The header of format 2; `None` where it is too short.
fn two(datagram: &[u8], word: u32) -> Option<Result<TransferHeader, Chapter10Error>> {
    let [second, third] = [u32_at(datagram, 4)?.swap_bytes(), u32_at(datagram, 8)?.swap_bytes()];
    if word & 0xF != 2 {
        return Some(Err(Chapter10Error::Udp { what: "format 2", at: 3, found: u64::from(word & 0xF) }));
    }
    let offset_words = second >> 24 << 16 | third >> 16;
    Some(Ok(TransferHeader::Segment {
        number: word >> 8,
        channel: (third & 0xFFFF) as u16,
        sequence: None,
        offset: offset_words * 4,
        packet_bytes: Some((second & 0xFF_FFFF) * 4),
    }))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parsed(bytes: &[u8], link: LinkFormat) -> Result<(TransferHeader, usize), Chapter10Error> {
        TransferHeader::parse(bytes, link).map(|(header, payload)| (header, payload.len()))
    }

    #[test]
    fn format_1() {
        let link = LinkFormat::OneOrThree;
        assert_eq!(parsed(&[0x01, 3, 2, 1, 9], link), Ok((TransferHeader::Full { number: 0x0001_0203 }, 1)));
        let header = TransferHeader::Segment {
            number: 0x0001_0203,
            channel: 0x1234,
            sequence: Some(0x56),
            offset: 0x0102_0304,
            packet_bytes: None,
        };
        assert_eq!(parsed(&[0x11, 3, 2, 1, 0x34, 0x12, 0x56, 0, 4, 3, 2, 1, 7, 7], link), Ok((header, 2)));
        assert!(matches!(parsed(&[0x21, 0, 0, 0], link), Err(Chapter10Error::Udp { found: 2, .. })));
        assert!(matches!(parsed(&[0x11, 0, 0, 0, 1], link), Err(Chapter10Error::Short { expected: 12, found: 5, .. })));
        assert!(matches!(parsed(&[0x01], link), Err(Chapter10Error::Short { expected: 4, .. })));
    }

    #[test]
    fn format_2() {
        let header = TransferHeader::Segment {
            number: 0x0001_0203,
            channel: 0x1234,
            sequence: None,
            offset: 0x0001_0002 * 4,
            packet_bytes: Some(0x03 * 4),
        };
        let bytes = [1, 2, 3, 0x12, 1, 0, 0, 3, 0, 2, 0x12, 0x34, 5];
        assert_eq!(parsed(&bytes, LinkFormat::Two), Ok((header, 1)));
        assert!(matches!(parsed(&bytes[..11], LinkFormat::Two), Err(Chapter10Error::Short { expected: 12, .. })));
        assert!(matches!(parsed(&[1; 12], LinkFormat::Two), Err(Chapter10Error::Udp { found: 1, .. })));
    }

    #[test]
    fn format_3() {
        let link = LinkFormat::OneOrThree;
        let of = |nibbles: u8| parsed(&[nibbles << 4 | 3, 0, 0x10, 0x20, 0x78, 0x56, 0x34, 0x12], link);
        let header =
            |number, number_bits, source| Ok((TransferHeader::Stream { number, number_bits, source, first_packet: 0x2010 }, 0));
        assert_eq!(of(0), header(0x1234_5678, 32, 0));
        assert_eq!(of(1), header(0x0234_5678, 28, 1));
        assert_eq!(of(2), header(0x34_5678, 24, 0x12));
        assert_eq!(of(4), header(0x5678, 16, 0x1234));
        assert!(matches!(of(5), Err(Chapter10Error::Udp { found: 20, .. })));
        assert!(matches!(parsed(&[4, 0, 0, 0], link), Err(Chapter10Error::Udp { found: 4, .. })));
        assert!(matches!(parsed(&[3, 0, 0, 0, 1], link), Err(Chapter10Error::Short { expected: 8, .. })));
    }
}
