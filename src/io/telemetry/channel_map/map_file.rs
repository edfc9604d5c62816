//! A map (TOML): which column of a table, or which field of a topic, is which channel.
//!
//! ```toml
//! separator = ";"                  # , ; tab or |; found out where absent
//! decimal = ","                    # . or ,; found out where absent
//! header_line = 3                  # of the file, from 1; default the first that is no comment
//! time = "Zeit [ms]"               # or { column = "Time", unit = "ms" }, { column = "UTC", format = "iso8601" },
//!                                  # { column = "Date", format = "dmy" } or "mdy", { column = "frame", rate_hz = 50 }
//! [channels]                       # a channel, and the column as its header calls it
//! p = "Roll Rate [deg/s]"          # the header states the unit
//! az = { column = "nz", unit = "g", sign = -1 }
//! elevator = { column = "DE", unit = "deg", scale = 0.5 }
//! [run]                            # keys of the run, as in the preamble of a CSV run file
//! aircraft = "..."
//! ```
//!
//! The value of a channel in SI is `sign * scale * factor(unit) * (what the column holds)`. An altitude may stand as a static
//! pressure. `attitude = ["q[0]", "q[1]", "q[2]", "q[3]"]` (w, x, y, z; body axes into north, east, down) among the channels gives
//! phi, theta, psi. Files of one recording have a table `[[file]]` each, with `ends` (how the name ends) and keys as above;
//! topics of an MCAP log `[[topic]]` with `name`, their fields with a dot for each level. Refused: unknown keys and names, with
//! the nearest; a channel twice; a unit of another quantity.

use super::unit_text::{name_and_unit, quantity_of, unit_of, units_of};
use crate::flight::channel::{Channel, ControlNames};
use crate::flight::file::run_file::{RunFileError, RunInfo, quoted};
use crate::flight::file::time_stamp::DateOrder;
use crate::flight::file::toml_reader::{TomlEntry, TomlError, TomlTable, TomlText, nearest};
use crate::flight::unit::{Quantity, factor_to_si};

/// How times are written.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum MappedTimeFormat {
    /// As the cells show.
    #[default]
    FoundOut,
    /// Numbers.
    Number,
    /// Date and time, or time of day: `2024-05-17T09:30:01.25Z`, `09:30:01.25`; with slashes in the order of the map.
    Stamps(DateOrder),
}

impl MappedTimeFormat {
    /// In which order day, month and year of a date with slashes stand.
    pub(crate) fn date_order(self) -> DateOrder {
        match self {
            MappedTimeFormat::Stamps(order) => order,
            MappedTimeFormat::FoundOut | MappedTimeFormat::Number => DateOrder::Unknown,
        }
    }
}

/// Where the time stands.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MappedTime {
    /// Its column or field; of a topic, where absent, the time at which the message was logged.
    pub column: Option<String>,
    /// Its unit, where the map says it.
    pub unit: Option<&'static str>,
    /// Numbers of samples in a row, and how many a second, 1/s.
    pub rate_hz: Option<f64>,
    /// How it is written.
    pub format: MappedTimeFormat,
}

/// A channel and where it stands.
#[derive(Clone, Debug, PartialEq)]
pub struct MappedChannel {
    /// The name that the map uses (of a control, one of its two).
    pub name: String,
    /// The channel.
    pub channel: Channel,
    /// The column or field.
    pub column: String,
    /// Its unit, where the map says it.
    pub unit: Option<&'static str>,
    /// Sign and scale.
    pub factor: f64,
}

/// A table, or a topic: where its time and channels stand.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MapSection {
    /// How the file's name ends, or what the topic is called; nothing where the map is of one table.
    pub of: Option<String>,
    /// What parts the cells.
    pub separator: Option<u8>,
    /// What parts whole numbers from decimals.
    pub decimal: Option<u8>,
    /// The line of the header, from 1.
    pub header_line: Option<usize>,
    /// The time.
    pub time: MappedTime,
    /// The channels, in the order of the map.
    pub channels: Vec<MappedChannel>,
    /// A quaternion of the attitude, by its four columns.
    pub attitude: Option<[String; 4]>,
}

/// What the sections of a map are.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum MapKind {
    /// One table.
    #[default]
    Table,
    /// Tables in several files.
    Files,
    /// Topics of a log.
    Topics,
}

/// A map.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ChannelMap {
    /// What its sections are.
    pub kind: MapKind,
    /// One a table or topic.
    pub sections: Vec<MapSection>,
    /// The table `run`.
    pub info: RunInfo,
}

const SECTION_KEYS: [&str; 5] = ["separator", "decimal", "header_line", "time", "channels"];
const ATTITUDE: &str = "attitude";

impl ChannelMap {
    /// Reads the map's text.
    ///
    /// # Errors
    /// [`RunFileError`] with line and column.
    pub fn from_toml(text: &str) -> Result<Self, RunFileError> {
        read(text).map_err(|TomlError { line, column, what }| RunFileError { line, column, what })
    }

    /// How the controls are called.
    pub fn controls(&self) -> ControlNames {
        let named = self.sections.iter().flat_map(|section| &section.channels);
        named.filter_map(|mapped| Channel::from_name(&mapped.name)?.1).next().unwrap_or_default()
    }
}

fn read(text: &str) -> Result<ChannelMap, TomlError> {
    let text = TomlText(text);
    let document = text.parse()?;
    let root = TomlTable::root(text, &document);
    let (files, topics) = (root.find("file"), root.find("topic"));
    let (kind, sections) = match (&files, &topics) {
        (Some(_), Some(topics)) => return Err(topics.misread("expected either [[file]] or [[topic]], found both")),
        (None, None) => {
            root.allow_only(&[&SECTION_KEYS[..], &["run"]].concat())?;
            (MapKind::Table, vec![section(&root, None)?])
        }
        (Some(files), None) => (MapKind::Files, sections(&root, files, "file", "ends", &SECTION_KEYS)?),
        (None, Some(topics)) => (MapKind::Topics, sections(&root, topics, "topic", "name", &["time", "channels"])?),
    };
    let mut info = RunInfo::default();
    if let Some(run) = root.find("run") {
        run.table("run")?;
        let table = text.0.parse::<toml::Table>().unwrap_or_default();
        let written = table.get("run").and_then(toml::Value::as_table).map(toml::Table::to_string).unwrap_or_default();
        info = RunInfo::from_toml(&written).map_err(|wrong| run.misread(wrong.what))?;
    }
    let map = ChannelMap { kind, sections, info };
    refuse_twice(&root, &map)?;
    Ok(map)
}

/// The tables of that key, each with the key that says what it is of.
fn sections(
    root: &TomlTable<'_>,
    entry: &TomlEntry<'_>,
    key: &str,
    of: &'static str,
    keys: &[&str],
) -> Result<Vec<MapSection>, TomlError> {
    root.allow_only(&[key, "run"])?;
    let tables = entry.tables(&format!("a [[{key}]]"))?;
    if tables.is_empty() {
        return Err(entry.misread("expected at least one table"));
    }
    tables
        .iter()
        .map(|table| {
            table.allow_only(&[&[of], keys].concat())?;
            let named = table.require(of)?;
            match named.text()? {
                "" => Err(named.misread("expected a text, found an empty one")),
                text => section(table, Some(text.to_owned())),
            }
        })
        .collect()
}

fn section(table: &TomlTable<'_>, of: Option<String>) -> Result<MapSection, TomlError> {
    let is_topic = of.is_some() && table.find("name").is_some();
    let mut section = MapSection { of, ..MapSection::default() };
    if let Some(entry) = table.find("separator") {
        section.separator = Some(match entry.text()? {
            "," => b',',
            ";" => b';',
            "tab" | "\t" => b'\t',
            "|" => b'|',
            _ => return Err(entry.choice("a separator", &[",", ";", "tab", "|"])),
        });
    }
    if let Some(entry) = table.find("decimal") {
        section.decimal = Some(match entry.text()? {
            "." => b'.',
            "," => b',',
            _ => return Err(entry.choice("a decimal sign", &[".", ","])),
        });
    }
    if let (Some(b','), Some(b','), Some(entry)) = (section.separator, section.decimal, table.find("decimal")) {
        return Err(entry.misread("expected another sign than the separator, found `,` for both"));
    }
    if let Some(entry) = table.find("header_line") {
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a whole number from 1 to 1000")]
        let line = entry.whole(1.0, 1000.0)? as usize;
        section.header_line = Some(line);
    }
    match table.find("time") {
        Some(entry) => section.time = time(&entry)?,
        None if is_topic => {}
        None => return Err(table.misread("expected `time = \"name of the column\"`, found none")),
    }
    for entry in table.require("channels")?.table("channels")?.entries() {
        if entry.key == ATTITUDE {
            section.attitude = Some(entry.texts::<4>()?.map(str::to_owned));
        } else {
            section.channels.push(channel(&entry)?);
        }
    }
    if section.channels.is_empty() && section.attitude.is_none() {
        return Err(table.misread("expected at least one channel under `channels`, found none"));
    }
    Ok(section)
}

fn time(entry: &TomlEntry<'_>) -> Result<MappedTime, TomlError> {
    if let Ok(column) = entry.text() {
        return Ok(MappedTime { column: Some(column.to_owned()), ..MappedTime::default() });
    }
    let table = entry.table("time")?;
    table.allow_only(&["column", "field", "unit", "format", "rate_hz"])?;
    let mut time = MappedTime { column: Some(column_of(&table)?), ..MappedTime::default() };
    if let Some(unit) = table.find("unit") {
        time.unit = Some(unit_for(&unit, "time", Quantity::Time)?);
        time.format = MappedTimeFormat::Number;
    }
    if let Some(rate) = table.find("rate_hz") {
        time.rate_hz = Some(rate.positive()?);
        if time.unit.is_some() {
            return Err(rate.misread("expected a unit or rate_hz, found both"));
        }
        time.format = MappedTimeFormat::Number;
    }
    if let Some(format) = table.find("format") {
        let is_number = time.format == MappedTimeFormat::Number;
        time.format = match (format.text()?, is_number) {
            ("number", _) => MappedTimeFormat::Number,
            ("iso8601" | "dmy" | "mdy", true) => return Err(format.misread("expected numbers or dates, found keys of both")),
            ("iso8601", false) => MappedTimeFormat::Stamps(DateOrder::Unknown),
            ("dmy", false) => MappedTimeFormat::Stamps(DateOrder::DayMonthYear),
            ("mdy", false) => MappedTimeFormat::Stamps(DateOrder::MonthDayYear),
            _ => return Err(format.choice("a format of the time", &["iso8601", "dmy", "mdy", "number"])),
        };
    }
    Ok(time)
}

fn column_of(table: &TomlTable<'_>) -> Result<String, TomlError> {
    let entry = match table.find("field") {
        Some(entry) => entry,
        None => table.require("column")?,
    };
    Ok(entry.text()?.to_owned())
}

fn channel(entry: &TomlEntry<'_>) -> Result<MappedChannel, TomlError> {
    let Some((channel, _)) = Channel::from_name(entry.key) else {
        let names = |controls| Channel::ALL.map(|channel| channel.name(controls));
        let mut valid = names(ControlNames::Rotorcraft).to_vec();
        valid.extend(["elevator", "aileron", "throttle", "rudder", ATTITUDE]);
        return Err(entry.unknown_key("the name of a channel", &valid));
    };
    let mut mapped = MappedChannel { name: entry.key.to_owned(), channel, column: String::new(), unit: None, factor: 1.0 };
    if let Ok(column) = entry.text() {
        mapped.column = column.to_owned();
        return Ok(mapped);
    }
    let table = entry.table(entry.key)?;
    table.allow_only(&["column", "field", "unit", "sign", "scale"])?;
    mapped.column = column_of(&table)?;
    if let Some(unit) = table.find("unit") {
        mapped.unit = Some(unit_for(&unit, entry.key, channel.quantity())?);
    }
    if let Some(scale) = table.find("scale") {
        mapped.factor = scale.positive()?;
    }
    if let Some(sign) = table.find("sign") {
        mapped.factor *= match sign.number()? {
            number if number.to_bits() == 1.0_f64.to_bits() => 1.0,
            number if number.to_bits() == (-1.0_f64).to_bits() => -1.0,
            number => return Err(sign.misread(format_args!("expected 1 or -1, found {number}"))),
        };
    }
    Ok(mapped)
}

/// The unit that an entry says, of that quantity.
fn unit_for(entry: &TomlEntry<'_>, name: &str, quantity: Quantity) -> Result<&'static str, TomlError> {
    let text = entry.text()?;
    // Of an altitude a static pressure may stand there.
    let fits = |unit: &&str| {
        let is_pressure = name == "altitude" && factor_to_si(unit, Quantity::Pressure).is_ok();
        is_pressure || factor_to_si(unit, quantity).is_ok()
    };
    let unit = unit_of(text).filter(fits);
    unit.ok_or_else(|| {
        let expected = units_of(quantity);
        entry.misread(format_args!("expected the unit of the column that is {name} ({expected}, ...), found {}", quoted(text)))
    })
}

/// Refuses a channel that comes twice, and controls called after two kinds of aircraft.
fn refuse_twice(root: &TomlTable<'_>, map: &ChannelMap) -> Result<(), TomlError> {
    let mut seen = 0_u32;
    let mut naming = None;
    let angles = [Channel::Phi, Channel::Theta, Channel::Psi];
    for section in &map.sections {
        let of_attitude = section.attitude.iter().flat_map(|_| angles.map(|channel| (channel, ATTITUDE)));
        for (channel, name) in of_attitude.chain(section.channels.iter().map(|mapped| (mapped.channel, mapped.name.as_str()))) {
            let bit = 1 << channel.index();
            if seen & bit != 0 {
                let name = if name == ATTITUDE { channel.name(ControlNames::default()) } else { name };
                return Err(root.misread(format_args!("expected every channel once, found {} twice", quoted(name))));
            }
            seen |= bit;
            match (Channel::from_name(name).and_then(|(_, naming)| naming), naming) {
                (Some(one), Some(other)) if one != other => {
                    let what = format_args!(
                        "expected controls called after one kind of aircraft, found {} beside the others' names",
                        quoted(name)
                    );
                    return Err(root.misread(what));
                }
                (Some(one), _) => naming = Some(one),
                (None, _) => {}
            }
        }
    }
    Ok(())
}

/// The place of a column among those of a header: as it stands there, or without its unit where that is one only.
///
/// # Errors
/// A sentence with the nearest.
pub(crate) fn place_of(column: &str, headers: &[&str]) -> Result<usize, String> {
    let bare = |header: &str| name_and_unit(header).0.to_owned();
    if let Some(place) = headers.iter().position(|header| header.trim() == column.trim()) {
        return Ok(place);
    }
    let mut places = (0..).zip(headers).filter(|(_, header)| bare(header) == column.trim()).map(|(place, _)| place);
    match (places.next(), places.next()) {
        (Some(place), None) => Ok(place),
        (Some(_), Some(_)) => {
            Err(format!("expected the whole header of one column, found several that begin with {}", quoted(column)))
        }
        (None, _) => {
            let near = nearest(column, headers).map(|name| format!("; nearest is {}", quoted(name))).unwrap_or_default();
            Err(format!("expected a column {}, found none{near}", quoted(column)))
        }
    }
}

/// The unit of a column of that header, and its factor to SI: that of the map, else the one that the header states.
///
/// # Errors
/// A sentence where neither states a unit that fits.
pub(crate) fn unit_of_column(name: &str, said: Option<&'static str>, header: &str) -> Result<(&'static str, f64), String> {
    let Some(quantity) = quantity_of(name) else { return Err(format!("{name}: expected the name of a channel")) };
    let expected = units_of(quantity);
    let stated = name_and_unit(header).1;
    let found = said.or_else(|| stated.and_then(unit_of));
    found.and_then(|unit| Some((unit, factor_to_si(unit, quantity).ok()?))).ok_or_else(|| {
        let header_says = match stated {
            Some(stated) => format!("its header says {}, which is none", quoted(stated)),
            None => "its header does not say it".to_owned(),
        };
        format!(
            "{name}: expected the unit of column {}, {header_says}; say it in the map: {name} = {{ column = {}, unit = \"...\" }} \
             ({expected}, ...)",
            quoted(header),
            toml::Value::from(header)
        )
    })
}
