//! A speed that drifts for long before the test input: longitudinal motion carries no information on lateral derivatives.
//!
//! Of 20 s of drift the lateral equations had numbers half a second after the rudder began to move, up to 17 standard errors off.

use super::pilot::with_inputs;
use super::reported::{rms, watched};
use crate::support::asked::{first_seed, seeds};
use crate::support::manoeuvre::over_seeds;
use crate::support::transport::transport;
use sideslip::simulation::fly::Flight;
use sideslip::simulation::instrument::InstrumentSet;

#[test]
fn a_drift_before_the_input_leaves_no_wrong_number_after_it() {
    let model = transport();
    let all = over_seeds(seeds(3), |seed| {
        let inputs = ["collective:step:0.6:1:2", "pedal:3211:0.05:0.7:25", "lat_cyclic:3211:0.03:0.7:40"];
        let mut flight = with_inputs(Flight::of(model.clone()), &inputs, 50.0);
        flight.instruments = InstrumentSet::flight_quality(1.0);
        flight.seed = first_seed(110_000) + seed;
        watched(&flight, &model)
    });
    let score = rms(&all, |_| true);
    let worst = all.iter().flat_map(|one| &one.scores).map(|(_, score)| score.abs()).fold(0.0, f64::max);
    let in_the_end = all.iter().all(|one| one.dutch_roll && one.last.iter().all(|has| *has));
    eprintln!("rms {score:.2}, worst {worst:.1}");
    assert!(in_the_end && score <= 1.3 && worst < 5.0);
}
