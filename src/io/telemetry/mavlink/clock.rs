//! Time of one sender: its boot time, unwrapped to one axis, with one segment for each boot.
//!
//! Consumes time stamps in the order of their arrival and, live, host times; produces microseconds on one axis that runs back by
//! no more than the delay of a message.
//! - 32-bit milliseconds and microseconds are unwrapped to the value nearest to the newest time.
//! - 64-bit microseconds from 10^15 (the year 2001) on are time since 1970. Their offset to the boot time is determined once, and
//!   again when they jump.
//! - A time more than [`LATE_US`] before the newest or more than [`AHEAD_US`] after it is not used until [`CONFIRMED`]
//!   consecutive times agree with each other. Then the sender has rebooted (a new segment, placed after the last by host time, at
//!   least [`BETWEEN_BOOTS_US`] later), or was not received for that long.
//! - Live, a clock that is set back by less than that goes on behind its newest time, in the same boot
//!   ([`BootClock::steps_back`]).
//!
//! Live, [`clock_monitor`](super::clock_monitor) supplies the host time: it decides what is a reboot ([`reboot`](super::reboot))
//! and when a message was sent ([`host_time`](super::host_time)). Messages without boot time are held while the clock is
//! uncertain.

use super::clock_monitor::{ClockMonitor, SavedClock};
use super::message::Stamp;
use super::reboot::{AHEAD_US, CONFIRMED, LATE_US};
use crate::io::telemetry::counter;

/// Least time between the segments of two boots, us: longer than what the estimation takes for a gap.
pub const BETWEEN_BOOTS_US: i64 = 2_000_000;
/// From here on microseconds are since 1970.
const UNIX_US: u64 = 1_000_000_000_000_000;
/// Stamps that wait for a boot clock at the start; then any clock will do.
const PATIENCE: u32 = 20;
/// No boot lasts so long (a thousand years), us.
const LONGEST_US: i64 = 1 << 55;

/// Where a message stands in time.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TimePlacement {
    /// On the axis.
    At {
        /// Time, us: of the first boot its boot time, of later ones set behind it.
        time_us: i64,
        /// Which boot, from 0.
        boot: u32,
    },
    /// Its time contradicts the newest; it is not used.
    InDoubt,
    /// No clock is known yet.
    NoClock,
    /// Live: a new boot has begun with the messages in doubt. Nothing is placed: place them again, and then this one.
    Restarted,
}

/// One sender's clock.
#[derive(Clone, Debug, Default)]
pub struct BootClock {
    boot: u32,
    /// Newest boot time, us.
    newest_us: Option<i64>,
    /// Newest of the stamps in doubt, and how many there are in a row.
    doubt: Option<(i64, u32)>,
    /// From boot time to the axis, us.
    segment_us: i64,
    /// From boot time to time since 1970 as the sender says it, us.
    unix_us: Option<i64>,
    /// From boot time to host time, the least found in this boot (the message that travelled fastest), us.
    host_us: Option<i64>,
    first_host_us: Option<i64>,
    waited: u32,
    in_doubt: u64,
    retied: u64,
    /// How often it was set back, by how much the last time and at what time before it, us.
    back: (u32, i64, i64),
    witness: Option<Box<ClockMonitor>>,
}

impl BootClock {
    /// A clock that is judged by host time, where a message has it; boots count from that number.
    pub fn live(boot: u32) -> Self {
        BootClock { boot, witness: Some(Box::default()), ..BootClock::default() }
    }

    /// A live clock as another process left it.
    pub fn resumed(from: &SavedClock) -> Self {
        BootClock {
            boot: from.boot,
            newest_us: Some(from.newest_us),
            segment_us: from.segment_us,
            host_us: Some(from.offset_us),
            first_host_us: Some(from.first_offset_us),
            witness: Some(Box::new(ClockMonitor::resumed(from))),
            ..BootClock::default()
        }
    }

    /// What the next process needs; `None` before the first message, or not live.
    pub fn remembered(&self) -> Option<SavedClock> {
        let witness = self.witness()?;
        Some(SavedClock {
            boot: self.boot,
            segment_us: self.segment_us,
            newest_us: self.newest_us?,
            heard_us: witness.heard_us()?,
            offset_us: witness.offset().least_us()?,
            first_offset_us: self.first_host_us?,
        })
    }

    /// Live, what host time says.
    pub fn witness(&self) -> Option<&ClockMonitor> {
        self.witness.as_deref()
    }

    /// Live, the host time at which that time on the axis was sent, us, of a message that arrived then.
    pub fn sent_us(&self, time_us: i64, host_us: Option<u64>) -> Option<i64> {
        let arrived_us = host_us.and_then(|host| i64::try_from(host).ok())?;
        Some(self.witness()?.offset().host_of(time_us - self.segment_us, arrived_us))
    }

    /// The boot that it is in, or begins with.
    pub fn boot(&self) -> u32 {
        self.boot
    }

    /// How many boots were seen.
    pub fn boots(&self) -> u32 {
        if self.newest_us.is_some() { self.boot + 1 } else { 0 }
    }

    /// How many messages were not used because their time was in doubt.
    pub fn in_doubt(&self) -> u64 {
        self.in_doubt
    }

    /// How often time since 1970 jumped against the boot clock.
    pub fn retied(&self) -> u64 {
        self.retied
    }

    /// Live, how often it was set back, by how much the last time, and what time it had reached before, us.
    pub fn steps_back(&self) -> (u32, i64, i64) {
        self.back
    }

    /// Newest boot time, us.
    pub fn newest_boot_us(&self) -> Option<i64> {
        self.newest_us
    }

    /// Newest time on the axis, us.
    pub fn newest_us(&self) -> Option<i64> {
        self.newest_us.map(|newest| newest + self.segment_us)
    }

    /// Places one message that arrived at that host time.
    pub fn place(&mut self, stamp: Stamp, host_us: Option<u64>) -> TimePlacement {
        if let Some(witness) = self.witness.as_deref_mut() {
            if has_boot_time(stamp) {
                witness.note_boot_time();
            } else if witness.is_in_doubt() {
                return TimePlacement::InDoubt;
            }
        }
        let Some(boot_us) = self.boot_time(stamp) else {
            return match (stamp, self.newest_us) {
                // What has no time of its own belongs to the newest.
                (Stamp::None, Some(newest)) => self.at(newest),
                _ => TimePlacement::NoClock,
            };
        };
        if boot_us > LONGEST_US {
            self.in_doubt += 1;
            return TimePlacement::InDoubt;
        }
        let host_us = host_us.and_then(|host| i64::try_from(host).ok()).filter(|host| *host < LONGEST_US);
        if let Some(host_us) = host_us.filter(|_| self.witness.is_some()) {
            let alone = has_boot_time(stamp) || self.witness().is_some_and(|witness| !witness.has_boot_time());
            let step_us = self.newest_us.map_or(0, |newest| boot_us - newest);
            if !alone && !self.witness().is_some_and(|witness| witness.agrees(step_us, host_us)) {
                self.in_doubt += 1;
                return TimePlacement::InDoubt;
            }
            return self.place_live(boot_us, host_us);
        }
        let Some(newest) = self.newest_us else {
            self.newest_us = Some(boot_us);
            self.observe(boot_us, host_us);
            self.first_host_us = self.host_us;
            return self.at(boot_us);
        };
        let step = boot_us - newest;
        if (-LATE_US..=AHEAD_US).contains(&step) {
            self.doubt = None;
            self.newest_us = Some(newest.max(boot_us));
            self.observe(boot_us, host_us);
            return self.at(boot_us);
        }
        let count = match self.doubt {
            Some((before, count)) if (-LATE_US..=AHEAD_US).contains(&(boot_us - before)) => count + 1,
            _ => 1,
        };
        if count < CONFIRMED {
            self.doubt = Some((boot_us, count));
            self.in_doubt += 1;
            return TimePlacement::InDoubt;
        }
        self.doubt = None;
        if step < 0 && !self.begin_boot(newest, boot_us, host_us) {
            self.in_doubt += 1;
            return TimePlacement::InDoubt;
        }
        self.newest_us = Some(boot_us);
        self.observe(boot_us, host_us);
        self.at(boot_us)
    }

    fn place_live(&mut self, boot_us: i64, host_us: i64) -> TimePlacement {
        let newest = self.newest_us;
        let Some(witness) = self.witness.as_deref_mut() else { return TimePlacement::NoClock };
        let series = match (witness.take(boot_us, newest, host_us), newest) {
            (Ok(()), _) => {
                let set_back = witness.take_step_back(host_us).zip(newest);
                self.newest_us = newest.max(Some(boot_us));
                if let Some((still_us, newest)) = set_back {
                    self.set_back(newest, boot_us, still_us);
                }
                self.observe(boot_us, Some(host_us));
                self.first_host_us = self.first_host_us.or(self.host_us);
                return self.at(boot_us);
            }
            (Err(Some(series)), Some(newest)) if self.begin_boot(newest, series.first_boot_us, Some(series.first_host_us)) => {
                series
            }
            (Err(_), _) => {
                self.in_doubt += 1;
                return TimePlacement::InDoubt;
            }
        };
        self.in_doubt = self.in_doubt.saturating_sub(u64::from(series.count - 1));
        self.newest_us = Some(series.first_boot_us);
        TimePlacement::Restarted
    }

    /// Goes on at a lower boot time, on the axis so long after its newest time as that was ago by the host's clock.
    fn set_back(&mut self, newest_us: i64, boot_us: i64, still_us: i64) {
        let shift_us = newest_us - boot_us + still_us;
        self.segment_us += shift_us;
        self.newest_us = Some(boot_us);
        (self.unix_us, self.host_us) = (None, None);
        self.back = (self.back.0.saturating_add(1), shift_us, newest_us);
    }

    fn at(&self, boot_us: i64) -> TimePlacement {
        TimePlacement::At { time_us: boot_us + self.segment_us, boot: self.boot }
    }

    fn observe(&mut self, boot_us: i64, host_us: Option<i64>) {
        if let Some(offset) = host_us.map(|host| host - boot_us) {
            self.host_us = Some(self.host_us.map_or(offset, |least| least.min(offset)));
        }
    }

    /// Sets the segment of a new boot; `false` where it would lie beyond all time.
    fn begin_boot(&mut self, newest: i64, boot_us: i64, host_us: Option<i64>) -> bool {
        let behind_last = newest + self.segment_us + BETWEEN_BOOTS_US - boot_us;
        let by_host = host_us.zip(self.first_host_us).map(|(host, first)| host - boot_us - first);
        let segment_us = by_host.map_or(behind_last, |by_host| by_host.max(behind_last));
        if segment_us > LONGEST_US {
            return false;
        }
        self.segment_us = segment_us;
        self.boot = self.boot.saturating_add(1);
        self.unix_us = None;
        self.host_us = None;
        true
    }

    /// The boot time that a stamp means, us; `None` where it has none, or none is known yet.
    fn boot_time(&mut self, stamp: Stamp) -> Option<i64> {
        let newest = self.newest_us;
        match stamp {
            Stamp::None => None,
            Stamp::BootMs(ms) => Some(match newest {
                Some(newest) => nearest(newest.div_euclid(1000), ms).saturating_mul(1000),
                None => i64::from(ms) * 1000,
            }),
            Stamp::WrappingUs(us) => match newest {
                Some(newest) => Some(nearest(newest, us)),
                None => self.out_of_patience().then_some(i64::from(us)),
            },
            Stamp::Us(us) if us < UNIX_US => i64::try_from(us).ok(),
            Stamp::Us(us) => {
                let us = i64::try_from(us).ok().filter(|us| *us < LONGEST_US)?;
                let newest = match newest {
                    Some(newest) => newest,
                    None if self.out_of_patience() => 0,
                    None => return None,
                };
                match self.unix_us.map(|tied| us - tied) {
                    Some(boot_us) if (-LATE_US..=AHEAD_US).contains(&(boot_us - newest)) => Some(boot_us),
                    tied => {
                        self.retied += u64::from(tied.is_some());
                        self.unix_us = Some(us - newest);
                        Some(newest)
                    }
                }
            }
        }
    }

    fn out_of_patience(&mut self) -> bool {
        self.waited += 1;
        self.waited > PATIENCE
    }
}

/// Whether a stamp counts from the boot, and says alone where in it; microseconds that wrap after an hour do not.
pub(super) fn has_boot_time(stamp: Stamp) -> bool {
    matches!(stamp, Stamp::BootMs(_) | Stamp::Us(..UNIX_US))
}

/// The number nearest to `near` whose low 32 bits are these.
fn nearest(near: i64, low: u32) -> i64 {
    counter::nearest(near, i64::from(low), 1 << 32)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(clock: &mut BootClock, stamp: Stamp) -> i64 {
        match clock.place(stamp, None) {
            TimePlacement::At { time_us, .. } => time_us,
            other => panic!("{stamp:?}: {other:?}"),
        }
    }

    #[test]
    fn milliseconds_and_microseconds_go_on_after_2_to_the_32() {
        let mut clock = BootClock::default();
        let last = i64::from(u32::MAX);
        assert_eq!(at(&mut clock, Stamp::BootMs(u32::MAX - 9)), (last - 9) * 1000);
        assert_eq!(at(&mut clock, Stamp::BootMs(10)), (last + 11) * 1000);
        // A late one from before the turn.
        assert_eq!(at(&mut clock, Stamp::BootMs(u32::MAX)), last * 1000);
        let newest = (last + 11) * 1000;
        let low = u32::try_from((newest + 500) % (1 << 32)).unwrap();
        assert_eq!(at(&mut clock, Stamp::WrappingUs(low)), newest + 500);
        assert_eq!(clock.boots(), 1);
    }

    #[test]
    fn a_reboot_is_a_new_segment_behind_the_old_one_and_a_stray_time_is_not() {
        let mut clock = BootClock::default();
        for ms in [600_000, 600_100] {
            at(&mut clock, Stamp::BootMs(ms));
        }
        assert_eq!(clock.place(Stamp::BootMs(5), None), TimePlacement::InDoubt);
        assert_eq!(at(&mut clock, Stamp::BootMs(600_200)), 600_200_000, "one stray");
        assert_eq!(clock.place(Stamp::BootMs(3_000), None), TimePlacement::InDoubt);
        assert_eq!(clock.place(Stamp::BootMs(3_100), None), TimePlacement::InDoubt);
        let TimePlacement::At { time_us, boot } = clock.place(Stamp::BootMs(3_200), None) else { panic!() };
        assert_eq!((time_us, boot), (602_200_000, 1));
        assert_eq!(at(&mut clock, Stamp::BootMs(3_300)), 602_300_000);
        assert_eq!((clock.boots(), clock.in_doubt()), (2, 3));
    }

    #[test]
    fn by_host_time_a_second_boot_stands_where_it_was() {
        let mut clock = BootClock::default();
        let host = |s: u64| Some((1_600_000_000 + s) * 1_000_000);
        clock.place(Stamp::BootMs(600_000), host(0));
        for s in 0..3 {
            clock.place(Stamp::BootMs(1_000 + 1_000 * s), host(30 + u64::from(s)));
        }
        // 32 s after a first boot time of 600 s.
        assert_eq!(clock.newest_us(), Some(632_000_000));
    }

    #[test]
    fn time_since_1970_is_tied_to_the_boot_clock_once_and_anew_when_it_jumps() {
        let mut clock = BootClock::default();
        let unix = 1_700_000_000_000_000_u64;
        assert_eq!(clock.place(Stamp::Us(unix), None), TimePlacement::NoClock);
        at(&mut clock, Stamp::BootMs(50_000));
        assert_eq!(at(&mut clock, Stamp::Us(unix)), 50_000_000);
        assert_eq!(at(&mut clock, Stamp::Us(unix + 20_000)), 50_020_000);
        assert_eq!(at(&mut clock, Stamp::Us(unix + 3_600_000_000)), 50_020_000);
        assert_eq!((clock.retied(), clock.boots()), (1, 1));
        assert_eq!(at(&mut clock, Stamp::Us(50_040_000)), 50_040_000, "microseconds since boot");
        // With no boot clock at all it counts from its own beginning.
        let mut clock = BootClock::default();
        for i in 0..u64::from(PATIENCE) {
            assert_eq!(clock.place(Stamp::Us(unix + i), None), TimePlacement::NoClock);
        }
        assert_eq!(at(&mut clock, Stamp::Us(unix + 100)), 0);
        assert_eq!(at(&mut clock, Stamp::Us(unix + 10_100)), 10_000);
    }

    #[test]
    fn what_has_no_time_takes_the_newest() {
        let mut clock = BootClock::default();
        assert_eq!(clock.place(Stamp::None, None), TimePlacement::NoClock);
        at(&mut clock, Stamp::BootMs(70));
        at(&mut clock, Stamp::BootMs(60));
        assert_eq!(at(&mut clock, Stamp::None), 70_000);
    }
}
