//! Where the words of a minor frame stand in a PCM packet.
//!
//! Consumes the lengths of sync pattern and words; produces the place of each in the bits of a recorded minor frame, first
//! bit first. In packed mode the bits follow each other without gaps; in unpacked mode each word (and the sync pattern as
//! one) fills whole cells. In both, the frame is filled up to the alignment of the packet, 16 or 32 bits.
//! | words | cell of 16 bits | cell of 32 bits |
//! | --- | --- | --- |
//! | up to 16 bits | one | one |
//! | up to 32 bits | two | one |
//!
//! The standard speaks of cells of 16 bits; its programmers' handbook of 32 in 32-bit alignment. The recorder whose data we
//! know uses 16 in both alignments: [`UnpackedForm::default`]. The filler follows the word, whose first bit stands on the
//! boundary; the other reading can be set. Refused: words of no or more than 64 bits, frames longer than [`FRAME_BITS`].
//! Source: IRIG 106-09 Chapter 10, 10.6.2.2 (since 106-17 Chapter 11, 11.2.2); RCC 123 (handbook), PCM data format 1.

use super::error::Chapter10Error;
use crate::io::telemetry::pcm::bits::read_bits;

/// The longest minor frame, bits.
pub const FRAME_BITS: u64 = 1 << 18;
/// The longest word or sync pattern, bits.
pub const WORD_BITS: u8 = 64;

/// How the data are recorded.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PcmMode {
    /// Minor frames, each word in a cell of its own.
    Unpacked,
    /// Minor frames, bit after bit.
    Packed,
    /// Bits as they came, without frames.
    Throughput,
}

/// Size of the units in which the data are stored.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PcmAlignment {
    /// Little-endian words of 16 bits.
    Bits16,
    /// Little-endian words of 32 bits.
    Bits32,
}

impl PcmAlignment {
    /// In bits.
    pub const fn bits(self) -> u64 {
        match self {
            PcmAlignment::Bits16 => 16,
            PcmAlignment::Bits32 => 32,
        }
    }
}

/// Size of the cells in unpacked mode.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum CellSize {
    /// 16 bits.
    #[default]
    Bits16,
    /// 16 or 32 bits, like the alignment.
    Alignment,
}

/// Where the filler stands in a cell.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Filler {
    /// Behind the word.
    #[default]
    After,
    /// Before the word.
    Before,
}

/// How words are recorded in unpacked mode.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct UnpackedForm {
    /// Size of the cells.
    pub cell: CellSize,
    /// Where the filler stands.
    pub filler: Filler,
}

/// Lengths of sync pattern and words of a minor frame.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct PcmLayout {
    sync_bits: u8,
    widths: Vec<u8>,
}

impl PcmLayout {
    /// A layout of a sync pattern and words of any length.
    ///
    /// # Errors
    /// [`Chapter10Error`] where a length is not possible.
    pub fn new(sync_bits: u8, widths: Vec<u8>) -> Result<Self, Chapter10Error> {
        let wrong = |what: &'static str, found: u64| Err(Chapter10Error::PcmLayout { what, found });
        if sync_bits == 0 || sync_bits > WORD_BITS {
            return wrong("a sync pattern of 1 to 64 bits", sync_bits.into());
        }
        if let Some(width) = widths.iter().find(|width| **width == 0 || **width > WORD_BITS) {
            return wrong("words of 1 to 64 bits", (*width).into());
        }
        let layout = PcmLayout { sync_bits, widths };
        match layout.frame_bits() {
            bits if bits > FRAME_BITS => wrong("a minor frame of at most 262,144 bits", bits),
            _ => Ok(layout),
        }
    }

    /// A layout of words of one length; the sync pattern is not counted as a word.
    ///
    /// # Errors
    /// [`Chapter10Error`] where a length is not possible.
    pub fn uniform(sync_bits: u8, word_bits: u8, words: u32) -> Result<Self, Chapter10Error> {
        if u64::from(words) > FRAME_BITS {
            return Err(Chapter10Error::PcmLayout { what: "at most 262,144 words", found: words.into() });
        }
        PcmLayout::new(sync_bits, vec![word_bits; usize::try_from(words).unwrap_or(usize::MAX)])
    }

    /// Length of the sync pattern, bits.
    pub fn sync_bits(&self) -> u8 {
        self.sync_bits
    }

    /// Lengths of the words behind the sync pattern, bits.
    pub fn widths(&self) -> &[u8] {
        &self.widths
    }

    /// Length of the minor frame as it was transmitted, bits.
    pub fn frame_bits(&self) -> u64 {
        u64::from(self.sync_bits) + self.widths.iter().map(|width| u64::from(*width)).sum::<u64>()
    }

    /// Where everything stands in a packet; `None` in throughput mode, which has no frames.
    pub fn map(&self, mode: PcmMode, alignment: PcmAlignment, form: UnpackedForm) -> Option<WordMap> {
        let cell = match (mode, form.cell) {
            (PcmMode::Throughput, _) => return None,
            (PcmMode::Packed, _) => 1,
            (PcmMode::Unpacked, CellSize::Bits16) => 16,
            (PcmMode::Unpacked, CellSize::Alignment) => alignment.bits(),
        };
        let mut at = 0_u64;
        let mut place = |width: u8| {
            let taken = u64::from(width).next_multiple_of(cell);
            let filler = match form.filler {
                Filler::After => 0,
                Filler::Before => taken - u64::from(width),
            };
            let word = BitField { at: at + filler, width };
            at += taken;
            word
        };
        let sync = place(self.sync_bits);
        let words: Vec<BitField> = self.widths.iter().map(|width| place(*width)).collect();
        let whole = WholeWords::of(&words);
        let bytes = usize::try_from(at.next_multiple_of(alignment.bits()) / 8).ok()?;
        Some(WordMap { sync, words, whole, bytes, mode, alignment })
    }
}

/// Place of a word in the bits of a frame, first bit first.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BitField {
    /// Its first bit.
    pub at: u64,
    /// Its length, bits.
    pub width: u8,
}

impl BitField {
    /// The number in the field, its first bit the most significant; `None` where it ends outside.
    #[inline]
    pub fn read(self, bits: &[u8]) -> Option<u64> {
        read_bits(bits, usize::try_from(self.at).ok()?, self.width.into())
    }
}

/// Words of whole bytes without gaps.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct WholeWords {
    /// The first byte of the first word.
    pub(super) from: usize,
    /// Bytes of them all.
    pub(super) bytes: usize,
    /// Bytes of each: 1, 2, 4 or 8.
    pub(super) width: usize,
}

impl WholeWords {
    /// Of words in these places; `None` where one of them is otherwise.
    fn of(words: &[BitField]) -> Option<Self> {
        let first = words.first()?;
        let width = u64::from(first.width);
        let are_whole = matches!(width, 8 | 16 | 32 | 64) && first.at.is_multiple_of(8);
        let follows = |one: &BitField, next: &BitField| next.at == one.at + width && next.width == one.width;
        let follow = words.windows(2).all(|two| matches!(two, [one, next] if follows(one, next)));
        (are_whole && follow).then_some(())?;
        let width = usize::from(first.width / 8);
        Some(WholeWords { from: usize::try_from(first.at / 8).ok()?, bytes: width * words.len(), width })
    }
}

/// Where the words of a recorded minor frame stand.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct WordMap {
    pub(super) sync: BitField,
    pub(super) words: Vec<BitField>,
    /// Where the words are whole bytes one behind the other.
    pub(super) whole: Option<WholeWords>,
    pub(super) bytes: usize,
    pub(super) mode: PcmMode,
    pub(super) alignment: PcmAlignment,
}

impl WordMap {
    /// Length of a recorded frame with its filler, without its intra-packet header, bytes.
    pub fn bytes(&self) -> usize {
        self.bytes
    }

    /// The places of the words behind the sync pattern.
    pub fn words(&self) -> &[BitField] {
        &self.words
    }

    /// The place of the sync pattern.
    pub fn sync(&self) -> BitField {
        self.sync
    }
}

#[cfg(test)]
mod tests {
    use super::super::packet_test::Noise;
    use super::*;

    fn places(layout: &PcmLayout, mode: PcmMode, alignment: PcmAlignment, form: UnpackedForm) -> (Vec<u64>, usize) {
        let map = layout.map(mode, alignment, form).unwrap();
        (std::iter::once(map.sync).chain(map.words.clone()).map(|word| word.at).collect(), map.bytes)
    }

    #[test]
    fn words_stand_where_mode_and_alignment_put_them() {
        let layout = PcmLayout::new(24, vec![12, 10, 20]).unwrap();
        let form = UnpackedForm::default();
        assert_eq!(places(&layout, PcmMode::Packed, PcmAlignment::Bits16, form), (vec![0, 24, 36, 46], 10));
        assert_eq!(places(&layout, PcmMode::Packed, PcmAlignment::Bits32, form), (vec![0, 24, 36, 46], 12));
        assert_eq!(places(&layout, PcmMode::Unpacked, PcmAlignment::Bits16, form), (vec![0, 32, 48, 64], 12));
        let before = UnpackedForm { filler: Filler::Before, ..form };
        assert_eq!(places(&layout, PcmMode::Unpacked, PcmAlignment::Bits16, before), (vec![8, 36, 54, 76], 12));
        let wide = UnpackedForm { cell: CellSize::Alignment, ..form };
        assert_eq!(places(&layout, PcmMode::Unpacked, PcmAlignment::Bits32, wide), (vec![0, 32, 64, 96], 16));
        assert_eq!(layout.map(PcmMode::Throughput, PcmAlignment::Bits16, form), None);
        assert!(PcmLayout::new(0, vec![]).is_err() && PcmLayout::new(65, vec![]).is_err());
        assert!(PcmLayout::new(32, vec![0]).is_err() && PcmLayout::uniform(32, 64, 5000).is_err());
        assert!(PcmLayout::uniform(32, 16, u32::MAX).is_err());
        assert_eq!(PcmLayout::uniform(32, 16, 12).unwrap().frame_bits(), 224);
    }

    #[test]
    fn fields_are_read_as_bit_by_bit() {
        let mut noise = Noise(5);
        let bits: Vec<u8> = (0..64).map(|_| noise.next() as u8).collect();
        for _ in 0..2000 {
            let field = BitField { at: noise.below(500) as u64, width: 1 + noise.below(64) as u8 };
            let bit = |at: u64| bits.get(at as usize / 8).map(|byte| u64::from(byte >> (7 - at % 8) & 1));
            let slow = (field.at..field.at + u64::from(field.width)).try_fold(0, |value, at| Some(value << 1 | bit(at)?));
            assert_eq!(field.read(&bits), slow, "{field:?}");
        }
    }
}
