//! The frame synchronisation pattern, how many of its bits may be wrong in each state, and how often random bits pass for it.
//!
//! IRIG 106 Chapter 4 (4.3, fixed formats): a minor frame begins with a fixed pattern of 16 to 33 bits; Appendix C lists one
//! for each length.
//!
//! With `n` bits compared, a window of random bits has at most `e` errors with probability
//! `p(e) = sum over i = 0..e of C(n, i) / 2^n`. Lock is declared at a bit where a pattern with at most `search_errors` errors, in
//! either polarity where polarity is automatic, is followed by `check_frames` more, each a minor frame further and with at most
//! `check_errors` errors. Random bits lead to lock at
//!
//! ```text
//! (1 or 2) * p(search_errors) * p(check_errors)^check_frames      per bit searched.                                 (1)
//! ```
//!
//! With 32 bits and the default rules that is 9e-25; with 16 bits 2.1e-12.

/// The pattern.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SyncPattern {
    /// Its bits, the last sent in the lowest place.
    pub pattern: u64,
    /// Ones where a bit is compared.
    pub mask: u64,
    /// Length, bits.
    pub bits: u32,
}

impl SyncPattern {
    /// The shortest.
    pub const SHORTEST: u32 = 16;
    /// The longest.
    pub const LONGEST: u32 = 33;

    /// All of the bits compared.
    #[must_use]
    pub const fn whole(pattern: u64, bits: u32) -> Self {
        SyncPattern { pattern, mask: u64::MAX >> (64_u32.saturating_sub(bits) % 64), bits }
    }

    /// How many bits are compared.
    #[must_use]
    pub const fn compared(&self) -> u32 {
        self.mask.count_ones()
    }

    /// How many of the compared bits of a window differ.
    #[must_use]
    #[inline]
    pub const fn errors(&self, window: u64) -> u32 {
        ((window ^ self.pattern) & self.mask).count_ones()
    }

    /// The fewest differences between the pattern and itself sent that many bits earlier or later, over the bits that overlap.
    #[must_use]
    pub const fn distance_to_itself(&self, shift: u32) -> u32 {
        let overlap = self.mask & self.mask >> shift;
        ((self.pattern ^ self.pattern >> shift) & overlap).count_ones()
    }

    /// Probability that random bits differ in at most that many places.
    #[must_use]
    pub fn random_match(&self, errors: u32) -> f64 {
        let compared = self.compared();
        let (mut ways, mut sum) = (1.0, 0.0);
        for i in 0..=errors.min(compared) {
            sum += ways;
            ways *= f64::from(compared - i) / f64::from(i + 1);
        }
        sum / (1_u64 << compared.min(63)) as f64
    }

    /// How often random bits lead to lock, per bit searched (1).
    #[must_use]
    pub fn false_lock_rate(&self, rules: &SyncRules, polarity: PolarityRule) -> f64 {
        let ways = if polarity == PolarityRule::Automatic { 2.0 } else { 1.0 };
        let start = ways * self.random_match(rules.search_errors);
        (0..rules.check_frames).fold(start, |rate, _| rate * self.random_match(rules.check_errors))
    }
}

/// What the frame synchroniser takes for a pattern, and for how long it goes on without one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SyncRules {
    /// Wrong bits of a pattern that begins the search for lock.
    pub search_errors: u32,
    /// Wrong bits of a pattern that confirms it, and of one that is found beside its place after a bit slip.
    pub check_errors: u32,
    /// Wrong bits of a pattern in lock.
    pub lock_errors: u32,
    /// Patterns in a row that confirm lock, the first not counted.
    pub check_frames: u32,
    /// Patterns in a row that may be missing in lock.
    pub flywheel_frames: u32,
    /// Bits that a pattern may stand beside its expected place.
    pub slip_bits: u32,
}

impl SyncRules {
    /// The most frames that are held back until lock is confirmed or lost.
    pub const FRAMES_MAX: u32 = 16;
    /// The widest window about the expected place.
    pub const SLIP_MAX: u32 = 8;

    /// The default for that many compared bits: false lock on random bits below 1e-9 a bit, lock kept to a bit-error rate of
    /// 1e-2.
    #[must_use]
    pub const fn for_length(compared: u32) -> Self {
        SyncRules {
            search_errors: if compared < 20 { 0 } else { 1 },
            check_errors: 1,
            lock_errors: if compared < 24 { 2 } else { 3 },
            check_frames: 2,
            flywheel_frames: 3,
            slip_bits: 2,
        }
    }
}

/// Which polarity the stream has.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum PolarityRule {
    /// As sent.
    Normal,
    /// Every bit inverted.
    Inverted,
    /// Whichever gives patterns; a change in lock is followed.
    #[default]
    Automatic,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn probabilities_are_those_counted_out() {
        let sync = SyncPattern::whole(0xEB90, 16);
        for errors in [0, 1, 2, 5] {
            let counted = (0..1_u64 << 16).filter(|window| sync.errors(*window) <= errors).count();
            assert!((sync.random_match(errors) - counted as f64 / 65_536.0).abs() < 1e-15, "{errors}");
        }
        let masked = SyncPattern { mask: 0xFFF0, ..sync };
        assert!((masked.random_match(1) - 13.0 / 4096.0).abs() < 1e-15);
        assert!((masked.random_match(40) - 1.0).abs() < 1e-15);
    }

    #[test]
    fn false_lock_is_rarer_than_once_in_1e9_bits_at_every_length() {
        for bits in SyncPattern::SHORTEST..=SyncPattern::LONGEST {
            let sync = SyncPattern::whole(0x1_FE6B_2840, bits);
            let rate = sync.false_lock_rate(&SyncRules::for_length(bits), PolarityRule::Automatic);
            assert!(rate <= 1e-9, "{bits} bits: {rate:e}");
        }
        let rate = |bits| SyncPattern::whole(0, bits).false_lock_rate(&SyncRules::for_length(bits), PolarityRule::Automatic);
        assert!(
            (rate(32) / 9.1e-25 - 1.0).abs() < 0.02 && (rate(16) / 2.05e-12 - 1.0).abs() < 0.02,
            "{:e} {:e}",
            rate(32),
            rate(16)
        );
    }

    #[test]
    fn the_recommended_patterns_differ_from_themselves_shifted() {
        for (pattern, bits) in [(0xEB90, 16), (0xFA_F320, 24), (0xFE6B_2840, 32)] {
            let sync = SyncPattern::whole(pattern, bits);
            let least = (1..=2).map(|shift| sync.distance_to_itself(shift)).min().unwrap();
            assert!(least > SyncRules::for_length(bits).lock_errors, "{bits}: {least}");
        }
        assert_eq!(SyncPattern::whole(0xAAAA, 16).distance_to_itself(2), 0);
        assert_eq!(SyncPattern::whole(0xAAAA, 16).distance_to_itself(1), 15);
    }
}
