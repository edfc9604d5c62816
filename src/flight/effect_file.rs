//! Effects as tables of a TOML document: read with every key checked, and written back.
//!
//! Consumes a table such as `kind = "actuator_lag", control = "pedal", tau = 0.15`; produces an [`Effect`] and the
//! standard error of its main number where the table has the optional key `std`.
//! Refused: a kind, key, axis, variable, control, channel, sensor or term that does not exist, a key that is missing,
//! a number that is not finite, and a negative time, rate, width or length.

use super::channel::{Channel, ControlNames};
use super::control::Control;
use super::derivative::{Axis, Variable};
use super::document::{Entry, Misread, Table, Text};
use super::effect::{Effect, EffectKind, PositionedSensor};
use super::term::Term;
use std::cell::Cell;
use std::fmt::Write;

/// An effect as a file declares it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DeclaredEffect {
    /// The effect.
    pub effect: Effect,
    /// Standard error of its main number, where known.
    pub std: Option<f64>,
}

/// Names of controls, watched so that a file keeps to one naming.
#[derive(Default)]
pub(crate) struct Naming(Cell<Option<ControlNames>>);

impl Naming {
    /// Takes note of a name; says so where it belongs to the other naming than an earlier one.
    pub(crate) fn note(&self, name: &str) -> Result<(), String> {
        match (Channel::from_name(name), self.0.get()) {
            (Some((_, Some(naming))), None) => self.0.set(Some(naming)),
            (Some((channel, Some(naming))), Some(earlier)) if naming != earlier => {
                return Err(format!("expected `{}` as controls are named before it, found `{name}`", channel.name(earlier)));
            }
            _ => {}
        }
        Ok(())
    }

    /// The naming that the file keeps to.
    pub(crate) fn kept(&self) -> ControlNames {
        self.0.get().unwrap_or_default()
    }

    /// The naming to offer in messages.
    fn offered(&self) -> ControlNames {
        self.kept()
    }

    /// Names of the four controls to offer in messages.
    pub(crate) fn control_names(&self) -> Vec<&'static str> {
        Control::ALL.iter().map(|control| control.name(self.offered())).collect()
    }

    /// Names of all linear variables to offer in messages.
    pub(crate) fn variable_names(&self) -> Vec<&'static str> {
        Variable::ALL.iter().map(|variable| variable.name(self.offered())).collect()
    }
}

/// The effects of a TOML document that has nothing but `[[effect]]` tables.
///
/// # Errors
/// [`Misread`] with the place of the first table that is not an effect.
pub fn parse_effects(text: &str) -> Result<Vec<DeclaredEffect>, Misread> {
    let root = Text(text).parse()?;
    let root = Table::root(Text(text), &root);
    root.allow_only(&["effect"])?;
    read_effects(&root, &Naming::default())
}

/// The `[[effect]]` tables of a root table.
pub(crate) fn read_effects(root: &Table<'_>, naming: &Naming) -> Result<Vec<DeclaredEffect>, Misread> {
    let Some(entry) = root.find("effect") else { return Ok(Vec::new()) };
    entry.tables("[[effect]]")?.iter().map(|table| read_effect(table, naming)).collect()
}

fn read_effect(table: &Table<'_>, naming: &Naming) -> Result<DeclaredEffect, Misread> {
    let kind_entry = table.require("kind")?;
    let Some(kind) = EffectKind::from_name(kind_entry.text()?) else {
        let names: Vec<&str> = EffectKind::ALL.iter().map(|kind| kind.name()).collect();
        return Err(kind_entry.choice("a kind of effect", &names));
    };
    // Of rotor speed, its effect on an axis or the reaction to its change.
    let reaction = table.find("reaction").filter(|_| kind == EffectKind::RotorSpeed);
    if let Some(reaction) = reaction.as_ref().filter(|_| table.find("coefficient").is_some()) {
        return Err(reaction.misread("expected `coefficient` (of its speed) or `reaction` (to its acceleration), found both"));
    }
    let reacts = reaction.is_some();
    let kind = if reacts { EffectKind::RotorReaction } else { kind };
    let allowed: Vec<&str> = ["kind", "std"].iter().chain(kind.keys()).copied().collect();
    table.allow_only(&allowed)?;
    let axis = || axis(&table.require("axis")?);
    let number = |key: &str| table.require(key)?.number();
    let not_negative = |key: &str| table.require(key)?.not_negative();
    let positive = |key: &str| table.require(key)?.positive();
    let control = |key: &str| control(&table.require(key)?, naming);
    let channel = || channel(&table.require("channel")?, naming);
    let effect = match kind {
        EffectKind::Derivative => Effect::Derivative {
            axis: axis()?,
            variable: variable(&table.require("variable")?, naming)?,
            delta: number("delta")?,
        },
        EffectKind::Nonlinear => Effect::Nonlinear {
            axis: axis()?,
            term: nonlinear_term(&table.require("term")?)?,
            coefficient: number("coefficient")?,
        },
        EffectKind::ControlEffectiveness => {
            Effect::ControlEffectiveness { control: control("control")?, factor: number("factor")? }
        }
        EffectKind::ActuatorLag => Effect::ActuatorLag { control: control("control")?, tau: not_negative("tau")? },
        EffectKind::TransportDelay => Effect::TransportDelay { control: control("control")?, delay: not_negative("delay")? },
        EffectKind::RateLimit => Effect::RateLimit { control: control("control")?, rate: positive("rate")? },
        EffectKind::DeadZone => Effect::DeadZone { control: control("control")?, half_width: not_negative("half_width")? },
        EffectKind::CrossFeed => {
            let effect = Effect::CrossFeed { from: control("from")?, to: control("to")?, gain: number("gain")? };
            if matches!(effect, Effect::CrossFeed { from, to, .. } if from == to) {
                return Err(table.require("to")?.misread("expected another control than `from`, found the same"));
            }
            effect
        }
        EffectKind::RotorSpeed => Effect::RotorSpeed { axis: axis()?, coefficient: number("coefficient")? },
        EffectKind::RotorReaction => {
            if axis()? != Axis::N {
                return Err(table.require("axis")?.misread("expected N, the axis that a rotor's shaft turns the fuselage about"));
            }
            let reaction = number("reaction")?;
            if !(libm::fabs(reaction) <= 1.0) {
                return Err(table.require("reaction")?.misread("expected a part of the fuselage's inertia, from -1 to 1"));
            }
            Effect::RotorReaction { reaction }
        }
        EffectKind::FlightPath => Effect::FlightPath {
            axis: axis()?,
            variable: variable(&table.require("variable")?, naming)?,
            slope: number("slope")?,
        },
        EffectKind::Turbulence => Effect::Turbulence { sigma: not_negative("sigma")?, length: positive("length")? },
        EffectKind::SensorBias => Effect::SensorBias { channel: channel()?, value: number("value")? },
        EffectKind::SensorScale => Effect::SensorScale { channel: channel()?, factor: number("factor")? },
        EffectKind::SensorLag => Effect::SensorLag { channel: channel()?, tau: not_negative("tau")? },
        EffectKind::SensorDelay => Effect::SensorDelay { channel: channel()?, delay: number("delay")? },
        EffectKind::SensorPosition => {
            Effect::SensorPosition { sensor: sensor(&table.require("sensor")?)?, offset_m: table.require("offset_m")?.vector()? }
        }
        EffectKind::None => Effect::None,
        EffectKind::Unknown => Effect::Unknown { axis: axis()? },
    };
    let std = table.find("std").map(|entry| entry.not_negative()).transpose()?;
    Ok(DeclaredEffect { effect, std })
}

fn axis(entry: &Entry<'_>) -> Result<Axis, Misread> {
    let names: Vec<&str> = Axis::ALL.iter().map(|axis| axis.name()).collect();
    Axis::from_name(entry.text()?).ok_or_else(|| entry.choice("an axis", &names))
}

fn variable(entry: &Entry<'_>, naming: &Naming) -> Result<Variable, Misread> {
    let name = entry.text()?;
    if name == "rotor_speed" {
        return Err(entry.misread("an effect of rotor speed has the kind `rotor_speed`"));
    }
    if Term::from_name(name).is_ok_and(Term::is_nonlinear) {
        return Err(entry.misread(format_args!("an effect of `{name}` has the kind `nonlinear`")));
    }
    let variable = Variable::from_name(name).ok_or_else(|| entry.choice("a variable", &naming.variable_names()))?;
    naming.note(name).map_err(|what| entry.misread(what))?;
    Ok(variable)
}

fn control(entry: &Entry<'_>, naming: &Naming) -> Result<Control, Misread> {
    let name = entry.text()?;
    let control = Control::from_name(name).ok_or_else(|| entry.choice("a control", &naming.control_names()))?;
    naming.note(name).map_err(|what| entry.misread(what))?;
    Ok(control)
}

fn channel(entry: &Entry<'_>, naming: &Naming) -> Result<Channel, Misread> {
    let name = entry.text()?;
    let Some((channel, _)) = Channel::from_name(name) else {
        let names: Vec<&str> = Channel::ALL.iter().map(|channel| channel.name(naming.offered())).collect();
        return Err(entry.choice("a channel", &names));
    };
    naming.note(name).map_err(|what| entry.misread(what))?;
    Ok(channel)
}

fn sensor(entry: &Entry<'_>) -> Result<PositionedSensor, Misread> {
    let name = entry.text()?;
    let found = PositionedSensor::ALL.into_iter().find(|sensor| sensor.name() == name);
    found.ok_or_else(|| entry.choice("a sensor", &PositionedSensor::ALL.map(PositionedSensor::name)))
}

fn nonlinear_term(entry: &Entry<'_>) -> Result<Term, Misread> {
    match Term::from_name(entry.text()?) {
        Ok(term) if term.is_nonlinear() => Ok(term),
        Ok(term) => {
            Err(entry.misread(format_args!("expected a nonlinear term, found the linear `{term}`: its kind is `derivative`")))
        }
        Err(error) => Err(entry.misread(format_args!("{error}; found \"{}\"", entry.text()?))),
    }
}

/// A value of an effect's table.
#[derive(Clone, Debug, PartialEq)]
pub enum EffectValue {
    /// A name.
    Name(String),
    /// A number.
    Number(f64),
    /// Three numbers.
    Vector([f64; 3]),
}

impl DeclaredEffect {
    /// Keys and values of the effect's table, `kind` first and `std` last, for any format that has tables.
    pub fn entries(&self, naming: ControlNames) -> Vec<(&'static str, EffectValue)> {
        use EffectValue::{Name, Number, Vector};
        let axis = |axis: Axis| ("axis", Name(axis.name().to_owned()));
        let variable = |variable: Variable| ("variable", Name(variable.name(naming).to_owned()));
        let control = |key: &'static str, control: Control| (key, Name(control.name(naming).to_owned()));
        let channel = |channel: Channel| ("channel", Name(channel.name(naming).to_owned()));
        let mut entries = vec![("kind", Name(self.effect.kind().name().to_owned()))];
        entries.extend(match self.effect {
            Effect::Derivative { axis: a, variable: v, delta } => vec![axis(a), variable(v), ("delta", Number(delta))],
            Effect::Nonlinear { axis: a, term, coefficient } => {
                vec![axis(a), ("term", Name(term.to_string())), ("coefficient", Number(coefficient))]
            }
            Effect::ControlEffectiveness { control: c, factor } => vec![control("control", c), ("factor", Number(factor))],
            Effect::ActuatorLag { control: c, tau } => vec![control("control", c), ("tau", Number(tau))],
            Effect::TransportDelay { control: c, delay } => vec![control("control", c), ("delay", Number(delay))],
            Effect::RateLimit { control: c, rate } => vec![control("control", c), ("rate", Number(rate))],
            Effect::DeadZone { control: c, half_width } => vec![control("control", c), ("half_width", Number(half_width))],
            Effect::CrossFeed { from, to, gain } => vec![control("from", from), control("to", to), ("gain", Number(gain))],
            Effect::RotorSpeed { axis: a, coefficient } => vec![axis(a), ("coefficient", Number(coefficient))],
            Effect::RotorReaction { reaction } => vec![axis(Axis::N), ("reaction", Number(reaction))],
            Effect::FlightPath { axis: a, variable: v, slope } => vec![axis(a), variable(v), ("slope", Number(slope))],
            Effect::Turbulence { sigma, length } => vec![("sigma", Number(sigma)), ("length", Number(length))],
            Effect::SensorBias { channel: c, value } => vec![channel(c), ("value", Number(value))],
            Effect::SensorScale { channel: c, factor } => vec![channel(c), ("factor", Number(factor))],
            Effect::SensorLag { channel: c, tau } => vec![channel(c), ("tau", Number(tau))],
            Effect::SensorDelay { channel: c, delay } => vec![channel(c), ("delay", Number(delay))],
            Effect::SensorPosition { sensor, offset_m } => {
                vec![("sensor", Name(sensor.name().to_owned())), ("offset_m", Vector(offset_m))]
            }
            Effect::None => Vec::new(),
            Effect::Unknown { axis: a } => vec![axis(a)],
        });
        entries.extend(self.std.map(|std| ("std", Number(std))));
        entries
    }

    /// The effect as one `[[effect]]` table of TOML.
    pub fn to_toml(&self, naming: ControlNames) -> String {
        let mut text = "[[effect]]\n".to_owned();
        for (key, value) in self.entries(naming) {
            let _ = match value {
                EffectValue::Name(name) => writeln!(text, "{key} = \"{name}\""),
                EffectValue::Number(number) => writeln!(text, "{key} = {number:?}"),
                EffectValue::Vector(numbers) => writeln!(text, "{key} = {numbers:?}"),
            };
        }
        text
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// One table of each kind, as a person would write it.
    const EVERY_KIND: &str = r#"
        effect = [
            { kind = "derivative", axis = "N", variable = "p", delta = -0.17, std = 0.01 },
            { kind = "nonlinear", axis = "N", term = "v*|v|", coefficient = 1e-3 },
            { kind = "control_effectiveness", control = "rudder", factor = 0.8 },
            { kind = "actuator_lag", control = "rudder", tau = 0.15 },
            { kind = "transport_delay", control = "aileron", delay = 0.1 },
            { kind = "rate_limit", control = "elevator", rate = 1 },
            { kind = "dead_zone", control = "throttle", half_width = 0.002 },
            { kind = "cross_feed", from = "throttle", to = "rudder", gain = 0.3 },
            { kind = "rotor_speed", axis = "N", coefficient = 0.02 },
            { kind = "flight_path", axis = "N", variable = "p", slope = 0.4 },
            { kind = "turbulence", sigma = 1.0, length = 200 },
            { kind = "sensor_bias", channel = "beta", value = -0.01 },
            { kind = "sensor_scale", channel = "rudder", factor = 1.1 },
            { kind = "sensor_lag", channel = "p", tau = 0.05 },
            { kind = "sensor_delay", channel = "r", delay = -0.02 },
            { kind = "sensor_position", sensor = "vane", offset_m = [13.1, 0, 0] },
            { kind = "none" },
            { kind = "unknown", axis = "L" },
            { kind = "rotor_speed", axis = "N", reaction = -0.2 },
        ]"#;

    #[test]
    fn every_kind_is_read_and_comes_back_as_written() {
        let effects = parse_effects(EVERY_KIND).unwrap();
        let kinds: Vec<EffectKind> = effects.iter().map(|declared| declared.effect.kind()).collect();
        assert_eq!(kinds, EffectKind::ALL);
        assert_eq!(effects[0].std, Some(0.01));
        for naming in [ControlNames::FixedWing, ControlNames::Rotorcraft] {
            let text: String = effects.iter().map(|declared| declared.to_toml(naming)).collect();
            assert_eq!(parse_effects(&text).unwrap(), effects, "{text}");
        }
    }

    #[test]
    fn entries_hold_exactly_the_keys_of_the_kind() {
        for declared in parse_effects(EVERY_KIND).unwrap() {
            let kind = declared.effect.kind();
            let mut wanted: Vec<&str> = kind.keys().to_vec();
            let mut found: Vec<&str> = declared.entries(ControlNames::Rotorcraft).into_iter().map(|(key, _)| key).collect();
            found.retain(|key| !["kind", "std"].contains(key));
            wanted.sort_unstable();
            found.sort_unstable();
            assert_eq!(found, wanted, "{}", kind.name());
        }
    }
}
