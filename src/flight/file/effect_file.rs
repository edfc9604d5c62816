//! Effects as tables of a TOML document: read with every key checked, and written back.
//!
//! Consumes a table such as `kind = "actuator_lag", control = "pedal", tau = 0.15`; produces an [`Effect`] and the
//! standard error of its main number where the table has the optional key `std`.
//! Refused: a kind, key, axis, variable, control, channel, sensor or term that does not exist, a key that is missing,
//! a number that is not finite, and a negative time, rate, width or length.

use super::toml_reader::{TomlEntry, TomlError, TomlTable, TomlText};
use crate::flight::channel::{Channel, ControlNames};
use crate::flight::control::Control;
use crate::flight::derivative::{Axis, Variable};
use crate::flight::effect::{Effect, EffectKind, PositionedSensor};
use crate::flight::effect_field::{EffectField, EffectReader, NumberRange};
use crate::flight::term::Term;
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
/// [`TomlError`] with the place of the first table that is not an effect.
pub fn parse_effects(text: &str) -> Result<Vec<DeclaredEffect>, TomlError> {
    let root = TomlText(text).parse()?;
    let root = TomlTable::root(TomlText(text), &root);
    root.allow_only(&["effect"])?;
    read_effects(&root, &Naming::default())
}

/// The `[[effect]]` tables of a root table.
pub(crate) fn read_effects(root: &TomlTable<'_>, naming: &Naming) -> Result<Vec<DeclaredEffect>, TomlError> {
    let Some(entry) = root.find("effect") else { return Ok(Vec::new()) };
    entry.tables("[[effect]]")?.iter().map(|table| read_effect(table, naming)).collect()
}

fn read_effect(table: &TomlTable<'_>, naming: &Naming) -> Result<DeclaredEffect, TomlError> {
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
    let effect = kind.read(&mut FieldReader { table, naming })?;
    if matches!(effect, Effect::CrossFeed { from, to, .. } if from == to) {
        return Err(table.require("to")?.misread("expected another control than `from`, found the same"));
    }
    let std = table.find("std").map(|entry| entry.not_negative()).transpose()?;
    Ok(DeclaredEffect { effect, std })
}

/// Fields of an effect's table, its names of controls watched.
struct FieldReader<'r, 't> {
    table: &'r TomlTable<'t>,
    naming: &'r Naming,
}

impl EffectReader for FieldReader<'_, '_> {
    type Error = TomlError;

    fn fixed_axis(&mut self, key: &'static str, wanted: Axis) -> Result<(), TomlError> {
        let entry = self.table.require(key)?;
        if axis(&entry)? == wanted {
            return Ok(());
        }
        Err(entry.misread(format_args!("expected {}, the axis that a rotor's shaft turns the fuselage about", wanted.name())))
    }

    fn axis(&mut self, key: &'static str) -> Result<Axis, TomlError> {
        axis(&self.table.require(key)?)
    }

    fn variable(&mut self, key: &'static str) -> Result<Variable, TomlError> {
        variable(&self.table.require(key)?, self.naming)
    }

    fn term(&mut self, key: &'static str) -> Result<Term, TomlError> {
        nonlinear_term(&self.table.require(key)?)
    }

    fn control(&mut self, key: &'static str) -> Result<Control, TomlError> {
        control(&self.table.require(key)?, self.naming)
    }

    fn channel(&mut self, key: &'static str) -> Result<Channel, TomlError> {
        channel(&self.table.require(key)?, self.naming)
    }

    fn channels(&mut self, key: &'static str) -> Result<[Channel; 2], TomlError> {
        let entry = self.table.require(key)?;
        let [one, other] = entry.texts::<2>()?;
        let channels = [channel_named(one, &entry, self.naming)?, channel_named(other, &entry, self.naming)?];
        match channels {
            [one, other] if one == other => Err(entry.misread("expected two different channels, found one twice")),
            [one, other] if one.quantity() != other.quantity() || is_control(one) != is_control(other) => {
                Err(entry.misread("expected two channels of one quantity, or two controls"))
            }
            channels => Ok(channels),
        }
    }

    fn sensor(&mut self, key: &'static str) -> Result<PositionedSensor, TomlError> {
        sensor(&self.table.require(key)?)
    }

    fn number(&mut self, key: &'static str, range: NumberRange) -> Result<f64, TomlError> {
        let entry = self.table.require(key)?;
        match range {
            NumberRange::Any => entry.number(),
            NumberRange::NotNegative => entry.not_negative(),
            NumberRange::Positive => entry.positive(),
            NumberRange::InertiaRatio => match entry.number()? {
                ratio if libm::fabs(ratio) <= 1.0 => Ok(ratio),
                _ => Err(entry.misread("expected a part of the fuselage's inertia, from -1 to 1")),
            },
        }
    }

    fn vector(&mut self, key: &'static str) -> Result<[f64; 3], TomlError> {
        self.table.require(key)?.vector()
    }
}

fn axis(entry: &TomlEntry<'_>) -> Result<Axis, TomlError> {
    let names: Vec<&str> = Axis::ALL.iter().map(|axis| axis.name()).collect();
    Axis::from_name(entry.text()?).ok_or_else(|| entry.choice("an axis", &names))
}

fn variable(entry: &TomlEntry<'_>, naming: &Naming) -> Result<Variable, TomlError> {
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

fn control(entry: &TomlEntry<'_>, naming: &Naming) -> Result<Control, TomlError> {
    let name = entry.text()?;
    let control = Control::from_name(name).ok_or_else(|| entry.choice("a control", &naming.control_names()))?;
    naming.note(name).map_err(|what| entry.misread(what))?;
    Ok(control)
}

fn channel(entry: &TomlEntry<'_>, naming: &Naming) -> Result<Channel, TomlError> {
    channel_named(entry.text()?, entry, naming)
}

fn channel_named(name: &str, entry: &TomlEntry<'_>, naming: &Naming) -> Result<Channel, TomlError> {
    let Some((channel, _)) = Channel::from_name(name) else {
        let names: Vec<&str> = Channel::ALL.iter().map(|channel| channel.name(naming.offered())).collect();
        return Err(entry.choice("a channel", &names));
    };
    naming.note(name).map_err(|what| entry.misread(what))?;
    Ok(channel)
}

fn is_control(channel: Channel) -> bool {
    Channel::CONTROLS.contains(&channel)
}

fn sensor(entry: &TomlEntry<'_>) -> Result<PositionedSensor, TomlError> {
    let name = entry.text()?;
    let found = PositionedSensor::ALL.into_iter().find(|sensor| sensor.name() == name);
    found.ok_or_else(|| entry.choice("a sensor", &PositionedSensor::ALL.map(PositionedSensor::name)))
}

fn nonlinear_term(entry: &TomlEntry<'_>) -> Result<Term, TomlError> {
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
    /// Names.
    Names(Vec<String>),
    /// A number.
    Number(f64),
    /// Three numbers.
    Vector([f64; 3]),
}

impl DeclaredEffect {
    /// Keys and values of the effect's table, `kind` first and `std` last, for any format that has tables.
    pub fn entries(&self, naming: ControlNames) -> Vec<(&'static str, EffectValue)> {
        use EffectValue::{Name, Names, Number, Vector};
        let mut entries = vec![("kind", Name(self.effect.kind().name().to_owned()))];
        self.effect.for_each_field(|key, field| {
            let value = match field {
                EffectField::Axis(axis) | EffectField::FixedAxis(axis) => Name(axis.name().to_owned()),
                EffectField::Variable(variable) => Name(variable.name(naming).to_owned()),
                EffectField::Term(term) => Name(term.to_string()),
                EffectField::Control(control) => Name(control.name(naming).to_owned()),
                EffectField::Channel(channel) => Name(channel.name(naming).to_owned()),
                EffectField::Channels(channels) => {
                    Names(channels.iter().map(|channel| channel.name(naming).to_owned()).collect())
                }
                EffectField::Sensor(sensor) => Name(sensor.name().to_owned()),
                EffectField::Number(number) => Number(number),
                EffectField::Vector(vector) => Vector(vector),
            };
            entries.push((key, value));
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
                EffectValue::Names(names) => writeln!(text, "{key} = {names:?}"),
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
    use crate::flight::effect::EVERY_KIND;

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
