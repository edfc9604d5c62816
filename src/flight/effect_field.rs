//! Fields of an effect: what its table in a file, a JSON object or a message has beside the kind.

use super::channel::Channel;
use super::control::Control;
use super::derivative::{Axis, Variable};
use super::positioned_sensor::PositionedSensor;
use super::term::Term;

/// A field's value.
#[derive(Clone, Copy, Debug, PartialEq)]
#[expect(missing_docs, reason = "variants are what their names say")]
pub enum EffectField {
    Axis(Axis),
    /// An axis that every effect of the kind has.
    FixedAxis(Axis),
    /// A motion variable or control.
    Variable(Variable),
    /// A nonlinear term.
    Term(Term),
    Control(Control),
    Channel(Channel),
    /// Two different channels.
    Channels([Channel; 2]),
    /// A sensor whose position matters.
    Sensor(PositionedSensor),
    Number(f64),
    /// Three numbers, body axes.
    Vector([f64; 3]),
}

/// Which finite numbers a field may have.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NumberRange {
    /// Any.
    Any,
    /// Zero or more.
    NotNegative,
    /// More than zero.
    Positive,
    /// From -1 to 1: the rotor's inertia over the fuselage's.
    InertiaRatio,
}

/// Where an effect's fields are read from, by key; each in the order of the table.
#[allow(clippy::missing_errors_doc, missing_docs, reason = "one function a type of field, with the errors of the source")]
pub trait EffectReader {
    /// Why a field cannot be read.
    type Error;
    fn fixed_axis(&mut self, key: &'static str, axis: Axis) -> Result<(), Self::Error>;
    fn axis(&mut self, key: &'static str) -> Result<Axis, Self::Error>;
    fn variable(&mut self, key: &'static str) -> Result<Variable, Self::Error>;
    fn term(&mut self, key: &'static str) -> Result<Term, Self::Error>;
    fn control(&mut self, key: &'static str) -> Result<Control, Self::Error>;
    fn channel(&mut self, key: &'static str) -> Result<Channel, Self::Error>;
    fn channels(&mut self, key: &'static str) -> Result<[Channel; 2], Self::Error>;
    fn sensor(&mut self, key: &'static str) -> Result<PositionedSensor, Self::Error>;
    fn number(&mut self, key: &'static str, range: NumberRange) -> Result<f64, Self::Error>;
    fn vector(&mut self, key: &'static str) -> Result<[f64; 3], Self::Error>;
}

/// Reads a field of the type that the table names.
macro_rules! read_field {
    ($from:ident $key:ident number) => {
        $from.number(stringify!($key), NumberRange::Any)?
    };
    ($from:ident $key:ident factor) => {
        $from.number(stringify!($key), NumberRange::Any)?
    };
    ($from:ident $key:ident not_negative) => {
        $from.number(stringify!($key), NumberRange::NotNegative)?
    };
    ($from:ident $key:ident positive) => {
        $from.number(stringify!($key), NumberRange::Positive)?
    };
    ($from:ident $key:ident inertia_ratio) => {
        $from.number(stringify!($key), NumberRange::InertiaRatio)?
    };
    ($from:ident $key:ident $of:ident) => {
        $from.$of(stringify!($key))?
    };
}

/// A field's value.
macro_rules! field {
    (axis $value:ident) => {
        EffectField::Axis($value)
    };
    (variable $value:ident) => {
        EffectField::Variable($value)
    };
    (term $value:ident) => {
        EffectField::Term($value)
    };
    (control $value:ident) => {
        EffectField::Control($value)
    };
    (channel $value:ident) => {
        EffectField::Channel($value)
    };
    (channels $value:ident) => {
        EffectField::Channels($value)
    };
    (sensor $value:ident) => {
        EffectField::Sensor($value)
    };
    (vector $value:ident) => {
        EffectField::Vector($value)
    };
    ($number:ident $value:ident) => {
        EffectField::Number($value)
    };
}

/// One where a field is a factor, else zero.
macro_rules! neutral {
    () => { 0.0 };
    (factor $($rest:ident)*) => { 1.0 };
    ($other:ident $($rest:ident)*) => { neutral!($($rest)*) };
}

pub(crate) use {field, neutral, read_field};
