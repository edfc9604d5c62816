//! The clock's own axis: wraps counted on, jumps confirmed, segments one behind the other.
//!
//! Consumes the stamps of groups of samples in order of arrival; places each, or holds it in doubt. A stamp more than
//! `forward_s` after the newest or more than `back_s` before it is believed once [`CONFIRMED`] in a row agree with each other,
//! and is a stray otherwise. A clock that has gone back begins a new segment, set behind the last; one that has gone forward
//! goes on as it says.
//! A counter's reading means the number nearest to the newest with these bits: a restart from more than half of its range is
//! taken for a wrap and a step forward, for nothing tells them apart.

use super::config::{RawStamp, StampUnit};
use crate::io::telemetry::counter;

/// Stamps in a row that confirm a jump, as of a sender's boot clock.
pub(super) const CONFIRMED: usize = 3;
/// No clock counts so far, s (a thousand years): what does is damaged.
const LONGEST_S: f64 = 3.2e10;

/// Samples of one stamp that is in doubt.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Doubtful {
    pub(super) clock_s: f64,
    /// Which group of samples.
    pub(super) group: u64,
}

/// At most [`CONFIRMED`] of them.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct DoubtfulGroups {
    held: [Doubtful; CONFIRMED],
    count: usize,
}

impl DoubtfulGroups {
    pub(super) fn iter(&self) -> impl Iterator<Item = &Doubtful> {
        self.held.iter().take(self.count)
    }

    fn push(&mut self, one: Doubtful) {
        if let Some(place) = self.held.get_mut(self.count) {
            *place = one;
            self.count += 1;
        }
    }

    fn last(&self) -> Option<&Doubtful> {
        self.held.get(self.count.checked_sub(1)?)
    }
}

/// Where a stamp stands.
#[derive(Clone, Copy, Debug)]
pub(super) enum AxisPlacement {
    /// On the axis; what was in doubt before were strays.
    At { strays: DoubtfulGroups, wrapped: bool },
    /// Not known yet; others that were in doubt before were strays.
    InDoubt { strays: DoubtfulGroups },
    /// The clock has jumped by so much, s, with these groups; before, the newest stood there on the axis.
    Jumped { confirmed: DoubtfulGroups, by_s: f64, from_axis_s: f64, wrapped: bool },
}

/// The axis.
#[derive(Clone, Debug)]
pub(super) struct SegmentedAxis {
    unit: StampUnit,
    forward_s: f64,
    back_s: f64,
    between_s: f64,
    /// Newest stamp, s and in counts.
    newest_s: Option<f64>,
    newest_count: Option<i64>,
    /// How often the counter has begun again.
    wraps: i64,
    shift_s: f64,
    doubt: DoubtfulGroups,
}

impl SegmentedAxis {
    pub(super) fn new(unit: StampUnit, forward_s: f64, back_s: f64, between_s: f64) -> Self {
        SegmentedAxis {
            unit,
            forward_s,
            back_s,
            between_s,
            newest_s: None,
            newest_count: None,
            wraps: 0,
            shift_s: 0.0,
            doubt: DoubtfulGroups::default(),
        }
    }

    /// The newest time on the axis, s.
    pub(super) fn newest_s(&self) -> Option<f64> {
        self.newest_s.map(|newest_s| newest_s + self.shift_s)
    }

    /// The newest time of the clock, s.
    pub(super) fn newest_clock_s(&self) -> Option<f64> {
        self.newest_s
    }

    /// A time of the clock on the axis, s.
    pub(super) fn on_axis_s(&self, clock_s: f64) -> f64 {
        clock_s + self.shift_s
    }

    /// The clock's time that a stamp means, s; `None` where it is no number, or not of this unit.
    pub(super) fn unwrapped_s(&self, stamp: RawStamp) -> Option<f64> {
        match (self.unit, stamp) {
            (StampUnit::Seconds, RawStamp::Seconds(time_s)) => (libm::fabs(time_s) < LONGEST_S).then_some(time_s),
            (StampUnit::Counter { bits, tick_s }, RawStamp::Count(count)) => {
                let modulus = 1_i64 << bits;
                let low = i64::try_from(count).ok().filter(|low| *low < modulus)?;
                let count = self.newest_count.map_or(low, |near| counter::nearest(near, low, modulus));
                Some(count as f64 * tick_s).filter(|time_s| libm::fabs(*time_s) < LONGEST_S)
            }
            _ => None,
        }
    }

    fn fits(&self, step_s: f64) -> bool {
        step_s >= -self.back_s && step_s <= self.forward_s
    }

    /// Places the time of a group of samples.
    pub(super) fn place(&mut self, clock_s: f64, group: u64) -> AxisPlacement {
        let Some(newest_s) = self.newest_s else {
            self.renew(clock_s);
            self.wraps = self.wraps_at(clock_s);
            return AxisPlacement::At { strays: DoubtfulGroups::default(), wrapped: false };
        };
        if self.fits(clock_s - newest_s) {
            let strays = std::mem::take(&mut self.doubt);
            self.renew(newest_s.max(clock_s));
            return AxisPlacement::At { strays, wrapped: self.has_wrapped() };
        }
        let mut strays = DoubtfulGroups::default();
        if self.doubt.last().is_some_and(|last| !self.fits(clock_s - last.clock_s)) {
            strays = std::mem::take(&mut self.doubt);
        }
        self.doubt.push(Doubtful { clock_s, group });
        if self.doubt.count < CONFIRMED {
            return AxisPlacement::InDoubt { strays };
        }
        let confirmed = std::mem::take(&mut self.doubt);
        let times = || confirmed.iter().map(|one| one.clock_s);
        let (first_s, last_s) = (times().fold(f64::INFINITY, f64::min), times().fold(f64::NEG_INFINITY, f64::max));
        let by_s = first_s - newest_s;
        let from_axis_s = newest_s + self.shift_s;
        if by_s < 0.0 {
            self.shift_s += self.between_s - by_s;
        }
        self.renew(last_s);
        let wrapped = by_s >= 0.0 && self.has_wrapped();
        self.wraps = self.wraps_at(last_s);
        AxisPlacement::Jumped { confirmed, by_s, from_axis_s, wrapped }
    }

    /// What is left in doubt at the end.
    pub(super) fn finish(&mut self) -> DoubtfulGroups {
        std::mem::take(&mut self.doubt)
    }

    fn renew(&mut self, newest_s: f64) {
        self.newest_s = Some(newest_s);
        if let StampUnit::Counter { tick_s, .. } = self.unit {
            #[expect(clippy::cast_possible_truncation, reason = "below 2^63: at most LONGEST_S of counts above 4 ns; saturates")]
            let count = libm::round(newest_s / tick_s) as i64;
            self.newest_count = Some(count);
        }
    }

    /// How often the counter began again before that time.
    fn wraps_at(&self, clock_s: f64) -> i64 {
        match self.unit {
            #[expect(clippy::cast_possible_truncation, reason = "saturates")]
            StampUnit::Counter { bits, tick_s } => libm::floor(libm::round(clock_s / tick_s) / (1_i64 << bits) as f64) as i64,
            StampUnit::Seconds => 0,
        }
    }

    /// Whether the newest lies behind a further turn of the counter.
    fn has_wrapped(&mut self) -> bool {
        let wraps = self.newest_s.map_or(0, |newest_s| self.wraps_at(newest_s));
        let wrapped = wraps > self.wraps;
        self.wraps = self.wraps.max(wraps);
        wrapped
    }
}
