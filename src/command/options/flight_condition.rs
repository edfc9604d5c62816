//! The model of a command and the flight that it is trimmed for: one set of options for every command that takes a model.

use crate::command::message;
use clap::builder::TypedValueParser;
use serde_json::{Value, json};
use sideslip::error::Failure;
use sideslip::io::text_file::{TextFileError, read_text};
use sideslip::simulation::flight_model::{CONDITION, FlightModel, FlightRequest, ModelError, PUMA, condition_values};
use sideslip::simulation::level1::trim::{STEEP, TrimCondition};
use std::path::{Path, PathBuf};

/// What is said of the model and its flight.
#[derive(clap::Args)]
pub(crate) struct FlightCondition {
    /// Model file (TOML), or puma, the built-in Level-1 Puma
    #[arg(long, value_name = "FILE")]
    pub(crate) model: PathBuf,
    /// True airspeed of the trim, m/s [default: the model file's]
    #[arg(long, value_name = "M/S", allow_negative_numbers = true, value_parser = number("m/s"), help_heading = HEADING)]
    speed: Option<f64>,
    /// Climb rate of the trim, m/s [default: the model file's]
    #[arg(long, value_name = "M/S", allow_negative_numbers = true, value_parser = number("m/s"), help_heading = HEADING)]
    climb: Option<f64>,
    /// Sideslip of the trim, rad, positive with the wind from starboard [default: the model file's]
    #[arg(long, value_name = "RAD", allow_negative_numbers = true, value_parser = number("rad"), help_heading = HEADING)]
    sideslip: Option<f64>,
    /// Air density, kg/m^3 [default: the model file's]
    #[arg(long, value_name = "KG/M3", allow_negative_numbers = true, value_parser = number("kg/m^3"), help_heading = HEADING)]
    density: Option<f64>,
    /// Set an option or another key of the model's [level1], such as hub=exact, flapping=second_order, inflow=dynamic,
    /// rotor_speed=governed, actuators=first_order, perturbation=small, main_rotor.shaft_tilt=0.05; repeatable
    #[arg(long, value_name = "KEY=VALUE", help_heading = HEADING)]
    pub(crate) set: Vec<String>,
}

const HEADING: &str = "Flight condition (a model of kind level1; a linear model has its own)";

/// A finite number in that unit; else a sentence that names the unit.
pub(crate) fn number(unit: &'static str) -> impl TypedValueParser<Value = f64> {
    clap::builder::NonEmptyStringValueParser::new().try_map(move |text: String| match text.trim().parse::<f64>() {
        Ok(number) if number.is_finite() => Ok(number),
        _ => Err(format!("expected a finite number, in {unit}")),
    })
}

impl FlightCondition {
    /// Reads the model and trims it; notes are said. `set` is what of `--set` goes to the model, `besides` what else it could
    /// go to.
    pub(crate) fn fly(&self, set: Vec<String>, besides: &str) -> Result<FlightModel, Failure> {
        let FlightCondition { speed, climb, sideslip, density, .. } = *self;
        let model = read_model(&self.model, &FlightRequest { speed, climb, sideslip, density, set }, besides)?;
        if let Some(trimmed) = &model.level1 {
            notes(&trimmed.condition).iter().for_each(|note| message(format_args!("note: {note}")));
        }
        Ok(model)
    }

    /// Whether the trim is left to the runs: a Level-1 aircraft, and neither airspeed nor climb was asked for.
    pub(crate) fn is_left_to_runs(&self, model: &FlightModel) -> bool {
        model.level1.is_some() && self.speed.is_none() && self.climb.is_none()
    }

    /// The model trimmed at this airspeed and climb rate, m/s.
    pub(crate) fn fly_at(&self, set: Vec<String>, speed: f64, climb: f64) -> Result<FlightModel, Failure> {
        let FlightCondition { sideslip, density, .. } = *self;
        read_model(&self.model, &FlightRequest { speed: Some(speed), climb: Some(climb), sideslip, density, set }, "")
    }

    /// The same with all of `--set` for the model.
    pub(crate) fn read(&self) -> Result<FlightModel, Failure> {
        self.fly(self.set.clone(), "")
    }
}

/// Consequences of a flight condition that its numbers do not show.
fn notes(condition: &TrimCondition) -> Vec<String> {
    let climb = condition.climb;
    let mut notes = Vec::new();
    if libm::fabs(climb) > condition.speed {
        notes.push(format!("climb exceeds the airspeed; the path is vertical, at {climb} m/s"));
    }
    let airspeed = condition.speed.max(libm::fabs(climb));
    if condition.sideslip != 0.0 && libm::fabs(climb) > STEEP * airspeed {
        notes.push("on so steep a path the sideslip is that of the track over ground".to_owned());
    }
    notes
}

/// The flight and the options of a trimmed aircraft in a line for a person; `None` of a linear model.
pub(crate) fn in_words(model: &FlightModel) -> Option<String> {
    let trimmed = model.level1.as_ref()?;
    let numbers = CONDITION.into_iter().zip(condition_values(&trimmed.condition));
    let flight: Vec<String> = numbers.map(|((name, unit), value)| format!("{name} {value} {unit}")).collect();
    let flown = model.flown();
    let options = flown.get("options").and_then(toml::Value::as_table).into_iter().flatten();
    let options: Vec<String> = options.map(|(name, value)| format!("{name} {}", value.as_str().unwrap_or_default())).collect();
    Some(format!("flight: {}\noptions: {}", flight.join(", "), options.join(", ")))
}

/// The same for a program: the keys of `[level1]` that are flown; `null` of a linear model.
pub(crate) fn to_json(model: &FlightModel) -> Value {
    let flown = model.flown();
    if flown.is_empty() { Value::Null } else { json!(flown) }
}

/// A model file, or the built-in one, trimmed as asked.
pub(crate) fn read_model(path: &Path, asked: &FlightRequest, besides: &str) -> Result<FlightModel, Failure> {
    let told = |error: ModelError| told(path, error, besides);
    if path.as_os_str() == "puma" && !path.exists() {
        return FlightModel::parse(PUMA, asked).map_err(told);
    }
    let builtin = "; built in is puma";
    let text = read_text(path).map_err(|wrong| match wrong {
        TextFileError::Unreadable(error) => Failure::file(path, format_args!("expected a model file: {error}{builtin}")),
        wrong => Failure::file(path, wrong),
    })?;
    FlightModel::parse(&text, asked).map_err(told)
}

fn told(path: &Path, error: ModelError, besides: &str) -> Failure {
    match error {
        ModelError::Misread(misread) => Failure::at(path, misread.line, misread.column, misread.what),
        ModelError::Linear("--set") | ModelError::Key { .. } => Failure::Input(format!("{error}{besides} ({})", path.display())),
        ModelError::Linear(_) => Failure::Input(format!("{error} ({})", path.display())),
        ModelError::Set(_) => Failure::Input(error.to_string()),
        ModelError::NoTrim(_) | ModelError::NotFinite { .. } => Failure::file(path, error),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_the_numbers_do_not_show_is_noted() {
        let condition = |speed, climb, sideslip| TrimCondition { speed, climb, sideslip, density: 1.2 };
        assert!(notes(&condition(50.0, -10.0, 0.1)).is_empty() && notes(&condition(0.0, 0.0, 0.1)).is_empty());
        assert!(notes(&condition(2.0, -3.0, 0.0))[0].contains("vertical, at -3 m/s"));
        assert_eq!(notes(&condition(2.0, 3.0, 0.1)).len(), 2);
    }

    #[test]
    fn a_number_comes_with_its_unit_when_it_is_none() {
        let command = <FlightCondition as clap::Args>::augment_args(clap::Command::new("any"));
        for wrong in ["100kn", "nan", "inf", "fast", ""] {
            let call = ["any", "--model", "puma", "--speed", wrong];
            let error = command.clone().try_get_matches_from(call).unwrap_err().to_string();
            assert!(error.contains("--speed"), "{wrong}: {error}");
            assert!(wrong.is_empty() || error.contains("finite number, in m/s"), "{wrong}: {error}");
        }
        let good = ["any", "--model", "puma", "--speed", "51.4", "--climb", "-5", "--sideslip", "-0.1", "--density", "1"];
        assert!(command.try_get_matches_from(good).is_ok());
    }
}
