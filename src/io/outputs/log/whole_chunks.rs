//! Which messages are in a file that could not be written to its end: those of the chunks that it has taken whole.
//!
//! Consumes the bytes that a buffered writer was given and that its file has taken, and the ends of chunks among them; produces a
//! number of messages. A chunk whose index alone is torn does not count, though a reader may find it.

use std::io::{Result, Write};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

/// A writer that counts the bytes that it has taken.
#[derive(Debug)]
pub(super) struct CountingWriter<W> {
    pub(super) inner: W,
    count: Arc<AtomicU64>,
}

impl<W: Write> CountingWriter<W> {
    pub(super) fn new(inner: W, count: &Arc<AtomicU64>) -> Self {
        CountingWriter { inner, count: Arc::clone(count) }
    }
}

impl<W: Write> Write for CountingWriter<W> {
    fn write(&mut self, bytes: &[u8]) -> Result<usize> {
        let written = self.inner.write(bytes)?;
        self.count.fetch_add(written as u64, Ordering::Relaxed);
        Ok(written)
    }

    fn flush(&mut self) -> Result<()> {
        self.inner.flush()
    }
}

/// The messages of a file since its last flush.
#[derive(Debug, Default)]
pub(super) struct WholeChunks {
    /// Bytes that the buffer was given, and that the file has taken.
    pub(super) given: Arc<AtomicU64>,
    pub(super) taken: Arc<AtomicU64>,
    /// Messages up to the last flush, and since.
    flushed: u64,
    unflushed: u64,
    /// Where each chunk ends, and how many of the unflushed messages it completes.
    chunks: Vec<(u64, u64)>,
}

impl WholeChunks {
    /// Writes one message; where a chunk was full before, it ended then.
    pub(super) fn message<E>(&mut self, write: impl FnOnce() -> std::result::Result<(), E>) -> std::result::Result<(), E> {
        let before = self.given.load(Ordering::Relaxed);
        write()?;
        let end = self.given.load(Ordering::Relaxed);
        if end > before {
            self.chunks.push((end, self.unflushed));
        }
        self.unflushed += 1;
        Ok(())
    }

    /// Everything is in the file.
    pub(super) fn flushed(&mut self) {
        self.flushed += std::mem::take(&mut self.unflushed);
        self.chunks.clear();
    }

    /// Whether the file holds any message, where writing has failed.
    pub(super) fn holds_any(&self) -> bool {
        self.flushed > 0 || self.lost() < self.unflushed
    }

    /// How many messages are not in the file, where writing has failed.
    pub(super) fn lost(&self) -> u64 {
        let taken = self.taken.load(Ordering::Relaxed);
        let whole = self.chunks.iter().rev().find(|(end, _)| *end <= taken).map_or(0, |(_, messages)| *messages);
        self.unflushed.saturating_sub(whole)
    }
}
