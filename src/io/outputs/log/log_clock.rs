//! The clock of a log's `log_time`: UTC where the run says when it was recorded, else the recording's own.
//!
//! Consumes the head of the log and times of messages, s; produces whole nanoseconds, (1) of `mcap_log`.

use crate::flight::file::log_head::LogHead;
use crate::flight::file::run_file::RunInfo;

/// The clock of one log.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum LogClock {
    /// The recording's own.
    Own,
    /// UTC: when the first message was recorded, ns since 1970, and its time, s, once it is known.
    Utc { recorded_ns: i64, first_s: Option<f64> },
}

impl LogClock {
    pub(super) fn of(head: &LogHead) -> Self {
        let recorded_ns = RunInfo::from_toml(&head.run_toml).ok().and_then(|info| info.recorded_at_ns());
        recorded_ns.map_or(LogClock::Own, |recorded_ns| LogClock::Utc { recorded_ns, first_s: None })
    }

    /// For the metadata of a channel.
    pub(super) fn name(self) -> &'static str {
        match self {
            LogClock::Own => "the recording's own, from its zero",
            LogClock::Utc { .. } => "UTC: recorded_at of the run, plus time, less time of the first message",
        }
    }

    /// (1).
    pub(super) fn log_time(&mut self, time_s: f64) -> u64 {
        let LogClock::Utc { recorded_ns, first_s } = self else { return log_time(time_s) };
        if !time_s.is_finite() {
            return 0;
        }
        let since_ns = libm::round(1e9 * (time_s - *first_s.get_or_insert(time_s))) as i64;
        u64::try_from(recorded_ns.saturating_add(since_ns)).unwrap_or(0)
    }
}

/// Time of a message in whole nanoseconds by the recording's own clock.
fn log_time(time_s: f64) -> u64 {
    let ns = libm::round(time_s * 1e9);
    if ns.is_nan() { 0 } else { (ns.max(0.0) as u64).min(i64::MAX as u64) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn log_time_is_whole_nanoseconds_and_never_negative() {
        let cases = [(0.0, 0), (1.5, 1_500_000_000), (-3.0, 0), (f64::NAN, 0), (f64::NEG_INFINITY, 0)];
        for (time_s, ns) in cases {
            assert_eq!(log_time(time_s), ns);
        }
        assert_eq!(log_time(f64::INFINITY), i64::MAX as u64);
        assert_eq!(log_time(1e300), i64::MAX as u64);
        assert_eq!(log_time(1.0 / 256.0), 3_906_250);
    }

    #[test]
    fn a_run_with_a_date_is_logged_in_utc() {
        let head = |run: &str| LogHead { run_toml: run.to_owned(), ..LogHead::default() };
        // date -d '2024-05-17T09:30:01Z' +%s = 1715938201.
        let mut clock = LogClock::of(&head("recorded_at = \"2024-05-17T09:30:01.5Z\"\n"));
        assert_eq!(clock.log_time(f64::NAN), 0);
        assert_eq!(clock.log_time(-3.0), 1_715_938_201_500_000_000);
        assert_eq!(clock.log_time(-1.75), 1_715_938_202_750_000_000);
        assert_eq!(clock.log_time(-4.0), 1_715_938_200_500_000_000);
        // A date alone is no time.
        assert_eq!(LogClock::of(&head("recorded_at = \"2024-05-17\"\n")), LogClock::Own);
        assert_eq!(LogClock::of(&head("")).log_time(1.5), 1_500_000_000);
    }
}
