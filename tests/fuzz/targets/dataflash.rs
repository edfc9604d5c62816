//! Dataflash logs: messages with their fields, channels, the file reader; written again with their own definitions.

use super::{Steps, bits, pieces, temporary};
use sideslip::io::telemetry::format::RecordingFormat;
use sideslip::io::telemetry::logs::dataflash::field::{DataflashType, DataflashValue};
use sideslip::io::telemetry::logs::dataflash::format::DataflashFormat;
use sideslip::io::telemetry::logs::dataflash::message::DataflashMessage;
use sideslip::io::telemetry::logs::dataflash::reader::DataflashReader;
use sideslip::io::telemetry::logs::dataflash::tally::DataflashTally;
use sideslip::io::telemetry::logs::encode::dataflash::{DataflashCell, DataflashWriter};
use sideslip::io::telemetry::logs::mapping::dataflash::DataflashMapping;
use sideslip::io::telemetry::logs::recording::{AutopilotLog, AutopilotRecording};
use std::path::Path;

pub(super) fn log(bytes: &[u8]) -> usize {
    let _ = RecordingFormat::of(bytes);
    let whole = read(bytes, std::iter::once(bytes));
    let cut = read(bytes, pieces(bytes));
    assert!(whole.tally == cut.tally, "pieces change what is found: {:?} {:?}", whole.tally, cut.tally);
    assert!(whole.messages == cut.messages && whole.rows == cut.rows, "pieces change the messages");
    let again = read(whole.written.bytes(), std::iter::once(whole.written.bytes()));
    assert_eq!((again.tally.garbage_bytes, again.tally.doubtful, again.tally.unreadable), (0, 0, 0), "written again");
    assert!(again.messages == whole.again, "what was written is read otherwise");
    as_file(bytes, AutopilotLog::Dataflash);
    whole.again.len()
}

/// Reads a log of an autopilot as a file.
pub(super) fn as_file(bytes: &[u8], log: AutopilotLog) {
    let Ok(mut recording) = AutopilotRecording::new(Path::new("fuzz"), temporary::file(bytes), log) else { return };
    let mut steps = Steps::of(bytes, 1);
    while let Ok(Some(row)) = recording.next_row() {
        steps.one();
        assert!(row.sample.time_s.is_finite());
    }
    let _ = recording.shortfall();
}

/// Type, name, and every value as it stands.
#[derive(Debug, PartialEq)]
struct Message {
    kind: u8,
    name: Box<str>,
    values: Vec<Value>,
}

#[derive(Debug, PartialEq)]
enum Value {
    Bits(u64),
    Text(Vec<u8>),
    Array(Vec<i16>),
}

struct Found {
    tally: DataflashTally,
    messages: Vec<Message>,
    /// Time, value.
    rows: Vec<u64>,
    written: DataflashWriter,
    /// Those messages that could be written.
    again: Vec<Message>,
}

fn read<'a>(bytes: &[u8], pieces: impl Iterator<Item = &'a [u8]>) -> Found {
    let (mut reader, mut mapping) = (DataflashReader::new(), DataflashMapping::new());
    let mut found = Found {
        tally: DataflashTally::default(),
        messages: Vec::new(),
        rows: Vec::new(),
        written: DataflashWriter::new(),
        again: Vec::new(),
    };
    let (mut defined, mut steps) = (vec![None; 256], Steps::of(bytes, 1));
    let mut message = |message: &DataflashMessage<'_>| {
        steps.one();
        mapping.map(message, |row| {
            assert!(row.value.is_finite(), "a row without a number");
            found.rows.extend([row.time_us, row.value.to_bits(), u64::from(row.restart), u64::from(row.instance)]);
        });
        let _ = (message.time_us(), message.instance());
        found.messages.push(owned(message));
        if write(message, &mut found.written, &mut defined).is_some() {
            found.again.push(owned(message));
        }
    };
    for mut piece in pieces {
        while !piece.is_empty() {
            piece = &piece[reader.take(piece)..];
            while let Some(found) = reader.next_message() {
                message(&found);
            }
        }
    }
    while let Some(found) = reader.last_message() {
        message(&found);
    }
    mapping.finish();
    let _ = mapping.tally();
    found.messages.retain(|message| !is_definition(&message.name));
    found.tally = reader.tally().clone();
    found
}

fn is_definition(name: &str) -> bool {
    matches!(name, "FMT" | "FMTU" | "UNIT" | "MULT")
}

fn owned(message: &DataflashMessage<'_>) -> Message {
    let value = |value: DataflashValue<'_>| match value {
        DataflashValue::Signed(number) => Value::Bits(number.cast_unsigned()),
        DataflashValue::Unsigned(number) => Value::Bits(number),
        DataflashValue::Single(number) => Value::Bits(bits([f64::from(number)])[0]),
        DataflashValue::Double(number) => Value::Bits(bits([number])[0]),
        text @ DataflashValue::Text(_) => Value::Text(text.text().unwrap().to_vec()),
        DataflashValue::Array(array) => Value::Array(array.iter().collect()),
    };
    Message {
        kind: message.format().kind,
        name: message.name().into(),
        values: message.fields().map(|field| value(field.value)).collect(),
    }
}

/// Writes a message, its definition before it where that is new; `None` where it is none that the writer can write.
fn write(message: &DataflashMessage<'_>, writer: &mut DataflashWriter, defined: &mut [Option<DataflashFormat>]) -> Option<()> {
    let format = message.format();
    let place = &mut defined[usize::from(format.kind)];
    if is_definition(message.name()) {
        return None;
    }
    let mut cells = Vec::new();
    for (field, reading) in format.fields.iter().zip(message.fields()) {
        let width = 8 * field.kind.size().min(8);
        cells.push(match reading.value {
            DataflashValue::Signed(number) => DataflashCell::Whole(number.cast_unsigned() & (u64::MAX >> (64 - width))),
            DataflashValue::Unsigned(number) => DataflashCell::Whole(number),
            DataflashValue::Single(number) => DataflashCell::Number(number.into()),
            DataflashValue::Double(number) => DataflashCell::Number(number),
            text @ DataflashValue::Text(_) => DataflashCell::Text(std::str::from_utf8(text.text()?).ok()?),
            DataflashValue::Array(array) => {
                let mut numbers = [0; 32];
                numbers.iter_mut().zip(array.iter()).for_each(|(to, from)| *to = from);
                DataflashCell::Array(numbers)
            }
        });
        // The writer cuts what half precision holds only as a number below its normal ones.
        let is_small = |number: f64| number != 0.0 && number.abs() < 6.2e-5;
        if field.kind == DataflashType::Half
            && reading.value.number().is_none_or(|number| !number.is_finite() || is_small(number))
        {
            return None;
        }
    }
    if !place.as_ref().is_some_and(|before| before.same_layout(format)) {
        writer.define(format.kind, &format.name, &format.characters, &format.columns).ok()?;
        *place = Some(format.clone());
    }
    let written = writer.message(format.kind, &cells);
    assert!(written.is_ok(), "{written:?}");
    Some(())
}
