//! Effects: a flaw put into data, a hypothesis about a model, or an extension of one; the same words for all three.
//!
//! An effect changes a model (`model`), the path from the pilot's control to the blade, the air, or an instrument.
//! Every number is finite, SI and radians. `effect_file` reads and writes them as tables.

use super::channel::Channel;
use super::control::Control;
use super::derivative::{Axis, Variable};
use super::term::Term;

/// One effect with its numbers.
#[derive(Clone, Copy, Debug, PartialEq)]
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
        /// Its coefficient.
        coefficient: f64,
    },
    /// Multiplies all derivatives with respect to a control.
    ControlEffectiveness {
        /// The control.
        control: Control,
        /// The factor.
        factor: f64,
    },
    /// First-order lag between control and blade.
    ActuatorLag {
        /// The control.
        control: Control,
        /// Time constant, s.
        tau: f64,
    },
    /// Pure delay between control and blade.
    TransportDelay {
        /// The control.
        control: Control,
        /// Delay, s.
        delay: f64,
    },
    /// The blade moves no faster than this.
    RateLimit {
        /// The control.
        control: Control,
        /// Rate, rad/s.
        rate: f64,
    },
    /// Deviations within the half width about trim move nothing; beyond it the blade follows less the half width.
    DeadZone {
        /// The control.
        control: Control,
        /// Half width, rad.
        half_width: f64,
    },
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
        /// The channel.
        channel: Channel,
        /// Bias in the channel's unit.
        value: f64,
    },
    /// An instrument reads that many times the true value.
    SensorScale {
        /// The channel.
        channel: Channel,
        /// Factor.
        factor: f64,
    },
    /// First-order lag of an instrument.
    SensorLag {
        /// The channel.
        channel: Channel,
        /// Time constant, s.
        tau: f64,
    },
    /// Time skew of an instrument; positive reads late.
    SensorDelay {
        /// The channel.
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
    /// The model explains the data within their noise and its own tolerance.
    None,
    /// Something is there on that axis, and no other effect explains it.
    Unknown {
        /// The axis.
        axis: Axis,
    },
}

/// An instrument whose position matters.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum PositionedSensor {
    /// The three accelerometers.
    Accelerometer,
    /// The flow-angle vanes.
    Vane,
}

impl PositionedSensor {
    /// Both.
    pub const ALL: [PositionedSensor; 2] = [PositionedSensor::Accelerometer, PositionedSensor::Vane];

    /// The name in files.
    pub const fn name(self) -> &'static str {
        match self {
            PositionedSensor::Accelerometer => "accelerometer",
            PositionedSensor::Vane => "vane",
        }
    }
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

macro_rules! kinds {
    ($($variant:ident $name:literal $family:ident [$($key:literal),*];)*) => {
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

            /// The keys that a table of this kind must have beside `kind`, its main number's last.
            pub const fn keys(self) -> &'static [&'static str] {
                match self { $(EffectKind::$variant => &[$($key),*],)* }
            }

            /// What sort of cause it is.
            pub const fn family(self) -> Family {
                match self { $(EffectKind::$variant => Family::$family,)* }
            }
        }

        impl Effect {
            /// The kind.
            pub const fn kind(&self) -> EffectKind {
                match self { $(Effect::$variant { .. } => EffectKind::$variant,)* }
            }
        }
    };
}

impl Effect {
    /// The channel whose instrument it is on, where it is on one.
    pub const fn sensor_channel(&self) -> Option<Channel> {
        match *self {
            Effect::SensorBias { channel, .. }
            | Effect::SensorScale { channel, .. }
            | Effect::SensorLag { channel, .. }
            | Effect::SensorDelay { channel, .. } => Some(channel),
            _ => None,
        }
    }
}

kinds! {
    Derivative "derivative" Derivative ["axis", "variable", "delta"];
    Nonlinear "nonlinear" Nonlinear ["axis", "term", "coefficient"];
    ControlEffectiveness "control_effectiveness" Control ["control", "factor"];
    ActuatorLag "actuator_lag" Control ["control", "tau"];
    TransportDelay "transport_delay" Control ["control", "delay"];
    RateLimit "rate_limit" Control ["control", "rate"];
    DeadZone "dead_zone" Control ["control", "half_width"];
    CrossFeed "cross_feed" Control ["from", "to", "gain"];
    RotorSpeed "rotor_speed" Rotor ["axis", "coefficient"];
    FlightPath "flight_path" Derivative ["axis", "variable", "slope"];
    Turbulence "turbulence" Disturbance ["length", "sigma"];
    SensorBias "sensor_bias" Instrument ["channel", "value"];
    SensorScale "sensor_scale" Instrument ["channel", "factor"];
    SensorLag "sensor_lag" Instrument ["channel", "tau"];
    SensorDelay "sensor_delay" Instrument ["channel", "delay"];
    SensorPosition "sensor_position" Instrument ["sensor", "offset_m"];
    None "none" None [];
    Unknown "unknown" Unknown ["axis"];
    RotorReaction "rotor_speed" Rotor ["axis", "reaction"];
}

impl EffectKind {
    /// The kind of that name; of two that share it the first, the other is told by its keys.
    pub fn from_name(name: &str) -> Option<EffectKind> {
        EffectKind::ALL.iter().copied().find(|kind| kind.name() == name)
    }
}

impl Effect {
    /// The number that a standard error is about: `sigma` for turbulence, the offset component largest in magnitude
    /// for a position; none for `none` and `unknown`.
    pub fn main_number(&self) -> Option<f64> {
        match *self {
            Effect::Derivative { delta: number, .. }
            | Effect::Nonlinear { coefficient: number, .. }
            | Effect::ControlEffectiveness { factor: number, .. }
            | Effect::ActuatorLag { tau: number, .. }
            | Effect::TransportDelay { delay: number, .. }
            | Effect::RateLimit { rate: number, .. }
            | Effect::DeadZone { half_width: number, .. }
            | Effect::CrossFeed { gain: number, .. }
            | Effect::RotorSpeed { coefficient: number, .. }
            | Effect::RotorReaction { reaction: number }
            | Effect::FlightPath { slope: number, .. }
            | Effect::Turbulence { sigma: number, .. }
            | Effect::SensorBias { value: number, .. }
            | Effect::SensorScale { factor: number, .. }
            | Effect::SensorLag { tau: number, .. }
            | Effect::SensorDelay { delay: number, .. } => Some(number),
            Effect::SensorPosition { offset_m: [x, y, z], .. } => {
                Some([y, z].into_iter().fold(x, |largest, c| if libm::fabs(c) > libm::fabs(largest) { c } else { largest }))
            }
            Effect::None | Effect::Unknown { .. } => None,
        }
    }
}

/// The same cause, whatever its number.
pub fn same_cause(a: &Effect, b: &Effect) -> bool {
    cause(a) == cause(b)
}

/// What a cause is called, without its number.
pub fn cause(effect: &Effect) -> (EffectKind, [u8; 2], Option<Term>) {
    let none = u8::MAX;
    let control = |c: Control| c.index() as u8;
    let key = match *effect {
        Effect::Derivative { axis, variable, .. } | Effect::FlightPath { axis, variable, .. } => {
            return (effect.kind(), [axis.index() as u8, none], Some(Term::Linear(variable)));
        }
        Effect::Nonlinear { axis, term, .. } => return (effect.kind(), [axis.index() as u8, none], Some(term)),
        Effect::ControlEffectiveness { control: c, .. }
        | Effect::ActuatorLag { control: c, .. }
        | Effect::TransportDelay { control: c, .. }
        | Effect::RateLimit { control: c, .. }
        | Effect::DeadZone { control: c, .. } => [control(c), none],
        Effect::CrossFeed { from, to, .. } => [control(from), control(to)],
        Effect::RotorSpeed { axis, .. } | Effect::Unknown { axis } => [axis.index() as u8, none],
        Effect::SensorBias { channel, .. }
        | Effect::SensorScale { channel, .. }
        | Effect::SensorLag { channel, .. }
        | Effect::SensorDelay { channel, .. } => [channel.index() as u8, none],
        Effect::SensorPosition { sensor, .. } => [sensor as u8, none],
        Effect::RotorReaction { .. } | Effect::Turbulence { .. } | Effect::None => [none, none],
    };
    (effect.kind(), key, None)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn kinds_are_found_by_name_and_families_are_as_agreed() {
        for &kind in EffectKind::ALL {
            let shares = kind == EffectKind::RotorReaction;
            assert_eq!(EffectKind::from_name(kind.name()), Some(if shares { EffectKind::RotorSpeed } else { kind }));
            assert_eq!(kind.name().starts_with("sensor_"), kind.family() == Family::Instrument);
        }
        assert_eq!(EffectKind::ALL.len(), 19);
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
