//! Errors put into simulated instruments: which are found under their true name, which are sized, what else is named.

use crate::flown::{checked, flight, own_biases};
use crate::manoeuvre::{over_seeds, seeds};
use crate::score::{Score, kind, score};
use sideslip::flight::channel::Channel::{self, Alpha, Ax, Ay, Az, Beta, P, Phi, Psi, Q, R, Tas, Theta};
use sideslip::flight::effect::{Effect, PositionedSensor};
use std::collections::BTreeMap;

const ALL: [Channel; 12] = [Ax, Ay, Az, P, Q, R, Tas, Alpha, Beta, Phi, Theta, Psi];
const BIASES: [(Channel, f64); 11] = [
    (Ax, 0.4),
    (Ay, 0.4),
    (Az, -0.4),
    (P, 0.01),
    (Q, 0.01),
    (R, -0.01),
    (Tas, 5.0),
    (Alpha, 0.035),
    (Beta, 0.035),
    (Phi, 0.035),
    (Theta, -0.035),
];

/// Every error once: biases of both signs in turn, factors of 5 and 20 % either way, lags, skews, accelerometers 1 and 3 m off.
fn every_error() -> Vec<Effect> {
    let mut all: Vec<Effect> = BIASES.map(|(channel, value)| Effect::SensorBias { channel, value }).to_vec();
    for channel in ALL {
        all.extend([0.8, 0.95, 1.05, 1.2].map(|factor| Effect::SensorScale { channel, factor }));
        all.extend([0.1, 0.3].map(|tau| Effect::SensorLag { channel, tau }));
        all.extend([0.05, 0.2].map(|delay| Effect::SensorDelay { channel, delay }));
    }
    for axis in 0..3 {
        all.extend([1.0, -3.0].map(|offset| {
            let offset_m = std::array::from_fn(|i| if i == axis { offset } else { 0.0 });
            Effect::SensorPosition { sensor: PositionedSensor::Accelerometer, offset_m }
        }));
    }
    all
}

/// One flight with these errors; a channel's own bias adds to the one that is put in.
fn judged(errors: &[Effect], seed: u64) -> Score {
    let mut flight = flight();
    let own = own_biases(&mut flight, seed);
    let verdict = checked(&flight, errors, seed);
    let truths: Vec<Effect> = errors
        .iter()
        .map(|error| match *error {
            Effect::SensorBias { channel, value } => {
                let own = own.iter().find(|(drawn, _)| *drawn == channel).map_or(0.0, |(_, bias)| *bias);
                Effect::SensorBias { channel, value: value + own }
            }
            other => other,
        })
        .collect();
    score(&verdict, &truths)
}

fn told(what: &str, scores: &[Score]) -> Score {
    let all = scores.iter().fold(Score::default(), Score::plus);
    eprintln!("{what}: {}", all.line());
    for said in &all.said {
        eprintln!("    {said}");
    }
    all
}

/// Every tenth error (all of them by SIDESLIP_SEEDS, so many flights each).
#[test]
fn errors_are_found_under_their_names() {
    let all = every_error();
    let whole = std::env::var_os("SIDESLIP_SEEDS").is_some();
    let errors: Vec<Effect> = if whole { all } else { all.into_iter().step_by(10).collect() };
    let each = seeds(1);
    let scores = over_seeds(each * errors.len() as u64, |number| {
        let error = errors[(number / each) as usize];
        let error = match error {
            Effect::SensorBias { channel, value } if number % 2 == 1 => Effect::SensorBias { channel, value: -value },
            other => other,
        };
        judged(&[error], 40_000 + number)
    });
    let mut kinds: BTreeMap<&str, Score> = BTreeMap::new();
    for (error, scores) in errors.iter().zip(scores.chunks(each as usize)) {
        let one = told(&format!("{error:?}"), scores);
        let sum = kinds.entry(kind(error)).or_default();
        *sum = std::mem::take(sum).plus(&one);
    }
    for (kind, sum) in &kinds {
        eprintln!("== {kind}: {}", sum.line());
    }
    let sum = kinds.values().fold(Score::default(), Score::plus);
    eprintln!("== all: {}", sum.line());
    let found = sum.named + sum.among_rivals;
    assert!(found * 100 >= sum.flights * 50, "{}", sum.line());
}

/// Two at once.
#[test]
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
    let scores = over_seeds(each * pairs.len() as u64, |number| judged(&pairs[(number / each) as usize], 50_000 + number));
    for (pair, scores) in pairs.iter().zip(scores.chunks(each as usize)) {
        told(&format!("{pair:?}"), scores);
    }
    let sum = scores.iter().fold(Score::default(), Score::plus);
    eprintln!("== two at once: {}", sum.line());
    assert!((sum.named + sum.among_rivals) * 100 >= sum.flights * 50, "{}", sum.line());
}
