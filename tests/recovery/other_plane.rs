//! One input, still air: what the motion of a plane that no input of its own moved tells of its derivatives.
//!
//! The terms of such a plane follow a few motions of the other and explain them alike. Selected among themselves they had, with
//! numbers under `converging` and `converged`: of a light aircraft that circled after an aileron pulse Z_u 19 standard errors
//! off, of a helicopter after a pedal doublet M_q 14 and M_v 13; in 3 of 6 flights each. Of a light helicopter, whose roll rate
//! is nearly a combination of its other motions, in 8 of 8 flights after a collective doublet: L_v 12, L_r 10 and L_p 10;
//! now none of 26,379 readings of 63 flights is beyond four.

use super::pilot::with_inputs;
use super::reported::{shares, watched};
use crate::support::asked::{first_seed, seeds};
use crate::support::invented::{helicopter, light_aircraft, light_helicopter};
use crate::support::manoeuvre::over_seeds;
use sideslip::flight::model::LinearModel;
use sideslip::simulation::fly::Flight;
use sideslip::simulation::instrument::InstrumentSet;

/// A name, an aircraft, inputs, the time flown in s, and whether N_v, N_r, L_p and the Dutch roll have to have numbers.
type Case = (&'static str, LinearModel, &'static [&'static str], f64, bool);

#[test]
fn a_plane_without_an_input_of_its_own_gives_no_wrong_number() {
    let cases: [Case; 8] = [
        ("circling", light_aircraft(), &["pedal:3211:0.037:0.8:2", "lat_cyclic:21:0.03:0.5:18"], 60.0, true),
        ("pedal doublet", helicopter(), &["pedal:doublet:0.02:1:2"], 40.0, true),
        ("lateral cyclic doublet", helicopter(), &["lat_cyclic:doublet:0.012:0.7:2"], 40.0, true),
        ("elevator doublet", light_aircraft(), &["lon_cyclic:doublet:0.03:0.5:2"], 40.0, false),
        ("light, pedal 3211", light_helicopter(), &["pedal:3211:0.03:0.6:2"], 40.0, false),
        ("light, pedal doublet", light_helicopter(), &["pedal:doublet:0.03:1.5:2"], 40.0, false),
        ("light, collective doublet", light_helicopter(), &["collective:doublet:0.02:1.5:2"], 40.0, false),
        ("light, longitudinal doublet", light_helicopter(), &["lon_cyclic:doublet:0.02:1:2"], 40.0, false),
    ];
    let mut silent = Vec::new();
    for (name, model, inputs, duration_s, lateral) in cases {
        let all = over_seeds(seeds(3), |seed| {
            let mut flight = with_inputs(Flight::of(model.clone()), inputs, duration_s);
            flight.instruments = InstrumentSet::flight_quality(1.0);
            flight.seed = first_seed(120_000) + seed;
            watched(&flight, &model)
        });
        let numbers: usize = all.iter().map(|one| one.numbers).sum();
        let wrong: usize = all.iter().map(|one| one.beyond_four).sum();
        eprintln!("{name}: {wrong} of {numbers} numbers beyond 4 standard errors");
        assert!(numbers > 0 && wrong == 0, "{name}");
        let told = shares(&all);
        if lateral {
            eprintln!("{name}: N_v, N_r, L_p, Dutch roll in {told:.2?} of the flights");
            if told.iter().any(|share| *share < 0.9) {
                silent.push(name);
            }
        }
    }
    assert!(silent.is_empty(), "no lateral answer: {silent:?}");
}
