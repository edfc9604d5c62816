//! What is checked: the built-in Puma at 100 kn, in one flight with several inputs, and in a sortie of one input a run.

use crate::support::uniform::Uniform;
use sideslip::flight::channel::Channel;
use sideslip::flight::control::Control;
use sideslip::flight::effect::Effect;
use sideslip::flight::run::RunGeometry;
use sideslip::postflight::reconstruction::verdict::{RunVerdict, check};
use sideslip::postflight::recorded_run::RecordedRun;
use sideslip::simulation::flight_model::{FlightModel, FlightRequest};
use sideslip::simulation::fly::{Flight, uniform_times};
use sideslip::simulation::input::InputSpec;
use sideslip::simulation::instrument::InstrumentSet;
use sideslip::simulation::pilot::Pilot;

const KNOT: f64 = 1852.0 / 3600.0;

/// Longitudinal cyclic of the usual flight, rad: q then moves less than 0.4 times as much as p.
const PITCH_INPUT: f64 = 0.01;

/// 30 s at 50 Hz with instruments of flight-test quality at the centre of mass.
pub(crate) fn flight() -> Flight {
    flight_with(PITCH_INPUT)
}

/// The same with that much longitudinal cyclic, rad.
pub(crate) fn flight_with(pitch_input: f64) -> Flight {
    let pitch = format!("lon_cyclic:3211:{pitch_input}:0.7:14");
    flown_with(&["pedal:3211:0.02:0.7", "lat_cyclic:3211:0.008:0.5:7", &pitch])
}

/// The inputs of a sortie, one a run.
pub(crate) const SORTIE: [&str; 4] =
    ["pedal:3211:0.02:0.7", "lat_cyclic:3211:0.008:0.5", "lon_cyclic:3211:0.03:0.7", "collective:doublet:0.02:1.0"];

/// The runs of a sortie, as it is flown for identification: each 30 s at 50 Hz, one input.
pub(crate) fn sortie() -> Vec<Flight> {
    SORTIE.iter().map(|input| flown_with(&[input])).collect()
}

fn flown_with(inputs: &[&str]) -> Flight {
    let asked =
        FlightRequest { speed: Some(100.0 * KNOT), set: vec!["perturbation=small".to_owned()], ..FlightRequest::default() };
    let mut flight = FlightModel::puma(&asked).unwrap().flight();
    flight.times_s = uniform_times(0.0, 30.0, 50.0).unwrap();
    for input in inputs {
        let spec = InputSpec::parse(input).unwrap();
        for control in Control::ALL.into_iter().filter(|control| control.channel() == spec.channel) {
            let history = &mut flight.inputs.controls[control.index()];
            *history = history.plus(1.0, &spec.deviation(crate::support::manoeuvre::LEAD_S));
        }
    }
    flight.pilot = Some(Pilot::ATTITUDE);
    flight.inputs = flight.inputs.sampled(&flight.times_s);
    flight.instruments = InstrumentSet::flight_quality(1.0);
    flight
}

/// Draws the run's own biases here, so that they are known: channel and bias.
pub(crate) fn own_biases(flight: &mut Flight, seed: u64) -> Vec<(Channel, f64)> {
    let mut uniform = Uniform(9000 + seed);
    flight
        .instruments
        .channels
        .iter_mut()
        .map(|one| {
            // The sum of twelve is as good as normal here.
            let drawn = one.bias_std * (0..12).map(|_| uniform.within(0.5)).sum::<f64>();
            (one.bias, one.bias_std) = (one.bias + drawn, 0.0);
            (one.channel, drawn)
        })
        .collect()
}

/// What is said of one flight with these effects.
pub(crate) fn checked(flight: &Flight, effects: &[Effect], seed: u64) -> RunVerdict {
    check(&[candidate("flight", flight, effects, seed)]).remove(0)
}

/// A flight with these effects, as it is handed to the check.
pub(crate) fn candidate(name: &str, flight: &Flight, effects: &[Effect], seed: u64) -> RecordedRun {
    let flown = Flight { effects: effects.to_vec(), seed, ..flight.clone() }.fly().unwrap();
    let geometry = RunGeometry {
        accelerometer_position_m: flight.instruments.accelerometer_position_m,
        vane_position_m: flight.instruments.vane_position_m,
        ..RunGeometry::default()
    };
    RecordedRun { name: name.to_owned(), samples: flown.samples, geometry, screened: false }
}
