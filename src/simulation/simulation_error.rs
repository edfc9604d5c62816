//! Why a simulation is refused.

use super::dropout::Dropouts;
use crate::flight::channel::{Channel, ControlNames};
use crate::flight::control::Control;
use crate::flight::effect::EffectKind;

/// How many mesh points a flight may have: several hours at the usual step.
pub const MAX_MESH_POINTS: usize = 4_000_000;

/// Most dropouts a second: more is no link.
pub const MOST_DROPOUTS: f64 = 100.0;

/// Why a flight cannot be flown.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[expect(missing_docs, reason = "the message of each says what its fields are")]
pub enum SimulationError {
    #[error("an effect of kind `{}` cannot be flown: it names no cause", .0.name())]
    NotFlown(EffectKind),
    /// An instrument or an effect on it that the simulation has nothing to say about.
    #[error("the simulation gives no channel `{}`", .0.name(ControlNames::Rotorcraft))]
    NoChannel(Channel),
    #[error("the effect of rotor speed needs `rotor_speed` in the model's [trim]")]
    NoRotorSpeed,
    #[error("the model's governor holds the rotor speed: it cannot be an input as well")]
    Governed,
    #[error("the model's rotor reacts already, for its engine turns it: an effect of its reaction is for a rotor of given speed")]
    Reacts,
    #[error("the model's modes cannot be computed from its derivatives")]
    NoModes,
    #[error("the effects add more nonlinear terms than a model may have")]
    TooManyTerms,
    #[error("times of samples must be finite and increase, found {0} s")]
    Times(f64),
    #[error("a rate must be finite and more than zero, found {0} Hz")]
    Rate(f64),
    #[error("the pilot cannot hold the aircraft with `{}`: the model has no moment by it", .0.name(ControlNames::Rotorcraft))]
    NoPower(Control),
    #[error("vibration needs `rotor_speed` in the model's [trim] and the number of blades")]
    NoRotor,
    #[error("the instrument of `{}`: expected {expected}, found {found}", .channel.name(ControlNames::Rotorcraft))]
    Instrument { channel: Channel, expected: &'static str, found: f64 },
    #[error("dropouts: expected up to {MOST_DROPOUTS} a second, of a positive length, found {} a second of {} s", .0.rate, .0.mean_length_s)]
    Dropouts(Dropouts),
    #[error("the flight needs about {needed} steps, at most {MAX_MESH_POINTS} are flown: shorten it or lower the rates")]
    TooLong { needed: u64 },
}
