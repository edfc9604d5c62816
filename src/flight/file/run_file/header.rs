//! The header row: one name a column, an optional unit in brackets, and what each column means to the program.
//!
//! Consumes the cells of the row; produces [`RecordingColumn`]s with `si = factor * value`, and the naming of the controls.

use super::error::{RunFileError, quoted};
use crate::flight::channel::{Channel, ControlNames};
use crate::flight::unit::{Quantity, UnitError, factor_to_si};
use std::collections::HashSet;

/// What a column feeds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum RecordingTarget {
    /// The time of the sample: `s = factor * value`.
    Time {
        /// Factor to seconds.
        factor: f64,
    },
    /// A channel that the program knows: `si = factor * value`.
    Known {
        /// Which channel.
        channel: Channel,
        /// Factor to SI.
        factor: f64,
    },
    /// Kept and carried along as it came.
    Other,
}

/// One column of a recording.
#[derive(Clone, Debug, PartialEq)]
pub struct RecordingColumn {
    /// The name, without the unit.
    pub name: String,
    /// The unit as the header writes it; `None` where it names none.
    pub unit_text: Option<String>,
    /// What the column feeds.
    pub target: RecordingTarget,
}

impl RecordingColumn {
    /// The column of that name and unit.
    ///
    /// # Errors
    /// A sentence where a known name has a unit that is unknown or measures something else.
    pub fn new(name: &str, unit_text: Option<&str>) -> Result<Self, String> {
        let factor = |quantity: Quantity| match unit_text {
            None => Ok(1.0),
            Some(text) => factor_to_si(text, quantity).map_err(|error| unit_message(name, text, quantity, error)),
        };
        let target = match (name, Channel::from_name(name)) {
            ("time", _) => RecordingTarget::Time { factor: factor(Quantity::Time)? },
            (_, Some((channel, _))) => RecordingTarget::Known { channel, factor: factor(channel.quantity())? },
            (_, None) => RecordingTarget::Other,
        };
        Ok(RecordingColumn { name: name.into(), unit_text: unit_text.map(Into::into), target })
    }

    /// Those of the columns that are neither time nor channels: a row carries them beside its sample, in this order.
    pub fn others(columns: &[RecordingColumn]) -> impl Iterator<Item = &RecordingColumn> {
        columns.iter().filter(|column| column.target == RecordingTarget::Other)
    }

    /// The unit of the column's values once they are inside the program: SI for a known one, its own text otherwise.
    pub fn inner_unit(&self) -> &str {
        match self.target {
            RecordingTarget::Time { .. } => Quantity::Time.si_unit(),
            RecordingTarget::Known { channel, .. } => channel.si_unit(),
            RecordingTarget::Other => self.unit_text.as_deref().unwrap_or(""),
        }
    }
}

fn unit_message(name: &str, text: &str, quantity: Quantity, error: UnitError) -> String {
    let expected = quantity.si_unit();
    match error {
        UnitError::Unknown => format!("column `{name}`: unknown unit {}, expected {expected} or a multiple of it", quoted(text)),
        UnitError::Mismatch { found, .. } => {
            format!("column `{name}`: expected a unit of {expected}, found {}, which is one of {}", quoted(text), found.si_unit())
        }
    }
}

/// A whole header.
#[derive(Clone, Debug, PartialEq)]
pub struct RecordingHeader {
    /// The columns in the order of the file.
    pub columns: Vec<RecordingColumn>,
    /// How the controls are called; rotorcraft where the header has none.
    pub controls: ControlNames,
}

impl RecordingHeader {
    /// Reads the cells of the header that stands on that line.
    ///
    /// # Errors
    /// [`RunFileError`] at the cell that is no name, comes twice, or has a wrong unit; at the line's start where no cell is
    /// `time`.
    pub fn parse(line: usize, cells: &[&str]) -> Result<Self, RunFileError> {
        let mut columns = Vec::with_capacity(cells.len());
        let mut start = 1;
        let mut check = Together::default();
        for cell in cells {
            let column = start + cell.chars().take_while(|c| c.is_whitespace()).count();
            let parsed = column_of(cell).and_then(|column| check.admit(&column).map(|()| column));
            columns.push(parsed.map_err(|what| RunFileError { line, column, what })?);
            start += cell.chars().count() + 1;
        }
        check.whole(cells).map_err(|what| RunFileError { line, column: 1, what })?;
        Ok(RecordingHeader { columns, controls: check.controls.map_or(ControlNames::default(), |(controls, _)| controls) })
    }

    /// Joins columns that another format brought.
    ///
    /// # Errors
    /// A sentence where a column comes twice or the controls are called after two kinds of aircraft.
    pub fn from_columns(columns: Vec<RecordingColumn>) -> Result<Self, String> {
        let mut check = Together::default();
        for column in &columns {
            check.admit(column)?;
        }
        Ok(RecordingHeader { columns, controls: check.controls.map_or(ControlNames::default(), |(controls, _)| controls) })
    }
}

/// `name`, `name[unit]` or `name [unit]`, spaces around each allowed, quotes around the whole too.
fn column_of(cell: &str) -> Result<RecordingColumn, String> {
    let cell = unquoted(cell.trim());
    let (name, unit_text) = match cell.split_once('[') {
        None => (cell, None),
        Some((name, rest)) => match rest.strip_suffix(']') {
            Some(unit) if !unit.contains(['[', ']']) => (name.trim_end(), Some(unit.trim())),
            _ => return Err(format!("expected `name` or `name[unit]`, found {}", quoted(cell))),
        },
    };
    if name.is_empty() {
        return Err("expected a channel name, found none".into());
    }
    if name.contains(['"', ']']) {
        return Err(format!("expected a channel name, found {}", quoted(cell)));
    }
    RecordingColumn::new(name, unit_text)
}

/// A cell without the pair of quotes that a spreadsheet may put around it.
fn unquoted(cell: &str) -> &str {
    cell.strip_prefix('"').and_then(|rest| rest.strip_suffix('"')).map_or(cell, str::trim)
}

/// What the columns of one header must satisfy together.
#[derive(Default)]
struct Together {
    names: HashSet<String>,
    places: u32,
    controls: Option<(ControlNames, String)>,
    has_time: bool,
}

impl Together {
    fn admit(&mut self, column: &RecordingColumn) -> Result<(), String> {
        let name = &column.name;
        if !self.names.insert(name.clone()) {
            return Err(format!("expected every column once, found {} a second time", quoted(name)));
        }
        self.has_time |= matches!(column.target, RecordingTarget::Time { .. });
        if let Some((channel, naming)) = Channel::from_name(name) {
            match (naming, &self.controls) {
                (Some(naming), Some((before, first))) if naming != *before => {
                    let same = self.places & (1 << channel.index()) != 0;
                    let why = if same { "both are the same control" } else { "they are two namings of the controls" };
                    return Err(format!(
                        "expected controls called after one kind of aircraft, found `{name}` beside `{first}`: {why}"
                    ));
                }
                (Some(naming), None) => self.controls = Some((naming, name.clone())),
                _ => {}
            }
            self.places |= 1 << channel.index();
        }
        Ok(())
    }

    fn whole(&self, cells: &[&str]) -> Result<(), String> {
        if self.has_time {
            return Ok(());
        }
        Err(format!("expected a column `time`, found {}", quoted(&cells.join(","))))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parse(header: &str) -> Result<RecordingHeader, RunFileError> {
        RecordingHeader::parse(3, &header.split(',').collect::<Vec<_>>())
    }

    #[test]
    fn names_units_and_spaces_are_read() {
        let header = parse(" time [ms] ,p[deg/s],torque [kN m],\"tas[kn]\",qhat,egt[deg C], rudder").unwrap();
        let targets: Vec<_> = header.columns.iter().map(|column| column.target).collect();
        assert_eq!(targets[0], RecordingTarget::Time { factor: 1e-3 });
        assert_eq!(targets[1], RecordingTarget::Known { channel: Channel::P, factor: core::f64::consts::PI / 180.0 });
        assert_eq!(targets[2], RecordingTarget::Known { channel: Channel::Torque, factor: 1e3 });
        assert_eq!(targets[3], RecordingTarget::Known { channel: Channel::Tas, factor: 1852.0 / 3600.0 });
        assert_eq!((targets[4], targets[5]), (RecordingTarget::Other, RecordingTarget::Other));
        assert_eq!(header.columns[5].unit_text.as_deref(), Some("deg C"));
        assert_eq!(targets[6], RecordingTarget::Known { channel: Channel::Pedal, factor: 1.0 });
        assert_eq!(header.controls, ControlNames::FixedWing);
        assert_eq!(parse("time,p").unwrap().controls, ControlNames::Rotorcraft);
    }

    #[test]
    fn columns_of_another_format_are_joined_under_the_same_rules() {
        let columns =
            |names: &[&str]| names.iter().map(|name| RecordingColumn::new(name, None)).collect::<Result<Vec<_>, _>>().unwrap();
        assert_eq!(RecordingHeader::from_columns(columns(&["p", "rudder"])).unwrap().controls, ControlNames::FixedWing);
        assert!(RecordingHeader::from_columns(columns(&["p", "p"])).unwrap_err().contains("second time"));
        assert!(RecordingHeader::from_columns(columns(&["rudder", "lon_cyclic"])).unwrap_err().contains("two namings"));
        assert!(RecordingColumn::new("p", Some("m")).unwrap_err().contains("`p`"));
    }

    #[test]
    fn every_wrong_header_says_where_and_what() {
        for (header, column, words) in [
            ("time,tas[furlong]", 6, ["`tas`", "furlong"]),
            ("time, tas[deg/s]", 7, ["`tas`", "rad/s"]),
            ("time[m],p", 1, ["`time`", "one of m"]),
            ("time,p,q,p", 10, ["`p`", "second time"]),
            ("time,x,x", 8, ["`x`", "second time"]),
            ("p,q,r", 1, ["`time`", "p,q,r"]),
            ("time,elevator,lon_cyclic", 15, ["`lon_cyclic`", "same control"]),
            ("time,elevator,pedal", 15, ["`pedal`", "two namings"]),
            ("time,p[deg/s", 6, ["name[unit]", "p[deg/s"]),
            ("time,,p", 6, ["channel name", "none"]),
            ("time,p[]", 6, ["`p`", "unknown unit"]),
        ] {
            let error = parse(header).unwrap_err();
            assert_eq!((error.line, error.column), (3, column), "{header}: {error}");
            assert!(words.iter().all(|word| error.what.contains(word)), "{header}: {error}");
        }
    }
}
