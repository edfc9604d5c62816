//! Why a header, a packet body or a datagram cannot be read: what was expected and what was found.
//!
//! Offsets are bytes from the start of the structure that the message names; the reader that met the error knows where that
//! structure stood in the stream.

/// Why something cannot be read.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[expect(missing_docs, reason = "the message of each says what its fields are")]
pub enum Chapter10Error {
    #[error("{what}: expected {expected} bytes, found {found}")]
    Short { what: &'static str, expected: u64, found: u64 },
    #[error("packet header, byte 0: expected the sync pattern EB25, found {found:04X}")]
    Sync { found: u16 },
    #[error("packet header, byte 22: expected the checksum {expected:04X}, found {found:04X}")]
    HeaderChecksum { expected: u16, found: u16 },
    #[error("secondary header, byte 10: expected the checksum {expected:04X}, found {found:04X}")]
    SecondaryChecksum { expected: u16, found: u16 },
    #[error("packet header, byte 4: expected a packet length that is a multiple of 4 and at least {least}, found {found}")]
    PacketLength { least: u32, found: u32 },
    #[error("packet header, byte 4: expected a packet length of at most {limit} bytes, found {found}")]
    TooLong { limit: u32, found: u32 },
    #[error("packet header, byte 8: expected a data length of at most {room} bytes, found {found}")]
    DataLength { room: u32, found: u32 },
    #[error("packet of data type {found:02X}: expected {expected:02X}")]
    DataType { expected: u8, found: u8 },
    #[error("time packet, byte {at}: expected decimal digits that make {what}, found {found:02X}")]
    Digits { what: &'static str, at: u64, found: u8 },
    #[error("time packet: expected {what}, found {found}")]
    Time { what: &'static str, found: u32 },
    #[error("PCM channel specific word: expected exactly one of unpacked, packed and throughput mode, found the bits {bits:03b}")]
    PcmMode { bits: u8 },
    #[error("PCM packet in throughput mode: it has bits, not minor frames")]
    PcmThroughput,
    #[error("PCM packet in a framed mode: expected intra-packet headers (bit 30), found none")]
    PcmNoIntraPacketHeader,
    #[error("PCM layout: expected {what}, found {found}")]
    PcmLayout { what: &'static str, found: u64 },
    #[error("PCM packet: expected minor frames of {frame} bytes each, found {found} bytes, {rest} too many")]
    PcmRest { frame: u64, found: u64, rest: u64 },
    #[error("setup record: expected TMATS as text, found XML (bit 9 of the channel specific word)")]
    SetupXml,
    #[error("TMATS: no recorder channel has the number {channel} (R-x\\TK1-n)")]
    TmatsNoChannel { channel: u16 },
    #[error("TMATS: the link of channel {channel} leads to no PCM format (P-d\\DLN)")]
    TmatsNoFormat { channel: u16 },
    #[error("UDP transfer header, byte {at}: expected {what}, found {found}")]
    Udp { what: &'static str, at: u64, found: u64 },
}
