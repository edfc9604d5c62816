//! Errors put into the instruments of a whole sortie, four runs checked together: which are found, sized, or named wrongly.
//!
//! One command for all of them, so many sorties an error, and as many times 100 healthy ones:
//! `SIDESLIP_SEEDS=1 cargo nextest run --release --test slow --run-ignored all --no-capture -E 'test(check::sortie)'`
//!
//! Measured with every error in one sortie (a bias in each of its four runs), seeds 80000 onwards, nothing named wrongly:
//!
//! | kind  | judged | named | among rivals | sized within 3 s.e. | missed, and said so | missed |
//! |-------|--------|-------|--------------|---------------------|---------------------|--------|
//! | bias  |     44 |    44 |            0 |                  44 |                   0 |      0 |
//! | scale |     48 |    41 |            0 |                  41 |                   6 |      1 |
//! | lag   |     24 |    17 |            3 |                  20 |                   4 |      0 |
//! | skew  |     24 |    10 |            9 |                  19 |                   5 |      0 |
//! | place |      6 |     4 |            1 |                   5 |                   1 |      0 |
//!
//! The errors are 0.77 of their standard errors rms. Falls short: ax hardly moves (0.1 m/s^2 rms), so none of its factors, lags
//! and skews is found, nor 5 % of ay, its lag of 0.1 s and skew of 0.05 s, nor airspeed's lag of 0.1 s and skews, nor
//! accelerometers 1 m ahead, each said; alpha's factor of 1.05 is missed without a word.
//!
//! In 100 healthy sorties (seeds 100000 onwards) nothing is named; 500 were not measured. Of 12 sorties with gyros or
//! accelerometers turned by 1 or -2 deg none is given a wrong name (one each).

use super::errors::{every_error, with_own};
use super::flown::{SORTIE, candidate, own_biases, sortie};
use super::score::{Score, score, told_by_kind};
use crate::support::asked::{is_study, seeds};
use crate::support::manoeuvre::over_seeds;
use sideslip::flight::channel::Channel;
use sideslip::flight::effect::Effect;
use sideslip::postflight::reconstruction::verdict::{RunVerdict, check};
use sideslip::postflight::recorded_run::RecordedRun;
use sideslip::simulation::fly::Flight;

/// A sortie with these errors in every run; each run's own biases.
fn checked(runs: &[Flight], errors: &[Effect], seed: u64) -> Vec<(RunVerdict, Vec<(Channel, f64)>)> {
    let (candidates, owns) = flown(runs, errors, seed);
    check(&candidates).into_iter().zip(owns).collect()
}

fn flown(runs: &[Flight], errors: &[Effect], seed: u64) -> (Vec<RecordedRun>, Vec<Vec<(Channel, f64)>>) {
    let mut owns = Vec::new();
    let mut candidates = Vec::new();
    for (place, (run, input)) in runs.iter().zip(SORTIE).enumerate() {
        let (mut run, seed) = (run.clone(), 10 * seed + place as u64);
        owns.push(own_biases(&mut run, seed));
        candidates.push(candidate(input, &run, errors, seed));
    }
    (candidates, owns)
}

/// A bias is judged in every run, for it is the run's own; everything else once.
fn judged(runs: &[Flight], errors: &[Effect], seed: u64) -> Score {
    let mut verdicts = checked(runs, errors, seed);
    let own = |one: &Effect| matches!(one, Effect::SensorBias { .. });
    if errors.iter().any(own) {
        let each = verdicts.iter().map(|(verdict, biases)| score(verdict, &with_own(errors, biases)));
        return each.fold(Score::default(), |sum, one| sum.plus(&one));
    }
    let biases: Vec<_> = verdicts.iter().skip(1).flat_map(|(verdict, _)| verdict.corrections.clone()).collect();
    let mut together = verdicts.swap_remove(0).0;
    together.corrections.extend(biases.into_iter().filter(|one| own(&one.effect.effect)));
    score(&together, errors)
}

/// Every twenty-eighth error (all of them by SIDESLIP_SEEDS, so many sorties each).
#[test]
#[ignore = "a study"]
fn errors_of_a_sortie_are_found_under_their_names() {
    let all = every_error();
    let whole = is_study();
    let errors: Vec<Effect> = if whole { all } else { all.into_iter().step_by(28).collect() };
    let each = seeds(1);
    let runs = sortie();
    let scores = over_seeds(each * errors.len() as u64, |number| {
        let error = errors[(number / each) as usize];
        judged(&runs, &[error], 80_000 + number)
    });
    let sum = told_by_kind(&errors, &scores);
    let found = sum.named + sum.among_rivals;
    assert!((sum.wrong + sum.wrong_among_rivals + sum.missed) * 50 <= sum.flights, "{}", sum.line());
    assert!((found - sum.sized) * 50 <= found && found * 100 >= sum.flights * 80, "{}", sum.line());
}

/// Rates or forces of every sample, turned about an axis by an angle, rad.
fn turned(candidates: &mut [RecordedRun], triad: [Channel; 3], axis: usize, angle: f64) {
    let (i, j) = ((axis + 1) % 3, (axis + 2) % 3);
    for sample in candidates.iter_mut().flat_map(|one| &mut one.samples) {
        let Some([a, b]) = sample.get(triad[i]).zip(sample.get(triad[j])).map(|(a, b)| [a, b]) else { continue };
        sample.set(triad[i], a * angle.cos() + b * angle.sin());
        sample.set(triad[j], b * angle.cos() - a * angle.sin());
    }
}

/// Gyros or accelerometers turned by 1 and 2 deg: the check has no name for it, so the only thing that it may say is a bias of
/// ax or ay, and that accelerometers which are turned read the same.
#[test]
#[ignore = "a study"]
fn turned_axes_are_not_called_something_else() {
    let runs = sortie();
    let triads = [[Channel::P, Channel::Q, Channel::R], [Channel::Ax, Channel::Ay, Channel::Az]];
    let whole = is_study();
    let cases: Vec<(usize, usize, f64)> = (0..2)
        .flat_map(|triad| (0..3).flat_map(move |axis| [1.0, -2.0].map(|deg: f64| (triad, axis, deg.to_radians()))))
        .filter(|(triad, axis, angle)| whole || *angle < 0.0 && (triad + axis) % 2 == 0)
        .collect();
    let each = seeds(1);
    let said = over_seeds(each * cases.len() as u64, |number| {
        let (triad, axis, angle) = cases[(number / each) as usize];
        let (mut candidates, _) = flown(&runs, &[], 120_000 + number);
        turned(&mut candidates, triads[triad], axis, angle);
        let verdicts = check(&candidates);
        let all = verdicts.iter().flat_map(|verdict| &verdict.corrections);
        let wrong = all.clone().filter(|one| one.turned.is_none()).count();
        for one in all {
            eprintln!("{triad} {axis} {angle:.3}: {:?} turned {:?} or {:?}", one.effect, one.turned, one.alternatives);
        }
        wrong
    });
    eprintln!("{} wrong names in {} sorties", said.iter().sum::<usize>(), said.len());
    assert!(said.iter().all(|wrong| *wrong == 0));
}

/// Two sorties (100 times SIDESLIP_SEEDS) with healthy instruments.
#[test]
fn healthy_instruments_of_a_sortie_are_left_alone() {
    let runs = sortie();
    let count = if is_study() { 100 * seeds(1) } else { 2 };
    let found = over_seeds(count, |number| {
        let verdicts = checked(&runs, &[], 100_000 + number);
        verdicts.into_iter().flat_map(|(verdict, _)| verdict.corrections).map(|one| format!("{:?}", one.effect)).collect()
    });
    let found: Vec<&String> = found.iter().flat_map(|one: &Vec<String>| one).collect();
    eprintln!("{} false findings in {count} sorties: {found:?}", found.len());
    assert!(found.len() as u64 * 100 <= 3 * count, "{found:?}");
}
