//! The Level-1 Puma: one evaluation of its equations, one linearisation from a cold start, one simulated second.

use crate::ledger::{Ledger, group};
use criterion::Criterion;
use sideslip::simulation::flight_model::{FlightModel, FlightRequest, PUMA};
use sideslip::simulation::fly::{Flight, uniform_times};
use std::hint::black_box;

/// Seconds of the flight that is timed; the printed time is that of all of them.
const SECONDS: f64 = 20.0;

pub(crate) fn run(criterion: &mut Criterion, ledger: &Ledger) {
    let mut group = group(criterion, "level1");
    let model = FlightModel::parse(PUMA, &FlightRequest::default()).unwrap();
    let trimmed = model.level1.clone().unwrap();
    let (aircraft, mut met) = (trimmed.aircraft.clone(), trimmed.situation());
    ledger.bench(&mut group, "level1: forces and moments", || {
        met.velocity[1] = 1e-3 - met.velocity[1];
        black_box(aircraft.respond(black_box(&met)));
    });
    ledger.bench(&mut group, "level1: trim from cold and linearisation", || {
        black_box(aircraft.trim(black_box(trimmed.condition)).unwrap().linear());
    });
    let flight = Flight { times_s: uniform_times(0.0, SECONDS, 64.0).unwrap(), ..model.flight() };
    ledger.bench(&mut group, "level1: 20 s at 256 Hz, fourth order", || {
        black_box(flight.fly().unwrap());
    });
    group.finish();
    ledger.tell("level1: forces and moments", 1.0, ", one evaluation");
    ledger.tell("level1: trim from cold and linearisation", 1.0, " (at most 2 000 000 is asked)");
    ledger.tell("level1: 20 s at 256 Hz, fourth order", SECONDS, " a simulated second; beside JSBSim: jsbsim/compare.py");
}
