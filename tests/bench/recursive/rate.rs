//! Recursive regression: one more vector of 12 regressors and a response, times for `compare.py`.
//!
//! Writes the very problem as CSV where a path is given, and prints one line each: median nanoseconds of an update (the sums, and
//! those over 16 lags that give coloured standard errors), of an update and a solution after it, and the last solution.

#![expect(clippy::unwrap_used, clippy::print_stdout, reason = "a benchmark stops where its data are wrong, and prints")]

use sideslip::num::sweep::Swept;
use sideslip::realtime::regression::information::Information;
use std::fmt::Write;
use std::hint::black_box;
use std::time::Instant;

const REGRESSORS: usize = 12;
const N: usize = REGRESSORS + 1;
const ROWS: usize = 2000;
const REPEATS: usize = 41;
const LAMBDA: f64 = 0.999;

fn rows() -> Vec<[f64; N]> {
    let mut seed = 11_u64;
    let mut noise = move || {
        seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        ((seed >> 11) as f64 / (1_u64 << 53) as f64 - 0.5) * 3.46
    };
    (0..ROWS)
        .map(|k| {
            let mut row: [f64; N] = std::array::from_fn(|j| (0.02 * (1 + j) as f64 * k as f64 + j as f64).sin() + 0.3 * noise());
            row[REGRESSORS] = row[1] - 0.8 * row[4] + 0.5 * row[7] - 0.3 * row[10] + 0.2 * noise();
            row
        })
        .collect()
}

fn solution(information: &Information<N>) -> [f64; REGRESSORS] {
    let mut swept = Swept::new(*information.sums());
    for k in 0..REGRESSORS {
        assert!(swept.enter(k, 1e-9), "a regressor that is none");
    }
    std::array::from_fn(|k| swept.at(k, REGRESSORS))
}

/// Nanoseconds a row, median over the repeats.
fn median(rows: &[[f64; N]], mut row_by_row: impl FnMut(&mut Information<N>, &[f64; N])) -> f64 {
    let mut times: Vec<f64> = (0..REPEATS)
        .map(|_| {
            let mut information = Information::default();
            let begin = Instant::now();
            rows.iter().for_each(|row| row_by_row(&mut information, black_box(row)));
            black_box(&information);
            begin.elapsed().as_secs_f64() * 1e9 / rows.len() as f64
        })
        .collect();
    times.sort_by(f64::total_cmp);
    times[REPEATS / 2]
}

fn main() {
    let rows = rows();
    if let Some(path) = std::env::args().nth(1).filter(|argument| !argument.starts_with("--")) {
        let mut text = String::new();
        for row in &rows {
            let row: Vec<String> = row.iter().map(ToString::to_string).collect();
            writeln!(text, "{}", row.join(",")).unwrap();
        }
        std::fs::write(path, text).unwrap();
    }
    println!("update_ns {:.1}", median(&rows, |information, row| information.add(row, LAMBDA)));
    let mut added = 0_usize;
    let solved = median(&rows, |information, row| {
        information.add(row, LAMBDA);
        added += 1;
        if added % ROWS > 2 * REGRESSORS {
            black_box(solution(information));
        }
    });
    println!("update_and_solution_ns {solved:.1}");
    let mut information = Information::default();
    rows.iter().for_each(|row| information.add(row, LAMBDA));
    let last: Vec<String> = solution(&information).iter().map(|value| format!("{value:.15e}")).collect();
    println!("solution {}", last.join(","));
}
