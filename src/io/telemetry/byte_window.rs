//! The bytes of a stream that are being looked at, and where they stand in it.
//!
//! Consumes pieces of any size; produces the bytes that were taken in and not yet passed, in one piece. Memory: one buffer of the
//! capacity that it is made with, taken once. [`read_block`] reads such pieces.

use std::io::{ErrorKind, Read, Result as IoResult};

/// Bytes from the stream, in order.
pub(crate) struct ByteWindow {
    buffer: Box<[u8]>,
    start: usize,
    end: usize,
    /// Place of `start` in the stream.
    position: u64,
}

impl ByteWindow {
    /// Nothing taken in yet.
    pub(crate) fn new(capacity: usize) -> Self {
        ByteWindow { buffer: vec![0; capacity].into(), start: 0, end: 0, position: 0 }
    }

    /// Takes in what there is room for and says how many bytes that was: at least one while less than the capacity is there.
    pub(crate) fn take(&mut self, bytes: &[u8]) -> usize {
        if self.buffer.len() - self.end < bytes.len() && self.start > 0 {
            self.buffer.copy_within(self.start..self.end, 0);
            self.end -= self.start;
            self.start = 0;
        }
        let room = self.buffer.get_mut(self.end..).unwrap_or_default();
        let count = room.len().min(bytes.len());
        if let (Some(room), Some(bytes)) = (room.get_mut(..count), bytes.get(..count)) {
            room.copy_from_slice(bytes);
            self.end += count;
        }
        count
    }

    /// What was taken in and not passed.
    pub(crate) fn bytes(&self) -> &[u8] {
        self.buffer.get(self.start..self.end).unwrap_or_default()
    }

    /// Place of the first of them in the stream.
    pub(crate) fn position(&self) -> u64 {
        self.position
    }

    /// Passes so many of them.
    pub(crate) fn advance(&mut self, count: usize) {
        let count = count.min(self.end - self.start);
        self.start += count;
        self.position += count as u64;
    }

    /// So many bytes from a place in the stream on; passed ones are there until more are taken in.
    pub(crate) fn at(&self, place: u64, length: usize) -> Option<&[u8]> {
        let first = self.position - self.start as u64;
        let begin = usize::try_from(place.checked_sub(first)?).ok()?;
        let end = begin.checked_add(length).filter(|end| *end <= self.end)?;
        self.buffer.get(begin..end)
    }
}

/// Reads what there is, at most a block; none at the end. A signal does not end it.
pub(crate) fn read_block(source: &mut impl Read, block: &mut [u8]) -> IoResult<usize> {
    loop {
        match source.read(block) {
            Err(error) if error.kind() == ErrorKind::Interrupted => {}
            read => return read,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bytes_come_in_order_and_passed_ones_stay_until_the_next_are_taken() {
        let mut window = ByteWindow::new(4);
        assert_eq!((window.take(b"abcdef"), window.bytes(), window.position()), (4, b"abcd".as_slice(), 0));
        assert_eq!(window.take(b"ef"), 0, "full");
        window.advance(3);
        assert_eq!((window.bytes(), window.position()), (b"d".as_slice(), 3));
        assert_eq!((window.at(1, 3), window.at(3, 1), window.at(3, 2)), (Some(b"bcd".as_slice()), Some(b"d".as_slice()), None));
        assert_eq!((window.take(b"ef"), window.bytes()), (2, b"def".as_slice()));
        assert_eq!((window.at(2, 1), window.at(4, 2)), (None, Some(b"ef".as_slice())));
        window.advance(9);
        assert_eq!((window.bytes(), window.position()), (b"".as_slice(), 6));
    }
}
