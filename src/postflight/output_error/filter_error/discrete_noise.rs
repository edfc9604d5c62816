//! Process noise over one sampling interval, and its derivatives by the unknowns.
//!
//! Consumes the matrices of the model, an interval h (s) and the gusts' densities q; produces the covariance Q (states square)
//! that is added to P over the interval. A disturbance is constant over the interval, with the variance density/h, as the
//! straight lines of the inputs are:
//!     Q = sum_i q_i F_i + sum_l s_l H_l,   F_i = (Psi1 E_i)(Psi1 E_i)'/h,   H_l = (Psi1 B_l)(Psi1 B_l)'/h          (1)
//! and the derivatives of Phi, of sum q_i F_i and of H_l by every unknown on which they depend; of the gusts' part by ln q_i.

use crate::postflight::output_error::discrete::{ModelMatrices, PreparedModel};
use crate::postflight::output_error::exponential::integrals;

/// One unknown's part in it.
pub(crate) struct NoiseDerivative {
    pub(crate) column: usize,
    /// dPhi; empty where there is none.
    pub(crate) phi: Vec<f64>,
    /// Derivative of the gusts' part of Q; empty where there is none.
    gusts: Vec<f64>,
    /// Derivatives of H, by noisy input; empty where there are none.
    inputs: Vec<Vec<f64>>,
}

/// (1) for one interval.
pub(crate) struct DiscreteNoise {
    gusts: Vec<f64>,
    inputs: Vec<Vec<f64>>,
    pub(crate) changes: Vec<NoiseDerivative>,
}

/// Which disturbances there are, and where their unknowns stand.
pub(crate) struct NoiseSources<'a> {
    pub(crate) gusts: &'a [usize],
    /// q.
    pub(crate) densities: &'a [f64],
    /// Column of ln q_0.
    pub(crate) column: usize,
    /// Inputs with noise.
    pub(crate) inputs: &'a [usize],
}

/// `matrix x`, n x n.
fn image(matrix: &[f64], x: &[f64]) -> Vec<f64> {
    matrix.chunks_exact(x.len()).map(|row| row.iter().zip(x).map(|(a, b)| a * b).sum()).collect()
}

/// `out += factor (a b' + b a')/2`.
fn add_outer(a: &[f64], b: &[f64], factor: f64, out: &mut [f64]) {
    let n = a.len();
    for i in 0..n {
        for j in 0..n {
            out[i * n + j] += 0.5 * factor * (a[i] * b[j] + b[i] * a[j]);
        }
    }
}

fn column(matrix: &[f64], columns: usize, which: usize) -> Vec<f64> {
    matrix.iter().skip(which).step_by(columns.max(1)).copied().collect()
}

impl DiscreteNoise {
    /// At a point, for an interval.
    pub(crate) fn new(
        prepared: &PreparedModel<'_>,
        point: &ModelMatrices,
        h: f64,
        sources: &NoiseSources<'_>,
        with_changes: bool,
    ) -> Self {
        let (n, m) = (prepared.layout.states, prepared.layout.inputs);
        let directions: Vec<Vec<f64>> =
            if with_changes { prepared.da.iter().map(|(_, d)| d.clone()).collect() } else { Vec::new() };
        let (value, moved) = integrals(&point.a, n, h, &directions);
        let gust = |psi1: &[f64], state: usize| column(psi1, n, state);
        let mut spread = DiscreteNoise { gusts: vec![0.0; n * n], inputs: Vec::new(), changes: Vec::new() };
        for (&state, q) in sources.gusts.iter().zip(sources.densities) {
            let f = gust(&value.psi1, state);
            add_outer(&f, &f, q / h, &mut spread.gusts);
        }
        let of_input = |psi1: &[f64], b: &[f64], l: usize| image(psi1, &column(b, m, l));
        for &l in sources.inputs {
            let (f, mut own) = (of_input(&value.psi1, &point.b, l), vec![0.0; n * n]);
            add_outer(&f, &f, 1.0 / h, &mut own);
            spread.inputs.push(own);
        }
        if !with_changes {
            return spread;
        }
        for ((j, _), change) in prepared.da.iter().zip(&moved) {
            let mut gusts = vec![0.0; n * n];
            for (&state, q) in sources.gusts.iter().zip(sources.densities) {
                add_outer(&gust(&value.psi1, state), &gust(&change.psi1, state), 2.0 * q / h, &mut gusts);
            }
            let inputs = sources.inputs.iter().map(|&l| {
                let mut own = vec![0.0; n * n];
                let (f, df) = (of_input(&value.psi1, &point.b, l), of_input(&change.psi1, &point.b, l));
                add_outer(&f, &df, 2.0 / h, &mut own);
                own
            });
            spread.changes.push(NoiseDerivative { column: *j, phi: change.phi.clone(), gusts, inputs: inputs.collect() });
        }
        for (j, db) in &prepared.db {
            let inputs: Vec<Vec<f64>> = sources
                .inputs
                .iter()
                .map(|&l| {
                    let mut own = vec![0.0; n * n];
                    let (f, df) = (of_input(&value.psi1, &point.b, l), of_input(&value.psi1, db, l));
                    add_outer(&f, &df, 2.0 / h, &mut own);
                    own
                })
                .collect();
            if inputs.iter().flatten().any(|&x| x != 0.0) {
                spread.add(NoiseDerivative { column: *j, phi: Vec::new(), gusts: Vec::new(), inputs });
            }
        }
        for (place, (&state, q)) in sources.gusts.iter().zip(sources.densities).enumerate() {
            if *q > 0.0 {
                let (f, mut gusts) = (gust(&value.psi1, state), vec![0.0; n * n]);
                add_outer(&f, &f, q / h, &mut gusts);
                spread.changes.push(NoiseDerivative {
                    column: sources.column + place,
                    phi: Vec::new(),
                    gusts,
                    inputs: Vec::new(),
                });
            }
        }
        spread
    }

    /// Adds the part of a column that may have one already.
    fn add(&mut self, change: NoiseDerivative) {
        match self.changes.iter_mut().find(|known| known.column == change.column) {
            Some(known) => {
                for (sum, own) in known.inputs.iter_mut().zip(&change.inputs) {
                    sum.iter_mut().zip(own).for_each(|(sum, x)| *sum += x);
                }
            }
            None => self.changes.push(change),
        }
    }

    /// Q with the densities of the noisy inputs, added to `out`.
    pub(crate) fn add_to(&self, densities: impl Iterator<Item = f64>, out: &mut [f64]) {
        sum(&self.gusts, &self.inputs, densities, out);
    }
}

impl NoiseDerivative {
    /// dQ, likewise.
    pub(crate) fn add_to(&self, densities: impl Iterator<Item = f64>, out: &mut [f64]) {
        sum(&self.gusts, &self.inputs, densities, out);
    }
}

fn sum(gusts: &[f64], inputs: &[Vec<f64>], densities: impl Iterator<Item = f64>, out: &mut [f64]) {
    out.iter_mut().zip(gusts).for_each(|(out, x)| *out += x);
    for (own, s) in inputs.iter().zip(densities) {
        if s > 0.0 {
            out.iter_mut().zip(own).for_each(|(out, x)| *out += s * x);
        }
    }
}
