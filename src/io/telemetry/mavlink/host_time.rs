//! Offset between host time and a vehicle's boot time, live: the least difference, for the time at which a sample was measured.
//!
//! Consumes pairs of boot time and host time of arrival, us; produces the host time of a boot time, with the delay of the fastest
//! message as reference, so that time spent in a receive buffer counts as age. With d = host - boot of each message,
//!     offset <- min(offset + elapsed/10^4, d)                                                                 (1)
//! The offset rises slowly, so that clocks of different rate (crystals: 2 10^-4 at most) do not let the age grow without bound. A
//! lower difference is accepted after `CONFIRMED` consecutive messages, so that one wrong stamp has no effect. A delay that lasts
//! [`WINDOW_US`] is attributed to the boot clock (a paused simulation) and accepted; if it occurs twice in succession the boot
//! clock is slower than the host's, and ages are counted from arrival.

/// Messages in a row that confirm a lower difference.
const CONFIRMED: u32 = 3;
/// Differences so near to the least need no confirmation, us.
const NEAR_US: i64 = 50_000;
/// A delay that lasts so long is none, us.
pub const WINDOW_US: i64 = 30_000_000;
/// Delays below this are jitter, us.
const DELAY_US: i64 = 100_000;
/// The offset creeps up by one in so many.
const CREEP: i64 = 10_000;
/// Messages that a window must hold to count.
const ENOUGH: u32 = 10;

/// The least difference of host time and boot time.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct HostOffset {
    /// The offset, and the host time of its last change.
    least: Option<(i64, i64)>,
    /// The largest of the lower differences in a row, and how many there are.
    lower: Option<(i64, u32)>,
    /// Since when, its least difference, how many messages.
    window: Option<(i64, i64, u32)>,
    /// How many windows in a row the offset was too low.
    delayed: u32,
}

impl HostOffset {
    /// An offset that was known at a host time, us.
    pub fn known(offset_us: i64, host_us: i64) -> Self {
        HostOffset { least: Some((offset_us, host_us)), ..HostOffset::default() }
    }

    /// The offset, us; `None` before the first message.
    pub fn least_us(&self) -> Option<i64> {
        self.least.map(|(least, _)| least)
    }

    /// Whether the vehicle's clock runs slower than the host's, so that ages count from arrival.
    pub fn is_by_arrival(&self) -> bool {
        self.delayed >= 2
    }

    /// Takes in a message of that boot time which arrived at that host time, us.
    pub fn observe(&mut self, boot_us: i64, host_us: i64) {
        let found = host_us - boot_us;
        let Some((least, since)) = self.least else {
            self.least = Some((found, host_us));
            self.window = Some((host_us, found, 1));
            return;
        };
        let crept = least + (host_us - since).max(0) / CREEP;
        if found < crept - NEAR_US {
            let (most, count) = self.lower.map_or((found, 1), |(most, count)| (most.max(found), count + 1));
            self.lower = Some((most, count));
            if count >= CONFIRMED {
                self.lower = None;
                self.least = Some((most, host_us));
            }
        } else {
            self.lower = None;
            // What has crept by less than a microsecond goes on creeping.
            if found < crept || crept > least {
                self.least = Some((crept.min(found), host_us));
            }
        }
        self.judge_window(found, host_us);
    }

    /// Host time of a boot time, us: never after its arrival.
    pub fn host_of(&self, boot_us: i64, arrived_us: i64) -> i64 {
        match self.least {
            Some((least, _)) if !self.is_by_arrival() => arrived_us.min(least.saturating_add(boot_us)),
            _ => arrived_us,
        }
    }

    fn judge_window(&mut self, found: i64, host_us: i64) {
        let (since, least, count) = self.window.unwrap_or((host_us, found, 0));
        if host_us - since < WINDOW_US {
            self.window = Some((since, least.min(found), count.saturating_add(1)));
            return;
        }
        self.window = Some((host_us, found, 1));
        if count < ENOUGH || self.is_by_arrival() {
            return;
        }
        self.delayed = match self.least {
            Some((offset, _)) if least > offset + DELAY_US => {
                self.least = Some((least, host_us));
                self.delayed + 1
            }
            _ => 0,
        };
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const BEGAN_US: i64 = 7_000_000;

    /// Messages at 50 Hz that take `delay(t)` us, from boot time `from` to `to`, s.
    fn heard(offset: &mut HostOffset, from: i64, to: i64, delay: impl Fn(i64) -> i64) {
        for boot_us in (from * 1_000_000..to * 1_000_000).step_by(20_000) {
            offset.observe(boot_us, BEGAN_US + boot_us + delay(boot_us));
        }
    }

    #[test]
    fn what_waited_is_as_old_as_it_is() {
        let mut offset = HostOffset::default();
        heard(&mut offset, 0, 10, |boot_us| 2_000 + boot_us / 20_000 % 7 * 1_000);
        assert!((offset.least_us().unwrap() - BEGAN_US - 2_000).abs() < 100, "{offset:?}");
        // Five seconds all at once.
        let arrived_us = BEGAN_US + 15_000_000;
        for boot_us in (10_000_000..15_000_000).step_by(20_000) {
            offset.observe(boot_us, arrived_us);
            let age_us = arrived_us - offset.host_of(boot_us, arrived_us);
            assert!((age_us - (15_000_000 - boot_us - 2_000)).abs() < 1_000 || boot_us > 14_990_000, "{boot_us}: {age_us}");
        }
        assert_eq!(offset.host_of(15_500_000, arrived_us), arrived_us, "never after its arrival");
    }

    #[test]
    fn clocks_that_drift_do_not_make_ages_grow() {
        let mut offset = HostOffset::default();
        // 80 microseconds a second slow for an hour.
        heard(&mut offset, 0, 3600, |boot_us| boot_us / 12_500);
        let arrived_us = BEGAN_US + 3_600_000_000 + 288_000;
        assert!(arrived_us - offset.host_of(3_600_000_000, arrived_us) < 1_000, "{offset:?}");
    }

    #[test]
    fn one_wrong_stamp_is_not_believed_and_a_delay_without_end_is_none() {
        let mut offset = HostOffset::default();
        heard(&mut offset, 0, 10, |_| 0);
        offset.observe(11_900_000, BEGAN_US + 10_000_000);
        heard(&mut offset, 10, 11, |_| 0);
        assert!(offset.least_us().unwrap() - BEGAN_US < 1_000 && offset.least_us().unwrap() >= BEGAN_US);
        // A simulation that paused for 1.5 s.
        heard(&mut offset, 11, 30, |_| 1_500_000);
        assert!(offset.least_us().unwrap() < BEGAN_US + 10_000, "it may be a delay yet");
        heard(&mut offset, 30, 80, |_| 1_500_000);
        assert!(offset.least_us().unwrap() >= BEGAN_US + 1_500_000 && !offset.is_by_arrival());
        // One that runs at nine tenths of the host's rate.
        heard(&mut offset, 80, 240, |boot_us| 1_500_000 + (boot_us - 80_000_000) / 9);
        assert!(offset.is_by_arrival());
    }
}
