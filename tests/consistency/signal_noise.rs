//! The noise that the smoothed signals are stated to have, against their errors in simulated flights in still air.

use crate::support::asked::seeds;
use crate::support::invented::{glider, helicopter, light_aircraft};
use crate::support::manoeuvre::{LEAD_S, over_seeds};
use sideslip::flight::control::Control;
use sideslip::flight::model::LinearModel;
use sideslip::flight::run::RunGeometry;
use sideslip::realtime::estimation::config::EstimationConfig;
use sideslip::realtime::estimation::estimator::Estimator;
use sideslip::simulation::fly::{Flight, uniform_times};
use sideslip::simulation::input::InputSpec;
use sideslip::simulation::instrument::InstrumentSet;

const RATE_HZ: f64 = 100.0;
const NAMES: [&str; 5] = ["u", "v", "w", "p", "q"];

/// Of u v w p q of one flight: variance of the error about its mean, which the trim takes out, and the variance stated. A small
/// pedal doublet keeps what smoothing takes off the motion itself below the noise, but of r, which it moves most.
fn error_and_stated(model: &LinearModel, seed: u64) -> [[f64; 2]; NAMES.len()] {
    let mut flight = Flight::of(model.clone());
    flight.times_s = uniform_times(0.0, 25.0, RATE_HZ).unwrap();
    let deviation = InputSpec::parse("pedal:doublet:0.005:1").unwrap().deviation(LEAD_S);
    let history = &mut flight.inputs.controls[Control::Pedal.index()];
    *history = history.plus(1.0, &deviation);
    flight.inputs = flight.inputs.sampled(&flight.times_s);
    flight.instruments = InstrumentSet::flight_quality(1.0);
    flight.seed = seed;
    let flown = flight.fly().unwrap();
    let mut estimator = Estimator::new(EstimationConfig::default(), RunGeometry::default()).unwrap();
    let mut errors: Vec<[f64; NAMES.len()]> = Vec::new();
    for sample in &flown.samples {
        for record in estimator.step(sample).smoothed.iter().filter(|record| (2.0..20.0).contains(&record.time_s)) {
            let at = record.time_s * RATE_HZ;
            let (before, after) = (&flown.truth[at as usize], &flown.truth[at as usize + 1]);
            let between = |a: f64, b: f64| a + at.fract() * (b - a);
            errors.push(std::array::from_fn(|k| match k {
                0..3 => record.velocity[k] - between(before.air_velocity[k], after.air_velocity[k]),
                _ => record.rates[k - 3] - between(before.motion.rates[k - 3], after.motion.rates[k - 3]),
            }));
        }
    }
    let noise = estimator.instrumentation().noise;
    let count = errors.len() as f64;
    std::array::from_fn(|k| {
        let mean = errors.iter().map(|row| row[k]).sum::<f64>() / count;
        let stated = if k < 3 { noise.velocity[k] } else { noise.rates[k - 3] };
        [errors.iter().map(|row| (row[k] - mean) * (row[k] - mean)).sum::<f64>() / count, stated * stated]
    })
}

/// Stated too large, the noise of an incidence vane takes N_v its number: the attenuation that it could bring is part of the
/// standard errors. The filter's error is slow, so what is left of v and u about their mean is 0.6 to 0.75 of the noise stated.
#[test]
fn the_noise_of_smoothed_signals_is_what_is_stated() {
    for (name, model) in [("helicopter", helicopter()), ("light aircraft", light_aircraft()), ("glider", glider())] {
        let all = over_seeds(seeds(8), |seed| error_and_stated(&model, 500 + seed));
        for (k, signal) in NAMES.iter().enumerate() {
            let sum = |which: usize| all.iter().map(|one| one[k][which]).sum::<f64>();
            let ratio = (sum(0) / sum(1)).sqrt();
            eprintln!("{name}, {signal}: error over noise stated {ratio:.2}");
            assert!((0.5..1.2).contains(&ratio), "{name}, {signal}: {ratio:.2}");
        }
    }
}
