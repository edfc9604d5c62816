//! Description of a run: the TOML document of its preamble, known keys typed, the others kept.
//!
//! Consumes TOML text and `key=value` overrides; produces texts, [`RunGeometry`] (positions in m, body axes, relative to
//! the centre of mass) and the document again. Every change goes through one check of its type, so that the typed view
//! and the document never differ.

use super::error::{RunFileError, quoted};
use super::latency::{self, ChannelLatencies};
use super::properties;
use crate::flight::channel::ControlNames;
use crate::flight::control::{CONTROLS, Control};
use crate::flight::file::time_stamp::TimeStamp;
use crate::flight::run::{AircraftProperties, RunGeometry};
use toml::de::DeTable;
use toml::{Table, Value};

/// What a known key must hold.
#[derive(Clone, Copy, PartialEq)]
enum Kind {
    Text,
    Position,
    CentreOfMass,
    Blades,
    Latencies,
    AssumedScale,
    Properties,
    RecordedAt,
}

const RECORDED_AT: &str = "recorded_at";
const LATENCY: &str = "latency_s";
/// What the rows of a recording have had subtracted, for a reader; it has no effect.
const LATENCY_SUBTRACTED: &str = "latency_subtracted_s";

/// Controls whose angles are commands by a scale that nobody stated.
const ASSUMED_SCALE: &str = "assumed_scale";

const KNOWN: [(&str, Kind); 16] = [
    ("run", Kind::Text),
    ("aircraft", Kind::Text),
    ("manoeuvre", Kind::Text),
    ("flight_path", Kind::Text),
    ("accelerometer_position_m", Kind::Position),
    ("vane_position_m", Kind::Position),
    ("blades", Kind::Blades),
    (LATENCY, Kind::Latencies),
    (ASSUMED_SCALE, Kind::AssumedScale),
    (RECORDED_AT, Kind::RecordedAt),
    ("tail", Kind::Text),
    ("configuration", Kind::Text),
    ("mass_kg", Kind::Properties),
    ("cg_m", Kind::CentreOfMass),
    ("inertia_kgm2", Kind::Properties),
    ("reference", Kind::Properties),
];

/// More blades than any rotor has.
const BLADES_MAX: u32 = 32;

/// What is known of a run besides its samples.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct RunInfo {
    geometry: RunGeometry,
    properties: Box<AircraftProperties>,
    latencies: Option<Box<ChannelLatencies>>,
    assumed_scale: [bool; CONTROLS],
    document: Table,
}

impl RunInfo {
    /// Reads the document of a run.
    ///
    /// # Errors
    /// [`RunFileError`] in the text itself (line and column from 1) where it is not TOML or a known key has another type.
    pub fn from_toml(text: &str) -> Result<Self, RunFileError> {
        let document: Table = text.parse().map_err(|error: toml::de::Error| {
            place(text, error.span().map_or(0, |span| span.start), format!("expected TOML: {}", error.message()))
        })?;
        let mut info = RunInfo::default();
        for (key, value) in document {
            info.put(&key, value).map_err(|what| place(text, value_start(text, &key), what))?;
        }
        Ok(info)
    }

    /// Overrides a key, as `--set key=value` does: the value is TOML, and a text may do without its quotes.
    ///
    /// # Errors
    /// A sentence where there is no `=`, the key is neither known nor in the run's own document, or the type is wrong.
    pub fn set(&mut self, assignment: &str) -> Result<(), String> {
        let Some((key, text)) = assignment.split_once('=') else {
            return Err(format!("expected key=value, found {}", quoted(assignment)));
        };
        let (key, text) = (key.trim(), text.trim());
        let takes_text = match (kind_of(key), self.document.get(key)) {
            (Some(kind), _) => matches!(kind, Kind::Text | Kind::RecordedAt),
            (None, Some(present)) => present.is_str(),
            (None, None) => return Err(format!("unknown key {}; known keys are {}", quoted(key), RunInfo::known_keys())),
        };
        let parsed = format!("value = {text}").parse::<Table>().ok().filter(|table| table.len() == 1);
        let value = match parsed.and_then(|mut table| table.remove("value")) {
            Some(value) if !takes_text || value.is_str() => value,
            _ if takes_text => Value::String(text.into()),
            _ => return Err(format!("{key}: expected a TOML value, found {}", quoted(text))),
        };
        self.put(key, value)
    }

    /// Whether a key has a meaning to the program.
    pub fn is_known(key: &str) -> bool {
        kind_of(key).is_some()
    }

    /// The keys that have a meaning to the program, for a sentence.
    pub fn known_keys() -> String {
        KNOWN.map(|(name, _)| name).join(", ")
    }

    /// Sets one key of the document after checking its type.
    fn put(&mut self, key: &str, value: Value) -> Result<(), String> {
        match kind_of(key) {
            Some(Kind::Text) if !value.is_str() => {
                return Err(format!("{key}: expected a text in quotes, found {}", described(&value)));
            }
            Some(kind @ (Kind::Position | Kind::CentreOfMass)) => {
                let position = position(&value)
                    .ok_or_else(|| format!("{key}: expected three finite numbers [x, y, z] in m, found {}", described(&value)))?;
                if kind == Kind::CentreOfMass {
                    // Kept for the reader: positions of instruments are relative to it.
                } else if key == "vane_position_m" {
                    self.geometry.vane_position_m = position;
                } else {
                    self.geometry.accelerometer_position_m = position;
                }
            }
            Some(Kind::Blades) => {
                let blades = value.as_integer().and_then(|n| u32::try_from(n).ok()).filter(|n| (1..=BLADES_MAX).contains(n));
                let wrong = || format!("{key}: expected a whole number from 1 to {BLADES_MAX}, found {}", described(&value));
                self.geometry.blades = Some(blades.ok_or_else(wrong)?);
            }
            Some(Kind::Latencies) => self.latencies = Some(Box::new(ChannelLatencies::from_value(&value)?)),
            Some(Kind::AssumedScale) => {
                let named = |value: &Value| Control::from_name(value.as_str()?);
                let controls = value.as_array().and_then(|all| all.iter().map(named).collect::<Option<Vec<Control>>>());
                let wrong = || format!("{key}: expected names of controls, [\"pedal\"], found {}", described(&value));
                let controls = controls.ok_or_else(wrong)?;
                self.assumed_scale = Control::ALL.map(|control| controls.contains(&control));
            }
            Some(Kind::Properties) => properties::set(&mut self.properties, key, &value)
                .map_err(|expected| format!("{key}: expected {expected}, found {}", described(&value)))?,
            Some(Kind::RecordedAt) => {
                let text = value.as_str().map(str::to_owned).or_else(|| value.as_datetime().map(ToString::to_string));
                let dated = text.filter(|text| TimeStamp::parse(text).or_else(|| midnight(text)).is_some_and(|at| at.dated));
                let wrong =
                    || format!("{key}: expected a date and time such as 2024-05-17T09:30:01Z, found {}", described(&value));
                self.document.insert(key.into(), Value::String(dated.ok_or_else(wrong)?));
                return Ok(());
            }
            Some(Kind::Text) | None => {}
        }
        self.document.insert(key.into(), value);
        Ok(())
    }

    /// The document as TOML text, one line a key, dotted within tables; [`RunInfo::from_toml`] gives the same run back.
    pub fn to_toml(&self) -> String {
        let mut text = String::new();
        write_lines(&mut text, "", &self.document);
        text
    }

    /// The whole document, unknown keys too.
    pub fn document(&self) -> &Table {
        &self.document
    }

    /// Where instruments stand and how the controls are called.
    pub fn geometry(&self) -> &RunGeometry {
        &self.geometry
    }

    /// Controls, by place, whose angles are commands by a scale that nobody stated.
    pub fn assumed_scale(&self) -> [bool; CONTROLS] {
        self.assumed_scale
    }

    /// Says of which controls, by place, the scale is assumed; under the names that they have here.
    pub fn set_assumed_scale(&mut self, assumed: [bool; CONTROLS]) {
        self.assumed_scale = assumed;
        let naming = self.geometry.controls;
        let named = Control::ALL.into_iter().zip(assumed).filter(|(_, assumed)| *assumed);
        let names: Vec<Value> = named.map(|(control, _)| Value::String(control.name(naming).to_owned())).collect();
        if names.is_empty() {
            self.document.remove(ASSUMED_SCALE);
        } else {
            self.document.insert(ASSUMED_SCALE.into(), Value::Array(names));
        }
    }

    /// When its first sample was recorded, as the run states it; a date alone is no time.
    pub fn recorded_at(&self) -> Option<&str> {
        self.text(RECORDED_AT)
    }

    /// The same in nanoseconds since 1970, UTC; `None` where the run states a date alone or nothing.
    pub fn recorded_at_ns(&self) -> Option<i64> {
        TimeStamp::parse(self.recorded_at()?)?.unix_ns()
    }

    /// Moves the time of its first sample on by seconds; a date alone stays.
    pub fn begin_later(&mut self, by_s: f64) {
        if by_s == 0.0 {
            return;
        }
        let moved_us = self.recorded_at_ns().map(|ns| libm::round(1e-3 * ns as f64 + 1e6 * by_s));
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "not negative, below 2^64")]
        let moved_us = moved_us.filter(|us| (0.0..1e18).contains(us)).map(|us| us as u64);
        if let Some(at) = moved_us.and_then(|us| TimeStamp::of_unix_us(us).iso()) {
            self.document.insert(RECORDED_AT.into(), Value::String(at));
        }
    }

    /// Mass, inertia and reference dimensions.
    pub fn properties(&self) -> &AircraftProperties {
        &self.properties
    }

    /// How late channels were stamped; `None` where the run does not say, and rows are taken as they stand.
    pub fn latencies(&self) -> Option<&ChannelLatencies> {
        self.latencies.as_deref()
    }

    /// The same for rows that are aligned by it from here on: the document says afterwards that it was subtracted, so that
    /// nobody who reads these rows subtracts it again.
    pub fn take_latencies(&mut self) -> Option<ChannelLatencies> {
        let taken = *self.latencies.take()?;
        if let Some(Value::Table(latencies)) = self.document.remove(LATENCY) {
            let sum = latency::added(self.document.get(LATENCY_SUBTRACTED), &latencies);
            self.document.insert(LATENCY_SUBTRACTED.into(), Value::Table(sum));
        }
        Some(taken)
    }

    /// Adds a text where the run does not have the key; it has no effect.
    pub fn add_text(&mut self, key: &str, text: &str) {
        let takes_text = kind_of(key).is_none_or(|kind| matches!(kind, Kind::Text | Kind::RecordedAt));
        if takes_text && !self.document.contains_key(key) {
            // A date that is none is left out: it has no effect.
            let _ = self.put(key, Value::String(text.into()));
        }
    }

    /// Says how the controls are called, as a header shows it.
    pub fn set_controls(&mut self, controls: ControlNames) {
        self.geometry.controls = controls;
    }

    /// The text of a key that holds one: `run`, `aircraft`, `manoeuvre`, `flight_path`.
    pub fn text(&self, key: &str) -> Option<&str> {
        self.document.get(key).and_then(Value::as_str)
    }

    /// The run's name.
    pub fn run(&self) -> Option<&str> {
        self.text("run")
    }

    /// The aircraft.
    pub fn aircraft(&self) -> Option<&str> {
        self.text("aircraft")
    }

    /// What was flown.
    pub fn manoeuvre(&self) -> Option<&str> {
        self.text("manoeuvre")
    }

    /// The flight path, such as `level`.
    pub fn flight_path(&self) -> Option<&str> {
        self.text("flight_path")
    }
}

/// The beginning of the day of a date alone.
fn midnight(date: &str) -> Option<TimeStamp> {
    TimeStamp::parse(&format!("{date}T00:00:00Z"))
}

fn kind_of(key: &str) -> Option<Kind> {
    KNOWN.iter().find(|(name, _)| *name == key).map(|(_, kind)| *kind)
}

/// Every entry on a line of its own; that of a table within by dotted keys. No line is empty, as no preamble's may be.
fn write_lines(text: &mut String, before: &str, table: &Table) {
    for (key, value) in table {
        let path = format!("{before}{}", written_key(key));
        match value.as_table().filter(|inner| !inner.is_empty()) {
            Some(inner) => write_lines(text, &format!("{path}."), inner),
            None => text.push_str(&format!("{path} = {value}\n")),
        }
    }
}

/// A key as TOML takes it: bare, or in quotes with escapes.
fn written_key(key: &str) -> String {
    if !key.is_empty() && key.chars().all(|c| c.is_ascii_alphanumeric() || c == '_' || c == '-') {
        return key.into();
    }
    // The escapes of JSON are TOML's, but for the one character that JSON lets stand.
    serde_json::Value::from(key).to_string().replace('\u{7f}', "\\u007F")
}

fn position(value: &Value) -> Option<[f64; 3]> {
    let mut position = [0.0; 3];
    let entries = value.as_array().filter(|entries| entries.len() == position.len())?;
    for (place, entry) in position.iter_mut().zip(entries) {
        #[expect(clippy::cast_precision_loss, reason = "metres: far below 2^53")]
        let number = entry.as_float().or_else(|| entry.as_integer().map(|whole| whole as f64));
        *place = number.filter(|number| number.is_finite())?;
    }
    Some(position)
}

/// A value as a message shows it: its type, and itself where it is short.
fn described(value: &Value) -> String {
    format!("the {} {}", value.type_str(), quoted(&value.to_string()))
}

/// Byte offset of a top-level key's value; the start of the text where it cannot be found.
fn value_start(text: &str, key: &str) -> usize {
    let Ok(document) = DeTable::parse(text) else { return 0 };
    document.get_ref().iter().find(|(name, _)| name.get_ref() == key).map_or(0, |(_, value)| value.span().start)
}

/// Line and column, in characters from 1, of a byte offset; what is missing at the very end is missing on the last line.
fn place(text: &str, offset: usize, what: String) -> RunFileError {
    let last = text.trim_end_matches('\n').len();
    let before = text.get(..offset.min(last)).unwrap_or(text);
    let line = before.matches('\n').count() + 1;
    let column = before.rsplit('\n').next().unwrap_or("").chars().count() + 1;
    RunFileError { line, column, what }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::flight::run::ReferenceDimensions;

    #[test]
    fn known_keys_are_typed_and_the_others_kept() {
        let info = RunInfo::from_toml("run = \"467/10/11\"\nblades = 4\nvane_position_m = [13.08, 0, -0.5]\npilot.name = \"A\"")
            .unwrap();
        assert_eq!(info.run(), Some("467/10/11"));
        let expected = RunGeometry { vane_position_m: [13.08, 0.0, -0.5], blades: Some(4), ..RunGeometry::default() };
        assert_eq!(info.geometry(), &expected);
        assert_eq!(RunInfo::from_toml(&info.to_toml()), Ok(info));
    }

    #[test]
    fn controls_of_assumed_scale_stand_in_the_document_and_are_read_back() {
        let mut info = RunInfo::default();
        info.set_controls(ControlNames::FixedWing);
        info.set_assumed_scale([true, false, false, true]);
        assert_eq!(info.to_toml(), "assumed_scale = [\"elevator\", \"rudder\"]\n");
        let mut again = RunInfo::from_toml(&info.to_toml()).unwrap();
        assert_eq!(again.assumed_scale(), [true, false, false, true]);
        again.set("assumed_scale=[]").unwrap();
        assert_eq!(again.assumed_scale(), [false; CONTROLS]);
        assert!(again.set("assumed_scale=[\"rudr\"]").unwrap_err().contains("names of controls"));
    }

    #[test]
    fn a_part_begins_later_and_a_date_alone_stays() {
        let mut info = RunInfo::from_toml("recorded_at = \"2024-05-17T23:59:59.5Z\"").unwrap();
        info.begin_later(1.25);
        assert_eq!(info.recorded_at(), Some("2024-05-18T00:00:00.750Z"));
        let mut day = RunInfo::from_toml("recorded_at = \"2024-05-17\"").unwrap();
        day.begin_later(1.25);
        assert_eq!(day.recorded_at(), Some("2024-05-17"));
    }

    #[test]
    fn mass_inertia_and_reference_dimensions_are_typed() {
        let text = "mass_kg = 17631\ninertia_kgm2 = {xx = 133367, yy = 252687, zz = 359593.0, xz = 11442}\n\
                    reference = {area_m2 = 64, span_m = 21.5, chord_m = 3.159}\ncg_m = [1, 0, 0]\ntail = \"D-ADAM\"";
        let info = RunInfo::from_toml(text).unwrap();
        let AircraftProperties { mass_kg, inertia, reference } = *info.properties();
        assert_eq!((mass_kg, inertia.map(|inertia| inertia.xz)), (Some(17631.0), Some(11442.0)));
        assert_eq!(reference, Some(ReferenceDimensions::Wing { area_m2: 64.0, span_m: 21.5, chord_m: 3.159 }));
        assert_eq!(RunInfo::from_toml(&info.to_toml()), Ok(info));
        let mut info = RunInfo::default();
        info.set("reference={rotor_radius_m=7.5, tip_speed_mps=208}").unwrap();
        assert_eq!(info.properties().reference, Some(ReferenceDimensions::Rotor { radius_m: 7.5, tip_speed_mps: 208.0 }));
        for (set, expected) in [
            ("mass_kg=0", "kg, more than zero"),
            ("inertia_kgm2={xx=1,yy=1,zz=1,xz=2}", "xz^2"),
            ("inertia_kgm2={xx=1,yy=1}", "xx, yy, zz"),
            ("reference={area_m2=64,span_m=21.5}", "chord_m"),
            ("reference={area_m2=64,tip_speed_mps=208}", "of a rotor"),
            ("cg_m=[1,2]", "three finite numbers"),
        ] {
            let said = info.set(set).unwrap_err();
            assert!(said.contains(expected), "{set}: {said}");
        }
    }

    #[test]
    fn tables_are_written_line_by_line_and_read_back() {
        let text = "run = \"a\"\n[level1.flight]\nspeed = 51.5\nclimb = 0.0\n[level1.options]\nhub = \"exact\"\n\
                    [\"odd key\".\"\u{e9}\\n\"]\nx = [1, 2]\n[empty]\n";
        let info = RunInfo::from_toml(text).unwrap();
        let written = info.to_toml();
        assert!(written.contains("level1.flight.speed = 51.5\nlevel1.options.hub = \"exact\"\n"), "{written}");
        assert!(written.lines().all(|line| line.contains(" = ")), "{written}");
        let again = RunInfo::from_toml(&written).unwrap();
        assert_eq!((again.to_toml(), again), (written, info));
    }

    #[test]
    fn a_wrong_type_is_found_where_it_stands() {
        let wrong = |text: &str| RunInfo::from_toml(text).unwrap_err();
        let error = wrong("run = \"a\"\n  blades = \"four\"");
        assert_eq!((error.line, error.column), (2, 12));
        assert!(error.what.contains("whole number") && error.what.contains("four"), "{}", error.what);
        let error = wrong("run = \"a\"\naircraft = \n");
        assert_eq!(error.line, 2);
        assert!(wrong("vane_position_m = [1.0, 2.0]").what.contains("three finite numbers"));
        assert!(wrong("vane_position_m = [1.0, 2.0, inf]").what.contains("three finite numbers"));
        assert!(wrong("run = 5").what.contains("text in quotes"));
        assert!(wrong("blades = 0").what.contains("from 1 to"));
    }

    #[test]
    fn an_override_takes_bare_texts_and_toml_values() {
        let mut info = RunInfo::from_toml("weather = \"calm\"").unwrap();
        for assignment in ["run=467/10/11", "aircraft = \"Puma\"", "vane_position_m=[1, 0, 0]", "blades=4", "weather=gusty"] {
            info.set(assignment).unwrap();
        }
        assert_eq!((info.run(), info.aircraft(), info.text("weather")), (Some("467/10/11"), Some("Puma"), Some("gusty")));
        assert_eq!((info.geometry().vane_position_m, info.geometry().blades), ([1.0, 0.0, 0.0], Some(4)));
        info.set("run=467").unwrap();
        assert_eq!(info.run(), Some("467"));
        assert!(info.set("vanes=3").unwrap_err().contains("vane_position_m"));
        assert!(info.set("blades=four").unwrap_err().contains("TOML value"));
        assert!(info.set("blades=4\nrun=\"x\"").is_err());
        assert!(info.set("blades").unwrap_err().contains("key=value"));
        assert_eq!(info.geometry().blades, Some(4));
    }
}
