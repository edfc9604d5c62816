//! Coarse errors: signs, units and names are told as such, and no run with one is called fit; damaged samples make no error.

use super::flown::{candidate, sortie};
use crate::support::manoeuvre::over_seeds;
use sideslip::flight::channel::Channel;
use sideslip::flight::channel::Channel::{Alpha, Altitude, Ay, Az, Beta, P, Phi, Psi, Q, R, Tas, Theta};
use sideslip::io::outputs::words::instrument_words::verdict_reason;
use sideslip::postflight::reconstruction::screening::Damage;
use sideslip::postflight::reconstruction::verdict::{Fitness, check, check_watched};
use sideslip::postflight::recorded_run::RecordedRun;
use sideslip::postflight::work_progress::WorkProgress;
use std::time::Instant;

/// One run of the sortie, each channel's samples changed.
fn changed(run: usize, seed: u64, mut change: impl FnMut(Channel, f64, f64) -> f64) -> RecordedRun {
    let mut one = candidate("run", &sortie()[run], &[], seed);
    for sample in &mut one.samples {
        for channel in Channel::ALL {
            if let Some(value) = sample.get(channel) {
                sample.set(channel, change(channel, sample.time_s, value));
            }
        }
    }
    one
}

/// The check lasts as long as its fits: one that is asked to end gives no verdict, and its fits give no result.
#[test]
fn a_check_that_is_asked_to_end_ends_without_a_verdict() {
    static WORK: WorkProgress = WorkProgress::new();
    let runs: Vec<RecordedRun> = (0..3).map(|run| changed(run, 1, |_, _, value| value)).collect();
    assert_eq!(check_watched(&runs, Some(&WORK)).map(|verdicts| verdicts.len()), Some(3));
    WORK.stop();
    let begun = Instant::now();
    assert_eq!(check_watched(&runs, Some(&WORK)), None);
    let stopped = begun.elapsed();
    let begun = Instant::now();
    check(&runs);
    assert!(stopped < begun.elapsed() / 2, "{stopped:?}");
}

/// Pedal, lateral, longitudinal: each channel in a run that moves it.
#[test]
fn a_turned_sign_is_named() {
    let turned = [(P, 1), (Q, 2), (R, 0), (Phi, 1), (Theta, 2), (Psi, 0), (Alpha, 2), (Beta, 0)];
    let verdicts = over_seeds(turned.len() as u64, |number| {
        let (turned, run) = turned[number as usize];
        check(&[changed(run, number, |channel, _, value| if channel == turned { -value } else { value })]).remove(0)
    });
    for ((channel, _), verdict) in turned.into_iter().zip(verdicts) {
        assert!(verdict.fitness == Fitness::NotFit, "{channel:?}: {verdict:?}");
        let name = channel.name(sideslip::flight::channel::ControlNames::Rotorcraft);
        assert!(
            verdict_reason(&verdict.reason).contains(&format!("{name} with its sign reversed")),
            "{}",
            verdict_reason(&verdict.reason)
        );
    }
    // Gravity tells this one before.
    let verdict = check(&[changed(0, 9, |channel, _, value| if channel == Az { -value } else { value })]).remove(0);
    assert!(verdict.fitness == Fitness::NotFit && verdict_reason(&verdict.reason).contains("az is 9."), "{verdict:?}");
}

/// Where only the collective moves, rough air would explain a sideways accelerometer with its sign turned: gravity does not.
#[test]
fn a_turned_sideways_accelerometer_is_told_by_gravity_where_nothing_else_moves() {
    let turned = |number| changed(3, 70 + number, |channel, _, value| if channel == Ay { -value } else { value });
    for verdict in over_seeds(2, |number| check(&[turned(number)]).remove(0)) {
        assert!(
            verdict_reason(&verdict.reason).contains("ay ") && verdict_reason(&verdict.reason).contains("sign reversed"),
            "{verdict:?}"
        );
        assert!(verdict.fitness == Fitness::NotFit || verdict.corrections.is_empty(), "{verdict:?}");
    }
}

#[test]
fn another_unit_is_named() {
    let degrees = 180.0 / std::f64::consts::PI;
    type Case = (usize, &'static [Channel], f64, &'static str);
    let cases: [Case; 5] = [
        (1, &[P, Q, R], degrees, "p q r in deg/s"),
        (1, &[Phi, Theta, Psi], degrees, "phi theta psi in deg"),
        (0, &[Alpha, Beta], degrees, "alpha beta in deg"),
        (2, &[Tas], 3600.0 / 1852.0, "tas in kn"),
        (2, &[Altitude], 1.0 / 0.3048, "altitude in ft"),
    ];
    let verdicts = over_seeds(cases.len() as u64, |number| {
        let (run, these, factor, _) = cases[number as usize];
        check(&[changed(run, number, |channel, _, value| if these.contains(&channel) { factor * value } else { value })])
            .remove(0)
    });
    for ((.., words), verdict) in cases.into_iter().zip(verdicts) {
        assert!(verdict.fitness == Fitness::NotFit && verdict_reason(&verdict.reason).contains(words), "{words}: {verdict:?}");
    }
}

#[test]
fn healthy_runs_have_no_coarse_error() {
    let verdicts = over_seeds(12, |seed| check(&[changed((seed % 4) as usize, 500 + seed, |_, _, value| value)]).remove(0));
    assert!(
        verdicts.iter().all(|verdict| !verdict_reason(&verdict.reason).contains("reads like") && verdict.screened.is_empty())
    );
}

/// A spike, a frozen and a zeroed stretch are taken out and said; what is left is as good as before.
#[test]
fn damaged_samples_make_no_error() {
    let mut held = None;
    let damaged = changed(0, 40, |channel, time_s, value| match channel {
        P if (6.0..6.015).contains(&time_s) => 50.0,
        Phi if (8.0..8.015).contains(&time_s) => 1.0,
        R if (10.0..11.0).contains(&time_s) => *held.get_or_insert(value),
        Ay if (14.0..14.2).contains(&time_s) => 0.0,
        _ => value,
    });
    let verdict = check(&[damaged]).remove(0);
    assert!(verdict.fitness == Fitness::Fit && verdict.corrections.is_empty(), "{verdict:?}");
    let said = |channel: Channel, damage: Damage| {
        verdict.screened.iter().filter(|one| one.channel == channel && one.damage == damage).map(|one| one.count).sum::<usize>()
    };
    assert_eq!(said(P, Damage::OutOfRange) + said(P, Damage::Spike), 1, "{:?}", verdict.screened);
    assert_eq!(said(Phi, Damage::Spike), 1);
    assert_eq!((said(R, Damage::Frozen), said(Ay, Damage::Frozen)), (49, 9), "{:?}", verdict.screened);
}
