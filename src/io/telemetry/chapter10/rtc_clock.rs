//! Seconds from the relative time counter.
//!
//! Consumes counts (48 bits, 10 MHz) in the order of their packets; produces seconds since a zero,
//!     t = (n - n_0) 100 ns                                                                                (1)
//! | n | count, unwrapped | | n_0 | count of the zero |
//!
//! A packet whose count is below the last one's by more than [`BACK_S`] means that the recorder started again. In a recording its
//! times are then below those before, as the counter says; live the time goes on where [`RtcClock::expect`] says what it is,
//! as it does where a count is further than [`APART_S`] from that.
//! Source: IRIG 106-09 Chapter 10, 10.6.1.1 i.

use super::header::{RTC_MODULUS, TICKS_PER_SECOND};
use crate::io::telemetry::counter;

/// Packets may be out of order by so much, s: those of several channels overlap.
const BACK_S: f64 = 1.0;
/// A count so far from what the receiver's clock expects is that of a recorder that started again, s.
const APART_S: f64 = 5.0;

/// The counter's time.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct RtcClock {
    /// Count of the zero, and of the last packet.
    counts: Option<(i64, i64)>,
    expected_s: Option<f64>,
    restarts: u64,
}

impl RtcClock {
    /// The first count, which has that time, s; later calls mean nothing.
    pub(super) fn begin(&mut self, rtc: u64, time_s: f64) {
        let count = wrapped(rtc);
        self.counts.get_or_insert((count.saturating_sub(ticks(time_s)), count));
    }

    /// Goes on with a time whose zero has that count.
    pub(super) fn resume(&mut self, zero: i64) {
        self.counts = Some((zero, zero));
    }

    /// The count of the zero; `None` before the first packet.
    pub(super) fn zero(&self) -> Option<i64> {
        self.counts.map(|(zero, _)| zero)
    }

    /// The time that a packet of now should have, s.
    pub(super) fn expect(&mut self, time_s: f64) {
        self.expected_s = Some(time_s);
    }

    /// The unwrapped count of a packet, and whether the recorder started again before it.
    pub(super) fn packet(&mut self, rtc: u64) -> (i64, bool) {
        self.begin(rtc, self.expected_s.unwrap_or(0.0));
        let Some((zero, last)) = self.counts else { return (0, false) };
        let count = self.near(rtc, last);
        let apart = |expected_s: f64| (seconds(count.saturating_sub(zero)) - expected_s).abs() > APART_S;
        let restarted = seconds(last.saturating_sub(count)) > BACK_S || self.expected_s.is_some_and(apart);
        let zero = match self.expected_s {
            Some(expected_s) if restarted => count.saturating_sub(ticks(expected_s)),
            _ => zero,
        };
        self.restarts += u64::from(restarted);
        self.counts = Some((zero, count));
        (count, restarted)
    }

    /// The count nearest to a known one that has these bits.
    #[expect(clippy::unused_self, reason = "counts are this clock's")]
    pub(super) fn near(&self, rtc: u64, count: i64) -> i64 {
        counter::nearest(count, wrapped(rtc), RTC_MODULUS as i64)
    }

    /// The time of a count, s (1).
    pub(super) fn time_s(&self, count: i64) -> f64 {
        seconds(count.saturating_sub(self.counts.map_or(count, |(zero, _)| zero)))
    }

    /// How often the recorder started again.
    pub(super) fn restarts(&self) -> u64 {
        self.restarts
    }
}

fn seconds(ticks: i64) -> f64 {
    ticks as f64 / TICKS_PER_SECOND as f64
}

fn ticks(time_s: f64) -> i64 {
    #[expect(clippy::cast_possible_truncation, reason = "a cast of a float saturates")]
    let ticks = libm::round(time_s * TICKS_PER_SECOND as f64) as i64;
    ticks
}

fn wrapped(rtc: u64) -> i64 {
    (rtc % RTC_MODULUS) as i64
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn seconds_go_on_through_the_wrap_and_start_again_with_the_recorder() {
        let mut clock = RtcClock::default();
        clock.begin(RTC_MODULUS - 5_000_000, 0.0);
        let time_s = |clock: &mut RtcClock, rtc| {
            let (count, restarted) = clock.packet(rtc);
            (clock.time_s(count), restarted)
        };
        assert_eq!(time_s(&mut clock, RTC_MODULUS - 5_000_000), (0.0, false));
        assert_eq!(time_s(&mut clock, 5_000_000), (1.0, false));
        assert_eq!(time_s(&mut clock, 4_000_000), (0.9, false));
        assert_eq!(time_s(&mut clock, RTC_MODULUS - 30_000_000), (-2.5, true));
        assert_eq!(clock.restarts(), 1);
    }

    #[test]
    fn a_time_is_taken_up_by_the_count_of_its_zero_unless_the_recorder_started_again() {
        let mut clock = RtcClock::default();
        clock.resume(1_000_000);
        clock.expect(99.0);
        let (count, restarted) = clock.packet(1_001_000_000);
        assert_eq!((clock.time_s(count), restarted, clock.zero()), (100.0, false, Some(1_000_000)));
        clock.resume(1_000_000);
        clock.expect(50.0);
        let (count, restarted) = clock.packet(1_001_000_000);
        assert_eq!((clock.time_s(count), restarted), (50.0, true));
    }

    #[test]
    fn live_the_time_goes_on_behind_a_restart() {
        let mut clock = RtcClock::default();
        clock.begin(7_000_000_000, 3.0);
        for (rtc, expected_s, found_s, restarted) in [
            (7_000_000_000, 3.0, 3.0, false),
            (7_010_000_000, 4.1, 4.0, false),
            (55, 9.0, 9.0, true),
            (10_000_055, 9.9, 10.0, false),
        ] {
            clock.expect(expected_s);
            let (count, again) = clock.packet(rtc);
            assert_eq!((clock.time_s(count), again), (found_s, restarted));
        }
        clock.expect(11.0);
        let (count, again) = clock.packet(900_000_000_000);
        assert_eq!((clock.time_s(count), again), (11.0, true));
    }
}
