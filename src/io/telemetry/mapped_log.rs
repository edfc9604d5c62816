//! An MCAP log of another program as a recording: its messages in JSON, by a map of topics and fields.
//!
//! Consumes an MCAP file and a map with a section a topic; produces rows in order of time. Values of one time are one row.
//! Time is a field of the message (a number in a unit, a date, or an object of `sec` and `nanosec`), else the time at which it
//! was logged; times since 1970 count from midnight (UTC) before the first. Refused: a topic that is not there, with those that
//! are; messages in another encoding than JSON.

use super::alignment::row_alignment::{RowAlignment, WINDOW_S};
use super::channel_map::map_file::{ChannelMap, MapSection, MappedTimeFormat};
use super::channel_map::unit_text::{name_and_unit, unit_of};
use super::mcap_stream::MessageStream;
use super::record::{RecordingError, RecordingRow, SkipReason, SkippedByReason};
use super::table::clock::scaled;
use super::table::header::MappedHeader;
use super::waiting_rows::WaitingRows;
use crate::flight::file::run_file::{ChannelLatencies, RecordingColumn, RecordingTarget, RunInfo, quoted};
use crate::flight::file::time_stamp::{DAY_S, DateOrder, TimeStamp};
use crate::flight::sample::Sample;
use crate::flight::unit::{Quantity, factor_to_si};
use serde_json::Value;
use std::collections::BTreeSet;
use std::fs::File;
use std::io::{BufReader, Seek, SeekFrom};
use std::path::{Path, PathBuf};

/// Times beyond are since 1970, s.
const EPOCH_S: f64 = 1e8;
/// Topics that an error names.
const TOPICS_NAMED: usize = 12;
/// So many messages show which topics there are.
const LOOKED_AT: u64 = 100_000;

/// Where the time of a topic's messages stands.
#[derive(Debug)]
enum MessageTime {
    /// When it was logged.
    Logged,
    /// A number.
    Number { field: String, factor: f64 },
    /// A date, or an object of seconds and nanoseconds.
    Stamp { field: String, order: DateOrder },
}

/// A topic: its fields, with the columns that they are.
#[derive(Debug)]
struct MappedTopic {
    name: String,
    time: MessageTime,
    fields: Vec<String>,
    header: MappedHeader,
}

impl MappedTopic {
    fn new(section: &MapSection) -> Result<Self, String> {
        let name = section.of.clone().unwrap_or_default();
        let of_attitude = section.attitude.iter().flatten();
        // The time stands first; of a topic without one, under a name that is no field.
        let mut fields = vec![section.time.column.clone().unwrap_or_default()];
        fields.extend(section.channels.iter().map(|mapped| &mapped.column).chain(of_attitude).cloned());
        let mut section = section.clone();
        section.time.column = fields.first().cloned();
        let headers: Vec<&str> = fields.iter().map(String::as_str).collect();
        let header =
            MappedHeader::new(&section, &headers).map_err(|what| format!("by the map, topic {}: {what}", quoted(&name)))?;
        let field = fields.first().cloned().unwrap_or_default();
        let unit = section.time.unit.or_else(|| name_and_unit(&field).1.and_then(unit_of));
        let of_rate = section.time.rate_hz.map(|rate_hz| 1.0 / rate_hz);
        let factor = of_rate.or_else(|| unit.and_then(|unit| factor_to_si(unit, Quantity::Time).ok()));
        let order = section.time.format.date_order();
        let time = match (field.is_empty(), section.time.format, factor) {
            (true, ..) => MessageTime::Logged,
            (false, MappedTimeFormat::Stamps(_), _) | (false, _, None) => MessageTime::Stamp { field, order },
            (false, _, Some(factor)) => MessageTime::Number { field, factor },
        };
        Ok(MappedTopic { name, time, fields, header })
    }

    /// The time of a message, s.
    fn time_s(&self, message: &Value, logged_ns: u64) -> Result<f64, SkipReason> {
        match &self.time {
            MessageTime::Logged => Ok(seconds_of_ns(logged_ns)),
            MessageTime::Number { field, factor } => {
                let value = field_of(message, field).ok_or(SkipReason::NoTime)?;
                value.as_f64().map(|number| scaled(number, *factor)).ok_or(SkipReason::NotANumber)
            }
            MessageTime::Stamp { field, order } => {
                let value = field_of(message, field).ok_or(SkipReason::NoTime)?;
                stamp_s(value, *order).ok_or(SkipReason::NotANumber)
            }
        }
    }

    /// The sample of a message.
    fn sample(&self, message: &Value, time_s: f64) -> Result<Sample, SkipReason> {
        let mut sample = Sample::new(time_s);
        let number = |place: usize| field_of(message, self.fields.get(place)?)?.as_f64();
        for (place, column) in self.header.columns.iter().enumerate().take(self.fields.len()) {
            if let (RecordingTarget::Known { channel, factor }, Some(value)) = (column.target, number(place)) {
                sample.set(channel, scaled(value, factor));
            }
        }
        self.header.derived.put(&mut sample, number).map_err(|_| SkipReason::Damaged)?;
        Ok(sample)
    }
}

/// A date's text, or an object of seconds and nanoseconds: s since 1970.
fn stamp_s(value: &Value, order: DateOrder) -> Option<f64> {
    let part = |names: [&str; 3]| names.iter().find_map(|name| value.get(name)).and_then(Value::as_f64);
    if let Some(text) = value.as_str() {
        let stamp = TimeStamp::parse_ordered(text, order)?;
        #[expect(clippy::cast_precision_loss, reason = "days")]
        let day = stamp.day.unwrap_or_default() as f64;
        return Some(day * DAY_S + stamp.second_s);
    }
    Some(part(["sec", "secs", "seconds"])? + 1e-9 * part(["nanosec", "nsec", "nanos"])?)
}

#[expect(clippy::cast_precision_loss, reason = "a quarter of a microsecond since 1970")]
fn seconds_of_ns(ns: u64) -> f64 {
    (ns / 1_000_000_000) as f64 + (ns % 1_000_000_000) as f64 * 1e-9
}

/// A field by its path: a dot for each level, a number in brackets for each place in an array.
fn field_of<'v>(message: &'v Value, path: &str) -> Option<&'v Value> {
    if let Some(value) = message.get(path) {
        return Some(value);
    }
    path.split(['.', '[']).try_fold(message, |value, part| match part.strip_suffix(']').unwrap_or(part).parse::<usize>() {
        Ok(place) if value.is_array() => value.get(place),
        _ => value.get(part.strip_suffix(']').unwrap_or(part)),
    })
}

/// A log that is being read.
pub struct MappedLog {
    path: PathBuf,
    stream: MessageStream<BufReader<File>>,
    topics: Vec<MappedTopic>,
    info: RunInfo,
    columns: Vec<RecordingColumn>,
    order: RowAlignment,
    waiting: WaitingRows,
    skipped: SkippedByReason,
    /// What times count from, s since 1970 or 0.
    zero_s: Option<f64>,
    messages: u64,
}

impl std::fmt::Debug for MappedLog {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("MappedLog").field("path", &self.path).field("topics", &self.topics.len()).finish_non_exhaustive()
    }
}

impl MappedLog {
    /// Opens a log by a map; `path` is named in messages only.
    ///
    /// # Errors
    /// [`RecordingError`] where reading fails, or a topic of the map is not there or not in JSON.
    pub fn new(path: &Path, mut source: File, map: &ChannelMap) -> Result<Self, RecordingError> {
        let whole = |what: String| RecordingError::Whole { path: path.into(), what };
        let io = |source| RecordingError::Io { path: path.into(), source };
        let topics = map.sections.iter().map(MappedTopic::new).collect::<Result<Vec<_>, _>>().map_err(whole)?;
        source.seek(SeekFrom::Start(0)).map_err(io)?;
        refuse_missing(path, &mut source, &topics)?;
        source.seek(SeekFrom::Start(0)).map_err(io)?;
        let mut info = map.info.clone();
        info.set_controls(map.controls());
        let mut columns = vec![RecordingColumn::new("time", None).map_err(whole)?];
        let known = |column: &&RecordingColumn| matches!(column.target, RecordingTarget::Known { .. });
        columns.extend(topics.iter().flat_map(|topic| topic.header.columns.iter().filter(known)).cloned());
        let order = RowAlignment::new(&ChannelLatencies::default(), 0, WINDOW_S).map_err(|wrong| whole(wrong.to_string()))?;
        let (waiting, skipped) = (WaitingRows::default(), SkippedByReason::default());
        let stream = MessageStream::new(BufReader::new(source));
        Ok(MappedLog { path: path.into(), stream, topics, info, columns, order, waiting, skipped, zero_s: None, messages: 0 })
    }

    /// What the map says of the run.
    pub fn info(&self) -> &RunInfo {
        &self.info
    }

    /// The time, then the channels in the order of the map.
    pub fn columns(&self) -> &[RecordingColumn] {
        &self.columns
    }

    /// What was skipped so far.
    pub fn skipped(&self) -> &SkippedByReason {
        &self.skipped
    }

    /// What of the file could not be read, in words; complete after the last row.
    pub fn shortfall(&self) -> Option<String> {
        let short = self.stream.shortfall();
        let damaged = (short.damaged_chunks > 0).then(|| {
            format!("{} damaged parts were skipped ({})", short.damaged_chunks, short.chunk_reason.as_deref().unwrap_or_default())
        });
        let late = self.order.tally().losses();
        let all: Vec<String> = short.stopped.clone().into_iter().chain(damaged).chain(late).collect();
        (!all.is_empty()).then(|| all.join("; "))
    }

    /// Whether the log, as far as it was read, stops without its proper end.
    pub fn ends_abruptly(&self) -> bool {
        self.stream.shortfall().stopped.is_some()
    }

    /// The next row; `None` at the end.
    ///
    /// # Errors
    /// [`RecordingError`] where reading fails, or the end comes without a single good message.
    pub fn next_row(&mut self) -> Result<Option<&RecordingRow>, RecordingError> {
        while self.waiting.wants_more() {
            let MappedLog { stream, topics, order, waiting, skipped, zero_s, messages, path, .. } = self;
            let read = stream.next_logged().map_err(|source| RecordingError::Io { path: path.clone(), source })?;
            let Some((channel, logged_ns, payload)) = read else {
                order.finish(&mut |row| waiting.push(row));
                waiting.end();
                if *messages == 0 {
                    let why = skipped.reasons().first().map(|rows| format!("; the first: {}", rows.example)).unwrap_or_default();
                    let what = format!("expected messages of the map's topics with a time and channels, found none{why}");
                    return Err(RecordingError::Whole { path: path.clone(), what });
                }
                continue;
            };
            for topic in topics.iter().filter(|topic| topic.name == channel.topic) {
                let number = *messages + skipped.rows() + 1;
                let parsed: Result<Value, _> = serde_json::from_slice(payload);
                let sample = parsed.map_err(|_| SkipReason::Damaged).and_then(|message| {
                    let time_s = topic.time_s(&message, logged_ns)?;
                    let zero_s = *zero_s.get_or_insert(if time_s > EPOCH_S { libm::floor(time_s / DAY_S) * DAY_S } else { 0.0 });
                    topic.sample(&message, time_s - zero_s)
                });
                match sample {
                    Ok(sample) => {
                        *messages += 1;
                        order.push(number, &sample, &[], &mut |row| waiting.push(row));
                    }
                    Err(reason) => skipped.count(reason, number, || {
                        let shown =
                            String::from_utf8_lossy(payload.get(..payload.len().min(60)).unwrap_or_default()).into_owned();
                        format!("topic {}: found {}", quoted(&topic.name), quoted(&shown))
                    }),
                }
            }
        }
        Ok(self.waiting.next_row())
    }
}

/// Refuses a log without one of the topics, or with other messages than JSON on it.
fn refuse_missing(path: &Path, source: &mut File, topics: &[MappedTopic]) -> Result<(), RecordingError> {
    let whole = |what: String| RecordingError::Whole { path: path.into(), what };
    let mut stream = MessageStream::new(BufReader::new(source));
    let missing = |stream: &MessageStream<_>| {
        let there = |topic: &&MappedTopic| stream.channels().values().any(|channel| channel.topic == topic.name);
        topics.iter().find(|topic| !there(topic)).map(|topic| topic.name.clone())
    };
    while missing(&stream).is_some() && stream.messages() < LOOKED_AT {
        let read = stream.next().map_err(|source| RecordingError::Io { path: path.into(), source })?;
        if read.is_none() {
            break;
        }
    }
    if let Some(name) = missing(&stream) {
        let there: BTreeSet<String> = stream.channels().values().map(|channel| quoted(&channel.topic)).collect();
        let named: Vec<&str> = there.iter().map(String::as_str).take(TOPICS_NAMED).collect();
        let why = stream.shortfall().chunk_reason.as_ref().map(|why| format!(" ({why})")).unwrap_or_default();
        return Err(whole(format!("by the map, expected a topic {}, found {}{why}", quoted(&name), named.join(" "))));
    }
    let other = |topic: &MappedTopic| {
        stream.channels().values().find(|channel| channel.topic == topic.name && channel.encoding != "json")
    };
    match topics.iter().find_map(other) {
        Some(channel) => Err(whole(format!(
            "topic {}: expected messages in JSON, found {}; write them as JSON (of ROS 2: mcap convert, or a node), or export a table \
             (CSV) and map that",
            quoted(&channel.topic),
            quoted(&channel.encoding)
        ))),
        None => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fields_are_found_by_their_path() {
        let message: Value =
            serde_json::from_str(r#"{"a":{"b":[1,{"c":2}]},"x.y":3,"stamp":{"sec":5,"nanosec":500000000}}"#).unwrap();
        let number = |path: &str| field_of(&message, path).and_then(Value::as_f64);
        assert_eq!(
            (number("a.b[0]"), number("a.b[1].c"), number("a.b.1.c"), number("x.y")),
            (Some(1.0), Some(2.0), Some(2.0), Some(3.0))
        );
        assert_eq!((number("a.b[2]"), number("a.z"), number("")), (None, None, None));
        assert_eq!(stamp_s(field_of(&message, "stamp").unwrap(), DateOrder::Unknown), Some(5.5));
        assert_eq!(stamp_s(&Value::from("1970-01-02T00:00:01Z"), DateOrder::Unknown), Some(86_401.0));
    }
}
