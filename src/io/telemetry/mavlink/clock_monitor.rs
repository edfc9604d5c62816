//! Supervision of a live boot clock by host time: reboots, time of sending, a clock that has stopped.
//!
//! Consumes unwrapped boot times ([`Clock`](super::clock)) with the host time of their arrival, us. Combines [`RebootDetector`],
//! [`HostOffset`] and [`ClockRate`]; all are reset at each boot. A clock whose times are all more than `BEHIND_US` behind the
//! newest, for `BACK_US` of host time and running, was set back: a late message comes among others that are not.

use super::clock_rate::ClockRate;
use super::host_time::HostOffset;
use super::reboot::{RebootDetector, StampSeries, StampVerdict};

/// A clock that does not go forward for so long, us of host time, stands still.
const STILL_US: i64 = 3_000_000;
/// If at least so many messages say so.
const STILL: u32 = 10;
/// Times so far behind the newest are late, or the clock was set back, us.
const BEHIND_US: i64 = 250_000;
/// It was set back where all are behind for so long, us of host time.
const BACK_US: i64 = 500_000;
/// If at least so many messages say so.
const BACK: u32 = 5;
/// A clock that has advanced by less than one in so many of host time does not run.
const RUNS: i64 = 10;

/// What of a live clock outlives a process: for the next one, on the same vehicle and host clock.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SavedClock {
    /// Which boot, from 0.
    pub boot: u32,
    /// From boot time to the axis, us.
    pub segment_us: i64,
    /// Newest boot time, us.
    pub newest_us: i64,
    /// Host time then, us.
    pub heard_us: i64,
    /// Least host time less boot time, us.
    pub offset_us: i64,
    /// The same of the first boot, us.
    pub first_offset_us: i64,
}

/// The witness of one clock.
#[derive(Clone, Debug, Default)]
pub struct ClockMonitor {
    judge: RebootDetector,
    offset: HostOffset,
    rate: ClockRate,
    /// Of the times in a row that are all behind: first host time, first and newest boot time, us, and how many.
    behind: Option<(i64, i64, i64, u32)>,
    /// Whether a message with boot time was heard.
    boot_stamped: bool,
    /// Host time when the clock last went forward, us, and messages since.
    forward: Option<(i64, u32)>,
    stands: bool,
}

impl ClockMonitor {
    /// A witness that goes on from what another process knew.
    pub fn resumed(from: &SavedClock) -> Self {
        ClockMonitor {
            judge: RebootDetector::known(from.heard_us),
            offset: HostOffset::known(from.offset_us, from.heard_us),
            boot_stamped: true,
            ..ClockMonitor::default()
        }
    }

    /// Host time when the clock was last heard, us.
    pub fn heard_us(&self) -> Option<i64> {
        self.judge.heard_us()
    }

    /// The host's side of the clock.
    pub fn offset(&self) -> &HostOffset {
        &self.offset
    }

    /// How many messages of a clock that may be a new boot's wait.
    pub fn waiting(&self) -> u32 {
        self.judge.series().map_or(0, |series| series.count)
    }

    /// How many times as fast as the host's it runs, where it is too fast.
    pub fn too_fast(&self) -> Option<f64> {
        self.rate.too_fast()
    }

    /// Where the clock was set back: for how long nothing has gone forward, us of host time. It is asked once.
    pub fn take_step_back(&mut self, host_us: i64) -> Option<i64> {
        let (since_us, from_us, newest_us, count) = self.behind?;
        let (elapsed_us, forward_us) = (host_us - since_us, self.forward?.0);
        if count < BACK || elapsed_us < BACK_US || newest_us - from_us < elapsed_us / RUNS {
            return None;
        }
        (self.behind, self.forward) = (None, None);
        (self.offset, self.rate) = (HostOffset::default(), ClockRate::default());
        Some(host_us - forward_us)
    }

    /// Whether two senders use the same id with different clocks.
    pub fn sees_two(&self) -> bool {
        self.judge.sees_two()
    }

    /// Whether the clock stands still.
    pub fn stands_still(&self) -> bool {
        self.stands
    }

    /// Whether what has no boot time waits until it is clear which clock it belongs to.
    pub fn is_in_doubt(&self) -> bool {
        self.boot_stamped && self.judge.series().is_some()
    }

    /// Whether a stamp that is so much newer than the newest agrees with the clock.
    pub fn agrees(&self, step_us: i64, host_us: i64) -> bool {
        self.judge.agrees(step_us, host_us)
    }

    /// Whether a message with boot time was heard.
    pub fn has_boot_time(&self) -> bool {
        self.boot_stamped
    }

    /// Notes that a message has boot time.
    pub fn note_boot_time(&mut self) {
        self.boot_stamped = true;
    }

    /// Takes in a message of that boot time; `Ok` where it agrees with the clock, otherwise the verdict.
    ///
    /// # Errors
    /// `Err(None)` where it may be a stray, `Err(Some(series))` where the clock has started again.
    pub fn take(&mut self, boot_us: i64, newest_us: Option<i64>, host_us: i64) -> Result<(), Option<StampSeries>> {
        if newest_us.is_none_or(|newest| self.judge.agrees(boot_us - newest, host_us)) {
            self.judge.observe(host_us);
            self.offset.observe(boot_us, host_us);
            self.rate.observe(boot_us, host_us);
            let (since_us, from_us, latest_us, count) = self.behind.unwrap_or((host_us, boot_us, boot_us, 0));
            self.behind = newest_us
                .filter(|newest| boot_us < newest - BEHIND_US)
                .map(|_| (since_us, from_us, latest_us.max(boot_us), count.saturating_add(1)));
            let went_on = newest_us.is_none_or(|newest| boot_us > newest);
            let (since_us, count) = self.forward.filter(|_| !went_on).unwrap_or((host_us, 0));
            self.forward = Some((since_us, count.saturating_add(1)));
            self.stands = count >= STILL && host_us - since_us >= STILL_US;
            return Ok(());
        }
        match self.judge.contradict(boot_us, host_us) {
            StampVerdict::Doubt => Err(None),
            StampVerdict::Restarted(series) => {
                *self = ClockMonitor { judge: self.judge, boot_stamped: true, ..ClockMonitor::default() };
                Err(Some(series))
            }
        }
    }
}
