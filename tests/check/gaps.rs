//! Records with long gaps and wrong time stamps: followed stretch by stretch, at the cost of their rows, or refused in words.

use super::flown::{candidate, flight};
use sideslip::flight::channel::Channel;
use sideslip::flight::effect::Effect;
use sideslip::io::outputs::words::instrument_words::verdict_reason;
use sideslip::postflight::reconstruction::verdict::{Fitness, RunVerdict, check};
use sideslip::postflight::recorded_run::RecordedRun;

const LATE: Effect = Effect::SensorDelay { channel: Channel::Phi, delay: 0.2 };

/// The flight twice, the second one that much after the first has ended.
fn two_test_points(apart_s: f64, effects: &[Effect]) -> RunVerdict {
    let mut run = candidate("flight", &flight(), effects, 1);
    let second = candidate("flight", &flight(), effects, 2);
    let end_s = run.samples.last().unwrap().time_s;
    run.samples.extend(second.samples.into_iter().map(|mut sample| {
        sample.time_s += end_s + apart_s;
        sample
    }));
    check(&[run]).remove(0)
}

fn delay(verdict: &RunVerdict) -> (f64, f64) {
    let found = verdict.corrections.iter().find_map(|one| match one.effect.effect {
        Effect::SensorDelay { channel: Channel::Phi, delay } => Some((delay, one.effect.std.unwrap())),
        _ => None,
    });
    found.unwrap_or_else(|| panic!("no delay of phi in {:?}", verdict.corrections))
}

#[test]
fn what_is_found_does_not_depend_on_the_length_of_a_gap() {
    let near = two_test_points(3.0, &[LATE]);
    // The rest of a year, as a clock has that jumps: laid over by nodes, it would take 64 GB.
    let far = two_test_points(3e7, &[LATE]);
    for verdict in [&near, &far] {
        let (value, std) = delay(verdict);
        assert!((value - 0.2).abs() < 3.0 * std.max(0.002), "{value} +- {std}");
        assert_eq!(verdict.long_gaps.len(), 1);
    }
    let ((near, std), (far, _)) = (delay(&near), delay(&far));
    assert!((near - far).abs() < 0.1 * std, "{near} and {far} +- {std}");
    assert_eq!(two_test_points(1000.0, &[]).fitness, Fitness::Fit);
}

/// A clock that jumps to the time since 1970 while the aircraft moves: rows next to the gap are no instrument's error.
#[test]
fn a_clock_that_jumps_in_mid_manoeuvre_makes_no_error_of_an_instrument() {
    for from_s in [3.0, 8.0, 15.0] {
        let mut run = candidate("flight", &flight(), &[], 1);
        run.samples.iter_mut().filter(|sample| sample.time_s >= from_s).for_each(|sample| sample.time_s += 1.7e9);
        let verdict = check(&[run]).remove(0);
        assert_eq!((verdict.fitness, verdict.corrections.len()), (Fitness::Fit, 0), "{from_s}: {:?}", verdict.corrections);
        assert_eq!(verdict.long_gaps.len(), 1);
    }
}

#[test]
fn one_wrong_time_stamp_is_refused_in_words_or_does_not_count() {
    let stamped = |place: usize, time_s: f64| {
        let mut run: RecordedRun = candidate("flight", &flight(), &[], 1);
        run.samples[place].time_s = time_s;
        check(&[run]).remove(0)
    };
    let count = candidate("flight", &flight(), &[], 1).samples.len();
    for time_s in [1e9, 1e300] {
        let verdict = stamped(count / 2, time_s);
        assert_eq!(verdict.fitness, Fitness::NotFit);
        assert!(verdict_reason(&verdict.reason).contains("does not go forward"), "{}", verdict_reason(&verdict.reason));
        assert_eq!(stamped(count - 1, time_s).fitness, Fitness::Fit);
    }
    assert_eq!(stamped(count / 2, 0.0).fitness, Fitness::Fit, "one stamp behind loses its row");
}
