//! Time data packets, format 1: the time of day and date that belongs to the relative time counter in the packet's header.
//!
//! Consumes the body of a packet of data type 11; produces a [`TimePacket`]. The channel specific word (32 bits,
//! little-endian): bits 3-0 source, 7-4 format, 8 leap year, 9 form of the date, 15-12 what the time code generator is locked
//! to. Binary coded decimals follow, one byte each, tens in the upper half:
//! | byte | both forms | | byte | day form | day-month-year form |
//! | --- | --- | --- | --- | --- | --- |
//! | 0 | hundreds and tens of milliseconds | | 4 | tens and units of the day of the year | day of the month |
//! | 1 | seconds | | 5 | hundreds of the day of the year | month |
//! | 2 | minutes | | 6 | | tens and units of the year |
//! | 3 | hours | | 7 | | thousands and hundreds of the year |
//!
//! The time is exact to 10 ms only as far as the digits go; what it marks is the count in the header. The scale (UTC, GPS,
//! local time of a range) is that of the source: no leap seconds are added. A second of 60 is taken as a leap second.
//! Refused: digits above 9, times and dates that do not exist, a packet whose format says that it holds no time.
//! Source: IRIG 106-09 Chapter 10, 10.6.3; since 106-17 Chapter 11, 11.2.3. Bits 15-12 came after 106-09.

use super::error::Chapter10Error;
use super::header::u32_at;

/// Nanoseconds of a second.
pub const NS: i64 = 1_000_000_000;
/// Nanoseconds of a day.
pub const DAY_NS: i64 = 86_400 * NS;

/// Where the time comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TimeSource {
    /// The recorder's clock.
    Internal,
    /// A signal from outside.
    External,
    /// The clock of the removable medium.
    Medium,
    /// None.
    None,
    /// A code that the standard reserves.
    Reserved(u8),
}

/// What carries the time.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TimeFormat {
    /// IRIG-B.
    IrigB,
    /// IRIG-A.
    IrigA,
    /// IRIG-G.
    IrigG,
    /// A real-time clock.
    RealTimeClock,
    /// UTC from GPS.
    UtcFromGps,
    /// GPS time.
    Gps,
    /// A code that the standard reserves.
    Reserved(u8),
}

/// A date and a time of day.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct CalendarTime {
    /// Year, where it is known.
    pub year: Option<u16>,
    /// Day of the year, from 1.
    pub day_of_year: u16,
    /// Nanoseconds since midnight.
    pub of_day_ns: i64,
}

impl CalendarTime {
    /// Nanoseconds since the start of the year.
    pub fn of_year_ns(&self) -> i64 {
        (i64::from(self.day_of_year) - 1) * DAY_NS + self.of_day_ns
    }

    /// Nanoseconds since 1970, where the year is known. Years after 2261 do not fit and have none.
    pub fn since_1970_ns(&self) -> Option<i64> {
        let year = i64::from(self.year?);
        let leaps = |year: i64| year / 4 - year / 100 + year / 400;
        let days = (year - 1970) * 365 + leaps(year - 1) - leaps(1969);
        days.checked_mul(DAY_NS)?.checked_add(self.of_year_ns())
    }
}

/// A time data packet of format 1.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TimePacket {
    /// Where the time comes from.
    pub source: TimeSource,
    /// What carries it.
    pub format: TimeFormat,
    /// What the time code generator is locked to (code of bits 15-12).
    pub lock: u8,
    /// Whether the packet says that the year is a leap year.
    pub leap_year: bool,
    /// The time.
    pub time: CalendarTime,
}

impl TimePacket {
    /// Reads the body of a packet.
    ///
    /// # Errors
    /// [`Chapter10Error`] where it is too short or holds no time.
    pub fn parse(body: &[u8]) -> Result<Self, Chapter10Error> {
        let short = |expected: u64| Chapter10Error::Short { what: "time packet", expected, found: body.len() as u64 };
        let word = u32_at(body, 0).ok_or(short(4))?;
        let [low, high] = [(word & 0xF) as u8, (word >> 4 & 0xF) as u8];
        let source = match low {
            0 => TimeSource::Internal,
            1 => TimeSource::External,
            2 => TimeSource::Medium,
            0xF => TimeSource::None,
            other => TimeSource::Reserved(other),
        };
        let format = match high {
            0 => TimeFormat::IrigB,
            1 => TimeFormat::IrigA,
            2 => TimeFormat::IrigG,
            3 => TimeFormat::RealTimeClock,
            4 => TimeFormat::UtcFromGps,
            5 => TimeFormat::Gps,
            0xF => return Err(Chapter10Error::Time { what: "a format that holds a time", found: 0xF }),
            other => TimeFormat::Reserved(other),
        };
        let leap_year = word >> 8 & 1 == 1;
        let dated = word >> 9 & 1 == 1;
        let length = if dated { 12 } else { 10 };
        let digits = body.get(4..length).ok_or(short(length as u64))?;
        let two = |at: usize, what: &'static str| {
            let byte = digits.get(at).copied().ok_or(short(length as u64))?;
            let (tens, units) = (byte >> 4, byte & 0xF);
            if tens > 9 || units > 9 {
                return Err(Chapter10Error::Digits { what, at: 4 + at as u64, found: byte });
            }
            Ok(u16::from(tens) * 10 + u16::from(units))
        };
        let at_most = |value: u16, most: u16, what: &'static str| {
            if value <= most { Ok(i64::from(value)) } else { Err(Chapter10Error::Time { what, found: value.into() }) }
        };
        let hundredths = i64::from(two(0, "hundredths of a second")?);
        let second = at_most(two(1, "seconds")?, 60, "at most 60 seconds")?;
        let minute = at_most(two(2, "minutes")?, 59, "at most 59 minutes")?;
        let hour = at_most(two(3, "hours")?, 23, "at most 23 hours")?;
        let of_day_ns = ((hour * 60 + minute) * 60 + second) * NS + hundredths * (NS / 100);
        let (year, day_of_year) = if dated {
            let year = two(7, "hundreds of years")? * 100 + two(6, "years")?;
            (Some(year), day_of_date(year, two(5, "a month")?, two(4, "a day")?)?)
        } else {
            let day = two(5, "hundreds of days")? * 100 + two(4, "days")?;
            let last = if leap_year { 366 } else { 365 };
            if !(1..=last).contains(&day) {
                return Err(Chapter10Error::Time { what: "a day of the year from 1 to its last", found: day.into() });
            }
            (None, day)
        };
        let lock = (word >> 12 & 0xF) as u8;
        Ok(TimePacket { source, format, lock, leap_year, time: CalendarTime { year, day_of_year, of_day_ns } })
    }
}

/// Whether a year has 366 days.
pub const fn is_leap(year: u16) -> bool {
    year.is_multiple_of(4) && !year.is_multiple_of(100) || year.is_multiple_of(400)
}

/// Day of the year of a date.
fn day_of_date(year: u16, month: u16, day: u16) -> Result<u16, Chapter10Error> {
    let february = if is_leap(year) { 29 } else { 28 };
    let lengths = [31, february, 31, 30, 31, 30, 31, 31, 30, 31, 30, 31];
    let before = usize::from(month).checked_sub(1).and_then(|index| Some((lengths.get(..index)?, lengths.get(index)?)));
    let Some((before, length)) = before else {
        return Err(Chapter10Error::Time { what: "a month from 1 to 12", found: month.into() });
    };
    if !(1..=*length).contains(&day) {
        return Err(Chapter10Error::Time { what: "a day that the month has", found: day.into() });
    }
    Ok(before.iter().sum::<u16>() + day)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_day_form_has_no_year() {
        // 20:05:00.00 on day 132.
        let packet = TimePacket::parse(&[1, 0, 0, 0, 0, 0, 0x05, 0x20, 0x32, 0x01]).unwrap();
        let of_day_ns = (20 * 60 + 5) * 60 * NS;
        assert_eq!(packet.time, CalendarTime { year: None, day_of_year: 132, of_day_ns });
        assert_eq!((packet.source, packet.format, packet.leap_year), (TimeSource::External, TimeFormat::IrigB, false));
        assert_eq!((packet.time.of_year_ns(), packet.time.since_1970_ns()), (131 * DAY_NS + of_day_ns, None));
    }

    #[test]
    fn the_date_form_gives_seconds_since_1970() {
        // 2000-03-01 12:34:56.78, UTC from GPS: date -ud "2000-03-01 12:34:56" +%s is 951914096.
        let body = [0x40, 0x03, 0, 0, 0x78, 0x56, 0x34, 0x12, 0x01, 0x03, 0x00, 0x20];
        let packet = TimePacket::parse(&body).unwrap();
        assert_eq!(packet.format, TimeFormat::UtcFromGps);
        assert_eq!((packet.time.year, packet.time.day_of_year), (Some(2000), 61));
        assert_eq!(packet.time.since_1970_ns(), Some(951_914_096 * NS + 780_000_000));
        let first = CalendarTime { year: Some(1970), day_of_year: 1, of_day_ns: 0 };
        assert_eq!(first.since_1970_ns(), Some(0));
        // date -ud 2100-12-31 +%s is 4133894400.
        let late = CalendarTime { year: Some(2100), day_of_year: 365, of_day_ns: 0 };
        assert_eq!(late.since_1970_ns(), Some(4_133_894_400 * NS));
        assert_eq!(CalendarTime { year: Some(9999), ..late }.since_1970_ns(), None);
    }

    #[test]
    fn times_that_do_not_exist_are_refused() {
        let day = |bytes: [u8; 6]| TimePacket::parse(&[&[1, 0, 0, 0][..], &bytes[..]].concat());
        assert!(day([0, 0, 0, 0, 1, 0]).is_ok());
        assert!(matches!(day([0x0A, 0, 0, 0, 1, 0]), Err(Chapter10Error::Digits { at: 4, found: 0x0A, .. })));
        for bytes in
            [[0, 0x61, 0, 0, 1, 0], [0, 0, 0x60, 0, 1, 0], [0, 0, 0, 0x24, 1, 0], [0, 0, 0, 0, 0, 0], [0, 0, 0, 0, 0x66, 3]]
        {
            assert!(matches!(day(bytes), Err(Chapter10Error::Time { .. })), "{bytes:?}");
        }
        let date = |day: u8, month: u8| TimePacket::parse(&[1, 2, 0, 0, 0, 0, 0, 0, day, month, 0x21, 0x20]);
        assert!(date(0x28, 2).is_ok() && date(0x31, 0x12).is_ok());
        assert!(date(0x29, 2).is_err() && date(1, 0x13).is_err() && date(0, 1).is_err() && date(1, 0).is_err());
        assert!(matches!(TimePacket::parse(&[1, 2, 0, 0, 0, 0, 0, 0, 1, 1]), Err(Chapter10Error::Short { .. })));
        assert!(matches!(TimePacket::parse(&[0xF1, 0, 0, 0, 0, 0, 0, 0, 1, 0]), Err(Chapter10Error::Time { .. })));
    }
}
