//! A whole sample through the pipeline, early and late in a record: the cost must not depend on the record's length.

use crate::flight::Flight;
use crate::ledger::{Ledger, group};
use criterion::Criterion;
use sideslip::flight::run::RunGeometry;
use sideslip::realtime::pipeline::{Pipeline, PipelineConfig};
use std::hint::black_box;
use std::time::{Duration, Instant};

/// Samples that are timed in one go before the pipeline is put back to where it was.
const BLOCK: usize = 1000;

/// Runs the group.
pub(crate) fn run(criterion: &mut Criterion, ledger: &Ledger, flight: &Flight) {
    let mut pipeline = Box::new(Pipeline::new(&PipelineConfig::default(), RunGeometry::default()).unwrap());
    let mut group = group(criterion, "whole sample");
    let mut fed = 0;
    for (name, after) in [("sample: after 1e3", 1_000), ("sample: after 1e4", 10_000), ("sample: after 1e5", 100_000)] {
        for sample in &flight.samples[fed..after] {
            pipeline.step(sample);
        }
        fed = after;
        let mut work = pipeline.clone();
        ledger.bench_prepared(&mut group, name, |iterations| {
            let mut took = Duration::ZERO;
            let mut left = iterations as usize;
            while left > 0 {
                work.clone_from(&pipeline);
                let block = left.min(BLOCK);
                let begin = Instant::now();
                for sample in &flight.samples[after..after + block] {
                    black_box(work.step(black_box(sample)));
                }
                took += begin.elapsed();
                left -= block;
            }
            took
        });
    }
    group.finish();
    ledger.compare("sample: after 1e5", "sample: after 1e4", " (late/early)");
    ledger.compare("sample: after 1e5", "sample: after 1e3", " (late/early: 1 is independent of the record's length)");
}
