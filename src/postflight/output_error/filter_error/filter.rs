//! A Kalman filter over one run, with the derivatives of the innovations and of their variances by every unknown.
//!
//! Consumes the matrices of the model with its discrete steps and noise; gives, for every measured value in turn,
//!     v = z - c x - d u - bias,   s = c P c' + r,   K = P c'/s,   x <- x + K v,   P <- P - K K' s           (1)
//!     x <- Phi x + G0 u_k + G1 u_(k+1) + Psi1 b,   P <- Phi P Phi' + Q   from sample to sample               (2)
//! and, by the product rule on every line, dv and ds. P(0) = 0: the initial state is among the unknowns. The values of one sample
//! are processed one after the other, which for uncorrelated noise of the outputs equals a joint update and needs no inverse.
//! Source: R. V. Jategaonkar, Flight Vehicle System Identification, 2nd ed., 2015, ch. 5; the derivatives of the variances are
//! kept as well, so the gradient is exact.

use super::discrete_noise::DiscreteNoise;
use crate::num::product::{dot, set_product, set_product_by_transpose};
use crate::postflight::output_error::discrete::{DiscreteStep, ModelMatrices, PreparedModel, SensitivityRows};
use crate::postflight::output_error::run_parameters::RunParameters;
use crate::postflight::output_error::simulated_outputs::PreparedRun;

pub(crate) struct SensitivityFilter<'a> {
    pub(crate) prepared: &'a PreparedModel<'a>,
    pub(crate) point: &'a ModelMatrices,
    pub(crate) output_lines: &'a SensitivityRows,
    /// By output.
    pub(crate) noise: &'a [f64],
    /// Column of ln r_0.
    pub(crate) noise_column: usize,
    /// Inputs with noise, as in the spreads.
    pub(crate) inputs: &'a [usize],
}

/// One measured value against what was predicted.
pub(crate) struct ScalarInnovation<'a> {
    pub(crate) sample: usize,
    pub(crate) output: usize,
    pub(crate) v: f64,
    pub(crate) s: f64,
    /// -dv by column; empty without derivatives.
    pub(crate) change: &'a [f64],
    /// Columns of `variance_changes`.
    pub(crate) columns: &'a [usize],
    pub(crate) variance_changes: &'a [f64],
}

impl SensitivityFilter<'_> {
    /// Goes through a run. `noise_densities` are by input and interval; without `derivatives` the steps need none either.
    pub(crate) fn run(
        &self,
        run: &PreparedRun,
        run_parameters: &RunParameters,
        (steps, spreads): (&[DiscreteStep], &[DiscreteNoise]),
        noise_densities: &[Vec<f64>],
        derivatives: bool,
        mut take: impl FnMut(&ScalarInnovation<'_>),
    ) {
        let layout = &self.prepared.layout;
        let (n, m, outputs, stride) = (layout.states, layout.inputs, layout.outputs, layout.stride());
        let delays = layout.delays.len();
        // Columns on which variances depend: those of the spreads, of C, and of r.
        let mut columns: Vec<usize> = Vec::new();
        if derivatives {
            columns.extend(spreads.iter().flat_map(|spread| spread.changes.iter().map(|change| change.column)));
            columns.extend(self.prepared.dc.iter().map(|(j, _)| *j));
            columns.extend(self.noise_column..self.noise_column + outputs);
            columns.sort_unstable();
            columns.dedup();
        }
        let place = |column: usize| columns.binary_search(&column).unwrap_or(usize::MAX);
        let in_spread: Vec<Vec<Option<usize>>> = spreads
            .iter()
            .map(|spread| {
                let of = |column: &usize| spread.changes.iter().position(|change| change.column == *column);
                columns.iter().map(of).collect()
            })
            .collect();
        let mut dc: Vec<Option<&[f64]>> = vec![None; columns.len()];
        if derivatives {
            self.prepared.dc.iter().for_each(|(j, d)| dc[place(*j)] = Some(d));
        }
        let square = n * n;
        let (mut x, mut next) = (run_parameters.initial_state.clone(), vec![0.0; n]);
        let (mut p, mut swap, mut half) = (vec![0.0; square], vec![0.0; square], vec![0.0; square]);
        let mut dp = vec![0.0; columns.len() * square];
        let wide = if derivatives { stride } else { 0 };
        let (mut s, mut s_next) = (vec![0.0; n * wide], vec![0.0; n * wide]);
        if derivatives {
            for (place, &state) in layout.initial.iter().enumerate() {
                s[state * stride + layout.parameters + place] = 1.0;
            }
        }
        let (mut h, mut gain, mut dh) = (vec![0.0; n], vec![0.0; n], vec![0.0; n]);
        let (mut dy, mut ds) = (vec![0.0; wide], vec![0.0; columns.len()]);
        let mut z = vec![0.0; 2 * n + 2 * m + 1];
        z[n + 2 * m..2 * n + 2 * m].copy_from_slice(&run_parameters.state_bias);
        z[2 * n + 2 * m] = 1.0;
        let mut w = vec![1.0; n + m + 1];
        let forced: Vec<Vec<f64>> = steps
            .iter()
            .map(|step| step.psi1.chunks_exact(n.max(1)).map(|row| dot(row, &run_parameters.state_bias)).collect())
            .collect();
        for k in 0..run.samples {
            let u = &run.inputs[k * m..(k + 1) * m];
            let changes = &run.input_changes[k * delays..(k + 1) * delays];
            for o in 0..outputs {
                let measured = run.outputs[k * outputs + o];
                if !measured.is_finite() {
                    continue;
                }
                let c = &self.point.c[o * n..(o + 1) * n];
                let v = measured - (run_parameters.output_bias[o] + dot(c, &x) + dot(&self.point.d[o * m..(o + 1) * m], u));
                for (i, h) in h.iter_mut().enumerate() {
                    *h = dot(&p[i * n..(i + 1) * n], c);
                }
                let variance = dot(c, &h) + self.noise[o];
                gain.iter_mut().zip(&h).for_each(|(gain, h)| *gain = h / variance);
                if derivatives {
                    w[..n].copy_from_slice(&x);
                    w[n..n + m].copy_from_slice(u);
                    self.output_lines.row(o, c, &s, &w, &mut dy);
                    for (delay, change) in layout.delays.iter().zip(changes) {
                        dy[delay.parameter] += self.point.d[o * m + delay.input] * change;
                    }
                    for i in 0..n {
                        let row = &mut s[i * stride..(i + 1) * stride];
                        row.iter_mut().zip(&dy).for_each(|(s, dy)| *s -= gain[i] * dy);
                    }
                    for (at, &column) in columns.iter().enumerate() {
                        let dp = &mut dp[at * square..(at + 1) * square];
                        for i in 0..n {
                            dh[i] = dot(&dp[i * n..(i + 1) * n], c);
                        }
                        let mut change = dot(c, &dh);
                        if let Some(dc) = dc[at].map(|dc| &dc[o * n..(o + 1) * n]) {
                            change += 2.0 * dot(dc, &h);
                            for i in 0..n {
                                dh[i] += dot(&p[i * n..(i + 1) * n], dc);
                            }
                        }
                        if column == self.noise_column + o {
                            change += self.noise[o];
                        }
                        ds[at] = change;
                        for i in 0..n {
                            s[i * stride + column] += (dh[i] - gain[i] * change) / variance * v;
                            for j in 0..n {
                                dp[i * n + j] -= dh[i] * gain[j] + gain[i] * dh[j] - gain[i] * gain[j] * change;
                            }
                        }
                    }
                }
                take(&ScalarInnovation {
                    sample: k,
                    output: o,
                    v,
                    s: variance,
                    change: &dy,
                    columns: &columns,
                    variance_changes: &ds,
                });
                for i in 0..n {
                    x[i] += gain[i] * v;
                    for j in 0..n {
                        p[i * n + j] -= h[i] * gain[j];
                    }
                }
            }
            let Some(&which) = run.timeline.which.get(k) else { break };
            let (step, spread) = (&steps[which], &spreads[which]);
            let densities =
                || self.inputs.iter().map(move |&l| noise_densities.get(l).and_then(|s| s.get(k)).copied().unwrap_or(0.0));
            let later = &run.inputs[(k + 1) * m..(k + 2) * m];
            if derivatives {
                z[..n].copy_from_slice(&x);
                z[n..n + m].copy_from_slice(u);
                z[n + m..n + 2 * m].copy_from_slice(later);
                let late = &run.input_changes[(k + 1) * delays..(k + 2) * delays];
                for (i, row) in s_next.chunks_exact_mut(stride).enumerate() {
                    step.lines.row(i, &step.phi[i * n..(i + 1) * n], &s, &z, row);
                    for ((delay, now), late) in layout.delays.iter().zip(changes).zip(late) {
                        let at = i * m + delay.input;
                        row[delay.parameter] += step.gamma0[at] * now + step.gamma1[at] * late;
                    }
                }
                core::mem::swap(&mut s, &mut s_next);
                for (at, dp) in dp.chunks_exact_mut(square.max(1)).enumerate() {
                    let change = in_spread[which][at].map(|place| &spread.changes[place]);
                    // dP <- T Phi' + Phi T' + dQ with T = Phi dP/2 + dPhi P.
                    set_product(&step.phi, dp, n, n, &mut half);
                    half.iter_mut().for_each(|x| *x *= 0.5);
                    if let Some(change) = change.filter(|change| !change.phi.is_empty()) {
                        set_product(&change.phi, &p, n, n, &mut swap);
                        half.iter_mut().zip(&swap).for_each(|(sum, x)| *sum += x);
                    }
                    set_product_by_transpose(&half, &step.phi, n, &mut swap);
                    for i in 0..n {
                        for j in 0..n {
                            dp[i * n + j] = swap[i * n + j] + swap[j * n + i];
                        }
                    }
                    if let Some(change) = change {
                        change.add_to(densities(), dp);
                    }
                }
            }
            set_product(&step.phi, &p, n, n, &mut half);
            set_product_by_transpose(&half, &step.phi, n, &mut p);
            spread.add_to(densities(), &mut p);
            for (i, slot) in next.iter_mut().enumerate() {
                *slot = forced[which][i]
                    + dot(&step.phi[i * n..(i + 1) * n], &x)
                    + dot(&step.gamma0[i * m..(i + 1) * m], u)
                    + dot(&step.gamma1[i * m..(i + 1) * m], later);
            }
            core::mem::swap(&mut x, &mut next);
        }
    }
}
