//! Payload of a finding of the diagnosis: its status, the effect by indices and values, the sentence.

use super::message::{ABSENT, MessageHeader, at, bytes_of, place, service, text_of};
use crate::flight::channel::Channel;
use crate::flight::control::Control;
use crate::flight::derivative::{Axis, Variable};
use crate::flight::effect::{Effect, EffectKind, PositionedSensor, cause};
use crate::flight::effect_field::{EffectField, EffectReader, NumberRange};
use crate::flight::term::Term;
use crate::io::bus::error::BusError;
use crate::postflight::diagnosis::record::{FindingRecord, FindingStatus, STATEMENT};
use iceoryx2::prelude::ZeroCopySend;

const SCHEMA: &str = "sideslip.Finding.1";
/// Forms of a term, by place.
const FORMS: [fn(Variable, Variable) -> Term; 4] =
    [|x, _| Term::Linear(x), |x, _| Term::SignedSquare(x), |x, _| Term::Cube(x), Term::Product];

/// A finding, with the meaning of [`FindingRecord`]; `time_s` of the header is the record's.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, ZeroCopySend)]
#[type_name("sideslip.Finding.1")]
pub struct FindingPayload {
    /// Its header.
    pub header: MessageHeader,
    /// The effect's numbers: its main number first (a position has three); of turbulence the scale length second.
    pub numbers: [f64; 3],
    /// Standard error of the main number; NaN where it has none.
    pub std: f64,
    /// How likely this is the cause; NaN where that cannot be said.
    pub probability: f64,
    /// How it stands: waiting 0, found 1, taken back 2, failed 3.
    pub standing: u32,
    /// Which finding of this run.
    pub number: u32,
    /// Other causes that the data do not rule out.
    pub rivals: u32,
    /// Manoeuvres that it rests on.
    pub manoeuvres: u32,
    /// Place of the kind of effect, in the order of the conventions.
    pub kind: u32,
    /// Place of its axis, control (of an interlink, that which the pilot moves), channel or sensor; [`ABSENT`] without one.
    pub which: u32,
    /// Place of its variable, of its term's first factor, or of the control that an interlink moves; [`ABSENT`] without one.
    pub first: u32,
    /// Place of its term's second factor; [`ABSENT`] without one.
    pub second: u32,
    /// Form of its term: x 0, x|x| 1, x^3 2, xy 3.
    pub form: u32,
    /// Bytes of the statement.
    pub statement_bytes: u32,
    /// The statement, UTF-8; zeros behind it.
    pub statement: [u8; STATEMENT],
}
service!(FindingPayload, "sideslip/finding", "sideslip.Finding.1", buffer 64, history 16);

impl From<&FindingRecord> for FindingPayload {
    fn from(record: &FindingRecord) -> Self {
        let (which, first, second, form) = places(&record.effect);
        FindingPayload {
            header: MessageHeader { time_s: record.time_s, ..MessageHeader::default() },
            numbers: numbers(&record.effect),
            std: record.std,
            probability: record.probability,
            standing: place(record.standing.index()),
            number: record.number,
            rivals: record.rivals,
            manoeuvres: record.manoeuvres,
            kind: place(record.effect.kind() as usize),
            which,
            first,
            second,
            form,
            statement_bytes: place(record.statement.len()),
            statement: bytes_of(&record.statement),
        }
    }
}

fn numbers(effect: &Effect) -> [f64; 3] {
    let (mut numbers, mut count) = ([0.0; 3], 0);
    effect.for_each_field(|_, field| match field {
        EffectField::Vector(vector) => numbers = vector,
        EffectField::Number(number) => {
            if let Some(entry) = numbers.get_mut(count) {
                *entry = number;
            }
            count += 1;
        }
        _ => {}
    });
    numbers
}

/// `which`, `first`, `second` and `form`.
fn places(effect: &Effect) -> (u32, u32, u32, u32) {
    let (_, [which, other], term) = cause(effect);
    let of = |index: u8| if index == u8::MAX { ABSENT } else { index.into() };
    let (first, second, form) = match term {
        None => (of(other), ABSENT, 0),
        Some(Term::Linear(x)) => (place(x.index()), ABSENT, 0),
        Some(Term::SignedSquare(x)) => (place(x.index()), ABSENT, 1),
        Some(Term::Cube(x)) => (place(x.index()), ABSENT, 2),
        Some(Term::Product(x, y)) => (place(x.index()), place(y.index()), 3),
    };
    (of(which), first, second, form)
}

impl FindingPayload {
    /// The record.
    ///
    /// # Errors
    /// [`BusError::Payload`] for a code that there is not, and a statement that is no text.
    pub fn record(&self) -> Result<FindingRecord, BusError> {
        let mut record = FindingRecord {
            time_s: self.header.time_s,
            standing: at(&FindingStatus::ALL, self.standing, SCHEMA, "standing")?,
            number: self.number,
            effect: self.effect()?,
            std: self.std,
            probability: self.probability,
            rivals: self.rivals,
            manoeuvres: self.manoeuvres,
            ..FindingRecord::EMPTY
        };
        record.set_statement(text_of(&self.statement, self.statement_bytes, SCHEMA, "statement_bytes")?);
        Ok(record)
    }

    fn effect(&self) -> Result<Effect, BusError> {
        at(EffectKind::ALL, self.kind, SCHEMA, "kind")?.read(&mut FieldReader { payload: self, places: 0, numbers: 0 })
    }
}

/// Fields of the effect, in order: its first axis, control, channel or sensor is `which`, a second one `first`.
struct FieldReader<'p> {
    payload: &'p FindingPayload,
    places: usize,
    numbers: usize,
}

impl FieldReader<'_> {
    fn place<T: Copy>(&mut self, all: &[T]) -> Result<T, BusError> {
        self.places += 1;
        match self.places {
            1 => at(all, self.payload.which, SCHEMA, "which"),
            _ => at(all, self.payload.first, SCHEMA, "first"),
        }
    }
}

impl EffectReader for FieldReader<'_> {
    type Error = BusError;

    fn fixed_axis(&mut self, _: &'static str, _: Axis) -> Result<(), BusError> {
        Ok(())
    }

    fn axis(&mut self, _: &'static str) -> Result<Axis, BusError> {
        self.place(&Axis::ALL)
    }

    fn variable(&mut self, _: &'static str) -> Result<Variable, BusError> {
        at(&Variable::ALL, self.payload.first, SCHEMA, "first")
    }

    fn term(&mut self, key: &'static str) -> Result<Term, BusError> {
        let form = at(&FORMS, self.payload.form, SCHEMA, "form")?;
        let x = self.variable(key)?;
        let y = if self.payload.form == 3 { at(&Variable::ALL, self.payload.second, SCHEMA, "second")? } else { x };
        Ok(form(x, y))
    }

    fn control(&mut self, _: &'static str) -> Result<Control, BusError> {
        self.place(&Control::ALL)
    }

    fn channel(&mut self, _: &'static str) -> Result<Channel, BusError> {
        self.place(&Channel::ALL)
    }

    fn channels(&mut self, _: &'static str) -> Result<[Channel; 2], BusError> {
        Ok([self.place(&Channel::ALL)?, self.place(&Channel::ALL)?])
    }

    fn sensor(&mut self, _: &'static str) -> Result<PositionedSensor, BusError> {
        self.place(&PositionedSensor::ALL)
    }

    fn number(&mut self, _: &'static str, _: NumberRange) -> Result<f64, BusError> {
        let number = self.payload.numbers.get(self.numbers).copied().unwrap_or_default();
        self.numbers += 1;
        Ok(number)
    }

    fn vector(&mut self, _: &'static str) -> Result<[f64; 3], BusError> {
        Ok(self.payload.numbers)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::flight::effect::EVERY_KIND;
    use crate::flight::file::effect_file::parse_effects;

    /// One of each kind, and every form of a term.
    fn effects() -> Vec<Effect> {
        let written = parse_effects(EVERY_KIND).unwrap().into_iter().map(|declared| declared.effect);
        drawn_up().into_iter().chain(written).collect()
    }

    fn drawn_up() -> Vec<Effect> {
        let (axis, variable, control, channel) = (Axis::N, Variable::Pedal, Control::LatCyclic, Channel::Beta);
        let nonlinear = |term| Effect::Nonlinear { axis, term, coefficient: 0.1 };
        vec![
            Effect::Derivative { axis, variable, delta: -0.2 },
            nonlinear(Term::SignedSquare(Variable::V)),
            nonlinear(Term::Cube(Variable::P)),
            nonlinear(Term::Product(Variable::P, Variable::V)),
            Effect::ControlEffectiveness { control, factor: 0.8 },
            Effect::ActuatorLag { control, tau: 0.2 },
            Effect::TransportDelay { control, delay: 0.1 },
            Effect::RateLimit { control, rate: 0.05 },
            Effect::DeadZone { control, half_width: 0.004 },
            Effect::CrossFeed { from: Control::Collective, to: Control::Pedal, gain: 0.3 },
            Effect::RotorSpeed { axis, coefficient: 0.01 },
            Effect::RotorReaction { reaction: 0.2 },
            Effect::FlightPath { axis, variable, slope: 0.5 },
            Effect::Turbulence { sigma: 1.5, length: 200.0 },
            Effect::SensorBias { channel, value: 0.01 },
            Effect::SensorScale { channel, factor: 1.1 },
            Effect::SensorLag { channel, tau: 0.05 },
            Effect::SensorDelay { channel, delay: -0.05 },
            Effect::SensorPosition { sensor: PositionedSensor::Vane, offset_m: [1.0, -2.0, 0.5] },
            Effect::Exchanged { channels: [Channel::P, Channel::R] },
            Effect::None,
            Effect::Unknown { axis },
        ]
    }

    #[test]
    fn every_kind_of_finding_comes_back_as_it_was() {
        for &kind in EffectKind::ALL {
            assert!(effects().iter().any(|effect| effect.kind() == kind), "{}", kind.name());
        }
        for effect in effects() {
            let (standing, number) = (FindingStatus::Retracted, 3);
            let mut record =
                FindingRecord { time_s: 12.5, standing, number, effect, std: 0.02, probability: 0.97, ..FindingRecord::EMPTY };
            record.set_statement("r is measured late");
            assert_eq!(FindingPayload::from(&record).record().unwrap(), record);
        }
    }

    #[test]
    fn codes_that_there_are_not_are_refused() {
        let record = FindingRecord { effect: effects()[3], ..FindingRecord::EMPTY };
        let payload = FindingPayload::from(&record);
        for wrong in [
            FindingPayload { standing: 4, ..payload },
            FindingPayload { kind: place(EffectKind::ALL.len()), ..payload },
            FindingPayload { which: 6, ..payload },
            FindingPayload { first: ABSENT, ..payload },
            FindingPayload { second: ABSENT, ..payload },
            FindingPayload { form: 4, ..payload },
            FindingPayload { statement_bytes: 241, ..payload },
        ] {
            assert!(wrong.record().is_err(), "{wrong:?}");
        }
    }
}
