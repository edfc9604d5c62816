//! Relations of two clocks: coverage of their standard errors, their bound, ambiguity and false alarms over simulated pairs, and
//! a real recording split in two.
//!
//! The long form: `SIDESLIP_SEEDS=1000 cargo nextest run --release --test fast --no-capture -E 'test(clock_relation)'`

use super::clock_pairs::{Band, Recorder};
use crate::support::manoeuvre::{over_seeds, seeds};
use crate::support::program::real;
use sideslip::flight::channel::Channel;
use sideslip::flight::sample::Sample;
use sideslip::flight::signal::series::Series;
use sideslip::io::telemetry::alignment::clock_estimation::{ClockEstimate, ClockSearch, ClockUnknown, estimate_clock_relation};
use sideslip::io::telemetry::recording::Recording;
use sideslip::num::random::NormalNoise;
use std::f64::consts::TAU;

/// Quantile of the standard normal for a two-sided 99.9 % band.
const BAND: f64 = 3.29;

const MOTION: Band = Band { std: 1.0, from_hz: 0.02, to_hz: 2.0, corner_hz: 0.5 };

/// One kind of pair.
struct Case {
    name: &'static str,
    ours: Recorder,
    theirs: Recorder,
    offset_s: f64,
    drift: f64,
    search: ClockSearch,
}

fn recorder(rate_hz: f64, noise_std: f64, from_s: f64, to_s: f64) -> Recorder {
    Recorder { rate_hz, noise_std, bias: 3.0, scale: 1.0, from_s, to_s, gaps_s: Vec::new() }
}

impl Case {
    fn pair(&self, band: &Band, seed: u64) -> (Series, Series) {
        let signal = band.draw(seed, 9);
        let ours = self.ours.record(|t| signal.at(t), 0.0, 0.0, seed, 1);
        (ours, self.theirs.record(|t| signal.at(t), self.offset_s, self.drift, seed, 2))
    }

    /// Errors of time at the reference and of the drift, over their standard errors.
    fn scores(&self, found: &ClockEstimate) -> (f64, Option<f64>) {
        let relation = found.relation;
        let reference_s = relation.reference_s();
        let truth_s = self.offset_s + reference_s + self.drift * reference_s;
        let std = |std: Option<f64>| std.filter(|std| *std > 0.0);
        let time = (relation.at_reference_s() - truth_s) / std(relation.std_at_s(reference_s)).unwrap();
        (time, std(relation.drift_std()).map(|std| (relation.drift() - self.drift) / std))
    }

    /// Standard error of the time by the bound of Knapp and Carter for independent noises on one stationary signal.
    fn bound_s(&self, band: &Band, length_s: f64) -> f64 {
        let density = |of: &Recorder| (of.noise_std / of.scale).powi(2) / of.rate_hz;
        let (ours, theirs) = (density(&self.ours), density(&self.theirs));
        let steps = 4000;
        let step = (band.to_hz - band.from_hz) / f64::from(steps);
        let sum: f64 = (0..steps)
            .map(|k| {
                let f = band.from_hz + (f64::from(k) + 0.5) * step;
                let s = band.density(f);
                (TAU * f * s).powi(2) / (s * (ours + theirs) + ours * theirs) * step
            })
            .sum();
        (2.0 * length_s * sum).sqrt().recip()
    }
}

fn cases() -> [Case; 3] {
    let ours = Recorder { gaps_s: vec![(40.0, 43.0)], ..recorder(256.0, 0.2, 0.0, 120.0) };
    let gaps_s = vec![(20.0, 26.0), (80.0, 81.0)];
    let theirs = Recorder { bias: -50.0, scale: 1.7, gaps_s, ..recorder(32.0, 0.1, -20.0, 110.0) };
    let fast = Case { name: "256 and 32 Hz", ours, theirs, offset_s: -93.7, drift: 200e-6, search: ClockSearch::default() };
    let ours = Recorder { gaps_s: vec![(40.0, 43.0)], ..recorder(10.0, 0.05, 0.0, 150.0) };
    let theirs = Recorder { bias: -50.0, scale: -2.0, ..recorder(100.0, 0.3, 30.0, 180.0) };
    // Theirs counts from 1970.
    let slow = Case { name: "10 and 100 Hz", ours, theirs, offset_s: -1.7e9, drift: -120e-6, search: ClockSearch::default() };
    let of = || recorder(50.0, 1.0, 0.0, 120.0);
    // As much noise in each sample as signal; the drift is known, for 120 s do not tell it.
    let search = ClockSearch { drift: Some(50e-6), ..ClockSearch::default() };
    let noisy = Case { name: "as much noise as signal", ours: of(), theirs: of(), offset_s: 271.0, drift: 50e-6, search };
    [fast, slow, noisy]
}

#[test]
fn standard_errors_cover_the_truth_and_are_those_of_the_bound() {
    let count = seeds(100);
    // Signal in both: 110 s less 10 s of gaps, 120 s less 3 s, 120 s.
    for (case, length_s) in cases().iter().zip([100.0, 117.0, 120.0]) {
        let found: Vec<_> = over_seeds(count, |seed| {
            let (ours, theirs) = case.pair(&MOTION, seed);
            estimate_clock_relation(&ours, &theirs, &case.search)
        });
        let known: Vec<&ClockEstimate> = found.iter().flatten().collect();
        for unknown in found.iter().filter_map(|found| found.as_ref().err()) {
            eprintln!("{}: {unknown}", case.name);
        }
        assert!(known.len() as u64 * 100 >= count * 97, "{}: {} of {count} are known", case.name, known.len());
        let scores: Vec<(f64, Option<f64>)> = known.iter().map(|found| case.scores(found)).collect();
        let of_time: Vec<f64> = scores.iter().map(|(time, _)| *time).collect();
        let of_drift: Vec<f64> = scores.iter().filter_map(|(_, drift)| *drift).collect();
        for (what, z) in [("time", of_time), ("drift", of_drift)] {
            if z.is_empty() {
                continue;
            }
            let n = z.len() as f64;
            let rms = (z.iter().map(|z| z * z).sum::<f64>() / n).sqrt();
            let inside = z.iter().filter(|z| z.abs() < 1.96).count() as f64 / n;
            eprintln!("{} {what}: rms z {rms:.3}, {:.1} % within 1.96 standard errors, of {n}", case.name, 100.0 * inside);
            assert!((inside - 0.95).abs() <= BAND * (0.95 * 0.05 / n).sqrt() + 0.5 / n, "{}: {what} {inside}", case.name);
            assert!((rms - 1.0).abs() <= BAND / (2.0 * n).sqrt() + 0.03, "{}: {what} {rms}", case.name);
        }
        let std_s = |found: &ClockEstimate| found.relation.std_at_s(found.relation.reference_s()).unwrap();
        let mean_s = (known.iter().map(|found| std_s(found).powi(2)).sum::<f64>() / known.len() as f64).sqrt();
        let bound_s = case.bound_s(&MOTION, length_s);
        eprintln!("{}: standard error {mean_s:.3e} s, bound {bound_s:.3e} s", case.name);
        assert!((0.95..1.2).contains(&(mean_s / bound_s)), "{}: {}", case.name, mean_s / bound_s);
    }
}

/// Responses to doublets at random times, with the period and damping of a short period: still between them.
fn manoeuvres(seed: u64, stream: u64, length_s: f64) -> impl Fn(f64) -> f64 {
    let mut noise = NormalNoise::new(seed, stream);
    let starts: Vec<(f64, f64)> =
        (0..5).map(|k| (length_s / 5.0 * (f64::from(k) + 0.3 + 0.15 * noise.draw()), 1.0 + 0.3 * noise.draw())).collect();
    let step = |t: f64| if t > 0.0 { 1.0 - (-1.2 * t).exp() * ((2.2 * t).cos() + 0.55 * (2.2 * t).sin()) } else { 0.0 };
    move |t| starts.iter().map(|(from, size)| size * (step(t - from) - 2.0 * step(t - from - 0.8) + step(t - from - 1.6))).sum()
}

#[test]
fn unrelated_recordings_have_no_relation() {
    let count = seeds(200);
    let bands = [
        ("motion", MOTION),
        ("red", Band { std: 1.0, from_hz: 0.005, to_hz: 2.0, corner_hz: 0.05 }),
        ("narrow", Band { std: 1.0, from_hz: 0.25, to_hz: 0.35, corner_hz: 10.0 }),
        ("slow", Band { std: 1.0, from_hz: 0.002, to_hz: 0.1, corner_hz: 1.0 }),
    ];
    let (ours, theirs) = (recorder(50.0, 0.05, 0.0, 120.0), recorder(20.0, 0.05, 0.0, 90.0));
    let (mut all, mut related) = (0, 0);
    let mut judge = |name: &str, one: &(dyn Fn(u64) -> (Series, Series) + Sync)| {
        let found = over_seeds(count, |seed| {
            let (ours, theirs) = one(seed);
            estimate_clock_relation(&ours, &theirs, &ClockSearch::default())
        });
        let wrong = found.iter().filter(|found| found.is_ok()).count();
        let past_search = |found: &&Result<_, _>| !matches!(found, Err(ClockUnknown::NoPeak { .. }));
        let highest = found.iter().filter_map(|found| match found {
            Err(ClockUnknown::NoPeak { found, needed }) => Some(found / needed),
            _ => None,
        });
        eprintln!(
            "{name}: {wrong} of {count} unrelated pairs related, {} past the search; largest significance {:.2} of that needed",
            found.iter().filter(past_search).count(),
            highest.fold(0.0, f64::max)
        );
        all += found.len();
        related += wrong;
    };
    for (name, band) in bands {
        judge(name, &|seed| {
            let (one, other) = (band.draw(seed, 9), band.draw(seed, 10));
            (ours.record(|t| one.at(t), 0.0, 0.0, seed, 1), theirs.record(|t| other.at(t), 7.0, 0.0, seed, 2))
        });
    }
    judge("doublets", &|seed| {
        let (one, other) = (manoeuvres(seed, 9, 120.0), manoeuvres(seed, 10, 90.0));
        (ours.record(one, 0.0, 0.0, seed, 1), theirs.record(other, 7.0, 0.0, seed, 2))
    });
    assert!(related * 100 < all, "{related} of {all}");
}

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
    let mut recording = Recording::open(&real(name)?).unwrap();
    let mut samples: Vec<Sample> = Vec::new();
    while let Some(row) = recording.next_row().unwrap() {
        samples.push(row.sample);
    }
    Some(samples)
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
