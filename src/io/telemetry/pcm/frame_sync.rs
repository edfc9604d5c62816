//! Minor frames out of a stream of bits: the frame synchroniser with the states search, check, lock and flywheel.
//!
//! Consumes bytes in pieces of any size, in which minor frames begin at any bit and in either polarity; produces each minor
//! frame of a stretch in lock, in the right polarity, with the place of its first bit in the stream. IRIG 106 Chapter 4 class
//! I: every minor frame has the same length and begins with the synchronisation pattern.
//!
//! | state | what is looked at | what follows |
//! | --- | --- | --- |
//! | search | every bit | a pattern: check |
//! | check | one minor frame further | a pattern for the last time asked for: lock; none: search from the bit behind the first |
//! | lock | one minor frame further | none: flywheel, unless it stands up to `slip_bits` beside its place (a bit slip) |
//! | flywheel | one minor frame further | a pattern: lock; none for too long: search from the bit behind the last pattern |
//!
//! The minor frames seen in check are handed out when lock is declared, so that the first is not lost. A minor frame is
//! handed out after the pattern behind it was looked at, and says what was found there: where that pattern is missing or
//! beside its place, bits of the minor frame may be shifted. Minor frames of a flywheel are held until a pattern ends it, and
//! are handed out with their lack of a pattern; where lock is lost instead they are discarded and counted. The search then
//! begins again behind the last pattern found, with the bits that are still here, so that a slip of any size costs the minor
//! frame that it is in.
//!
//! Memory is set at the start by the length of a minor frame; nothing is allocated later. Time for a byte in lock is that of
//! copying it twice; in search each of its bits is compared once.

use super::bit_buffer::BitBuffer;
use super::bits::LineCode;
use super::sync_pattern::{PolarityRule, SyncPattern, SyncRules};

/// Patterns of the minor frames that wait to be handed out, and the one behind them.
const PATTERNS_MAX: usize = SyncRules::FRAMES_MAX as usize + 2;

/// What stands behind a minor frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NextSync {
    /// A pattern at its place.
    Found,
    /// A pattern that many bits later (earlier where negative): bits were added or lost in this minor frame.
    Slipped(i32),
    /// An inverted pattern at its place: polarity changed in this minor frame.
    Inverted,
    /// None.
    Missed,
    /// The end of the stream, before a pattern could be looked at.
    EndOfStream,
}

/// One minor frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct MinorFrame<'b> {
    /// Its bits from the first of the pattern on, in right polarity; zeros fill the last byte.
    pub bytes: &'b [u8],
    /// Length, bits.
    pub bits: usize,
    /// Place of its first bit in the stream, from 0.
    pub first_bit: u64,
    /// Wrong bits of its pattern; `None` where the pattern was not found (flywheel).
    pub sync_errors: Option<u32>,
    /// Whether it was inverted on the line.
    pub inverted: bool,
    /// What stands behind it.
    pub next_sync: NextSync,
}

impl<'b> MinorFrame<'b> {
    /// One that something else has synchronised, for example a recorder.
    #[must_use]
    pub const fn synchronised(bytes: &'b [u8], bits: usize, first_bit: u64) -> Self {
        MinorFrame { bytes, bits, first_bit, sync_errors: Some(0), inverted: false, next_sync: NextSync::Found }
    }

    /// Whether bits of it may not stand at their places: no pattern at one of its ends.
    #[must_use]
    pub fn is_doubtful(&self) -> bool {
        self.sync_errors.is_none() || !matches!(self.next_sync, NextSync::Found | NextSync::EndOfStream)
    }
}

/// The state.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SyncState {
    /// No pattern yet.
    Search,
    /// A pattern that must be confirmed.
    Check,
    /// Patterns at their places.
    Lock,
    /// The last pattern was missing.
    Flywheel,
}

/// What was found so far.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct SyncCounters {
    /// Bits taken in.
    pub bits: u64,
    /// Minor frames handed out.
    pub minor_frames: u64,
    /// Of these, inverted on the line.
    pub inverted: u64,
    /// Of these, without a pattern of their own.
    pub flywheel: u64,
    /// Minor frames of a flywheel that ended without a pattern, not handed out.
    pub discarded: u64,
    /// Patterns that began a check.
    pub candidates: u64,
    /// Times that lock was declared.
    pub locks: u64,
    /// Times that it was lost.
    pub losses: u64,
    /// Patterns missing at their place in lock.
    pub missed_syncs: u64,
    /// Wrong bits of the patterns found in lock.
    pub sync_bit_errors: u64,
    /// Bit slips: patterns beside their place.
    pub slips: u64,
    /// Changes of polarity in lock.
    pub polarity_changes: u64,
}

impl SyncCounters {
    /// Adds those of a stream that ended before.
    #[must_use]
    pub const fn plus(self, earlier: &Self) -> Self {
        SyncCounters {
            bits: self.bits + earlier.bits,
            minor_frames: self.minor_frames + earlier.minor_frames,
            inverted: self.inverted + earlier.inverted,
            flywheel: self.flywheel + earlier.flywheel,
            discarded: self.discarded + earlier.discarded,
            candidates: self.candidates + earlier.candidates,
            locks: self.locks + earlier.locks,
            losses: self.losses + earlier.losses,
            missed_syncs: self.missed_syncs + earlier.missed_syncs,
            sync_bit_errors: self.sync_bit_errors + earlier.sync_bit_errors,
            slips: self.slips + earlier.slips,
            polarity_changes: self.polarity_changes + earlier.polarity_changes,
        }
    }
}

#[derive(Clone, Copy, Debug)]
enum Phase {
    Search {
        from: u64,
    },
    Check {
        start: u64,
        inverted: bool,
        hits: u32,
    },
    /// `start`: the first bit of the minor frame behind the last pattern found.
    Lock {
        start: u64,
        inverted: bool,
        missed: u32,
    },
}

/// Minor frames that are to be handed out.
#[derive(Clone, Copy, Debug)]
struct Held {
    start: u64,
    next: usize,
    count: usize,
    inverted: bool,
    /// Behind the last of them; a pattern stands or is missing between them.
    end: NextSync,
}

/// Finds minor frames.
#[derive(Clone, Debug)]
pub struct FrameSynchronizer {
    sync: SyncPattern,
    rules: SyncRules,
    polarity: PolarityRule,
    bits: usize,
    buffer: BitBuffer,
    phase: Phase,
    /// Wrong bits of the patterns of the minor frames held, first to last.
    errors: [Option<u32>; PATTERNS_MAX],
    held: Option<Held>,
    frame: Box<[u8]>,
    counters: SyncCounters,
}

impl FrameSynchronizer {
    /// For minor frames of that many bits. Rules beyond their largest values count as
    /// these; a validated format has none.
    #[must_use]
    pub fn new(sync: SyncPattern, rules: SyncRules, polarity: PolarityRule, code: LineCode, minor_frame_bits: usize) -> Self {
        let rules = SyncRules {
            check_frames: rules.check_frames.clamp(1, SyncRules::FRAMES_MAX),
            flywheel_frames: rules.flywheel_frames.min(SyncRules::FRAMES_MAX),
            slip_bits: rules.slip_bits.min(SyncRules::SLIP_MAX),
            ..rules
        };
        let bits = minor_frame_bits.max(sync.bits as usize + 1);
        let frames = rules.check_frames.max(rules.flywheel_frames + 1) as usize + 1;
        // Twice what is looked back to, so that bytes are rarely moved.
        let buffer = BitBuffer::new((frames * bits + 128).saturating_mul(2), code);
        FrameSynchronizer {
            sync,
            rules,
            polarity,
            bits,
            buffer,
            phase: Phase::Search { from: 0 },
            errors: [None; PATTERNS_MAX],
            held: None,
            frame: vec![0; bits.div_ceil(8)].into(),
            counters: SyncCounters::default(),
        }
    }

    /// Takes in what there is room for and says how many bytes that was; at least one where [`FrameSynchronizer::next_frame`]
    /// has just given `None`.
    pub fn take(&mut self, bytes: &[u8]) -> usize {
        let needed = match (self.held, self.phase) {
            (Some(held), _) => held.start,
            (None, Phase::Search { from }) => from,
            (None, Phase::Check { start, .. }) => start,
            (None, Phase::Lock { start, .. }) => start.saturating_sub(u64::from(SyncRules::SLIP_MAX)),
        };
        let count = self.buffer.take(bytes, needed);
        self.counters.bits += 8 * count as u64;
        count
    }

    /// The next minor frame; `None` where more bytes are needed.
    pub fn next_frame(&mut self) -> Option<MinorFrame<'_>> {
        while self.held.is_none() {
            self.step()?;
        }
        self.hand_out()
    }

    /// The next minor frame where no more bytes will come; `None` after the last.
    pub fn last_frame(&mut self) -> Option<MinorFrame<'_>> {
        while self.held.is_none() {
            if self.step().is_none() {
                let Phase::Lock { start, inverted, missed } = self.phase else { return None };
                let whole = usize::try_from(self.buffer.end().saturating_sub(start)).unwrap_or(0) / self.bits;
                self.phase = Phase::Search { from: self.buffer.end() };
                let looked_at = whole <= missed as usize;
                let end = if looked_at { NextSync::Missed } else { NextSync::EndOfStream };
                self.hold(start, whole.min(missed as usize + 1), inverted, end);
                self.held?;
            }
        }
        self.hand_out()
    }

    /// The state.
    #[must_use]
    pub fn state(&self) -> SyncState {
        match self.phase {
            Phase::Search { .. } => SyncState::Search,
            Phase::Check { .. } => SyncState::Check,
            Phase::Lock { missed: 0, .. } => SyncState::Lock,
            Phase::Lock { .. } => SyncState::Flywheel,
        }
    }

    /// What was found so far.
    #[must_use]
    pub fn counters(&self) -> SyncCounters {
        self.counters
    }

    /// One pattern looked at; `None` where more bytes are needed.
    fn step(&mut self) -> Option<()> {
        match self.phase {
            Phase::Search { from } => self.search(from),
            Phase::Check { start, inverted, hits } => self.check(start, inverted, hits),
            Phase::Lock { start, inverted, missed } => self.follow(start, inverted, missed),
        }
    }

    fn search(&mut self, from: u64) -> Option<()> {
        let (sync, most, compared) = (self.sync, self.rules.search_errors, self.sync.compared());
        let (normal, inverse) = (self.polarity != PolarityRule::Inverted, self.polarity != PolarityRule::Normal);
        let found = self.buffer.find(from, u64::MAX, sync.bits, |window| {
            let errors = sync.errors(window);
            if normal && errors <= most {
                Some((errors, false))
            } else if inverse && compared - errors <= most {
                Some((compared - errors, true))
            } else {
                None
            }
        });
        match found {
            Some((start, (errors, inverted))) => {
                self.counters.candidates += 1;
                self.put_errors(0, Some(errors));
                self.phase = Phase::Check { start, inverted, hits: 0 };
                Some(())
            }
            None => {
                let from = from.max((self.buffer.end() + 1).saturating_sub(u64::from(sync.bits)));
                self.phase = Phase::Search { from };
                None
            }
        }
    }

    fn check(&mut self, start: u64, inverted: bool, hits: u32) -> Option<()> {
        let place = start + (u64::from(hits) + 1) * self.bits as u64;
        let errors = self.errors_at(place, inverted)?;
        if errors > self.rules.check_errors {
            self.phase = Phase::Search { from: start + 1 };
            return Some(());
        }
        let hits = hits + 1;
        if hits < self.rules.check_frames {
            self.put_errors(hits as usize, Some(errors));
            self.phase = Phase::Check { start, inverted, hits };
            return Some(());
        }
        self.counters.locks += 1;
        self.counters.sync_bit_errors += self.errors.iter().take(hits as usize).flatten().map(|e| u64::from(*e)).sum::<u64>();
        self.hold(start, hits as usize, inverted, NextSync::Found);
        self.lock_at(place, inverted, errors);
        Some(())
    }

    fn follow(&mut self, start: u64, inverted: bool, missed: u32) -> Option<()> {
        let rules = self.rules;
        let place = start + (u64::from(missed) + 1) * self.bits as u64;
        // Whatever pieces the bytes come in, the whole window must be here.
        if place + u64::from(rules.slip_bits + self.sync.bits) > self.buffer.end() {
            return None;
        }
        let errors = self.errors_at(place, inverted)?;
        let compared = self.sync.compared();
        let (place, inverted, errors, end) = if errors <= rules.lock_errors {
            (place, inverted, errors, NextSync::Found)
        } else if self.polarity == PolarityRule::Automatic && compared - errors <= rules.check_errors {
            self.counters.polarity_changes += 1;
            (place, !inverted, compared - errors, NextSync::Inverted)
        } else if let Some((slip, errors)) = self.slipped(place, inverted) {
            self.counters.slips += 1;
            (place.saturating_add_signed(slip.into()), inverted, errors, NextSync::Slipped(slip))
        } else {
            self.counters.missed_syncs += 1;
            let missed = missed + 1;
            if missed > rules.flywheel_frames {
                self.counters.losses += 1;
                self.counters.discarded += u64::from(missed - 1);
                self.hold(start, 1, inverted, NextSync::Missed);
                self.phase = Phase::Search { from: start + 1 };
            } else {
                self.put_errors(missed as usize, None);
                self.phase = Phase::Lock { start, inverted, missed };
            }
            return Some(());
        };
        // Frames of a flywheel before a change of polarity are as doubtful in the one as in the other.
        let Phase::Lock { inverted: before, .. } = self.phase else { return None };
        self.hold(start, missed as usize + 1, before, end);
        self.lock_at(place, inverted, errors);
        Some(())
    }

    /// The pattern beside its place with the fewest errors, and among these the nearest.
    fn slipped(&self, place: u64, inverted: bool) -> Option<(i32, u32)> {
        let slips = (1..=self.rules.slip_bits.cast_signed()).flat_map(|by| [-by, by]);
        let at = |slip: i32| Some((slip, self.errors_at(place.checked_add_signed(slip.into())?, inverted)?));
        slips.filter_map(at).filter(|(_, errors)| *errors <= self.rules.check_errors).min_by_key(|(_, errors)| *errors)
    }

    fn errors_at(&self, place: u64, inverted: bool) -> Option<u32> {
        let errors = self.sync.errors(self.buffer.get(place, self.sync.bits)?);
        Some(if inverted { self.sync.compared() - errors } else { errors })
    }

    fn lock_at(&mut self, start: u64, inverted: bool, errors: u32) {
        self.counters.sync_bit_errors += u64::from(errors);
        self.phase = Phase::Lock { start, inverted, missed: 0 };
        // The errors of the frames held are read first; this is the first behind them.
        match self.held {
            Some(held) => self.put_errors(held.count, Some(errors)),
            None => self.put_errors(0, Some(errors)),
        }
    }

    fn put_errors(&mut self, index: usize, errors: Option<u32>) {
        if let Some(place) = self.errors.get_mut(index) {
            *place = errors;
        }
    }

    fn hold(&mut self, start: u64, count: usize, inverted: bool, end: NextSync) {
        self.held = (count > 0).then_some(Held { start, next: 0, count, inverted, end });
    }

    fn hand_out(&mut self) -> Option<MinorFrame<'_>> {
        let held = self.held?;
        let first_bit = held.start + (held.next * self.bits) as u64;
        let own = self.errors.get(held.next).copied().flatten();
        let behind = self.errors.get(held.next + 1).copied().flatten();
        let next = held.next + 1;
        let next_sync = match behind {
            _ if next == held.count => held.end,
            Some(_) => NextSync::Found,
            None => NextSync::Missed,
        };
        if next == held.count {
            self.held = None;
            self.put_errors(0, behind);
        } else {
            self.held = Some(Held { next, ..held });
        }
        self.buffer.copy(first_bit, self.bits, &mut self.frame, held.inverted).then_some(())?;
        self.counters.minor_frames += 1;
        self.counters.inverted += u64::from(held.inverted);
        self.counters.flywheel += u64::from(own.is_none());
        let (bytes, bits, inverted) = (&*self.frame, self.bits, held.inverted);
        Some(MinorFrame { bytes, bits, first_bit, sync_errors: own, inverted, next_sync })
    }
}

#[cfg(test)]
#[path = "frame_sync_tests.rs"]
mod tests;
