//! Measures whether a sync pattern recurs in a stream of bits, and at what distance.
//!
//! Consumes bytes whose most significant bit came first; produces, for one pattern, the distance at which it recurs most
//! often, in either polarity. A distance is claimed only if at least [`FRAMES`] frames have it and they cover at least half
//! of what lies between the first and the last of them, and only up to [`PERIOD`]: a pseudo-random sequence of 32,767 bits
//! holds every pattern of 15 bits once, but in no frame that the standard allows. This is a measurement of a recording, no
//! frame synchroniser: it tolerates no bit error in the pattern. Memory: [`DISTANCES`] distances and the last [`RECENT`]
//! places for each polarity.
//! Source: IRIG 106 Chapter 4: minor frames have at most 16,384 bits (class II), sync patterns at least 16 bits.

use std::collections::{BTreeMap, VecDeque};

/// Frames that must have the distance.
pub const FRAMES: u64 = 4;
/// The longest distance, bits: two bytes for each 8 bits of a frame of 16,384 bits (unpacked mode), and a header.
pub const PERIOD: u64 = 32_000;
/// Distances that are counted.
pub const DISTANCES: usize = 4096;
/// Earlier places to which a distance is taken.
pub const RECENT: usize = 8;
/// The shortest pattern that is looked for, bits.
pub const PATTERN_BITS: u8 = 16;

/// A pattern and how it recurs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Recurrence {
    /// The pattern, its first bit the most significant.
    pub pattern: u64,
    /// Its length, bits.
    pub pattern_bits: u8,
    /// Whether the data are the complement.
    pub inverted: bool,
    /// The distance, bits.
    pub period: u64,
    /// Whole frames of that length.
    pub frames: u64,
}

/// What was counted for one distance.
#[derive(Clone, Copy, Debug, Default)]
struct DistanceCount {
    frames: u64,
    first: u64,
    last: u64,
}

/// The places of one polarity.
#[derive(Clone, Debug, Default)]
struct PatternPlaces {
    recent: VecDeque<u64>,
    distances: BTreeMap<u64, DistanceCount>,
}

impl PatternPlaces {
    fn hit(&mut self, at: u64) {
        for earlier in &self.recent {
            let distance = at - earlier;
            if distance > PERIOD || (self.distances.len() >= DISTANCES && !self.distances.contains_key(&distance)) {
                continue;
            }
            let count = self.distances.entry(distance).or_insert(DistanceCount { frames: 0, first: *earlier, last: at });
            count.frames += 1;
            count.last = at;
        }
        if self.recent.len() >= RECENT {
            self.recent.pop_front();
        }
        self.recent.push_back(at);
    }

    /// The most frequent distance, the shortest of these.
    fn best(&self) -> Option<(u64, DistanceCount)> {
        let most = self.distances.values().map(|count| count.frames).max()?;
        self.distances.iter().find(|(_, count)| count.frames == most).map(|(distance, count)| (*distance, *count))
    }
}

/// Looks for one pattern.
#[derive(Clone, Debug)]
pub struct SyncSearch {
    pattern: u64,
    mask: u64,
    bits: u8,
    register: u64,
    /// Bits in the register since the last gap.
    filled: u64,
    position: u64,
    upright: PatternPlaces,
    inverted: PatternPlaces,
}

impl SyncSearch {
    /// Looks for the lowest `bits` bits of `pattern`; `None` for patterns that are too short or too long.
    pub fn new(pattern: u64, bits: u8) -> Option<Self> {
        if !(PATTERN_BITS..=64).contains(&bits) {
            return None;
        }
        let mask = u64::MAX >> (64 - u32::from(bits));
        Some(SyncSearch {
            pattern: pattern & mask,
            mask,
            bits,
            register: 0,
            filled: 0,
            position: 0,
            upright: PatternPlaces::default(),
            inverted: PatternPlaces::default(),
        })
    }

    /// Takes in bits.
    pub fn push(&mut self, bytes: &[u8]) {
        for byte in bytes {
            for shift in (0..8).rev() {
                self.register = self.register << 1 | u64::from(byte >> shift & 1);
                self.position += 1;
                self.filled += 1;
                let apart = (self.register ^ self.pattern) & self.mask;
                if (apart == 0 || apart == self.mask) && self.filled >= u64::from(self.bits) {
                    let places = if apart == 0 { &mut self.upright } else { &mut self.inverted };
                    places.hit(self.position);
                }
            }
        }
    }

    /// Says that bits are missing here: no pattern and no distance reaches across.
    pub fn gap(&mut self) {
        self.filled = 0;
        self.upright.recent.clear();
        self.inverted.recent.clear();
    }

    /// What recurs, if anything does.
    pub fn found(&self) -> Option<Recurrence> {
        let claim = |places: &PatternPlaces, inverted: bool| {
            let (period, count) = places.best()?;
            let covered = count.frames.saturating_mul(period);
            (count.frames >= FRAMES && covered >= (count.last - count.first) / 2).then_some(Recurrence {
                pattern: self.pattern,
                pattern_bits: self.bits,
                inverted,
                period,
                frames: count.frames,
            })
        };
        let (upright, inverted) = (claim(&self.upright, false), claim(&self.inverted, true));
        upright.into_iter().chain(inverted).max_by_key(|found| found.frames)
    }
}

#[cfg(test)]
mod tests {
    use super::super::packet_test::Noise;
    use super::*;

    /// Bits of frames: a pattern of 24 bits, then noise up to the length.
    fn frames(count: usize, bits: usize, noise: &mut Noise) -> Vec<u8> {
        let mut stream = vec![1, 0, 1];
        for _ in 0..count {
            stream.extend((0..24).rev().map(|shift| (0xFA_F320_u32 >> shift & 1) as u8));
            stream.extend((24..bits).map(|_| noise.next() as u8 & 1));
        }
        stream.chunks_exact(8).map(|bits| bits.iter().fold(0, |byte, bit| byte << 1 | bit)).collect()
    }

    #[test]
    fn the_distance_of_the_pattern_is_found_in_either_polarity() {
        let mut noise = Noise(77);
        let bytes = frames(20, 453, &mut noise);
        let mut search = SyncSearch::new(0xFAF320, 24).unwrap();
        bytes.chunks(3).for_each(|piece| search.push(piece));
        let found = Recurrence { pattern: 0xFAF320, pattern_bits: 24, inverted: false, period: 453, frames: 19 };
        assert_eq!(search.found(), Some(found));
        let complement: Vec<u8> = bytes.iter().map(|byte| !byte).collect();
        let mut search = SyncSearch::new(0xFAF320, 24).unwrap();
        search.push(&complement);
        assert_eq!(search.found(), Some(Recurrence { inverted: true, ..found }));
        // Missing bits at a gap cost one frame.
        let mut search = SyncSearch::new(0xFAF320, 24).unwrap();
        search.push(&bytes[..570]);
        search.gap();
        search.push(&bytes[575..]);
        assert_eq!(search.found().map(|found| (found.period, found.frames)), Some((453, 18)));
    }

    #[test]
    fn noise_and_pseudo_random_sequences_have_no_frames() {
        let mut noise = Noise(9);
        let bytes: Vec<u8> = (0..1 << 20).map(|_| noise.next() as u8).collect();
        // x^15 + x^14 + 1.
        let mut state = 1_u16;
        let sequence: Vec<u8> = (0..1 << 17)
            .map(|_| {
                (0..8).fold(0, |byte, _| {
                    let bit = (state >> 14 ^ state >> 13) & 1;
                    state = state << 1 | bit;
                    byte << 1 | bit as u8
                })
            })
            .collect();
        for (pattern, bits) in [(0xEB90, 16), (0xFAF320, 24), (0xFE6B_2840, 32)] {
            for data in [&bytes, &sequence] {
                let mut search = SyncSearch::new(pattern, bits).unwrap();
                search.push(data);
                assert_eq!(search.found(), None, "{pattern:X}");
            }
        }
        assert!(SyncSearch::new(0xEB9, 12).is_none() && SyncSearch::new(0, 65).is_none());
    }

    #[test]
    fn constant_data_cost_bounded_memory() {
        let mut search = SyncSearch::new(0, 32).unwrap();
        search.push(&[0; 10_000]);
        assert_eq!(search.found().map(|found| found.period), Some(1));
        assert!(search.upright.distances.len() <= RECENT);
    }
}
