//! The last bits of a stream, at their places counted from its start.
//!
//! Consumes bytes in pieces of any size, derandomises them where the line code asks for it, and keeps what is still needed;
//! produces bits by their place in the stream, which is a number of bits from the first one. Memory is set at the start; a
//! piece is taken in as far as there is room.

use super::bits::{Derandomizer, LineCode, copy_bits, read_bits};

/// Bytes behind the last one that may be loaded with it.
const SPARE: usize = 8;

/// A stretch of the stream.
#[derive(Clone, Debug)]
pub struct BitBuffer {
    bytes: Box<[u8]>,
    length: usize,
    /// Place of the first byte in the stream, bytes.
    first: u64,
    derandomizer: Option<Derandomizer>,
}

impl BitBuffer {
    /// With room for at least that many bits.
    #[must_use]
    pub fn new(bits: usize, code: LineCode) -> Self {
        let derandomizer = match code {
            LineCode::NrzL => None,
            LineCode::RnrzL => Some(Derandomizer::default()),
        };
        BitBuffer { bytes: vec![0; bits.div_ceil(8) + SPARE].into(), length: 0, first: 0, derandomizer }
    }

    /// Place behind the last bit.
    #[must_use]
    pub fn end(&self) -> u64 {
        (self.first + self.length as u64) * 8
    }

    /// Takes in what there is room for and says how many bytes that was. Bits before `needed` may go.
    pub fn take(&mut self, bytes: &[u8], needed: u64) -> usize {
        let capacity = self.bytes.len() - SPARE;
        if capacity - self.length < bytes.len() {
            let gone = usize::try_from((needed / 8).saturating_sub(self.first)).unwrap_or(0).min(self.length);
            self.bytes.copy_within(gone..self.length, 0);
            self.first += gone as u64;
            self.length -= gone;
        }
        let count = bytes.len().min(capacity - self.length);
        if let (Some(room), Some(bytes)) = (self.bytes.get_mut(self.length..self.length + count), bytes.get(..count)) {
            room.copy_from_slice(bytes);
            if let Some(derandomizer) = &mut self.derandomizer {
                derandomizer.apply(room);
            }
            self.length += count;
        }
        count
    }

    /// That many bits (1 to 64) from that place on; `None` where they are not all here.
    #[must_use]
    pub fn get(&self, at: u64, count: u32) -> Option<u64> {
        let bits = self.inside(at, u64::from(count))?;
        read_bits(&self.bytes, bits, count)
    }

    /// Copies bits to the start of the target, inverted on request; `false` where they are not all here.
    pub fn copy(&self, at: u64, count: usize, target: &mut [u8], inverted: bool) -> bool {
        self.inside(at, count as u64).is_some_and(|bits| copy_bits(&self.bytes, bits, count, target, inverted))
    }

    /// The first place from `from` to before `to` at which a window of that many bits (1 to 56) has what is looked for, and
    /// what was found there. Windows that are not all here are not looked at.
    pub fn find<T>(&self, from: u64, to: u64, count: u32, mut wanted: impl FnMut(u64) -> Option<T>) -> Option<(u64, T)> {
        if !(1..=56).contains(&count) {
            return None;
        }
        let to = to.min((self.end() + 1).saturating_sub(u64::from(count)));
        let mut at = from.max(self.first * 8);
        while at < to {
            let byte = usize::try_from(at / 8 - self.first).ok()?;
            let eight = u64::from_be_bytes(*self.bytes.get(byte..)?.first_chunk::<8>()?);
            let next = (at / 8 + 1) * 8;
            for place in at..next.min(to) {
                let window = eight << (place % 8) >> (64 - count);
                if let Some(found) = wanted(window) {
                    return Some((place, found));
                }
            }
            at = next;
        }
        None
    }

    /// Bits from the start of the buffer to that place, where the stretch is all here.
    fn inside(&self, at: u64, count: u64) -> Option<usize> {
        let bits = at.checked_sub(self.first * 8)?;
        (at.checked_add(count)? <= self.end()).then_some(())?;
        usize::try_from(bits).ok()
    }
}

#[cfg(test)]
mod tests {
    use super::super::test_random::Random;
    use super::*;

    #[test]
    fn a_stretch_is_the_same_in_any_pieces() {
        let mut random = Random(4);
        let stream = random.bytes(5000);
        let mut buffer = BitBuffer::new(800, LineCode::NrzL);
        let mut target = [0; 12];
        let (mut taken, mut needed) = (0, 0_u64);
        while taken < stream.len() {
            let piece = &stream[taken..(taken + random.below(200)).min(stream.len())];
            let count = buffer.take(piece, needed);
            taken += count;
            assert_eq!(buffer.end(), taken as u64 * 8);
            let length = 1 + random.below(60) as u32;
            if needed + u64::from(length) <= buffer.end() {
                assert_eq!(buffer.get(needed, length), read_bits(&stream, needed as usize, length));
                let word = buffer.get(needed, length).unwrap();
                let first =
                    buffer.find(needed, buffer.end(), length.min(56), |window| (length <= 56 && window == word).then_some(()));
                assert!(length > 56 || first.is_some_and(|(place, ())| place >= needed));
            }
            if needed + 90 <= buffer.end() {
                assert!(buffer.copy(needed, 90, &mut target, false));
                assert_eq!(read_bits(&target, 0, 64), read_bits(&stream, needed as usize, 64));
            }
            assert_eq!(buffer.get(buffer.end() - 3, 4), None);
            needed = needed.max(buffer.end().saturating_sub(random.below(500) as u64));
        }
    }

    #[test]
    fn a_full_buffer_takes_nothing_and_loses_nothing() {
        let mut buffer = BitBuffer::new(16, LineCode::NrzL);
        assert_eq!((buffer.take(&[1, 2, 3], 0), buffer.take(&[3], 7), buffer.take(&[3, 4], 8)), (2, 0, 1));
        assert_eq!((buffer.get(8, 16), buffer.get(0, 8), buffer.get(u64::MAX, 8)), (Some(0x0203), None, None));
    }

    #[test]
    fn windows_are_looked_at_one_by_one() {
        let mut buffer = BitBuffer::new(64, LineCode::NrzL);
        buffer.take(&[0b0001_0110, 0b0101_1000], 0);
        let five = |from, to| buffer.find(from, to, 5, |window| (window == 0b10110).then_some(())).map(|(place, ())| place);
        assert_eq!((five(0, 16), five(4, 16), five(4, 9), five(10, 100)), (Some(3), Some(9), None, None));
    }
}
