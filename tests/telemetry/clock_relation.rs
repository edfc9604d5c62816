//! Relations of two clocks: what is not answered, a real recording split in two, real recordings of different flights.

use super::clock_pairs::{MOTION, recorder};
use crate::support::program::real;
use crate::support::recorded_samples::samples_of;
use sideslip::flight::channel::Channel;
use sideslip::flight::sample::Sample;
use sideslip::flight::signal::series::Series;
use sideslip::io::telemetry::alignment::clock_estimation::estimate_clock_relation;
use sideslip::io::telemetry::alignment::clock_estimation::record::{ClockSearch, ClockUnknown};
use sideslip::num::random::NormalNoise;

#[test]
fn a_periodic_manoeuvre_a_still_channel_and_a_short_record_are_not_answered() {
    // A doublet every 8 s, rounded.
    let square = |t: f64| match (t / 8.0).rem_euclid(1.0) {
        x if x < 0.2 => 1.0,
        x if x < 0.4 => -1.0,
        _ => 0.0,
    };
    let doublets = |t: f64| (-10..10).map(|k| square(t + 0.03 * f64::from(k))).sum::<f64>() / 20.0;
    let (ours, theirs) = (recorder(50.0, 0.05, 0.0, 80.0), recorder(20.0, 0.05, 0.0, 80.0));
    let signal = MOTION.draw(1, 9);
    let relate = |signal: &dyn Fn(f64) -> f64, seed, search: &ClockSearch| {
        let (one, two) = (ours.record(signal, 0.0, 0.0, seed, 1), theirs.record(signal, 7.0, 50e-6, seed, 2));
        estimate_clock_relation(&one, &two, search)
    };
    let default = ClockSearch::default();
    for seed in 0..20 {
        let Err(ClockUnknown::Ambiguous { first_s, second_s, .. }) = relate(&doublets, seed, &default) else { panic!("{seed}") };
        let periods = (first_s - second_s) / 8.0;
        assert!((periods - periods.round()).abs() < 0.1 && periods.round() != 0.0, "{first_s} {second_s}");
    }
    // Told where to look, it knows.
    let near = ClockSearch { difference_s: Some((4.0, 10.0)), drift: Some(50e-6), ..default };
    let found = relate(&doublets, 3, &near).unwrap();
    assert!((found.relation.ours_s(20.0) - (7.0 + 1.000_05 * 20.0)).abs() < 4.0 * found.relation.std_at_s(20.0).unwrap());
    // A channel that stands still, one with noise only, and one record that is too short for its drift.
    let flat = Series::of((0..4000).map(|k| (0.02 * f64::from(k), 12.0)));
    let moving = theirs.record(|t| signal.at(t), 0.0, 0.0, 1, 2);
    assert_eq!(estimate_clock_relation(&flat, &moving, &default).unwrap_err(), ClockUnknown::NoMotion);
    assert!(matches!(relate(&|_| 5.0, 1, &default), Err(ClockUnknown::NoPeak { .. })));
    let strict = ClockSearch { drift_std_max: 5e-6, ..default };
    let Err(error @ ClockUnknown::TooShortForDrift { difference_s, time_std_s, .. }) = relate(&|t| signal.at(t), 1, &strict)
    else {
        panic!()
    };
    assert!((difference_s - 7.0).abs() < 0.01 && time_std_s < 2e-3 && error.to_string().starts_with("not known, because 7"));
    let short = Series::of(moving.samples().take(99));
    assert_eq!(
        estimate_clock_relation(&short, &moving, &default).unwrap_err(),
        ClockUnknown::TooFewSamples { samples: 99, needed: 100 }
    );
}

/// The samples of a real recording.
fn samples(name: &str) -> Option<Vec<Sample>> {
    Some(samples_of(&real(name)?))
}

/// A channel of them.
fn channel(samples: &[Sample], channel: Channel) -> Vec<(f64, f64)> {
    samples.iter().filter_map(|sample| Some((sample.time_s, sample.get(channel)?))).collect()
}

#[test]
fn a_real_recording_in_two_parts_is_put_together_again() {
    let (offset_s, drift) = (12.3456, 80e-6);
    let Some(recording) = samples("attas-stall-1.csv") else { return };
    let mut known = Vec::new();
    // Every second sample for each, so that not even the noise of the instrument is shared.
    for shared in [Channel::Tas, Channel::Az, Channel::Ay, Channel::P, Channel::Q, Channel::Theta, Channel::Altitude] {
        let samples = channel(&recording, shared);
        let mean = samples.iter().map(|(_, x)| x).sum::<f64>() / samples.len() as f64;
        let std = (samples.iter().map(|(_, x)| (x - mean).powi(2)).sum::<f64>() / samples.len() as f64).sqrt();
        let mut z = Vec::new();
        for seed in 0..10 {
            let (mut noise, mut other) = (NormalNoise::new(seed, 1), NormalNoise::new(seed, 2));
            let ours = Series::of(samples.iter().step_by(2).map(|&(t, x)| (t, x + 0.01 * std * noise.draw())));
            let theirs = samples.iter().skip(1).step_by(2);
            let theirs =
                Series::of(theirs.map(|&(t, x)| ((t - offset_s) / (1.0 + drift), 4.0 + 1.02 * (x + 0.01 * std * other.draw()))));
            let search = ClockSearch { drift_std_max: 200e-6, ..ClockSearch::default() };
            let found = match estimate_clock_relation(&ours, &theirs, &search) {
                Ok(found) => found,
                Err(unknown @ (ClockUnknown::NoPeak { .. } | ClockUnknown::TooShortForDrift { .. })) => {
                    if seed == 0 {
                        eprintln!("{shared:?}: {unknown}");
                    }
                    continue;
                }
                Err(other) => panic!("{shared:?}: {other}"),
            };
            let relation = found.relation;
            let at = relation.reference_s();
            z.push((
                (relation.at_reference_s() - (offset_s + (1.0 + drift) * at)) / relation.std_at_s(at).unwrap(),
                (relation.drift() - drift) / relation.drift_std().unwrap(),
            ));
            if seed == 0 {
                eprintln!("{shared:?}: {relation}, colour {:.1}, significance {:.1}", found.colour_factor, found.significance.0);
            }
            assert!((found.scale.0 / 1.02 - 1.0).abs() < 5.0 * found.scale.1 + 0.01, "{shared:?}: {:?}", found.scale);
        }
        // The ten share the recording, so that they are little more than one draw.
        let worst = z.iter().flat_map(|(time, drift)| [time.abs(), drift.abs()]).fold(0.0, f64::max);
        eprintln!("{shared:?}: {} of 10 known, largest error {worst:.2} standard errors", z.len());
        assert!(worst < 4.0, "{shared:?}: {z:?}");
        if z.len() == 10 {
            known.push(shared);
        }
    }
    assert!([Channel::Tas, Channel::P, Channel::Q].iter().all(|channel| known.contains(channel)), "{known:?}");
}

#[test]
fn real_recordings_of_different_flights_have_no_relation() {
    let names = ["attas-rud1", "attas-ail1", "attas-elv1", "attas-stall-1", "citation-2018-dutchroll", "citation-2019-dutchroll"];
    let mut recordings = Vec::new();
    for name in names.into_iter().chain(["citation-2019-dutchroll-yawdamper", "citation-2018-short-period", "hfb320"]) {
        let Some(recording) = samples(&format!("{name}.csv")) else { return };
        recordings.push((name, recording));
    }
    let mut pairs = 0;
    for (i, (name, ours)) in recordings.iter().enumerate() {
        for (other_name, theirs) in recordings.iter().skip(i + 1) {
            for shared in [Channel::P, Channel::Q, Channel::R, Channel::Phi, Channel::Theta, Channel::Tas, Channel::Altitude] {
                let (one, two) = (Series::of(channel(ours, shared)), Series::of(channel(theirs, shared)));
                let drift = Some(0.0);
                let found = estimate_clock_relation(&one, &two, &ClockSearch { drift, ..ClockSearch::default() });
                assert!(found.is_err(), "{shared:?} of {name} and {other_name}: {found:?}");
                pairs += 1;
            }
        }
    }
    eprintln!("{pairs} pairs of different flights, none related");
}
