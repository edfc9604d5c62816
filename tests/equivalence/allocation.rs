//! Between a sample and its estimate nothing is allocated: not on the ground, in flight, or when things go wrong.

use crate::support::allocations::during;
use crate::support::firmware_manoeuvre::{ManoeuvreSamples, SAMPLES};
use sideslip::flight::channel::Channel;
use sideslip::flight::run::RunGeometry;
use sideslip::flight::sample::Sample;
use sideslip::realtime::estimation::config::RegressionStates;
use sideslip::realtime::estimation::record::EstimationEvent;
use sideslip::realtime::pipeline::{Pipeline, PipelineConfig};
use std::hint::black_box;

/// The manoeuvre with everything wrong that telemetry gets wrong.
fn troubled() -> Vec<Sample> {
    let mut samples: Vec<Sample> = ManoeuvreSamples::default().collect();
    for (i, sample) in samples.iter_mut().enumerate() {
        match i % 97 {
            3 => sample.set(Channel::P, f64::NAN),
            7 => sample.set(Channel::Beta, f64::INFINITY),
            11 => sample.set(Channel::Ay, 1e9),
            13 => sample.time_s = f64::NAN,
            17 => sample.time_s -= 0.5,
            19 => sample.time_s -= 0.02,
            23 => sample.set(Channel::Tas, 400.0),
            29 => sample.clear(Channel::R),
            _ => {}
        }
    }
    // Silence, then a clock that was set back, then instruments that are gone.
    let silence = SAMPLES as usize / 2;
    for sample in &mut samples[silence..] {
        sample.time_s += 5.0;
    }
    for sample in &mut samples[silence + 300..] {
        sample.time_s -= 20.0;
    }
    for sample in &mut samples[silence + 700..] {
        for channel in [Channel::Ax, Channel::Ay, Channel::Az, Channel::Beta, Channel::Phi] {
            sample.clear(channel);
        }
    }
    samples
}

#[test]
fn the_counter_counts() {
    let _turn = crate::alone();
    assert_eq!(during(|| drop(black_box(Box::new(1_u64)))), 2);
    assert_eq!(during(|| drop(black_box(String::from("grows")) + "again")), 3);
    assert_eq!(during(|| ()), 0);
}

#[test]
fn nothing_is_allocated_between_sample_and_estimate() {
    let _turn = crate::alone();
    for samples in [ManoeuvreSamples::default().collect(), troubled()] {
        for states in [RegressionStates::Smoothed, RegressionStates::Filtered] {
            let mut config = PipelineConfig::default();
            config.estimation.regression_states = states;
            let mut pipeline = Box::new(Pipeline::new(&config, RunGeometry::default()).unwrap());
            let mut worst = 0;
            for sample in &samples {
                worst = worst.max(during(|| {
                    black_box(pipeline.step(sample));
                }));
            }
            let last = during(|| {
                black_box(pipeline.finish());
            });
            assert_eq!((worst, last), (0, 0));
        }
    }
}

#[test]
fn the_troubled_run_had_its_troubles_and_an_answer() {
    let _turn = crate::alone();
    let mut pipeline = Box::new(Pipeline::new(&PipelineConfig::default(), RunGeometry::default()).unwrap());
    let mut events = Vec::new();
    for sample in troubled() {
        events.extend(pipeline.step(&sample).estimation_events.iter().copied());
    }
    let happened = |which: &dyn Fn(&EstimationEvent) -> bool| assert!(events.iter().any(which), "{events:?}");
    happened(&|event| matches!(event, EstimationEvent::NotFinite { .. }));
    happened(&|event| matches!(event, EstimationEvent::OutOfRange { .. }));
    happened(&|event| matches!(event, EstimationEvent::TimeNotFinite));
    happened(&|event| matches!(event, EstimationEvent::TimeWentBack { .. }));
    happened(&|event| matches!(event, EstimationEvent::DuplicateTime));
    happened(&|event| matches!(event, EstimationEvent::Gap { .. }));
    happened(&|event| matches!(event, EstimationEvent::SegmentRestart));
    happened(&|event| matches!(event, EstimationEvent::AidRejected { .. }));
    assert!(events.iter().filter(|event| matches!(event, EstimationEvent::Initialised)).count() >= 3);
    let modes = pipeline.finish().modes.unwrap();
    assert!(modes.dutch_roll.is_some(), "{modes:?}");
}
