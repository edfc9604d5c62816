//! The words of a recorded minor frame, one behind the other.
//!
//! Consumes the bits of the frame, first bit first, and the places of its words; produces their numbers. Words of 8, 16, 32 or
//! 64 bits that follow each other from a whole byte on, as recorders mostly have them, are taken as bytes in one pass over a
//! slice; others bit field by bit field ([`BitField::read`]). Both give the same; a word that ends outside of the bits is
//! left out.

use super::pcm_layout::{BitField, WordMap};
use std::slice::Iter;

/// An iterator over words, their first bits the most significant.
#[derive(Clone, Debug)]
pub struct RecordedWords<'b>(Words<'b>);

#[derive(Clone, Debug)]
enum Words<'b> {
    Bytes(Iter<'b, [u8; 1]>),
    Pairs(Iter<'b, [u8; 2]>),
    Fours(Iter<'b, [u8; 4]>),
    Eights(Iter<'b, [u8; 8]>),
    Fields(Iter<'b, BitField>, &'b [u8]),
}

impl WordMap {
    /// The words in the bits of a frame.
    pub fn words_of<'b>(&'b self, bits: &'b [u8]) -> RecordedWords<'b> {
        let whole = self.whole.and_then(|whole| Some((whole.width, bits.get(whole.from..)?.get(..whole.bytes)?)));
        RecordedWords(match whole {
            Some((1, bytes)) => Words::Bytes(bytes.as_chunks().0.iter()),
            Some((2, bytes)) => Words::Pairs(bytes.as_chunks().0.iter()),
            Some((4, bytes)) => Words::Fours(bytes.as_chunks().0.iter()),
            Some((8, bytes)) => Words::Eights(bytes.as_chunks().0.iter()),
            _ => Words::Fields(self.words.iter(), bits),
        })
    }
}

impl Iterator for RecordedWords<'_> {
    type Item = u64;

    #[inline]
    fn next(&mut self) -> Option<u64> {
        match &mut self.0 {
            Words::Bytes(words) => words.next().map(|word| u64::from(u8::from_be_bytes(*word))),
            Words::Pairs(words) => words.next().map(|word| u64::from(u16::from_be_bytes(*word))),
            Words::Fours(words) => words.next().map(|word| u64::from(u32::from_be_bytes(*word))),
            Words::Eights(words) => words.next().map(|word| u64::from_be_bytes(*word)),
            Words::Fields(fields, bits) => fields.find_map(|field| field.read(bits)),
        }
    }

    /// The kind of word is looked at once for them all.
    #[inline]
    fn fold<B, F: FnMut(B, u64) -> B>(self, first: B, mut with: F) -> B {
        match self.0 {
            Words::Bytes(words) => words.fold(first, |sum, word| with(sum, u64::from(u8::from_be_bytes(*word)))),
            Words::Pairs(words) => words.fold(first, |sum, word| with(sum, u64::from(u16::from_be_bytes(*word)))),
            Words::Fours(words) => words.fold(first, |sum, word| with(sum, u64::from(u32::from_be_bytes(*word)))),
            Words::Eights(words) => words.fold(first, |sum, word| with(sum, u64::from_be_bytes(*word))),
            Words::Fields(fields, bits) => fields.filter_map(|field| field.read(bits)).fold(first, with),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::packet_test::Noise;
    use super::super::pcm_layout::{PcmAlignment, PcmLayout, PcmMode, UnpackedForm};
    use super::*;

    #[test]
    fn words_in_one_pass_are_those_of_bit_fields() {
        let mut noise = Noise(9);
        let mut in_one_pass = 0;
        for round in 0..600 {
            let width = |noise: &mut Noise| 1 + noise.below(64) as u8;
            let count = 1 + noise.below(40);
            let widths: Vec<u8> = match round % 3 {
                0 => (0..count).map(|_| width(&mut noise)).collect(),
                1 => vec![width(&mut noise); count],
                _ => vec![[8, 16, 32, 64][noise.below(4)]; count],
            };
            let sync = [24, 32, width(&mut noise)][noise.below(3)];
            let layout = PcmLayout::new(sync, widths).unwrap();
            for mode in [PcmMode::Packed, PcmMode::Unpacked] {
                for alignment in [PcmAlignment::Bits16, PcmAlignment::Bits32] {
                    let map = layout.map(mode, alignment, UnpackedForm::default()).unwrap();
                    let mut bits: Vec<u8> = (0..map.bytes()).map(|_| noise.next() as u8).collect();
                    in_one_pass += u32::from(!matches!(map.words_of(&bits).0, Words::Fields(..)));
                    // A frame that is cut short has fewer words.
                    if noise.below(4) == 0 {
                        bits.truncate(noise.below(bits.len()));
                    }
                    let slow: Vec<u64> = map.words().iter().filter_map(|field| field.read(&bits)).collect();
                    assert_eq!(map.words_of(&bits).collect::<Vec<_>>(), slow, "{layout:?} {mode:?}");
                    let mut folded = Vec::new();
                    map.words_of(&bits).for_each(|word| folded.push(word));
                    assert_eq!(folded, slow, "{layout:?} {mode:?}");
                }
            }
        }
        assert!(in_one_pass > 400, "{in_one_pass}");
    }
}
