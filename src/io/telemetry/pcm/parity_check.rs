//! The parity of the words of minor frames, and whether it is theirs at all.
//!
//! Consumes minor frames; produces for each word whether its parity is wrong or in doubt. A line with so many bit errors that
//! one word in five has wrong parity has no frame lock, but half of all words do where the words have another parity than the
//! format says, or none: then the other half is right by chance, and a bit that is taken for the parity is missing in the value.
//! With w_k = 1 where the parity of the k-th checked word is wrong, else 0,
//!     s_k = s_(k-1) + (w_k - s_(k-1))/min(k, `MEMORY`)                                             (1)
//! over all words and for each of them. Where one of the two exceeds [`NOT_THE_PARITY`] the word's parity is in doubt.

use super::bits::read_bits;
use super::format::Parity;
use super::layout::{PcmFormat, WordLayout};

/// Words that (1) remembers.
const MEMORY: u32 = 64;
/// A share of words with wrong parity beyond which it is not their parity.
pub const NOT_THE_PARITY: f64 = 0.2;
/// Wrong words before that is said.
const WRONG: u32 = 3;

/// (1).
#[derive(Clone, Copy, Debug, Default)]
struct WrongShare {
    share: f64,
    checked: u32,
    wrong: u32,
}

impl WrongShare {
    fn put(&mut self, wrong: bool) {
        self.checked = self.checked.saturating_add(1);
        self.wrong = self.wrong.saturating_add(u32::from(wrong));
        self.share += (f64::from(u8::from(wrong)) - self.share) / f64::from(self.checked.min(MEMORY));
    }

    fn is_not_the_parity(&self) -> bool {
        self.wrong >= WRONG && self.share > NOT_THE_PARITY
    }
}

/// A word with a parity bit.
#[derive(Clone, Copy, Debug)]
struct ParityWord {
    /// From 1.
    number: u32,
    offset: u32,
    bits: u32,
    odd: bool,
    share: WrongShare,
}

/// Checks the words of minor frames.
#[derive(Clone, Debug)]
pub struct ParityCheck {
    words: Vec<ParityWord>,
    all: WrongShare,
    /// By number of the word: not to be used.
    refused: Vec<bool>,
    errors: u64,
    checks: u64,
    doubted: u64,
}

impl ParityCheck {
    /// For that format.
    #[must_use]
    pub fn new(format: &PcmFormat) -> Self {
        let word = |(word, number): (&WordLayout, u32)| {
            let odd = match word.parity {
                Parity::None => return None,
                Parity::Odd(_) => true,
                Parity::Even(_) => false,
            };
            Some(ParityWord { number, offset: word.offset, bits: word.bits, odd, share: WrongShare::default() })
        };
        ParityCheck {
            words: format.words().iter().zip(1..).filter_map(word).collect(),
            all: WrongShare::default(),
            refused: vec![false; format.words().len() + 1],
            errors: 0,
            checks: 0,
            doubted: 0,
        }
    }

    /// Takes in a minor frame.
    pub fn check(&mut self, bytes: &[u8]) {
        for word in &mut self.words {
            let ones = read_bits(bytes, word.offset as usize, word.bits).map_or(0, u64::count_ones);
            let wrong = (ones % 2 == 1) != word.odd;
            self.checks += 1;
            self.errors += u64::from(wrong);
            word.share.put(wrong);
            self.all.put(wrong);
            if let Some(place) = self.refused.get_mut(word.number as usize) {
                *place = wrong;
            }
        }
        let all = self.all.is_not_the_parity();
        for word in self.words.iter().filter(|word| all || word.share.is_not_the_parity()) {
            if let Some(place) = self.refused.get_mut(word.number as usize) {
                self.doubted += u64::from(!*place);
                *place = true;
            }
        }
    }

    /// Whether a word of the last minor frame, by its number from 1, has wrong parity or one in doubt.
    #[must_use]
    pub fn refuses(&self, word: u32) -> bool {
        self.refused.get(word as usize).is_some_and(|refused| *refused)
    }

    /// Words with wrong parity, and all that were checked.
    #[must_use]
    pub fn errors(&self) -> (u64, u64) {
        (self.errors, self.checks)
    }

    /// Words with right parity that is in doubt.
    #[must_use]
    pub fn doubted(&self) -> u64 {
        self.doubted
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::io::telemetry::pcm::test_random::Random;

    /// Eight words of 12 bits with even parity, the last of them of odd parity, behind a pattern of 24.
    fn check() -> ParityCheck {
        let text = "bit_rate = 48_000\nwords = 10\nword_bits = 12\nparity = \"even\"\n[sync]\npattern = 0xFA_F320\nbits = 24\n\
            [[word]]\nnumber = 9\nparity = \"odd\"\n[[parameter]]\nname = \"p\"\nword = 2\n";
        ParityCheck::new(&PcmFormat::from_toml(text).unwrap())
    }

    #[test]
    fn words_that_have_no_parity_are_all_doubted_at_once_and_single_errors_doubt_nothing_else() {
        let mut random = Random(4);
        let mut none = check();
        let mut passed = 0;
        for _ in 0..200 {
            none.check(&random.bytes(17));
            passed += (1..=9).filter(|word| !none.refuses(*word)).count();
        }
        assert!(passed < 20, "{passed} words passed");
        assert!(none.doubted() > 700 && none.errors().0 > 700, "{:?}", (none.doubted(), none.errors()));
        // Zeros: one wrong bit in ten frames costs the words that it hits; the last word, which should be odd, is never right.
        let (mut noisy, mut refused) = (check(), [0; 10]);
        for frame in 0..2000 {
            let mut bytes = [0; 17];
            if frame % 10 == 9 {
                bytes[3 + random.below(12)] ^= 1 << random.below(8);
            }
            noisy.check(&bytes);
            (1..=9).for_each(|word| refused[word as usize] += u32::from(noisy.refuses(word)));
        }
        assert_eq!((refused[9], noisy.doubted()), (2000, 0));
        assert!(refused[1..9].iter().all(|count| (5..60).contains(count)), "{refused:?}");
        // Words that begin to have their parity are used again.
        (0..100).for_each(|_| none.check(&[0; 17]));
        assert!((1..9).all(|word| !none.refuses(word)));
    }
}
