//! Filter error against a slow one from the book: matrices whole, the likelihood minimised by differences; and where there is
//! nothing to filter against output error.

use crate::support::short_period::{Noise, TRUTH, normal, parameters, record, structure};
use crate::support::uniform::Uniform;
use nalgebra::{DMatrix, DVector};
use sideslip::postflight::output_error;
use sideslip::postflight::output_error::filter_error;
use sideslip::postflight::output_error::filter_error::Disturbances;
use sideslip::postflight::output_error::{FitSettings, InputOutputRecord, MatrixEntry, RunParameters};

const TIGHT: FitSettings = FitSettings {
    iterations: 100,
    tolerance: 1e-9,
    noise: output_error::NoiseCovariance::Diagonal,
    delay_grid: true,
    watch: None,
};
const STEP_S: f64 = 0.05;
const STATES: usize = 2;

fn values(matrix: &[Vec<MatrixEntry>], theta: &[f64]) -> DMatrix<f64> {
    DMatrix::from_fn(matrix.len(), matrix[0].len(), |i, j| matrix[i][j].value(theta))
}

/// Phi, and the integrals of it and of its integral, by their series.
fn integrals(a: &DMatrix<f64>, h: f64) -> [DMatrix<f64>; 3] {
    let one = DMatrix::<f64>::identity(STATES, STATES);
    let mut sums = [one.clone(), &one * h, &one * (0.5 * h * h)];
    let mut power = one;
    let mut factorial = 1.0;
    for k in 1..25 {
        power = &power * a * h;
        factorial *= f64::from(k);
        let (k1, k2) = (f64::from(k + 1), f64::from(k + 2));
        sums[0] += &power / factorial;
        sums[1] += &power * (h / (factorial * k1));
        sums[2] += &power * (h * h / (factorial * k1 * k2));
    }
    sums
}

/// Unknowns: theta 6, ln q by gust 2, ln r by output 3, then by run w(0), q(0), the bias of q' and that of az.
fn cost(unknowns: &[f64], records: &[InputOutputRecord], density: f64) -> f64 {
    let structure = structure();
    let theta = &unknowns[..6];
    let [a, b, c, d] = [&structure.a, &structure.b, &structure.c, &structure.d].map(|matrix| values(matrix, theta));
    let [phi, psi1, psi2] = integrals(&a, STEP_S);
    let gusts = DMatrix::from_diagonal(&DVector::from_fn(STATES, |i, _| unknowns[6 + i].exp()));
    let q = &psi1 * (gusts + &b * density * b.transpose()) * psi1.transpose() / STEP_S;
    let r = DMatrix::from_diagonal(&DVector::from_fn(3, |i, _| unknowns[8 + i].exp()));
    let mut cost = 0.0;
    for (run, record) in records.iter().enumerate() {
        let own = &unknowns[11 + 4 * run..15 + 4 * run];
        let (mut x, mut p) = (DVector::from_row_slice(&own[..2]), DMatrix::zeros(STATES, STATES));
        let bias = DVector::from_row_slice(&[0.0, own[2]]);
        for k in 0..record.times_s.len() {
            let u = record.inputs[0][k];
            let there: Vec<usize> = (0..3).filter(|&o| record.outputs[o][k].is_finite()).collect();
            if !there.is_empty() {
                let c = c.select_rows(&there);
                let foretold = |o: usize, at: usize| (c.row(at) * &x)[0] + d[(o, 0)] * u + if o == 2 { own[3] } else { 0.0 };
                let v = DVector::from_fn(there.len(), |at, _| record.outputs[there[at]][k] - foretold(there[at], at));
                let s = &c * &p * c.transpose() + r.select_rows(&there).select_columns(&there);
                let inverse = s.clone().try_inverse().unwrap();
                cost += 0.5 * ((v.transpose() * &inverse * &v)[0] + s.determinant().ln());
                let gain = &p * c.transpose() * inverse;
                x += &gain * v;
                p -= &gain * s * gain.transpose();
            }
            if k + 1 < record.times_s.len() {
                let (late, slope) = (record.inputs[0][k + 1], (record.inputs[0][k + 1] - u) / STEP_S);
                assert!(late.is_finite());
                x = &phi * x + &psi1 * (b.column(0) * u + &bias) + &psi2 * b.column(0) * slope;
                p = &phi * p * phi.transpose() + &q;
            }
        }
    }
    cost
}

/// Newton's method on differences from a place nearby; values and the square roots of the inverse curvature's diagonal.
fn minimum(mut unknowns: Vec<f64>, cost: impl Fn(&[f64]) -> f64) -> Vec<f64> {
    let n = unknowns.len();
    let steps: Vec<f64> = unknowns.iter().map(|x| 2e-4 * x.abs().max(0.05)).collect();
    let at = |unknowns: &[f64], moves: &[(usize, f64)]| {
        let mut moved = unknowns.to_vec();
        moves.iter().for_each(|&(j, by)| moved[j] += by);
        cost(&moved)
    };
    // Five points: differences of three alone would leave 1e-6.
    let slope = |unknowns: &[f64], j: usize| {
        let h = steps[j];
        let far = at(unknowns, &[(j, 2.0 * h)]) - at(unknowns, &[(j, -2.0 * h)]);
        (8.0 * (at(unknowns, &[(j, h)]) - at(unknowns, &[(j, -h)])) - far) / (12.0 * h)
    };
    let hessian = DMatrix::from_fn(n, n, |i, j| {
        let (h, k) = (steps[i], steps[j]);
        let sum = |a: f64, b: f64| at(&unknowns, &[(i, a * h), (j, b * k)]);
        (sum(1.0, 1.0) - sum(1.0, -1.0) - sum(-1.0, 1.0) + sum(-1.0, -1.0)) / (4.0 * h * k)
    });
    let inverse = hessian.try_inverse().unwrap();
    for _ in 0..6 {
        let step = &inverse * DVector::from_fn(n, |j, _| slope(&unknowns, j));
        unknowns.iter_mut().zip(step.iter()).for_each(|(x, step)| *x -= step);
    }
    unknowns
}

/// Two runs whose states were disturbed; the first output is sampled at every other instant.
fn disturbed_runs(strength: f64) -> Vec<InputOutputRecord> {
    let mut uniform = Uniform(21);
    let white = Noise { std: [0.002, 0.003, 0.02], colour: 0.0 };
    let mut runs = Vec::new();
    for (samples, pulse_s) in [(160_u32, 0.5), (140, 0.7)] {
        let times = (0..samples).map(|k| STEP_S * f64::from(k)).collect();
        let own =
            RunParameters { initial_state: vec![0.01, -0.02], state_bias: vec![0.0, 0.03], output_bias: vec![0.0, 0.0, 0.1] };
        let mut run = record(times, pulse_s, &own, &white, &mut uniform);
        // What white accelerations add, sample by sample.
        let s = structure();
        let (a, c) = (values(&s.a, &TRUTH), values(&s.c, &TRUTH));
        let [phi, psi1, _] = integrals(&a, STEP_S);
        let mut x = DVector::zeros(STATES);
        for k in 0..run.times_s.len() {
            let y = &c * &x;
            (0..3).for_each(|o| run.outputs[o][k] += y[o]);
            let w = DVector::from_fn(STATES, |_, _| strength * normal(&mut uniform) / STEP_S.sqrt());
            x = &phi * x + &psi1 * w;
        }
        run.outputs[0].iter_mut().skip(1).step_by(2).for_each(|z| *z = f64::NAN);
        runs.push(run);
    }
    runs
}

fn relative(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b).abs() / b.abs()).fold(0.0, f64::max)
}

#[test]
fn gusts_and_noisy_inputs_are_the_slow_answer() {
    let (records, density) = (disturbed_runs(0.01), 1e-8);
    let inputs = records.iter().map(|record| vec![vec![density; record.times_s.len() - 1]]).collect();
    let disturbances = Disturbances { gusts: vec![0, 1], inputs };
    let start = output_error::fit(&structure(), &parameters(0.2), &[], &records, &TIGHT).unwrap();
    let (found, gusts) = filter_error::fit(&structure(), &parameters(0.2), &[], &records, &disturbances, &TIGHT, &start).unwrap();
    assert!(found.converged);
    let mut ours = found.theta.clone();
    ours.extend(gusts.gusts.iter().map(|gust| gust.density.ln()));
    ours.extend(found.noise_cov.diagonal().iter().map(|r| r.ln()));
    for run in &found.runs {
        ours.extend([
            run.run_parameters.initial_state[0],
            run.run_parameters.initial_state[1],
            run.run_parameters.state_bias[1],
            run.run_parameters.output_bias[2],
        ]);
    }
    let ours_cost = cost(&ours, &records, density);
    assert!((ours_cost - found.cost).abs() < 1e-9 * found.cost.abs(), "{ours_cost} {}", found.cost);
    // From somewhere else, so that standing still would show.
    let begin: Vec<f64> = ours.iter().map(|x| x + 1e-3 * x.abs().max(0.01)).collect();
    let slow = minimum(begin, |unknowns| cost(unknowns, &records, density));
    let apart = relative(&found.theta, &slow[..6]);
    eprintln!("estimates apart by {apart:.1e}, densities' logarithms by {:.1e}", relative(&ours[6..11], &slow[6..11]));
    assert!(apart < 1e-6 && relative(&ours[6..11], &slow[6..11]) < 1e-5, "{ours:?} {slow:?}");
    // Without gusts in the model their power is taken for noise of the outputs.
    assert!(start.noise_cov.diagonal()[1] > 1.3 * found.noise_cov.diagonal()[1], "{:?}", start.noise_cov);
}

#[test]
fn without_disturbances_it_is_output_error() {
    let records = disturbed_runs(0.0);
    let start = output_error::fit(&structure(), &parameters(0.2), &[], &records, &TIGHT).unwrap();
    for gusts in [vec![], vec![0, 1]] {
        let disturbances = Disturbances { gusts, inputs: Vec::new() };
        let fit = filter_error::fit(&structure(), &parameters(0.2), &[], &records, &disturbances, &TIGHT, &start);
        let (found, disturbed) = fit.unwrap();
        let none = disturbed.gusts.iter().all(|gust| gust.density <= 0.0);
        eprintln!("{:?}: {:.1e}", disturbed.gusts, relative(&found.theta, &start.theta));
        if none {
            assert!(relative(&found.theta, &start.theta) < 1e-7 && relative(&found.std_cramer_rao, &start.std_cramer_rao) < 1e-7);
            assert!((found.cost - start.cost).abs() < 1e-7, "{} {}", found.cost, start.cost);
        }
        // A gust that chance made up changes nothing by more than a small part of its error.
        let moved = (0..6).map(|j| (found.theta[j] - start.theta[j]).abs() / start.std[j]).fold(0.0, f64::max);
        assert!(found.cost < start.cost + 1e-7 && moved < 0.3, "{moved}");
    }
}
