//! The description of a PCM format: what the minor frame holds, and where each parameter stands in it.
//!
//! IRIG 106 Chapter 4 (4.2, 4.3), fixed formats, in its terms: a minor frame begins with the synchronisation pattern, which
//! counts as one word whatever its length; the words behind it are numbered from 1. Minor frames of a major frame are
//! numbered from 1; the subframe identifier counts them. Bits of a word are numbered from 1, the most significant, which is
//! sent first. A word's length includes its parity bit, if it has one; its data bits are numbered without it.
//!
//! - Supercommutation: a parameter at several places of a minor frame.
//! - Subcommutation: a parameter in some of the minor frames of a major frame, at equal intervals.
//! - Concatenation: a parameter of several words or parts of words of the same minor frame, most significant first.
//!
//! A description is plain data; [`PcmFormat::new`](super::layout::PcmFormat::new) validates it. Not described: words sent
//! least significant bit first, parameters whose parts stand in different minor frames, formats that change, asynchronous
//! embedded formats.

use super::bits::LineCode;
use super::calibration::Calibration;
use super::encoding::RawEncoding;
use super::sync_pattern::{PolarityRule, SyncPattern, SyncRules};

/// A format.
#[derive(Clone, Debug, PartialEq)]
pub struct PcmFormatSpec {
    /// What it is called.
    pub name: String,
    /// Bits a second.
    pub bit_rate: f64,
    /// How bits stand on the line.
    pub line_code: LineCode,
    /// Which polarity is expected.
    pub polarity: PolarityRule,
    /// The frame synchronisation pattern.
    pub sync: SyncPattern,
    /// Its tolerances; by its length where absent.
    pub rules: Option<SyncRules>,
    /// Words of a minor frame, the synchronisation pattern counted as one.
    pub words: u32,
    /// Length of a word, bits.
    pub word_bits: u32,
    /// Parity of a word.
    pub parity: Parity,
    /// Words that differ from these.
    pub special_words: Vec<SpecialWord>,
    /// Minor frames of a major frame.
    pub minor_frames: u32,
    /// The word that counts them; needed where a parameter is subcommutated.
    pub subframe_id: Option<SubframeId>,
    /// What is measured.
    pub parameters: Vec<ParameterSpec>,
}

/// The parity bit of a word.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Parity {
    /// None.
    #[default]
    None,
    /// The ones of the word, its parity bit included, are odd.
    Odd(ParityPlace),
    /// The same, even.
    Even(ParityPlace),
}

/// Where the parity bit stands.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ParityPlace {
    /// Behind the data bits.
    #[default]
    Trailing,
    /// Before the data bits.
    Leading,
}

/// A word with a length or a parity of its own.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SpecialWord {
    /// Its number.
    pub word: u32,
    /// Its length, bits.
    pub bits: Option<u32>,
    /// Its parity.
    pub parity: Option<Parity>,
}

/// The counter of minor frames.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SubframeId {
    /// The word, and the bits of it.
    pub part: WordPart,
    /// Its value in minor frame 1.
    pub first_value: u32,
    /// Whether it counts up or down from there.
    pub direction: CountDirection,
}

/// Which way a counter counts.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum CountDirection {
    /// One more each minor frame.
    #[default]
    Up,
    /// One less.
    Down,
}

/// A word or bits of it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct WordPart {
    /// Number of the word.
    pub word: u32,
    /// First and last of its data bits, from 1; all where absent.
    pub bits: Option<(u32, u32)>,
}

/// A measured quantity.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ParameterSpec {
    /// Its name.
    pub name: String,
    /// Unit of its engineering values, as text.
    pub unit: String,
    /// Where it stands.
    pub places: Vec<ParameterPlace>,
    /// How its number is coded.
    pub encoding: RawEncoding,
    /// From that number to engineering units.
    pub calibration: Calibration,
    /// Where engineering values are expected.
    pub limits: ParameterLimits,
}

/// One place of a parameter in a minor frame, or several at equal intervals.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ParameterPlace {
    /// Its parts, most significant first.
    pub parts: Vec<WordPart>,
    /// Words from one such place to the next, to the end of the minor frame; one place where absent.
    pub word_interval: Option<u32>,
    /// The minor frames that have it; all where absent.
    pub frames: Option<FrameSet>,
}

/// Some of the minor frames of a major frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FrameSet {
    /// The first, from 1.
    pub first: u32,
    /// From one to the next; only the first where absent.
    pub interval: Option<u32>,
}

/// Where the engineering values of a parameter are expected.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ParameterLimits {
    /// The least.
    pub low: Option<f64>,
    /// The greatest.
    pub high: Option<f64>,
    /// The greatest change from a sample to the next.
    pub step: Option<f64>,
}

impl Default for PcmFormatSpec {
    /// 16-bit words behind a pattern of 32 bits (IRIG 106 Appendix C), no parameters.
    fn default() -> Self {
        PcmFormatSpec {
            name: String::new(),
            bit_rate: 1e6,
            line_code: LineCode::NrzL,
            polarity: PolarityRule::Automatic,
            sync: SyncPattern::whole(0xFE6B_2840, 32),
            rules: None,
            words: 2,
            word_bits: 16,
            parity: Parity::None,
            special_words: Vec::new(),
            minor_frames: 1,
            subframe_id: None,
            parameters: Vec::new(),
        }
    }
}

impl ParameterPlace {
    /// A whole word of every minor frame.
    #[must_use]
    pub fn word(word: u32) -> Self {
        ParameterPlace { parts: vec![WordPart { word, bits: None }], word_interval: None, frames: None }
    }
}

impl FrameSet {
    /// Whether that minor frame is one of them.
    #[must_use]
    pub fn contains(&self, number: u32) -> bool {
        match (number.checked_sub(self.first), self.interval) {
            (Some(0), _) => true,
            (Some(behind), Some(interval)) => interval > 0 && behind % interval == 0,
            _ => false,
        }
    }
}

impl SubframeId {
    /// The number, from 1, of the minor frame with that value, of a major frame of so many.
    #[must_use]
    pub fn number(&self, value: u64, minor_frames: u32) -> Option<u32> {
        let first = u64::from(self.first_value);
        let behind = match self.direction {
            CountDirection::Up => value.checked_sub(first)?,
            CountDirection::Down => first.checked_sub(value)?,
        };
        u32::try_from(behind.checked_add(1)?).ok().filter(|number| *number <= minor_frames)
    }

    /// The value in the minor frame of that number.
    #[must_use]
    pub fn value(&self, number: u32) -> u32 {
        match self.direction {
            CountDirection::Up => self.first_value.saturating_add(number.saturating_sub(1)),
            CountDirection::Down => self.first_value.saturating_sub(number.saturating_sub(1)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frame_sets_are_first_and_interval() {
        let members =
            |first, interval| -> Vec<u32> { (1..=16).filter(|number| FrameSet { first, interval }.contains(*number)).collect() };
        assert_eq!(members(3, Some(4)), [3, 7, 11, 15]);
        assert_eq!((members(5, None), members(17, Some(1)), members(2, Some(0))), (vec![5], vec![], vec![2]));
    }

    #[test]
    fn subframe_identifiers_count_either_way() {
        let part = WordPart { word: 1, bits: None };
        let up = SubframeId { part, first_value: 0, direction: CountDirection::Up };
        let down = SubframeId { part, first_value: 7, direction: CountDirection::Down };
        for number in 1..=8 {
            assert_eq!(up.number(up.value(number).into(), 8), Some(number));
            assert_eq!(down.number(down.value(number).into(), 8), Some(number));
        }
        assert_eq!((up.value(8), down.value(8)), (7, 0));
        assert_eq!((up.number(8, 8), down.number(8, 8), up.number(u64::MAX, 8)), (None, None, None));
    }
}
