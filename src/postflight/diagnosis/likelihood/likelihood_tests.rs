//! Slopes against differences: what the filter says of its parameters and noises is what happens when they are moved.

use super::aircraft::Aircraft;
use super::normal_equations::{Detail, linearise};
use super::parameter_set::{Hypothesis, ParameterSet};
use super::problem::DiagnosisProblem;
use crate::flight::channel::Channel;
use crate::flight::control::Control;
use crate::flight::derivative::{AXES, Axis, VARIABLES, Variable};
use crate::flight::effect::{Effect, PositionedSensor};
use crate::flight::run::RunGeometry;
use crate::flight::sample::Sample;
use crate::flight::term::Term;
use crate::postflight::diagnosis::data::run_data::RunData;
use crate::simulation::flight_model::{FlightModel, FlightRequest};
use crate::simulation::fly::{Flight, Inputs, uniform_times};
use crate::simulation::input::InputSpec;
use crate::simulation::instrument::InstrumentSet;

/// The built-in aircraft, linear, on a pedal 3211 and a cyclic doublet.
pub(crate) fn flown(effects: Vec<Effect>) -> (FlightModel, Vec<Sample>) {
    let puma = FlightModel::puma(&FlightRequest::default()).unwrap();
    let text = crate::flight::file::model_file::ModelFile { linear: puma.linear().clone(), ..puma.file }.to_toml();
    let model = FlightModel::parse(&text, &FlightRequest::default()).unwrap();
    let times_s = uniform_times(0.0, 9.0, 128.0).unwrap();
    let mut inputs = Inputs::at_trim(model.linear());
    for (control, input) in [(Control::Pedal, "pedal:3211:0.02:0.5:1"), (Control::LonCyclic, "lon_cyclic:doublet:0.02:0.8:4")] {
        let history = &mut inputs.controls[control.index()];
        *history = history.plus(1.0, &InputSpec::parse(input).unwrap().deviation(0.5));
    }
    let flight = Flight {
        inputs: inputs.sampled(&times_s),
        instruments: InstrumentSet::flight_quality(1.0),
        times_s,
        seed: 3,
        effects,
        ..Flight::of(model.linear().clone())
    };
    let samples = flight.fly().unwrap().samples;
    (model, samples)
}

/// The model beside a flight with effects that it does not have.
pub(crate) fn problem_with(effects: Vec<Effect>) -> DiagnosisProblem {
    let (model, samples) = flown(effects);
    let record = RunData::of("one", &samples, RunGeometry::DEFAULT).unwrap();
    DiagnosisProblem::new(Aircraft::of(&model), Vec::new(), vec![record], 0.03, &[[0.0; VARIABLES]; AXES])
}

fn problem() -> DiagnosisProblem {
    problem_with(Vec::new())
}

fn with(problem: &DiagnosisProblem, effect: Effect) -> ParameterSet {
    let mut point = problem.null_hypothesis();
    point.hypotheses.push(Hypothesis::of(effect, 1e3));
    point
}

fn cost(problem: &DiagnosisProblem, point: &ParameterSet) -> f64 {
    linearise(problem, point, &[], Detail::Cost).unwrap().cost
}

/// (4) of the filter is exact: the gain hangs on the noise, and so do the state and every innovation after.
#[test]
fn the_score_of_a_noise_is_the_slope_of_the_cost() {
    let problem = problem();
    let mut point = problem.null_hypothesis();
    point.gust = (0.3, 4.0);
    let local = linearise(&problem, &point, &[], Detail::Slopes).unwrap();
    for of in 0..=AXES {
        let at = |by: f64| {
            let mut there = point.clone();
            match there.force_density.get_mut(of) {
                Some(density) => *density *= by.exp(),
                None => there.gust.0 *= (0.5 * by).exp(),
            }
            cost(&problem, &there)
        };
        let slope = (at(1e-3) - at(-1e-3)) / 2e-3;
        let (said, curvature) = local.noise_score[of];
        assert!((said - slope).abs() < 1e-3 * slope.abs() + 0.02, "noise {of}: {said} is not {slope}");
        assert!(curvature > 0.0);
    }
}

/// Half the cost's slope is what the innovations pull, but for the gain's and the Jacobians' own dependence on the parameter.
#[test]
fn what_a_parameter_pulls_is_the_slope_of_the_cost() {
    let problem = problem();
    let (axis, channel) = (Axis::N, Channel::R);
    for (effect, step) in [
        (Effect::Derivative { axis, variable: Variable::V, delta: 0.002 }, 1e-5),
        (Effect::Nonlinear { axis, term: Term::SignedSquare(Variable::R), coefficient: 0.5 }, 1e-3),
        (Effect::ControlEffectiveness { control: Control::Pedal, factor: 1.1 }, 1e-3),
        (Effect::ActuatorLag { control: Control::Pedal, tau: 0.1 }, 1e-3),
        (Effect::TransportDelay { control: Control::Pedal, delay: 0.1 }, 2e-3),
        (Effect::CrossFeed { from: Control::LonCyclic, to: Control::Pedal, gain: 0.1 }, 1e-3),
        (Effect::RateLimit { control: Control::Pedal, rate: 0.08 }, 1.6e-3),
        (Effect::DeadZone { control: Control::Pedal, half_width: 0.004 }, 1e-5),
        (Effect::SensorBias { channel: Channel::Theta, value: 0.003 }, 1e-5),
        (Effect::SensorScale { channel, factor: 1.05 }, 1e-4),
        (Effect::SensorLag { channel, tau: 0.08 }, 1e-4),
        (Effect::SensorDelay { channel, delay: 0.05 }, 1e-4),
        (Effect::SensorBias { channel: Channel::Pedal, value: 0.002 }, 1e-5),
        (Effect::SensorPosition { sensor: PositionedSensor::Vane, offset_m: [2.0, 0.0, 0.0] }, 1e-2),
        (Effect::SensorPosition { sensor: PositionedSensor::Accelerometer, offset_m: [1.0, 0.0, 0.0] }, 1e-3),
    ] {
        let point = with(&problem, effect);
        let local = linearise(&problem, &point, &[], Detail::Slopes).unwrap();
        let at = |by: f64| {
            let mut there = point.clone();
            there.change((0, 0), by, 100.0);
            cost(&problem, &there)
        };
        let slope = (at(step) - at(-step)) / (2.0 * step);
        let said = -2.0 * local.gradient[0];
        // A difference of one over the standard error would move the number by half of that.
        let std = local.std(0);
        assert!((said - slope).abs() < 0.06 * slope.abs() + 0.5 / std, "{effect:?}: {said} is not {slope}, std {std}");
    }
}
