//! Reads a log of this program as a recording: its head, its samples, the values of its unknown columns.
//!
//! Samples come in the order of the file with the bits that were logged. A null is a value that was no number and
//! comes back as NaN. A file that was cut off gives every whole sample, and [`SampleReader::losses`] says where it ended:
//! that is data lost, not an error. An MCAP file of someone else is refused with the topics that it has.

use super::mcap_stream::MessageStream;
use crate::flight::channel::Channel;
use crate::flight::file::log_head::{ColumnTarget, LogHead, LogHeadError, RUN_METADATA};
use crate::flight::sample::Sample;
use serde::de::{DeserializeSeed, Deserializer, Error as _, IgnoredAny, MapAccess, Visitor};
use std::collections::HashMap;
use std::fmt;
use std::io::{self, BufReader, Read, Seek, SeekFrom};

/// The topic of the samples.
pub const SAMPLE_TOPIC: &str = "/sample";

/// Topics that an error names; of more it says how many.
const TOPICS_NAMED: usize = 12;

/// Why a file cannot be read as a log.
#[derive(Debug, thiserror::Error)]
#[expect(missing_docs, reason = "the message of each says what its fields are")]
pub enum LogReadError {
    #[error("{0}")]
    Io(#[from] io::Error),
    #[error("expected an MCAP file, found something else")]
    NotMcap,
    #[error(
        "expected a log of sideslip with the topic {SAMPLE_TOPIC} and a metadata record `{RUN_METADATA}`, found {0}; \
         topics of another program are read by a map with [[topic]] (--map)"
    )]
    Foreign(String),
    #[error("metadata record `{RUN_METADATA}`: {0}")]
    Head(#[from] LogHeadError),
}

/// What a log did not give.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct LogLosses {
    /// Samples read.
    pub samples: u64,
    /// Messages read, of every topic.
    pub messages: u64,
    /// Why reading stopped before the file's proper end.
    pub stopped: Option<String>,
    /// Parts of the file that did not match their checksum or their own lengths, and the first reason.
    pub damaged: Option<(u64, String)>,
    /// Messages of channels that the file does not introduce.
    pub orphans: u64,
    /// Samples that could not be understood, and what was wrong with the first.
    pub malformed: Option<(u64, String)>,
}

impl LogLosses {
    /// Whether everything in the file was read.
    pub fn is_none(&self) -> bool {
        self.stopped.is_none() && self.damaged.is_none() && self.orphans == 0 && self.malformed.is_none()
    }
}

impl fmt::Display for LogLosses {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut first = true;
        let mut clause = |f: &mut fmt::Formatter<'_>, text: fmt::Arguments<'_>| {
            let gap = if std::mem::take(&mut first) { "" } else { "; " };
            write!(f, "{gap}{text}")
        };
        if let Some(why) = &self.stopped {
            let LogLosses { messages, samples, .. } = self;
            clause(f, format_args!("truncated after {messages} messages ({samples} samples): {why}"))?;
        }
        if let Some((count, why)) = &self.damaged {
            clause(f, format_args!("{count} damaged parts were skipped ({why})"))?;
        }
        if self.orphans > 0 {
            clause(f, format_args!("{} messages belong to no channel of the file", self.orphans))?;
        }
        if let Some((count, why)) = &self.malformed {
            clause(f, format_args!("{count} samples could not be understood ({why})"))?;
        }
        Ok(())
    }
}

/// A sample with the values of its unknown columns, `None` where not sampled.
pub type SampleWithOthers<'a> = (Sample, &'a [Option<f64>]);

/// Reads the samples of a log, one after another.
pub struct SampleReader<R> {
    stream: MessageStream<BufReader<R>>,
    head: LogHead,
    columns: HashMap<String, ColumnTarget>,
    unknown: Vec<Option<f64>>,
    samples: u64,
    malformed: Option<(u64, String)>,
}

impl<R: Read + Seek> SampleReader<R> {
    /// Opens a log: finds its head, wherever it stands, and goes back to the first sample.
    ///
    /// # Errors
    /// [`LogReadError`] where reading fails, or the file is no log of this program.
    pub fn open(mut source: R) -> Result<Self, LogReadError> {
        let mut stream = MessageStream::new(BufReader::new(&mut source));
        let Some(texts) = stream.find_metadata(RUN_METADATA)? else {
            return Err(if stream.is_mcap() { LogReadError::Foreign(content(&stream)) } else { LogReadError::NotMcap });
        };
        drop(stream);
        let head = LogHead::from_metadata(&texts)?;
        source.seek(SeekFrom::Start(0))?;
        let names = head.channels.iter().map(|(name, _)| name.clone());
        Ok(SampleReader {
            stream: MessageStream::new(BufReader::new(source)),
            columns: names.zip(head.targets()).collect(),
            unknown: vec![None; head.unknown_columns()],
            head,
            samples: 0,
            malformed: None,
        })
    }
}

impl<R: Read> SampleReader<R> {
    /// The head of the log.
    pub fn head(&self) -> &LogHead {
        &self.head
    }

    /// The next sample with the values of its unknown columns (`None` where not sampled); `None` at the end of what can
    /// be read.
    ///
    /// # Errors
    /// Where reading the source fails; what is wrong with the bytes goes to [`SampleReader::losses`].
    pub fn next_sample(&mut self) -> io::Result<Option<SampleWithOthers<'_>>> {
        let sample = loop {
            let Some((channel, payload)) = self.stream.next()? else { return Ok(None) };
            if channel.topic != SAMPLE_TOPIC {
                continue;
            }
            self.unknown.fill(None);
            let seed = SampleSeed { columns: &self.columns, unknown: &mut self.unknown };
            let parsed = match channel.encoding.as_str() {
                "json" => {
                    let mut json = serde_json::Deserializer::from_slice(payload);
                    seed.deserialize(&mut json).and_then(|sample| json.end().map(|()| sample)).map_err(|error| error.to_string())
                }
                other => Err(format!("expected the encoding json, found `{}`", other.chars().take(20).collect::<String>())),
            };
            match parsed {
                Ok(sample) => break sample,
                Err(reason) => match &mut self.malformed {
                    Some((count, _)) => *count += 1,
                    None => self.malformed = Some((1, reason)),
                },
            }
        };
        self.samples += 1;
        Ok(Some((sample, &self.unknown)))
    }

    /// Samples that could not be understood so far, and what was wrong with the first.
    pub fn malformed(&self) -> Option<&(u64, String)> {
        self.malformed.as_ref()
    }

    /// What could not be read so far; complete once [`SampleReader::next_sample`] has given `None`.
    pub fn losses(&self) -> LogLosses {
        let shortfall = self.stream.shortfall();
        LogLosses {
            samples: self.samples,
            messages: self.stream.messages(),
            stopped: shortfall.stopped.clone(),
            damaged: (shortfall.damaged_chunks > 0)
                .then(|| (shortfall.damaged_chunks, shortfall.chunk_reason.clone().unwrap_or_default())),
            orphans: shortfall.orphans,
            malformed: self.malformed.clone(),
        }
    }
}

/// What a file without our head holds, in words.
fn content<R: Read>(stream: &MessageStream<R>) -> String {
    let mut topics: Vec<&str> = stream.channels().values().map(|channel| channel.topic.as_str()).collect();
    topics.sort_unstable();
    topics.dedup();
    let mut words = if topics.is_empty() { "no topic".to_owned() } else { "the topics ".to_owned() };
    for (place, topic) in topics.iter().take(TOPICS_NAMED).enumerate() {
        let shown: String = topic.chars().take(60).flat_map(char::escape_debug).collect();
        words.push_str(if place == 0 { "" } else { ", " });
        words.push_str(&shown);
    }
    if topics.len() > TOPICS_NAMED {
        words.push_str(&format!(" and {} more", topics.len() - TOPICS_NAMED));
    }
    let shortfall = stream.shortfall();
    for reason in [&shortfall.stopped, &shortfall.chunk_reason].into_iter().flatten() {
        words.push_str("; ");
        words.push_str(reason);
    }
    words
}

/// Puts the fields of a sample's JSON where the head says.
struct SampleSeed<'a> {
    columns: &'a HashMap<String, ColumnTarget>,
    unknown: &'a mut [Option<f64>],
}

impl<'de> DeserializeSeed<'de> for SampleSeed<'_> {
    type Value = Sample;

    fn deserialize<D: Deserializer<'de>>(self, deserializer: D) -> Result<Sample, D::Error> {
        deserializer.deserialize_map(self)
    }
}

impl<'de> Visitor<'de> for SampleSeed<'_> {
    type Value = Sample;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a sample, an object with the field `time`")
    }

    fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<Sample, A::Error> {
        let mut sample = Sample::new(f64::NAN);
        let mut timed = false;
        while let Some(name) = map.next_key::<std::borrow::Cow<'de, str>>()? {
            let target = match self.columns.get(name.as_ref()) {
                Some(target) => Some(*target),
                None => Channel::from_name(&name).map(|(channel, _)| ColumnTarget::Known(channel)),
            };
            match target {
                _ if name == "time" => {
                    sample.time_s = map.next_value::<NumberOrNull>()?.0;
                    timed = true;
                }
                Some(ColumnTarget::Known(channel)) => sample.set(channel, map.next_value::<NumberOrNull>()?.0),
                Some(ColumnTarget::Unknown(place)) => {
                    let value = map.next_value::<NumberOrNull>()?.0;
                    if let Some(slot) = self.unknown.get_mut(place) {
                        *slot = Some(value);
                    }
                }
                None => drop(map.next_value::<IgnoredAny>()?),
            }
        }
        if timed { Ok(sample) } else { Err(A::Error::missing_field("time")) }
    }
}

/// A number, or NaN for null.
struct NumberOrNull(f64);

impl<'de> serde::Deserialize<'de> for NumberOrNull {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let number: Option<f64> = serde::Deserialize::deserialize(deserializer)?;
        Ok(NumberOrNull(number.unwrap_or(f64::NAN)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::Cursor;

    #[test]
    fn what_is_no_mcap_file_is_said_to_be_none() {
        for bytes in [&b""[..], b"time,p\n0,1\n", b"\x89MCAP1\r\n", b"\x89MCAP0\r", &[0; 500]] {
            let error = SampleReader::open(Cursor::new(bytes)).map(|_| ()).unwrap_err();
            assert!(matches!(error, LogReadError::NotMcap), "{error}");
        }
    }

    #[test]
    fn a_file_of_someone_else_is_refused_with_its_topics() {
        let mut file = Cursor::new(Vec::new());
        let mut writer = mcap::WriteOptions::new().compression(None).create(&mut file).unwrap();
        for topic in ["/imu", "/gps"] {
            writer.add_channel(0, topic, "json", &Default::default()).unwrap();
        }
        writer.finish().unwrap();
        drop(writer);
        file.set_position(0);
        let error = SampleReader::open(file).map(|_| ()).unwrap_err();
        assert!(error.to_string().contains("found the topics /gps, /imu"), "{error}");
    }
}
