//! The last events, repeats folded into one entry with a count; totals by kind are complete. Fixed size, no allocation.
//!
//! Two events are repeats where kind and subject (channel, aid, axis) are equal; the entry keeps the newest values with the first
//! and last time, s. In a full ring the entry that is oldest by its last time is replaced; its count remains in the totals.

use super::record::{EventKind, EventRecord};
use super::words::event_text::{EVENT_KINDS, EventText, Severity, event_place, event_severity, event_subject};
use crate::flight::channel::ControlNames;
use core::fmt::{self, Display, Formatter};
use heapless::Vec;

/// An event with its repeats.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FoldedEvent {
    /// When it was first noticed, s.
    pub first_s: f64,
    /// When it was last noticed, s.
    pub last_s: f64,
    /// How often.
    pub count: u32,
    /// What, with the newest values.
    pub kind: EventKind,
}

/// A folded event as one sentence, with how often and when.
#[derive(Clone, Copy, Debug)]
pub struct FoldedText<'a> {
    /// The event.
    pub event: &'a FoldedEvent,
    /// How the controls are called.
    pub controls: ControlNames,
}

impl Display for FoldedText<'_> {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let FoldedEvent { first_s, last_s, count, kind } = self.event;
        write!(f, "{} (", EventText { kind, controls: self.controls })?;
        match count {
            0 | 1 => write!(f, "at {last_s:.2} s)"),
            _ => write!(f, "{count} times, {first_s:.2} to {last_s:.2} s)"),
        }
    }
}

/// The last `N` different events.
#[derive(Clone, Debug, Default)]
pub struct EventRing<const N: usize> {
    /// Oldest `last_s` first.
    entries: Vec<FoldedEvent, N>,
    totals: [u32; EVENT_KINDS],
    folded_away: u32,
}

impl<const N: usize> EventRing<N> {
    /// A ring without events.
    pub const fn new() -> Self {
        EventRing { entries: Vec::new(), totals: [0; EVENT_KINDS], folded_away: 0 }
    }

    /// Takes an event in.
    pub fn push(&mut self, event: &EventRecord) {
        if let Some(total) = self.totals.get_mut(event_place(&event.kind)) {
            *total = total.saturating_add(1);
        }
        let same = |entry: &FoldedEvent| {
            event_place(&entry.kind) == event_place(&event.kind)
                && event_subject(&entry.kind, ControlNames::Rotorcraft) == event_subject(&event.kind, ControlNames::Rotorcraft)
        };
        let entry = match self.entries.iter().position(same) {
            Some(place) => {
                let old = self.entries.remove(place);
                FoldedEvent { last_s: event.time_s, count: old.count.saturating_add(1), kind: event.kind, ..old }
            }
            None => {
                if self.entries.is_full() && !self.entries.is_empty() {
                    self.entries.remove(0);
                    self.folded_away = self.folded_away.saturating_add(1);
                }
                FoldedEvent { first_s: event.time_s, last_s: event.time_s, count: 1, kind: event.kind }
            }
        };
        // Fails only for a ring of no size, which keeps the totals alone.
        let _ = self.entries.push(entry);
    }

    /// The entries, the most recently noticed last.
    pub fn entries(&self) -> &[FoldedEvent] {
        &self.entries
    }

    /// How many entries had to make room.
    pub fn overwritten(&self) -> u32 {
        self.folded_away
    }

    /// How often each kind was noticed, by `text::event_place`; whatever the ring still holds.
    pub fn totals(&self) -> &[u32; EVENT_KINDS] {
        &self.totals
    }

    /// The worst severity among the entries still held.
    pub fn worst(&self) -> Option<Severity> {
        self.entries.iter().map(|entry| event_severity(&entry.kind)).max()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::flight::channel::Channel;
    use crate::realtime::estimation::record::EstimationEvent;

    fn event(time_s: f64, event: EstimationEvent) -> EventRecord {
        EventRecord { time_s, kind: EventKind::Estimation(event) }
    }

    #[test]
    fn repeats_fold_even_where_two_take_turns() {
        let mut ring = EventRing::<4>::new();
        for k in 0..100_u32 {
            let channel = if k % 2 == 0 { Channel::Phi } else { Channel::Theta };
            ring.push(&event(f64::from(k), EstimationEvent::OutOfRange { channel, value: f64::from(k) }));
        }
        let folded: std::vec::Vec<_> = ring.entries().iter().map(|e| (e.first_s, e.last_s, e.count)).collect();
        assert_eq!(folded, [(0.0, 98.0, 50), (1.0, 99.0, 50)]);
        assert_eq!(ring.totals()[1], 100);
        assert_eq!(
            ring.entries()[1].kind,
            EventKind::Estimation(EstimationEvent::OutOfRange { channel: Channel::Theta, value: 99.0 })
        );
    }

    #[test]
    fn a_full_ring_drops_the_longest_silent_and_keeps_the_totals() {
        let mut ring = EventRing::<2>::new();
        ring.push(&event(1.0, EstimationEvent::NotFinite { channel: Channel::P }));
        ring.push(&event(2.0, EstimationEvent::DuplicateTime));
        ring.push(&event(3.0, EstimationEvent::NotFinite { channel: Channel::P }));
        ring.push(&event(4.0, EstimationEvent::SegmentRestart));
        let counts: std::vec::Vec<_> = ring.entries().iter().map(|e| (event_place(&e.kind), e.count)).collect();
        assert_eq!(counts, [(0, 2), (6, 1)]);
        assert_eq!((ring.totals()[0], ring.totals()[3], ring.overwritten()), (2, 1, 1));
        assert_eq!(ring.worst(), Some(Severity::DataLost));
    }

    #[test]
    fn a_ring_of_no_size_still_counts() {
        let mut ring = EventRing::<0>::new();
        ring.push(&event(1.0, EstimationEvent::DuplicateTime));
        assert_eq!((ring.entries().len(), ring.totals()[3]), (0, 1));
    }
}
