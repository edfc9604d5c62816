//! Recorded logs, message by message against pymavlink's DFReader and pyulog, in pieces of any size.

use super::logs_expected::{DATAFLASH, DATAFLASH_ALL, INFORMATION, PARAMETERS, TEXT, ULOG, WRITTEN_DATAFLASH, WRITTEN_ULOG};
use crate::support::program::data;
use sideslip::io::telemetry::logs::dataflash::error::DataflashError;
use sideslip::io::telemetry::logs::dataflash::reader::DataflashReader;
use sideslip::io::telemetry::logs::dataflash::tally::{DataflashTally, DataflashTruncation};
use sideslip::io::telemetry::logs::encode::flight::SimulatedFlight;
use sideslip::io::telemetry::logs::ulog::message::UlogMessage;
use sideslip::io::telemetry::logs::ulog::reader::{UlogHeader, UlogReader};
use sideslip::io::telemetry::logs::ulog::tally::UlogTally;
use sideslip::io::telemetry::logs::ulog::value::UlogValue;
use std::collections::BTreeMap;

/// Bytes of a recording; `None`, said loudly, where it is absent.
fn recording(name: &str) -> Option<Vec<u8>> {
    data("logs", name).map(|file| std::fs::read(file).unwrap())
}

/// FNV-1a of 64 bits.
#[derive(Clone, Copy, PartialEq, Eq)]
struct Digest {
    count: u64,
    state: u64,
}

impl Default for Digest {
    fn default() -> Self {
        Digest { count: 0, state: 0xCBF2_9CE4_8422_2325 }
    }
}

impl Digest {
    fn take(&mut self, bytes: &[u8]) {
        for byte in bytes {
            self.state = (self.state ^ u64::from(*byte)).wrapping_mul(0x0100_0000_01B3);
        }
    }

    fn number(&mut self, value: f64) {
        let bits = if value.is_nan() { 0x7FF8_0000_0000_0000 } else { value.to_bits() };
        self.take(&bits.to_le_bytes());
    }

    fn text(&mut self, text: &[u8]) {
        self.take(text);
        self.take(&[0xFF]);
    }

    fn pair(&self) -> (u64, u64) {
        (self.count, self.state)
    }
}

/// Pieces of pseudo-random sizes from 1 to `longest` (a linear congruential generator).
fn pieces(bytes: &[u8], longest: u64, seed: u64) -> Vec<&[u8]> {
    let (mut rest, mut state, mut all) = (bytes, seed, Vec::new());
    while !rest.is_empty() {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        let length = usize::try_from((state >> 33) % longest + 1).unwrap().min(rest.len());
        all.push(&rest[..length]);
        rest = &rest[length..];
    }
    all
}

fn read_dataflash(bytes: &[u8], longest: u64) -> (Digest, BTreeMap<String, Digest>, DataflashTally) {
    let (mut every, mut kinds) = (Digest::default(), BTreeMap::<String, Digest>::new());
    let mut reader = DataflashReader::new();
    let mut one = |message: sideslip::io::telemetry::logs::dataflash::message::DataflashMessage<'_>| {
        let kind = kinds.entry(message.name().to_owned()).or_default();
        for digest in [&mut every, kind] {
            digest.count += 1;
            for (field, column) in message.fields().zip(&message.format().fields) {
                // pymavlink applies the scale of the format character, and no multiplier.
                match (field.value.number(), field.value.text()) {
                    (Some(number), _) => digest.number(column.implied.apply(number)),
                    (None, Some(text)) => digest.text(text),
                    _ => panic!("{}", field.name),
                }
            }
        }
    };
    for piece in pieces(bytes, longest, 7) {
        let mut piece = piece;
        while !piece.is_empty() {
            piece = &piece[reader.take(piece)..];
            while let Some(message) = reader.next_message() {
                one(message);
            }
        }
    }
    while let Some(message) = reader.last_message() {
        one(message);
    }
    let tally = reader.tally().clone();
    (every, kinds, tally)
}

#[test]
fn dataflash_agrees_message_for_message_with_pymavlink() {
    let Some(bytes) = recording("plane-3.8.2.BIN") else { return };
    let (every, kinds, tally) = read_dataflash(&bytes, 1 << 20);
    let found: Vec<_> = kinds.iter().map(|(name, digest)| (name.as_str(), digest.count, digest.state)).collect();
    assert_eq!(found, DATAFLASH);
    assert_eq!(every.pair(), DATAFLASH_ALL);
    // The file is cut within its last message.
    let truncated = DataflashTruncation { at: 65_512, kind: Some(141), name: "AHR2".into(), found: 24, expected: 45 };
    assert_eq!(tally.truncated, Some(truncated));
    assert_eq!((tally.messages, tally.garbage_bytes, tally.doubtful, tally.unreadable), (1731, 0, 0, 0));
    assert_eq!((tally.backward, tally.redefinitions, tally.unknown_types, tally.first_damage_at), (0, 0, 0, None));
    let wrong: Vec<_> = tally.complaints.iter().map(DataflashError::to_string).collect();
    assert_eq!(wrong, [""; 0]);
}

/// A simulated flight, 2 s at 250, 100 and 91 Hz.
fn simulated() -> SimulatedFlight {
    SimulatedFlight { duration_s: 2.0, imu_hz: 250.0, attitude_hz: 100.0, air_hz: 91.0 }
}

/// Leaves a log for the Python peers to read where `SIDESLIP_LOGS_OUT` names a folder.
fn leave(name: &str, bytes: &[u8]) {
    if let Some(folder) = std::env::var_os("SIDESLIP_LOGS_OUT") {
        std::fs::write(std::path::PathBuf::from(folder).join(name), bytes).unwrap();
    }
}

#[test]
fn pymavlink_finds_the_same_in_the_dataflash_log_that_is_written() {
    let bytes = simulated().dataflash().unwrap();
    leave("plane-3.8.2.BIN", &bytes);
    let (_, kinds, tally) = read_dataflash(&bytes, 1 << 20);
    let found: Vec<_> = kinds.iter().map(|(name, digest)| (name.as_str(), digest.count, digest.state)).collect();
    assert_eq!(found, WRITTEN_DATAFLASH);
    assert_eq!((tally.complaints_total, tally.garbage_bytes), (0, 0));
}

#[test]
fn pyulog_finds_the_same_in_the_ulog_that_is_written() {
    let bytes = simulated().ulog().unwrap();
    leave("sample_log_small.ulg", &bytes);
    let found = read_ulog(&bytes, 1 << 20);
    let topics: Vec<_> =
        found.topics.iter().map(|((name, id), digest)| (name.as_str(), *id, digest.count, digest.state)).collect();
    assert_eq!(topics, WRITTEN_ULOG);
    assert_eq!((found.tally.complaints_total, found.tally.garbage_bytes), (0, 0));
}

#[test]
fn dataflash_in_pieces_is_the_same() {
    let Some(bytes) = recording("plane-3.8.2.BIN") else { return };
    let whole = read_dataflash(&bytes, 1 << 20);
    for longest in [1, 2, 7, 100, 5000] {
        assert!(read_dataflash(&bytes, longest) == whole, "{longest}");
    }
}

#[derive(Default, PartialEq)]
struct UlogDigests {
    header: Option<(u8, u64)>,
    topics: BTreeMap<(String, u8), Digest>,
    parameters: Digest,
    text: Digest,
    information: Digest,
    tally: UlogTally,
}

impl UlogDigests {
    fn take(&mut self, message: UlogMessage<'_>) {
        match message {
            UlogMessage::Data(data) => {
                let topic = self.topics.entry((data.name().to_owned(), data.multi_id())).or_default();
                topic.count += 1;
                assert!(data.time_us().is_some());
                for value in data.fields().flat_map(|field| field.values.iter()) {
                    match value {
                        UlogValue::Single(number) => topic.number(number.into()),
                        UlogValue::Double(number) => topic.number(number),
                        UlogValue::Signed(number) => topic.take(&number.to_le_bytes()),
                        UlogValue::Unsigned(number) => topic.take(&number.to_le_bytes()),
                        UlogValue::Bool(byte) | UlogValue::Char(byte) => topic.take(&u64::from(byte).to_le_bytes()),
                    }
                }
            }
            UlogMessage::Parameter(keyed) => {
                self.parameters.count += 1;
                self.parameters.text(keyed.key.as_bytes());
                self.parameters.number(keyed.value().unwrap().number());
            }
            UlogMessage::Information(keyed) => {
                self.information.count += 1;
                self.information.text(keyed.key.as_bytes());
                match keyed.text() {
                    Some(text) => self.information.text(text.as_bytes()),
                    None => self.information.number(keyed.value().unwrap().number()),
                }
            }
            UlogMessage::Logged(line) => {
                self.text.count += 1;
                self.text.take(&line.time_us.to_le_bytes());
                self.text.text(line.bytes);
            }
            _ => {}
        }
    }
}

fn read_ulog(bytes: &[u8], longest: u64) -> UlogDigests {
    let mut reader = UlogReader::new();
    let mut digests = UlogDigests::default();
    for piece in pieces(bytes, longest, 11) {
        let mut piece = piece;
        while !piece.is_empty() {
            piece = &piece[reader.take(piece)..];
            while let Some(message) = reader.next_message().unwrap() {
                digests.take(message);
            }
        }
    }
    while let Some(message) = reader.last_message().unwrap() {
        digests.take(message);
    }
    digests.header = reader.header().map(|UlogHeader { version, start_us }| (version, start_us));
    digests.tally = reader.tally().clone();
    digests
}

#[test]
fn ulog_agrees_message_for_message_with_pyulog() {
    let Some(bytes) = recording("sample_log_small.ulg") else { return };
    let found = read_ulog(&bytes, 1 << 20);
    let topics: Vec<_> =
        found.topics.iter().map(|((name, id), digest)| (name.as_str(), *id, digest.count, digest.state)).collect();
    assert_eq!(topics, ULOG);
    let others = [found.parameters, found.text, found.information].map(|digest| digest.pair());
    assert_eq!(others, [PARAMETERS, TEXT, INFORMATION]);
    assert_eq!(found.header, Some((1, 20_309_082)));
    // Counted independently, header by header.
    let counts = b"DPMFAISLBO".map(|kind| found.tally.of(kind));
    assert_eq!(counts, [14_604, 980, 131, 82, 72, 14, 12, 3, 1, 1]);
    let mut expected = UlogTally { kinds: found.tally.kinds, dropouts: 1, dropout_ms: 30, ..UlogTally::default() };
    expected.complaints.clone_from(&found.tally.complaints);
    assert_eq!(found.tally, expected);
    assert_eq!(found.tally.complaints, []);
}

#[test]
fn ulog_in_pieces_is_the_same() {
    let Some(bytes) = recording("sample_log_small.ulg") else { return };
    let whole = read_ulog(&bytes, 1 << 20);
    for longest in [1, 3, 50, 4000, 200_000] {
        assert!(read_ulog(&bytes, longest) == whole, "{longest}");
    }
}
