//! The time of a row: a number in a unit, or a date and time.
//!
//! Consumes cells; produces s. Dates count from midnight (UTC) before the first row, so that little is lost of a date's seconds;
//! a time of day that falls by more than half a day is of the next day. The unit of numbers, where it is not stated, is told by
//! the spacing of the first rows: recordings have from 3.3 to 3300 rows a second, so that of s, ms, us and ns one fits only.

use super::cell::{bare, number_of};
use crate::flight::file::time_stamp::{DAY_S, DateOrder, TimeStamp};

/// The least number of rows a second, 1/s.
const SLOWEST_HZ: f64 = 10.0 / 3.0;
/// The greatest.
const FASTEST_HZ: f64 = 1000.0 * SLOWEST_HZ;
/// Units by their factor to s.
const UNITS: [(&str, f64); 4] = [("s", 1.0), ("ms", 1e-3), ("us", 1e-6), ("ns", 1e-9)];

/// How times are read.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum TableClock {
    /// Numbers: s = factor * number.
    Number { factor: f64 },
    /// Numbers that count from 1970-01-01 (UTC): s = factor * number - 86400 * (the day from whose beginning it counts).
    SinceEpoch { factor: f64, zero_day: i64 },
    /// Dates, or times of day.
    Stamp { order: DateOrder, zero_day: Option<i64>, newest_s: f64, midnights: f64 },
}

impl TableClock {
    /// Of dates, those with slashes in that order.
    pub(crate) fn of_stamps(order: DateOrder) -> Self {
        TableClock::Stamp { order, zero_day: None, newest_s: f64::NEG_INFINITY, midnights: 0.0 }
    }

    /// Counts from that day's beginning.
    pub(crate) fn count_from(&mut self, day: i64) {
        match self {
            TableClock::Stamp { zero_day, .. } => *zero_day = Some(day),
            TableClock::SinceEpoch { zero_day, .. } => *zero_day = day,
            TableClock::Number { .. } => {}
        }
    }

    /// The day from whose beginning it counts.
    pub(crate) fn zero_day(&self) -> Option<i64> {
        match self {
            TableClock::Stamp { zero_day, .. } => *zero_day,
            TableClock::SinceEpoch { zero_day, .. } => Some(*zero_day),
            TableClock::Number { .. } => None,
        }
    }

    /// The time in a cell, s; `None` where it is empty.
    pub(crate) fn seconds(&mut self, cell: &[u8], decimal: u8) -> Result<Option<f64>, ()> {
        match self {
            TableClock::Number { factor } => Ok(number_of(cell, decimal)?.map(|number| scaled(number, *factor))),
            TableClock::SinceEpoch { factor, zero_day } => {
                #[expect(clippy::cast_precision_loss, reason = "days")]
                let zero_s = *zero_day as f64 * DAY_S;
                Ok(number_of(cell, decimal)?.map(|number| scaled(number, *factor) - zero_s))
            }
            TableClock::Stamp { order, zero_day, newest_s, midnights } => {
                let cell = bare(cell);
                if cell.is_empty() {
                    return Ok(None);
                }
                let stamp = std::str::from_utf8(cell).ok().and_then(|text| TimeStamp::parse_ordered(text, *order)).ok_or(())?;
                let days = match stamp.day {
                    Some(day) => {
                        #[expect(clippy::cast_precision_loss, reason = "days")]
                        let days = (day - *zero_day.get_or_insert(day)) as f64;
                        days
                    }
                    None => {
                        *midnights += f64::from(u8::from(stamp.second_s < *newest_s - 0.5 * DAY_S));
                        *newest_s = stamp.second_s;
                        *midnights
                    }
                };
                Ok(Some(days * DAY_S + stamp.second_s))
            }
        }
    }
}

/// A factor of one must not touch the bits.
#[expect(clippy::float_cmp, reason = "exactly one means SI already")]
pub(crate) fn scaled(value: f64, factor: f64) -> f64 {
    if factor == 1.0 { value } else { value * factor }
}

/// The median step between times that grow, and of how many; `None` where none grows.
pub(crate) fn median_step(times: &[f64]) -> Option<(f64, usize)> {
    let mut steps: Vec<f64> =
        times.windows(2).filter_map(|pair| Some(pair.get(1)? - pair.first()?)).filter(|step| *step > 0.0).collect();
    steps.sort_by(f64::total_cmp);
    Some((*steps.get(steps.len() / 2)?, steps.len()))
}

/// The unit of times with that step, and its factor: that of s, ms, us, ns by which rows come neither too fast nor too slowly.
pub(crate) fn unit_by_step(step: f64) -> Option<(&'static str, f64)> {
    UNITS.into_iter().find(|(_, factor)| {
        let rate_hz = 1.0 / (step * factor);
        (SLOWEST_HZ..FASTEST_HZ).contains(&rate_hz)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_unit_of_times_follows_from_their_step() {
        for (step, unit) in [
            (0.01, Some("s")),
            (0.1, Some("s")),
            (0.001, Some("s")),
            (1.0, Some("ms")),
            (10.0, Some("ms")),
            (100.0, Some("ms")),
            (1000.0, Some("us")),
            (4000.0, Some("us")),
            (20_000.0, Some("us")),
            (4e6, Some("ns")),
            (1e-5, None),
            (1e10, None),
        ] {
            assert_eq!(unit_by_step(step).map(|(unit, _)| unit), unit, "{step}");
        }
        assert_eq!(median_step(&[0.0, 10.0, 20.0, 20.0, 500.0]), Some((10.0, 3)));
        assert_eq!(median_step(&[3.0, 2.0]), None);
    }

    #[test]
    fn dates_count_from_midnight_and_times_of_day_go_past_it() {
        let mut clock = TableClock::of_stamps(DateOrder::Unknown);
        assert_eq!(clock.seconds(b"2024-05-17T23:59:59.5Z", b'.'), Ok(Some(86_399.5)));
        assert_eq!(clock.seconds(b"\"2024-05-18T00:00:00.5Z\"", b'.'), Ok(Some(86_400.5)));
        assert_eq!((clock.seconds(b"", b'.'), clock.seconds(b"x", b'.')), (Ok(None), Err(())));
        let mut clock = TableClock::of_stamps(DateOrder::Unknown);
        assert_eq!(clock.seconds(b"23:59:59.5", b'.'), Ok(Some(86_399.5)));
        assert_eq!(clock.seconds(b"00:00:00.5", b'.'), Ok(Some(86_400.5)));
        let mut numbers = TableClock::Number { factor: 1e-3 };
        assert_eq!(numbers.seconds(b"1,5", b','), Ok(Some(1.5e-3)));
    }
}
