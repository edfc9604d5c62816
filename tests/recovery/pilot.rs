//! The built-in Puma with a pilot who holds its attitude: long flights stay near the trim, and its derivatives are what they
//! are without him.

use super::WANTED;
use crate::support::asked::seeds;
use crate::support::manoeuvre::{DURATION_S, INPUTS, LEAD_S, over_seeds};
use crate::support::puma::puma_100kn;
use nalgebra::{DMatrix, DVector};
use sideslip::flight::channel::Channel;
use sideslip::flight::control::Control;
use sideslip::flight::derivative::{Axis, Variable};
use sideslip::flight::model::LinearModel;
use sideslip::flight::run::RunGeometry;
use sideslip::flight::signal::piecewise_linear::History;
use sideslip::realtime::pipeline::{Pipeline, PipelineConfig};
use sideslip::simulation::flight_model::{FlightModel, FlightRequest};
use sideslip::simulation::fly::{Flight, FlightResult, uniform_times};
use sideslip::simulation::input::InputSpec;
use sideslip::simulation::instrument::InstrumentSet;
use sideslip::simulation::integrate::TrueState;
use sideslip::simulation::pilot::Pilot;

pub(super) const KNOT: f64 = 1852.0 / 3600.0;

/// The Level-1 Puma at that speed with these inputs.
fn flight(knots: f64, inputs: &[&str], duration_s: f64) -> (Flight, FlightModel) {
    let model = FlightModel::puma(&FlightRequest {
        speed: Some(knots * KNOT),
        set: vec!["perturbation=small".to_owned()],
        ..FlightRequest::default()
    });
    let model = model.unwrap();
    (with_inputs(model.flight(), inputs, duration_s), model)
}

pub(super) fn with_inputs(mut flight: Flight, inputs: &[&str], duration_s: f64) -> Flight {
    flight.times_s = uniform_times(0.0, duration_s, 100.0).unwrap();
    for input in inputs {
        let spec = InputSpec::parse(input).unwrap();
        for control in Control::ALL.into_iter().filter(|control| control.channel() == spec.channel) {
            let history = &mut flight.inputs.controls[control.index()];
            *history = history.plus(1.0, &spec.deviation(LEAD_S));
        }
    }
    flight.inputs = flight.inputs.sampled(&flight.times_s);
    flight
}

/// Largest deviation of a channel from its first value.
fn largest(flown: &FlightResult, channel: Channel) -> f64 {
    let values: Vec<f64> = flown.samples.iter().filter_map(|sample| sample.get(channel)).collect();
    values.iter().map(|value| (value - values[0]).abs()).fold(0.0, f64::max)
}

#[test]
fn at_140_kn_it_stays_near_its_trim_for_two_minutes_with_him_and_is_lost_without() {
    let (mut alone, _) = flight(140.0, &["pedal:3211:0.02:0.7"], 120.0);
    let wild = alone.fly().unwrap();
    alone.pilot = Some(Pilot::ATTITUDE);
    let held = alone.fly().unwrap();
    assert!(wild.diverged_at_s.is_some() || largest(&wild, Channel::Phi) > 3.0);
    assert!(held.diverged_at_s.is_none() && held.samples.len() == 12_001);
    let limits = [(Channel::Phi, 0.7), (Channel::Theta, 0.2), (Channel::Beta, 0.3), (Channel::Tas, 5.0), (Channel::P, 0.7)];
    for (channel, limit) in limits {
        let moved = largest(&held, channel);
        assert!(moved < limit, "{channel:?}: {moved}");
    }
    // His hands move less than the test input; his feet hold still.
    let moved = [Channel::LatCyclic, Channel::LonCyclic, Channel::Pedal].map(|channel| largest(&held, channel));
    assert!(moved[0] > 1e-3 && moved[0] < 0.02 && moved[1] > 1e-4 && moved[1] < 0.01, "{moved:?}");
    assert!((moved[2] - 0.02).abs() < 1e-12, "{moved:?}");
}

#[test]
fn the_recorded_controls_flown_again_without_him_give_the_same_flight() {
    let (mut held, model) = flight(100.0, &["pedal:prbs4:0.01:0.6", "lat_cyclic:3211:0.008:0.5:12"], 30.0);
    held.pilot = Some(Pilot::ATTITUDE_AND_HEADING);
    let first = held.fly().unwrap();
    let mut again = Flight { pilot: None, ..held };
    for control in Control::ALL {
        let recorded = first.samples.iter().map(|sample| (sample.time_s, sample.get(control.channel()).unwrap())).collect();
        again.inputs.controls[control.index()] = History::through(recorded).unwrap();
    }
    assert!(model.level1.is_some());
    let second = again.fly().unwrap();
    for (a, b) in first.truth.iter().zip(&second.truth) {
        let (a, b) = (a.motion.to_vector(), b.motion.to_vector());
        assert!(a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-8), "{a:?} {b:?}");
    }
    assert_eq!(first.truth.len(), second.truth.len());
}

/// Derivatives of an axis by ordinary least squares of the true acceleration on the true motion and the controls that moved.
fn by_least_squares(flown: &FlightResult, model: &LinearModel, axis: Axis, variables: &[Variable]) -> Vec<f64> {
    let trim = &model.trim;
    let of = |state: &TrueState, variable: Variable| {
        let motion = state.motion.velocity.into_iter().chain(state.motion.rates);
        let all: Vec<f64> = motion.chain(state.controls).collect();
        let order = [Variable::U, Variable::V, Variable::W, Variable::P, Variable::Q, Variable::R];
        let controls = Control::ALL.map(|control| control.variable());
        let place = order.into_iter().chain(controls).position(|other| other == variable).unwrap();
        all[place] - trim.of(variable)
    };
    let rows = flown.truth.len();
    let x = DMatrix::from_fn(rows, variables.len(), |row, column| of(&flown.truth[row], variables[column]));
    let y = DVector::from_fn(rows, |row, _| flown.truth[row].angular_acceleration[axis.index() - 3]);
    let normal = x.transpose() * &x;
    normal.cholesky().unwrap().solve(&(x.transpose() * y)).iter().copied().collect()
}

const LATERAL: [Variable; 5] = [Variable::V, Variable::P, Variable::R, Variable::LatCyclic, Variable::Pedal];

/// So small an input that the aircraft is linear: what is left of its curvature goes with the amplitude (ten times the
/// input, ten times the error). The derivatives of the lateral motion, which the input excites, within 1 %, the smallest of them
/// within 1 % of what is usual.
#[test]
fn derivatives_by_least_squares_are_the_model_s_with_him_and_without() {
    let motion = [Variable::U, Variable::V, Variable::W, Variable::P, Variable::Q, Variable::R];
    let mut worst = 0.0f64;
    for knots in [80.0, 100.0, 120.0] {
        let (alone, model) = flight(knots, &["pedal:3211:0.00001:0.7", "lat_cyclic:3211:0.000005:0.5:7"], 30.0);
        let held = Flight { pilot: Some(Pilot::ATTITUDE), ..alone.clone() };
        let linear = model.linear();
        for (flown, controls) in [
            (alone.fly().unwrap(), &[Variable::LatCyclic, Variable::Pedal][..]),
            (held.fly().unwrap(), &[Variable::LonCyclic, Variable::LatCyclic, Variable::Pedal]),
        ] {
            let variables: Vec<Variable> = motion.into_iter().chain(controls.iter().copied()).collect();
            for axis in [Axis::L, Axis::N] {
                let found = by_least_squares(&flown, linear, axis, &variables);
                for (&variable, found) in variables.iter().zip(found).filter(|(variable, _)| LATERAL.contains(variable)) {
                    let truth = linear.derivative(axis, variable);
                    let size = if variable == Variable::V { 0.02 } else { 0.2 };
                    let name = format!("{knots} kn, {} controls, {}_{variable:?}", controls.len(), axis.name());
                    worst = worst.max((found - truth).abs() / truth.abs().max(size));
                    assert!((found - truth).abs() < 0.01 * truth.abs().max(size), "{name}: {found} for {truth}");
                }
            }
        }
    }
    eprintln!("largest relative error {worst:.4}");
}

/// As `puma_100kn` without him, 40 seeds: were his feedback mistaken for the aircraft's own motion, the scores would show it.
#[test]
fn the_pipeline_s_derivatives_are_within_their_standard_errors_with_him() {
    let Some(model) = puma_100kn() else { return };
    let mut held = with_inputs(Flight::of(model.clone()), &INPUTS, DURATION_S);
    (held.pilot, held.instruments) = (Some(Pilot::ATTITUDE), InstrumentSet::flight_quality(1.0));
    let all = over_seeds(seeds(40), |seed| {
        let mut pipeline = Box::new(Pipeline::new(&PipelineConfig::default(), RunGeometry::default()).unwrap());
        for sample in &(Flight { seed, ..held.clone() }).fly().unwrap().samples {
            pipeline.step(sample);
        }
        let last = pipeline.finish().derivatives.clone().unwrap();
        WANTED.map(|(axis, variable)| {
            let term = last.equations[axis.index()].term(variable);
            term.map_or(f64::INFINITY, |term| (term.value - model.derivative(axis, variable)) / term.std)
        })
    });
    for (place, (axis, variable)) in WANTED.into_iter().enumerate() {
        let scores: Vec<f64> = all.iter().map(|one| one[place]).collect();
        let within = scores.iter().filter(|score| score.abs() < 3.0).count();
        let mean = scores.iter().sum::<f64>() / scores.len() as f64;
        eprintln!("{}_{variable:?}: {within} of {} within 3 standard errors, mean {mean:+.2}", axis.name(), scores.len());
        assert!(20 * within >= 19 * scores.len() && mean.abs() < 1.0, "{axis:?} {variable:?}: {scores:?}");
    }
}
