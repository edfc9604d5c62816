//! The number of a minor frame in its major frame, by the subframe identifier and its continuity.
//!
//! A number is trusted where the identifier has the value that follows from the last trusted one and from the minor frames
//! that passed since, by their places in the stream. One that has not is a wrong bit or a jump of the counter: the
//! subcommutated words of its minor frame are nobody's, and of those behind it until either an identifier follows from the
//! last trusted one again, or three in a row from each other. The first identifier is trusted.

use super::format::SubframeId;

/// What was found of identifiers.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct SubframeCounters {
    /// Identifiers that did not follow from the one before.
    pub jumps: u64,
    /// Identifiers that were those of the minor frame before.
    pub repeats: u64,
    /// Values that no minor frame has.
    pub out_of_range: u64,
}

/// Identifiers that must follow from one that would be a jump.
const CONFIRMATIONS: u32 = 2;

/// Follows the identifier.
#[derive(Clone, Debug)]
pub(super) struct SubframeTracker {
    id: SubframeId,
    minor_frames: u32,
    minor_frame_bits: u64,
    /// Number and first bit of the last minor frame whose number was trusted.
    trusted: Option<(u32, u64)>,
    /// The same of the last after what would be a jump, and how many before it say the same.
    jumped: Option<((u32, u64), u32)>,
    counters: SubframeCounters,
}

impl SubframeTracker {
    pub(super) fn new(id: SubframeId, minor_frames: u32, minor_frame_bits: usize) -> Self {
        let minor_frame_bits = (minor_frame_bits as u64).max(1);
        let (trusted, jumped) = (None, None);
        SubframeTracker { id, minor_frames, minor_frame_bits, trusted, jumped, counters: SubframeCounters::default() }
    }

    pub(super) fn counters(&self) -> SubframeCounters {
        self.counters
    }

    /// The number of the minor frame that begins there and has that identifier; `None` where it is not trusted.
    pub(super) fn number(&mut self, value: u64, first_bit: u64) -> Option<u32> {
        let read = self.id.number(value, self.minor_frames);
        let Some(read) = read else {
            self.counters.out_of_range += 1;
            return None;
        };
        let as_jump = self.jumped.filter(|(last, _)| self.following(*last, first_bit) == read).map_or(0, |(_, said)| said + 1);
        if self.trusted.is_none_or(|last| self.following(last, first_bit) == read) || as_jump >= CONFIRMATIONS {
            self.jumped = None;
            self.trusted = Some((read, first_bit));
            return Some(read);
        }
        if as_jump == 0 {
            let before = self.jumped.map(|(last, _)| last).or(self.trusted);
            if before.is_some_and(|(number, at)| number == read && self.passed(at, first_bit) == 1) {
                self.counters.repeats += 1;
            } else {
                self.counters.jumps += 1;
            }
        }
        self.jumped = Some(((read, first_bit), as_jump));
        None
    }

    /// Minor frames from one place to another, to the nearest.
    fn passed(&self, from: u64, to: u64) -> u64 {
        to.saturating_sub(from).saturating_add(self.minor_frame_bits / 2) / self.minor_frame_bits
    }

    fn following(&self, (number, at): (u32, u64), first_bit: u64) -> u32 {
        let behind = (u64::from(number - 1) + self.passed(at, first_bit)) % u64::from(self.minor_frames);
        behind as u32 + 1
    }
}

#[cfg(test)]
mod tests {
    use super::super::format::{CountDirection, WordPart};
    use super::*;

    /// Numbers of minor frames of 100 bits with these identifiers, from 0 to 7 in order, `None` left out in the stream.
    fn numbers(ids: &[Option<u64>]) -> (Vec<Option<u32>>, SubframeCounters) {
        let id = SubframeId { part: WordPart { word: 1, bits: None }, first_value: 0, direction: CountDirection::Up };
        let mut tracker = SubframeTracker::new(id, 8, 100);
        let frames = ids.iter().enumerate().filter_map(|(k, id)| Some((k as u64 * 100, (*id)?)));
        let found = frames.map(|(at, id)| tracker.number(id, at)).collect();
        (found, tracker.counters())
    }

    #[test]
    fn a_wrong_identifier_is_left_out_and_the_next_is_right() {
        let (found, counters) = numbers(&[6, 7, 0, 5, 2, 3].map(Some));
        assert_eq!(found, [Some(7), Some(8), Some(1), None, Some(3), Some(4)]);
        assert_eq!(counters, SubframeCounters { jumps: 1, ..SubframeCounters::default() });
        let (found, counters) = numbers(&[1, 2, 900, 4].map(Some));
        assert_eq!((found[2], found[3], counters.out_of_range), (None, Some(5), 1));
    }

    #[test]
    fn minor_frames_lost_in_the_stream_are_no_jump_and_those_lost_before_it_are_one() {
        let (found, counters) = numbers(&[Some(1), Some(2), None, None, Some(5)]);
        assert_eq!((found, counters), (vec![Some(2), Some(3), Some(6)], SubframeCounters::default()));
        let (found, counters) = numbers(&[1, 2, 6, 7, 0, 1].map(Some));
        assert_eq!(found, [Some(2), Some(3), None, None, Some(1), Some(2)]);
        assert_eq!(counters.jumps, 1);
    }

    #[test]
    fn repeats_are_counted_as_such() {
        let (found, counters) = numbers(&[1, 2, 2, 3, 4].map(Some));
        assert_eq!(found, [Some(2), Some(3), None, None, Some(5)]);
        assert_eq!(counters, SubframeCounters { repeats: 1, ..SubframeCounters::default() });
        let (found, counters) = numbers(&[2; 9].map(Some));
        assert_eq!(found.iter().flatten().count(), 2, "once a major frame a counter that stands is right");
        assert_eq!(counters.repeats, 7);
    }
}
