//! Errors put into the instruments of a whole sortie, four runs checked together: which are found, sized, or named wrongly.
//!
//! One command for all of them, so many sorties an error, and as many times 500 healthy ones:
//! `SIDESLIP_SEEDS=1 cargo nextest run --release --test check --no-capture -E 'test(sortie)'`

use crate::errors::{every_error, with_own};
use crate::flown::{SORTIE, candidate, own_biases, sortie};
use crate::manoeuvre::{over_seeds, seeds};
use crate::score::{Score, kind, score};
use sideslip::estimation::compatibility::verdict::{Verdict, check};
use sideslip::flight::channel::Channel;
use sideslip::flight::effect::Effect;
use sideslip::simulation::fly::Flight;
use std::collections::BTreeMap;

/// A sortie with these errors in every run; each run's own biases.
fn checked(runs: &[Flight], errors: &[Effect], seed: u64) -> Vec<(Verdict, Vec<(Channel, f64)>)> {
    let mut owns = Vec::new();
    let mut candidates = Vec::new();
    for (place, (run, input)) in runs.iter().zip(SORTIE).enumerate() {
        let (mut run, seed) = (run.clone(), 10 * seed + place as u64);
        owns.push(own_biases(&mut run, seed));
        candidates.push(candidate(input, &run, errors, seed));
    }
    check(&candidates).into_iter().zip(owns).collect()
}

/// A bias is judged in every run, for it is the run's own; everything else once.
fn judged(runs: &[Flight], errors: &[Effect], seed: u64) -> Score {
    let mut verdicts = checked(runs, errors, seed);
    if std::env::var_os("DBG").is_some() {
        eprintln!("{:#?}", verdicts[2].0.not_observable);
    }
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

/// Every fourteenth error (all of them by SIDESLIP_SEEDS, so many sorties each).
#[test]
fn errors_of_a_sortie_are_found_under_their_names() {
    let all = every_error();
    let whole = std::env::var_os("SIDESLIP_SEEDS").is_some();
    let only = std::env::var("ONLY").ok();
    let errors: Vec<Effect> = if whole { all } else { all.into_iter().step_by(14).collect() };
    let errors: Vec<Effect> =
        errors.into_iter().filter(|e| only.as_ref().is_none_or(|only| format!("{e:?}").contains(only))).collect();
    let each = seeds(1);
    let runs = sortie();
    let scores = over_seeds(each * errors.len() as u64, |number| {
        let error = errors[(number / each) as usize];
        let clock = std::time::Instant::now();
        let one = judged(&runs, &[error], 80_000 + number);
        eprintln!("{error:?} ({:.1} s): {}", clock.elapsed().as_secs_f64(), one.line());
        one
    });
    let mut kinds: BTreeMap<&str, Score> = BTreeMap::new();
    for (error, scores) in errors.iter().zip(scores.chunks(each as usize)) {
        let one = scores.iter().fold(Score::default(), Score::plus);
        eprintln!("{error:?}: {}", one.line());
        for said in &one.said {
            eprintln!("    {said}");
        }
        let sum = kinds.entry(kind(error)).or_default();
        *sum = std::mem::take(sum).plus(&one);
    }
    for (kind, sum) in &kinds {
        eprintln!("== {kind}: {}", sum.line());
    }
    let sum = kinds.values().fold(Score::default(), Score::plus);
    eprintln!("== all: {}", sum.line());
}

/// Two sorties (500 times SIDESLIP_SEEDS) with healthy instruments.
#[test]
fn healthy_instruments_of_a_sortie_are_left_alone() {
    let runs = sortie();
    let count = if std::env::var_os("SIDESLIP_SEEDS").is_some() { 500 * seeds(1) } else { 2 };
    let found = over_seeds(count, |number| {
        let verdicts = checked(&runs, &[], 100_000 + number);
        verdicts.into_iter().flat_map(|(verdict, _)| verdict.corrections).map(|one| format!("{:?}", one.effect)).collect()
    });
    let found: Vec<&String> = found.iter().flat_map(|one: &Vec<String>| one).collect();
    eprintln!("{} false findings in {count} sorties: {found:?}", found.len());
}
