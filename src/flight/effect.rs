//! Effects: an error in simulated data, a hypothesis about a model, or an extension of one, in one vocabulary.
//!
//! An effect changes a model (`model`), the path from the pilot's control to the blade, the air, or an instrument.
//! Every number is finite, SI and radians. A kind is one variant of [`Effect`] and one line of the table at `kinds!`: names,
//! keys, types and main number follow from it, and so do `effect_file`, JSON, the bus and [`same_cause`].

use super::channel::Channel;
use super::control::Control;
use super::derivative::{Axis, Variable};
use super::effect_field::{EffectField, EffectReader, NumberRange, field, neutral, read_field};
pub use super::positioned_sensor::PositionedSensor;
use super::term::Term;

/// One effect with its numbers.
#[derive(Clone, Copy, Debug, PartialEq)]
#[expect(missing_docs, reason = "variants are what their names say")]
pub enum Effect {
    /// Adds `delta` to a derivative; one that the model lacks counts as zero.
    Derivative {
        /// Axis of the derivative.
        axis: Axis,
        /// Variable of the derivative.
        variable: Variable,
        /// What is added, in the derivative's unit.
        delta: f64,
    },
    /// Adds `coefficient * term` to an axis; the term is a product of deviations from trim.
    Nonlinear {
        /// Axis that is added to.
        axis: Axis,
        /// A nonlinear term.
        term: Term,
        coefficient: f64,
    },
    /// Multiplies all derivatives with respect to a control.
    ControlEffectiveness { control: Control, factor: f64 },
    /// First-order lag between control and blade.
    ActuatorLag {
        control: Control,
        /// Time constant, s.
        tau: f64,
    },
    /// Pure delay between control and blade.
    TransportDelay {
        control: Control,
        /// Delay, s.
        delay: f64,
    },
    /// The blade moves no faster than this.
    RateLimit {
        control: Control,
        /// Rate, rad/s.
        rate: f64,
    },
    /// Deviations within the half width about trim move nothing; beyond it the blade follows less the half width.
    DeadZone { control: Control, half_width: f64 },
    /// The deviation of one control also moves another.
    CrossFeed {
        /// The control that the pilot moves.
        from: Control,
        /// The control that moves with it.
        to: Control,
        /// Radians of `to` a radian of `from`.
        gain: f64,
    },
    /// Adds `coefficient * (rotor speed - trim rotor speed)` to an axis.
    RotorSpeed {
        /// Axis that is added to.
        axis: Axis,
        /// Coefficient per rad/s.
        coefficient: f64,
    },
    /// What turns the rotor faster turns the fuselage the other way: with c the rotor's inertia over the fuselage's about its
    /// shaft, positive for a rotor that turns against a positive yaw (anticlockwise from above), the yawing moment N of all else
    /// gives `dr/dt = (N + c dOmega/dt)/(1 + |c|)`: of the torque in the shaft the air holds all but I (dOmega/dt - sigma dr/dt),
    /// sigma the sign of c.
    RotorReaction {
        /// c.
        reaction: f64,
    },
    /// A derivative that changes with the flight-path angle of the trim.
    FlightPath {
        /// Axis of the derivative.
        axis: Axis,
        /// Variable of the derivative.
        variable: Variable,
        /// Change of the derivative a radian of flight-path angle, climb positive, zero in level flight.
        slope: f64,
    },
    /// Gusts: a disturbance, not a model error.
    Turbulence {
        /// Standard deviation of each gust component, m/s.
        sigma: f64,
        /// Scale length, m.
        length: f64,
    },
    /// An instrument reads that much more.
    SensorBias {
        channel: Channel,
        /// Bias in the channel's unit.
        value: f64,
    },
    /// An instrument reads that many times the true value.
    SensorScale { channel: Channel, factor: f64 },
    /// First-order lag of an instrument.
    SensorLag {
        channel: Channel,
        /// Time constant, s.
        tau: f64,
    },
    /// Time skew of an instrument; positive reads late.
    SensorDelay {
        channel: Channel,
        /// Delay, s.
        delay: f64,
    },
    /// Accelerometer or vane stands elsewhere than the run says.
    SensorPosition {
        /// Which of the two.
        sensor: PositionedSensor,
        /// True position less the run's, body axes, m.
        offset_m: [f64; 3],
    },
    /// Two channels are recorded under each other's name.
    Exchanged {
        /// Which, of one quantity; their order says nothing.
        channels: [Channel; 2],
    },
    /// The model explains the data within their noise and its own tolerance.
    None,
    /// Something is there on that axis, and no other effect explains it.
    Unknown { axis: Axis },
}

/// What sort of cause an effect is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Family {
    /// A derivative is wrong, or changes with flight path.
    Derivative,
    /// A nonlinear term is missing.
    Nonlinear,
    /// The path from control to blade.
    Control,
    /// Rotor speed.
    Rotor,
    /// The air.
    Disturbance,
    /// An instrument.
    Instrument,
    /// Nothing.
    None,
    /// Something without a name.
    Unknown,
}

/// An error of one channel's instrument.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum SensorError {
    /// Added to the true value, in the channel's unit.
    Bias(f64),
    /// The true value is multiplied by it.
    Scale(f64),
    /// Time constant of a first-order lag, s.
    Lag(f64),
    /// Time skew, s; positive reads late.
    Delay(f64),
}

macro_rules! kinds {
    ($(
        $variant:ident $name:literal $family:ident $([$fixed:ident = $axis:ident])?
        { $($field:ident: $of:ident),* } $(main $main:ident)?;
    )*) => {
        /// The kind of an effect, without its numbers.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
        pub enum EffectKind {
            $(#[doc = concat!("`", $name, "`.")] $variant,)*
        }

        impl EffectKind {
            /// Every kind.
            pub const ALL: &'static [EffectKind] = &[$(EffectKind::$variant,)*];

            /// The name in files.
            pub const fn name(self) -> &'static str {
                match self { $(EffectKind::$variant => $name,)* }
            }

            /// The keys that a table of this kind must have beside `kind`.
            pub const fn keys(self) -> &'static [&'static str] {
                match self { $(EffectKind::$variant => &[$(stringify!($fixed),)? $(stringify!($field)),*],)* }
            }

            /// What sort of cause it is.
            pub const fn family(self) -> Family {
                match self { $(EffectKind::$variant => Family::$family,)* }
            }

            /// Its main number where nothing is wrong: one of a factor, else zero.
            pub const fn neutral(self) -> f64 {
                match self { $(EffectKind::$variant => neutral!($($of)*),)* }
            }

            /// The effect of this kind with the fields that are read, in the order of the table.
            ///
            /// # Errors
            /// Those of the reader.
            pub fn read<R: EffectReader>(self, from: &mut R) -> Result<Effect, R::Error> {
                Ok(match self {
                    $(EffectKind::$variant => {
                        $(from.fixed_axis(stringify!($fixed), Axis::$axis)?;)?
                        Effect::$variant { $($field: read_field!(from $field $of)),* }
                    })*
                })
            }
        }

        impl Effect {
            /// The kind.
            pub const fn kind(&self) -> EffectKind {
                match self { $(Effect::$variant { .. } => EffectKind::$variant,)* }
            }

            /// Every field with its key, in the order of the table.
            pub fn for_each_field(&self, mut of: impl FnMut(&'static str, EffectField)) {
                match *self {
                    $(Effect::$variant { $($field),* } => {
                        $(of(stringify!($fixed), EffectField::FixedAxis(Axis::$axis));)?
                        $(of(stringify!($field), field!($of $field));)*
                    })*
                }
            }

            /// The number that a standard error is about: `sigma` for turbulence, the offset component largest in magnitude
            /// for a position; none for `none` and `unknown`.
            pub fn main_number(&self) -> Option<f64> {
                match *self {
                    $($(Effect::$variant { $main: number, .. } => Some(number),)?)*
                    Effect::SensorPosition { offset_m: [x, y, z], .. } => {
                        let larger = |largest: f64, c: f64| if libm::fabs(c) > libm::fabs(largest) { c } else { largest };
                        Some([y, z].into_iter().fold(x, larger))
                    }
                    _ => None,
                }
            }

            /// The main number, to be changed; none where the effect has none or a vector.
            pub fn main_number_mut(&mut self) -> Option<&mut f64> {
                match self {
                    $($(Effect::$variant { $main: number, .. } => Some(number),)?)*
                    _ => None,
                }
            }
        }
    };
}

// A kind in a line: name in files, family, what every table of it has, fields by key with their types, main number.
kinds! {
    Derivative "derivative" Derivative { axis: axis, variable: variable, delta: number } main delta;
    Nonlinear "nonlinear" Nonlinear { axis: axis, term: term, coefficient: number } main coefficient;
    ControlEffectiveness "control_effectiveness" Control { control: control, factor: factor } main factor;
    ActuatorLag "actuator_lag" Control { control: control, tau: not_negative } main tau;
    TransportDelay "transport_delay" Control { control: control, delay: not_negative } main delay;
    RateLimit "rate_limit" Control { control: control, rate: positive } main rate;
    DeadZone "dead_zone" Control { control: control, half_width: not_negative } main half_width;
    CrossFeed "cross_feed" Control { from: control, to: control, gain: number } main gain;
    RotorSpeed "rotor_speed" Rotor { axis: axis, coefficient: number } main coefficient;
    FlightPath "flight_path" Derivative { axis: axis, variable: variable, slope: number } main slope;
    Turbulence "turbulence" Disturbance { sigma: not_negative, length: positive } main sigma;
    SensorBias "sensor_bias" Instrument { channel: channel, value: number } main value;
    SensorScale "sensor_scale" Instrument { channel: channel, factor: factor } main factor;
    SensorLag "sensor_lag" Instrument { channel: channel, tau: not_negative } main tau;
    SensorDelay "sensor_delay" Instrument { channel: channel, delay: number } main delay;
    SensorPosition "sensor_position" Instrument { sensor: sensor, offset_m: vector };
    None "none" None {};
    Unknown "unknown" Unknown { axis: axis };
    RotorReaction "rotor_speed" Rotor [axis = N] { reaction: inertia_ratio } main reaction;
    Exchanged "exchanged" Instrument { channels: channels };
}

impl Effect {
    /// The first field that this picks.
    fn first<T>(&self, pick: impl Fn(EffectField) -> Option<T>) -> Option<T> {
        let mut found = None;
        self.for_each_field(|_, field| {
            if found.is_none() {
                found = pick(field);
            }
        });
        found
    }

    /// The channel whose instrument it is on, where it is on one.
    pub fn sensor_channel(&self) -> Option<Channel> {
        self.sensor_error().map(|(channel, _)| channel)
    }

    /// The channel and the error of its instrument, of an effect on one channel. Every place that applies such errors matches on
    /// [`SensorError`] in full, so that a new one is forgotten nowhere.
    pub const fn sensor_error(&self) -> Option<(Channel, SensorError)> {
        match *self {
            Effect::SensorBias { channel, value } => Some((channel, SensorError::Bias(value))),
            Effect::SensorScale { channel, factor } => Some((channel, SensorError::Scale(factor))),
            Effect::SensorLag { channel, tau } => Some((channel, SensorError::Lag(tau))),
            Effect::SensorDelay { channel, delay } => Some((channel, SensorError::Delay(delay))),
            Effect::Derivative { .. }
            | Effect::Nonlinear { .. }
            | Effect::ControlEffectiveness { .. }
            | Effect::ActuatorLag { .. }
            | Effect::TransportDelay { .. }
            | Effect::RateLimit { .. }
            | Effect::DeadZone { .. }
            | Effect::CrossFeed { .. }
            | Effect::RotorSpeed { .. }
            | Effect::RotorReaction { .. }
            | Effect::FlightPath { .. }
            | Effect::Turbulence { .. }
            | Effect::SensorPosition { .. }
            | Effect::Exchanged { .. }
            | Effect::Unknown { .. }
            | Effect::None => None,
        }
    }

    /// Whether a channel or control is recorded with the sign turned, or two under each other's name.
    pub const fn is_recording_fault(&self) -> bool {
        match *self {
            Effect::Exchanged { .. } => true,
            Effect::SensorScale { factor, .. } | Effect::ControlEffectiveness { factor, .. } => factor < 0.0,
            _ => false,
        }
    }

    /// The axis whose force or moment it changes, where that is one.
    pub fn axis(&self) -> Option<Axis> {
        self.first(|field| match field {
            EffectField::Axis(axis) | EffectField::FixedAxis(axis) => Some(axis),
            _ => None,
        })
    }

    /// The control without whose motion it does nothing.
    pub fn acting_control(&self) -> Option<Control> {
        self.first(|field| match field {
            EffectField::Control(control) => Some(control),
            EffectField::Variable(variable) => Control::ALL.into_iter().find(|control| control.variable() == variable),
            _ => None,
        })
    }
}

impl EffectKind {
    /// The kind of that name; of two that share it the first; the other is distinguished by its keys.
    pub fn from_name(name: &str) -> Option<EffectKind> {
        EffectKind::ALL.iter().copied().find(|kind| kind.name() == name)
    }
}

/// The same cause, whatever its number.
pub fn same_cause(a: &Effect, b: &Effect) -> bool {
    cause(a) == cause(b)
}

/// What a cause is called, without its number: its kind, the places of its axis, controls, channel or sensor, and its term or
/// variable.
pub fn cause(effect: &Effect) -> (EffectKind, [u8; 2], Option<Term>) {
    let (mut places, mut count, mut of) = ([u8::MAX; 2], 0, None);
    effect.for_each_field(|_, field| {
        let place = match field {
            EffectField::Axis(axis) => axis.index(),
            EffectField::Control(control) => control.index(),
            EffectField::Channel(channel) => channel.index(),
            EffectField::Channels(channels) => {
                let [one, other] = channels.map(|channel| channel.index() as u8);
                return places = [one.min(other), one.max(other)];
            }
            EffectField::Sensor(sensor) => sensor as usize,
            EffectField::Variable(variable) => return of = Some(Term::Linear(variable)),
            EffectField::Term(term) => return of = Some(term),
            EffectField::FixedAxis(_) | EffectField::Number(_) | EffectField::Vector(_) => return,
        };
        if let Some(entry) = places.get_mut(count) {
            *entry = place as u8;
        }
        count += 1;
    });
    (effect.kind(), places, of)
}

/// One table of each kind, as a person would write it: every kind is read, written and sent in the tests of files and of the bus.
#[cfg(all(test, feature = "std"))]
pub(crate) const EVERY_KIND: &str = r#"
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
        { kind = "exchanged", channels = ["p", "r"] },
    ]"#;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn kinds_are_found_by_name_and_families_are_as_agreed() {
        for &kind in EffectKind::ALL {
            let shares = kind == EffectKind::RotorReaction;
            assert_eq!(EffectKind::from_name(kind.name()), Some(if shares { EffectKind::RotorSpeed } else { kind }));
            let of_instrument = kind.name().starts_with("sensor_") || kind == EffectKind::Exchanged;
            assert_eq!(of_instrument, kind.family() == Family::Instrument);
        }
        assert_eq!(EffectKind::ALL.len(), 20);
        assert_eq!(EffectKind::FlightPath.family(), Family::Derivative);
        assert_eq!(EffectKind::from_name("sensor"), None);
    }

    #[test]
    fn the_main_number_of_a_position_is_its_largest_component() {
        let offset = Effect::SensorPosition { sensor: PositionedSensor::Vane, offset_m: [1.0, -3.0, 2.0] };
        assert_eq!(offset.main_number(), Some(-3.0));
        assert_eq!(Effect::Turbulence { sigma: 1.5, length: 200.0 }.main_number(), Some(1.5));
        assert_eq!(Effect::None.main_number(), None);
    }
}
