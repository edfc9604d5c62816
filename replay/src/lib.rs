//! Plays time-stamped things at real time, at a factor of it, or as fast as it goes.
//!
//! In: anything with a time of its own in seconds. Out: the moment at which each is due on a monotonic clock.
//! Each wait is counted from one anchor (a time of the recording and the clock's reading then), never from the wait
//! before, so errors do not add up:
//!
//! `due = anchor_clock + (time - anchor_time) / factor` (1)
//!
//! Assumed: times in seconds, mostly increasing. Where they are not, the player stays bounded: an item whose time went
//! back is due at once and becomes the new anchor; a gap longer than [`LONGEST_GAP_S`] lasts that long (before the
//! factor) and ends in a new anchor; an item whose time is not finite is due at once. A listener that falls behind
//! gets what is overdue without waits, in order, until it has caught up.

use std::fmt;
use std::str::FromStr;
use std::time::{Duration, Instant};

/// The longest silence of a recording that is played out, s of the recording's time; a longer one is cut to it.
pub const LONGEST_GAP_S: f64 = 10.0;

/// A wait is taken in slices of at most this, so that whoever plays can stop in between.
pub const WAIT_SLICE: Duration = Duration::from_millis(100);

/// How fast a recording is played.
#[derive(Clone, Copy, Debug, PartialEq, Default)]
pub enum Pace {
    /// As it was recorded.
    RealTime,
    /// That many times as fast as it was recorded; finite and above zero.
    Factor(f64),
    /// As fast as it goes.
    #[default]
    Max,
}

/// A text that is no pace.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct PaceError {
    found: String,
}

impl fmt::Display for PaceError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "expected a factor above zero, such as 1 (real time) or 4, or max; found `{}`", self.found)
    }
}

impl std::error::Error for PaceError {}

impl FromStr for Pace {
    type Err = PaceError;

    fn from_str(text: &str) -> Result<Self, PaceError> {
        let refused = || PaceError { found: text.chars().take(40).collect() };
        if text == "max" {
            return Ok(Pace::Max);
        }
        let factor: f64 = text.parse().map_err(|_| refused())?;
        if !(factor.is_finite() && factor > 0.0) {
            return Err(refused());
        }
        Ok(if factor.to_bits() == 1.0_f64.to_bits() { Pace::RealTime } else { Pace::Factor(factor) })
    }
}

impl fmt::Display for Pace {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Pace::RealTime => f.write_str("1"),
            Pace::Factor(factor) => write!(f, "{factor}"),
            Pace::Max => f.write_str("max"),
        }
    }
}

impl Pace {
    /// Seconds of the recording a second of the clock; `None` as fast as it goes, or for a factor that is none.
    fn factor(self) -> Option<f64> {
        match self {
            Pace::RealTime => Some(1.0),
            Pace::Factor(factor) if factor.is_finite() && factor > 0.0 => Some(factor),
            Pace::Factor(_) | Pace::Max => None,
        }
    }
}

/// A clock that never goes back, and a way to let its time pass.
pub trait Clock {
    /// Its reading, from an origin of its own.
    fn now(&self) -> Duration;
    /// Lets about that much time pass.
    fn wait(&mut self, time: Duration);
}

/// The machine's monotonic clock.
#[derive(Clone, Copy, Debug)]
pub struct MonotonicClock {
    origin: Instant,
}

impl MonotonicClock {
    /// A clock that reads zero now.
    pub fn new() -> Self {
        MonotonicClock { origin: Instant::now() }
    }
}

impl Default for MonotonicClock {
    fn default() -> Self {
        MonotonicClock::new()
    }
}

impl Clock for MonotonicClock {
    fn now(&self) -> Duration {
        self.origin.elapsed()
    }

    fn wait(&mut self, time: Duration) {
        std::thread::sleep(time);
    }
}

/// Where the recording's time and the clock's were tied together, and the last item since.
#[derive(Clone, Copy, Debug)]
struct Anchor {
    time_s: f64,
    clock: Duration,
    last_s: f64,
}

/// Knows for each item when it is due.
#[derive(Debug)]
pub struct Player<C> {
    pace: Pace,
    clock: C,
    anchor: Option<Anchor>,
}

impl Player<MonotonicClock> {
    /// A player on the machine's monotonic clock.
    pub fn new(pace: Pace) -> Self {
        Player::with_clock(pace, MonotonicClock::new())
    }
}

impl<C: Clock> Player<C> {
    /// A player on that clock.
    pub fn with_clock(pace: Pace, clock: C) -> Self {
        Player { pace, clock, anchor: None }
    }

    /// The clock.
    pub fn clock(&self) -> &C {
        &self.clock
    }

    /// When the next item, of that time in seconds, is due on the clock; never later than [`LONGEST_GAP_S`] of the
    /// recording's time after the item before it was due or asked for. Call it once an item, in their order.
    pub fn due(&mut self, time_s: f64) -> Duration {
        let now = self.clock.now();
        let Some(factor) = self.pace.factor() else { return now };
        if !time_s.is_finite() {
            return now;
        }
        let Some(anchor) = &mut self.anchor else {
            self.anchor = Some(Anchor { time_s, clock: now, last_s: time_s });
            return now;
        };
        let step_s = time_s - anchor.last_s;
        if step_s < 0.0 {
            *anchor = Anchor { time_s, clock: now, last_s: time_s };
            return now;
        }
        if step_s > LONGEST_GAP_S {
            let last_due = after(anchor.clock, (anchor.last_s - anchor.time_s) / factor);
            let due = after(last_due.max(now), LONGEST_GAP_S / factor);
            *anchor = Anchor { time_s, clock: due, last_s: time_s };
            return due;
        }
        anchor.last_s = time_s;
        after(anchor.clock, (time_s - anchor.time_s) / factor)
    }

    /// Waits until the next item, of that time in seconds, is due. Asks `go_on` before every slice of the wait, and
    /// returns false as soon as it says no.
    pub fn wait_for(&mut self, time_s: f64, mut go_on: impl FnMut() -> bool) -> bool {
        let due = self.due(time_s);
        loop {
            if !go_on() {
                return false;
            }
            let remaining = due.saturating_sub(self.clock.now());
            if remaining.is_zero() {
                return true;
            }
            self.clock.wait(remaining.min(WAIT_SLICE));
        }
    }

    /// Plays every item of a source: waits until it is due, then delivers it. Ends with the source, or as soon as
    /// `deliver` returns false. Returns how many items were delivered.
    pub fn play<T>(
        &mut self,
        source: impl IntoIterator<Item = T>,
        time_s: impl Fn(&T) -> f64,
        mut deliver: impl FnMut(T) -> bool,
    ) -> u64 {
        let mut delivered = 0;
        for item in source {
            self.wait_for(time_s(&item), || true);
            delivered += 1;
            if !deliver(item) {
                break;
            }
        }
        delivered
    }
}

/// That many seconds after a reading of the clock; where that is beyond what a clock can read, the reading itself.
fn after(clock: Duration, seconds: f64) -> Duration {
    Duration::try_from_secs_f64(seconds).ok().and_then(|wait| clock.checked_add(wait)).unwrap_or(clock)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A clock that stands still but for waits, each of which takes `late` too long.
    #[derive(Default)]
    struct Fake {
        now: Duration,
        late: Duration,
    }

    impl Clock for Fake {
        fn now(&self) -> Duration {
            self.now
        }

        fn wait(&mut self, time: Duration) {
            self.now += time + self.late;
        }
    }

    fn seconds(player: &Player<Fake>) -> f64 {
        player.clock().now().as_secs_f64()
    }

    #[test]
    fn a_pace_is_a_factor_or_max() {
        assert_eq!("1".parse(), Ok(Pace::RealTime));
        assert_eq!("4".parse(), Ok(Pace::Factor(4.0)));
        assert_eq!("0.5".parse(), Ok(Pace::Factor(0.5)));
        assert_eq!("max".parse(), Ok(Pace::Max));
        for wrong in ["0", "-1", "nan", "inf", "", "fast", "4x", "Max"] {
            let error = wrong.parse::<Pace>().unwrap_err();
            assert!(error.to_string().ends_with(&format!("found `{wrong}`")), "{error}");
        }
        for pace in [Pace::RealTime, Pace::Factor(0.25), Pace::Max] {
            assert_eq!(pace.to_string().parse(), Ok(pace));
        }
    }

    #[test]
    fn late_waits_do_not_add_up() {
        for (pace, factor) in [(Pace::RealTime, 1.0), (Pace::Factor(4.0), 4.0)] {
            let late = Duration::from_micros(300);
            let mut player = Player::with_clock(pace, Fake { now: Duration::ZERO, late });
            for k in 0..25_600_u32 {
                let time_s = 1000.0 + f64::from(k) / 256.0;
                assert!(player.wait_for(time_s, || true));
                let lateness = seconds(&player) - f64::from(k) / 256.0 / factor;
                assert!((-1e-9..=301e-6).contains(&lateness), "{k}: {lateness}");
            }
        }
    }

    #[test]
    fn a_listener_that_falls_behind_catches_up() {
        let mut player = Player::with_clock(Pace::RealTime, Fake::default());
        let count = player.play(0..100_u32, |k| f64::from(*k) / 10.0, |_| true);
        assert_eq!(count, 100);
        player.clock.now += Duration::from_secs(3);
        let before = player.clock.now;
        assert!(player.wait_for(10.0, || true));
        assert_eq!(player.clock.now, before);
        assert!(player.wait_for(14.0, || true));
        assert!((seconds(&player) - 14.0).abs() < 1e-9);
    }

    #[test]
    fn time_that_goes_back_is_played_at_once_and_from_there_on() {
        let mut player = Player::with_clock(Pace::RealTime, Fake::default());
        for time_s in [100.0, 101.0, 5.0] {
            player.wait_for(time_s, || true);
        }
        assert!((seconds(&player) - 1.0).abs() < 1e-9);
        player.wait_for(5.5, || true);
        assert!((seconds(&player) - 1.5).abs() < 1e-9);
    }

    #[test]
    fn a_gap_and_a_wild_time_are_bounded() {
        let mut player = Player::with_clock(Pace::Factor(2.0), Fake::default());
        for time_s in [0.0, 1.0, 1e300, 1e300] {
            player.wait_for(time_s, || true);
        }
        assert!((seconds(&player) - (0.5 + LONGEST_GAP_S / 2.0)).abs() < 1e-9);
        for time_s in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
            player.wait_for(time_s, || true);
        }
        assert!((seconds(&player) - 5.5).abs() < 1e-9);
        let mut crawling = Player::with_clock(Pace::Factor(f64::MIN_POSITIVE), Fake::default());
        crawling.due(0.0);
        assert_eq!(crawling.due(1.0), Duration::ZERO, "beyond what a clock can read: at once");
    }

    #[test]
    fn as_fast_as_it_goes_never_waits_and_a_wait_can_be_left() {
        let mut player = Player::with_clock(Pace::Max, Fake::default());
        assert_eq!(player.play([0.0, 5.0, 1e9], |time_s| *time_s, |_| true), 3);
        assert_eq!(player.clock.now, Duration::ZERO);
        assert_eq!(player.play([0.0, 5.0, 1e9], |time_s| *time_s, |_| false), 1);

        let mut player = Player::with_clock(Pace::RealTime, Fake::default());
        player.wait_for(0.0, || true);
        let mut asked = 0;
        let done = player.wait_for(5.0, || {
            asked += 1;
            asked < 4
        });
        assert!(!done);
        assert_eq!(player.clock.now, 3 * WAIT_SLICE);
    }
}
