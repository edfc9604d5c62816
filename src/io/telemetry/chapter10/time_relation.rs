//! From the relative time counter to the time of the year or since 1970.
//!
//! Consumes counts with the times that belong to them (from time packets, in order); produces the time of any count. Between
//! two references that agree the time is a straight line; elsewhere it goes on from the nearest earlier reference, or back
//! from the first one, at 10 MHz:
//!     t = t_i + (n - n_i) (t_{i+1} - t_i) / (n_{i+1} - n_i)                                        (1)
//!     t = t_i + (n - n_i) 100 ns                                                                   (2)
//! | n | count, unwrapped: 48 bits wrap after 325.8 days | | t | time, ns since the start of the year, or since 1970 |
//!
//! Two references agree if the second lies within [`TOLERANCE_NS`] and 100 ppm of the interval of (2). If not, that is
//! counted and reported, and both stay: the clock was set, or lost its source. A counter that runs backwards means that the
//! recorder started again: what came before is dropped, so times must be asked in the order of the packets. A time without
//! year that falls back by 365 or 366 days is the turn of the year and goes on counting. Only one time channel is followed,
//! the first that comes unless told otherwise. Memory: [`REFERENCES`] references, the oldest go first.
//! Source: IRIG 106-09 Chapter 10, 10.6.1.1 i (counter) and 10.6.3 (time packets). Equation (1) is our own choice.

use super::error::Chapter10Error;
use super::header::{RTC_MODULUS, data_type};
use super::packet::{Chapter10Packet, Integrity};
use super::time::{CalendarTime, DAY_NS, TimePacket};
use crate::io::telemetry::counter;
use std::collections::VecDeque;

/// How far apart two references may be, ns: the digits of a time packet end at 10 ms.
pub const TOLERANCE_NS: i64 = 10_000_000;
/// References that are kept at most: 18 hours at one a second.
pub const REFERENCES: usize = 1 << 16;

const TICK_NS: i64 = 100;

/// What a time is counted from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TimeScale {
    /// From the first of January of a year that the recording does not tell.
    YearStart,
    /// From 1970.
    Since1970,
}

/// How a time was found.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TimeBasis {
    /// Between two references that agree.
    Between,
    /// So many ns after a reference.
    After(i64),
    /// So many ns before the first reference.
    Before(i64),
}

/// The time of a count.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct AbsoluteTime {
    /// Nanoseconds on the scale.
    pub ns: i64,
    /// The scale.
    pub scale: TimeScale,
    /// How it was found.
    pub basis: TimeBasis,
}

/// Two references that do not agree.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TimeDisagreement {
    /// Relative time counter of the second one.
    pub rtc: u64,
    /// The time that the first one predicts there, ns.
    pub expected_ns: i64,
    /// The time that the second one says, ns.
    pub found_ns: i64,
}

/// What was found so far.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct TimeTally {
    /// References that were taken.
    pub references: u64,
    /// Time packets that hold no time, or are damaged.
    pub unreadable: u64,
    /// Time packets of other channels than the one that is followed.
    pub other_channel: u64,
    /// Times on another scale than the first one (with a year, without a year).
    pub other_scale: u64,
    /// References that repeat the count of the one before.
    pub repeated: u64,
    /// References that do not agree with the one before.
    pub disagreements: u64,
    /// The first of these.
    pub first_disagreement: Option<TimeDisagreement>,
    /// Times that the counter ran backwards: the recorder started again.
    pub counter_restarts: u64,
    /// Times that the counter passed 2^48.
    pub counter_wraps: u64,
    /// Turns of the year in times without year.
    pub year_ends: u64,
    /// Largest difference between references that agree and 10 MHz, ns.
    pub largest_drift_ns: i64,
}

#[derive(Clone, Copy, Debug)]
struct Reference {
    count: i64,
    ns: i64,
    /// Whether it agrees with the one before it.
    agrees: bool,
}

/// The relation between counter and time.
#[derive(Clone, Debug, Default)]
pub struct TimeRelation {
    channel: Option<u16>,
    scale: Option<TimeScale>,
    references: VecDeque<Reference>,
    /// Added to every time: years that have passed.
    years_ns: i64,
    tally: TimeTally,
}

impl TimeRelation {
    /// Nothing known; `channel` is the time channel to follow, the first that comes if `None`.
    pub fn new(channel: Option<u16>) -> Self {
        TimeRelation { channel, ..TimeRelation::default() }
    }

    /// What was found so far.
    pub fn tally(&self) -> TimeTally {
        self.tally
    }

    /// The time channel that is followed.
    pub fn channel(&self) -> Option<u16> {
        self.channel
    }

    /// Takes in a packet; those of other types than time data, format 1, mean nothing here.
    ///
    /// # Errors
    /// [`Chapter10Error`] where it is a time packet and holds no time; this is counted, too.
    pub fn packet(&mut self, packet: &Chapter10Packet<'_>) -> Result<(), Chapter10Error> {
        if packet.header.data_type != data_type::TIME_1 {
            return Ok(());
        }
        if packet.integrity == Integrity::Damaged {
            self.tally.unreadable += 1;
            return Ok(());
        }
        match TimePacket::parse(packet.body) {
            Ok(time) => self.reference(packet.header.channel, packet.header.rtc, &time.time),
            Err(error) => {
                self.tally.unreadable += 1;
                return Err(error);
            }
        }
        Ok(())
    }

    /// Takes in the time that belongs to a count.
    pub fn reference(&mut self, channel: u16, rtc: u64, time: &CalendarTime) {
        if *self.channel.get_or_insert(channel) != channel {
            self.tally.other_channel += 1;
            return;
        }
        let (scale, ns) = match time.since_1970_ns() {
            Some(ns) => (TimeScale::Since1970, ns),
            None => (TimeScale::YearStart, time.of_year_ns()),
        };
        if *self.scale.get_or_insert(scale) != scale {
            self.tally.other_scale += 1;
            return;
        }
        let mut ns = ns.saturating_add(self.years_ns);
        let Some(last) = self.references.back().copied() else {
            return self.push(Reference { count: wrapped(rtc), ns, agrees: false });
        };
        let count = self.unwrap(rtc, last.count);
        let passed = count - last.count;
        if passed == 0 {
            self.tally.repeated += 1;
            return;
        }
        if passed < 0 {
            self.tally.counter_restarts += 1;
            self.references.clear();
            return self.push(Reference { count: wrapped(rtc), ns, agrees: false });
        }
        if count.div_euclid(RTC_MODULUS_I64) > last.count.div_euclid(RTC_MODULUS_I64) {
            self.tally.counter_wraps += 1;
        }
        let expected_ns = last.ns.saturating_add(passed * TICK_NS);
        let tolerance_ns = TOLERANCE_NS + passed / (10_000 / TICK_NS);
        let fits = |ns: i64| ns.saturating_sub(expected_ns).saturating_abs() <= tolerance_ns;
        if scale == TimeScale::YearStart && !fits(ns) {
            let turned = [365, 366].into_iter().map(|days| days * DAY_NS).find(|year| fits(ns.saturating_add(*year)));
            if let Some(year_ns) = turned {
                self.tally.year_ends += 1;
                self.years_ns = self.years_ns.saturating_add(year_ns);
                ns = ns.saturating_add(year_ns);
            }
        }
        let agrees = fits(ns);
        if agrees {
            let drift_ns = ns.saturating_sub(expected_ns).saturating_abs();
            self.tally.largest_drift_ns = self.tally.largest_drift_ns.max(drift_ns);
        } else {
            self.tally.disagreements += 1;
            self.tally.first_disagreement.get_or_insert(TimeDisagreement { rtc, expected_ns, found_ns: ns });
        }
        self.push(Reference { count, ns, agrees });
    }

    /// The time of a count; `None` as long as there is no reference.
    pub fn at(&self, rtc: u64) -> Option<AbsoluteTime> {
        let scale = self.scale?;
        let count = self.unwrap(rtc, self.references.back()?.count);
        let next = self.references.partition_point(|reference| reference.count <= count);
        let later = self.references.get(next);
        let found = |ns: i64, basis: TimeBasis| Some(AbsoluteTime { ns, scale, basis });
        let Some(earlier) = next.checked_sub(1).and_then(|index| self.references.get(index)) else {
            let before_ns = (later?.count - count) * TICK_NS;
            return found(later?.ns.saturating_sub(before_ns), TimeBasis::Before(before_ns));
        };
        let passed = count - earlier.count;
        if passed == 0 {
            return found(earlier.ns, TimeBasis::After(0));
        }
        if let Some(later) = later.filter(|later| later.agrees) {
            let rise = i128::from(passed) * (i128::from(later.ns) - i128::from(earlier.ns));
            let line = rise / i128::from(later.count - earlier.count).max(1);
            return found(earlier.ns.saturating_add(i64::try_from(line).ok()?), TimeBasis::Between);
        }
        found(earlier.ns.saturating_add(passed * TICK_NS), TimeBasis::After(passed * TICK_NS))
    }

    fn push(&mut self, reference: Reference) {
        if self.references.len() >= REFERENCES {
            self.references.pop_front();
        }
        self.references.push_back(reference);
        self.tally.references += 1;
    }

    /// The count nearest to a known one that has these 48 bits. Half of the modulus is 2^47 ticks, or 1.4e16 ns.
    fn unwrap(&self, rtc: u64, near: i64) -> i64 {
        counter::nearest(near, wrapped(rtc), RTC_MODULUS_I64)
    }
}

const RTC_MODULUS_I64: i64 = RTC_MODULUS as i64;

fn wrapped(rtc: u64) -> i64 {
    (rtc % RTC_MODULUS) as i64
}

#[cfg(test)]
mod tests {
    use super::super::time::NS;
    use super::*;

    fn day(day_of_year: u16, second: i64) -> CalendarTime {
        CalendarTime { year: None, day_of_year, of_day_ns: second * NS }
    }

    #[test]
    fn between_references_the_line_through_them_counts_and_elsewhere_ten_megahertz() {
        let mut relation = TimeRelation::new(None);
        assert_eq!(relation.at(5), None);
        relation.reference(1, 1000, &day(1, 10));
        relation.reference(1, 10_001_000 + 20, &day(1, 11));
        relation.reference(2, 10_001_000, &day(9, 11));
        let ns = |rtc| relation.at(rtc).map(|time| (time.ns, time.basis)).unwrap();
        assert_eq!(ns(1000), (10 * NS, TimeBasis::After(0)));
        // 5,000,010 counts of 10,000,020 are half a second.
        assert_eq!(ns(5_001_010), (10 * NS + NS / 2, TimeBasis::Between));
        assert_eq!(ns(10_001_030), (11 * NS + 1000, TimeBasis::After(1000)));
        assert_eq!(ns(0), (10 * NS - 100_000, TimeBasis::Before(100_000)));
        let tally = relation.tally();
        assert_eq!((tally.references, tally.other_channel, tally.largest_drift_ns), (2, 1, 2000));
    }

    #[test]
    fn the_counter_wraps_and_the_year_turns() {
        let mut relation = TimeRelation::new(Some(7));
        let start = RTC_MODULUS - 5_000_000;
        relation.reference(7, start, &day(365, 86_399));
        relation.reference(7, 5_000_000, &day(1, 0));
        relation.reference(7, 15_000_000, &day(1, 1));
        let tally = relation.tally();
        assert_eq!((tally.counter_wraps, tally.year_ends, tally.disagreements), (1, 1, 0));
        assert_eq!(relation.at(10_000_000).map(|time| time.ns), Some(365 * DAY_NS + NS / 2));
        assert_eq!(relation.at(start).map(|time| time.ns), Some(365 * DAY_NS - NS));
    }

    #[test]
    fn a_clock_that_was_set_and_a_recorder_that_started_again_are_told() {
        let mut relation = TimeRelation::new(None);
        relation.reference(1, 100_000_000, &day(5, 0));
        relation.reference(1, 110_000_000, &day(5, 31));
        let told = TimeDisagreement { rtc: 110_000_000, expected_ns: 4 * DAY_NS + NS, found_ns: 4 * DAY_NS + 31 * NS };
        assert_eq!((relation.tally().disagreements, relation.tally().first_disagreement), (1, Some(told)));
        assert_eq!(relation.at(105_000_000).map(|time| time.ns), Some(4 * DAY_NS + NS / 2));
        assert_eq!(relation.at(110_000_000).map(|time| time.ns), Some(4 * DAY_NS + 31 * NS));
        relation.reference(1, 50, &day(5, 100));
        assert_eq!(relation.tally().counter_restarts, 1);
        assert_eq!(relation.at(10_000_050).map(|time| time.ns), Some(4 * DAY_NS + 101 * NS));
        relation.reference(1, 50, &day(5, 100));
        relation.reference(1, 60, &CalendarTime { year: Some(2020), ..day(5, 100) });
        assert_eq!((relation.tally().repeated, relation.tally().other_scale), (1, 1));
    }

    #[test]
    fn memory_is_bounded() {
        let mut relation = TimeRelation::new(None);
        for second in 0..REFERENCES as i64 + 100 {
            let (days, rest) = (second / 86_400, second % 86_400);
            relation.reference(1, second as u64 * 10_000_000, &day(1 + days as u16, rest));
        }
        assert_eq!((relation.references.len(), relation.tally().disagreements), (REFERENCES, 0));
        assert_eq!(relation.at(0).map(|time| time.ns), Some(0));
    }
}
