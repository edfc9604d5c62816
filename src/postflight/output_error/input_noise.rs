//! Noise on the recorded inputs: what it adds to the covariance of the likelihood's gradient.
//!
//! Output error takes the recorded inputs for those that acted. Their noise n (white, variance s_i^2 of input i) drives the model
//! and not the aircraft, so that residuals contain the model's response to it, which resembles the sensitivities: the fit takes
//! most of it from the residuals, and their own autocovariance (`coloured_errors`) does not show it. With W_k = R^-1 S_k [outputs
//! x columns] the weighed sensitivities at sample k, its contribution to the gradient and the covariance of that are
//!     L_k = C'W_k + Phi_k'L_(k+1)                                                                   (1)
//!     h_ki = G0_k[:, i]'L_(k+1) + G1_(k-1)[:, i]'L_k + D[:, i]'W_k                                   (2)
//!     W_n = sum_k sum_i s_i^2 h_ki h_ki'                                                            (3)
//! (1) goes backwards from L_(N+1) = 0: it is the adjoint of (1) of `simulated_outputs`. An input that stands for N samples is
//! the mean of a control at rest (`resting_controls`): they have one error in common, of variance s_i^2/N, so that
//!     W_n = sum over stretches of s_i^2/N H H',   H = sum of h_ki over the stretch                   (4)
//! of which (3) is the case of stretches of one sample.
//! Source: ours; (3) is the propagation of the inputs' covariance through the linearised estimator.

use super::discrete::{DiscreteStep, ModelMatrices, UnknownLayout};
use super::simulated_outputs::PreparedRun;
use crate::num::dense::Dense;

/// (3) of a run. `weighed` has W by sample, output and column; `steps` are those of the run's distinct intervals.
pub(crate) fn gradient_cov(
    layout: &UnknownLayout,
    point: &ModelMatrices,
    steps: &[DiscreteStep],
    run: &PreparedRun,
    weighed: &[f64],
) -> Dense {
    let (n, m, outputs, columns) = (layout.states, layout.inputs, layout.outputs, layout.columns());
    let variance = |i: usize| run.input_noise_std.get(i).map_or(0.0, |std| std * std);
    let mut cov = Dense::zeros(columns, columns);
    if (0..m).all(|i| variance(i) == 0.0) {
        return cov;
    }
    let input = |k: usize, i: usize| run.inputs.get(k * m + i);
    let mut later = vec![0.0; n * columns];
    let mut now = vec![0.0; n * columns];
    // By input: H of the stretch so far, and its samples.
    let mut stretches: Vec<(Vec<f64>, f64)> = vec![(vec![0.0; columns], 0.0); m];
    for k in (0..run.samples).rev() {
        let w = &weighed[k * outputs * columns..(k + 1) * outputs * columns];
        let step = run.timeline.which.get(k).and_then(|&which| steps.get(which));
        now.fill(0.0);
        for (o, row) in w.chunks_exact(columns).enumerate() {
            for (state, out) in now.chunks_exact_mut(columns).enumerate() {
                add_scaled(point.c[o * n + state], row, out);
            }
        }
        if let Some(step) = step {
            for (to, row) in later.chunks_exact(columns).enumerate() {
                for (from, out) in now.chunks_exact_mut(columns).enumerate() {
                    add_scaled(step.phi[to * n + from], row, out);
                }
            }
        }
        let before = k.checked_sub(1).and_then(|k| run.timeline.which.get(k)).and_then(|&which| steps.get(which));
        for (i, (h, samples)) in stretches.iter_mut().enumerate().filter(|(i, _)| variance(*i) > 0.0) {
            for state in 0..n {
                if let Some(step) = step {
                    add_scaled(step.gamma0[state * m + i], &later[state * columns..(state + 1) * columns], h);
                }
                if let Some(before) = before {
                    add_scaled(before.gamma1[state * m + i], &now[state * columns..(state + 1) * columns], h);
                }
            }
            for (o, row) in w.chunks_exact(columns).enumerate() {
                add_scaled(point.d[o * m + i], row, h);
            }
            *samples += 1.0;
            if k == 0 || input(k - 1, i) != input(k, i) {
                let factor = variance(i) / *samples;
                for a in 0..columns {
                    for b in 0..columns {
                        cov[(a, b)] += factor * h[a] * h[b];
                    }
                }
                h.fill(0.0);
                *samples = 0.0;
            }
        }
        core::mem::swap(&mut now, &mut later);
    }
    cov
}

fn add_scaled(factor: f64, row: &[f64], out: &mut [f64]) {
    if factor != 0.0 {
        out.iter_mut().zip(row).for_each(|(sum, x)| *sum += factor * x);
    }
}
