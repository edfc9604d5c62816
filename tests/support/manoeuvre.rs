//! The manoeuvre that the statistical tests fly: the published Puma at 100 kn, pedal 3211, then lateral cyclic 3211.

use sideslip::flight::derivative::{Axis, Variable};
use sideslip::flight::model::LinearModel;
use sideslip::simulation::fly::{FlightResult, Inputs, simulate};
use sideslip::simulation::input::InputSpec;
use sideslip::simulation::instrument::InstrumentSet;

/// Steady flight before the first input, s.
pub(crate) const LEAD_S: f64 = 2.0;
/// Length of the record, s.
pub(crate) const DURATION_S: f64 = 22.0;
/// Samples a second.
pub(crate) const RATE_HZ: f64 = 100.0;
/// The pilot's inputs: control, shape, amplitude rad, clock s, start s. Without the second, nothing moves the lateral cyclic
/// and its derivatives cannot be known.
pub(crate) const INPUTS: [&str; 2] = ["pedal:3211:0.02:0.7", "lat_cyclic:3211:0.008:0.5:7"];

/// The derivatives of yaw and roll that the modes are made of: what is asked of every way of telemetry and flying.
pub(crate) const WANTED: [(Axis, Variable); 8] = [
    (Axis::N, Variable::V),
    (Axis::N, Variable::P),
    (Axis::N, Variable::R),
    (Axis::N, Variable::Pedal),
    (Axis::L, Variable::V),
    (Axis::L, Variable::P),
    (Axis::L, Variable::R),
    (Axis::L, Variable::LatCyclic),
];

/// One flight with instruments of that quality.
pub(crate) fn fly(model: &LinearModel, inputs: &[&str], instruments: &InstrumentSet, seed: u64) -> FlightResult {
    fly_at(RATE_HZ, model, inputs, instruments, seed)
}

/// The same with so many samples a second.
pub(crate) fn fly_at(rate_hz: f64, model: &LinearModel, inputs: &[&str], instruments: &InstrumentSet, seed: u64) -> FlightResult {
    let mut controls = Inputs::at_trim(model);
    for input in inputs {
        let spec = InputSpec::parse(input).unwrap();
        let place = sideslip::flight::channel::Channel::CONTROLS.iter().position(|&control| control == spec.channel).unwrap();
        controls.controls[place] = controls.controls[place].plus(1.0, &spec.deviation(LEAD_S));
    }
    simulate(model, &controls, instruments, DURATION_S, rate_hz, seed).unwrap()
}

/// Results of seeds 0 .. count, on every core.
pub(crate) fn over_seeds<T: Send>(count: u64, one: impl Fn(u64) -> T + Sync) -> Vec<T> {
    let cores = std::thread::available_parallelism().map_or(1, |cores| cores.get() as u64);
    let mut results: Vec<(u64, T)> = std::thread::scope(|scope| {
        let workers: Vec<_> = (0..cores)
            .map(|core| {
                let one = &one;
                scope.spawn(move || (core..count).step_by(cores as usize).map(|seed| (seed, one(seed))).collect::<Vec<_>>())
            })
            .collect();
        workers.into_iter().flat_map(|worker| worker.join().unwrap()).collect()
    });
    results.sort_by_key(|(seed, _)| *seed);
    results.into_iter().map(|(_, result)| result).collect()
}
