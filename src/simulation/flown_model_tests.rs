//! Test flights: every effect is at work in what is flown, and instruments read what the closed form says.

use super::fly::{Flight, FlightResult, Inputs, SimulationError, simulate, uniform_times};
use super::input::InputSpec;
use super::instrument::{FLIGHT_QUALITY, Instrument, InstrumentSet};
use crate::flight::channel::Channel;
use crate::flight::control::Control;
use crate::flight::derivative::{Axis, Variable};
use crate::flight::effect::{Effect, EffectKind, PositionedSensor};
use crate::flight::model::{LinearModel, Trim};
use crate::flight::signal::piecewise_linear::History;
use crate::flight::term::Term;

/// A climbing aircraft with stable modes, all values of our own making.
fn model() -> LinearModel {
    let trim = Trim { u: 50.0, w: 1.5, theta: 0.1, phi: 0.02, rotor_speed: Some(27.0), controls: [0.01, 0.0, 0.2, 0.1], v: 0.0 };
    let mut model = LinearModel::about(trim);
    for (axis, variable, value) in [
        (Axis::X, Variable::U, -0.03),
        (Axis::Z, Variable::W, -0.8),
        (Axis::M, Variable::W, -0.03),
        (Axis::M, Variable::Q, -1.0),
        (Axis::Y, Variable::V, -0.15),
        (Axis::L, Variable::V, -0.05),
        (Axis::L, Variable::P, -1.6),
        (Axis::N, Variable::V, 0.03),
        (Axis::N, Variable::P, -0.2),
        (Axis::N, Variable::R, -0.6),
        (Axis::L, Variable::Pedal, 2.0),
        (Axis::N, Variable::Pedal, -9.0),
        (Axis::M, Variable::LonCyclic, 6.0),
        (Axis::Z, Variable::Collective, -100.0),
    ] {
        *model.derivative_mut(axis, variable) = value;
    }
    model
}

/// Pedal 3211 and rotor-speed swings, 12 s at 100 Hz.
fn flight(effects: &[Effect]) -> Flight {
    let model = model();
    let times_s = uniform_times(0.0, 12.0, 100.0).unwrap();
    let mut inputs = Inputs::at_trim(&model);
    let pedal = &mut inputs.controls[Control::Pedal.index()];
    *pedal = pedal.plus(1.0, &InputSpec::parse("pedal:3211:0.02:0.7:1").unwrap().deviation(1.0));
    inputs.rotor_speed = Some(History::through(vec![(0.0, 27.0), (4.0, 27.0), (6.0, 27.5), (9.0, 26.8)]).unwrap());
    Flight { effects: effects.to_vec(), inputs: inputs.sampled(&times_s), times_s, ..Flight::of(model) }
}

fn readings(flown: &FlightResult, channel: Channel) -> Vec<f64> {
    flown.samples.iter().filter_map(|sample| sample.get(channel)).collect()
}

fn largest_difference(a: &[f64], b: &[f64]) -> f64 {
    assert_eq!(a.len(), b.len());
    a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
}

#[test]
fn the_trim_stays_the_trim() {
    let flown = simulate(&model(), &Inputs::at_trim(&model()), &InstrumentSet::perfect(), 10.0, 50.0, 1).unwrap();
    assert_eq!(flown.samples.len(), 501);
    for channel in [Channel::Tas, Channel::Phi, Channel::Az, Channel::R, Channel::Pedal] {
        let values = readings(&flown, channel);
        assert!(values.iter().all(|value| (value - values[0]).abs() < 1e-9), "{channel:?}");
    }
    let climb = model().trim.airspeed() * model().trim.flight_path_angle().sin();
    let altitude = readings(&flown, Channel::Altitude);
    assert!((altitude[500] - altitude[0] - 10.0 * climb).abs() < 1e-8);
}

/// One effect of each kind, in the order of [`EffectKind::ALL`], each large enough to be seen.
pub(crate) fn one_of_each() -> [Effect; 20] {
    let pedal = Control::Pedal;
    [
        Effect::Derivative { axis: Axis::N, variable: Variable::P, delta: -0.1 },
        Effect::Nonlinear { axis: Axis::N, term: Term::SignedSquare(Variable::V), coefficient: 0.005 },
        Effect::ControlEffectiveness { control: pedal, factor: 0.8 },
        Effect::ActuatorLag { control: pedal, tau: 0.15 },
        Effect::TransportDelay { control: pedal, delay: 0.1 },
        Effect::RateLimit { control: pedal, rate: 0.02 },
        Effect::DeadZone { control: pedal, half_width: 0.005 },
        Effect::CrossFeed { from: pedal, to: Control::Collective, gain: 0.3 },
        Effect::RotorSpeed { axis: Axis::N, coefficient: 0.1 },
        Effect::FlightPath { axis: Axis::N, variable: Variable::P, slope: 1.0 },
        Effect::Turbulence { sigma: 1.0, length: 150.0 },
        Effect::SensorBias { channel: Channel::Beta, value: 0.01 },
        Effect::SensorScale { channel: Channel::Pedal, factor: 1.1 },
        Effect::SensorLag { channel: Channel::P, tau: 0.05 },
        Effect::SensorDelay { channel: Channel::R, delay: -0.03 },
        Effect::SensorPosition { sensor: PositionedSensor::Vane, offset_m: [5.0, 0.0, 0.0] },
        Effect::None,
        Effect::Unknown { axis: Axis::L },
        Effect::RotorReaction { reaction: 0.2 },
        Effect::Exchanged { channels: [Channel::P, Channel::R] },
    ]
}

#[test]
fn every_effect_is_flown_or_refused() {
    let effects = one_of_each();
    let plain = flight(&[]).fly().unwrap();
    assert_eq!(effects.map(|effect| effect.kind()).as_slice(), EffectKind::ALL);
    for effect in effects {
        let flown = flight(&[effect]).fly();
        match effect {
            Effect::None => assert_eq!(flown.as_ref(), Ok(&plain)),
            Effect::Unknown { .. } => assert_eq!(flown, Err(SimulationError::NotFlown(EffectKind::Unknown))),
            _ => {
                let changed = FLIGHT_QUALITY
                    .iter()
                    .map(|i| largest_difference(&readings(flown.as_ref().unwrap(), i.channel), &readings(&plain, i.channel)))
                    .fold(0.0, f64::max);
                assert!(changed > 1e-3, "{effect:?} changes nothing: {changed:e}");
            }
        }
    }
}

#[test]
fn half_effectiveness_is_half_the_input() {
    let mut half_input = flight(&[]);
    let pedal = &mut half_input.inputs.controls[Control::Pedal.index()];
    *pedal = History::through(pedal.points().iter().map(|&(t, x)| (t, 0.1 + 0.5 * (x - 0.1))).collect()).unwrap();
    let effect = Effect::ControlEffectiveness { control: Control::Pedal, factor: 0.5 };
    let (by_input, by_effect) = (half_input.fly().unwrap(), flight(&[effect]).fly().unwrap());
    for channel in [Channel::R, Channel::Beta, Channel::Ay] {
        assert!(largest_difference(&readings(&by_input, channel), &readings(&by_effect, channel)) < 1e-12, "{channel:?}");
    }
}

#[test]
fn a_delayed_instrument_reads_what_was_and_a_scaled_one_its_multiple() {
    let plain = readings(&flight(&[]).fly().unwrap(), Channel::R);
    let late =
        [Effect::SensorDelay { channel: Channel::R, delay: 0.05 }, Effect::SensorScale { channel: Channel::R, factor: 2.0 }];
    let late = readings(&flight(&late).fly().unwrap(), Channel::R);
    assert!(largest_difference(&late[5..], &plain[..plain.len() - 5].iter().map(|x| 2.0 * x).collect::<Vec<f64>>()) < 1e-10);
    let early = readings(&flight(&[Effect::SensorDelay { channel: Channel::R, delay: -0.03 }]).fly().unwrap(), Channel::R);
    assert_eq!(early.len(), plain.len());
    assert!(largest_difference(&early[..plain.len() - 3], &plain[3..]) < 1e-10);
}

#[test]
fn a_lag_solves_its_own_equation() {
    // tau dy/dt = x - y: integrated by the trapezium rule on 1 ms samples of the true rate.
    let tau = 0.2;
    let mut fine = flight(&[Effect::SensorLag { channel: Channel::R, tau }]);
    fine.times_s = uniform_times(0.0, 8.0, 1000.0).unwrap();
    let flown = fine.fly().unwrap();
    let (read, mut y, h) = (readings(&flown, Channel::R), 0.0, 1e-3);
    for (place, pair) in flown.truth.windows(2).enumerate() {
        let (x0, x1) = (pair[0].motion.rates[2], pair[1].motion.rates[2]);
        y = (y * (1.0 - h / (2.0 * tau)) + h / (2.0 * tau) * (x0 + x1)) / (1.0 + h / (2.0 * tau));
        assert!((read[place + 1] - y).abs() < 1e-6, "{place}");
    }
}

#[test]
fn instruments_off_the_centre_of_mass_read_the_motion_of_their_own_place() {
    let mut there = flight(&[]);
    there.instruments.accelerometer_position_m = [3.0, -1.0, 0.5];
    there.instruments.vane_position_m = [6.0, 1.0, -0.5];
    there.times_s = uniform_times(0.0, 6.0, 1000.0).unwrap();
    let flown = there.fly().unwrap();
    let cross = |a: [f64; 3], b: [f64; 3]| [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
    let at = |place: usize, r: [f64; 3]| {
        let (v, w) = (flown.truth[place].motion.velocity, cross(flown.truth[place].motion.rates, r));
        [v[0] + w[0], v[1] + w[1], v[2] + w[2]]
    };
    for place in (1..flown.truth.len() - 1).step_by(37) {
        // Specific force of the place: rate of change of its own velocity, turning axes, less gravity.
        let r = there.instruments.accelerometer_position_m;
        let (before, now, after) = (at(place - 1, r), at(place, r), at(place + 1, r));
        let turning = cross(flown.truth[place].motion.rates, now);
        let [phi, theta, _] = flown.truth[place].motion.attitude;
        let gravity = [-theta.sin(), theta.cos() * phi.sin(), theta.cos() * phi.cos()].map(|part| 9.80665 * part);
        for (axis, channel) in [Channel::Ax, Channel::Ay, Channel::Az].into_iter().enumerate() {
            let wanted = (after[axis] - before[axis]) / 2e-3 + turning[axis] - gravity[axis];
            let read = flown.samples[place].get(channel).unwrap();
            // At a corner of the pedal the difference is off by a quarter of the jump: 4.5 rad/s^3 by 3 m by 1 ms.
            assert!((read - wanted).abs() < 5e-3, "{channel:?}, sample {place}: {read} is not {wanted}");
        }
        let [u, v, w] = at(place, there.instruments.vane_position_m);
        let beta = (v / (u * u + v * v + w * w).sqrt()).asin();
        assert!((flown.samples[place].get(Channel::Beta).unwrap() - beta).abs() < 1e-12);
        assert!((flown.samples[place].get(Channel::Alpha).unwrap() - (w / u).atan()).abs() < 1e-12);
    }
}

#[test]
fn one_channel_more_changes_nothing_in_the_others_and_a_seed_repeats() {
    let mut all = flight(&[]);
    all.instruments = InstrumentSet::flight_quality(1.0);
    all.seed = 9;
    let mut fewer = all.clone();
    fewer.instruments.channels.retain(|i| i.channel != Channel::Ax && i.channel != Channel::Q);
    let (all, again, fewer) = (all.fly().unwrap(), all.fly().unwrap(), fewer.fly().unwrap());
    assert_eq!(all, again);
    for channel in [Channel::Ay, Channel::R, Channel::Pedal] {
        assert_eq!(readings(&all, channel), readings(&fewer, channel));
    }
    // White noise about the truth, less the run's own bias, has the stated standard deviation.
    let errors: Vec<f64> =
        readings(&all, Channel::R).iter().zip(&all.truth).map(|(read, state)| read - state.motion.rates[2]).collect();
    let mean = errors.iter().sum::<f64>() / errors.len() as f64;
    let std = (errors.iter().map(|e| (e - mean) * (e - mean)).sum::<f64>() / errors.len() as f64).sqrt();
    assert!((std / 0.001 - 1.0).abs() < 0.1 && mean.abs() < 0.0025, "{std}, {mean}");
}

#[test]
fn channels_at_rates_of_their_own_are_in_the_samples_of_their_times_only() {
    let mut mixed = flight(&[]);
    let at = |channel, rate_hz| Instrument { rate_hz: Some(rate_hz), quantum: Some(1e-3), ..Instrument::perfect(channel) };
    mixed.instruments.channels = vec![at(Channel::P, 32.0), at(Channel::R, 256.0), at(Channel::Phi, 50.0)];
    let flown = mixed.fly().unwrap();
    let counts = [Channel::P, Channel::R, Channel::Phi].map(|channel| readings(&flown, channel).len());
    assert_eq!(counts, [12 * 32 + 1, 12 * 256 + 1, 601]);
    assert!(flown.samples.windows(2).all(|pair| pair[1].time_s > pair[0].time_s));
    assert!(readings(&flown, Channel::R).iter().all(|r| (r * 1e3 - (r * 1e3).round()).abs() < 1e-9));
    let whole_second = flown.samples.iter().find(|sample| (sample.time_s - 3.0).abs() < 1e-12).unwrap();
    assert_eq!(whole_second.present.count_ones(), 3);
}

#[test]
fn rotor_speed_and_gusts_enter_where_they_should() {
    let effects = [Effect::RotorSpeed { axis: Axis::N, coefficient: 0.1 }, Effect::Turbulence { sigma: 1.0, length: 150.0 }];
    let mut one = flight(&effects[..1]);
    one.inputs.controls = Inputs::at_trim(&model()).controls;
    let flown = one.fly().unwrap();
    let start = flown.truth.iter().find(|state| state.time_s > 4.4).unwrap();
    // The rotor is 0.1 rad/s fast after 0.4 s of its ramp; so soon nothing else acts on yaw.
    assert!((start.angular_acceleration[2] - 0.1 * (start.rotor_speed.unwrap() - 27.0)).abs() < 2e-3);
    // As its ramp begins the rotor's acceleration of 0.25 rad/s^2 turns the fuselage: the share that the rotor leaves of it.
    one.effects = vec![Effect::RotorReaction { reaction: -0.2 }];
    let flown = one.fly().unwrap();
    let yaw = |time_s: f64| flown.truth.iter().find(|state| state.time_s >= time_s).unwrap().angular_acceleration[2];
    assert!((yaw(4.0) - yaw(3.9) + 0.2 / 1.2 * 0.25).abs() < 1e-9, "{} {}", yaw(3.9), yaw(4.0));
    let mut gusty = flight(&effects[1..]);
    let whole = gusty.fly().unwrap();
    gusty.max_step_s = Some(0.0025);
    let half = gusty.fly().unwrap();
    for (whole, half) in whole.truth.iter().zip(&half.truth) {
        assert!((whole.motion.rates[2] - half.motion.rates[2]).abs() < 1e-9);
    }
    assert!(whole.truth.iter().any(|state| (state.air_velocity[1] - state.motion.velocity[1]).abs() > 0.3));
}

#[test]
fn divergence_is_a_result_and_nonsense_is_refused() {
    let mut wild = flight(&[Effect::Derivative { axis: Axis::N, variable: Variable::R, delta: 20.0 }]);
    let flown = wild.fly().unwrap();
    let until = flown.diverged_at_s.unwrap();
    assert!(until > 1.0 && until < 12.0 && flown.samples.len() == flown.truth.len());
    assert!(flown.samples.last().unwrap().time_s < until);
    wild.effects = vec![Effect::SensorBias { channel: Channel::Torque, value: 1.0 }];
    assert_eq!(wild.fly(), Err(SimulationError::NoChannel(Channel::Torque)));
    wild.effects = vec![Effect::RotorSpeed { axis: Axis::N, coefficient: 1.0 }];
    wild.model.trim.rotor_speed = None;
    assert_eq!(wild.fly(), Err(SimulationError::NoRotorSpeed));
    assert!(matches!(uniform_times(0.0, 1e9, 1e3), Err(SimulationError::TooLong { .. })));
    assert!(matches!(uniform_times(0.0, 1.0, -1.0), Err(SimulationError::Rate(_))));
    wild = flight(&[]);
    wild.times_s = vec![0.0, 0.0];
    assert_eq!(wild.fly(), Err(SimulationError::Times(0.0)));
    wild = flight(&[]);
    wild.instruments.channels[0].rate_hz = Some(f64::INFINITY);
    assert_eq!(wild.fly(), Err(SimulationError::Rate(f64::INFINITY)));
}
