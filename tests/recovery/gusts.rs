//! Live estimates in air that moves: silent without a test input, right with one.
//!
//! The built-in Puma's linear model at three speeds and the Navion's, in Dryden gusts, alone, with a pilot who holds attitude or
//! heading too, and with attitude and rate feedback of 1.5 rad/s; every second of every flight is looked at. CI flies one seed of
//! each; the study, `cargo nextest run --release --test slow --run-ignored all recovery::gusts`, as many as `SIDESLIP_SEEDS`
//! says, from seeds moved by `SIDESLIP_SEEDS_FROM` on.
//! Gates: of all numbers with a pilot's test input the root mean square of (estimate - truth)/standard error; it is a mean over
//! some hundred correlated numbers, and right standard errors would give 1.

use super::pilot::{KNOT, with_inputs};
use super::reported::{Reported, kept, rms, shares, too_many_converged_and_wrong, watched};
use crate::support::asked::{first_seed, seeds};
use crate::support::manoeuvre::over_seeds;
use crate::support::navion::navion;
use crate::support::wilson::wilson;
use sideslip::flight::channel::Channel;
use sideslip::flight::effect::Effect;
use sideslip::flight::model::LinearModel;
use sideslip::simulation::flight_model::{FlightModel, FlightRequest};
use sideslip::simulation::fly::Flight;
use sideslip::simulation::instrument::InstrumentSet;
use sideslip::simulation::pilot::Pilot;

const SPEEDS_KN: [f64; 3] = [80.0, 100.0, 120.0];
const INPUT: [&[&str]; 2] =
    [&["pedal:3211:0.02:0.7", "lat_cyclic:3211:0.008:0.5:7"], &["pedal:doublet:0.02:0.8", "lat_cyclic:doublet:0.01:0.8:8"]];
/// Standard deviation of the gusts, m/s.
const GUSTS: [f64; 5] = [0.1, 0.3, 0.6, 1.0, 1.5];
/// Rate and attitude feedback without dead time to speak of: an augmentation system.
const AUGMENTATION: Pilot = Pilot { frequency: 1.5, damping: 0.7, lag_s: 0.05, dead_time_s: 0.02, heading: true };
/// Of the flights' seeds in turn: where nothing but the air moves the aircraft, more of it must not add up to an answer.
const DURATIONS_S: [f64; 4] = [60.0, 120.0, 180.0, 300.0];
const VANES: [Channel; 2] = [Channel::Alpha, Channel::Beta];
const HANDS: [Option<Pilot>; 4] = [None, Some(Pilot::ATTITUDE), Some(Pilot::ATTITUDE_AND_HEADING), Some(AUGMENTATION)];

fn model(knots: f64) -> LinearModel {
    let request = FlightRequest { speed: Some(knots * KNOT), ..FlightRequest::default() };
    FlightModel::puma(&request).unwrap().linear().clone()
}

fn reported(model: &LinearModel, gust: f64, hands: Option<Pilot>, inputs: &[&str], duration_s: f64, seed: u64) -> Reported {
    let mut flight = with_inputs(Flight::of(model.clone()), inputs, duration_s);
    flight.pilot = hands;
    flight.instruments = InstrumentSet::flight_quality(1.0);
    flight.seed = seed;
    if gust > 0.0 {
        flight.effects.push(Effect::Turbulence { sigma: gust, length: 150.0 });
    }
    watched(&flight, model)
}

/// Flights of every aircraft and speed, every pair of hands and `seeds` seeds each, of which every one has its duration.
fn flown(gust: f64, inputs: &[&[&str]], durations_s: &[f64], seeds: u64) -> Vec<Reported> {
    let models: Vec<LinearModel> = SPEEDS_KN.into_iter().map(model).chain([navion()]).collect();
    let inputs = if inputs.is_empty() { &[&[][..]][..] } else { inputs };
    let kinds = (models.len() * HANDS.len() * inputs.len()) as u64;
    over_seeds(seeds * kinds, |n| {
        let kind = (n % kinds) as usize;
        let (model, rest) = (&models[kind % models.len()], kind / models.len());
        let duration_s = durations_s[(n / kinds) as usize % durations_s.len()];
        reported(model, gust, HANDS[rest % HANDS.len()], inputs[rest / HANDS.len()], duration_s, first_seed(20_000) + n)
    })
}

#[test]
fn gusts_alone_and_hands_that_answer_them_tell_nothing() {
    for gust in GUSTS {
        let all = flown(gust, &[], &DURATIONS_S, seeds(1));
        let numbers: usize = all.iter().map(|one| one.numbers).sum();
        let wrong: usize = all.iter().map(|one| one.converged_and_wrong + one.unstable + one.blamed).sum();
        let score = rms(&all, |_| true);
        eprintln!("gusts of {gust} m/s, {} flights: {numbers} numbers, rms {score:.2}, {wrong} wrong", all.len());
        assert!(wrong == 0 && score <= 1.3, "{gust} m/s: {wrong} wrong, rms {score}");
    }
}

/// The pedal's 3211 in gusts of 1 m/s, before the lateral cyclic moves: the frequency domain contradicts L, Y has no derivative
/// yet. An `exciting` Y has hidden the contradiction, and a roll root of +14.5 1/s was reported at 8 s.
#[test]
fn an_equation_that_is_exciting_hides_no_disagreement() {
    let found = reported(&model(120.0), 1.0, Some(Pilot::ATTITUDE_AND_HEADING), INPUT[0], 9.5, 1_020_058);
    assert!(found.unstable == 0 && found.numbers > 0);
}

#[test]
fn with_a_test_input_what_is_reported_is_right_and_silence_is_no_way_out() {
    let mut failed = Vec::new();
    for (gust, most_rms, least_share) in [(0.0, 1.1, 0.98), (0.3, 1.2, 0.9), (1.0, 1.3, 0.7)] {
        let all = flown(gust, &INPUT, &[22.0], seeds(1));
        let score = rms(&all, |_| true);
        let wrong: usize = all.iter().map(|one| one.converged_and_wrong).sum();
        let blamed: usize = all.iter().map(|one| one.blamed).sum();
        let unstable: usize = all.iter().map(|one| one.unstable).sum();
        let shares = shares(&all);
        eprintln!(
            "gusts of {gust} m/s with inputs, {} flights: rms {score:.2}, converged and beyond 4: {wrong}, unstable {unstable}, \
             numbers in the end for N_v {:.2} N_r {:.2} L_p {:.2} Dutch roll {:.2}",
            all.len(),
            shares[0],
            shares[1],
            shares[2],
            shares[3]
        );
        let is_wrong = gust > 0.0 && too_many_converged_and_wrong(&all);
        if score > most_rms || blamed > 0 || is_wrong || shares.iter().any(|share| *share < least_share) {
            failed.push(gust);
        }
    }
    assert!(failed.is_empty(), "gusts of {failed:?} m/s");
}

/// Feedback correlates the controls with the gusts: least squares is biased, and the errors have to cover it. Of 100 flights of
/// the Navion alone the root mean square is 1.11, 1.25 and 1.23, of 100 of the Puma 0.6; of two flights it may be 2.
#[test]
fn of_a_closed_loop_in_gusts_the_errors_cover_the_bias() {
    let models: Vec<LinearModel> = SPEEDS_KN.into_iter().map(model).chain([navion()]).collect();
    let kinds = (models.len() * INPUT.len()) as u64;
    let mut failed = Vec::new();
    for gust in [0.5, 1.0, 1.5] {
        let all = over_seeds(seeds(1) * kinds, |n| {
            let kind = (n % kinds) as usize;
            let (model, input) = (&models[kind % models.len()], INPUT[kind / models.len()]);
            reported(model, gust, Some(AUGMENTATION), input, 60.0, first_seed(80_000) + n)
        });
        let unstable: usize = all.iter().map(|one| one.unstable).sum();
        let wrong = too_many_converged_and_wrong(&all) || unstable > 0;
        let score = rms(&all, |_| true);
        // Places in the order of `models`.
        let (_, wing): (Vec<_>, Vec<_>) = all.into_iter().enumerate().partition(|(n, _)| n % models.len() < SPEEDS_KN.len());
        let wing: Vec<Reported> = wing.into_iter().map(|(_, one)| one).collect();
        eprintln!(
            "augmented, gusts of {gust} m/s: rms {score:.2}, of the {} of the Navion {:.2}",
            wing.len(),
            rms(&wing, |_| true)
        );
        if score > 1.3 || wrong {
            failed.push(gust);
        }
    }
    assert!(failed.is_empty(), "gusts of {failed:?} m/s");
}

/// A test input at 2 s, then a minute of gusts: what they alone would tell does not replace what the input has told.
#[test]
fn an_answer_is_kept_in_the_gusts_that_follow() {
    let mut failed = Vec::new();
    for gust in GUSTS {
        let all = flown(gust, &INPUT[..1], &DURATIONS_S, seeds(1));
        let unstable: usize = all.iter().map(|one| one.unstable).sum();
        let wrong = too_many_converged_and_wrong(&all) || unstable > 0;
        let (score, shares, kept) = (rms(&all, |_| true), shares(&all), kept(&all));
        let of_those = kept.map(|(kept, answered)| kept as f64 / answered.max(1) as f64);
        eprintln!(
            "gusts of {gust} m/s, {} flights: rms {score:.2}, numbers in the end {shares:.2?}, of those after the input \
             {of_those:.2?}",
            all.len()
        );
        // How many flights tell anything is of the inputs' test; here it has to be something. N_v and the Dutch roll need ay,
        // whose sign and unit strong gusts leave in doubt while the response to the input decays: of 290 flights at 1.5 m/s
        // 0.85 and 0.86 keep them, and 0.93 keep N_r and L_p. 95 % intervals: 0.025 false alarms.
        let few = kept.into_iter().zip([0.8, 0.9, 0.9, 0.8]).any(|((kept, answered), least)| wilson(kept, answered)[1] < least);
        if wrong || score > 1.3 || few || shares.iter().any(|share| *share < 0.5) {
            failed.push(gust);
        }
    }
    assert!(failed.is_empty(), "gusts of {failed:?} m/s");
}

/// Vanes that are late by 50 ms or read a tenth too much: part of what they read is not the air, and is not taken for it.
#[test]
fn vanes_that_lag_or_read_too_much_are_not_taken_for_gusts() {
    let models: Vec<LinearModel> = SPEEDS_KN.into_iter().map(model).chain([navion()]).collect();
    let kinds = models.len() as u64;
    let mut failed = Vec::new();
    for (name, lag_s, factor) in [("lag", 0.05, 1.0), ("factor", 0.0, 1.1)] {
        for gust in [0.3, 1.0] {
            let all = over_seeds(seeds(3) * kinds, |n| {
                let model = &models[(n % kinds) as usize];
                let mut flight = with_inputs(Flight::of(model.clone()), INPUT[(n / kinds % 2) as usize], 22.0);
                flight.instruments = InstrumentSet::flight_quality(1.0);
                for vane in flight.instruments.channels.iter_mut().filter(|one| VANES.contains(&one.channel)) {
                    (vane.lag_s, vane.factor) = (lag_s, factor);
                }
                flight.seed = first_seed(70_000) + n;
                flight.effects.push(Effect::Turbulence { sigma: gust, length: 150.0 });
                watched(&flight, model)
            });
            let score = rms(&all, |_| true);
            eprintln!("vanes with a {name}, gusts of {gust} m/s, {} flights: rms {score:.2}", all.len());
            if score > 1.3 {
                failed.push((name, gust));
            }
        }
    }
    assert!(failed.is_empty(), "{failed:?}");
}
