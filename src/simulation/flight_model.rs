//! A model file of either kind, ready to fly and to linearise; the built-in Puma.
//!
//! Consumes the text of a model file, the trim that is asked for and options set by hand; produces the file, its linear
//! model, and for kind `level1` the aircraft in its trim. A linear model has one trim and no options: asking for another is
//! refused.
//!
//! `--set` writes `key=value` into the `[level1]` table, the key dotted (`main_rotor.shaft_tilt=0.05`); that of an option may
//! stand alone (`hub=exact`). A value that is no TOML is taken as a text. The key must be there already, but for
//! `engine.torque_limit`, which a model may do without. The condition flown can be written into a run: see
//! [`FlightModel::flown`].

use super::fly::Flight;
use super::level1::file::{DeclaredAircraft, OPTIONS, TORQUE_LIMIT, read};
use super::level1::trim::{TrimCondition, TrimError, Trimmed};
use crate::flight::channel::ControlNames;
use crate::flight::derivative::{Axis, Variable};
use crate::flight::file::effect_file::DeclaredEffect;
use crate::flight::file::model_file::ModelFile;
use crate::flight::file::toml_reader::TomlError;
use crate::flight::model::LinearModel;
use std::fmt::Write;

/// The text of the built-in model `puma`.
pub const PUMA: &str = include_str!("../../replay/models/puma.toml");

/// The numbers of a flight condition, as options and files name them, with their units.
pub const CONDITION: [(&str, &str); 4] = [("speed", "m/s"), ("climb", "m/s"), ("sideslip", "rad"), ("density", "kg/m^3")];

/// Their values in that order.
pub fn condition_values(condition: &TrimCondition) -> [f64; 4] {
    [condition.speed, condition.climb, condition.sideslip, condition.density]
}

/// A trim other than the file's own, and options; `None` and nothing leave the file's.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct FlightRequest {
    /// True airspeed, m/s.
    pub speed: Option<f64>,
    /// Climb rate, m/s.
    pub climb: Option<f64>,
    /// Sideslip, rad.
    pub sideslip: Option<f64>,
    /// Air density, kg/m^3.
    pub density: Option<f64>,
    /// Assignments to keys of the `[level1]` table.
    pub set: Vec<String>,
}

/// A model of either kind.
#[derive(Clone, Debug, PartialEq)]
pub struct FlightModel {
    /// The file; its linear model is for kind `level1` the one about the trim.
    pub file: ModelFile,
    /// The aircraft in its trim, for kind `level1`.
    pub level1: Option<Box<Trimmed>>,
    /// The text, assignments made.
    text: String,
    /// Keys of `[level1]` that were assigned to, each as the parts of its path.
    assigned: Vec<Vec<String>>,
}

/// Why a text is no model to fly.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[expect(missing_docs, reason = "the message of each says what its fields are")]
pub enum ModelError {
    #[error("{0}")]
    Misread(#[from] TomlError),
    #[error("--set: {0}")]
    Set(String),
    #[error("--set: expected {expected}, found `{key}`")]
    Key { expected: String, key: String },
    #[error(
        "{0}: a model of kind `linear` holds at its own trim only, which is part of its file; a model of kind `level1`, such as \
         puma, can be trimmed anew"
    )]
    Linear(&'static str),
    #[error("{0}")]
    NoTrim(#[from] TrimError),
    #[error("the simulation has no linear model at its trim: the derivative {}_{} is not finite", axis.name(), variable.name(ControlNames::default()))]
    NotFinite { axis: Axis, variable: Variable },
}

impl FlightModel {
    /// Reads a model file's text and trims what it declares.
    ///
    /// # Errors
    /// [`ModelError`] with the first wrong place, or why there is no such trim.
    pub fn parse(text: &str, asked: &FlightRequest) -> Result<Self, ModelError> {
        let (file, mut declared) = ModelFile::parse_either(text, read)?;
        let mut text = text.to_owned();
        let mut assigned = Vec::new();
        if declared.is_some() && !asked.set.is_empty() {
            let document = assign(&text, &asked.set, &mut assigned)?;
            refuse_twice(asked, &assigned)?;
            text = toml::to_string(&document).map_err(|error| ModelError::Set(error.to_string()))?;
            declared = ModelFile::parse_either(&text, read).map_err(|misread| ModelError::Set(misread.what))?.1;
        }
        let Some(declared) = declared else {
            let options = [
                ("--speed", asked.speed.is_some()),
                ("--climb", asked.climb.is_some()),
                ("--sideslip", asked.sideslip.is_some()),
                ("--density", asked.density.is_some()),
                ("--set", !asked.set.is_empty()),
            ];
            return match options.into_iter().find(|(_, given)| *given) {
                Some((option, _)) => Err(ModelError::Linear(option)),
                None => Ok(FlightModel { file, level1: None, text, assigned }),
            };
        };
        let DeclaredAircraft { aircraft, mut condition } = declared;
        for (place, asked) in [
            (&mut condition.speed, asked.speed),
            (&mut condition.climb, asked.climb),
            (&mut condition.sideslip, asked.sideslip),
            (&mut condition.density, asked.density),
        ] {
            *place = asked.unwrap_or(*place);
        }
        let trimmed = aircraft.trim(condition)?;
        let linear = trimmed.linear();
        let all = Axis::ALL.into_iter().flat_map(|axis| Variable::ALL.into_iter().map(move |variable| (axis, variable)));
        if let Some((axis, variable)) = all.into_iter().find(|(axis, variable)| !linear.derivative(*axis, *variable).is_finite())
        {
            return Err(ModelError::NotFinite { axis, variable });
        }
        let file = ModelFile { linear, ..file };
        Ok(FlightModel { file, level1: Some(Box::new(trimmed)), text, assigned })
    }

    /// The built-in Puma.
    ///
    /// # Errors
    /// As for [`FlightModel::parse`].
    pub fn puma(asked: &FlightRequest) -> Result<Self, ModelError> {
        FlightModel::parse(PUMA, asked)
    }

    /// The model in its trim without effects, perfect instruments, no time yet.
    pub fn flight(&self) -> Flight {
        match &self.level1 {
            None => Flight::of(self.file.linear.clone()),
            Some(trimmed) => Flight::of_level1((**trimmed).clone()),
        }
    }

    /// A model file that flies the same, in the trim that was asked for and with these effects instead of its own.
    ///
    /// # Errors
    /// [`ModelError::Set`] where the text cannot be written anew.
    pub fn with_effects(&self, effects: &[DeclaredEffect]) -> Result<String, ModelError> {
        let Some(trimmed) = &self.level1 else {
            return Ok(ModelFile { effects: effects.to_vec(), ..self.file.clone() }.to_toml());
        };
        let values = CONDITION.into_iter().zip(condition_values(&trimmed.condition));
        let flight: Vec<String> = values.map(|((key, _), value)| format!("flight.{key}={value:?}")).collect();
        let mut document = assign(&self.text, &flight, &mut Vec::new())?;
        document.remove("effect");
        let mut text = toml::to_string(&document).map_err(|error| ModelError::Set(error.to_string()))?;
        for effect in effects {
            let _ = write!(text, "\n{}\n", effect.to_toml(self.file.controls).trim_end());
        }
        Ok(text)
    }

    /// What of a `[level1]` table is flown: the flight condition with the airspeed flown, the options, and each other key that
    /// was assigned to; empty for a linear model.
    pub fn flown(&self) -> toml::Table {
        let mut flown = toml::Table::new();
        let Some(trimmed) = &self.level1 else { return flown };
        let document = self.text.parse::<toml::Table>().unwrap_or_default();
        let options = OPTIONS.map(|option| vec!["options".to_owned(), option.to_owned()]);
        for path in options.iter().chain(&self.assigned) {
            let mut there = document.get("level1");
            for part in path {
                there = there.and_then(|value| value.get(part));
            }
            if let Some(value) = there {
                put(&mut flown, path, value.clone());
            }
        }
        let condition = TrimCondition { speed: trimmed.condition.airspeed(), ..trimmed.condition };
        for ((key, _), value) in CONDITION.into_iter().zip(condition_values(&condition)) {
            put(&mut flown, &["flight".to_owned(), key.to_owned()], value.into());
        }
        flown
    }

    /// Blades of the main rotor of a Level-1 aircraft.
    pub fn blades(&self) -> Option<f64> {
        self.level1.as_ref().map(|trimmed| trimmed.aircraft.main_rotor.blades)
    }

    /// The linear model, effects left out.
    pub fn linear(&self) -> &LinearModel {
        &self.file.linear
    }
}

/// Refuses a number of the flight condition that both its own option and an assignment give.
fn refuse_twice(asked: &FlightRequest, assigned: &[Vec<String>]) -> Result<(), ModelError> {
    let given = [asked.speed, asked.climb, asked.sideslip, asked.density];
    for ((key, _), given) in CONDITION.into_iter().zip(given) {
        if given.is_some() && assigned.iter().any(|path| *path == ["flight", key]) {
            return Err(ModelError::Set(format!("expected flight.{key} once, found it beside --{key}")));
        }
    }
    Ok(())
}

/// The document with these assignments made; the path of each key is added to `assigned`.
fn assign(text: &str, assignments: &[String], assigned: &mut Vec<Vec<String>>) -> Result<toml::Table, ModelError> {
    let refuse = |what: String| ModelError::Set(what);
    let mut document: toml::Table = text.parse().map_err(|error| refuse(format!("{error}")))?;
    for assignment in assignments {
        let (key, value) = assignment
            .split_once('=')
            .ok_or_else(|| refuse(format!("expected key=value, such as hub=exact, found `{assignment}`")))?;
        let key = key.trim();
        let path: Vec<&str> = if OPTIONS.contains(&key) { vec!["options", key] } else { key.split('.').collect() };
        let mut place = document.get_mut("level1");
        if path == ["engine", TORQUE_LIMIT]
            && let Some(engine) = place.as_mut().and_then(|level1| level1.get_mut("engine")).and_then(toml::Value::as_table_mut)
        {
            engine.entry(TORQUE_LIMIT).or_insert(toml::Value::Float(0.0));
        }
        for part in &path {
            place = place.and_then(|value| value.as_table_mut()).and_then(|table| table.get_mut(*part));
        }
        match place.filter(|place| !place.is_table()) {
            Some(place) => *place = written(value.trim()),
            None => return Err(ModelError::Key { expected: assignable(&document, &path), key: key.to_owned() }),
        }
        assigned.push(path.into_iter().map(str::to_owned).collect());
    }
    Ok(document)
}

/// What could be assigned to instead of that path: the keys of its last table that is there.
fn assignable(document: &toml::Table, path: &[&str]) -> String {
    let mut there = "level1".to_owned();
    let mut table = document.get("level1").and_then(toml::Value::as_table);
    for part in path {
        let Some(inner) = table.and_then(|table| table.get(*part)).and_then(toml::Value::as_table) else { break };
        (there, table) = (format!("{there}.{part}"), Some(inner));
    }
    let keys = table.into_iter().flat_map(toml::Table::keys).map(String::as_str).collect::<Vec<_>>().join(" ");
    match there.strip_prefix("level1.") {
        None => format!("an option ({}) or a dotted key of the model's [level1], such as flight.speed", OPTIONS.join(" ")),
        Some(within) => format!("a key of [{there}], such as {within}.KEY with KEY one of {keys}"),
    }
}

/// Puts a value at that path, making the tables on the way.
fn put(table: &mut toml::Table, path: &[String], value: toml::Value) {
    match path {
        [] => {}
        [key] => {
            table.insert(key.clone(), value);
        }
        [key, rest @ ..] => {
            let inner = table.entry(key.clone()).or_insert_with(|| toml::Value::Table(toml::Table::new()));
            if let Some(inner) = inner.as_table_mut() {
                put(inner, rest, value);
            }
        }
    }
}

/// A value as TOML reads it, else as a text.
fn written(value: &str) -> toml::Value {
    let parsed = format!("x = {value}").parse::<toml::Table>().ok().and_then(|mut table| table.remove("x"));
    parsed.unwrap_or_else(|| toml::Value::String(value.to_owned()))
}

#[cfg(test)]
mod tests {
    use super::super::level1::hub::Hub;
    use super::*;
    use crate::flight::derivative::{Axis, Variable};
    use crate::flight::effect::Effect;

    fn with(set: &[&str]) -> Result<FlightModel, ModelError> {
        FlightModel::puma(&FlightRequest { set: set.iter().map(|&text| text.to_owned()).collect(), ..FlightRequest::default() })
    }

    #[test]
    fn options_and_data_are_set_by_hand() {
        let model = with(&["hub=exact", "flight.speed = 30", "options.inflow=dynamic"]).unwrap();
        let trimmed = model.level1.unwrap();
        assert_eq!(trimmed.aircraft.hub, Hub::Exact);
        assert!(trimmed.aircraft.options.dynamic_inflow && (trimmed.trim.airspeed() - 30.0).abs() < 1e-12);
    }

    #[test]
    fn written_with_effects_and_read_again_it_flies_the_same() {
        let effect = Effect::Derivative { axis: Axis::N, variable: Variable::P, delta: -0.17 };
        let effects = [DeclaredEffect { effect, std: Some(0.01) }];
        let asked = FlightRequest { climb: Some(5.0), set: vec!["hub=exact".to_owned()], ..FlightRequest::default() };
        let model = FlightModel::puma(&asked).unwrap();
        let text = model.with_effects(&effects).unwrap();
        let again = FlightModel::parse(&text, &FlightRequest::default()).unwrap();
        assert_eq!((again.level1, again.file.linear), (model.level1, model.file.linear), "{text}");
        assert_eq!(again.file.effects, effects);
    }

    #[test]
    fn wrong_assignments_say_why() {
        for (text, part) in [
            ("hub", "key=value"),
            ("hub=round", "nearest is `exact`"),
            ("huub=exact", "found `huub`"),
            ("level1.hub=exact", "found `level1.hub`"),
            ("flight=1", "found `flight`"),
            ("main_rotor.shaft_tlt=0.1", "shaft_tilt"),
            ("body.mass=-1", "more than zero"),
            ("body.mass=heavy", "finite number"),
        ] {
            let error = with(&[text]).unwrap_err().to_string();
            assert!(error.starts_with("--set: ") && error.contains(part), "{text}: {error}");
        }
    }

    #[test]
    fn a_linear_model_has_one_trim_and_no_options() {
        let text = "kind = 'linear'\n[trim]\nu = 50.0\ntheta = 0.0\n";
        assert!(FlightModel::parse(text, &FlightRequest::default()).unwrap().level1.is_none());
        let error = FlightModel::parse(text, &FlightRequest { climb: Some(1.0), ..FlightRequest::default() }).unwrap_err();
        assert!(error.to_string().starts_with("--climb"), "{error}");
        assert!(FlightModel::parse(text, &FlightRequest::default()).unwrap().flown().is_empty());
    }

    #[test]
    fn what_is_flown_is_told_as_a_model_file_has_it() {
        let set = ["hub=exact", "main_rotor.shaft_tilt=0.05", "flight.sideslip=0.02"].map(str::to_owned).to_vec();
        let flown =
            FlightModel::puma(&FlightRequest { climb: Some(5.0), set: set.clone(), ..FlightRequest::default() }).unwrap().flown();
        let at = |table: &str, key: &str| flown[table][key].clone();
        assert_eq!((at("flight", "climb"), at("flight", "sideslip")), (5.0.into(), 0.02.into()));
        assert_eq!((at("options", "hub"), at("options", "inflow")), ("exact".into(), "quasi_steady".into()));
        assert_eq!(at("main_rotor", "shaft_tilt"), 0.05.into());
        assert_eq!((flown.len(), flown["options"].as_table().unwrap().len()), (3, OPTIONS.len()));
        let twice =
            FlightModel::puma(&FlightRequest { sideslip: Some(0.0), set, ..FlightRequest::default() }).unwrap_err().to_string();
        assert!(twice.contains("flight.sideslip once") && twice.contains("--sideslip"), "{twice}");
    }
}
