//! One stepwise pass and a whole publication (six equations and modes), beside stepwise by Cholesky.

use crate::flight::Flight;
use crate::ledger::{Ledger, group};
use crate::regression::Smoothed;
use crate::textbook_regression::{Depth, Equation, P, Sums, stepwise};
use criterion::Criterion;
use nalgebra::{Matrix4, SVector};
use sideslip::flight::derivative::{Axis, Variable};
use sideslip::realtime::modes::stage;
use sideslip::realtime::regression::candidate::{REGRESSORS, is_primary, regressor, response};
use sideslip::realtime::regression::config::RegressionConfig;
use sideslip::realtime::regression::information::Information;
use sideslip::realtime::regression::stepwise::{Fit, Offer, Thresholds, fit};
use std::hint::black_box;

const F_ENTER: f64 = 12.0;
const F_REMOVE: f64 = 8.0;

/// What an axis is offered, in both forms.
struct Offered {
    response: usize,
    offer: Offer,
    primary: Vec<usize>,
    optional: Vec<usize>,
}

fn offered(axis: Axis) -> Offered {
    let mut offer = Offer::NONE;
    let (mut primary, mut optional) = (Vec::new(), Vec::new());
    for variable in Variable::ALL {
        let place = regressor(variable);
        if is_primary(axis, variable) {
            offer.primary[place] = true;
            primary.push(place);
        } else {
            offer.optional[place] = true;
            optional.push(place);
        }
    }
    Offered { response: response(axis), offer, primary, optional }
}

fn theirs(sums: &Sums, offered: &Offered, depth: Depth) -> Equation {
    stepwise(sums, offered.response, &offered.primary, &offered.optional, F_ENTER, F_REMOVE, depth).unwrap()
}

fn ours(information: &Information<{ crate::textbook_regression::N }>, offered: &Offered) -> Fit {
    fit(information, offered.response, &offered.offer, &Thresholds { f_enter: F_ENTER, f_remove: F_REMOVE }).unwrap()
}

/// Lateral matrix from the textbook's Y, L and N equations, and its roots.
fn roots(equations: &[Equation], u0: f64, w0: f64, theta0: f64) -> f64 {
    let mut a = Matrix4::zeros();
    for (equation, row) in [(1, 0), (3, 1), (5, 3)] {
        let Equation { terms, theta, .. } = &equations[equation];
        for (term, theta) in terms.iter().zip(theta) {
            match term {
                2 => a[(row, 0)] = *theta,
                4 => a[(row, 1)] = *theta,
                6 => a[(row, 3)] = *theta,
                _ => {}
            }
        }
    }
    a[(0, 1)] += w0;
    a[(0, 2)] = 9.80665 * theta0.cos();
    a[(0, 3)] -= u0;
    a[(2, 1)] = 1.0;
    a[(2, 3)] = theta0.tan();
    a.complex_eigenvalues().iter().map(|root| root.im).fold(0.0, f64::max)
}

/// Runs the group.
pub(crate) fn run(criterion: &mut Criterion, ledger: &Ledger, flight: &Flight) {
    let Smoothed { vectors, mut recursive, instruments } = Smoothed::of(flight);
    // The very vectors that the stage took: those from the excited part.
    let lambda = (-0.08_f64 / RegressionConfig::default().forgetting_s).exp();
    let (mut information, mut sums) = (Information::default(), Sums::new());
    for z in &vectors {
        information.add(z, lambda);
        sums.add(&SVector::from(*z), lambda);
    }
    let axes = Axis::ALL.map(offered);
    for offered in &axes {
        // Both fit the primary terms alike; beyond them the selections differ, for ours takes a second look.
        let mut primary = Offered { optional: Vec::new(), primary: offered.primary.clone(), ..*offered };
        primary.offer.optional = [false; REGRESSORS];
        let (ours, theirs) = (ours(&information, &primary), theirs(&sums, &primary, Depth::Coloured));
        assert_eq!(ours.order.as_slice(), theirs.terms.as_slice(), "the same terms in the same order");
        for ((&place, theta), std) in ours.order.iter().zip(&theirs.theta).zip(&theirs.std) {
            assert!((ours.theta[place] - theta).abs() < 1e-6 * theta.abs().max(1e-3), "{} {theta}", ours.theta[place]);
            let ratio = ours.cov[place][place].sqrt() / std;
            assert!((0.5..2.0).contains(&ratio), "standard errors of one size: {ratio}");
        }
    }
    let record = recursive.record(80.0, 80.0, &instruments);
    let modes = stage::step(&record, None, 0.0).dutch_roll.unwrap();
    assert!((modes.omega - 1.1).abs() < 0.2, "{modes:?}");
    assert_eq!(P, REGRESSORS);

    let yaw = &axes[Axis::N.index()];
    let mut group = group(criterion, "selection");
    ledger.bench(&mut group, "stepwise, one axis: ours", || {
        black_box(ours(&information, yaw));
    });
    ledger.bench(&mut group, "stepwise, one axis: Cholesky, white", || {
        black_box(theirs(&sums, yaw, Depth::White));
    });
    ledger.bench(&mut group, "stepwise, one axis: Cholesky, coloured", || {
        black_box(theirs(&sums, yaw, Depth::Coloured));
    });
    let mut time_s = 80.0;
    ledger.bench(&mut group, "publication: ours", || {
        time_s += 0.06;
        let derivatives = recursive.record(time_s, 0.06, &instruments);
        black_box(stage::step(&derivatives, None, 0.0));
    });
    for (name, depth) in [("publication: Cholesky, white", Depth::White), ("publication: Cholesky, coloured", Depth::Coloured)] {
        ledger.bench(&mut group, name, || {
            let equations: Vec<Equation> = axes.iter().map(|offered| theirs(&sums, offered, depth)).collect();
            black_box(roots(&equations, 51.3, 1.6, 0.031));
        });
    }
    group.finish();
    ledger.compare(
        "stepwise, one axis: ours",
        "stepwise, one axis: Cholesky, coloured",
        " (does less: no second look, standard errors from the residual's autocovariance alone)",
    );
    ledger.compare(
        "stepwise, one axis: ours",
        "stepwise, one axis: Cholesky, white",
        " (does less: no standard errors for coloured residuals)",
    );
    ledger.compare(
        "publication: ours",
        "publication: Cholesky, coloured",
        " (does less: the same, and no covariance across equations, no standard errors of the modes)",
    );
    ledger.compare(
        "publication: ours",
        "publication: Cholesky, white",
        " (does less still: no standard errors for coloured residuals)",
    );
}
