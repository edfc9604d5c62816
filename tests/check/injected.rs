//! Errors put into simulated instruments: which are found under their true name, which are sized, what else is named.
//!
//! Measured over every error in three flights each (339 flights): no wrong name and none missed without a word. By kind: named
//! alone, named among rivals, sized within 3 standard errors; told as a doubt, missed where the run says that it must be:
//! bias 25 + 8, sized 32 of 33; scale 77 + 2, sized 79, doubts 36, missed 29 of 144; lag 38 + 11, sized 49, doubts 9, missed 14
//! of 72; skew 31 + 16, sized 47, doubts 7, missed 18 of 72; accelerometer 1 and 3 m off 9 + 7, sized 16, missed 2 of 18.
//! Among rivals counts also where the first explanation is another and the truth stands beside it.
//! Falls short, in this flight: factor, lag and skew of ax, and lag and skew of tas and its 5 %, are never found, 5 % of ay and
//! of alpha hardly ever; q, theta and alpha move too little beside p, so most of theirs, and 5 % of r and psi, stay doubts.

use super::errors::{every_error, with_own};
use super::flown::{checked, flight, flight_with, own_biases};
use super::score::{Score, score, told, told_by_kind};
use crate::support::asked::{is_study, seeds};
use crate::support::manoeuvre::over_seeds;
use sideslip::flight::channel::Channel::{Alpha, Ay, Beta, P, Phi, Psi, Q, R, Theta};
use sideslip::flight::effect::{Effect, PositionedSensor};
use sideslip::simulation::fly::Flight;

/// One flight with these errors; a channel's own bias adds to the one that is put in.
fn judged(mut flight: Flight, errors: &[Effect], seed: u64) -> Score {
    let own = own_biases(&mut flight, seed);
    let verdict = checked(&flight, errors, seed);
    let truths = with_own(errors, &own);
    score(&verdict, &truths)
}

/// Every thirtieth error (all of them by SIDESLIP_SEEDS, so many flights each).
#[test]
fn errors_are_found_under_their_names() {
    let all = every_error();
    let whole = is_study();
    let errors: Vec<Effect> = if whole { all } else { all.into_iter().step_by(30).collect() };
    let each = seeds(1);
    let scores = over_seeds(each * errors.len() as u64, |number| {
        let error = errors[(number / each) as usize];
        let error = match error {
            Effect::SensorBias { channel, value } if number % 2 == 1 => Effect::SensorBias { channel, value: -value },
            other => other,
        };
        judged(flight(), &[error], 40_000 + number)
    });
    let sum = told_by_kind(&errors, &scores);
    let found = sum.named + sum.among_rivals;
    assert!((sum.wrong + sum.wrong_among_rivals + sum.missed) * 50 <= sum.flights, "{}", sum.line());
    assert!((found - sum.sized) * 25 <= found && found * 100 >= sum.flights * 45, "{}", sum.line());
}

/// What stays a doubt where the aircraft hardly pitches is told once it pitches: 39 of 40 found and sized, one doubt.
#[test]
#[ignore = "a study"]
fn errors_of_pitch_are_told_once_the_aircraft_pitches() {
    let scale = |channel, factor| Effect::SensorScale { channel, factor };
    let errors = [
        scale(Q, 0.8),
        scale(Q, 1.2),
        scale(Theta, 0.8),
        scale(Theta, 1.2),
        scale(Alpha, 0.8),
        scale(Alpha, 1.2),
        Effect::SensorLag { channel: Q, tau: 0.3 },
        Effect::SensorLag { channel: Theta, tau: 0.1 },
        Effect::SensorDelay { channel: Theta, delay: 0.05 },
        Effect::SensorLag { channel: Alpha, tau: 0.1 },
    ];
    let each = seeds(1);
    let one = |number: u64| judged(flight_with(0.03), &[errors[(number / each) as usize]], 60_000 + number);
    let scores = over_seeds(each * errors.len() as u64, one);
    for (error, scores) in errors.iter().zip(scores.chunks(each as usize)) {
        told(&format!("{error:?}"), scores);
    }
    let sum = scores.iter().fold(Score::default(), Score::plus);
    eprintln!("== pitching: {}", sum.line());
    assert!((sum.wrong + sum.wrong_among_rivals + sum.missed) * 20 <= sum.flights, "{}", sum.line());
    assert!((sum.named + sum.among_rivals) * 100 >= sum.flights * 70, "{}", sum.line());
}

/// The judge itself: judged against another error, what was found is wrong and what was asked for is missed.
#[test]
fn a_wrong_name_is_counted_as_wrong() {
    let error = |channel| Effect::SensorScale { channel, factor: 1.2 };
    let verdict = checked(&flight(), &[error(R)], 70_000);
    let (right, wrong) = (score(&verdict, &[error(R)]), score(&verdict, &[error(P)]));
    assert!(right.named == 1 && right.sized == 1 && right.wrong == 0, "{}", right.line());
    assert!(wrong.named == 0 && wrong.missed == 1 && wrong.wrong == 1, "{}", wrong.line());
}

/// Two at once: 44 of 48 found and sized, 4 doubts (theta).
#[test]
#[ignore = "a study"]
fn two_errors_at_once_are_mostly_found() {
    let scale = |channel, factor| Effect::SensorScale { channel, factor };
    let delay = |channel, delay| Effect::SensorDelay { channel, delay };
    let off = |offset_m| Effect::SensorPosition { sensor: PositionedSensor::Accelerometer, offset_m };
    let pairs = [
        [scale(R, 1.1), delay(Phi, 0.1)],
        [scale(Beta, 0.85), Effect::SensorBias { channel: P, value: 0.01 }],
        [delay(Alpha, 0.15), scale(P, 0.9)],
        [off([3.0, 0.0, 0.0]), delay(Psi, 0.2)],
        [Effect::SensorLag { channel: Beta, tau: 0.3 }, scale(Theta, 1.15)],
        [Effect::SensorBias { channel: Ay, value: 0.5 }, delay(P, 0.1)],
    ];
    let each = seeds(1);
    let scores =
        over_seeds(each * pairs.len() as u64, |number| judged(flight(), &pairs[(number / each) as usize], 50_000 + number));
    for (pair, scores) in pairs.iter().zip(scores.chunks(each as usize)) {
        told(&format!("{pair:?}"), scores);
    }
    let sum = scores.iter().fold(Score::default(), Score::plus);
    eprintln!("== two at once: {}", sum.line());
    assert!((sum.wrong + sum.wrong_among_rivals + sum.missed) * 10 <= sum.flights, "{}", sum.line());
    assert!((sum.named + sum.among_rivals) * 100 >= sum.flights * 75, "{}", sum.line());
}
