//! The structure of whole records against the recursive information matrix: row by row or all at once, the same numbers.

use crate::support::equation::{linear_candidates, rules_of_the_paper};
use crate::support::uniform::Uniform;
use sideslip::flight::channel::ControlNames;
use sideslip::flight::derivative::{Axis, Variable};
use sideslip::postflight::equation_error::design::{Bias, Design};
use sideslip::postflight::equation_error::expression::Expression;
use sideslip::postflight::equation_error::stepwise::select;
use sideslip::postflight::equation_error::table::RegressionTable;
use sideslip::realtime::regression::candidate::{BIAS, REGRESSORS, SIGNALS, regressor, response};
use sideslip::realtime::regression::coloured_errors;
use sideslip::realtime::regression::information::Information;
use sideslip::realtime::regression::stepwise::{Offer, Thresholds, fit};

const ROWS: usize = 700;

/// Signals of a lightly damped motion under controls, with noise, and a yawing acceleration of some of them.
fn vectors(seed: u64) -> Vec<[f64; SIGNALS]> {
    let mut random = Uniform(seed);
    let mut error = 0.0;
    (0..ROWS)
        .map(|k| {
            let t = 0.08 * k as f64;
            let mut z = [0.0; SIGNALS];
            z[BIAS] = 1.0;
            for (j, entry) in z.iter_mut().enumerate().take(REGRESSORS).skip(1) {
                *entry = (0.3 * j as f64 * t + j as f64).sin() * (1.0 + 0.02 * t) + random.within(0.2);
            }
            error = 0.7 * error + random.within(0.1);
            z[response(Axis::N)] = 0.9 * z[regressor(Variable::V)] - 0.5 * z[regressor(Variable::R)]
                + 0.2 * z[regressor(Variable::P)]
                - 1.4 * z[regressor(Variable::Pedal)]
                + error;
            z
        })
        .collect()
}

fn table(vectors: &[[f64; SIGNALS]]) -> RegressionTable {
    let column = |place: usize| -> Vec<f64> { vectors.iter().map(|z| z[place]).collect() };
    let mut columns: Vec<(&str, Vec<f64>)> = Variable::ALL
        .into_iter()
        .map(|variable| (variable.name(ControlNames::Rotorcraft), column(regressor(variable))))
        .collect();
    columns.push(("r_dot", column(response(Axis::N))));
    let columns: Vec<(&str, &[f64])> = columns.iter().map(|(name, values)| (*name, values.as_slice())).collect();
    let time_s: Vec<f64> = (0..vectors.len()).map(|k| 0.08 * k as f64).collect();
    let mut table = RegressionTable::new();
    table.add_record(&time_s, &columns).unwrap();
    table
}

#[test]
fn every_value_and_every_f_of_every_step_is_that_of_the_recursion() {
    for seed in 1..4 {
        let vectors = vectors(seed);
        let mut information = Information::<SIGNALS>::default();
        for z in &vectors {
            information.add(z, 1.0);
        }
        let table = table(&vectors);
        let candidates = linear_candidates(Axis::N);
        let mask = table.whole();
        let design = Design::new(&table, &Expression::parse("r_dot").unwrap(), &candidates, &mask, Bias::Shared).unwrap();
        let selection = select(&design, &rules_of_the_paper()).unwrap();
        assert!(selection.steps.len() > 5);
        let mut compared = 0;
        for step in selection.steps.iter().skip(1) {
            let mut offer = Offer::NONE;
            for term in &step.terms {
                offer.primary[1 + term.place] = true;
            }
            let thresholds = Thresholds { f_enter: 1.0, f_remove: 0.0 };
            let recursive = fit(&information, response(Axis::N), &offer, &thresholds).unwrap();
            let parameters = recursive.order.len();
            let residual =
                coloured_errors::residual_covariance(&information, &recursive.residual, &recursive.residual, parameters);
            let white = coloured_errors::white_covariance(&information, &recursive.dispersion, residual[0]);
            for term in &step.terms {
                let place = 1 + term.place;
                let value = recursive.theta[place];
                let f = value * value / white[place][place];
                assert!((term.value - value).abs() < 1e-9 * value.abs().max(1e-3), "{}: {} {value}", term.name, term.value);
                assert!((term.f_white - f).abs() < 1e-9 * f.max(1e-3), "{}: {} {f}", term.name, term.f_white);
                compared += 1;
            }
            let r_squared = 1.0 - recursive.squares / recursive.response_squares;
            assert!((step.quality.r_squared - r_squared).abs() < 1e-9);
            let f_total = r_squared / (parameters - 1) as f64 * (ROWS - parameters) as f64 / (1.0 - r_squared);
            assert!((step.quality.f_total - f_total).abs() < 1e-9 * f_total);
        }
        assert!(compared > 20);
    }
}
