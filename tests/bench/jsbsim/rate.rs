//! How fast the Level-1 Puma flies: simulated seconds a second at 256 Hz, fourth order, and the time of one linearisation.
//!
//! Prints `key value` a line for `compare.py` beside it. One thread. The flight has a pedal 3211 and is long enough that its
//! start does not count. Motion and loads alone are timed, for nothing reads the other side's either; then with what all the
//! instruments read of it.

#![expect(clippy::unwrap_used, clippy::print_stdout, reason = "a benchmark stops where its data are wrong, and prints")]

#[path = "../../support/processor_clock.rs"]
mod processor_clock;

use processor_clock::Clock;
use sideslip::flight::control::Control;
use sideslip::simulation::flight_model::{FlightModel, FlightRequest};
use sideslip::simulation::fly::{Flight, uniform_times};
use sideslip::simulation::input::InputSpec;
use std::hint::black_box;

/// Length of a flight, s: a Puma whose stick nobody holds leaves its trim for good after about half a minute.
const FLIGHT_S: f64 = 20.0;

/// For how long it is measured, s.
const MEASURED_S: f64 = 2.0;

fn main() {
    let model = FlightModel::puma(&FlightRequest::default()).unwrap();
    let mut flight = Flight { times_s: uniform_times(0.0, FLIGHT_S, 256.0).unwrap(), ..model.flight() };
    let pedal = &mut flight.inputs.controls[Control::Pedal.index()];
    *pedal = pedal.plus(1.0, &InputSpec::parse("pedal:3211:0.01:0.7").unwrap().deviation(1.0));
    let flown = flight.fly().unwrap();
    assert!(flown.diverged_at_s.is_none() && flown.truth.len() == flight.times_s.len(), "the whole flight is flown");
    for (name, channels) in
        [("simulated_seconds_per_second", Vec::new()), ("with_instruments", flight.instruments.channels.clone())]
    {
        flight.instruments.channels = channels;
        let rate = per_second(|| {
            black_box(black_box(&flight).fly().unwrap());
        });
        println!("{name} {:.1}", rate * FLIGHT_S);
    }
    let trimmed = model.level1.unwrap();
    let linearised = per_second(|| {
        black_box(trimmed.aircraft.trim(black_box(trimmed.condition)).unwrap().linear());
    });
    println!("milliseconds_per_linearisation {:.4}", 1e3 / linearised);
}

/// Calls a second of processor time, over [`MEASURED_S`] after a first one.
fn per_second(mut work: impl FnMut()) -> f64 {
    work();
    let clock = Clock::new();
    let (from_s, mut calls) = (clock.seconds(), 0.0);
    while clock.seconds() - from_s < MEASURED_S {
        work();
        calls += 1.0;
    }
    calls / (clock.seconds() - from_s)
}
