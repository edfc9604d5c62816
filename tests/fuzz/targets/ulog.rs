//! ULogs: messages with their fields, channels, the file reader; written again with their own definitions.

use super::{Steps, bits, dataflash, pieces};
use sideslip::io::telemetry::format::RecordingFormat;
use sideslip::io::telemetry::logs::encode::ulog::UlogWriter;
use sideslip::io::telemetry::logs::mapping::ulog::UlogMapping;
use sideslip::io::telemetry::logs::recording::AutopilotLog;
use sideslip::io::telemetry::logs::ulog::definition::{UlogFieldType, UlogFormat};
use sideslip::io::telemetry::logs::ulog::message::{UlogData, UlogMessage};
use sideslip::io::telemetry::logs::ulog::reader::UlogReader;
use sideslip::io::telemetry::logs::ulog::tally::UlogTally;
use sideslip::io::telemetry::logs::ulog::value::{UlogType, UlogValue};

pub(super) fn log(bytes: &[u8]) -> usize {
    let _ = RecordingFormat::of(bytes);
    let whole = read(bytes, std::iter::once(bytes));
    let cut = read(bytes, pieces(bytes));
    assert!(whole.tally == cut.tally, "pieces change what is found: {:?} {:?}", whole.tally, cut.tally);
    assert!(whole.data == cut.data && whole.rows == cut.rows && whole.refused == cut.refused, "pieces change the messages");
    if let Some(writer) = &whole.written {
        let again = read(writer.bytes(), std::iter::once(writer.bytes()));
        let tally = &again.tally;
        assert_eq!((tally.garbage_bytes, tally.doubtful, tally.wrong_size, tally.refused), (0, 0, 0, 0), "written again");
        assert!(again.data == whole.data, "what was written is read otherwise");
    }
    dataflash::as_file(bytes, AutopilotLog::Ulog);
    whole.data.len()
}

/// Data of a topic: what it is, when, and every value.
#[derive(Debug, PartialEq)]
struct Data {
    name: String,
    id: u16,
    multi_id: u8,
    time_us: Option<u64>,
    values: Vec<u64>,
}

struct Found {
    tally: UlogTally,
    data: Vec<Data>,
    /// Time, value.
    rows: Vec<u64>,
    refused: Option<String>,
    written: Option<UlogWriter>,
}

fn read<'a>(bytes: &[u8], pieces: impl Iterator<Item = &'a [u8]>) -> Found {
    let (mut reader, mut mapping) = (UlogReader::new(), UlogMapping::new());
    let mut found = Found { tally: UlogTally::default(), data: Vec::new(), rows: Vec::new(), refused: None, written: None };
    let mut steps = Steps::of(bytes, 1);
    let start_us = bytes.get(8..16).and_then(<[u8]>::first_chunk).map_or(0, |start| u64::from_le_bytes(*start));
    let mut pieces = pieces;
    let (mut piece, mut ended): (&[u8], bool) = (&[], false);
    loop {
        match if ended { reader.last_message() } else { reader.next_message() } {
            Err(error) => {
                found.refused = Some(error.to_string());
                break;
            }
            Ok(Some(message)) => {
                steps.one();
                if let UlogMessage::Data(data) = &message {
                    found.data.push(owned(data));
                    mapping.map(data, |row| {
                        assert!(row.value.is_finite(), "a row without a number");
                        found.rows.extend([row.time_us, row.value.to_bits(), u64::from(row.restart), u64::from(row.instance)]);
                    });
                }
                write(&message, found.written.get_or_insert_with(|| UlogWriter::new(start_us)));
            }
            Ok(None) if ended => break,
            Ok(None) => {
                if piece.is_empty() {
                    match pieces.next() {
                        Some(next) => piece = next,
                        None => ended = true,
                    }
                }
                piece = &piece[reader.take(piece)..];
            }
        }
    }
    mapping.finish();
    let _ = mapping.tally();
    found.tally = reader.tally().clone();
    found
}

fn owned(data: &UlogData<'_>) -> Data {
    Data {
        name: data.name().to_owned(),
        id: data.subscription().id,
        multi_id: data.multi_id(),
        time_us: data.time_us(),
        values: data.fields().flat_map(|field| bits(field.values.iter().map(UlogValue::number))).collect(),
    }
}

fn write(message: &UlogMessage<'_>, writer: &mut UlogWriter) {
    let written = match message {
        UlogMessage::Format(format) => writer.format(&text(format)),
        UlogMessage::Subscription(one) => writer.subscribe(one.multi_id, one.id, &one.name),
        UlogMessage::Removed { id } => writer.message(b'R', &[&id.to_le_bytes()]),
        UlogMessage::Data(data) => writer.data(data.subscription().id, &[&payload(data)]),
        UlogMessage::Information(keyed) => writer.keyed(b'I', &format!("{} {}", keyed.kind, keyed.key), keyed.bytes),
        UlogMessage::Parameter(keyed) => writer.keyed(b'P', &format!("{} {}", keyed.kind, keyed.key), keyed.bytes),
        UlogMessage::Dropout { duration_ms } => {
            writer.dropout(*duration_ms);
            Ok(())
        }
        UlogMessage::Sync => {
            writer.sync();
            Ok(())
        }
        UlogMessage::Flags { .. }
        | UlogMessage::MultiInformation { .. }
        | UlogMessage::DefaultParameter { .. }
        | UlogMessage::Logged(_) => Ok(()),
    };
    assert!(written.is_ok(), "{written:?}");
}

fn text(format: &UlogFormat) -> String {
    let mut text = format!("{}:", format.name);
    for field in &format.fields {
        let kind = match &field.kind {
            UlogFieldType::Basic(kind) => name(*kind),
            UlogFieldType::Format(name) => name,
        };
        let array = field.array.map(|length| format!("[{length}]")).unwrap_or_default();
        text.push_str(&format!("{kind}{array} {};", field.name));
    }
    text
}

fn name(kind: UlogType) -> &'static str {
    match kind {
        UlogType::Int8 => "int8_t",
        UlogType::UInt8 => "uint8_t",
        UlogType::Int16 => "int16_t",
        UlogType::UInt16 => "uint16_t",
        UlogType::Int32 => "int32_t",
        UlogType::UInt32 => "uint32_t",
        UlogType::Int64 => "int64_t",
        UlogType::UInt64 => "uint64_t",
        UlogType::Float => "float",
        UlogType::Double => "double",
        UlogType::Bool => "bool",
        UlogType::Char => "char",
    }
}

/// The bytes of the data, without the padding that may be left out.
fn payload(data: &UlogData<'_>) -> Vec<u8> {
    let layout = data.layout();
    let mut bytes = vec![0; layout.least];
    let shown = layout.leaves.iter().filter(|leaf| !leaf.padding);
    for (leaf, field) in shown.zip(data.fields()) {
        let place = &mut bytes[leaf.offset..leaf.offset + leaf.size()];
        for (place, value) in place.chunks_mut(leaf.kind.size()).zip(field.values.iter()) {
            let size = place.len();
            let raw = match value {
                UlogValue::Signed(number) => number.cast_unsigned(),
                UlogValue::Unsigned(number) => number,
                UlogValue::Single(number) => number.to_bits().into(),
                UlogValue::Double(number) => number.to_bits(),
                UlogValue::Bool(byte) | UlogValue::Char(byte) => byte.into(),
            };
            place.copy_from_slice(&raw.to_le_bytes()[..size]);
        }
    }
    bytes
}
