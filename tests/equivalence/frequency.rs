//! The recursive Fourier regression against the slow obvious one: every instant stored, each transform integrated over the
//! whole record, least squares by singular values.

use crate::support::uniform::Uniform;
use nalgebra::{Complex, DMatrix, DVector};
use sideslip::flight::derivative::{Axis, Variable};
use sideslip::realtime::regression::candidate::{BIAS, REGRESSORS, SIGNALS, regressor, response};
use sideslip::realtime::regression::frequency::band::Band;
use sideslip::realtime::regression::frequency::estimate::{Estimate, Shared};
use sideslip::realtime::regression::frequency::transforms::Transforms;

const GRID_S: f64 = 0.08;
/// Parts of an interval for Simpson's rule.
const PARTS: usize = 120;

/// Everything that was seen: pieces without a hole, each of instants.
struct Stored {
    pieces: Vec<Vec<[f64; SIGNALS]>>,
    decay: f64,
    band: Band,
}

impl Stored {
    /// The real numbers of all transforms, Re of every frequency and then Im, of what `signal` makes of an instant, its slope and
    /// the time in its interval.
    fn transform(&self, signal: impl Fn(&[f64; SIGNALS], &[f64; SIGNALS], f64) -> f64) -> DVector<f64> {
        let mut sums = DVector::zeros(2 * self.band.count());
        self.over_time(|g, weight, now, next, part| sums += g * (weight * signal(now, next, part)));
        sums
    }

    /// Calls with the real and imaginary parts of g at every node of the integration.
    fn over_time(&self, mut call: impl FnMut(&DVector<f64>, f64, &[f64; SIGNALS], &[f64; SIGNALS], f64)) {
        let count = self.band.count();
        let intervals: usize = self.pieces.iter().map(|piece| piece.len() - 1).sum();
        let mut ago = intervals as f64 * GRID_S;
        for piece in &self.pieces {
            for two in piece.windows(2) {
                for node in 0..=PARTS {
                    let part = node as f64 / PARTS as f64;
                    let simpson = if node == 0 || node == PARTS { 1.0 } else { [2.0, 4.0][node % 2] };
                    let t = ago - part * GRID_S;
                    let g = DVector::from_fn(2 * count, |i, _| {
                        let rad_s = self.band.rad_s(i % count);
                        (-self.decay * t).exp() * if i < count { (rad_s * t).cos() } else { (rad_s * t).sin() }
                    });
                    call(&g, simpson * GRID_S / (3.0 * PARTS as f64), &two[0], &two[1], part);
                }
                ago -= GRID_S;
            }
        }
    }

    fn value(&self, place: usize) -> DVector<f64> {
        self.transform(|now, next, part| now[place] + part * (next[place] - now[place]))
    }

    fn response(&self, axis: Axis) -> DVector<f64> {
        let place = response(axis);
        if axis.is_force() {
            return self.value(place);
        }
        // The slope of the straight lines of the rate: no end is asked for.
        let rate = place - REGRESSORS - 3 + regressor(Variable::P);
        self.transform(|now, next, _| (next[rate] - now[rate]) / GRID_S)
    }

    fn columns(&self, places: &[usize]) -> DMatrix<f64> {
        DMatrix::from_columns(&places.iter().map(|&place| self.value(place)).collect::<Vec<_>>())
    }

    /// Estimates and standard errors: the error, white in time, through the very integrals.
    fn fit(&self, places: &[usize], y: &DVector<f64>) -> (DVector<f64>, DVector<f64>) {
        let x = self.columns(places);
        let inverse = x.clone().pseudo_inverse(1e-14).unwrap();
        let theta = &inverse * y;
        let residual = y - &x * &theta;
        let order = y.len();
        let mut error_cov = DMatrix::<f64>::zeros(order, order);
        self.over_time(|g, weight, _, _, _| error_cov.ger(weight, g, g, 1.0));
        let left = DMatrix::identity(order, order) - &x * &inverse;
        let intensity = residual.norm_squared() / (&left * &error_cov * left.transpose()).trace();
        let cov = &inverse * error_cov * inverse.transpose() * intensity;
        (theta, cov.diagonal().map(f64::sqrt))
    }
}

fn recursive(stored: &Stored, wanted: &[usize], axis: Axis) -> Estimate {
    let forgetting_s = 1.0 / stored.decay;
    let mut transforms = Transforms::new(stored.band, forgetting_s);
    for piece in &stored.pieces {
        transforms.hole();
        piece.iter().for_each(|z| transforms.add(z, GRID_S));
    }
    let mut offered = [false; REGRESSORS];
    wanted.iter().for_each(|&place| offered[place] = true);
    Shared::new(&transforms, &offered).fit(&transforms, axis, wanted).unwrap()
}

/// Signals that go from line to line, slowly enough for the band.
fn instants(uniform: &mut Uniform, count: usize) -> Vec<[f64; SIGNALS]> {
    let mut slow = [[0.0; SIGNALS]; 2];
    let mut one = || {
        let [fast, slow] = &mut slow;
        for (fast, slow) in fast.iter_mut().zip(slow.iter_mut()) {
            *fast = 0.8 * *fast + uniform.within(1.0);
            *slow = 0.7 * *slow + *fast;
        }
        let mut z = *slow;
        z[BIAS] = 1.0;
        z
    };
    (0..count).map(|_| one()).collect()
}

#[test]
fn recursion_is_the_batch_regression_over_the_stored_record() {
    let mut uniform = Uniform(91);
    let terms = [Variable::V, Variable::P, Variable::R, Variable::Pedal];
    let places: Vec<usize> = [BIAS].into_iter().chain(terms.map(regressor)).collect();
    for (decay, lengths, band) in [
        (1e-9, vec![130], Band::DEFAULT),
        (1.0 / 20.0, vec![130], Band::DEFAULT),
        (1.0 / 8.0, vec![60, 1, 70, 25], Band { from_hz: 0.2, to_hz: 2.0, step_hz: 0.1 }),
    ] {
        let pieces = lengths.iter().map(|&count| instants(&mut uniform, count)).collect();
        let stored = Stored { pieces, decay, band };
        for axis in [Axis::Y, Axis::N] {
            let found = recursive(&stored, &places, axis);
            let (theta, std) = stored.fit(&places, &stored.response(axis));
            for (i, &place) in places.iter().enumerate() {
                let what = format!("{axis:?} {place}, decay {decay}, pieces {lengths:?}");
                assert!((found.theta[place] - theta[i]).abs() < 1e-9 * theta[i].abs().max(std[i]), "{what}: {found:?} {theta}");
                assert!((found.std[place] / std[i] - 1.0).abs() < 1e-9, "{what}: {} {}", found.std[place], std[i]);
            }
        }
    }
}

/// A yawing motion of a cycle and a quarter, cut where the rate is largest, and the sideslip that its derivatives ask for.
fn yawing() -> Vec<[f64; SIGNALS]> {
    let [n_v, n_p, n_r, n_pedal] = TRUTH;
    let (omega, damping) = (1.25, 0.1);
    let at = |k: usize| {
        let t = GRID_S * k as f64;
        let envelope = (1.0 - (-2.0 * t).exp()) * (-damping * t).exp();
        let slope = 2.0 * (-2.0 * t).exp() * (-damping * t).exp() - damping * envelope;
        let (r, r_dot) =
            (0.1 * envelope * (omega * t).sin(), 0.1 * (slope * (omega * t).sin() + envelope * omega * (omega * t).cos()));
        let pedal = 0.02 * (-(t - 1.5) * (t - 1.5)).exp() - 0.02 * (-(t - 3.5) * (t - 3.5) / 0.5).exp();
        let p = 0.05 * (1.0 - (-t).exp()) * (1.9 * t + 0.4).cos();
        let mut z = [0.0; SIGNALS];
        z[BIAS] = 1.0;
        z[regressor(Variable::R)] = r;
        z[regressor(Variable::P)] = p;
        z[regressor(Variable::Pedal)] = pedal;
        z[regressor(Variable::V)] = (r_dot - n_p * p - n_r * r - n_pedal * pedal) / n_v;
        z
    };
    (0..=78).map(at).collect()
}

const TRUTH: [f64; 4] = [0.0176, -0.155, -0.664, -9.93];

#[test]
fn without_the_ends_of_the_record_the_estimates_are_biased_and_with_them_not() {
    let stored = Stored { pieces: vec![yawing()], decay: 1e-9, band: Band::DEFAULT };
    let places = [Variable::V, Variable::P, Variable::R, Variable::Pedal].map(regressor);
    let found = recursive(&stored, &places, Axis::N);
    let count = stored.band.count();
    let rates = stored.value(regressor(Variable::R));
    let standard = DVector::from_fn(2 * count, |i, _| {
        // In this form time is counted back from the end: j w X.
        let x = Complex::new(rates[i % count], rates[count + i % count]) * Complex::new(0.0, stored.band.rad_s(i % count));
        if i < count { x.re } else { x.im }
    });
    let (without, _) = stored.fit(&places, &standard);
    let mut worst: f64 = 0.0;
    for (i, truth) in TRUTH.into_iter().enumerate() {
        let (with, without) = (found.theta[places[i]] / truth - 1.0, without[i] / truth - 1.0);
        eprintln!("{:?}: {:+.3} % with the ends, {:+.1} % without", places[i], 100.0 * with, 100.0 * without);
        assert!(with.abs() < 0.02, "{with}");
        worst = worst.max(without.abs());
    }
    assert!(worst > 0.2, "{worst}");
}
