//! Bits of a PCM stream: the randomised line code, and fields of any length at any bit of a byte slice.
//!
//! Bits are numbered from 0 in the order in which they were sent; the first bit of a byte is its most significant one.
//!
//! RNRZ-L is NRZ-L passed through the self-synchronising randomiser of 15 stages, polynomial x^15 + x^14 + 1 (the IRIG
//! randomiser of IRIG 106 Chapter 12, edition of 2023):
//!
//! ```text
//! sent:      r[n] = d[n] ^ r[n - 14] ^ r[n - 15]
//! received:  d[n] = r[n] ^ r[n - 14] ^ r[n - 15]
//! ```
//!
//! The receiver needs no common start: it is right from its 16th bit on. One wrong bit of the line makes three wrong bits of
//! data, at n, n + 14 and n + 15. An inverted line gives inverted data, so polarity can be decided behind the derandomiser.

/// How bits stand on the line.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum LineCode {
    /// A one is the high level, a zero the low one.
    #[default]
    NrzL,
    /// NRZ-L, randomised.
    RnrzL,
}

/// Bits of the line to bits of data.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Derandomizer {
    /// The last bits of the line, newest in the lowest place.
    line: u32,
}

impl Derandomizer {
    /// The next eight bits.
    #[must_use]
    pub fn byte(&mut self, line: u8) -> u8 {
        self.line = self.line << 8 | u32::from(line);
        (self.line ^ self.line >> 14 ^ self.line >> 15).to_be_bytes()[3]
    }

    /// All of these, in place.
    pub fn apply(&mut self, bytes: &mut [u8]) {
        let mut words = bytes.chunks_exact_mut(8);
        for word in &mut words {
            let mut line = [0; 8];
            line.copy_from_slice(word);
            let newest = u64::from_be_bytes(line);
            let line = u128::from(self.line) << 64 | u128::from(newest);
            let data = (line ^ line >> 14 ^ line >> 15).to_be_bytes();
            if let Some(data) = data.last_chunk::<8>() {
                word.copy_from_slice(data);
            }
            self.line = (newest & u64::from(u32::MAX)) as u32;
        }
        for byte in words.into_remainder() {
            *byte = self.byte(*byte);
        }
    }
}

/// Bits of data to bits of the line.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Randomizer {
    line: u32,
}

impl Randomizer {
    /// The next eight bits.
    #[must_use]
    pub fn byte(&mut self, data: u8) -> u8 {
        // The bit 14 places back is older than these eight.
        let back = self.line << 8;
        let sent = data ^ (back >> 14 ^ back >> 15).to_be_bytes()[3];
        self.line = back | u32::from(sent);
        sent
    }
}

/// That many bits (1 to 64) from that bit on, the first of them most significant; `None` where the slice has not so many.
#[must_use]
#[inline]
pub fn read_bits(bytes: &[u8], at: usize, count: u32) -> Option<u64> {
    let (first, shift) = (at / 8, (at % 8) as u32);
    if !(1..=64).contains(&count) {
        return None;
    }
    if shift + count <= 64
        && let Some(eight) = bytes.get(first..).and_then(|rest| rest.first_chunk::<8>())
    {
        return Some(u64::from_be_bytes(*eight) << shift >> (64 - count));
    }
    read_bits_near_end(bytes, at, count)
}

/// The same where fewer than eight bytes follow the first bit, or the field touches nine. Kept out of the short way before it,
/// which every word of a minor frame but its last few takes.
#[inline(never)]
fn read_bits_near_end(bytes: &[u8], at: usize, count: u32) -> Option<u64> {
    let (first, shift) = (at / 8, (at % 8) as u32);
    let covered = (shift + count).div_ceil(8);
    let covered_bytes = bytes.get(first..first.checked_add(covered as usize)?)?;
    if let Some(last) = bytes.last_chunk::<8>()
        && let Some(skipped) = at.checked_sub(8 * (bytes.len() - 8))
        && skipped + count as usize <= 64
    {
        return Some(u64::from_be_bytes(*last) << skipped >> (64 - count));
    }
    let window = covered_bytes.iter().fold(0_u128, |window, byte| window << 8 | u128::from(*byte));
    let value = window >> (covered * 8 - shift - count) & (u128::MAX >> (128 - count));
    u64::try_from(value).ok()
}

/// Writes the low bits of a value (1 to 64 of them) from that bit on; `false` where the slice has not so many.
pub fn write_bits(bytes: &mut [u8], at: usize, count: u32, value: u64) -> bool {
    let Some(end) = at.checked_add(count as usize).filter(|end| *end <= bytes.len() * 8) else { return false };
    for (place, bit) in (at..end).rev().zip(0..64) {
        if let Some(byte) = bytes.get_mut(place / 8) {
            let mask = 0x80 >> (place % 8);
            *byte = if value >> bit & 1 == 1 { *byte | mask } else { *byte & !mask };
        }
    }
    true
}

/// Copies that many bits from that bit of the source on to the start of the target, inverted on request; what is left of the
/// last byte is zero. `false` where the source or the target is too short.
pub fn copy_bits(source: &[u8], at: usize, count: usize, target: &mut [u8], inverted: bool) -> bool {
    let (first, shift) = (at / 8, at % 8);
    let flip = if inverted { u64::MAX } else { 0 };
    let whole = count.div_ceil(8);
    let (Some(source), Some(target)) = (source.get(first..), target.get_mut(..whole)) else { return false };
    if source.len() * 8 < shift + count {
        return false;
    }
    for (k, part) in target.chunks_mut(8).enumerate() {
        let Some(rest) = source.get(8 * k..) else { return false };
        let word = match (rest.first_chunk::<8>(), rest.get(8)) {
            (Some(eight), next) => {
                let next = u64::from(next.copied().unwrap_or(0));
                u64::from_be_bytes(*eight) << shift | if shift == 0 { 0 } else { next >> (8 - shift) }
            }
            (None, _) => rest.iter().enumerate().fold(0, |word, (i, byte)| word | u64::from(*byte) << (56 - 8 * i)) << shift,
        };
        for (byte, moved) in part.iter_mut().zip((word ^ flip).to_be_bytes()) {
            *byte = moved;
        }
    }
    if !count.is_multiple_of(8)
        && let Some(last) = target.last_mut()
    {
        *last &= 0xFF << (8 - count % 8);
    }
    true
}

#[cfg(test)]
mod tests {
    use super::super::test_random::Random;
    use super::*;

    fn bit(bytes: &[u8], at: usize) -> u8 {
        bytes[at / 8] >> (7 - at % 8) & 1
    }

    /// The definition, bit by bit.
    fn randomised_slowly(data: &[u8]) -> Vec<u8> {
        let mut sent: Vec<u8> = Vec::new();
        for n in 0..data.len() * 8 {
            let back = |k: usize| if n >= k { sent[n - k] } else { 0 };
            sent.push(bit(data, n) ^ back(14) ^ back(15));
        }
        sent.chunks(8).map(|bits| bits.iter().fold(0, |byte, bit| byte << 1 | bit)).collect()
    }

    #[test]
    fn the_randomiser_is_the_definition_bit_by_bit_and_the_derandomiser_undoes_it() {
        let mut random = Random(1);
        let data = random.bytes(1000);
        let mut randomizer = Randomizer::default();
        let line: Vec<u8> = data.iter().map(|byte| randomizer.byte(*byte)).collect();
        assert_eq!(line, randomised_slowly(&data));
        let mut derandomizer = Derandomizer::default();
        assert_eq!(line.iter().map(|byte| derandomizer.byte(*byte)).collect::<Vec<_>>(), data);
        // In any pieces, and in the middle of the stream: right from the 16th bit on.
        for from in [0, 3, 17] {
            let mut derandomizer = Derandomizer::default();
            let mut found = line[from..].to_vec();
            let mut rest = found.as_mut_slice();
            while !rest.is_empty() {
                let (piece, after) = rest.split_at_mut((1 + random.below(30)).min(rest.len()));
                derandomizer.apply(piece);
                rest = after;
            }
            assert_eq!(found[2..], data[from + 2..]);
            assert_eq!(bit(&found, 15), bit(&data[from..], 15));
        }
    }

    #[test]
    fn one_wrong_bit_of_the_line_makes_three_of_data_and_an_inverted_line_inverted_data() {
        let mut line = vec![0_u8; 20];
        line[5] ^= 0b0000_0100;
        let mut derandomizer = Derandomizer::default();
        derandomizer.apply(&mut line);
        let wrong: Vec<usize> = (0..160).filter(|n| bit(&line, *n) == 1).collect();
        assert_eq!(wrong, [45, 59, 60]);
        let mut ones = vec![0xFF_u8; 20];
        Derandomizer::default().apply(&mut ones);
        assert!((15..160).all(|n| bit(&ones, n) == 1));
    }

    #[test]
    fn a_constant_becomes_the_sequence_of_32_767_bits() {
        let mut randomizer = Randomizer::default();
        let first = randomizer.byte(0x80);
        let line: Vec<u8> = std::iter::once(first).chain((0..3 * 4096).map(|_| randomizer.byte(0))).collect();
        let period = 32_767;
        assert!((0..period).all(|n| bit(&line, n) == bit(&line, n + period)));
        assert_eq!((0..period).filter(|n| bit(&line, *n) == 1).count(), 16_384, "a maximum-length sequence has one more one");
    }

    #[test]
    fn fields_are_the_bits_in_their_order() {
        let mut random = Random(2);
        let bytes = random.bytes(40);
        for _ in 0..20_000 {
            let (at, count) = (random.below(330), 1 + random.below(64));
            let expected = (at + count <= 320).then(|| (at..at + count).fold(0, |word, n| word << 1 | u64::from(bit(&bytes, n))));
            assert_eq!(read_bits(&bytes, at, count as u32), expected, "{at} {count}");
            if let Some(value) = expected {
                let mut written = random.bytes(40);
                let before = written.clone();
                assert!(write_bits(&mut written, at, count as u32, value));
                assert_eq!(read_bits(&written, at, count as u32), Some(value));
                let outside = |n: &usize| *n < at || *n >= at + count;
                assert!((0..320).filter(outside).all(|n| bit(&before, n) == bit(&written, n)));
            }
        }
        assert_eq!((read_bits(&bytes, 0, 0), read_bits(&bytes, 0, 65), read_bits(&bytes, usize::MAX, 8)), (None, None, None));
        assert!(!write_bits(&mut [0; 4], 30, 3, 0) && !write_bits(&mut [0; 4], usize::MAX, 3, 0));
    }

    #[test]
    fn bits_are_copied_from_anywhere() {
        let mut random = Random(3);
        let bytes = random.bytes(60);
        for _ in 0..5000 {
            let (at, count, inverted) = (random.below(300), 1 + random.below(250), random.below(2) == 1);
            let mut target = random.bytes(40);
            let fits = at + count <= 480;
            assert_eq!(copy_bits(&bytes, at, count, &mut target, inverted), fits);
            if fits {
                assert!((0..count).all(|n| bit(&target, n) == bit(&bytes, at + n) ^ u8::from(inverted)));
                assert!((count..count.div_ceil(8) * 8).all(|n| bit(&target, n) == 0));
            }
        }
        assert!(!copy_bits(&bytes, 0, 41, &mut [0; 5], false));
    }
}
