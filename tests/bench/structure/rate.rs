//! Model structure: full subset search and stepwise regression of 480 rows and 12 candidates, times for `compare.py`.
//!
//! Writes the very problem as CSV where a path is given, so that the peer works on the same numbers, and prints one line
//! each: median microseconds from the raw table, its columns, sums and all, and what was found.

#![expect(clippy::unwrap_used, clippy::print_stdout, reason = "a benchmark stops where its data are wrong, and prints")]

use sideslip::postflight::equation_error::design::{Bias, CandidateTerm, Design};
use sideslip::postflight::equation_error::expression::Expression;
use sideslip::postflight::equation_error::stepwise::{StepwiseRules, select};
use sideslip::postflight::equation_error::subset::best_subsets;
use sideslip::postflight::equation_error::table::RegressionTable;
use std::fmt::Write;
use std::hint::black_box;
use std::time::Instant;

const ROWS: usize = 480;
const CANDIDATES: usize = 12;
const REPEATS: usize = 300;

/// Columns like those of an oscillating motion under controls, some of them alike, and a response of four of them.
fn columns() -> Vec<(String, Vec<f64>)> {
    let mut seed = 7_u64;
    let mut noise = move || {
        seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        ((seed >> 11) as f64 / (1_u64 << 53) as f64 - 0.5) * 3.46
    };
    let mut columns: Vec<(String, Vec<f64>)> = (0..CANDIDATES)
        .map(|j| {
            let rate = 0.02 * (1 + j) as f64;
            let column = (0..ROWS).map(|k| (rate * k as f64 + j as f64).sin() + 0.3 * noise());
            (format!("x{j}"), column.collect())
        })
        .collect();
    let mut error = 0.0;
    let y = (0..ROWS).map(|k| {
        error = 0.6 * error + 0.2 * noise();
        columns[1].1[k] - 0.8 * columns[4].1[k] + 0.5 * columns[7].1[k] - 0.3 * columns[10].1[k] + error
    });
    let y = ("y".to_owned(), y.collect());
    columns.push(y);
    columns
}

fn median(mut timed: impl FnMut()) -> f64 {
    let mut times: Vec<f64> = (0..REPEATS)
        .map(|_| {
            let begin = Instant::now();
            timed();
            begin.elapsed().as_secs_f64() * 1e6
        })
        .collect();
    times.sort_by(f64::total_cmp);
    times[REPEATS / 2]
}

fn main() {
    let columns = columns();
    if let Some(path) = std::env::args().nth(1).filter(|argument| !argument.starts_with("--")) {
        let mut text = String::new();
        for k in 0..ROWS {
            let row: Vec<String> = columns.iter().map(|(_, values)| values[k].to_string()).collect();
            writeln!(text, "{}", row.join(",")).unwrap();
        }
        std::fs::write(path, text).unwrap();
    }
    let borrowed: Vec<(&str, &[f64])> = columns.iter().map(|(name, values)| (name.as_str(), values.as_slice())).collect();
    let time_s: Vec<f64> = (0..ROWS).map(|k| 0.04 * k as f64).collect();
    let mut table = RegressionTable::new();
    table.add_record(&time_s, &borrowed).unwrap();
    let candidates: Vec<CandidateTerm> = (0..CANDIDATES).map(|j| CandidateTerm::offered(&format!("x{j}")).unwrap()).collect();
    let (response, mask) = (Expression::parse("y").unwrap(), table.whole());
    let design = || Design::new(black_box(&table), &response, &candidates, &mask, Bias::Shared).unwrap();
    let rules = StepwiseRules::for_candidates(CANDIDATES);
    let found = best_subsets(&design()).unwrap();
    let selection = select(&design(), &rules).unwrap();
    println!("design_us {:.1}", median(|| drop(black_box(design()))));
    println!("subsets_us {:.1}", median(|| drop(black_box(best_subsets(&design()).unwrap()))));
    println!("stepwise_us {:.1}", median(|| drop(black_box(select(&design(), &rules).unwrap()))));
    println!("triangles {}", found.triangles);
    let mut chosen: Vec<usize> = selection.fit.terms.iter().map(|term| term.place).collect();
    chosen.sort_unstable();
    let named = |places: &[usize]| places.iter().map(ToString::to_string).collect::<Vec<_>>().join("+");
    println!("stepwise_terms {}", named(&chosen));
    println!("best_of_four {}", named(&found.subsets[4].places));
    println!("squares_of_four {:.15e}", 1.0 - found.subsets[4].r_squared);
}
