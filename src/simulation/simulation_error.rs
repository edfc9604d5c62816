//! What cannot be flown, and why.
//!
//! Consumes a flight; produces its first and last time, or the first thing about it that makes no flight.

use super::dropout::Dropouts;
use super::fly::{Flight, MAX_MESH_POINTS};
use super::instrument::Instrument;
use crate::flight::channel::{Channel, ControlNames};
use crate::flight::control::Control;
use crate::flight::effect::{Effect, EffectKind};

/// Most dropouts a second: more is no link.
pub const MOST_DROPOUTS: f64 = 100.0;

/// Why a flight cannot be flown.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum SimulationError {
    /// An effect that stands for no model.
    #[error("an effect of kind `{}` cannot be flown: it names no cause", .0.name())]
    NotFlown(EffectKind),
    /// An instrument or an effect on it that the simulation has nothing to say about.
    #[error("the simulation gives no channel `{}`", .0.name(ControlNames::Rotorcraft))]
    NoChannel(Channel),
    /// Rotor speed matters and the model's trim has none.
    #[error("the effect of rotor speed needs `rotor_speed` in the model's [trim]")]
    NoRotorSpeed,
    /// Rotor speed is given to a model whose engine makes it.
    #[error("the model's governor holds the rotor speed: it cannot be an input as well")]
    Governed,
    /// The rotor's reaction is added to a model that has it.
    #[error("the model's rotor reacts already, for its engine turns it: an effect of its reaction is for a rotor of given speed")]
    Reacts,
    /// The model's modes cannot be computed.
    #[error("the model's modes cannot be computed from its derivatives")]
    NoModes,
    /// More nonlinear terms than a model may have.
    #[error("the effects add more nonlinear terms than a model may have")]
    TooManyTerms,
    /// Times of samples that are not finite or do not increase.
    #[error("times of samples must be finite and increase, found {0} s")]
    Times(f64),
    /// A rate that is not positive and finite.
    #[error("a rate must be finite and more than zero, found {0} Hz")]
    Rate(f64),
    /// The pilot's control does nothing.
    #[error("the pilot cannot hold the aircraft with `{}`: the model has no moment by it", .0.name(ControlNames::Rotorcraft))]
    NoPower(Control),
    /// Vibration without blades or a rotor that turns.
    #[error("vibration needs `rotor_speed` in the model's [trim] and the number of blades")]
    NoRotor,
    /// An instrument that is none.
    #[error("the instrument of `{}`: expected {expected}, found {found}", .channel.name(ControlNames::Rotorcraft))]
    Instrument {
        /// Its channel.
        channel: Channel,
        /// Which number, and its range.
        expected: &'static str,
        /// Its value.
        found: f64,
    },
    /// Dropouts that are none.
    #[error("dropouts: expected up to {MOST_DROPOUTS} a second, of a positive length, found {} a second of {} s", .0.rate, .0.mean_length_s)]
    Dropouts(Dropouts),
    /// Too long a flight for its steps.
    #[error("the flight needs about {needed} steps, at most {MAX_MESH_POINTS} are flown: shorten it or lower the rates")]
    TooLong {
        /// Steps that it needs.
        needed: u64,
    },
}

impl Flight {
    /// Refuses what cannot be flown; gives the first and the last time, s.
    pub(crate) fn check(&self) -> Result<(f64, f64), SimulationError> {
        for effect in &self.effects {
            match *effect {
                Effect::Unknown { .. } => return Err(SimulationError::NotFlown(effect.kind())),
                Effect::SensorBias { channel, .. }
                | Effect::SensorScale { channel, .. }
                | Effect::SensorLag { channel, .. }
                | Effect::SensorDelay { channel, .. }
                    if !self.gives(channel) =>
                {
                    return Err(SimulationError::NoChannel(channel));
                }
                Effect::RotorSpeed { .. } | Effect::RotorReaction { .. } if self.model.trim.rotor_speed.is_none() => {
                    return Err(SimulationError::NoRotorSpeed);
                }
                Effect::RotorReaction { .. } if self.is_governed() => return Err(SimulationError::Reacts),
                _ => {}
            }
        }
        if self.inputs.rotor_speed.is_some() && self.is_governed() {
            return Err(SimulationError::Governed);
        }
        let on_rotor_speed =
            self.inputs.rotor_speed.is_some() || self.model.rotor_speed.iter().any(|&derivative| derivative != 0.0);
        if on_rotor_speed && self.model.trim.rotor_speed.is_none() {
            return Err(SimulationError::NoRotorSpeed);
        }
        for instrument in &self.instruments.channels {
            if !self.gives(instrument.channel) && instrument.channel != Channel::RotorSpeed {
                return Err(SimulationError::NoChannel(instrument.channel));
            }
            if let Some(rate_hz) = instrument.rate_hz.filter(|rate_hz| !(rate_hz.is_finite() && *rate_hz > 0.0)) {
                return Err(SimulationError::Rate(rate_hz));
            }
            if instrument.vibration.is_some() && (self.blades().is_none() || self.model.trim.rotor_speed.is_none()) {
                return Err(SimulationError::NoRotor);
            }
            check_instrument(instrument)?;
        }
        let links = self.instruments.channels.iter().map(|instrument| instrument.dropouts).chain([self.instruments.dropouts]);
        for dropouts in links.flatten() {
            let (rate, length) = (dropouts.rate, dropouts.mean_length_s);
            if !(rate > 0.0 && rate <= MOST_DROPOUTS && length > 0.0 && length.is_finite()) {
                return Err(SimulationError::Dropouts(dropouts));
            }
        }
        for (&before, &time_s) in self.times_s.iter().zip(self.times_s.iter().skip(1)) {
            if !(time_s > before && time_s.is_finite()) {
                return Err(SimulationError::Times(time_s));
            }
        }
        match (self.times_s.first(), self.times_s.last()) {
            (Some(&first), Some(&last)) if first.is_finite() => Ok((first, last)),
            (Some(&first), _) => Err(SimulationError::Times(first)),
            _ => Err(SimulationError::Times(f64::NAN)),
        }
    }

    /// Whether an engine turns the rotor, whose speed is then no input.
    pub fn is_governed(&self) -> bool {
        self.level1.as_ref().is_some_and(|trimmed| trimmed.aircraft.options.governed)
    }

    /// Whether the flight has this channel to measure.
    pub fn gives(&self, channel: Channel) -> bool {
        match channel {
            Channel::RotorSpeed => self.model.trim.rotor_speed.is_some(),
            Channel::Torque | Channel::Flap0 | Channel::Flap1c | Channel::Flap1s => self.level1.is_some(),
            Channel::Rho => false,
            _ => true,
        }
    }

    /// Blades of the main rotor, where they are known.
    pub(crate) fn blades(&self) -> Option<f64> {
        self.instruments.blades.or_else(|| self.level1.as_ref().map(|trimmed| trimmed.aircraft.main_rotor.blades))
    }
}

/// Refuses numbers that no instrument has.
fn check_instrument(instrument: &Instrument) -> Result<(), SimulationError> {
    let positive = |value: f64| value > 0.0 && value.is_finite();
    let not_negative = |value: f64| value >= 0.0 && value.is_finite();
    let [least, most] = instrument.range.unwrap_or([0.0, 1.0]);
    let [first, second] = instrument.vibration.unwrap_or_default();
    let quantum = instrument.quantum.unwrap_or(1.0);
    for (found, good, expected) in [
        (instrument.noise_std, not_negative(instrument.noise_std), "a standard deviation of noise of zero or more"),
        (instrument.bias_std, not_negative(instrument.bias_std), "a standard deviation of bias of zero or more"),
        (instrument.bias, instrument.bias.is_finite(), "a finite bias"),
        (instrument.factor, instrument.factor.is_finite(), "a finite scale factor"),
        (instrument.lag_s, not_negative(instrument.lag_s), "a lag of zero seconds or more"),
        (instrument.delay_s, instrument.delay_s.is_finite(), "a finite delay"),
        (quantum, positive(quantum), "a quantum of more than zero"),
        (most, least.is_finite() && most.is_finite() && least < most, "a range whose upper end is above its lower"),
        (first, not_negative(first), "an amplitude of vibration of zero or more"),
        (second, not_negative(second), "an amplitude of vibration of zero or more"),
    ] {
        if !good {
            return Err(SimulationError::Instrument { channel: instrument.channel, expected, found });
        }
    }
    Ok(())
}
