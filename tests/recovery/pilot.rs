//! The built-in Puma with a pilot who holds its attitude: long flights stay near the trim, and its derivatives are what they
//! are without him.

use sideslip::flight::channel::Channel;
use sideslip::flight::control::Control;
use sideslip::flight::derivative::{Axis, Variable};
use sideslip::flight::run::RunGeometry;
use sideslip::pipeline::{Config, Pipeline};
use sideslip::simulation::flight_model::{Asked, FlightModel};
use sideslip::simulation::fly::{Flight, Flown, uniform_times};
use sideslip::simulation::input::InputSpec;
use sideslip::simulation::instrument::Instruments;
use sideslip::simulation::pilot::Pilot;

const KNOT: f64 = 1852.0 / 3600.0;

/// The Puma at that speed with these inputs.
fn flight(knots: f64, inputs: &[&str], duration_s: f64) -> (Flight, FlightModel) {
    let model = FlightModel::puma(&Asked { speed: Some(knots * KNOT), ..Asked::default() }).unwrap();
    let mut flight = model.flight();
    flight.times_s = uniform_times(0.0, duration_s, 100.0).unwrap();
    for input in inputs {
        let spec = InputSpec::parse(input).unwrap();
        for control in Control::ALL.into_iter().filter(|control| control.channel() == spec.channel) {
            let history = &mut flight.inputs.controls[control.index()];
            *history = history.plus(1.0, &spec.deviation(2.0));
        }
    }
    flight.inputs = flight.inputs.sampled(&flight.times_s);
    (flight, model)
}

/// Largest deviation of a channel from its first value.
fn largest(flown: &Flown, channel: Channel) -> f64 {
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
        again.inputs.controls[control.index()] = sideslip::simulation::history::History::through(recorded).unwrap();
    }
    assert!(model.level1.is_some());
    let second = again.fly().unwrap();
    for (a, b) in first.truth.iter().zip(&second.truth) {
        let (a, b) = (a.motion.to_vector(), b.motion.to_vector());
        assert!(a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-8), "{a:?} {b:?}");
    }
    assert_eq!(first.truth.len(), second.truth.len());
}

/// Lateral derivatives as the pipeline estimates them.
fn estimated(flight: &Flight, wanted: &[(Axis, Variable)]) -> Vec<f64> {
    let mut pipeline = Box::new(Pipeline::new(&Config::default(), RunGeometry::default()).unwrap());
    for sample in &flight.fly().unwrap().samples {
        pipeline.step(sample);
    }
    let last = pipeline.finish().derivatives.clone().unwrap();
    wanted
        .iter()
        .map(|&(axis, variable)| last.equations[axis.index()].term(variable).map_or(f64::NAN, |term| term.value))
        .collect()
}

#[test]
fn derivatives_estimated_with_him_are_those_without() {
    let wanted = [
        (Axis::N, Variable::V),
        (Axis::N, Variable::P),
        (Axis::N, Variable::R),
        (Axis::N, Variable::Pedal),
        (Axis::L, Variable::V),
        (Axis::L, Variable::P),
        (Axis::L, Variable::LatCyclic),
    ];
    for knots in [80.0, 100.0] {
        let (mut alone, model) = flight(knots, &["pedal:3211:0.01:0.7", "lat_cyclic:3211:0.004:0.5:7"], 22.0);
        let truth = model.linear();
        for noise in [0.0, 1.0] {
            alone.instruments = Instruments::flight_quality(noise);
            let without = estimated(&alone, &wanted);
            let with = estimated(&Flight { pilot: Some(Pilot::ATTITUDE), ..alone.clone() }, &wanted);
            for ((&(axis, variable), without), with) in wanted.iter().zip(without).zip(with) {
                let truth = truth.derivative(axis, variable);
                eprintln!(
                    "{knots} kn noise {noise} {}_{variable:?}: model {truth:.4}, without {without:.4}, with {with:.4}",
                    axis.name()
                );
            }
        }
    }
}
