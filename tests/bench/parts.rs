//! What a sample at 256 Hz costs by part, and the longest that any sample of the flight takes.

use crate::filter::{DT, start, ticks};
use crate::flight::Flight;
use crate::ledger::{Ledger, group};
use criterion::Criterion;
use sideslip::flight::channel::Channel;
use sideslip::flight::run::RunGeometry;
use sideslip::flight::sample::Sample;
use sideslip::realtime::estimation::config::EstimationConfig;
use sideslip::realtime::estimation::ekf::{FilterObserver, Fusion, Transition};
use sideslip::realtime::estimation::estimator::Estimator;
use sideslip::realtime::estimation::fixed_lag::FixedLag;
use sideslip::realtime::estimation::noise::NoiseStatistics;
use sideslip::realtime::estimation::process::State;
use sideslip::realtime::estimation::vibration::LineNotch;
use sideslip::realtime::pipeline::{Pipeline, PipelineConfig};
use std::hint::black_box;
use std::time::{Duration, Instant};

/// Samples before anything is timed: filter and trim are settled.
const SETTLED: usize = 1024;
/// Flights over which the shortest time of each sample is taken: what else the machine did is left out.
const FLIGHTS: usize = 7;

/// What a filter did in one step.
#[derive(Clone)]
struct Kept {
    transition: Transition,
    fusions: Vec<(State, Fusion)>,
}

impl FilterObserver for Kept {
    fn propagate(&mut self, transition: &Transition) {
        self.transition = *transition;
        self.fusions.clear();
    }
    fn fuse(&mut self, row: &State, fusion: &Fusion) {
        self.fusions.push((*row, *fusion));
    }
}

/// The longest step of a pipeline over the flight, each sample at its shortest of several flights.
fn longest(samples: &[Sample]) -> (usize, Duration) {
    let mut shortest = vec![Duration::MAX; samples.len()];
    for _ in 0..FLIGHTS {
        let mut pipeline = Box::new(Pipeline::new(&PipelineConfig::default(), RunGeometry::default()).unwrap());
        for (sample, shortest) in samples.iter().zip(&mut shortest) {
            let begin = Instant::now();
            black_box(pipeline.step(black_box(sample)));
            *shortest = (*shortest).min(begin.elapsed());
        }
    }
    shortest.into_iter().enumerate().max_by_key(|(_, took)| *took).unwrap()
}

/// Goes round through the settled samples.
fn around(samples: &[Sample], mut each: impl FnMut(&Sample)) -> impl FnMut() {
    let mut k = SETTLED;
    move || {
        each(&samples[k]);
        k = if k + 1 < samples.len() { k + 1 } else { SETTLED };
    }
}

/// Runs the group.
pub(crate) fn run(criterion: &mut Criterion, ledger: &Ledger, flight: &Flight) {
    let z = ticks(flight);
    let (mut filter, _) = start(&z, 1.0);
    let mut smoother = Box::new(FixedLag::new(0.5, 0.08));
    let mut kept = Kept { transition: *filter.ekf.transition(), fusions: Vec::new() };
    for (k, z) in z[1..SETTLED].iter().enumerate() {
        let mut step = kept.clone();
        filter.step(z, &mut step);
        kept = step;
        smoother.propagate(&kept.transition);
        kept.fusions.iter().for_each(|(row, fusion)| smoother.fuse(row, fusion));
        smoother.tick(k as f64 * DT, &filter.ekf);
    }
    let mut group = group(criterion, "parts");
    let mut work = filter.clone();
    ledger.bench(&mut group, "part: prediction", || {
        work.ekf.clone_from(&filter.ekf);
        black_box(work.ekf.propagate(DT, &work.noise)).unwrap();
    });
    ledger.bench(&mut group, "part: thirteen measurements", || {
        work.ekf.clone_from(&filter.ekf);
        black_box(work.measure(&z[SETTLED], &mut ()));
    });
    let mut gathering = smoother.clone();
    let mut count = 0;
    ledger.bench(&mut group, "part: fixed lag, gathering", || {
        count += 1;
        if count % 20 == 0 {
            gathering.clone_from(&smoother);
        }
        gathering.propagate(black_box(&kept.transition));
        kept.fusions.iter().for_each(|(row, fusion)| gathering.fuse(row, fusion));
    });
    let mut time_s = SETTLED as f64 * DT;
    ledger.bench(&mut group, "part: fixed lag, an instant", || {
        time_s += 0.08;
        black_box(smoother.tick(time_s, &filter.ekf));
    });
    let mut statistics = NoiseStatistics::new(&EstimationConfig::default());
    flight.samples[..SETTLED].iter().for_each(|sample| statistics.take(sample));
    ledger.bench(&mut group, "part: noise banks", around(&flight.samples, |sample| statistics.take(sample)));
    ledger.bench(&mut group, "part: noise statistics brought up to date", || statistics.update());
    let mut notch = LineNotch::new(Some(4), 0.5);
    let lines = around(&flight.samples, |sample| {
        let mut sample = *sample;
        sample.set(Channel::RotorSpeed, 27.0);
        notch.clean(&mut sample);
        black_box(&sample);
    });
    ledger.bench(&mut group, "part: line notch", lines);
    // The same flight over and over, without a step back in time.
    let seconds = flight.samples.len() as f64 * DT;
    let endless = |mut each: Box<dyn FnMut(&Sample)>| {
        let (mut k, mut gone_s) = (0, 0.0);
        move || {
            let mut sample = flight.samples[k];
            sample.time_s += gone_s;
            each(&sample);
            k += 1;
            if k == flight.samples.len() {
                (k, gone_s) = (0, gone_s + seconds);
            }
        }
    };
    let mut estimator = Box::new(Estimator::new(EstimationConfig::default(), RunGeometry::default()).unwrap());
    ledger.bench(
        &mut group,
        "part: estimation, all of it",
        endless(Box::new(move |sample| {
            black_box(estimator.step(sample));
        })),
    );
    let mut pipeline = Box::new(Pipeline::new(&PipelineConfig::default(), RunGeometry::default()).unwrap());
    ledger.bench(
        &mut group,
        "part: pipeline, all of it",
        endless(Box::new(move |sample| {
            black_box(pipeline.step(sample));
        })),
    );
    group.finish();
    ledger.tell("part: prediction", 1.0, "");
    ledger.tell("part: thirteen measurements", 1.0, "");
    ledger.tell("part: fixed lag, gathering", 1.0, "");
    ledger.tell("part: fixed lag, an instant", 1.0, ", once every 0.08 s");
    ledger.tell("part: noise banks", 1.0, "");
    ledger.tell("part: noise statistics brought up to date", 1.0, ", once every 0.1 s");
    ledger.tell("part: line notch", 1.0, ", where there are blades");
    ledger.tell("part: estimation, all of it", 1.0, ", mean over instants of every kind");
    ledger.tell("part: pipeline, all of it", 1.0, ", mean over instants of every kind");
    let (sample, took) = longest(&flight.samples);
    ledger.note(format!(
        "longest step of the pipeline {:.0} us (sample {sample}, shortest of {FLIGHTS} flights)",
        took.as_secs_f64() * 1e6
    ));
}
