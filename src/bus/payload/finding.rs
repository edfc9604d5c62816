//! A finding of the diagnosis on the bus: how it stands, the effect by its places and numbers, the sentence.

use super::{ABSENT, Header, at, bytes_of, place, service, text_of};
use crate::bus::error::BusError;
use crate::diagnosis::record::{FindingRecord, STATEMENT, Standing};
use crate::flight::channel::Channel;
use crate::flight::control::Control;
use crate::flight::derivative::{Axis, Variable};
use crate::flight::effect::{Effect, EffectKind, PositionedSensor, cause};
use crate::flight::term::Term;
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
    pub header: Header,
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
            header: Header { time_s: record.time_s, ..Header::default() },
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
    match *effect {
        Effect::SensorPosition { offset_m, .. } => offset_m,
        Effect::Turbulence { sigma, length } => [sigma, length, 0.0],
        _ => [effect.main_number().unwrap_or(0.0), 0.0, 0.0],
    }
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
            standing: at(&Standing::ALL, self.standing, SCHEMA, "standing")?,
            number: self.number,
            effect: self.effect()?,
            std: self.std,
            probability: self.probability,
            rivals: self.rivals,
            manoeuvres: self.manoeuvres,
            ..FindingRecord::EMPTY
        };
        record.say(text_of(&self.statement, self.statement_bytes, SCHEMA, "statement_bytes")?);
        Ok(record)
    }

    fn effect(&self) -> Result<Effect, BusError> {
        let axis = || at(&Axis::ALL, self.which, SCHEMA, "which");
        let control = || at(&Control::ALL, self.which, SCHEMA, "which");
        let channel = || at(&Channel::ALL, self.which, SCHEMA, "which");
        let variable = || at(&Variable::ALL, self.first, SCHEMA, "first");
        let [number, second, _] = self.numbers;
        Ok(match at(EffectKind::ALL, self.kind, SCHEMA, "kind")? {
            EffectKind::Derivative => Effect::Derivative { axis: axis()?, variable: variable()?, delta: number },
            EffectKind::Nonlinear => {
                let form = at(&FORMS, self.form, SCHEMA, "form")?;
                let x = variable()?;
                let y = if self.form == 3 { at(&Variable::ALL, self.second, SCHEMA, "second")? } else { x };
                Effect::Nonlinear { axis: axis()?, term: form(x, y), coefficient: number }
            }
            EffectKind::ControlEffectiveness => Effect::ControlEffectiveness { control: control()?, factor: number },
            EffectKind::ActuatorLag => Effect::ActuatorLag { control: control()?, tau: number },
            EffectKind::TransportDelay => Effect::TransportDelay { control: control()?, delay: number },
            EffectKind::RateLimit => Effect::RateLimit { control: control()?, rate: number },
            EffectKind::DeadZone => Effect::DeadZone { control: control()?, half_width: number },
            EffectKind::CrossFeed => {
                Effect::CrossFeed { from: control()?, to: at(&Control::ALL, self.first, SCHEMA, "first")?, gain: number }
            }
            EffectKind::RotorSpeed => Effect::RotorSpeed { axis: axis()?, coefficient: number },
            EffectKind::RotorReaction => Effect::RotorReaction { reaction: number },
            EffectKind::FlightPath => Effect::FlightPath { axis: axis()?, variable: variable()?, slope: number },
            EffectKind::Turbulence => Effect::Turbulence { sigma: number, length: second },
            EffectKind::SensorBias => Effect::SensorBias { channel: channel()?, value: number },
            EffectKind::SensorScale => Effect::SensorScale { channel: channel()?, factor: number },
            EffectKind::SensorLag => Effect::SensorLag { channel: channel()?, tau: number },
            EffectKind::SensorDelay => Effect::SensorDelay { channel: channel()?, delay: number },
            EffectKind::SensorPosition => {
                let sensor = at(&PositionedSensor::ALL, self.which, SCHEMA, "which")?;
                Effect::SensorPosition { sensor, offset_m: self.numbers }
            }
            EffectKind::None => Effect::None,
            EffectKind::Unknown => Effect::Unknown { axis: axis()? },
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// One of each kind.
    fn effects() -> Vec<Effect> {
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
            let (standing, number) = (Standing::TakenBack, 3);
            let mut record =
                FindingRecord { time_s: 12.5, standing, number, effect, std: 0.02, probability: 0.97, ..FindingRecord::EMPTY };
            record.say("r is measured late");
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
