//! Rate of a live boot clock against the host's: one that runs much faster belongs to a simulation, or is wrong.
//!
//! Consumes boot times with the host time of their arrival, us; produces their ratio where it is above [`FAST`] over
//! [`WINDOWS`] windows of [`WINDOW_US`] in a row: what had waited in a buffer and comes at once makes one such window, not two. A
//! clock that runs slower is found by [`host_time`](super::host_time).

/// Crystals differ by 2 10^-4; an arrival that is late by half a second makes this ratio over one window.
pub const FAST: f64 = 1.05;
/// Host time of one window, us.
pub const WINDOW_US: i64 = 10_000_000;
/// Windows in a row that show it.
pub const WINDOWS: u32 = 2;

/// The rate of one clock.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ClockRate {
    /// Host time and boot time at the window's start, us.
    since: Option<(i64, i64)>,
    newest_us: i64,
    fast: u32,
    rate: f64,
}

impl ClockRate {
    /// Takes in a message of that boot time which arrived at that host time, us.
    pub fn observe(&mut self, boot_us: i64, host_us: i64) {
        let Some((since_us, from_us)) = self.since else {
            (self.since, self.newest_us) = (Some((host_us, boot_us)), boot_us);
            return;
        };
        self.newest_us = self.newest_us.max(boot_us);
        let elapsed_us = host_us - since_us;
        if elapsed_us < WINDOW_US {
            return;
        }
        #[expect(clippy::cast_precision_loss, reason = "below 2^55 us")]
        let rate = (self.newest_us - from_us) as f64 / elapsed_us as f64;
        self.fast = if rate > FAST { self.fast.saturating_add(1) } else { 0 };
        self.rate = rate;
        self.since = Some((host_us, self.newest_us));
    }

    /// How many times as fast as the host's it runs, where it is too fast.
    pub fn too_fast(&self) -> Option<f64> {
        (self.fast >= WINDOWS).then_some(self.rate)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn heard(rate: &mut ClockRate, from_us: i64, to_us: i64, boot: impl Fn(i64) -> i64) {
        (from_us..to_us).step_by(20_000).for_each(|host_us| rate.observe(boot(host_us), host_us));
    }

    #[test]
    fn a_clock_twice_as_fast_is_seen_after_two_windows_and_a_backlog_is_none() {
        let mut rate = ClockRate::default();
        heard(&mut rate, 0, 2 * WINDOW_US - 20_000, |host_us| 100 + 2 * host_us);
        assert_eq!(rate.too_fast(), None);
        heard(&mut rate, 2 * WINDOW_US - 20_000, 2 * WINDOW_US + 60_000, |host_us| 100 + 2 * host_us);
        assert!(rate.too_fast().is_some_and(|rate| (rate - 2.0).abs() < 0.01), "{rate:?}");
        let mut rate = ClockRate::default();
        // Three seconds had waited, and come within one.
        heard(&mut rate, 0, 60_000_000, |host_us| host_us + 3_000_000.min(4 * host_us));
        assert_eq!(rate.too_fast(), None);
    }
}
