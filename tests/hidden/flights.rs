//! What is flown: four runs to look at, two to judge by, a pilot's attitude hold in the loop, instruments at their own rates.

use super::case::{Plan, Recorded};
use super::draw::stream;
use crate::support::uniform::Uniform;
use sideslip::flight::channel::Channel;
use sideslip::flight::control::Control;
use sideslip::flight::file::run_file::RunInfo;
use sideslip::flight::model::LinearModel;
use sideslip::flight::sample::Sample;
use sideslip::flight::signal::piecewise_linear::History;
use sideslip::simulation::fly::{Flight, FlightResult, Inputs, uniform_times};
use sideslip::simulation::input::InputSpec;
use sideslip::simulation::instrument::{Instrument, InstrumentSet};
use sideslip::simulation::pilot::Pilot;

/// Rate of attitude, air data and controls, and of the pilot's acts, Hz.
pub(crate) const RATE_HZ: f64 = 64.0;
/// Steady flight before the first input, s.
const LEAD_S: f64 = 2.0;
pub(crate) const FIT: usize = 4;
/// Where the instruments stand, as the runs say, m.
const ACCELEROMETER_M: [f64; 3] = [0.3, 0.0, 0.2];
const VANE_M: [f64; 3] = [6.5, 0.0, 0.8];
const BLADES: u32 = 4;

/// Bounds that a flight keeps: bank and pitch, rad; rates, rad/s; deviation of a velocity, m/s.
const BOUNDS: [f64; 3] = [0.9, 0.8, 20.0];

/// Channel, rate Hz, noise; the accelerometers' noise is drawn.
const INSTRUMENTS: [(Channel, f64, f64); 18] = [
    (Channel::Ax, 128.0, 0.08),
    (Channel::Ay, 128.0, 0.08),
    (Channel::Az, 128.0, 0.08),
    (Channel::P, 128.0, 0.003),
    (Channel::Q, 128.0, 0.003),
    (Channel::R, 128.0, 0.003),
    (Channel::Phi, 64.0, 0.0017),
    (Channel::Theta, 64.0, 0.0017),
    (Channel::Psi, 64.0, 0.0017),
    (Channel::Tas, 64.0, 0.25),
    (Channel::Alpha, 64.0, 0.0025),
    (Channel::Beta, 64.0, 0.0025),
    (Channel::LonCyclic, 64.0, 0.0002),
    (Channel::LatCyclic, 64.0, 0.0002),
    (Channel::Collective, 64.0, 0.0002),
    (Channel::Pedal, 64.0, 0.0002),
    (Channel::Altitude, 32.0, 0.5),
    (Channel::RotorSpeed, 32.0, 0.02),
];

/// Channels with their noise, those of the accelerometers in the middle of what is drawn.
pub(crate) fn noise_stds() -> impl Iterator<Item = (Channel, f64)> {
    INSTRUMENTS.into_iter().map(|(channel, _, std)| (channel, std))
}

/// One run's inputs and length.
#[derive(Clone, Debug)]
pub(crate) struct Manoeuvre {
    pub(crate) name: String,
    pub(crate) inputs: Vec<String>,
    pub(crate) duration_s: f64,
}

/// The six runs' manoeuvres and what shakes the aircraft.
#[derive(Clone, Debug)]
pub(crate) struct Manoeuvres {
    pub(crate) runs: Vec<Manoeuvre>,
    accelerometer_noise: f64,
    /// Amplitude on x, y, z at blade passing, m/s^2.
    vibration: [f64; 3],
    /// Of each run: amplitude rad/s, period s, phase rad of the rotor's wander.
    wander: Vec<[[f64; 3]; 3]>,
}

impl Manoeuvres {
    pub(crate) fn draw(seed: u64) -> Self {
        let mut uniform = Uniform(stream(seed, 1));
        let sign = if uniform.within(1.0) < 0.0 { -1.0 } else { 1.0 };
        let mut input = |control: &str, shape: &str, amplitude: f64, clock: f64, start: Option<f64>| {
            let amplitude = amplitude * uniform.between(0.8, 1.2);
            let clock = clock * uniform.between(0.85, 1.15);
            let start = start.map_or(String::new(), |start| format!(":{start}"));
            format!("{control}:{shape}:{amplitude:.5}:{clock:.3}{start}")
        };
        let inputs = [
            ("fit-1", vec![input("pedal", "3211", sign * 0.02, 0.7, None)]),
            ("fit-2", vec![input("lat_cyclic", "3211", sign * 0.009, 0.5, None)]),
            ("fit-3", vec![input("pedal", "doublet", -sign * 0.02, 1.0, None)]),
            ("fit-4", vec![input("lon_cyclic", "3211", sign * 0.022, 0.7, None)]),
            ("holdout-1", vec![input("pedal", "doublet", sign * 0.017, 0.8, None)]),
            (
                "holdout-2",
                vec![
                    input("lat_cyclic", "doublet", -sign * 0.009, 0.7, None),
                    input("lon_cyclic", "doublet", -sign * 0.02, 0.9, Some(8.0)),
                ],
            ),
        ];
        let runs = inputs
            .into_iter()
            .map(|(name, inputs)| Manoeuvre { name: name.to_owned(), inputs, duration_s: uniform.between(16.0, 22.0) })
            .collect::<Vec<_>>();
        let accelerometer_noise = uniform.between(0.06, 0.1);
        let vibration = [(); 3].map(|()| uniform.between(0.15, 0.4));
        let wander = runs
            .iter()
            .map(|_| {
                [4.0, 8.0, 15.0].map(|period| {
                    [uniform.between(0.08, 0.16), period * uniform.between(0.8, 1.25), uniform.within(core::f64::consts::PI)]
                })
            })
            .collect();
        Manoeuvres { runs, accelerometer_noise, vibration, wander }
    }

    /// Rotor speed of that run, rad/s: at trim over its first second, then it wanders.
    fn rotor_speed(&self, run: usize, at_trim: f64) -> History {
        let points = (0..=250).map(|step| {
            let time_s = 0.1 * f64::from(step);
            let wander: f64 = self.wander[run]
                .iter()
                .map(|&[amplitude, period, phase]| {
                    amplitude * ((core::f64::consts::TAU * time_s / period + phase).sin() - phase.sin())
                })
                .sum();
            (time_s, at_trim + wander * (0.5 * (time_s - 1.0)).clamp(0.0, 1.0))
        });
        History::through(points.collect()).unwrap()
    }

    pub(crate) fn instruments(&self) -> InstrumentSet {
        let channels = INSTRUMENTS.map(|(channel, rate_hz, noise_std)| {
            let axis = [Channel::Ax, Channel::Ay, Channel::Az].iter().position(|&one| one == channel);
            Instrument {
                rate_hz: Some(rate_hz),
                noise_std: axis.map_or(noise_std, |_| self.accelerometer_noise),
                vibration: axis.map(|axis| [self.vibration[axis], 0.0]),
                ..Instrument::perfect(channel)
            }
        });
        InstrumentSet {
            channels: channels.to_vec(),
            accelerometer_position_m: ACCELEROMETER_M,
            vane_position_m: VANE_M,
            blades: Some(f64::from(BLADES)),
            dropouts: None,
        }
    }
}

/// A pilot's inputs, at the rate of the record, so that straight lines between its samples are what was flown.
pub(crate) fn hands(model: &LinearModel, specs: &[impl AsRef<str>], times_s: &[f64]) -> Inputs {
    let mut inputs = Inputs::at_trim(model);
    for spec in specs {
        let spec = InputSpec::parse(spec.as_ref()).unwrap();
        let control = Control::ALL.into_iter().find(|control| control.channel() == spec.channel).unwrap();
        let history = &mut inputs.controls[control.index()];
        *history = history.plus(1.0, &spec.deviation(LEAD_S));
    }
    inputs.sampled(times_s)
}

/// One run of the plan as it was flown; `None` where the aircraft leaves its bounds.
pub(crate) fn flown(plan: &Plan, run: usize) -> Option<FlightResult> {
    let manoeuvre = &plan.manoeuvres.runs[run];
    let model = &plan.truth.model;
    let times_s = uniform_times(0.0, manoeuvre.duration_s, RATE_HZ).unwrap();
    let mut inputs = hands(model, &manoeuvre.inputs, &times_s);
    inputs.rotor_speed = Some(plan.manoeuvres.rotor_speed(run, model.trim.rotor_speed.unwrap()));
    let flight = Flight {
        effects: plan.hidden.effects.clone(),
        unmodelled: plan.hidden.law.as_ref().map(|law| law.flown.clone()),
        inputs,
        pilot: Some(Pilot::ATTITUDE),
        instruments: plan.manoeuvres.instruments(),
        times_s,
        seed: stream(plan.seed, 100 + run as u64),
        ..Flight::of(model.clone())
    };
    let flown = flight.fly().unwrap();
    let trim = &model.trim;
    let [angle, rate, velocity] = BOUNDS;
    let kept = flown.truth.iter().all(|state| {
        let [phi, theta, _] = state.motion.attitude;
        let angles = (phi - trim.phi).abs() < angle && (theta - trim.theta).abs() < angle;
        let velocities = state.motion.velocity.iter().zip([trim.u, trim.v, trim.w]).all(|(x, x0)| (x - x0).abs() < velocity);
        angles && velocities && state.motion.rates.iter().all(|x| x.abs() < rate)
    });
    (flown.diverged_at_s.is_none() && kept).then_some(flown)
}

/// What those instruments recorded.
pub(crate) fn recorded(name: &str, inputs: &str, samples: Vec<Sample>) -> Recorded {
    let text = format!(
        "run = \"{name}\"\naircraft = \"Puma\"\nmanoeuvre = \"{inputs}\"\naccelerometer_position_m = {ACCELEROMETER_M:?}\n\
         vane_position_m = {VANE_M:?}\nblades = {BLADES}\n"
    );
    Recorded { name: name.to_owned(), info: RunInfo::from_toml(&text).unwrap(), samples }
}

/// The plan's runs to look at and to judge by; `None` where one leaves its bounds.
pub(crate) fn fly(plan: &Plan) -> Option<(Vec<Recorded>, Vec<Recorded>)> {
    let runs = plan.manoeuvres.runs.iter().enumerate();
    let mut fit = runs
        .map(|(run, manoeuvre)| {
            let samples = flown(plan, run)?.samples;
            Some(recorded(&manoeuvre.name, &manoeuvre.inputs.join(" "), samples))
        })
        .collect::<Option<Vec<_>>>()?;
    let holdout = fit.split_off(FIT);
    Some((fit, holdout))
}

/// That run's controls and rotor speed, as they were recorded, flown by that model without a pilot, seen without noise.
pub(crate) fn again(recorded: &Recorded, model: &LinearModel) -> Vec<Sample> {
    let instruments =
        InstrumentSet { accelerometer_position_m: ACCELEROMETER_M, vane_position_m: VANE_M, ..InstrumentSet::perfect() };
    let inputs = Inputs {
        controls: Channel::CONTROLS.map(|channel| history(recorded, channel)),
        rotor_speed: Some(history(recorded, Channel::RotorSpeed)),
    };
    flown_again(recorded, model, inputs, instruments, 0)
}

/// The same from the model's trim, the controls' mean over the first second, through instruments with the noise of that seed.
pub(crate) fn seen_again(recorded: &Recorded, model: &LinearModel, instruments: &InstrumentSet, seed: u64) -> Recorded {
    let from_trim = |channel: Channel, at_trim: f64| {
        let first = recorded.samples.iter().take_while(|sample| sample.time_s <= recorded.samples[0].time_s + 1.0);
        let first: Vec<f64> = first.filter_map(|sample| sample.get(channel)).collect();
        history(recorded, channel).shifted(at_trim - first.iter().sum::<f64>() / first.len() as f64)
    };
    let controls = core::array::from_fn(|place| from_trim(Channel::CONTROLS[place], model.trim.controls[place]));
    let rotor_speed = model.trim.rotor_speed.map(|at_trim| from_trim(Channel::RotorSpeed, at_trim));
    let samples = flown_again(recorded, model, Inputs { controls, rotor_speed }, instruments.clone(), seed);
    Recorded { samples, ..recorded.clone() }
}

fn history(recorded: &Recorded, channel: Channel) -> History {
    let points = recorded.samples.iter().filter_map(|sample| Some((sample.time_s, sample.get(channel)?)));
    History::through(points.collect()).unwrap()
}

fn flown_again(recorded: &Recorded, model: &LinearModel, inputs: Inputs, instruments: InstrumentSet, seed: u64) -> Vec<Sample> {
    let times_s: Vec<f64> = recorded.samples.iter().map(|sample| sample.time_s).collect();
    Flight { inputs, instruments, times_s, seed, ..Flight::of(model.clone()) }.fly().unwrap().samples
}
