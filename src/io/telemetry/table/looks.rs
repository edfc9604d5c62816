//! What the first rows show of the time, and which headers look like channels.
//!
//! Consumes the first lines of a table; produces the clock of its rows with what was found out in sentences, and hints for the
//! user: what a header probably means, and how a map is written. Refused: a map's time whose unit neither text nor spacing tell.

use super::cell::{bare, number_of};
use super::clock::{TableClock, median_step, unit_by_step};
use super::layout::{TableLayout, cells};
use crate::flight::file::run_file::{RecordingColumn, RecordingTarget, quoted};
use crate::flight::file::time_stamp::{DateOrder, TimeStamp};
use crate::flight::unit::{Quantity, factor_to_si};
use crate::io::telemetry::channel_map::header_guess::{guess, in_words};
use crate::io::telemetry::channel_map::map_file::{MapSection, MappedTime, MappedTimeFormat};
use crate::io::telemetry::channel_map::unit_text::unit_of;
use std::ops::Range;

/// So many headers that look like channels are named.
const NAMED: usize = 6;
/// So many steps tell the unit of the time.
const STEPS_MIN: usize = 8;
/// Rows of a run file that are further apart are not in s.
const SLOWEST_S: f64 = 3.0;
/// Times since 1970 that are dates from 2000 to 2100, s.
const SINCE_EPOCH_S: Range<f64> = 946_684_800.0..4_102_444_800.0;
/// How a user gets a map.
pub(crate) const TEMPLATE: &str = "sideslip inspect FILE --map-template map.toml";

/// The time's column in the first rows.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct TimeColumn {
    pub(crate) place: usize,
    /// Of its cells that are numbers.
    numbers: Vec<f64>,
    /// The first one that is a date or time of day, where no cell is a number.
    first_stamp: Option<TimeStamp>,
    /// In which order the map says that day, month and year stand.
    order: DateOrder,
}

/// How times are read.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct FoundClock {
    pub(crate) clock: TableClock,
    pub(crate) said: Option<String>,
    /// When the record began, where the times say it.
    pub(crate) started: Option<String>,
}

impl FoundClock {
    fn number(factor: f64) -> Self {
        FoundClock { clock: TableClock::Number { factor }, said: None, started: None }
    }

    /// Of another program, whose times may count from 1970.
    fn foreign(factor: f64, numbers: &[f64]) -> Self {
        let first_s = numbers.first().map(|first| first * factor).filter(|first_s| SINCE_EPOCH_S.contains(first_s));
        let Some(first_s) = first_s else { return Self::number(factor) };
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "between 2000 and 2100")]
        let stamp = TimeStamp::of_unix_us(libm::round(first_s * 1e6) as u64);
        FoundClock {
            clock: TableClock::SinceEpoch { factor, zero_day: stamp.day.unwrap_or_default() },
            said: Some("the time counts from 1970: s since midnight (UTC) of the first day".to_owned()),
            started: stamp.iso(),
        }
    }

    /// With another sentence before its own.
    fn and_said(mut self, words: String) -> Self {
        self.said = Some(match self.said {
            Some(own) => format!("{words}; {own}"),
            None => words,
        });
        self
    }
}

impl TimeColumn {
    /// Looks at the rows behind the header.
    pub(crate) fn look(rows: &[&[u8]], layout: TableLayout, place: usize, section: Option<&MapSection>) -> Self {
        let format = section.map_or(MappedTimeFormat::FoundOut, |section| section.time.format);
        let order = format.date_order();
        let (mut numbers, mut first_stamp) = (Vec::new(), None);
        for row in rows {
            let record = cells(row, layout.separator);
            let cell = bare(record.get(place).unwrap_or_default());
            match number_of(cell, layout.decimal) {
                Ok(number) => numbers.extend(number),
                Err(()) if format != MappedTimeFormat::Number && first_stamp.is_none() => {
                    first_stamp = std::str::from_utf8(cell).ok().and_then(|text| TimeStamp::parse_ordered(text, order));
                }
                Err(()) => {}
            }
        }
        TimeColumn { place, first_stamp: first_stamp.filter(|_| numbers.is_empty()), order, numbers }
    }

    /// Dates.
    fn stamps(&self) -> FoundClock {
        let is_dated = self.first_stamp.is_some_and(|stamp| stamp.dated);
        let said = if is_dated {
            "the time is a date and time: s since midnight (UTC) of the first day"
        } else {
            "the time is a time of day: s since midnight"
        };
        let mut clock = TableClock::of_stamps(self.order);
        if let Some(day) = self.first_stamp.and_then(|stamp| stamp.day) {
            clock.count_from(day);
        }
        FoundClock { clock, said: Some(said.to_owned()), started: self.first_stamp.and_then(TimeStamp::iso) }
    }

    /// Of a run file: s where the header states no unit. A recording without a preamble is another program's: in ms, us or ns
    /// where every row is far too late for s, and since 1970 where it would be of this century.
    pub(crate) fn of_run_file(&self, factor: f64, unit: Option<&str>, has_preamble: bool) -> FoundClock {
        if self.first_stamp.is_some() {
            return self.stamps();
        }
        // Of few rows, or of times in disorder, nothing is found out: they are read as they stand.
        let is_recording = median_step(&self.numbers).filter(|(_, grow)| *grow >= STEPS_MIN && grow + 1 == self.numbers.len());
        let Some((step, _)) = is_recording.filter(|_| !has_preamble) else { return FoundClock::number(factor) };
        match unit_by_step(step).filter(|_| unit.is_none() && step >= SLOWEST_S) {
            Some((unit, factor)) => FoundClock::foreign(factor, &self.numbers)
                .and_said(format!("the time is in {unit}: its header states no unit, rows are {step} apart")),
            None => FoundClock::foreign(factor, &self.numbers),
        }
    }

    /// Of a table that a map describes.
    ///
    /// # Errors
    /// A sentence where the unit is not stated and several are possible.
    pub(crate) fn of_mapped(&self, time: &MappedTime, header_unit: Option<&str>) -> Result<FoundClock, String> {
        if matches!(time.format, MappedTimeFormat::Stamps(_)) || self.first_stamp.is_some() {
            return Ok(self.stamps());
        }
        if let Some(rate_hz) = time.rate_hz {
            return Ok(FoundClock::number(1.0 / rate_hz));
        }
        let stated = time.unit.or_else(|| header_unit.and_then(unit_of));
        if let Some(factor) = stated.and_then(|unit| factor_to_si(unit, Quantity::Time).ok()) {
            return Ok(FoundClock::foreign(factor, &self.numbers));
        }
        let column = time.column.as_deref().unwrap_or("time");
        let say_it = format!("say it in the map: time = {{ column = {}, unit = \"ms\" }}", toml::Value::from(column));
        match median_step(&self.numbers) {
            // Steps of 1 are 1 Hz in s or 1000 Hz in ms.
            Some((step, _)) if (0.3..SLOWEST_S).contains(&step) => {
                Err(format!("expected the unit of the time {}: rows are {step} apart, in s or in ms; {say_it}", quoted(column)))
            }
            Some((step, _)) => match unit_by_step(step) {
                Some((unit, factor)) => Ok(FoundClock::foreign(factor, &self.numbers)
                    .and_said(format!("the time is in {unit}: neither header nor map state a unit, rows are {step} apart"))),
                None => Err(format!("expected the unit of the time {}: rows are {step} apart; {say_it}", quoted(column))),
            },
            None => Err(format!(
                "expected times that grow, or dates such as 2026-11-29 14:03:02.120 or 29.11.2026 14:03:02.120, in column {}, found \
                 neither; of numbers {say_it}, of dates with slashes time = {{ column = {}, format = \"dmy\" }} or \"mdy\"",
                quoted(column),
                toml::Value::from(column)
            )),
        }
    }
}

/// What a refused header may mean, and how to go on.
pub(crate) fn hint(headers: &[&str]) -> String {
    let alike = named(headers.iter().copied(), |_| true);
    let alike = if alike.is_empty() { String::new() } else { format!("; did you mean {alike}?") };
    format!("{alike} A table of another program is read by a map: {TEMPLATE}, then --map map.toml")
}

/// Columns without a meaning whose headers look like channels that the table lacks.
pub(crate) fn look_alikes(headers: &[&str], columns: &[RecordingColumn]) -> Option<String> {
    let lacks = |name: &str| !columns.iter().any(|column| column.name == name);
    let others = headers.iter().zip(columns).filter(|(_, column)| column.target == RecordingTarget::Other);
    let alike = named(others.map(|(header, _)| *header), lacks);
    let how = format!("name them so, or write a map: {TEMPLATE}");
    (!alike.is_empty()).then(|| format!("columns that are no channels: did you mean {alike}? {how}"))
}

fn named<'h>(headers: impl Iterator<Item = &'h str>, lacks: impl Fn(&str) -> bool) -> String {
    let bare = |header: &'h str| header.trim().trim_matches('"');
    let meant = headers.filter_map(|header| Some((header, guess(bare(header)).filter(|guess| lacks(guess.name))?)));
    let words: Vec<String> = meant.map(|(header, guess)| format!("{} as {}", quoted(bare(header)), in_words(&guess))).collect();
    let more = if words.len() > NAMED { ", ..." } else { "" };
    let shown = words.get(..words.len().min(NAMED)).unwrap_or_default();
    if shown.is_empty() { String::new() } else { format!("{}{more}", shown.join(", ")) }
}
