//! The filter beside independent answers: central differences, and the joint density by its whole covariance.

use super::filter::{KinematicNoise, Prepared, pass};
use super::fit::active;
use super::motion::{STATES, observe, rate};
use super::noise::first_guess;
use super::parameter::{INPUTS, OUTPUT_CHANNELS, OUTPUTS, TIMING, Theta};
use super::run_channels::RunChannels;
use crate::flight::channel::Channel;
use crate::flight::run::RunGeometry;
use crate::flight::sample::Sample;
use nalgebra::{DMatrix, DVector};

/// A motion that obeys the kinematics, integrated in steps of 1 ms from smooth inputs, read without error at 50 Hz.
pub(crate) fn flown() -> RunChannels {
    let input = |t: f64| {
        let s = |a: f64, w: f64| a * libm::sin(w * t);
        [1.0 + s(0.3, 1.1), s(0.8, 1.7), -9.7 + s(1.0, 2.1), s(0.2, 1.3) + s(0.1, 3.0), s(0.08, 1.9), s(0.12, 1.5) + s(0.05, 2.6)]
    };
    let mut x = [60.0, 0.5, 4.0, 0.02, 0.07, 0.3, 1000.0, 0.0];
    let (h, channels) = (1e-3, [Channel::Ax, Channel::Ay, Channel::Az, Channel::P, Channel::Q, Channel::R]);
    let mut samples = Vec::new();
    for k in 0..12_000 {
        let t = h * f64::from(k);
        if k % 20 == 0 {
            let mut sample = Sample::new(t);
            channels.into_iter().zip(input(t)).for_each(|(channel, value)| sample.set(channel, value));
            let omega = [input(t)[3], input(t)[4], input(t)[5]];
            for (output, channel) in OUTPUT_CHANNELS.into_iter().enumerate() {
                let rho = if (1..3).contains(&output) { [5.0, 0.0, 0.5] } else { [0.0; 3] };
                sample.set(channel, observe(output, &x, omega, rho).unwrap().value);
            }
            samples.push(sample);
        }
        let f = rate(&x, &input(t)).unwrap();
        let middle = core::array::from_fn(|i| x[i] + 0.5 * h * f[i]);
        let f = rate(&middle, &input(t + 0.5 * h)).unwrap();
        (0..STATES).for_each(|i| x[i] += h * f[i]);
    }
    RunChannels::of(&samples, &RunGeometry { vane_position_m: [5.0, 0.0, 0.5], ..RunGeometry::DEFAULT })
}

fn noise(record: &RunChannels) -> KinematicNoise {
    let mut noise = first_guess(record);
    noise.input = [1e-4, 1e-4, 1e-4, 1e-7, 1e-7, 1e-7];
    noise.output = [0.09, 4e-6, 4e-6, 4e-6, 4e-6, 1.6e-5, 0.25];
    noise
}

/// Every sensitivity beside central differences of the whole filter, without lags and with some.
#[test]
fn sensitivities_are_those_of_central_differences() {
    let record = flown();
    let noise = noise(&record);
    let all = active(&record);
    let mut lagging = Theta::NONE;
    for measured in [2, 5, INPUTS + 1, INPUTS + 2, INPUTS + 3] {
        lagging.lag[measured] = true;
        lagging.values[TIMING + measured] = 0.05;
    }
    for theta in [Theta::NONE, lagging] {
        let central = pass(&Prepared::of(&record, &theta), &noise, &all, false).unwrap();
        for (column, &index) in all.iter().enumerate() {
            let at = |by: f64| {
                let mut moved = theta.clone();
                moved.values[index] += by;
                pass(&Prepared::of(&record, &moved), &noise, &[], false).unwrap().innovations
            };
            let step = 1e-4;
            let (up, down) = (at(step), at(-step));
            let rows = central.rows.chunks(all.len());
            let (mut size, mut off) = (0.0, 0.0);
            for (row, (up, down)) in rows.zip(up.iter().zip(&down)) {
                let wanted = -(up.whitened - down.whitened) / (2.0 * step);
                size += wanted * wanted;
                off += (row[column] - wanted) * (row[column] - wanted);
            }
            assert!(off <= 0.0025 * size + 1e-9, "parameter {index}: {off:e} of {size:e}");
        }
    }
}

/// Bank alone: a walk driven by the gyro's noise, read with noise. Its density by the whole covariance at once:
/// cov(z_i, z_j) = P0 + q min(t_i, t_j) + R (i = j).
#[test]
fn the_cost_is_that_of_the_joint_density() {
    let samples: Vec<Sample> = (0..30)
        .map(|k| {
            let mut sample = Sample::new(0.1 * f64::from(k));
            let wiggle = libm::sin(7.3 * f64::from(k * k));
            sample.set(Channel::P, 0.1 * wiggle);
            sample.set(Channel::Q, 1e-9 * wiggle);
            sample.set(Channel::R, 1e-9 * f64::from(k));
            sample.set(Channel::Phi, 0.01 * libm::cos(3.1 * f64::from(k)));
            sample
        })
        .collect();
    let record = RunChannels::of(&samples, &RunGeometry::DEFAULT);
    let noise = KinematicNoise { input: [0.0, 0.0, 0.0, 1e-3, 0.0, 0.0], climb: 0.0, output: [1e-4; OUTPUTS] };
    let found = pass(&Prepared::of(&record, &Theta::NONE), &noise, &[], true).unwrap().cost;
    let readings = record.readings(&Theta::NONE);
    let phi: Vec<(usize, f64)> =
        (0..record.mesh.nodes).flat_map(|node| readings.at(node).iter().map(move |one| (node, one.value))).collect();
    let start = record.start(0, &Theta::NONE)[3];
    let mut mean = vec![start; record.mesh.nodes];
    for node in 1..record.mesh.nodes {
        let series = record.inputs[3].as_ref().unwrap();
        mean[node] = mean[node - 1] + record.mesh.step_s * series.mean(record.mesh.time_s(node - 1), record.mesh.time_s(node));
    }
    let n = phi.len();
    let mut covariance = DMatrix::zeros(n, n);
    for (i, (a, _)) in phi.iter().enumerate() {
        for (j, (b, _)) in phi.iter().enumerate() {
            let walked = 1e-3 * record.mesh.step_s * (*a.min(b)) as f64;
            covariance[(i, j)] = 0.25 + walked + if i == j { 1e-4 } else { 0.0 };
        }
    }
    let residual: Vec<f64> = phi.iter().map(|(node, value)| value - mean[*node]).collect();
    let weighted = covariance.clone().cholesky().unwrap().inverse() * DVector::from_vec(residual.clone());
    let squares: f64 = weighted.iter().zip(&residual).map(|(a, b)| a * b).sum();
    // The determinant by plain elimination.
    let mut log_determinant = 0.0;
    let mut rest = covariance.clone();
    for k in 0..n {
        log_determinant += f64::ln(rest[(k, k)]);
        for i in k + 1..n {
            let ratio = rest[(i, k)] / rest[(k, k)];
            for j in k..n {
                rest[(i, j)] -= ratio * rest[(k, j)];
            }
        }
    }
    assert!(n > 20 && (found - squares - log_determinant).abs() < 1e-4, "{found} {squares} {log_determinant}");
}
