//! The information of one run: sums of squares and products of its whitened sensitivities and residuals.
//!
//! Consumes a simulated run and a whitening W with W'W = R^-1; produces, with T = W [S | v] stacked over the samples,
//!     T'T = [ S'R^-1 S   S'R^-1 v ; .   v'R^-1 v ]                                                  (1)
//! [columns + 1 square], in the order theta, x0, b, c, residual. An output that was not sampled has no row (`W` is then
//! diagonal).
//! Numerics: some forty rows are gathered before their products are summed, so that they stay in the processor's cache.

use super::discrete::{BLOCK, DiscreteStep, ModelMatrices, PreparedModel, SensitivityRows};
use super::run_parameters::RunParameters;
use super::simulated_outputs::{PreparedRun, SimulatedOutputs};
use crate::num::dense::Dense;

const ROWS: usize = 40;
const TILE: usize = 4;

/// The model at a point with its derivatives.
#[derive(Clone, Copy, Debug)]
pub struct SensitivityModel<'a> {
    /// Structure and sizes.
    pub prepared: &'a PreparedModel<'a>,
    /// The matrices.
    pub point: &'a ModelMatrices,
    /// Steps of this run, with derivatives.
    pub steps: &'a [DiscreteStep],
    /// Derivatives of the outputs.
    pub output_lines: &'a SensitivityRows,
}

impl SensitivityModel<'_> {
    /// Gives every sample's rows [dy | v] (outputs x stride, not whitened) to `take`.
    pub fn pass(
        &self,
        run: &PreparedRun,
        simulated: &SimulatedOutputs,
        run_parameters: &RunParameters,
        mut take: impl FnMut(usize, &[f64]),
    ) {
        let layout = &self.prepared.layout;
        let (n, m, outputs, stride) = (layout.states, layout.inputs, layout.outputs, layout.stride());
        let (columns, delays) = (layout.columns(), layout.delays.len());
        let mut s = vec![0.0; n * stride];
        for (place, &state) in layout.initial.iter().enumerate() {
            s[state * stride + layout.parameters + place] = 1.0;
        }
        let mut next = vec![0.0; n * stride];
        let mut rows = vec![0.0; outputs * stride];
        let mut z = vec![0.0; 2 * n + 2 * m + 1];
        z[n + 2 * m..2 * n + 2 * m].copy_from_slice(&run_parameters.state_bias);
        z[2 * n + 2 * m] = 1.0;
        let mut w = vec![1.0; n + m + 1];
        for k in 0..run.samples {
            let x = &simulated.states[k * n..(k + 1) * n];
            let u = &run.inputs[k * m..(k + 1) * m];
            let changes = &run.input_changes[k * delays..(k + 1) * delays];
            w[..n].copy_from_slice(x);
            w[n..n + m].copy_from_slice(u);
            for (o, row) in rows.chunks_exact_mut(stride).enumerate() {
                self.output_lines.row(o, &self.point.c[o * n..(o + 1) * n], &s, &w, row);
                for (delay, change) in layout.delays.iter().zip(changes) {
                    row[delay.parameter] += self.point.d[o * m + delay.input] * change;
                }
                row[columns] = simulated.residuals[k * outputs + o];
            }
            take(k, &rows);
            let Some(&which) = run.timeline.which.get(k) else { break };
            let step = &self.steps[which];
            z[..n].copy_from_slice(x);
            z[n..n + m].copy_from_slice(u);
            z[n + m..n + 2 * m].copy_from_slice(&run.inputs[(k + 1) * m..(k + 2) * m]);
            let later = &run.input_changes[(k + 1) * delays..(k + 2) * delays];
            for (i, row) in next.chunks_exact_mut(stride).enumerate() {
                step.lines.row(i, &step.phi[i * n..(i + 1) * n], &s, &z, row);
                for ((delay, now), later) in layout.delays.iter().zip(changes).zip(later) {
                    let at = i * m + delay.input;
                    row[delay.parameter] += step.gamma0[at] * now + step.gamma1[at] * later;
                }
            }
            core::mem::swap(&mut s, &mut next);
        }
    }

    /// (1): columns + 1 square.
    pub fn information(
        &self,
        run: &PreparedRun,
        simulated: &SimulatedOutputs,
        run_parameters: &RunParameters,
        whitening: &Whitening,
    ) -> Dense {
        let layout = &self.prepared.layout;
        let (stride, columns) = (layout.stride(), layout.columns());
        let mut sums = vec![0.0; stride * stride];
        let mut gathered = Vec::with_capacity((ROWS + layout.outputs) * stride);
        self.pass(run, simulated, run_parameters, |_, rows| {
            whitening.append(rows, stride, columns, &mut gathered);
            if gathered.len() >= ROWS * stride {
                add_squares(&gathered, stride, columns + 1, &mut sums);
                gathered.clear();
            }
        });
        add_squares(&gathered, stride, columns + 1, &mut sums);
        Dense::from_fn(columns + 1, columns + 1, |i, j| sums[i.min(j) * stride + i.max(j)])
    }
}

/// Adds rows' products, upper triangle by tiles.
pub(crate) fn add_squares(rows: &[f64], stride: usize, columns: usize, sums: &mut [f64]) {
    for top in (0..columns).step_by(TILE) {
        for left in (top..columns).step_by(TILE) {
            let mut tile = [[0.0; TILE]; TILE];
            for row in rows.chunks_exact(stride) {
                let (Some(a), Some(b)) = (row[top..].first_chunk::<TILE>(), row[left..].first_chunk::<TILE>()) else { continue };
                for (line, a) in tile.iter_mut().zip(a) {
                    for (sum, b) in line.iter_mut().zip(b) {
                        *sum += a * b;
                    }
                }
            }
            for (i, line) in tile.iter().enumerate() {
                for (j, value) in line.iter().enumerate() {
                    sums[(top + i) * stride + left + j] += value;
                }
            }
        }
    }
}

/// W with W'W = R^-1.
#[derive(Clone, Debug, PartialEq)]
pub enum Whitening {
    /// One factor for each output: uncorrelated noise.
    Diagonal(Vec<f64>),
    /// The inverse of the lower Cholesky factor; all outputs at once or none.
    Full(Dense),
}

impl Whitening {
    /// Appends W rows where they were sampled.
    fn append(&self, rows: &[f64], stride: usize, residual: usize, out: &mut Vec<f64>) {
        debug_assert!(stride.is_multiple_of(BLOCK));
        match self {
            Whitening::Diagonal(factors) => {
                for (row, factor) in rows.chunks_exact(stride).zip(factors) {
                    if row[residual].is_finite() {
                        out.extend(row.iter().map(|x| factor * x));
                    }
                }
            }
            Whitening::Full(factor) => {
                if rows.chunks_exact(stride).any(|row| !row[residual].is_finite()) {
                    return;
                }
                for o in 0..factor.rows() {
                    let begin = out.len();
                    out.resize(begin + stride, 0.0);
                    for (&factor, row) in factor.row(o)[..=o].iter().zip(rows.chunks_exact(stride)) {
                        for (out, x) in out[begin..].iter_mut().zip(row) {
                            *out += factor * x;
                        }
                    }
                }
            }
        }
    }

    /// R^-1.
    pub fn inverse_cov(&self) -> Dense {
        match self {
            Whitening::Diagonal(factors) => {
                let n = factors.len();
                Dense::from_fn(n, n, |i, j| if i == j { factors[i] * factors[i] } else { 0.0 })
            }
            Whitening::Full(factor) => factor.transposed().times(factor),
        }
    }
}
