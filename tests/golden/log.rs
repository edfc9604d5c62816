//! MCAP logs, read by the `mcap` crate alone: for each topic its schema, how many messages, a hash over all of them with their
//! times, and a few whole messages.

use super::digest::{sha256, spread};
use super::document::{Document, keys, worded};
use super::table::stretches;
use mcap::records::Record;
use serde_json::Value;
use std::collections::BTreeMap;
use std::fmt::Write;

/// Bytes for a whole message, for an entry of the metadata, and for the words of a topic.
const BUDGET: usize = 900;
const METADATA: usize = 1500;
const WORDS: usize = 1200;

/// What a topic holds.
#[derive(Default)]
struct Topic {
    head: String,
    /// Each message: times and numbers.
    numbers: Vec<String>,
    documents: Vec<(i128, Document)>,
    schema_words: Vec<(String, String)>,
}

/// What is compared of a message, apart from its topic.
#[derive(Clone, Copy)]
pub(crate) enum Whole {
    /// Hashes, and some messages in full.
    Some,
    /// Hashes, and the first and last message in full.
    Ends,
    /// Hashes only, where the recording's rows are not ours to pass on.
    None,
}

impl Whole {
    /// Places of the messages that are written in full.
    fn places(self, count: usize) -> Vec<usize> {
        match self {
            Whole::Some => spread(count, 2),
            Whole::Ends => spread(count, 1),
            Whole::None => Vec::new(),
        }
    }
}

fn without_date(text: &str) -> String {
    text.split_inclusive('\n').filter(|line| !line.starts_with("recorded_at = ")).collect()
}

fn document(bytes: &[u8]) -> Document {
    Document::new(&serde_json::from_slice::<Value>(bytes).unwrap())
}

/// A log as numbers and words. `tidied` makes a text independent of the place where it was written.
pub(crate) fn log(bytes: &[u8], whole: Whole, tidied: impl Fn(&str) -> String) -> (String, String) {
    let (mut numbers, mut words) = (String::new(), String::new());
    for record in mcap::read::LinearReader::new(bytes).unwrap() {
        if let Record::Metadata(found) = record.unwrap() {
            let _ = writeln!(numbers, "[metadata {}]", found.name);
            let _ = writeln!(words, "[metadata {}]", found.name);
            // The call and its files have their proof in `conformance::provenance`; a live link is dated by the clock of this
            // machine.
            for (key, value) in found.metadata.iter().filter(|(key, _)| !matches!(key.as_str(), "command_line" | "files")) {
                let value = without_date(&tidied(value));
                let (of_numbers, of_words) = match serde_json::from_str::<Value>(&value) {
                    Ok(parsed @ (Value::Array(_) | Value::Object(_))) => {
                        let found = Document::new(&parsed);
                        (found.numbers(METADATA), worded(&found.words, WORDS))
                    }
                    _ => keys(&value),
                };
                let parted = if value.contains('\n') || of_numbers.trim_end().contains('\n') { '\n' } else { ' ' };
                let _ = writeln!(numbers, "{key}:{parted}{}", of_numbers.trim_end());
                if !of_words.is_empty() {
                    let _ = writeln!(words, "{key}:{parted}{}", of_words.trim_end());
                }
            }
        }
    }
    let mut topics: BTreeMap<String, Topic> = BTreeMap::new();
    let mut begin = None;
    for message in mcap::MessageStream::new(bytes).unwrap() {
        let message = message.unwrap();
        let channel = &message.channel;
        let topic = topics.entry(channel.topic.clone()).or_default();
        if topic.head.is_empty() {
            let schema = channel.schema.as_ref().unwrap();
            let found = document(&schema.data);
            topic.head = format!(
                "schema = {} {} {}\nschema_sha256 = {}\nmetadata = {}, sha256 {}\n",
                schema.name,
                schema.encoding,
                channel.message_encoding,
                sha256(found.canonical()),
                channel.metadata.get("clock").map_or("", String::as_str),
                sha256(format!("{:?}", channel.metadata))
            );
            topic.schema_words = found.words;
        }
        let found = document(&message.data);
        // Of UTC what has passed since the first message.
        let is_utc = channel.metadata.get("clock").is_some_and(|clock| clock.starts_with("UTC"));
        let zero = if is_utc { *begin.get_or_insert(message.log_time) } else { 0 };
        let since = |time: u64| i128::from(time) - i128::from(zero);
        let (log_time, publish_time) = (since(message.log_time), since(message.publish_time));
        topic.numbers.push(format!("{log_time} {publish_time}\n{}", found.canonical()));
        topic.documents.push((log_time, found));
    }
    for (name, topic) in &topics {
        let _ = write!(numbers, "[{name}]\n{}", topic.head);
        let _ = writeln!(numbers, "messages = {}, sha256 {}", topic.numbers.len(), sha256(topic.numbers.concat()));
        numbers.push_str(&stretches(&topic.numbers, "messages"));
        for i in whole.places(topic.documents.len()) {
            let (time, document) = &topic.documents[i];
            let _ = write!(numbers, "[{name} message {i}, log time {time}]\n{}", document.numbers(BUDGET));
        }
        let _ = writeln!(words, "[{name}]\nschema: {} texts, sha256 {}", topic.schema_words.len(), {
            sha256(worded(&topic.schema_words, usize::MAX))
        });
        words.push_str(&said(&topic.documents));
    }
    (numbers, words)
}

/// The words of all messages: a hash, and each text once with how often it stands there.
fn said(documents: &[(i128, Document)]) -> String {
    let all: Vec<(String, String)> = documents
        .iter()
        .flat_map(|(time, document)| document.words.iter().map(move |(path, text)| (format!("{time} {path}"), text.clone())))
        .collect();
    if all.is_empty() {
        return String::new();
    }
    let mut times: BTreeMap<&str, usize> = BTreeMap::new();
    let mut distinct = Vec::new();
    for (path, text) in &all {
        let count = times.entry(text).or_default();
        *count += 1;
        if *count == 1 {
            distinct.push((path.clone(), text.clone()));
        }
    }
    let counted: Vec<(String, String)> =
        distinct.into_iter().map(|(path, text)| (format!("{} times, first {path}", times[text.as_str()]), text)).collect();
    format!("messages: {} texts, sha256 {}\n{}", all.len(), sha256(worded(&all, usize::MAX)), worded(&counted, WORDS))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A log of two topics; `altered` is put in place of the 40th value of one, `late` is added to a time of the other.
    fn written(altered: f64, late: u64, why: &str) -> (String, String) {
        let mut writer = mcap::Writer::new(std::io::Cursor::new(Vec::new())).unwrap();
        let schema = writer.add_schema("sideslip.Test", "jsonschema", br#"{"type":"object","description":"a test"}"#).unwrap();
        let channels = ["/a", "/b"].map(|topic| writer.add_channel(schema, topic, "json", &BTreeMap::new()).unwrap());
        for k in 0..50_u32 {
            let header = |channel, late: u64| {
                let time = u64::from(k) * 1_000_000 + late;
                mcap::records::MessageHeader { channel_id: channel, sequence: k, log_time: time, publish_time: time }
            };
            let value = if k == 40 { altered } else { 0.5 };
            let sentence = if k == 40 { why } else { "as it was" };
            let of_a = serde_json::json!({"x": value, "series": vec![value; 20], "why": sentence}).to_string();
            writer.write_to_known_channel(&header(channels[0], 0), of_a.as_bytes()).unwrap();
            let late = if k == 20 { late } else { 0 };
            writer.write_to_known_channel(&header(channels[1], late), b"{\"y\":1}").unwrap();
        }
        writer.finish().unwrap();
        let bytes = writer.into_inner().into_inner();
        log(&bytes, Whole::Ends, str::to_owned)
    }

    #[test]
    fn one_altered_message_in_the_middle_shows_where_it_belongs() {
        let before = written(0.5, 0, "as it was");
        assert_eq!(written(0.5, 0, "as it was"), before);
        let (numbers, words) = written(0.500_000_000_000_000_1, 0, "as it was");
        assert!(numbers != before.0 && words == before.1);
        let lines = |text: &str| text.lines().map(str::to_owned).collect::<Vec<_>>();
        let apart: Vec<String> =
            lines(&numbers).into_iter().zip(lines(&before.0)).filter(|(a, b)| a != b).map(|(line, _)| line).collect();
        assert!(apart.len() == 2 && apart[1].starts_with("messages 35 to 41 ="), "{apart:?}");
        let (numbers, words) = written(0.5, 1, "as it was");
        assert!(numbers != before.0 && words == before.1, "a time");
        let (numbers, words) = written(0.5, 0, "as it is");
        assert!(numbers == before.0 && words != before.1, "a word");
    }
}
