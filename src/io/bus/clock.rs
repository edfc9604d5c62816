//! The clock that all processes of a machine share: CLOCK_MONOTONIC in ns since the machine started.

use iceoryx2_bb_posix::clock::{ClockType, Time};

/// The reading now, ns; 0 where the system has no such clock, which no Linux lacks.
pub fn monotonic_ns() -> u64 {
    Time::now_with_clock(ClockType::Monotonic)
        .map_or(0, |now| now.seconds().saturating_mul(1_000_000_000).saturating_add(u64::from(now.nanoseconds())))
}

#[cfg(test)]
mod tests {
    use super::monotonic_ns;
    use std::time::{Duration, Instant};

    #[test]
    fn it_runs_as_fast_as_the_clock_of_the_standard_library() {
        let (begun, from_ns) = (Instant::now(), monotonic_ns());
        std::thread::sleep(Duration::from_millis(30));
        let (to_ns, elapsed) = (monotonic_ns(), begun.elapsed());
        let between = Duration::from_nanos(to_ns - from_ns);
        assert!(between >= Duration::from_millis(30) && between <= elapsed, "{between:?}, {elapsed:?}");
    }
}
