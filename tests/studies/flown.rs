//! Flights of the built-in Puma, and what the pipeline makes of them.

use crate::support::manoeuvre::{LEAD_S, RATE_HZ};
use sideslip::flight::control::{CONTROLS, Control};
use sideslip::flight::run::RunGeometry;
use sideslip::flight::sample::Sample;
use sideslip::flight::signal::piecewise_linear::History;
use sideslip::realtime::pipeline::{Pipeline, PipelineConfig};
use sideslip::simulation::flight_model::{FlightModel, FlightRequest};
use sideslip::simulation::fly::{Flight, uniform_times};
use sideslip::simulation::input::InputSpec;
use sideslip::simulation::instrument::InstrumentSet;

/// The book's knot, m/s.
const KNOT: f64 = 0.5148;

/// The Level-1 Puma in level flight; its linear model is that of small perturbations.
pub(crate) fn puma(knots: f64) -> FlightModel {
    let set = vec!["perturbation=small".to_owned()];
    FlightModel::puma(&FlightRequest { speed: Some(knots * KNOT), set, ..FlightRequest::default() }).unwrap()
}

/// Deviations of the controls that those inputs make, by place.
pub(crate) fn deviations(inputs: &[String]) -> [History; CONTROLS] {
    let mut controls = Control::ALL.map(|_| History::constant(0.0));
    for input in inputs {
        let spec = InputSpec::parse(input).unwrap();
        let control = Control::ALL.into_iter().find(|control| control.channel() == spec.channel).unwrap();
        controls[control.index()] = controls[control.index()].plus(1.0, &spec.deviation(LEAD_S));
    }
    controls
}

/// What instruments record of that aircraft under those inputs.
pub(crate) fn fly(aircraft: &Flight, inputs: &[String], instruments: &InstrumentSet, duration_s: f64, seed: u64) -> Vec<Sample> {
    let mut flight = Flight {
        instruments: instruments.clone(),
        times_s: uniform_times(0.0, duration_s, RATE_HZ).unwrap(),
        seed,
        ..aircraft.clone()
    };
    for (control, deviation) in flight.inputs.controls.iter_mut().zip(deviations(inputs)) {
        *control = control.plus(1.0, &deviation);
    }
    flight.inputs = flight.inputs.sampled(&flight.times_s);
    flight.fly().unwrap().samples
}

/// The pipeline after all of those samples.
pub(crate) fn through(samples: &[Sample]) -> Box<Pipeline> {
    let mut pipeline = Box::new(Pipeline::new(&PipelineConfig::default(), RunGeometry::default()).unwrap());
    for sample in samples {
        pipeline.step(sample);
    }
    pipeline
}
