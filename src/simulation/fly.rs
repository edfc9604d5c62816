//! A flight of a model with its effects: controls in, samples and true states out.
//!
//! Consumes a model, effects, inputs and instruments; produces what the instruments would have recorded, and the truth.
//! It starts in the model's trim at the first sample's time, heading zero, by default: a linear model at
//! [`START_ALTITUDE_M`], a Level-1 aircraft where the standard atmosphere has the density of its trim (which stays as it is
//! whatever the altitude does).

use super::instrument::{InstrumentSet, MeasuredFlight, SensorPositions, SimulatedChannelErrors, gather, read, sent};
use super::integrate::{Level1Motion, TrueState, longest_level1_step, longest_step};
use super::level1::trim::Trimmed;
use super::motion::Motion;
use super::pilot::{Pilot, PilotAtWork};
use super::segment::FlightSegments;
pub use super::simulation_error::SimulationError;
use super::simulation_error::{MAX_MESH_POINTS, MOST_DROPOUTS};
use super::turbulence::gusts;
use super::unmodelled::Unmodelled;
use super::vibration::Azimuth;
use crate::dynamics::atmosphere::altitude_of;
use crate::dynamics::linear::with_effects;
use crate::flight::channel::Channel;
use crate::flight::control::{CONTROLS, Control};
use crate::flight::effect::Effect;
use crate::flight::model::LinearModel;
use crate::flight::sample::Sample;
use crate::flight::signal::piecewise_linear::History;
use std::borrow::Cow;

/// Altitude at which a linear model's flight starts unless told otherwise, m.
pub const START_ALTITUDE_M: f64 = 1000.0;

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

    /// As [`Inputs::sampled`], each channel at its instrument's own rate where that has one.
    ///
    /// # Errors
    /// [`SimulationError`] where such a rate makes no times.
    pub fn sampled_by(&self, instruments: &InstrumentSet, times_s: &[f64]) -> Result<Self, SimulationError> {
        let mut sampled = self.sampled(times_s);
        let (Some(&first_s), Some(&last_s)) = (times_s.first(), times_s.last()) else { return Ok(sampled) };
        for instrument in &instruments.channels {
            let Some(rate_hz) = instrument.rate_hz else { continue };
            let again =
                |history: &History| uniform_times(first_s, last_s - first_s, rate_hz).map(|times| history.sampled(&times));
            if instrument.channel == Channel::RotorSpeed {
                sampled.rotor_speed = self.rotor_speed.as_ref().map(again).transpose()?;
            }
            for control in Control::ALL.into_iter().filter(|control| control.channel() == instrument.channel) {
                sampled.controls[control.index()] = again(&self.controls[control.index()])?;
            }
        }
        Ok(sampled)
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
    /// What acts on it besides and no effect describes, if anything.
    pub unmodelled: Option<Unmodelled>,
    /// What the pilot does, whatever the aircraft does.
    pub inputs: Inputs,
    /// The pilot who holds the attitude besides, if any.
    pub pilot: Option<Pilot>,
    /// What measures it.
    pub instruments: InstrumentSet,
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
pub struct FlightResult {
    /// What the instruments recorded.
    pub samples: Vec<Sample>,
    /// The true state at each of the flight's times.
    pub truth: Vec<TrueState>,
    /// When the motion left what the kinematics can carry, s; everything after is cut.
    pub diverged_at_s: Option<f64>,
}

impl Flight {
    /// The model in its trim, perfect instruments, no time yet.
    pub fn of(model: LinearModel) -> Self {
        Flight {
            inputs: Inputs::at_trim(&model),
            model,
            level1: None,
            effects: Vec::new(),
            unmodelled: None,
            pilot: None,
            instruments: InstrumentSet::perfect(),
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

    /// The trim where this flight starts.
    fn start_in_trim(&self) -> Motion {
        let trim = Flight::trim_motion(&self.model);
        let altitude = self.level1.as_ref().map_or(trim.altitude, |trimmed| altitude_of(trimmed.condition.density));
        Motion { altitude, ..trim }
    }

    /// Flies it.
    ///
    /// # Errors
    /// [`SimulationError`] where an effect, instrument or time makes no flight. Divergence is no error: see [`FlightResult`].
    pub fn fly(&self) -> Result<FlightResult, SimulationError> {
        let (start_s, end_s) = self.check()?;
        let model = with_effects(&self.model, &self.effects).map_err(|_| SimulationError::TooManyTerms)?;
        // Beside a Level-1 aircraft the linear model holds what the effects add; either may be the faster.
        let added = longest_step(&model);
        let longest = self.level1.as_ref().map_or(added, |trimmed| Some(longest_level1_step(trimmed)?.min(added?)));
        let step_s = longest.ok_or(SimulationError::NoModes)?.min(self.max_step_s.unwrap_or(f64::INFINITY));
        let readings: Vec<SimulatedChannelErrors> =
            self.instruments.channels.iter().map(|i| SimulatedChannelErrors::of(i, &self.effects)).collect();
        let early_s = readings.iter().map(|reading| -reading.delay_s).fold(0.0, f64::max);
        let last_s = end_s + early_s;
        refuse_long((last_s - start_s) / step_s)?;
        let channel_times: Vec<Cow<'_, [f64]>> =
            self.instruments.channels.iter().map(|i| self.times_of(i.rate_hz, start_s, end_s)).collect::<Result<_, _>>()?;
        let air = self.turbulence(start_s, last_s);

        let mut wanted: Vec<f64> = self.times_s.clone();
        wanted.push(last_s);
        let mut known = vec![(None, 0.0)];
        for ((instrument, times), reading) in self.instruments.channels.iter().zip(&channel_times).zip(&readings) {
            let times_of = (instrument.rate_hz, reading.delay_s);
            if !known.contains(&times_of) {
                known.push(times_of);
                wanted.extend(times.iter().map(|time_s| time_s - reading.delay_s));
            }
        }
        wanted.extend(self.inputs.rotor_speed.iter().flat_map(History::times));
        wanted.extend(air.iter().flatten().flat_map(History::times));
        wanted.retain(|time_s| (start_s..=last_s).contains(time_s));
        refuse_long(wanted.len() as f64 + (last_s - start_s) / step_s)?;
        wanted.sort_by(f64::total_cmp);

        let start = self.start.unwrap_or_else(|| self.start_in_trim());
        let segments = FlightSegments {
            controls: &self.inputs.controls,
            rotor_speed: self.inputs.rotor_speed.as_ref(),
            effects: &self.effects,
            unmodelled: self.unmodelled.as_ref(),
            controls_at_trim: self.model.trim.controls,
            model: &model,
            level1: self.level1.as_ref().map(|trimmed| Level1Motion {
                trimmed,
                equations: trimmed.aircraft.equations(),
                inner: trimmed.aircraft.options.active().contains(&true),
                effectiveness: effectiveness(&self.effects),
                added: model != self.model,
            }),
            air: air.as_ref(),
            wanted_s: &wanted,
            step_s,
        };
        let (states, diverged_at_s) = match self.pilot_at_work(&start, start_s)? {
            None => segments.fly(start, last_s),
            Some((pilot, at_work)) => segments.fly_with_pilot(start, &pilot.acts_s(&self.times_s, last_s), at_work),
        };

        let vibrates = self.instruments.channels.iter().any(|instrument| instrument.vibration.is_some());
        let azimuth = if vibrates { Azimuth::of(&states) } else { None };
        let mesh_s: Vec<f64> = states.iter().map(|state| state.time_s).collect();
        let seen = MeasuredFlight {
            stands: SensorPositions::of(&self.instruments, &self.effects),
            states: &states,
            mesh_s: &mesh_s,
            rotor: azimuth.as_ref().zip(self.blades()),
            start_s,
            seed: self.seed,
        };
        let mut recorded = Vec::new();
        for ((instrument, reading), times) in self.instruments.channels.iter().zip(&readings).zip(&channel_times) {
            let name = recorded_as(instrument.channel, &self.effects);
            recorded.push((name, read(instrument, reading, &seen, times)));
        }
        // Every wanted time is in the mesh, up to where the motion diverged.
        let mut wanted = self.times_s.iter().peekable();
        let mut truth = states;
        truth.retain(|state| wanted.next_if(|time_s| state.time_s.total_cmp(time_s).is_eq()).is_some());
        let samples = sent(gather(&recorded), self.instruments.dropouts, start_s, self.seed);
        Ok(FlightResult { samples, truth, diverged_at_s })
    }

    /// Refuses what cannot be flown; gives the first and the last time, s.
    fn check(&self) -> Result<(f64, f64), SimulationError> {
        for effect in &self.effects {
            if let Some((channel, _)) = effect.sensor_error().filter(|(channel, _)| !self.gives(*channel)) {
                return Err(SimulationError::NoChannel(channel));
            }
            match *effect {
                Effect::Unknown { .. } => return Err(SimulationError::NotFlown(effect.kind())),
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
            instrument.check()?;
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
    fn blades(&self) -> Option<f64> {
        self.instruments.blades.or_else(|| self.level1.as_ref().map(|trimmed| trimmed.aircraft.main_rotor.blades))
    }

    fn pilot_at_work(&self, start: &Motion, start_s: f64) -> Result<Option<(Pilot, PilotAtWork)>, SimulationError> {
        let Some(pilot) = self.pilot else { return Ok(None) };
        let [_, _, heading] = start.attitude;
        let linear = self.level1.as_ref().map(|trimmed| trimmed.linear());
        let at_work =
            PilotAtWork::of(pilot, linear.as_ref().unwrap_or(&self.model), heading, start_s).map_err(SimulationError::NoPower)?;
        Ok(Some((pilot, at_work)))
    }

    fn times_of(&self, rate_hz: Option<f64>, start_s: f64, end_s: f64) -> Result<Cow<'_, [f64]>, SimulationError> {
        match rate_hz {
            None => Ok(Cow::Borrowed(&self.times_s)),
            Some(rate_hz) => uniform_times(start_s, end_s - start_s, rate_hz).map(Cow::Owned),
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

fn refuse_long(steps: f64) -> Result<(), SimulationError> {
    if steps <= MAX_MESH_POINTS as f64 { Ok(()) } else { Err(SimulationError::TooLong { needed: steps as u64 }) }
}

/// Times `start, start + 1/rate, ...` up to `start + duration`, s.
///
/// # Errors
/// [`SimulationError`] where rate or duration make no times, or more than a flight may have.
pub fn uniform_times(start_s: f64, duration_s: f64, rate_hz: f64) -> Result<Vec<f64>, SimulationError> {
    if !(rate_hz.is_finite() && rate_hz > 0.0) {
        return Err(SimulationError::Rate(rate_hz));
    }
    let steps = libm::floor(duration_s * rate_hz + 1e-9);
    if !(start_s.is_finite() && steps >= 0.0) {
        return Err(SimulationError::Times(start_s + duration_s));
    }
    refuse_long(steps)?;
    Ok((0..=steps as usize).map(|step| start_s + step as f64 / rate_hz).collect())
}

/// A model without effects flown from its trim at time zero, the inputs as a recording at that rate would show them.
///
/// # Errors
/// [`SimulationError`] as for [`Flight::fly`].
pub fn simulate(
    model: &LinearModel,
    inputs: &Inputs,
    instruments: &InstrumentSet,
    duration_s: f64,
    rate_hz: f64,
    seed: u64,
) -> Result<FlightResult, SimulationError> {
    let times_s = uniform_times(0.0, duration_s, rate_hz)?;
    let flight =
        Flight { inputs: inputs.sampled(&times_s), instruments: instruments.clone(), times_s, seed, ..Flight::of(model.clone()) };
    flight.fly()
}

/// The name that a channel is recorded under.
pub(crate) fn recorded_as(channel: Channel, effects: &[Effect]) -> Channel {
    effects.iter().fold(channel, |channel, effect| match *effect {
        Effect::Exchanged { channels: [one, other] } if channel == one => other,
        Effect::Exchanged { channels: [one, other] } if channel == other => one,
        _ => channel,
    })
}
