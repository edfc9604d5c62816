//! tlog files: packets read from a file or any other reader, records written to any writer.
//!
//! A tlog is a sequence of records: 8 bytes of big-endian microseconds since 1970, then one frame. Damaged records are skipped
//! and counted by the framer. Memory: the framer's buffer and one block.

use super::packet::{FrameTally, Framer, Framing, Packet};
use std::io::{ErrorKind, Read, Result, Write};

/// How much is read at once, bytes.
const BLOCK: usize = 16 << 10;

/// Reads packets.
pub struct PacketReader<R> {
    source: R,
    framer: Framer,
    block: Box<[u8]>,
    from: usize,
    to: usize,
    ended: bool,
}

impl<R> std::fmt::Debug for PacketReader<R> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("PacketReader").field("framer", &self.framer).finish_non_exhaustive()
    }
}

impl<R: Read> PacketReader<R> {
    /// Reads from the start.
    pub fn new(source: R, framing: Framing) -> Self {
        PacketReader { source, framer: Framer::new(framing), block: vec![0; BLOCK].into(), from: 0, to: 0, ended: false }
    }

    /// What was found so far.
    pub fn tally(&self) -> FrameTally {
        self.framer.tally()
    }

    /// The next packet; `None` at the end.
    ///
    /// # Errors
    /// What the source gives, save that it was interrupted.
    pub fn next_packet(&mut self) -> Result<Option<Packet>> {
        while !self.ended {
            if let Some(packet) = self.framer.next_packet() {
                return Ok(Some(packet));
            }
            if self.from == self.to {
                match self.source.read(&mut self.block) {
                    Ok(count) => (self.from, self.to, self.ended) = (0, count, count == 0),
                    Err(error) if error.kind() == ErrorKind::Interrupted => {}
                    Err(error) => return Err(error),
                }
            }
            self.from += self.framer.take(self.block.get(self.from..self.to).unwrap_or_default());
        }
        Ok(self.framer.last_packet())
    }
}

/// Writes one record.
///
/// # Errors
/// What the writer gives.
pub fn write_record<W: Write>(writer: &mut W, stamp_us: u64, frame: &[u8]) -> Result<()> {
    writer.write_all(&stamp_us.to_be_bytes())?;
    writer.write_all(frame)
}
