//! Aircraft whose roll mode is fast, and one modest input: p follows from v, r and the controls and differs from what they say
//! by little more than its noise.
//!
//! The noise attenuates L_p, and its share is in L_v, L_r, L_rudder: of a glider after a rudder pulse they were up to 42 standard
//! errors off, N_r `converged` among them.

use super::pilot::with_inputs;
use super::reported::{Reported, watched};
use crate::support::asked::{first_seed, seeds};
use crate::support::invented::{glider, high_aspect_ratio, unmanned};
use crate::support::manoeuvre::over_seeds;
use sideslip::flight::effect::Effect;
use sideslip::simulation::fly::Flight;
use sideslip::simulation::instrument::InstrumentSet;
use sideslip::simulation::pilot::Pilot;

/// One modest input, or two of them.
const MODEST: [&[&str]; 6] = [
    &["pedal:1:0.02:0.5"],
    &["pedal:doublet:0.02:0.5"],
    &["lat_cyclic:doublet:0.02:0.5"],
    &["pedal:3211:0.02:0.5"],
    &["lon_cyclic:doublet:0.03:0.5", "pedal:doublet:0.02:0.4:8"],
    &["lat_cyclic:1:0.01:0.3", "pedal:doublet:0.02:0.4:8"],
];

fn flown(name: &str, gust: f64, hands: Option<Pilot>, seeds: u64) -> Vec<Reported> {
    let models = [glider(), high_aspect_ratio(), unmanned()];
    let names = ["glider", "high aspect ratio", "unmanned"];
    let kinds = (models.len() * MODEST.len()) as u64;
    let all = over_seeds(seeds * kinds, |n| {
        let kind = (n % kinds) as usize;
        let (model, inputs) = (&models[kind % models.len()], MODEST[kind / models.len()]);
        let mut flight = with_inputs(Flight::of(model.clone()), inputs, 30.0);
        flight.pilot = hands;
        if gust > 0.0 {
            flight.effects.push(Effect::Turbulence { sigma: gust, length: 150.0 });
        }
        flight.instruments = InstrumentSet::flight_quality(1.0);
        flight.seed = first_seed(140_000) + n;
        watched(&flight, model)
    });
    for (kind, aircraft) in names.into_iter().enumerate() {
        for (place, inputs) in MODEST.iter().enumerate() {
            let of: Vec<&Reported> = all.iter().skip(kind + models.len() * place).step_by(kinds as usize).collect();
            let wrong = of.iter().filter(|one| one.beyond_four > 0).count();
            if wrong > 0 {
                let worst = of.iter().map(|one| one.beyond_four).max();
                eprintln!("{name}: {aircraft}, {inputs:?}: {wrong} of {} flights, {worst:?} numbers", of.len());
            }
        }
    }
    all
}

#[test]
fn what_only_the_noise_of_the_roll_rate_tells_apart_has_no_wrong_number() {
    let mut failed = Vec::new();
    for (name, gust, hands) in
        [("still", 0.0, None), ("held", 0.0, Some(Pilot::ATTITUDE)), ("light gusts, held", 0.1, Some(Pilot::ATTITUDE))]
    {
        let all = flown(name, gust, hands, seeds(2));
        let numbers: usize = all.iter().map(|one| one.numbers).sum();
        let wrong: usize = all.iter().map(|one| one.beyond_four).sum();
        let converged: usize = all.iter().map(|one| one.converged_and_wrong).sum();
        let flights = all.iter().filter(|one| one.beyond_four > 0).count();
        let answered = super::reported::shares(&all);
        eprintln!(
            "{name}: {wrong} of {numbers} numbers beyond 4 standard errors, {converged} converged, in {flights} of {} flights; \
             N_v N_r L_p Dutch roll told in {answered:.2?}",
            all.len()
        );
        if converged > 0 || flights * 20 > all.len() {
            failed.push(name);
        }
    }
    assert!(failed.is_empty(), "{failed:?}");
}
