//! The frame synchroniser against streams whose minor frames are known bit by bit.

use super::super::test_random::Random;
use super::*;

const SYNC: SyncPattern = SyncPattern::whole(0xFE6B_2840, 32);
const RULES: SyncRules = SyncRules::for_length(32);
/// Bits of a minor frame: no whole bytes.
const LENGTH: usize = 301;

/// Bits of a stream, one a byte.
struct Stream {
    bits: Vec<u8>,
    random: Random,
}

impl Stream {
    fn new(seed: u64) -> Self {
        Stream { bits: Vec::new(), random: Random(seed) }
    }

    fn noise(mut self, count: usize) -> Self {
        for _ in 0..count {
            self.bits.push(self.random.below(2) as u8);
        }
        self
    }

    fn frames(mut self, count: usize) -> Self {
        for _ in 0..count {
            self.bits.extend((0..32).rev().map(|k| (0xFE6B_2840_u32 >> k & 1) as u8));
            self = self.noise(LENGTH - 32);
        }
        self
    }

    fn bytes(&self) -> Vec<u8> {
        self.bits.chunks(8).map(|bits| bits.iter().enumerate().fold(0, |byte, (k, bit)| byte | bit << (7 - k))).collect()
    }
}

#[derive(Debug, PartialEq, Eq)]
struct Found {
    at: u64,
    errors: Option<u32>,
    inverted: bool,
    next: NextSync,
    bytes: Vec<u8>,
}

fn run(bytes: &[u8], mut piece: impl FnMut() -> usize) -> (Vec<Found>, FrameSynchronizer) {
    let mut synchronizer = FrameSynchronizer::new(SYNC, RULES, PolarityRule::Automatic, LineCode::NrzL, LENGTH);
    let mut found = Vec::new();
    let mut rest = bytes;
    let own = |frame: MinorFrame<'_>| Found {
        at: frame.first_bit,
        errors: frame.sync_errors,
        inverted: frame.inverted,
        next: frame.next_sync,
        bytes: frame.bytes.to_vec(),
    };
    while !rest.is_empty() {
        let taken = synchronizer.take(&rest[..piece().clamp(1, rest.len())]);
        rest = &rest[taken..];
        let before = found.len();
        found.extend(std::iter::from_fn(|| synchronizer.next_frame().map(own)));
        assert!(taken > 0 || found.len() > before, "bytes are taken or frames given");
    }
    found.extend(std::iter::from_fn(|| synchronizer.last_frame().map(own)));
    (found, synchronizer)
}

fn places(found: &[Found]) -> Vec<u64> {
    found.iter().map(|frame| frame.at).collect()
}

fn at(from: usize, frames: std::ops::Range<usize>) -> Vec<u64> {
    frames.map(|k| (from + k * LENGTH) as u64).collect()
}

#[test]
fn every_minor_frame_from_the_first_to_the_last_whole_one_is_found_at_any_bit_offset() {
    for offset in 0..70 {
        let stream = Stream::new(1).noise(offset).frames(20).noise(40);
        let (found, synchronizer) = run(&stream.bytes(), || 1000);
        assert_eq!(places(&found), at(offset, 0..20));
        assert!(found.iter().take(19).all(|frame| frame.next == NextSync::Found && frame.errors == Some(0)));
        for frame in &found {
            let bits = &stream.bits[frame.at as usize..][..LENGTH];
            let expected = Stream { bits: bits.to_vec(), random: Random(0) }.bytes();
            assert_eq!(frame.bytes, expected);
        }
        let counters = synchronizer.counters();
        assert_eq!((counters.locks, counters.losses, counters.minor_frames, counters.sync_bit_errors), (1, 0, 20, 0));
    }
}

#[test]
fn pieces_of_any_size_give_the_same() {
    let stream = Stream::new(2).noise(777).frames(9).noise(3).frames(12).noise(1500).frames(30);
    let mut bytes = stream.bytes();
    let mut random = Random(3);
    for _ in 0..200 {
        let place = random.below(bytes.len());
        bytes[place] ^= 1 << random.below(8);
    }
    let (whole, first) = run(&bytes, || usize::MAX);
    assert!(whole.len() > 40, "{}", whole.len());
    for seed in 0..20 {
        let mut random = Random(seed);
        let most = [2, 9, 100, 3000][seed as usize % 4];
        let (pieces, second) = run(&bytes, || 1 + random.below(most));
        assert_eq!(pieces, whole);
        assert_eq!(second.counters(), first.counters());
    }
}

#[test]
fn an_inverted_stream_gives_the_same_bits_and_a_change_of_polarity_is_followed() {
    let stream = Stream::new(4).noise(13).frames(10);
    let inverted: Vec<u8> = stream.bytes().iter().map(|byte| !byte).collect();
    let (normal, _) = run(&stream.bytes(), || 50);
    let (found, synchronizer) = run(&inverted, || 50);
    assert_eq!(found.len(), 10);
    assert!(found.iter().zip(&normal).all(|(one, other)| one.bytes == other.bytes && one.inverted && !other.inverted));
    assert_eq!(synchronizer.counters().inverted, 10);
    // Inverted from the middle of the fifth on.
    let mut turned = stream;
    turned.bits.iter_mut().skip(13 + 4 * LENGTH + 150).for_each(|bit| *bit ^= 1);
    let (found, synchronizer) = run(&turned.bytes(), || 50);
    assert_eq!((places(&found), synchronizer.counters().polarity_changes), (at(13, 0..10), 1));
    assert_eq!(found[4].next, NextSync::Inverted);
    assert!(found.iter().enumerate().all(|(k, frame)| frame.inverted == (k > 4)));
    assert!(found[6..].iter().zip(&normal[6..]).all(|(one, other)| one.bytes == other.bytes));
    let mut fixed = FrameSynchronizer::new(SYNC, RULES, PolarityRule::Normal, LineCode::NrzL, LENGTH);
    assert!(fixed.take(&inverted) > 0 && fixed.next_frame().is_none());
}

#[test]
fn a_slip_within_the_window_costs_the_minor_frame_that_it_is_in() {
    for slip in [-2_i32, -1, 1, 2] {
        let mut stream = Stream::new(5).frames(12);
        let place = 5 * LENGTH + 100;
        if slip > 0 {
            let inserted = vec![1; slip as usize];
            stream.bits.splice(place..place, inserted);
        } else {
            stream.bits.drain(place..place + slip.unsigned_abs() as usize);
        }
        let (found, synchronizer) = run(&stream.noise(20).bytes(), || 64);
        let moved = (6 * LENGTH).saturating_add_signed(slip as isize);
        assert_eq!(places(&found), [at(0, 0..6), at(moved, 0..6)].concat(), "{slip}");
        assert_eq!(found.iter().filter(|frame| frame.next != NextSync::Found).count(), 2, "the slip and the end");
        assert_eq!((found[5].next, found[6].errors), (NextSync::Slipped(slip), Some(0)));
        let counters = synchronizer.counters();
        assert_eq!((counters.slips, counters.losses, counters.missed_syncs), (1, 0, 0));
    }
}

#[test]
fn a_slip_beyond_the_window_is_found_by_a_search_of_what_is_still_here() {
    for slip in [3_usize, 17, 140] {
        let mut stream = Stream::new(6).frames(15);
        stream.bits.drain(5 * LENGTH + 100..5 * LENGTH + 100 + slip);
        let (found, synchronizer) = run(&stream.noise(20).bytes(), || 64);
        assert_eq!(places(&found), [at(0, 0..6), at(6 * LENGTH - slip, 0..9)].concat(), "{slip}");
        assert_eq!(found[5].next, NextSync::Missed);
        let counters = synchronizer.counters();
        assert_eq!((counters.losses, counters.locks, counters.missed_syncs, counters.discarded), (1, 2, 4, 3));
    }
}

#[test]
fn a_flywheel_carries_over_missing_patterns_and_says_so() {
    let mut stream = Stream::new(7).frames(12).noise(20);
    for k in [4, 5, 6] {
        stream.bits[k * LENGTH..k * LENGTH + 32].fill(1);
    }
    let (found, synchronizer) = run(&stream.bytes(), || 64);
    assert_eq!(places(&found), at(0, 0..12));
    let missing: Vec<usize> = (0..12).filter(|k| found[*k].errors.is_none()).collect();
    assert_eq!(missing, [4, 5, 6]);
    let next: Vec<NextSync> = found[3..8].iter().map(|frame| frame.next).collect();
    assert_eq!(next, [NextSync::Missed, NextSync::Missed, NextSync::Missed, NextSync::Found, NextSync::Found]);
    let counters = synchronizer.counters();
    assert_eq!((counters.flywheel, counters.missed_syncs, counters.losses, counters.discarded), (3, 3, 0, 0));
    assert_eq!(found.iter().filter(|frame| frame.next == NextSync::EndOfStream).count(), 1);
}

#[test]
fn a_pattern_in_the_data_does_not_hide_the_true_one() {
    let mut stream = Stream::new(8).noise(200).frames(10);
    let pattern: Vec<u8> = stream.bits[200..232].to_vec();
    // False ones before the first true one, overlapping it by a minor frame, and in step with each other once.
    for place in [20, 20 + LENGTH, 150, 200 + 40, 200 + 3 * LENGTH + 60] {
        stream.bits.splice(place..place + 32, pattern.iter().copied());
    }
    let (found, synchronizer) = run(&stream.noise(20).bytes(), || 64);
    assert_eq!(places(&found), at(200, 0..10));
    assert_eq!(synchronizer.counters().candidates, 3);
}

#[test]
fn wrong_bits_of_the_pattern_are_borne_up_to_the_tolerance_of_the_state() {
    let with_errors = |errors: [usize; 4]| {
        let mut stream = Stream::new(9).frames(4).noise(20);
        for (k, count) in errors.into_iter().enumerate() {
            (0..count).for_each(|bit| stream.bits[k * LENGTH + 3 * bit] ^= 1);
        }
        let (found, _) = run(&stream.bytes(), || 64);
        found.iter().map(|frame| frame.errors).collect::<Vec<_>>()
    };
    assert_eq!(with_errors([1, 1, 1, 3]), [Some(1), Some(1), Some(1), Some(3)]);
    assert_eq!(with_errors([0, 0, 0, 4]), [Some(0), Some(0), Some(0), None]);
    assert!(with_errors([0, 0, 2, 0]).is_empty(), "no three in a row that pass search and check");
}

#[test]
fn nothing_is_found_in_noise_or_in_a_cut_stream() {
    let (found, synchronizer) = run(&Stream::new(10).noise(100_000).bytes(), || 4096);
    assert!(found.is_empty() && synchronizer.state() == SyncState::Search && synchronizer.counters().bits == 100_000);
    let (found, synchronizer) = run(&Stream::new(10).frames(2).noise(20).bytes(), || 4096);
    assert_eq!((found.len(), synchronizer.state()), (0, SyncState::Check));
    let (found, _) = run(&[], || 1);
    assert!(found.is_empty());
}
