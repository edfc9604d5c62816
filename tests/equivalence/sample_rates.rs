//! One flight sampled at other rates: the same derivatives, with the standard errors of the rate that the regression uses.
//!
//! Samples less than `2 lag / 248` apart, 3.2 ms, are not all used by the regression: every second one at 333 to 500 Hz,
//! every fourth at 1000 Hz. Its standard errors are those of the rate that is used, 155 to 310 Hz.

use crate::support::manoeuvre::{INPUTS, WANTED, fly_at};
use sideslip::flight::channel::Channel;
use sideslip::flight::file::model_file::ModelFile;
use sideslip::flight::run::RunGeometry;
use sideslip::flight::sample::Sample;
use sideslip::realtime::estimation::config::EstimationConfig;
use sideslip::realtime::estimation::estimator::Estimator;
use sideslip::realtime::pipeline::{Pipeline, PipelineConfig};
use sideslip::simulation::instrument::InstrumentSet;

const MODEL: &str = include_str!("../../replay/models/puma-like.toml");
const SEEDS: u64 = 4;
/// Standard errors of one flight scatter by a third from seed to seed, their mean over the terms and four seeds by a tenth.
const FACTOR: f64 = 1.3;

fn flown(rate_hz: f64, seed: u64) -> Vec<Sample> {
    let model = ModelFile::parse(MODEL).unwrap().linear;
    fly_at(rate_hz, &model, &INPUTS, &InstrumentSet::flight_quality(1.0), seed).samples
}

/// Value and standard error of every wanted derivative; each has to be told.
fn estimated(rate_hz: f64, seed: u64) -> Vec<(f64, f64)> {
    let mut pipeline = Box::new(Pipeline::new(&PipelineConfig::default(), RunGeometry::default()).unwrap());
    flown(rate_hz, seed).iter().for_each(|sample| {
        pipeline.step(sample);
    });
    let derivatives = pipeline.finish().derivatives.clone().unwrap();
    let told = WANTED.into_iter().map(|(axis, variable)| {
        let equation = &derivatives.equations[axis.index()];
        let term = equation.term(variable);
        let term = term.unwrap_or_else(|| panic!("{rate_hz} Hz, seed {seed}: no {axis:?} {variable:?}, {:?}", equation.status));
        (term.value, term.std)
    });
    told.collect()
}

/// Geometric mean of the standard errors.
fn mean_std(all: &[Vec<(f64, f64)>]) -> f64 {
    let terms: Vec<f64> = all.iter().flatten().map(|(_, std)| std.ln()).collect();
    (terms.iter().sum::<f64>() / terms.len() as f64).exp()
}

#[test]
fn derivatives_of_fast_samples_are_those_of_slow_ones() {
    let all = |rate_hz: f64| (0..SEEDS).map(|seed| estimated(rate_hz, seed)).collect::<Vec<_>>();
    let (slow, usual) = (all(100.0), all(250.0));
    for rate_hz in [310.0, 333.0, 400.0, 420.0, 500.0, 1000.0] {
        let fast = all(rate_hz);
        for (reference, of_reference) in [(&slow, "100"), (&usual, "250")] {
            for ((value, std), (expected, expected_std)) in fast.iter().flatten().zip(reference.iter().flatten()) {
                let score = (value - expected) / std.hypot(*expected_std);
                assert!(score.abs() < 3.0, "{rate_hz} Hz against {of_reference}: {value} +- {std}, {expected} +- {expected_std}");
            }
        }
        // The rate that is used, relative to that of 250 Hz: white noise averages with its root.
        let used_hz = rate_hz / (rate_hz * 0.8 / 248.0).ceil();
        let of_rate = mean_std(&fast) / mean_std(&usual) * (used_hz / 250.0).sqrt();
        let of_slow = mean_std(&fast) / mean_std(&slow);
        eprintln!("{rate_hz} Hz, of them {used_hz} used: {of_rate:.2} of what 250 Hz lets expect, {of_slow:.2} of 100 Hz");
        assert!((1.0 / FACTOR..FACTOR).contains(&of_rate) && of_slow < 1.0, "{rate_hz} Hz: {of_rate} {of_slow}");
    }
}

/// Instants of the regression grid of a flight at that rate, each gyro in a sample of its own so many seconds after the other.
fn instants(rate_hz: f64, apart_s: f64) -> Vec<f64> {
    let mut estimator = Box::new(Estimator::new(EstimationConfig::default(), RunGeometry::default()).unwrap());
    let mut instants = Vec::new();
    for whole in &flown(rate_hz, 1) {
        let mut parts = [*whole; 3];
        for (i, part) in parts.iter_mut().enumerate() {
            part.time_s += apart_s * i as f64;
            for (j, gyro) in Channel::GYROS.into_iter().enumerate() {
                if j != i {
                    part.clear(gyro);
                }
            }
            if i > 0 {
                Channel::ALL.into_iter().filter(|channel| !Channel::GYROS.contains(channel)).for_each(|other| part.clear(other));
            }
        }
        for sample in if apart_s > 0.0 { &parts[..] } else { std::slice::from_ref(whole) } {
            instants.extend(estimator.step(sample).smoothed.iter().map(|record| record.time_s));
        }
    }
    instants
}

#[test]
fn no_instant_of_the_regression_is_lost_at_any_rate() {
    for (rate_hz, apart_s) in [
        (50.0, 0.0),
        (100.0, 0.0),
        (250.0, 0.0),
        (310.0, 0.0),
        (333.0, 0.0),
        (400.0, 0.0),
        (420.0, 0.0),
        (500.0, 0.0),
        (1000.0, 0.0),
        (5000.0, 0.0),
        (50.0, 0.001),
        (100.0, 0.003),
    ] {
        let found = instants(rate_hz, apart_s);
        assert!(found.len() > 260, "{rate_hz} Hz, {apart_s} s: {} instants", found.len());
        for [before, after] in found.array_windows() {
            assert!((after - before - 0.08).abs() < 1e-9, "{rate_hz} Hz, {apart_s} s: {before} to {after}");
        }
    }
}
