//! Instruments: what each channel reads of the true state.
//!
//! Consumes true states and the effects on instruments; produces samples. Accelerometers and vanes read (6), and (3) and (4), of
//! `sensors` at their positions, with velocities through the air; `tas` is (2) at the centre of mass. Then, in this order:
//! vibration of its place, lag, delay (steady before the start), `reading = factor * true + bias`, the run's own constant bias,
//! white noise, the word that it is sent as, and dropouts: of the instrument, and of the link that sends all of them. What the
//! instrument itself does and what an effect does to it add up: one lag follows the other, delays and biases are summed,
//! factors multiplied.
//!
//! A word counts steps of `quantum` from the lower end of its range and holds at both ends (saturation); without a range the
//! steps are counted from zero.
//! Refused: a channel that the simulation does not model (density; torque and flapping of a linear model).

use super::control_path::Lag;
use super::dropout::{DropoutLink, Dropouts};
use super::integrate::TrueState;
use super::simulation_error::SimulationError;
use super::vibration::{Azimuth, Vibration};
use crate::dynamics::sensors::{AirData, specific_force_at_arm, velocity_at_arm};
use crate::flight::channel::{CHANNELS, Channel};
use crate::flight::control::Control;
use crate::flight::effect::{Effect, PositionedSensor, SensorError};
use crate::flight::sample::Sample;
use crate::num::random::NormalNoise;

/// One instrument.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Instrument {
    /// What it measures.
    pub channel: Channel,
    /// Its own rate, Hz; `None` samples at the times of the flight.
    pub rate_hz: Option<f64>,
    /// Standard deviation of its white noise.
    pub noise_std: f64,
    /// Standard deviation of the bias that it keeps for a run.
    pub bias_std: f64,
    /// What it reads too much, at every time.
    pub bias: f64,
    /// It reads that many times the true value.
    pub factor: f64,
    /// First-order lag, s; zero has none.
    pub lag_s: f64,
    /// Time by which it reads late, s.
    pub delay_s: f64,
    /// Step of its readings; `None` reads continuously.
    pub quantum: Option<f64>,
    /// The least and the most that it reads; `None` has no bounds.
    pub range: Option<[f64; 2]>,
    /// Vibration that it reads: amplitude at blade passing and at twice that.
    pub vibration: Option<[f64; 2]>,
    /// Its own dropouts.
    pub dropouts: Option<Dropouts>,
}

impl Instrument {
    /// One that reads the truth.
    pub const fn perfect(channel: Channel) -> Self {
        Instrument {
            channel,
            rate_hz: None,
            noise_std: 0.0,
            bias_std: 0.0,
            bias: 0.0,
            factor: 1.0,
            lag_s: 0.0,
            delay_s: 0.0,
            quantum: None,
            range: None,
            vibration: None,
            dropouts: None,
        }
    }

    /// The word that stands for a value.
    pub fn word(&self, value: f64) -> f64 {
        let Some([least, most]) = self.range else {
            return self.quantum.map_or(value, |quantum| libm::round(value / quantum) * quantum);
        };
        let bounded = value.clamp(least, most);
        let Some(quantum) = self.quantum else { return bounded };
        // The last count that the range holds; a whole range of counts is not to lose its last to rounding.
        let last = libm::floor((most - least) / quantum * (1.0 + 1e-12));
        least + libm::round((bounded - least) / quantum).min(last) * quantum
    }

    /// Refuses numbers that no instrument has.
    pub(super) fn check(&self) -> Result<(), SimulationError> {
        let positive = |value: f64| value > 0.0 && value.is_finite();
        let not_negative = |value: f64| value >= 0.0 && value.is_finite();
        let [least, most] = self.range.unwrap_or([0.0, 1.0]);
        let [first, second] = self.vibration.unwrap_or_default();
        let quantum = self.quantum.unwrap_or(1.0);
        for (found, good, expected) in [
            (self.noise_std, not_negative(self.noise_std), "a standard deviation of noise of zero or more"),
            (self.bias_std, not_negative(self.bias_std), "a standard deviation of bias of zero or more"),
            (self.bias, self.bias.is_finite(), "a finite bias"),
            (self.factor, self.factor.is_finite(), "a finite scale factor"),
            (self.lag_s, not_negative(self.lag_s), "a lag of zero seconds or more"),
            (self.delay_s, self.delay_s.is_finite(), "a finite delay"),
            (quantum, positive(quantum), "a quantum of more than zero"),
            (most, least.is_finite() && most.is_finite() && least < most, "a range whose upper end is above its lower"),
            (first, not_negative(first), "an amplitude of vibration of zero or more"),
            (second, not_negative(second), "an amplitude of vibration of zero or more"),
        ] {
            if !good {
                return Err(SimulationError::Instrument { channel: self.channel, expected, found });
            }
        }
        Ok(())
    }
}

/// The instruments of an aircraft, and where those stand whose position matters.
#[derive(Clone, Debug, PartialEq)]
pub struct InstrumentSet {
    /// The instruments, in the order of a file's columns.
    pub channels: Vec<Instrument>,
    /// Position of the accelerometers from the centre of mass, body axes, m.
    pub accelerometer_position_m: [f64; 3],
    /// Position of the vanes from the centre of mass, body axes, m.
    pub vane_position_m: [f64; 3],
    /// Blades of the main rotor, for vibration; `None` takes those of a Level-1 aircraft.
    pub blades: Option<f64>,
    /// Dropouts of the link that sends every channel.
    pub dropouts: Option<Dropouts>,
}

const fn instrument(channel: Channel, noise_std: f64, bias_std: f64) -> Instrument {
    Instrument { noise_std, bias_std, ..Instrument::perfect(channel) }
}

/// What good flight-test instruments do: noise and bias in the channel's unit. The rotor speed is read where there is one.
pub const FLIGHT_QUALITY: [Instrument; 18] = [
    instrument(Channel::Ax, 0.02, 0.03),
    instrument(Channel::Ay, 0.02, 0.03),
    instrument(Channel::Az, 0.02, 0.03),
    instrument(Channel::P, 0.001, 0.000_5),
    instrument(Channel::Q, 0.001, 0.000_5),
    instrument(Channel::R, 0.001, 0.000_5),
    instrument(Channel::Phi, 0.002, 0.0),
    instrument(Channel::Theta, 0.002, 0.0),
    instrument(Channel::Psi, 0.004, 0.0),
    instrument(Channel::Tas, 0.3, 0.0),
    instrument(Channel::Alpha, 0.002, 0.0),
    instrument(Channel::Beta, 0.002, 0.0),
    instrument(Channel::Altitude, 0.5, 0.0),
    instrument(Channel::LonCyclic, 0.000_2, 0.0),
    instrument(Channel::LatCyclic, 0.000_2, 0.0),
    instrument(Channel::Collective, 0.000_2, 0.0),
    instrument(Channel::Pedal, 0.000_2, 0.0),
    instrument(Channel::RotorSpeed, 0.01, 0.0),
];

/// What good instruments of a rotor do, where the model has a rotor.
pub const ROTOR_QUALITY: [Instrument; 4] = [
    instrument(Channel::Torque, 200.0, 0.0),
    instrument(Channel::Flap0, 0.000_5, 0.0),
    instrument(Channel::Flap1c, 0.000_5, 0.0),
    instrument(Channel::Flap1s, 0.000_5, 0.0),
];

impl InstrumentSet {
    /// With the instruments of [`ROTOR_QUALITY`], their noise times `factor`.
    #[must_use]
    pub fn with_rotor(mut self, factor: f64) -> Self {
        self.channels.extend(ROTOR_QUALITY.map(|i| Instrument { noise_std: factor * i.noise_std, ..i }));
        self
    }

    /// The channels of [`FLIGHT_QUALITY`], at the centre of mass, with its noise and biases times `factor`.
    pub fn flight_quality(factor: f64) -> Self {
        let scaled = |i: Instrument| Instrument { noise_std: factor * i.noise_std, bias_std: factor * i.bias_std, ..i };
        InstrumentSet {
            channels: FLIGHT_QUALITY.map(scaled).to_vec(),
            accelerometer_position_m: [0.0; 3],
            vane_position_m: [0.0; 3],
            blades: None,
            dropouts: None,
        }
    }

    /// The same channels without noise and bias.
    pub fn perfect() -> Self {
        InstrumentSet::flight_quality(0.0)
    }
}

/// What an instrument and the effects on its channel make of its reading.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct SimulatedChannelErrors {
    lags_s: Vec<f64>,
    /// Sum of the channel's delays, s; negative reads early.
    pub(crate) delay_s: f64,
    factor: f64,
    bias: f64,
}

impl SimulatedChannelErrors {
    pub(crate) fn of(instrument: &Instrument, effects: &[Effect]) -> Self {
        let channel = instrument.channel;
        let mut reading = SimulatedChannelErrors {
            lags_s: if instrument.lag_s > 0.0 { vec![instrument.lag_s] } else { Vec::new() },
            delay_s: instrument.delay_s,
            factor: instrument.factor,
            bias: instrument.bias,
        };
        for (_, error) in effects.iter().filter_map(Effect::sensor_error).filter(|(of, _)| *of == channel) {
            match error {
                SensorError::Bias(value) => reading.bias += value,
                SensorError::Scale(factor) => reading.factor *= factor,
                SensorError::Lag(tau) => reading.lags_s.extend((tau > 0.0).then_some(tau)),
                SensorError::Delay(delay) => reading.delay_s += delay,
            }
        }
        reading
    }
}

/// Where the instruments truly stand: the run's positions with the effects' offsets.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SensorPositions {
    accelerometer_m: [f64; 3],
    vane_m: [f64; 3],
}

impl SensorPositions {
    pub(crate) fn of(instruments: &InstrumentSet, effects: &[Effect]) -> Self {
        let mut stands =
            SensorPositions { accelerometer_m: instruments.accelerometer_position_m, vane_m: instruments.vane_position_m };
        for effect in effects {
            if let Effect::SensorPosition { sensor, offset_m } = effect {
                let position = match sensor {
                    PositionedSensor::Accelerometer => &mut stands.accelerometer_m,
                    PositionedSensor::Vane => &mut stands.vane_m,
                };
                position.iter_mut().zip(offset_m).for_each(|(place, offset)| *place += offset);
            }
        }
        stands
    }

    /// The channel's true value where its instrument stands, `None` where there is none.
    pub(crate) fn true_value(&self, channel: Channel, state: &TrueState) -> Option<f64> {
        let rates = state.motion.rates;
        let [p, q, r] = rates;
        let [phi, theta, psi] = state.motion.attitude;
        let at_vane = || velocity_at_arm(state.air_velocity, rates, self.vane_m);
        let accelerometer =
            || specific_force_at_arm(state.specific_force, rates, state.angular_acceleration, self.accelerometer_m);
        Some(match channel {
            Channel::Ax => accelerometer()[0],
            Channel::Ay => accelerometer()[1],
            Channel::Az => accelerometer()[2],
            Channel::P => p,
            Channel::Q => q,
            Channel::R => r,
            Channel::Phi => phi,
            Channel::Theta => theta,
            Channel::Psi => psi,
            Channel::Tas => AirData::Airspeed.value(state.air_velocity),
            Channel::Alpha => AirData::Incidence.value(at_vane()),
            Channel::Beta => AirData::Sideslip.value(at_vane()),
            Channel::Altitude => state.motion.altitude,
            Channel::LonCyclic => state.controls[Control::LonCyclic.index()],
            Channel::LatCyclic => state.controls[Control::LatCyclic.index()],
            Channel::Collective => state.controls[Control::Collective.index()],
            Channel::Pedal => state.controls[Control::Pedal.index()],
            Channel::TailPitch => state.blade[Control::Pedal.index()],
            Channel::RotorSpeed => return state.rotor_speed,
            Channel::Torque => return state.rotor.map(|rotor| rotor.torque),
            Channel::Flap0 => return state.rotor.map(|rotor| rotor.flap.coning),
            Channel::Flap1c => return state.rotor.map(|rotor| rotor.flap.cosine),
            Channel::Flap1s => return state.rotor.map(|rotor| rotor.flap.sine),
            Channel::Rho => return None,
        })
    }
}

/// What readings are taken of.
#[derive(Clone, Copy, Debug)]
pub(crate) struct MeasuredFlight<'s> {
    pub(crate) stands: SensorPositions,
    pub(crate) states: &'s [TrueState],
    /// Their times, s.
    pub(crate) mesh_s: &'s [f64],
    /// The rotor's turning and its blades, where anything vibrates with them.
    pub(crate) rotor: Option<(&'s Azimuth, f64)>,
    pub(crate) start_s: f64,
    pub(crate) seed: u64,
}

/// One instrument's reading at each of its times, s.
pub(crate) fn read(
    instrument: &Instrument,
    reading: &SimulatedChannelErrors,
    seen: &MeasuredFlight<'_>,
    times_s: &[f64],
) -> Vec<(f64, f64)> {
    let channel = instrument.channel;
    let mesh_s = seen.mesh_s;
    let truth: Option<Vec<f64>> = seen.states.iter().map(|state| seen.stands.true_value(channel, state)).collect();
    let Some(mut truth) = truth else { return Vec::new() };
    for &tau in &reading.lags_s {
        Lag::new(tau).follow(mesh_s, &mut truth);
    }
    // Each reading has its own number of the stream, whether its noise is on or not.
    let mut noise = NormalNoise::new(seen.seed, channel.index() as u64);
    let noisy = instrument.noise_std != 0.0;
    let bias = reading.bias + if noisy || instrument.bias_std != 0.0 { instrument.bias_std * noise.draw() } else { 0.0 };
    let shaken = instrument.vibration.zip(seen.rotor);
    let shaken = shaken.map(|(lines, (azimuth, blades))| (Vibration::new(channel, lines, blades, seen.seed), azimuth));
    let mut link =
        instrument.dropouts.map(|dropouts| DropoutLink::new(dropouts, channel.index() as u64, seen.start_s, seen.seed));
    let until_s = mesh_s.last().copied().unwrap_or(f64::NEG_INFINITY);
    let mut values = Vec::with_capacity(times_s.len());
    let mut after = 0;
    for &time_s in times_s.iter().take_while(|&&time_s| time_s - reading.delay_s <= until_s) {
        let felt_s = time_s - reading.delay_s;
        let shaking = shaken.as_ref().map_or(0.0, |(lines, azimuth)| lines.at(felt_s, azimuth, reading.lags_s.iter().copied()));
        while mesh_s.get(after).is_some_and(|&mesh_s| mesh_s <= felt_s) {
            after += 1;
        }
        let exact = between(mesh_s, &truth, felt_s, after) + shaking;
        let value = reading.factor * exact + bias + if noisy { instrument.noise_std * noise.draw() } else { 0.0 };
        if !link.as_mut().is_some_and(|link| link.loses(time_s)) {
            values.push((time_s, instrument.word(value)));
        }
    }
    values
}

/// The samples that a link with dropouts lets through.
pub(crate) fn sent(samples: Vec<Sample>, dropouts: Option<Dropouts>, start_s: f64, seed: u64) -> Vec<Sample> {
    let Some(dropouts) = dropouts else { return samples };
    let mut link = DropoutLink::new(dropouts, CHANNELS as u64, start_s, seed);
    samples.into_iter().filter(|sample| !link.loses(sample.time_s)).collect()
}

/// Samples out of every instrument's readings; readings closer than a nanosecond are of one time.
pub(crate) fn gather(readings: &[(Channel, Vec<(f64, f64)>)]) -> Vec<Sample> {
    const APART_S: f64 = 1e-9;
    let longest = readings.iter().map(|(_, values)| values.len()).max().unwrap_or(0);
    let mut samples: Vec<Sample> = Vec::with_capacity(longest);
    let mut left: Vec<(Channel, &[(f64, f64)])> =
        readings.iter().map(|(channel, values)| (*channel, values.as_slice())).collect();
    loop {
        let first = left.iter().filter_map(|(_, values)| values.first()).map(|&(time_s, _)| time_s).min_by(f64::total_cmp);
        let Some(time_s) = first else { break };
        let mut sample = Sample::new(time_s);
        for (channel, values) in &mut left {
            while let Some((&(at_s, value), rest)) = values.split_first()
                && at_s - time_s < APART_S
            {
                sample.set(*channel, value);
                *values = rest;
            }
        }
        samples.push(sample);
    }
    samples
}

/// The value at a time, the place of the first time after it given.
fn between(times_s: &[f64], values: &[f64], time_s: f64, after: usize) -> f64 {
    let at = |place: usize| times_s.get(place).copied().zip(values.get(place).copied());
    match (after.checked_sub(1).and_then(at), at(after)) {
        (Some((t0, x0)), Some((t1, x1))) => x0 + (x1 - x0) * ((time_s - t0) / (t1 - t0)),
        (Some((_, x)), None) | (None, Some((_, x))) => x,
        (None, None) => f64::NAN,
    }
}
