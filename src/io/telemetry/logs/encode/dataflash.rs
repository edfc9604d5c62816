//! Writes dataflash logs: definitions, units, messages.
//!
//! Consumes formats and values in the units of the log (degrees where its format says so); a number is divided by the scale of
//! its format character and rounded to the nearest integer where the field holds one. Produces bytes that begin with the FMT
//! of FMT.

use super::super::dataflash::field::{DataflashScale, DataflashType};
use super::super::dataflash::format::{DataflashField, DataflashFormat, FMT_LENGTH, FMT_TYPE};
use super::LogEncodeError;

const FMTU: u8 = 0xF0;
const UNIT: u8 = 0xF1;
const MULT: u8 = 0xF2;

/// One value of a message.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum DataflashCell<'a> {
    /// A number as it is meant: the scale of its format character is applied.
    Number(f64),
    /// An integer as it stands in the log.
    Whole(u64),
    /// Text.
    Text(&'a str),
    /// 32 integers.
    Array([i16; 32]),
}

/// Writes a log.
#[derive(Clone, Debug)]
pub struct DataflashWriter {
    bytes: Vec<u8>,
    formats: Vec<Option<DataflashFormat>>,
}

impl Default for DataflashWriter {
    fn default() -> Self {
        DataflashWriter::new()
    }
}

fn padded(text: &str, size: usize) -> Option<Vec<u8>> {
    let mut bytes = text.as_bytes().to_vec();
    (bytes.len() <= size).then(|| {
        bytes.resize(size, 0);
        bytes
    })
}

impl DataflashWriter {
    /// A log with the definition of FMT alone.
    pub fn new() -> Self {
        let mut writer = DataflashWriter { bytes: Vec::new(), formats: vec![None; 256] };
        // Its own definition is right, so nothing can be refused.
        let _ = writer.define(FMT_TYPE, "FMT", "BBnNZ", "Type,Length,Name,Format,Columns");
        writer
    }

    /// Writes an FMT.
    ///
    /// # Errors
    /// [`LogEncodeError::Definition`] where a text is too long, or the format contradicts itself.
    pub fn define(&mut self, kind: u8, name: &str, characters: &str, columns: &str) -> Result<(), LogEncodeError> {
        let wrong = |what: &str| LogEncodeError::Definition { kind, what: what.into() };
        let size = characters.bytes().map(|c| DataflashType::of(c).map(|(kind, _)| kind.size())).sum::<Option<usize>>();
        let length = size.and_then(|size| u8::try_from(size + 3).ok()).ok_or_else(|| wrong("its length"))?;
        let mut body = vec![kind, length];
        for (text, size) in [(name, 4), (characters, 16), (columns, 64)] {
            body.extend(padded(text, size).ok_or_else(|| wrong("a text that is too long"))?);
        }
        let (format, warning) = DataflashFormat::parse(&body, 0).map_err(|error| wrong(&error.to_string()))?;
        if let Some(warning) = warning {
            return Err(wrong(&warning.to_string()));
        }
        self.raw(FMT_TYPE, &body);
        if let Some(place) = self.formats.get_mut(usize::from(kind)) {
            *place = Some(format);
        }
        Ok(())
    }

    /// Writes the tables of units and multipliers, with their own definitions (types 240 to 242).
    ///
    /// # Errors
    /// As [`define`](Self::define).
    pub fn tables(&mut self, labels: &[(char, &str)], multipliers: &[(char, f64)]) -> Result<(), LogEncodeError> {
        self.define(FMTU, "FMTU", "QBNN", "TimeUS,FmtType,UnitIds,MultIds")?;
        self.define(UNIT, "UNIT", "QbZ", "TimeUS,Id,Label")?;
        self.define(MULT, "MULT", "Qbd", "TimeUS,Id,Mult")?;
        let id = |c: char| DataflashCell::Number(u32::from(c).into());
        for (c, label) in labels {
            self.message(UNIT, &[DataflashCell::Whole(0), id(*c), DataflashCell::Text(label)])?;
        }
        for (c, multiplier) in multipliers {
            self.message(MULT, &[DataflashCell::Whole(0), id(*c), DataflashCell::Number(*multiplier)])?;
        }
        Ok(())
    }

    /// Writes the units and multipliers of a type, a letter for each column.
    ///
    /// # Errors
    /// As [`message`](Self::message).
    pub fn units(&mut self, kind: u8, units: &str, multipliers: &str) -> Result<(), LogEncodeError> {
        let cells = [DataflashCell::Whole(0), DataflashCell::Whole(kind.into()), DataflashCell::Text(units)];
        let [time, kind, units] = cells;
        self.message(FMTU, &[time, kind, units, DataflashCell::Text(multipliers)])
    }

    /// Writes a message.
    ///
    /// # Errors
    /// [`LogEncodeError`] where the type was not defined, or a value does not fit its column.
    pub fn message(&mut self, kind: u8, cells: &[DataflashCell<'_>]) -> Result<(), LogEncodeError> {
        let format = self.formats.get(usize::from(kind)).and_then(Option::as_ref);
        let format = format.ok_or(LogEncodeError::NotDefined { kind })?;
        let (name, expected, found) = (format.name.to_string(), format.fields.len(), cells.len());
        if expected != found {
            return Err(LogEncodeError::Count { name, expected, found });
        }
        let mut body = Vec::with_capacity(usize::from(format.length));
        for (field, cell) in format.fields.iter().zip(cells) {
            let bytes = cell_bytes(field, cell);
            body.extend(bytes.ok_or_else(|| LogEncodeError::Value {
                name: name.clone(),
                field: field.name.to_string(),
                value: format!("{cell:?}"),
            })?);
        }
        self.raw(kind, &body);
        Ok(())
    }

    /// Writes a header and whatever bytes behind it.
    pub fn raw(&mut self, kind: u8, body: &[u8]) {
        self.bytes.extend([0xA3, 0x95, kind]);
        self.bytes.extend(body);
    }

    /// Writes bytes that are no message.
    pub fn garbage(&mut self, bytes: &[u8]) {
        self.bytes.extend(bytes);
    }

    /// What was written.
    pub fn bytes(&self) -> &[u8] {
        &self.bytes
    }
}

/// The integer nearest to a number, where it is one of that type.
fn whole<T: TryFrom<i128>>(number: f64) -> Option<T> {
    let rounded = libm::round(number);
    #[expect(clippy::cast_possible_truncation, reason = "2^100 is far inside of 128 bits")]
    let integer = (libm::fabs(rounded) < libm::exp2(100.0)).then_some(rounded as i128)?;
    T::try_from(integer).ok()
}

fn cell_bytes(field: &DataflashField, cell: &DataflashCell<'_>) -> Option<Vec<u8>> {
    let number = match cell {
        DataflashCell::Text(text) => match field.kind {
            DataflashType::Text(size) => return padded(text, usize::from(size)),
            _ => return None,
        },
        DataflashCell::Array(array) => {
            let array = (field.kind == DataflashType::Array).then_some(array)?;
            return Some(array.iter().flat_map(|number| number.to_le_bytes()).collect());
        }
        DataflashCell::Whole(integer) => {
            let bytes = integer.to_le_bytes();
            let (low, high) = bytes.split_at_checked(field.kind.size())?;
            let of_integer = !matches!(
                field.kind,
                DataflashType::Half | DataflashType::Single | DataflashType::Double | DataflashType::Text(_)
            );
            return (of_integer && high.iter().all(|byte| *byte == 0)).then(|| low.to_vec());
        }
        DataflashCell::Number(number) => match field.implied {
            DataflashScale::Times(factor) => number / factor,
            DataflashScale::Over(divisor) => number * divisor,
        },
    };
    #[expect(clippy::cast_possible_truncation, reason = "the nearest single-precision number is meant")]
    let single = number as f32;
    Some(match field.kind {
        DataflashType::Signed8 => whole::<i8>(number)?.to_le_bytes().to_vec(),
        DataflashType::Unsigned8 => whole::<u8>(number)?.to_le_bytes().to_vec(),
        DataflashType::Signed16 => whole::<i16>(number)?.to_le_bytes().to_vec(),
        DataflashType::Unsigned16 => whole::<u16>(number)?.to_le_bytes().to_vec(),
        DataflashType::Signed32 => whole::<i32>(number)?.to_le_bytes().to_vec(),
        DataflashType::Unsigned32 => whole::<u32>(number)?.to_le_bytes().to_vec(),
        DataflashType::Signed64 => whole::<i64>(number)?.to_le_bytes().to_vec(),
        DataflashType::Unsigned64 => whole::<u64>(number)?.to_le_bytes().to_vec(),
        DataflashType::Half => half_bits(single)?.to_le_bytes().to_vec(),
        DataflashType::Single => single.to_le_bytes().to_vec(),
        DataflashType::Double => number.to_le_bytes().to_vec(),
        DataflashType::Text(_) | DataflashType::Array => return None,
    })
}

/// Half precision, of numbers that it holds as normal ones; the fraction is cut, not rounded.
fn half_bits(number: f32) -> Option<u16> {
    let bits = number.to_bits();
    let sign = u16::try_from(bits >> 31).ok()? << 15;
    if number.abs() < f32::MIN_POSITIVE {
        return Some(sign);
    }
    let exponent = (bits >> 23 & 0xFF).checked_sub(112).filter(|exponent| (1..31).contains(exponent))?;
    let rest = u16::try_from(exponent << 10 | (bits >> 13 & 0x3FF)).ok()?;
    Some(sign | rest)
}

const _: () = assert!(FMT_LENGTH == 3 + 2 + 4 + 16 + 64, "the body of an FMT");

#[cfg(test)]
mod tests {
    use super::super::super::dataflash::field::DataflashValue;
    use super::super::super::dataflash::reader::DataflashReader;
    use super::*;

    #[test]
    fn every_format_character_comes_back() {
        let mut writer = DataflashWriter::new();
        writer.define(1, "ALL", "abBhHiIfdnNcCe", "a,b,B,h,H,i,I,f,d,n,N,c,C,e").unwrap();
        writer.define(2, "MORE", "ELMqQgZ", "E,L,M,q,Q,g,Z").unwrap();
        let number = DataflashCell::Number;
        let array: [i16; 32] = std::array::from_fn(|i| i as i16 * -1000);
        let all = [
            DataflashCell::Array(array),
            number(-128.0),
            number(255.0),
            number(-32768.0),
            number(65535.0),
            number(-2e9),
            number(4e9),
            number(0.5),
            number(0.1),
            DataflashCell::Text("four"),
            DataflashCell::Text("sixteen bytes 16"),
            number(-327.68),
            number(655.35),
            number(-2e7),
        ];
        writer.message(1, &all).unwrap();
        let more = [
            number(4e7),
            number(-35.362_627_7),
            number(3.0),
            number(-9e15),
            DataflashCell::Whole(u64::MAX),
            number(-1.5),
            DataflashCell::Text("text"),
        ];
        writer.message(2, &more).unwrap();
        let mut reader = DataflashReader::new();
        assert_eq!(reader.take(writer.bytes()), writer.bytes().len());
        let mut cells = all.iter().chain(&more);
        let mut fields = 0;
        while let Some(message) = reader.last_message() {
            if message.name() == "FMT" {
                continue;
            }
            for field in message.fields() {
                fields += 1;
                match (cells.next().unwrap(), field.value) {
                    (DataflashCell::Number(number), _) => assert_eq!(field.scaled, Some(*number), "{}", field.name),
                    (DataflashCell::Whole(number), value) => assert_eq!(value, DataflashValue::Unsigned(*number)),
                    (DataflashCell::Text(text), value) => assert_eq!(value.text(), Some(text.as_bytes())),
                    (DataflashCell::Array(array), DataflashValue::Array(found)) => {
                        assert!(found.iter().eq(array.iter().copied()))
                    }
                    other => panic!("{other:?}"),
                }
            }
        }
        assert_eq!((fields, reader.tally().messages, reader.tally().complaints_total), (21, 5, 0));
    }

    #[test]
    fn what_does_not_fit_is_refused() {
        let mut writer = DataflashWriter::new();
        writer.define(1, "X", "BcZ", "b,c,z").unwrap();
        let number = DataflashCell::Number;
        for cells in [
            &[number(256.0), number(0.0), DataflashCell::Text("")][..],
            &[number(0.0), number(328.0), DataflashCell::Text("")],
            &[number(0.0), number(0.0), number(0.0)],
            &[DataflashCell::Whole(256), number(0.0), DataflashCell::Text("")],
            &[number(f64::NAN), number(0.0), DataflashCell::Text("")],
            &[number(0.0)],
        ] {
            assert!(writer.message(1, cells).is_err(), "{cells:?}");
        }
        assert!(writer.message(9, &[]).is_err());
        assert!(writer.define(1, "LONGER", "B", "b").is_err() && writer.define(1, "X", "BB", "b").is_err());
    }
}
