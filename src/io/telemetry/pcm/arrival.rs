//! Lost datagrams of a stream that does not number them, by the times at which the others arrive.
//!
//! Consumes, for each datagram, when it arrived and when it should have by the bits before it; produces the time that lost
//! datagrams took. With the delay d of each, its least value over a window of [`WINDOW_US`] is that of a datagram that nothing
//! held up. It rises at a loss by the length T of a datagram, or a multiple, and stays:
//!     lost = k T,  |s - k T| <= T/4,  s = min over the window - min over the window before,  s > [`LEAST_US`]             (1)
//! Where lengths differ, lost = s. A datagram that waited has later ones behind it that did not; a receiver that slept finds
//! them waiting and catches up; clocks that drift change d by less than a thousandth of a window. A loss is told one window
//! late. Not told: the loss of datagrams shorter than [`LEAST_US`], losses in windows of fewer than [`ENOUGH`] datagrams. Told
//! in error: a delay near a multiple of T that lasts a window and ends later.

use std::collections::VecDeque;

/// Length of a window, us.
pub const WINDOW_US: i64 = 500_000;
/// Rises below this are jitter, us.
pub const LEAST_US: i64 = 2_000;
/// Datagrams that a window must hold.
pub const ENOUGH: usize = 5;
/// Datagrams that are kept at most.
const KEPT: usize = 1 << 14;

/// One datagram.
#[derive(Clone, Copy, Debug)]
struct Arrival {
    host_us: i64,
    delay_us: i64,
    length_us: i64,
}

/// The delays of the last datagrams.
#[derive(Clone, Debug)]
pub struct ArrivalWindow {
    arrivals: VecDeque<Arrival>,
}

impl Default for ArrivalWindow {
    fn default() -> Self {
        ArrivalWindow { arrivals: VecDeque::with_capacity(KEPT) }
    }
}

impl ArrivalWindow {
    /// Takes in a datagram that arrived at that host time and whose last bit has that time of the stream; returns the time that
    /// datagrams lost before it took, us, where it shows that some were. The stream's time must go on by it.
    pub fn arrived(&mut self, host_us: i64, stream_us: i64, length_us: i64) -> Option<i64> {
        if self.arrivals.len() >= KEPT {
            self.arrivals.pop_front();
        }
        self.arrivals.push_back(Arrival { host_us, delay_us: host_us - stream_us, length_us });
        while self.arrivals.front().is_some_and(|first| host_us - first.host_us > 2 * WINDOW_US) {
            self.arrivals.pop_front();
        }
        let split = self.arrivals.partition_point(|one| host_us - one.host_us > WINDOW_US);
        let least = |from: usize, to: usize| self.arrivals.range(from..to).map(|one| one.delay_us).min();
        if split < ENOUGH || self.arrivals.len() - split < ENOUGH {
            return None;
        }
        let rise_us = least(split, self.arrivals.len())? - least(0, split)?;
        let lengths = || self.arrivals.range(split..).map(|one| one.length_us);
        let (shortest_us, longest_us) = (lengths().min()?.max(1), lengths().max()?.max(1));
        if rise_us <= LEAST_US || 4 * rise_us <= 3 * longest_us {
            return None;
        }
        let multiple_us = (rise_us + longest_us / 2) / longest_us * longest_us;
        let lost_us = match shortest_us == longest_us {
            true if 4 * (rise_us - multiple_us).abs() > longest_us => return None,
            true => multiple_us,
            false => rise_us,
        };
        // What came since is as late as it was before, once the stream goes on by that.
        self.arrivals.range_mut(split..).for_each(|one| one.delay_us -= lost_us);
        Some(lost_us)
    }

    /// Forgets what came: the stream begins anew.
    pub fn clear(&mut self) {
        self.arrivals.clear();
    }
}

#[cfg(test)]
mod tests {
    use super::super::test_random::Random;
    use super::*;

    /// Plays datagrams of 20 ms with delays; `lost` are not sent, what is told goes on the stream's time.
    fn told(delay_us: impl Fn(i64) -> i64, lost: impl Fn(i64) -> bool) -> Vec<(i64, i64)> {
        let (mut window, mut stream_us, mut found) = (ArrivalWindow::default(), 0, Vec::new());
        for k in (0..500).filter(|k| !lost(*k)) {
            stream_us += 20_000;
            if let Some(us) = window.arrived(20_000 * (k + 1) + delay_us(k), stream_us, 20_000) {
                stream_us += us;
                found.push((k, us));
            }
        }
        found
    }

    #[test]
    fn one_lost_datagram_and_three_are_told_with_their_length() {
        let random = std::cell::RefCell::new(Random(7));
        let jitter = |_| i64::try_from(random.borrow_mut().next() % 4_000).unwrap();
        let found = told(jitter, |k| k == 200 || (300..303).contains(&k));
        assert_eq!(found.iter().map(|(_, us)| *us).collect::<Vec<_>>(), [20_000, 60_000], "{found:?}");
        assert!(found[0].0 < 200 + 28 && found[1].0 < 303 + 28, "{found:?}");
    }

    #[test]
    fn losses_close_upon_each_other_are_all_told() {
        // Pairs a sixth of a second apart, and one datagram in ten for a second.
        let pairs = told(|k| k % 3 * 500, |k| k % 100 == 50 || k % 100 == 58);
        assert_eq!(pairs.iter().map(|(_, us)| us).sum::<i64>(), 10 * 20_000, "{pairs:?}");
        let many = told(|k| k % 3 * 500, |k| (200..250).contains(&k) && k % 10 == 0);
        assert_eq!(many.iter().map(|(_, us)| us).sum::<i64>(), 5 * 20_000, "{many:?}");
    }

    #[test]
    fn delays_that_end_clocks_that_drift_and_pauses_of_the_receiver_are_no_loss() {
        assert_eq!(told(|_| 0, |_| false), []);
        // A quarter of a second late, then at once again.
        assert_eq!(told(|k| if k == 100 { 250_000 } else { 0 }, |_| false), []);
        // The receiver sleeps for two seconds and finds a hundred waiting.
        assert_eq!(told(|k| if (100..200).contains(&k) { 20_000 * (200 - k) } else { 0 }, |_| false), []);
        // 1000 ppm.
        assert_eq!(told(|k| 20 * k, |_| false), []);
    }
}
