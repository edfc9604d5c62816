//! How long one fit by output error takes, and what comes out of it: `key value` a line for `compare.py` beside it.
//!
//! With a path as argument the problem is written there first, so that the other side fits the very numbers: a line with the
//! starts, a line with the truth, then time, inputs, outputs a line.

#![expect(clippy::unwrap_used, clippy::print_stdout, reason = "a benchmark stops where its data are wrong, and prints")]

#[path = "problem.rs"]
mod problem;
#[path = "../../support/processor_clock.rs"]
mod processor_clock;

use processor_clock::Clock;
use sideslip::postflight::output_error::{FitSettings, fit};
use std::fmt::Write as _;
use std::hint::black_box;
use std::time::Instant;

/// For how long it is measured, s.
const MEASURED_S: f64 = 2.0;

fn main() {
    let (structure, parameters, record) = (problem::structure(), problem::parameters(), problem::record());
    if let Some(path) = std::env::args().skip(1).find(|argument| !argument.starts_with('-')) {
        let line = |values: Vec<f64>| values.iter().map(|value| format!("{value:?}")).collect::<Vec<_>>().join(",");
        let mut text = line(parameters.iter().map(|parameter| parameter.start).collect()) + "\n";
        writeln!(text, "{}", line(problem::TRUTH.iter().map(|(_, value)| *value).collect())).unwrap();
        for (k, &t) in record.times_s.iter().enumerate() {
            let row = [t].into_iter().chain(record.inputs.iter().chain(&record.outputs).map(|one| one[k])).collect();
            writeln!(text, "{}", line(row)).unwrap();
        }
        std::fs::write(path, text).unwrap();
    }
    let settings = FitSettings::default();
    let records = [record];
    let once = || fit(black_box(&structure), &parameters, &[], black_box(&records), &settings).unwrap();
    let fitted = once();
    assert!(fitted.converged, "the search ends");
    let (clock, begin) = (Clock::new(), Instant::now());
    let mut times = Vec::new();
    while begin.elapsed().as_secs_f64() < MEASURED_S {
        let from_s = clock.seconds();
        black_box(once());
        times.push(clock.seconds() - from_s);
    }
    times.sort_by(f64::total_cmp);
    println!("milliseconds_per_fit {:.4}", 1e3 * times[times.len() / 2]);
    println!("iterations {}", fitted.iterations);
    println!("cost {:?}", fitted.cost);
    for (j, (theta, std)) in fitted.theta.iter().zip(&fitted.std_cramer_rao).enumerate() {
        println!("theta_{j} {theta:?}\nstd_{j} {std:?}");
    }
}
