//! A flight of a model with its effects: controls in, samples and true states out.
//!
//! Consumes a model, effects, inputs and instruments; produces what the instruments would have recorded, and the truth.
//! It starts in the model's trim at the first sample's time, heading zero, unless told otherwise.

use super::control_path::ControlPath;
use super::history::History;
use super::instrument::{Instruments, Reading, Stands, gather, read};
use super::integrate::{Drive, Nonlinear, TrueState, longest_level1_step, longest_step, nodes};
use super::level1::trim::Trimmed;
use super::linear::with_effects;
use super::motion::Motion;
use super::turbulence::gusts;
use crate::flight::channel::{Channel, ControlNames};
use crate::flight::control::{CONTROLS, Control};
use crate::flight::effect::{Effect, EffectKind};
use crate::flight::model::LinearModel;
use crate::telemetry::record::Sample;

/// Altitude at which a flight starts unless told otherwise, m.
pub const START_ALTITUDE_M: f64 = 1000.0;

/// How many mesh points a flight may have: several hours at the usual step.
pub const MAX_MESH_POINTS: usize = 4_000_000;

/// What the pilot and the governor do over time, absolute values.
#[derive(Clone, Debug, PartialEq)]
pub struct Inputs {
    /// The pilot's controls by [`Control`] place, rad.
    pub controls: [History; CONTROLS],
    /// Rotor speed, rad/s; `None` keeps it at trim.
    pub rotor_speed: Option<History>,
}

impl Inputs {
    /// Everything stays at the model's trim.
    pub fn at_trim(model: &LinearModel) -> Self {
        Inputs { controls: model.trim.controls.map(History::constant), rotor_speed: None }
    }

    /// What a recording sampled at these times would show, and straight lines between.
    #[must_use]
    pub fn sampled(&self, times_s: &[f64]) -> Self {
        let controls = Control::ALL.map(|control| self.controls[control.index()].sampled(times_s));
        Inputs { controls, rotor_speed: self.rotor_speed.as_ref().map(|history| history.sampled(times_s)) }
    }
}

/// A flight to be flown.
#[derive(Clone, Debug, PartialEq)]
pub struct Flight {
    /// The linear model; of a Level-1 flight, what adds to the aircraft's accelerations about its trim (nothing, before effects).
    pub model: LinearModel,
    /// The Level-1 aircraft in its trim, where it is one that flies.
    pub level1: Option<Box<Trimmed>>,
    /// The effects that it is flown with.
    pub effects: Vec<Effect>,
    /// What the pilot does.
    pub inputs: Inputs,
    /// What measures it.
    pub instruments: Instruments,
    /// Times of samples and true states, s, increasing; instruments with a rate of their own sample at theirs.
    pub times_s: Vec<f64>,
    /// Seed of noise, biases and gusts.
    pub seed: u64,
    /// Motion at the first time; `None` is the trim.
    pub start: Option<Motion>,
    /// Longest step of the integration, s; `None` takes what the model asks for.
    pub max_step_s: Option<f64>,
}

/// A flight that was flown.
#[derive(Clone, Debug, PartialEq)]
pub struct Flown {
    /// What the instruments recorded.
    pub samples: Vec<Sample>,
    /// The true state at each of the flight's times.
    pub truth: Vec<TrueState>,
    /// When the motion left what the kinematics can carry, s; everything after is cut.
    pub diverged_at_s: Option<f64>,
}

/// Why a flight cannot be flown.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum Refused {
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
    /// Too long a flight for its steps.
    #[error("the flight needs about {needed} steps, at most {MAX_MESH_POINTS} are flown: shorten it or lower the rates")]
    TooLong {
        /// Steps that it needs.
        needed: u64,
    },
}

impl Flight {
    /// The model in its trim, perfect instruments, no time yet.
    pub fn of(model: LinearModel) -> Self {
        Flight {
            inputs: Inputs::at_trim(&model),
            model,
            level1: None,
            effects: Vec::new(),
            instruments: Instruments::perfect(),
            times_s: Vec::new(),
            seed: 0,
            start: None,
            max_step_s: None,
        }
    }

    /// A Level-1 aircraft in its trim, perfect instruments, no time yet.
    pub fn of_level1(trimmed: Trimmed) -> Self {
        Flight { level1: Some(Box::new(trimmed.clone())), ..Flight::of(LinearModel::about(trimmed.trim)) }
    }

    /// The model's trim as a motion.
    pub fn trim_motion(model: &LinearModel) -> Motion {
        let trim = &model.trim;
        Motion {
            velocity: [trim.u, trim.v, trim.w],
            rates: [0.0; 3],
            attitude: [trim.phi, trim.theta, 0.0],
            altitude: START_ALTITUDE_M,
        }
    }

    /// Flies it.
    ///
    /// # Errors
    /// [`Refused`] where an effect, instrument or time makes no flight. Divergence is no error: see [`Flown`].
    pub fn fly(&self) -> Result<Flown, Refused> {
        let (start_s, end_s) = self.check()?;
        let model = with_effects(&self.model, &self.effects).map_err(|_| Refused::TooManyTerms)?;
        // Beside a Level-1 aircraft the linear model holds what the effects add; either may be the faster.
        let added = longest_step(&model);
        let longest = self.level1.as_ref().map_or(added, |trimmed| Some(longest_level1_step(trimmed)?.min(added?)));
        let step_s = longest.ok_or(Refused::NoModes)?.min(self.max_step_s.unwrap_or(f64::INFINITY));
        let deviations = Control::ALL
            .map(|control| self.inputs.controls[control.index()].clone().shifted(-self.model.trim.controls[control.index()]));
        let path = ControlPath::new(&deviations, &self.effects);
        let readings: Vec<Reading> = self.instruments.channels.iter().map(|i| Reading::of(i.channel, &self.effects)).collect();
        let early_s = readings.iter().map(|reading| -reading.delay_s).fold(0.0, f64::max);
        let last_s = end_s + early_s;
        refuse_long((last_s - start_s) / step_s)?;
        let channel_times: Vec<Vec<f64>> =
            self.instruments.channels.iter().map(|i| self.times_of(i.rate_hz, start_s, end_s)).collect::<Result<_, _>>()?;
        let air = self.turbulence(start_s, last_s);

        let mut wanted: Vec<f64> = self.times_s.clone();
        wanted.push(last_s);
        for (times, reading) in channel_times.iter().zip(&readings) {
            wanted.extend(times.iter().map(|time_s| time_s - reading.delay_s));
        }
        wanted.extend(path.bends());
        wanted.extend(self.inputs.rotor_speed.iter().flat_map(History::times));
        wanted.extend(air.iter().flatten().flat_map(History::times));
        wanted.retain(|time_s| (start_s..=last_s).contains(time_s));
        refuse_long(wanted.len() as f64 + (last_s - start_s) / step_s)?;

        let nodes_s = nodes(wanted, step_s);
        let blade = path.blade(&nodes_s);
        let level1 = self.level1.as_ref().map(|trimmed| Nonlinear {
            trimmed,
            effectiveness: effectiveness(&self.effects),
            added: model != self.model,
        });
        let drive = Drive {
            model: &model,
            level1,
            nodes_s: &nodes_s,
            blade: &blade,
            controls: &self.inputs.controls,
            gusts: air.as_ref(),
            rotor_speed: self.inputs.rotor_speed.as_ref(),
        };
        let (states, diverged_at_s) = drive.fly(self.start.unwrap_or_else(|| Flight::trim_motion(&self.model)));

        let stands = Stands::of(&self.instruments, &self.effects);
        let mut recorded = Vec::new();
        for ((instrument, reading), times) in self.instruments.channels.iter().zip(&readings).zip(&channel_times) {
            recorded.push((instrument.channel, read(instrument, reading, &stands, &states, times, self.seed)));
        }
        let at = |time_s: &f64| {
            states.binary_search_by(|state| state.time_s.total_cmp(time_s)).ok().and_then(|place| states.get(place))
        };
        let truth = self.times_s.iter().map_while(|time_s| at(time_s).copied()).collect();
        Ok(Flown { samples: gather(&recorded), truth, diverged_at_s })
    }

    /// Refuses what cannot be flown; gives the first and the last time, s.
    fn check(&self) -> Result<(f64, f64), Refused> {
        for effect in &self.effects {
            match *effect {
                Effect::Unknown { .. } => return Err(Refused::NotFlown(effect.kind())),
                Effect::SensorBias { channel, .. }
                | Effect::SensorScale { channel, .. }
                | Effect::SensorLag { channel, .. }
                | Effect::SensorDelay { channel, .. }
                    if !self.gives(channel) =>
                {
                    return Err(Refused::NoChannel(channel));
                }
                Effect::RotorSpeed { .. } if self.model.trim.rotor_speed.is_none() => return Err(Refused::NoRotorSpeed),
                _ => {}
            }
        }
        if self.inputs.rotor_speed.is_some() && self.level1.as_ref().is_some_and(|trimmed| trimmed.aircraft.options.governed) {
            return Err(Refused::Governed);
        }
        let on_rotor_speed =
            self.inputs.rotor_speed.is_some() || self.model.rotor_speed.iter().any(|&derivative| derivative != 0.0);
        if on_rotor_speed && self.model.trim.rotor_speed.is_none() {
            return Err(Refused::NoRotorSpeed);
        }
        for instrument in &self.instruments.channels {
            if !self.gives(instrument.channel) && instrument.channel != Channel::RotorSpeed {
                return Err(Refused::NoChannel(instrument.channel));
            }
            if let Some(rate_hz) = instrument.rate_hz.filter(|rate_hz| !(rate_hz.is_finite() && *rate_hz > 0.0)) {
                return Err(Refused::Rate(rate_hz));
            }
        }
        for (&before, &time_s) in self.times_s.iter().zip(self.times_s.iter().skip(1)) {
            if !(time_s > before && time_s.is_finite()) {
                return Err(Refused::Times(time_s));
            }
        }
        match (self.times_s.first(), self.times_s.last()) {
            (Some(&first), Some(&last)) if first.is_finite() => Ok((first, last)),
            (Some(&first), _) => Err(Refused::Times(first)),
            _ => Err(Refused::Times(f64::NAN)),
        }
    }

    fn gives(&self, channel: Channel) -> bool {
        match channel {
            Channel::RotorSpeed => self.model.trim.rotor_speed.is_some(),
            Channel::Torque | Channel::Flap0 | Channel::Flap1c | Channel::Flap1s => self.level1.is_some(),
            Channel::Rho => false,
            _ => true,
        }
    }

    fn times_of(&self, rate_hz: Option<f64>, start_s: f64, end_s: f64) -> Result<Vec<f64>, Refused> {
        match rate_hz {
            None => Ok(self.times_s.clone()),
            Some(rate_hz) => uniform_times(start_s, end_s - start_s, rate_hz),
        }
    }

    /// Gusts of every turbulence effect; several add up.
    fn turbulence(&self, start_s: f64, end_s: f64) -> Option<[History; 3]> {
        let mut sum: Option<[History; 3]> = None;
        let airspeed = self.model.trim.airspeed();
        for (count, effect) in self.effects.iter().enumerate() {
            let Effect::Turbulence { sigma, length } = *effect else { continue };
            let fresh = gusts(sigma, length, airspeed, (start_s, end_s), self.seed.wrapping_add(count as u64));
            sum = Some(match sum {
                None => fresh,
                Some([x, y, z]) => [x.plus(1.0, &fresh[0]), y.plus(1.0, &fresh[1]), z.plus(1.0, &fresh[2])],
            });
        }
        sum
    }
}

/// The share of each control's deviation that acts.
fn effectiveness(effects: &[Effect]) -> [f64; CONTROLS] {
    let mut shares = [1.0; CONTROLS];
    for effect in effects {
        if let Effect::ControlEffectiveness { control, factor } = *effect {
            shares[control.index()] *= factor;
        }
    }
    shares
}

fn refuse_long(steps: f64) -> Result<(), Refused> {
    if steps <= MAX_MESH_POINTS as f64 { Ok(()) } else { Err(Refused::TooLong { needed: steps as u64 }) }
}

/// Times `start, start + 1/rate, ...` up to `start + duration`, s.
///
/// # Errors
/// [`Refused`] where rate or duration make no times, or more than a flight may have.
pub fn uniform_times(start_s: f64, duration_s: f64, rate_hz: f64) -> Result<Vec<f64>, Refused> {
    if !(rate_hz.is_finite() && rate_hz > 0.0) {
        return Err(Refused::Rate(rate_hz));
    }
    let steps = libm::floor(duration_s * rate_hz + 1e-9);
    if !(start_s.is_finite() && steps >= 0.0) {
        return Err(Refused::Times(start_s + duration_s));
    }
    refuse_long(steps)?;
    Ok((0..=steps as usize).map(|step| start_s + step as f64 / rate_hz).collect())
}

/// A model without effects flown from its trim at time zero, the inputs as a recording at that rate would show them.
///
/// # Errors
/// [`Refused`] as for [`Flight::fly`].
pub fn simulate(
    model: &LinearModel,
    inputs: &Inputs,
    instruments: &Instruments,
    duration_s: f64,
    rate_hz: f64,
    seed: u64,
) -> Result<Flown, Refused> {
    let times_s = uniform_times(0.0, duration_s, rate_hz)?;
    let flight =
        Flight { inputs: inputs.sampled(&times_s), instruments: instruments.clone(), times_s, seed, ..Flight::of(model.clone()) };
    flight.fly()
}
