//! Instrumental variables against two-stage least squares of stored rows, and over flights in gusts.

use crate::flight::derivative::{Axis, Variable};
use crate::realtime::regression::candidate::{BIAS, Coefficients, REGRESSORS, SIGNALS, regressor, response};
use crate::realtime::regression::coloured_errors;
use crate::realtime::regression::information::Information;
use crate::realtime::regression::instrumental::Instruments;
use nalgebra::DMatrix;
use std::vec::Vec as Rows;

/// Normal numbers by the sum of twelve uniform ones of a linear congruential generator.
struct Normals(u64);

impl Normals {
    fn next(&mut self) -> f64 {
        let mut uniform = || {
            self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (self.0 >> 11) as f64 / (1u64 << 53) as f64
        };
        (0..12).map(|_| uniform()).sum::<f64>() - 6.0
    }
}

/// N_v, N_r, N_pedal.
const TRUTH: [f64; 3] = [0.04, -0.6, -9.0];
const TERMS: [Variable; 3] = [Variable::V, Variable::R, Variable::Pedal];
const INTERVAL_S: f64 = 0.08;

/// Yaw and sideslip in gusts that act through both equations, a pilot who answers yaw rate and sideslip, and a 3211 of the
/// pedal; at rest for the first and the last instants.
fn flight(seed: u64, gusts: f64, pilot: f64) -> Rows<[f64; SIGNALS]> {
    let mut normals = Normals(seed);
    let (mut v, mut r, mut gust, mut feedback) = (0.0, 0.0, 0.0, 0.0);
    let mut rows = Rows::new();
    let mut seen = [[0.0; 2]; 3];
    for k in 0..440usize {
        let flying = (20..420).contains(&k);
        gust = 0.97 * gust + if flying { 0.24 * gusts * normals.next() } else { 0.0 };
        let input = match k {
            40..66 => 0.02,
            66..84 => -0.02,
            84..92 => 0.02,
            92..100 => -0.02,
            _ => 0.0,
        };
        feedback += 0.3 * (pilot * (0.06 * seen[2][1] + 0.001 * seen[2][0]) - feedback);
        seen = [[v, r], seen[0], seen[1]];
        let pedal = input + feedback;
        let acceleration = TRUTH[0] * (v + gust) + TRUTH[1] * r + TRUTH[2] * pedal;
        let side_force = -0.15 * (v + gust);
        let mut z = [0.0; SIGNALS];
        z[BIAS] = 1.0;
        if flying {
            z[regressor(Variable::V)] = v;
            z[regressor(Variable::R)] = r;
            z[regressor(Variable::Pedal)] = pedal;
            z[response(Axis::Y)] = side_force;
            z[response(Axis::N)] = acceleration + 1e-4 * normals.next();
        }
        rows.push(z);
        if flying {
            v += INTERVAL_S * (side_force - 50.0 * r);
            r += INTERVAL_S * acceleration;
        }
    }
    rows
}

fn information(rows: &[[f64; SIGNALS]]) -> Information<SIGNALS> {
    let mut information = Information::EMPTY;
    rows.iter().for_each(|z| information.add(z, 1.0));
    information
}

fn order() -> Rows<usize> {
    core::iter::once(BIAS).chain(TERMS.map(regressor)).collect()
}

/// A signal `lag` instants ago at every row, zero before the first.
fn column(rows: &[[f64; SIGNALS]], place: usize, lag: usize) -> Rows<f64> {
    (0..rows.len()).map(|k| k.checked_sub(lag).map_or(0.0, |then| rows[then][place])).collect()
}

fn matrix(columns: &[Rows<f64>]) -> DMatrix<f64> {
    DMatrix::from_fn(columns[0].len(), columns.len(), |k, j| columns[j][k])
}

#[test]
fn lagged_products_give_two_stage_least_squares_of_the_stored_rows() {
    let rows = flight(7, 1.0, 1.0);
    let pedal = regressor(Variable::Pedal);
    // (1) by least squares of the stored rows.
    let places = [Variable::V, Variable::P, Variable::R].map(regressor).into_iter().chain([response(Axis::Y), pedal]);
    let places: Rows<usize> = places.filter(|&place| rows.iter().any(|z| z[place] != 0.0)).collect();
    let mut predictors = std::vec![column(&rows, BIAS, 0)];
    predictors.extend(
        [2, 4, 6]
            .into_iter()
            .flat_map(|lag| places.iter().map(move |&place| (place, lag)))
            .map(|(place, lag)| column(&rows, place, lag)),
    );
    let (x, d) = (matrix(&predictors), matrix(&[column(&rows, pedal, 0)]));
    let weights = (x.transpose() * &x).lu().solve(&(x.transpose() * &d)).unwrap();
    let innovation = &d - &x * weights;
    // (2) and (3).
    let mut instruments = std::vec![column(&rows, BIAS, 0)];
    instruments.extend(
        [0, 2, 4, 6, 8, 10]
            .map(|lag| (0..rows.len()).map(|k| k.checked_sub(lag).map_or(0.0, |then| innovation[then])).collect::<Rows<f64>>()),
    );
    let z = matrix(&instruments);
    let x = matrix(&order().iter().map(|&place| column(&rows, place, 0)).collect::<Rows<_>>());
    let y = matrix(&[column(&rows, response(Axis::N), 0)]);
    let first_stage = (z.transpose() * &z).lu().solve(&(z.transpose() * &x)).unwrap();
    let predicted = &z * first_stage;
    let theta = (predicted.transpose() * &x).lu().solve(&(predicted.transpose() * y)).unwrap();
    let information = information(&rows);
    let found = Instruments::new(&information).unwrap().estimate(&information, &order(), response(Axis::N)).unwrap();
    for (i, &place) in order().iter().enumerate() {
        let (found, known, std) = (found.theta[place], theta[i], found.cov[place][place].sqrt());
        assert!((found - known).abs() < 0.02 * std, "term {i}: {found} for {known} (standard error {std})");
    }
}

/// Of 60 flights: root mean square of the errors in standard errors, by least squares and by instrumental variables.
fn scores(gusts: f64, pilot: f64) -> ([f64; 3], [f64; 3]) {
    let mut squares = [[0.0; 3]; 2];
    for seed in 1..=60 {
        let information = information(&flight(seed, gusts, pilot));
        let order = order();
        let x = DMatrix::from_fn(4, 4, |i, j| information.sums()[order[i]][order[j]]).try_inverse().unwrap();
        let against = DMatrix::from_fn(4, 1, |i, _| information.sums()[order[i]][response(Axis::N)]);
        let least = &x * against;
        let mut residual: Coefficients = [0.0; SIGNALS];
        residual[response(Axis::N)] = 1.0;
        let mut dispersion = [[0.0; REGRESSORS]; REGRESSORS];
        for (i, &a) in order.iter().enumerate() {
            residual[a] = -least[i];
            order.iter().enumerate().for_each(|(j, &b)| dispersion[a][b] = x[(i, j)]);
        }
        let cov = coloured_errors::equation_covariance(&information, &order, &dispersion, &residual);
        let other = Instruments::new(&information).unwrap().estimate(&information, &order, response(Axis::N)).unwrap();
        for (n, &place) in order.iter().skip(1).enumerate() {
            squares[0][n] += (least[n + 1] - TRUTH[n]).powi(2) / cov[place][place];
            squares[1][n] += (other.theta[place] - TRUTH[n]).powi(2) / other.cov[place][place];
        }
    }
    let [least, instrumental] = squares.map(|sums| sums.map(|sum: f64| (sum / 60.0).sqrt()));
    (least, instrumental)
}

#[test]
fn in_gusts_with_a_pilot_least_squares_is_biased_and_instruments_are_not() {
    for (gusts, pilot) in [(1.0, 0.0), (1.0, 1.0)] {
        let (least, instrumental) = scores(gusts, pilot);
        std::eprintln!("gusts {gusts}, pilot {pilot}: least squares {least:?}, instrumental variables {instrumental:?}");
        assert!(least[0] > 2.0, "N_v by least squares: {least:?}");
        // 60 right standard errors: 1 +- 0.09.
        assert!(instrumental.iter().all(|score| *score < 1.3), "{instrumental:?}");
    }
}

#[test]
fn what_fewer_instruments_than_terms_do_not_tell_is_not_known() {
    let mut rows = flight(7, 1.0, 0.0);
    let mut normals = Normals(5);
    // Six more regressors that no input moves.
    let others = [Variable::U, Variable::W, Variable::P, Variable::Q, Variable::LonCyclic, Variable::Collective];
    for z in &mut rows[20..420] {
        others.iter().for_each(|&variable| z[regressor(variable)] = 1e-4 * normals.next());
    }
    let information = information(&rows);
    let order: Rows<usize> = order().into_iter().chain(others.map(regressor)).collect();
    let found = Instruments::new(&information).unwrap().estimate(&information, &order, response(Axis::N)).unwrap();
    let unknown = others.iter().filter(|&&variable| {
        let place = regressor(variable);
        // The whole response would not be out of its error.
        found.cov[place][place].sqrt() * 1e-4 > 0.1
    });
    assert!(unknown.count() >= 3, "{:?}", others.map(|variable| found.cov[regressor(variable)][regressor(variable)]));
}

#[test]
fn without_a_control_that_moves_there_are_no_instruments() {
    let mut rows = flight(3, 1.0, 0.0);
    rows.iter_mut().for_each(|z| z[regressor(Variable::Pedal)] = 0.0);
    assert!(Instruments::new(&information(&rows)).is_none());
}
