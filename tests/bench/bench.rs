//! Benchmark: what one step of each kernel costs, beside the plain textbook form of the same, in one run.
//!
//! Method. One flight is computed beforehand (`flight`): a stable linear aircraft under multisine controls with noise from a
//! fixed seed, so every run of the benchmark sees the same numbers. Criterion times each piece in flat samples and gives its
//! own statistics; the durations of those very samples are kept, and the table at the end is the median of each piece over
//! the median of its textbook partner. A ratio below 1 means that ours is faster. Before anything is timed both sides run
//! over the same data and their answers are compared, so that no side is fast because it is wrong.
//! Both sides are built by the same compiler with the same flags. The textbook side is written as one would from a book
//! with nalgebra's fixed-size matrices, with nothing made slow on purpose; where it does less work than ours the table says so.
//!
//! Run with `cargo bench`; a filter (`cargo bench -- filter`) runs a part, and the table then shows that part.

#![expect(clippy::unwrap_used, clippy::print_stdout, reason = "a benchmark stops where its data are wrong, and prints")]

mod filter;
mod flight;
mod ledger;
mod level1;
mod live;
mod parts;
mod peer;
mod record_length;
mod regression;
mod selection;
mod smoother;
mod textbook;
mod textbook_regression;

use criterion::Criterion;
use ledger::Ledger;
use std::time::Duration;

/// Filter and smoother: samples a second, and how many there are of them.
const FAST_HZ: f64 = 256.0;
const FAST_SAMPLES: usize = 8192;
/// The regression and the length of a record.
const SLOW_HZ: f64 = 50.0;
const SLOW_SAMPLES: usize = 102_000;

fn main() {
    let mut criterion = Criterion::default()
        .without_plots()
        .sample_size(60)
        .warm_up_time(Duration::from_millis(600))
        .measurement_time(Duration::from_millis(2500))
        .configure_from_args();
    let ledger = Ledger::default();
    let fast = flight::Flight::fly(FAST_HZ, FAST_SAMPLES);
    let ticks = filter::ticks(&fast);
    filter::run(&mut criterion, &ledger, &ticks);
    smoother::run(&mut criterion, &ledger, &ticks);
    parts::run(&mut criterion, &ledger, &fast);
    let flight = flight::Flight::fly(SLOW_HZ, SLOW_SAMPLES);
    regression::run(&mut criterion, &ledger, &flight);
    selection::run(&mut criterion, &ledger, &flight);
    record_length::run(&mut criterion, &ledger, &flight);
    level1::run(&mut criterion, &ledger);
    live::run(&mut criterion, &ledger);
    criterion.final_summary();
    ledger.print();
}
