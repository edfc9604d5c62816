//! The signature of a frame, as it stands behind the checksum (mavlink.io, "Message Signing").
//!
//! Consumes the last 13 bytes of a signed frame; produces link id, timestamp and signature, unverified. Any bytes are one.

/// Bytes of a signature with its link id and timestamp.
pub const SIGNATURE: usize = 13;

/// What stands behind the checksum of a signed frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FrameSignature {
    /// Number of the link, as its sender counts links.
    pub link_id: u8,
    /// When it was signed, in steps of 10 us since 2015-01-01, as its sender says.
    pub timestamp: u64,
    /// The signature itself, unverified.
    pub value: [u8; 6],
}

impl FrameSignature {
    /// Reads it.
    pub fn from_bytes(bytes: &[u8; SIGNATURE]) -> Self {
        let [link_id, t0, t1, t2, t3, t4, t5, value @ ..] = *bytes;
        FrameSignature { link_id, timestamp: u64::from_le_bytes([t0, t1, t2, t3, t4, t5, 0, 0]), value }
    }
}
