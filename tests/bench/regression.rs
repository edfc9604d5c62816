//! One regression update: 17 signals and 16 lags, ours beside outer products with nalgebra and beside plain least squares.

use crate::flight::Flight;
use crate::ledger::{Ledger, group};
use crate::textbook_regression::{LeastSquares, N, Sums};
use criterion::Criterion;
use nalgebra::SVector;
use sideslip::flight::run::RunGeometry;
use sideslip::realtime::estimation::config::EstimationConfig;
use sideslip::realtime::estimation::estimator::Estimator;
use sideslip::realtime::estimation::record::Instrumentation;
use sideslip::realtime::regression::candidate::{SIGNALS, signals};
use sideslip::realtime::regression::config::RegressionConfig;
use sideslip::realtime::regression::information::Information;
use sideslip::realtime::regression::recursive::Recursive;
use std::hint::black_box;

/// Ticks that are taken: 80 s, 900 instants of the grid.
const TICKS: usize = 4000;

/// Forgetting over 60 s on a grid of 0.08 s.
pub(crate) const LAMBDA: f64 = 0.998_667_6;

/// What the estimation makes of the flight's first part.
pub(crate) struct Smoothed {
    /// Vectors of the information matrix.
    pub(crate) vectors: Vec<[f64; SIGNALS]>,
    /// The regression stage after them.
    pub(crate) recursive: Recursive,
    /// Instruments found.
    pub(crate) instruments: Instrumentation,
}

impl Smoothed {
    /// Estimates the flight's first part.
    pub(crate) fn of(flight: &Flight) -> Self {
        let config = EstimationConfig::default();
        let mut estimator = Estimator::new(config, RunGeometry::default()).unwrap();
        let mut recursive = Recursive::new(RegressionConfig::default()).unwrap();
        let mut trim = None;
        let mut vectors = Vec::new();
        for sample in &flight.samples[..TICKS] {
            let output = estimator.step(sample);
            if let Some(found) = output.trim {
                trim = Some(found);
                recursive.begin(found);
            }
            for smoothed in &output.smoothed {
                recursive.step(smoothed);
                vectors.extend(trim.as_ref().and_then(|trim| signals(smoothed, trim)));
            }
        }
        let instruments = estimator.instrumentation();
        Smoothed { vectors, recursive, instruments }
    }
}

/// Same sums, and least squares that agrees with them.
fn agree(vectors: &[[f64; SIGNALS]]) {
    let (mut ours, mut sums, mut plain) = (Information::<N>::default(), Sums::new(), LeastSquares::new());
    for z in vectors {
        ours.add(z, LAMBDA);
        sums.add(&SVector::from(*z), LAMBDA);
        plain.add(&SVector::from(*z), LAMBDA);
    }
    let apart = sums.apart(ours.sums(), |lag| ours.lagged(lag));
    assert!(apart < 1e-12, "sums are {apart} apart");
    // N_v of the flight.
    assert!((plain.theta(2, 5) - 0.02).abs() < 2e-3, "N_v {}", plain.theta(2, 5));
}

/// Runs the group.
pub(crate) fn run(criterion: &mut Criterion, ledger: &Ledger, flight: &Flight) {
    let vectors = Smoothed::of(flight).vectors;
    agree(&vectors);
    let columns: Vec<SVector<f64, N>> = vectors.iter().map(|z| SVector::from(*z)).collect();
    let mut group = group(criterion, "regression update");
    let next = |k: &mut usize| {
        *k = (*k + 1) % vectors.len();
        *k
    };
    let (mut ours, mut k) = (Information::<N>::default(), 0);
    ledger.bench(&mut group, "update: ours", || ours.add(black_box(&vectors[next(&mut k)]), LAMBDA));
    black_box(&ours);
    let (mut sums, mut k) = (Sums::new(), 0);
    ledger.bench(&mut group, "update: outer products", || sums.add(black_box(&columns[next(&mut k)]), LAMBDA));
    black_box(&sums);
    let (mut plain, mut k) = (LeastSquares::new(), 0);
    ledger.bench(&mut group, "update: plain least squares", || plain.add(black_box(&columns[next(&mut k)]), LAMBDA));
    black_box(&plain);
    group.finish();
    ledger.compare("update: ours", "update: outer products", "");
    ledger.compare(
        "update: ours",
        "update: plain least squares",
        " (does less: no lags, so no honest standard errors, and one set of regressors)",
    );
}
