//! Relations of two clocks over many simulated pairs: coverage of their standard errors, their bound, false alarms.
//!
//! CI flies 25, 50 and 20 pairs of each kind. The long form:
//! `SIDESLIP_SEEDS=1000 cargo nextest run --release --test slow --no-capture -E 'test(clock_coverage)'`

use super::clock_pairs::{Band, MOTION, Recorder, recorder};
use crate::support::asked::seeds;
use crate::support::manoeuvre::over_seeds;
use sideslip::flight::signal::series::Series;
use sideslip::io::telemetry::alignment::clock_estimation::estimate_clock_relation;
use sideslip::io::telemetry::alignment::clock_estimation::record::{ClockEstimate, ClockSearch, ClockUnknown};
use sideslip::num::random::NormalNoise;
use std::f64::consts::TAU;

/// Quantile of the standard normal for a two-sided 99.9 % band.
const BAND: f64 = 3.29;

/// One kind of pair.
struct Case {
    name: &'static str,
    ours: Recorder,
    theirs: Recorder,
    offset_s: f64,
    drift: f64,
    search: ClockSearch,
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
    let count = seeds(25);
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
    let count = seeds(50);
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
fn where_the_instruments_differ_slowly_the_standard_error_grows_with_it() {
    let (ours, theirs) = (recorder(64.0, 0.05, 0.0, 150.0), recorder(32.0, 0.05, 0.0, 150.0));
    let found: Vec<_> = over_seeds(seeds(20), |seed| {
        let signal = MOTION.draw(seed, 9);
        let one = ours.record(|t| signal.at(t), 0.0, 0.0, seed, 1);
        // A difference of 0.2 that lasts for half a second.
        let (mut noise, mut slow, keeps) = (NormalNoise::new(seed, 5), 0.0, (-1.0_f64 / 16.0).exp());
        let two = theirs.record(|t| signal.at(t), 7.0, 1e-4, seed, 2);
        let two = Series::of(two.samples().map(|(t, x)| {
            slow = keeps * slow + 0.2 * (1.0 - keeps * keeps).sqrt() * noise.draw();
            (t, x + slow)
        }));
        estimate_clock_relation(&one, &two, &ClockSearch::default())
    });
    let known: Vec<&ClockEstimate> = found.iter().flatten().collect();
    let n = known.len() as f64;
    let z = |found: &ClockEstimate| {
        let at = found.relation.reference_s();
        (found.relation.at_reference_s() - (7.0 + 1.0001 * at)) / found.relation.std_at_s(at).unwrap()
    };
    let rms = (known.iter().map(|found| z(found).powi(2)).sum::<f64>() / n).sqrt();
    let colour = known.iter().map(|found| found.colour_factor).sum::<f64>() / n;
    eprintln!("slow differences: rms z {rms:.2}, factor on the variance {colour:.1}, of {n}");
    // White noise alone would make it sqrt(colour); what is left is what a finite number of lags leaves out.
    assert!(found.len() * 9 <= known.len() * 10 && colour > 3.0 && (0.7..1.4).contains(&rms), "{rms} {colour} {n}");
}
