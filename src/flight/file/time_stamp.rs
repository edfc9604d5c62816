//! Times as dates and times of day.
//!
//! Consumes a text; produces the day (since 1970-01-01, UTC; none of a time of day) and the second of the day. Read are ISO 8601
//! (`2024-05-17T09:30:01.25Z`, a space for the T, an offset `+02:00`, a comma for the point), the same with points between day,
//! month and year (`17.05.2024 09:30:01`), the time of day alone (`09:30:01.25`, `9:30:01 PM`), and the day of the year before it
//! (`138:09:30:01.25`, day 1 is the first). With slashes, `5/6/2024` is a day of May or of June: read where the order is stated.

/// Seconds of a day.
pub const DAY_S: f64 = 86_400.0;

/// A date and time, or a time of day.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TimeStamp {
    /// Days since 1970-01-01, or since an unnamed year's beginning.
    pub day: Option<i64>,
    /// Whether the day has a year.
    pub dated: bool,
    /// Second of that day, s.
    pub second_s: f64,
}

/// In which order day, month and year stand in a date with slashes, `5/6/2024`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum DateOrder {
    /// Not stated: such a date is not read.
    #[default]
    Unknown,
    /// As in Europe.
    DayMonthYear,
    /// As in the United States.
    MonthDayYear,
}

impl TimeStamp {
    /// Reads the text.
    #[must_use]
    pub fn parse(text: &str) -> Option<Self> {
        Self::parse_ordered(text, DateOrder::Unknown)
    }

    /// The same, dates with slashes in that order.
    #[must_use]
    pub fn parse_ordered(text: &str, order: DateOrder) -> Option<Self> {
        let text = text.trim();
        if let Some((date, time)) = text.split_once(['T', 't', ' '])
            && let Some(day) = date_of(date, order)
        {
            let time = time.trim_start();
            let (time, offset_s) = zone_of(time)?;
            return TimeStamp { day: Some(day), dated: true, second_s: time_of_day(time)? - offset_s }.within_its_day();
        }
        let parts = text.bytes().filter(|byte| *byte == b':').count();
        match (parts, text.split_once(':')) {
            (3, Some((day, time))) => {
                let day = digits(day, 1, 3).filter(|day| (1..=366).contains(day))?;
                Some(TimeStamp { day: Some(day - 1), dated: false, second_s: time_of_day(time)? })
            }
            (2, _) => Some(TimeStamp { day: None, dated: false, second_s: time_of_day(text)? }),
            _ => None,
        }
    }

    /// An offset may lead to the day before or after.
    fn within_its_day(self) -> Option<Self> {
        let TimeStamp { day, dated, second_s } = self;
        let (shift, second_s) = if second_s < 0.0 {
            (-1, second_s + DAY_S)
        } else if second_s >= DAY_S {
            (1, second_s - DAY_S)
        } else {
            (0, second_s)
        };
        Some(TimeStamp { day: day.map(|day| day + shift), dated, second_s })
    }

    /// As ISO 8601, UTC, to the millisecond, where it has a date.
    pub fn iso(self) -> Option<String> {
        let (year, month, day) = civil(self.day.filter(|_| self.dated)?);
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "0 to 86400")]
        let ms = libm::floor(1e3 * self.second_s + 1e-3) as u32;
        let second = ms / 1000;
        let fraction = if ms.is_multiple_of(1000) { String::new() } else { format!(".{:03}", ms % 1000) };
        let (hours, minutes, seconds) = (second / 3600, second / 60 % 60, second % 60);
        Some(format!("{year:04}-{month:02}-{day:02}T{hours:02}:{minutes:02}:{seconds:02}{fraction}Z"))
    }

    /// Nanoseconds since 1970-01-01, UTC, where it has a date.
    pub fn unix_ns(self) -> Option<i64> {
        let day = self.day.filter(|_| self.dated)?;
        #[expect(clippy::cast_possible_truncation, reason = "a second of the day")]
        let of_day = libm::round(1e9 * self.second_s) as i64;
        day.checked_mul(86_400_000_000_000)?.checked_add(of_day)
    }

    /// The time so many microseconds after 1970-01-01, UTC.
    pub fn of_unix_us(us: u64) -> Self {
        const DAY_US: u64 = 86_400_000_000;
        #[expect(clippy::cast_possible_wrap, clippy::cast_precision_loss, reason = "days of 64 bits of us: below 2^28")]
        let (day, of_day) = ((us / DAY_US) as i64, (us % DAY_US) as f64);
        TimeStamp { day: Some(day), dated: true, second_s: 1e-6 * of_day }
    }
}

/// A number of so many digits and no other sign.
fn digits(text: &str, least: usize, most: usize) -> Option<i64> {
    let fits = (least..=most).contains(&text.len()) && text.bytes().all(|byte| byte.is_ascii_digit());
    if fits { text.parse().ok() } else { None }
}

/// Days since 1970-01-01 of `2024-05-17`, `2024/05/17` or `17.05.2024`, and of `17/05/2024` or `05/17/2024` by the order.
fn date_of(text: &str, order: DateOrder) -> Option<i64> {
    let separator = text.chars().find(|letter| !letter.is_ascii_digit())?;
    let parts: Vec<&str> = text.split(separator).collect();
    let [first, second, third] = parts.try_into().ok()?;
    let (year, month, day) = match (separator, first.len(), order) {
        ('-' | '/', 4, _) => (first, second, third),
        ('.', ..) | ('/', _, DateOrder::DayMonthYear) => (third, second, first),
        ('/', _, DateOrder::MonthDayYear) => (third, first, second),
        _ => return None,
    };
    let (year, month, day) = (digits(year, 4, 4)?, digits(month, 1, 2)?, digits(day, 1, 2)?);
    let days = days_from_civil(year, month, day);
    ((1..=12).contains(&month) && civil(days) == (year, month, day)).then_some(days)
}

/// Days since 1970-01-01 in the Gregorian calendar; eras of 400 years of 146097 days, years that begin in March.
fn days_from_civil(year: i64, month: i64, day: i64) -> i64 {
    let year = if month <= 2 { year - 1 } else { year };
    let era = year.div_euclid(400);
    let of_era = year.rem_euclid(400);
    let of_year = (153 * ((month + 9) % 12) + 2) / 5 + day - 1;
    era * 146_097 + of_era * 365 + of_era / 4 - of_era / 100 + of_year - 719_468
}

/// Year, month and day of that day: the inverse.
fn civil(days: i64) -> (i64, i64, i64) {
    let days = days.saturating_add(719_468);
    let era = days.div_euclid(146_097);
    let of_era = days.rem_euclid(146_097);
    let year_of_era = (of_era - of_era / 1460 + of_era / 36_524 - of_era / 146_096) / 365;
    let of_year = of_era - (365 * year_of_era + year_of_era / 4 - year_of_era / 100);
    let march_month = (5 * of_year + 2) / 153;
    let day = of_year - (153 * march_month + 2) / 5 + 1;
    let month = if march_month < 10 { march_month + 3 } else { march_month - 9 };
    (year_of_era + era * 400 + i64::from(month <= 2), month, day)
}

/// The time without its zone, and how far that is ahead of UTC, s.
fn zone_of(text: &str) -> Option<(&str, f64)> {
    if let Some(time) = text.strip_suffix(['Z', 'z']) {
        return Some((time.trim_end(), 0.0));
    }
    let Some(at) = text.rfind(['+', '-']) else { return Some((text, 0.0)) };
    let (time, offset) = text.split_at_checked(at)?;
    let sign = if offset.starts_with('-') { -1.0 } else { 1.0 };
    let offset = offset.get(1..)?.replace(':', "");
    let (hours, minutes) = match offset.len() {
        2 => (digits(&offset, 2, 2)?, 0),
        4 => (digits(offset.get(..2)?, 2, 2)?, digits(offset.get(2..)?, 2, 2)?),
        _ => return None,
    };
    if hours > 14 || minutes > 59 {
        return None;
    }
    #[expect(clippy::cast_precision_loss, reason = "below 900")]
    let offset_s = sign * (hours * 60 + minutes) as f64 * 60.0;
    Some((time.trim_end(), offset_s))
}

/// Second of the day of `09:30:01.25` or `9:30:01 PM`; 60 in a leap second.
fn time_of_day(text: &str) -> Option<f64> {
    let half = |ends: [&str; 2]| ends.iter().find_map(|end| text.strip_suffix(end)).map(str::trim_end);
    match (half(["AM", "am"]), half(["PM", "pm"])) {
        (None, None) => time_of_24_hours(text),
        (morning, afternoon) => {
            let within_s = time_of_24_hours(morning.or(afternoon)?)?;
            let hour_s = 3600.0;
            // Twelve o'clock is the half's beginning.
            let fits = (hour_s..13.0 * hour_s).contains(&within_s);
            let since_half_s = if within_s >= 12.0 * hour_s { within_s - 12.0 * hour_s } else { within_s };
            fits.then_some(if afternoon.is_some() { since_half_s + 12.0 * hour_s } else { since_half_s })
        }
    }
}

fn time_of_24_hours(text: &str) -> Option<f64> {
    let mut parts = text.split(':');
    let (hours, minutes) = (digits(parts.next()?, 1, 2)?, digits(parts.next()?, 2, 2)?);
    let seconds = parts.next().unwrap_or("00").replacen(',', ".", 1);
    let plain = seconds.bytes().all(|byte| byte.is_ascii_digit() || byte == b'.');
    let second_s: f64 = seconds.parse().ok().filter(|_| plain)?;
    let fits = hours <= 24 && minutes <= 59 && second_s < 61.0 && parts.next().is_none();
    #[expect(clippy::cast_precision_loss, reason = "below 86400")]
    let whole_s = (hours * 3600 + minutes * 60) as f64;
    fits.then_some(whole_s + second_s)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(text: &str) -> Option<(Option<i64>, f64)> {
        TimeStamp::parse(text).map(|stamp| (stamp.day, stamp.second_s))
    }

    #[test]
    fn dates_and_times_are_those_of_the_calendar() {
        // date -d '2024-05-17T09:30:01Z' +%s = 1715938201 = 19860 days and 34201 s.
        assert_eq!(at("2024-05-17T09:30:01.25Z"), Some((Some(19_860), 34_201.25)));
        assert_eq!(at("2024-05-17 09:30:01,25"), Some((Some(19_860), 34_201.25)));
        assert_eq!(at("2024-05-17T01:30:01.25+02:00"), Some((Some(19_859), 84_601.25)));
        assert_eq!(at("2024-05-17T23:30:00-0100"), Some((Some(19_861), 1800.0)));
        assert_eq!(at("2024-02-29T00:00:00"), Some((Some(19_782), 0.0)));
        assert_eq!(at("09:30:01.25"), Some((None, 34_201.25)));
        assert_eq!(at("138:09:30:01.25"), Some((Some(137), 34_201.25)));
        let stamp = TimeStamp::parse("2024-05-17T09:30:01.25Z").unwrap();
        assert_eq!(stamp.iso().as_deref(), Some("2024-05-17T09:30:01.250Z"));
        assert_eq!(stamp.unix_ns(), Some(1_715_938_201_250_000_000));
        assert_eq!(TimeStamp::of_unix_us(1_715_938_201_250_000), stamp);
        assert_eq!(TimeStamp::parse("09:30:01").unwrap().unix_ns(), None);
        assert_eq!(at("17.05.2024 09:30:01,25"), Some((Some(19_860), 34_201.25)));
        assert_eq!(at("9:30:01 PM"), Some((None, 77_401.0)));
        assert_eq!((at("12:00:01 AM"), at("12:00:01 pm")), (Some((None, 1.0)), Some((None, 43_201.0))));
        // 5 August, or 8 May.
        for (order, day) in
            [(DateOrder::Unknown, None), (DateOrder::DayMonthYear, Some(19_940)), (DateOrder::MonthDayYear, Some(19_851))]
        {
            let found = TimeStamp::parse_ordered("05/08/2024 00:00:00", order);
            assert_eq!(found.and_then(|stamp| stamp.day), day, "{order:?}");
        }
        for wrong in [
            "",
            "12.5",
            "2024-05-17",
            "2023-02-29T00:00:00",
            "2024-13-01T00:00:00",
            "9:3",
            "25:00:00",
            "00:61:00",
            "a:b:c",
            "2024-05-17T09:30:01+99:00",
            "0:00:00:00",
            "1:2:3:4:5",
            "13:00:00 PM",
            "0:30:00 AM",
            "05/17/2024 09:30:01",
            "17.05-2024 09:30:01",
            "31.02.2024 09:30:01",
        ] {
            assert_eq!(TimeStamp::parse(wrong), None, "{wrong}");
        }
    }
}
