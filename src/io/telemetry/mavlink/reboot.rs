//! Detection of a reboot by host time: a live boot clock that jumps has restarted, or belongs to another sender.
//!
//! Consumes steps of the boot clock with the host time of their arrival, us; produces a verdict. A time stamp is consistent if it
//! is no more than two seconds late and no further ahead than host time allows. Inconsistent stamps form a series. A series that
//! lasts [`RESTART_US`] of host time, with a running clock and no consistent stamp between, is a reboot; a clock that was running
//! before the old one became silent, which is no restart, needs [`CHANGE_US`]. A series that is repeatedly interrupted by the old
//! clock with the same difference is another sender with the same id.

/// A message may come so much later than the newest, us.
pub const LATE_US: i64 = 2_000_000;
/// A silence so long needs no confirmation, us.
pub const AHEAD_US: i64 = 60_000_000;
/// Stamps in a row that confirm a jump.
pub const CONFIRMED: u32 = 3;
/// A clock that has started afresh must run for so long while the old one is silent, us.
pub const RESTART_US: i64 = 500_000;
/// Any other must for so long, us.
pub const CHANGE_US: i64 = 5_000_000;
/// No simulation runs faster than so many times the host.
const FASTEST: i64 = 20;
/// A clock that runs slower than one in so many stands still.
const SLOWEST: i64 = 10;
/// Messages after which a clock is the vehicle's beyond doubt.
const SETTLED: u32 = 10;
/// Series of one other clock that show a second sender.
const RIVAL: u32 = 5;

/// Stamps in a row that contradict the clock and agree with each other.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct StampSeries {
    /// Boot time of the first, us.
    pub first_boot_us: i64,
    /// Its arrival, us.
    pub first_host_us: i64,
    newest_boot_us: i64,
    newest_host_us: i64,
    /// How many.
    pub count: u32,
}

/// Verdict on an inconsistent time stamp.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StampVerdict {
    /// It may be a stray.
    Doubt,
    /// The clock has started again, with this series.
    Restarted(StampSeries),
}

/// The judge of one clock.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct RebootDetector {
    heard_us: Option<i64>,
    agreed: u32,
    series: Option<StampSeries>,
    /// Host less boot time of the clock that broke in last, us, and how often it did.
    rival: Option<(i64, u32)>,
}

impl RebootDetector {
    /// A judge of a clock that was last heard at that host time, us, and is known.
    pub fn known(heard_us: i64) -> Self {
        RebootDetector { heard_us: Some(heard_us), agreed: SETTLED, ..RebootDetector::default() }
    }

    /// Host time when the clock was last heard, us.
    pub fn heard_us(&self) -> Option<i64> {
        self.heard_us
    }

    /// The series that is open.
    pub fn series(&self) -> Option<StampSeries> {
        self.series
    }

    /// Whether two senders use the same id with different clocks.
    pub fn sees_two(&self) -> bool {
        self.rival.is_some_and(|(_, count)| count >= RIVAL)
    }

    /// Whether a stamp that is so much newer than the newest agrees with the clock.
    pub fn agrees(&self, step_us: i64, host_us: i64) -> bool {
        let elapsed_us = self.heard_us.map_or(0, |heard| host_us - heard);
        within(step_us, elapsed_us)
    }

    /// Takes in a stamp that agrees; the series that it breaks was of strays or of another sender.
    pub fn observe(&mut self, host_us: i64) {
        self.heard_us = Some(self.heard_us.map_or(host_us, |heard| heard.max(host_us)));
        self.agreed = self.agreed.saturating_add(1);
        if let Some(series) = self.series.take() {
            let offset = series.newest_host_us - series.newest_boot_us;
            self.rival = match self.rival {
                Some((known, count)) if (known - offset).abs() <= LATE_US => Some((offset, count.saturating_add(1))),
                known @ Some((_, RIVAL..)) => known,
                _ => Some((offset, 1)),
            };
        }
    }

    /// Takes in a stamp that does not agree.
    pub fn contradict(&mut self, boot_us: i64, host_us: i64) -> StampVerdict {
        let series = match self.series {
            Some(series) if within(boot_us - series.newest_boot_us, host_us - series.newest_host_us) => StampSeries {
                newest_boot_us: series.newest_boot_us.max(boot_us),
                newest_host_us: series.newest_host_us.max(host_us),
                count: series.count.saturating_add(1),
                ..series
            },
            _ => StampSeries {
                first_boot_us: boot_us,
                first_host_us: host_us,
                newest_boot_us: boot_us,
                newest_host_us: host_us,
                count: 1,
            },
        };
        self.series = Some(series);
        let elapsed_us = series.newest_host_us - series.first_host_us;
        let advanced_us = series.newest_boot_us - series.first_boot_us;
        // A clock that begins at zero began after the old one was last heard.
        let began_us = series.first_host_us - series.first_boot_us;
        let afresh = self.agreed < SETTLED || self.heard_us.is_none_or(|heard| began_us >= heard - LATE_US);
        let needed_us = if afresh { RESTART_US } else { CHANGE_US };
        if series.count < CONFIRMED || elapsed_us < needed_us || advanced_us < elapsed_us / SLOWEST {
            return StampVerdict::Doubt;
        }
        *self = RebootDetector { heard_us: Some(series.first_host_us), rival: self.rival, ..RebootDetector::default() };
        StampVerdict::Restarted(series)
    }
}

/// Whether a step of the vehicle's clock is explained by so much host time.
fn within(step_us: i64, elapsed_us: i64) -> bool {
    let elapsed_us = elapsed_us.max(0);
    let at_any_rate = elapsed_us.saturating_mul(FASTEST).min(AHEAD_US);
    let furthest_us = at_any_rate.max(elapsed_us.saturating_add(elapsed_us / 100)).saturating_add(LATE_US);
    (-LATE_US..=furthest_us).contains(&step_us)
}

#[cfg(test)]
mod tests {
    use super::*;

    const HOST_US: i64 = 1_000_000_000;

    /// A clock that was heard at 50 Hz for ten seconds, up to boot time 110 s and [`HOST_US`].
    fn settled() -> RebootDetector {
        let mut judge = RebootDetector::default();
        (0..=500).for_each(|k| judge.observe(HOST_US - 10_000_000 + 20_000 * k));
        judge
    }

    /// Stamps at 50 Hz from that boot time on, the first 20 ms after the last of the old clock: how long until a verdict.
    fn restarts_after(judge: &mut RebootDetector, boot_us: i64, rate: i64) -> Option<i64> {
        (0..500).map(|k| 20_000 * k).find(|elapsed_us| {
            let verdict = judge.contradict(boot_us + elapsed_us * rate, HOST_US + 20_000 + elapsed_us);
            matches!(verdict, StampVerdict::Restarted(StampSeries { first_boot_us, .. }) if first_boot_us == boot_us)
        })
    }

    #[test]
    fn a_fresh_start_needs_half_a_second_any_other_clock_five_and_one_that_stands_never_comes() {
        assert_eq!(restarts_after(&mut settled(), 500_000, 1), Some(RESTART_US));
        assert_eq!(restarts_after(&mut settled(), 0, 10), Some(RESTART_US), "a simulation that runs fast");
        assert_eq!(restarts_after(&mut settled(), 50_000_000, 1), Some(CHANGE_US));
        assert_eq!(restarts_after(&mut settled(), 5_000_000_000, 1), Some(CHANGE_US));
        assert_eq!(restarts_after(&mut settled(), 0, 0), None);
        // One stray at the very start holds up nothing.
        let mut judge = RebootDetector::default();
        judge.observe(HOST_US);
        assert_eq!(restarts_after(&mut judge, 50_000_000, 1), Some(RESTART_US));
    }

    #[test]
    fn spoofed_stamps_all_at_once_end_nothing() {
        let mut judge = settled();
        for k in 0..1000 {
            assert_eq!(judge.contradict(k * 20_000, HOST_US + 1_000 + k), StampVerdict::Doubt);
        }
        judge.observe(HOST_US + 20_000);
        assert!(judge.series().is_none() && !judge.sees_two());
    }

    #[test]
    fn two_senders_in_turn_are_seen_and_never_taken_for_boots() {
        for burst in [1, 24] {
            let mut judge = settled();
            for k in 0..2000 {
                let host_us = HOST_US + 20_000 * k;
                if k / burst % 2 == 0 {
                    judge.observe(host_us);
                } else {
                    assert_eq!(judge.contradict(50_000_000 + 20_000 * k, host_us), StampVerdict::Doubt);
                }
            }
            assert!(judge.sees_two(), "{burst}");
        }
        // Strays of different times are no sender.
        let mut judge = settled();
        for k in 0..100 {
            judge.contradict(1_000_000_000 + 10_000_000 * k, HOST_US + 20_000 * k);
            judge.observe(HOST_US + 20_000 * k + 1);
        }
        assert!(!judge.sees_two());
    }

    #[test]
    fn a_silence_is_explained_by_host_time_and_a_leap_is_not() {
        let judge = settled();
        assert!(judge.agrees(3_600_000_000, HOST_US + 3_600_000_000));
        assert!(judge.agrees(5_000_000, HOST_US + 500_000), "ten times as fast");
        assert!(!judge.agrees(7_000_000, HOST_US + 20_000));
        assert!(!judge.agrees(-2_100_000, HOST_US + 20_000));
    }
}
