//! What happened to samples on their way to the axis: events with their place in time, dropouts, counters.

use crate::io::telemetry::alignment::dropout::{Dropout, IntervalFinding, RateChange};

/// What happened.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum TimelineEventKind {
    /// Dropped: it came so much too late, s.
    Late(f64),
    /// Dropped: the same time and value as the sample before of its channel.
    Repeated,
    /// Dropped: the same time as the sample before of its channel, and another value.
    Contradicting,
    /// Dropped: its stamp, so far from the newest, s, contradicts those around it.
    Stray(f64),
    /// Dropped: no such channel, or a stamp that is no number or of another kind.
    NoTime,
    /// The clock went back by so much, s: a new segment begins here.
    JumpBack(f64),
    /// The clock went forward by so much, s, or was silent.
    JumpForward(f64),
    /// The counter began again at zero.
    Wrap,
    /// Handed on before its time, for there was no more room.
    Early,
    /// A channel has another rate from here on.
    RateChange(RateChange),
}

/// What happened, where.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TimelineEvent {
    /// Time on the axis, s: of the sample, or the newest where the sample has none.
    pub at_s: f64,
    /// Channel of the sample.
    pub channel: usize,
    /// What.
    pub kind: TimelineEventKind,
}

/// Counters.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[expect(missing_docs, reason = "named as the events, where they are explained")]
pub struct ReorderTally {
    /// Samples that came.
    pub taken: u64,
    /// Samples that were handed on.
    pub put: u64,
    /// Samples that came after a newer one of their channel and found their place.
    pub reordered: u64,
    pub late: u64,
    pub repeated: u64,
    pub contradicting: u64,
    pub strays: u64,
    pub no_time: u64,
    pub jumps_back: u64,
    pub jumps_forward: u64,
    pub wraps: u64,
    pub early: u64,
    pub rate_changes: u64,
    pub dropouts: u64,
    /// Samples that are missing in all dropouts.
    pub missing: u64,
    /// Events and dropouts that the tables had no room for.
    pub beyond_tables: u64,
}

/// Tables of what happened.
#[derive(Clone, Debug)]
pub(super) struct TimelineTables {
    pub(super) events: Vec<TimelineEvent>,
    pub(super) dropouts: Vec<Dropout>,
    rows_max: usize,
    pub(super) tally: ReorderTally,
}

impl TimelineTables {
    /// All memory is taken here.
    pub(super) fn new(rows_max: usize) -> Self {
        let (events, dropouts) = (Vec::with_capacity(rows_max), Vec::with_capacity(rows_max));
        TimelineTables { events, dropouts, rows_max, tally: ReorderTally::default() }
    }

    pub(super) fn event(&mut self, at_s: f64, channel: usize, kind: TimelineEventKind) {
        let tally = &mut self.tally;
        *match kind {
            TimelineEventKind::Late(_) => &mut tally.late,
            TimelineEventKind::Repeated => &mut tally.repeated,
            TimelineEventKind::Contradicting => &mut tally.contradicting,
            TimelineEventKind::Stray(_) => &mut tally.strays,
            TimelineEventKind::NoTime => &mut tally.no_time,
            TimelineEventKind::JumpBack(_) => &mut tally.jumps_back,
            TimelineEventKind::JumpForward(_) => &mut tally.jumps_forward,
            TimelineEventKind::Wrap => &mut tally.wraps,
            TimelineEventKind::Early => &mut tally.early,
            TimelineEventKind::RateChange(_) => &mut tally.rate_changes,
        } += 1;
        if self.events.len() < self.rows_max {
            self.events.push(TimelineEvent { at_s, channel, kind });
        } else {
            tally.beyond_tables += 1;
        }
    }

    pub(super) fn interval(&mut self, finding: IntervalFinding) {
        match finding {
            IntervalFinding::RateChange(change) => {
                self.event(change.at_s, change.channel, TimelineEventKind::RateChange(change));
            }
            IntervalFinding::Dropout(dropout) => {
                self.tally.dropouts += 1;
                self.tally.missing += dropout.missing;
                if self.dropouts.len() < self.rows_max {
                    self.dropouts.push(dropout);
                } else {
                    self.tally.beyond_tables += 1;
                }
            }
        }
    }
}
