//! One message of a dataflash log: its name, its time, and its fields with type, unit and scaled value.
//!
//! Borrows from the reader; nothing is copied. A field's scaled value is its number by the multiplier of FMTU, or where that
//! says nothing by the scale of its format character, in the unit that FMTU names. Time is TimeUS, or TimeMS times 1000, of 64
//! bits: microseconds since the autopilot started, when the message was written, which may be after the measurement.

use super::field::{DataflashScale, DataflashValue};
use super::format::{DataflashField, DataflashFormat};
use super::unit::DataflashUnits;

/// A message.
#[derive(Clone, Copy, Debug)]
pub struct DataflashMessage<'a> {
    pub(super) format: &'a DataflashFormat,
    pub(super) units: &'a DataflashUnits,
    pub(super) body: &'a [u8],
    pub(super) at: u64,
}

/// A field of a message.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DataflashReading<'a> {
    /// Name of the column.
    pub name: &'a str,
    /// As it stands in the log.
    pub value: DataflashValue<'a>,
    /// The unit of `scaled`, where the log names one.
    pub unit: Option<&'a str>,
    /// The value in `unit`; `None` of a text or an array.
    pub scaled: Option<f64>,
}

impl<'a> DataflashMessage<'a> {
    /// The layout.
    pub fn format(&self) -> &'a DataflashFormat {
        self.format
    }

    /// Name of the message.
    pub fn name(&self) -> &'a str {
        &self.format.name
    }

    /// Where it began, bytes from the start of the log.
    pub fn at(&self) -> u64 {
        self.at
    }

    /// The bytes behind its header.
    pub fn body(&self) -> &'a [u8] {
        self.body
    }

    /// When it was written, us since start; `None` where it has no time, or a time that 64 bits do not hold.
    pub fn time_us(&self) -> Option<u64> {
        let (place, factor) = self.format.time?;
        match self.value(self.format.fields.get(place)?)? {
            DataflashValue::Unsigned(time) => time.checked_mul(factor),
            _ => None,
        }
    }

    /// Which of several instruments it is of.
    pub fn instance(&self) -> Option<u64> {
        match self.value(self.format.instance_field()?)? {
            DataflashValue::Unsigned(number) => Some(number),
            _ => None,
        }
    }

    /// Its fields in the order of the columns.
    pub fn fields(&self) -> impl Iterator<Item = DataflashReading<'a>> + use<'a> {
        let message = *self;
        message.format.fields.iter().filter_map(move |field| message.reading(field))
    }

    /// The field of that name.
    pub fn field(&self, name: &str) -> Option<DataflashReading<'a>> {
        self.reading(self.format.field(name)?)
    }

    fn value(&self, field: &DataflashField) -> Option<DataflashValue<'a>> {
        field.kind.read(self.body.get(field.offset..)?)
    }

    fn reading(&self, field: &'a DataflashField) -> Option<DataflashReading<'a>> {
        let value = self.value(field)?;
        let scale = scale(field, self.units);
        let scaled = value.number().map(|number| scale.apply(number));
        Some(DataflashReading { name: &field.name, value, unit: self.units.label(field.unit_id), scaled })
    }
}

/// The scale of a field: the multiplier's, else its character's.
fn scale(field: &DataflashField, units: &DataflashUnits) -> DataflashScale {
    units.scale(field.mult_id).unwrap_or(field.implied)
}
