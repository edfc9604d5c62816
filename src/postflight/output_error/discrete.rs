//! One step of the model from sample to sample, exact for inputs that are straight between them, and its derivatives.
//!
//! Consumes the matrices at a point and an interval h; produces the step
//!     x_(k+1) = Phi x_k + G0 u_k + G1 u_(k+1) + Psi1 b                                              (1)
//!     G0 = (Psi1 - Psi2/h) B,   G1 = Psi2 B/h                                                       (2)
//! with Phi, Psi1, Psi2 of `exponential`. The unknowns are the columns of every sensitivity, in the order theta, x0, b, c:
//!     S_(k+1) = Phi S_k + sum_l z_l dG_l,   z = (x_k, u_k, u_(k+1), b, 1)                           (3)
//!     dy_k    = C S_k + sum_l w_l dH_l,     w = (x_k, u_k, 1)                                       (4)
//! `SensitivityRows` holds the dG and dH without their zeros, in blocks of [`BLOCK`] columns.
//! Intervals are distinct to a nanosecond; each distinct one costs one set of integrals.

use super::exponential::integrals;
use super::model::{InputDelay, InputOutputRecord, MatrixEntry, ModelStructure};
use crate::num::product::add_product;

/// Columns that are taken at once.
pub const BLOCK: usize = 8;

/// Sizes, and which column belongs to which unknown.
#[derive(Clone, Debug, PartialEq)]
#[expect(missing_docs, reason = "fields are what their names say")]
pub struct UnknownLayout {
    pub states: usize,
    pub inputs: usize,
    pub outputs: usize,
    /// Parameters of all runs.
    pub parameters: usize,
    /// States whose initial value is free.
    pub initial: Vec<usize>,
    /// State equations with a bias.
    pub state_bias: Vec<usize>,
    /// Outputs with a bias.
    pub output_bias: Vec<usize>,
    /// Delayed inputs.
    pub delays: Vec<InputDelay>,
}

fn chosen(flags: &[bool]) -> Vec<usize> {
    flags.iter().enumerate().filter(|(_, on)| **on).map(|(i, _)| i).collect()
}

impl UnknownLayout {
    /// Of a structure that has been checked.
    pub fn new(structure: &ModelStructure, parameters: usize, delays: &[InputDelay]) -> Self {
        UnknownLayout {
            states: structure.states.len(),
            inputs: structure.inputs.len(),
            outputs: structure.outputs.len(),
            parameters,
            initial: chosen(&structure.initial_state),
            state_bias: chosen(&structure.state_bias),
            output_bias: chosen(&structure.output_bias),
            delays: delays.to_vec(),
        }
    }

    /// Run parameters.
    pub fn run_parameter_count(&self) -> usize {
        self.initial.len() + self.state_bias.len() + self.output_bias.len()
    }

    /// All columns: theta and one run's own.
    pub fn columns(&self) -> usize {
        self.parameters + self.run_parameter_count()
    }

    /// Columns with one more for the residual, rounded up to whole blocks.
    pub fn stride(&self) -> usize {
        (self.columns() + 1).div_ceil(BLOCK) * BLOCK
    }

    /// First column of the biases of state equations.
    pub fn state_bias_at(&self) -> usize {
        self.parameters + self.initial.len()
    }

    /// First column of the biases of outputs.
    pub fn output_bias_at(&self) -> usize {
        self.state_bias_at() + self.state_bias.len()
    }
}

/// Distinct intervals of a record, and which of them follows each sample.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Timeline {
    /// Lengths, s.
    pub distinct_s: Vec<f64>,
    /// By sample but the last: place in `distinct_s`.
    pub which: Vec<usize>,
}

impl Timeline {
    /// Of times that increase.
    pub fn new(record: &InputOutputRecord) -> Self {
        let mut line = Timeline::default();
        let mut known = std::collections::BTreeMap::new();
        for (before, after) in record.times_s.iter().zip(record.times_s.iter().skip(1)) {
            let interval = after - before;
            let key = libm::round(interval * 1e9) as i64;
            let place = *known.entry(key).or_insert_with(|| {
                line.distinct_s.push(interval);
                line.distinct_s.len() - 1
            });
            line.which.push(place);
        }
        line
    }
}

/// Rows of derivatives without their zeros: by output row and block of columns, which factor z_l and where its numbers are.
#[derive(Clone, Debug, Default)]
pub struct SensitivityRows {
    /// By row and block: first of its items (one more at the end).
    starts: Vec<usize>,
    /// Factor and block of numbers.
    items: Vec<(usize, [f64; BLOCK])>,
    blocks: usize,
}

impl SensitivityRows {
    /// From full rows: `full[(row * factors + l) * stride + column]`.
    fn new(full: &[f64], rows: usize, factors: usize, stride: usize) -> Self {
        let blocks = stride / BLOCK;
        let mut lines = SensitivityRows { starts: vec![0], items: Vec::new(), blocks };
        for row in 0..rows {
            for block in 0..blocks {
                for factor in 0..factors {
                    let from = (row * factors + factor) * stride + block * BLOCK;
                    let numbers: [f64; BLOCK] = core::array::from_fn(|i| full[from + i]);
                    if numbers.iter().any(|&x| x != 0.0) {
                        lines.items.push((factor, numbers));
                    }
                }
                lines.starts.push(lines.items.len());
            }
        }
        lines
    }

    /// `out = matrix S + lines z` for one row; `s` is states x stride.
    #[inline]
    pub fn row(&self, row: usize, matrix_row: &[f64], s: &[f64], z: &[f64], out: &mut [f64]) {
        let stride = self.blocks * BLOCK;
        for (block, out) in out.as_chunks_mut::<BLOCK>().0.iter_mut().enumerate() {
            let mut sum = [0.0; BLOCK];
            for (&factor, line) in matrix_row.iter().zip(s.chunks_exact(stride)) {
                if let Some(line) = line.as_chunks::<BLOCK>().0.get(block) {
                    for (sum, value) in sum.iter_mut().zip(line) {
                        *sum += factor * value;
                    }
                }
            }
            let at = row * self.blocks + block;
            for (l, line) in &self.items[self.starts[at]..self.starts[at + 1]] {
                let factor = z[*l];
                for (sum, value) in sum.iter_mut().zip(line) {
                    *sum += factor * value;
                }
            }
            *out = sum;
        }
    }
}

/// One step (1) of a given length.
#[derive(Clone, Debug)]
pub struct DiscreteStep {
    /// Phi, states x states.
    pub phi: Vec<f64>,
    /// G0, states x inputs.
    pub gamma0: Vec<f64>,
    /// G1, states x inputs.
    pub gamma1: Vec<f64>,
    /// Psi1, states x states.
    pub psi1: Vec<f64>,
    /// Derivatives (3); empty where they were not asked for.
    pub lines: SensitivityRows,
}

/// The matrices at a point.
#[derive(Clone, Debug)]
pub struct ModelMatrices {
    /// A, states x states.
    pub a: Vec<f64>,
    /// B, states x inputs.
    pub b: Vec<f64>,
    /// C, outputs x states.
    pub c: Vec<f64>,
    /// D, outputs x inputs.
    pub d: Vec<f64>,
}

fn values(matrix: &[Vec<MatrixEntry>], theta: &[f64]) -> Vec<f64> {
    matrix.iter().flatten().map(|entry| entry.value(theta)).collect()
}

/// Derivative of a matrix by one parameter.
fn derivative(matrix: &[Vec<MatrixEntry>], parameter: usize) -> Vec<f64> {
    let of = |entry: &MatrixEntry| entry.terms.iter().filter(|(j, _)| *j == parameter).map(|(_, factor)| factor).sum();
    matrix.iter().flatten().map(of).collect()
}

fn is_in(matrix: &[f64]) -> bool {
    matrix.iter().any(|&x| x != 0.0)
}

/// A structure with the derivatives of its matrices, which are the same at every point.
#[derive(Clone, Debug)]
pub struct PreparedModel<'a> {
    /// What is fitted.
    pub structure: &'a ModelStructure,
    /// Its sizes.
    pub layout: UnknownLayout,
    /// Parameters in A, with dA.
    pub(crate) da: Vec<(usize, Vec<f64>)>,
    pub(crate) db: Vec<(usize, Vec<f64>)>,
    pub(crate) dc: Vec<(usize, Vec<f64>)>,
    dd: Vec<(usize, Vec<f64>)>,
}

impl<'a> PreparedModel<'a> {
    /// Of a structure that has been checked.
    pub fn new(structure: &'a ModelStructure, layout: UnknownLayout) -> Self {
        let of = |matrix: &[Vec<MatrixEntry>]| -> Vec<(usize, Vec<f64>)> {
            (0..layout.parameters).map(|j| (j, derivative(matrix, j))).filter(|(_, d)| is_in(d)).collect()
        };
        let (da, db, dc, dd) = (of(&structure.a), of(&structure.b), of(&structure.c), of(&structure.d));
        PreparedModel { structure, layout, da, db, dc, dd }
    }

    /// The matrices at theta.
    pub fn at(&self, theta: &[f64]) -> ModelMatrices {
        let s = self.structure;
        ModelMatrices { a: values(&s.a, theta), b: values(&s.b, theta), c: values(&s.c, theta), d: values(&s.d, theta) }
    }

    /// One step for every distinct interval.
    pub fn steps(&self, point: &ModelMatrices, timeline: &Timeline, with_derivatives: bool) -> Vec<DiscreteStep> {
        timeline.distinct_s.iter().map(|&h| self.step(point, h, with_derivatives)).collect()
    }

    fn step(&self, point: &ModelMatrices, h: f64, with_derivatives: bool) -> DiscreteStep {
        let (n, m, stride) = (self.layout.states, self.layout.inputs, self.layout.stride());
        let directions: Vec<Vec<f64>> =
            if with_derivatives { self.da.iter().map(|(_, d)| d.clone()).collect() } else { Vec::new() };
        let (value, changes) = integrals(&point.a, n, h, &directions);
        let early = |psi1: &[f64], psi2: &[f64]| -> Vec<f64> { psi1.iter().zip(psi2).map(|(one, two)| one - two / h).collect() };
        let late = |psi2: &[f64]| -> Vec<f64> { psi2.iter().map(|two| two / h).collect() };
        let (first, last) = (early(&value.psi1, &value.psi2), late(&value.psi2));
        let gamma0 = product(&first, &point.b, n, n, m);
        let gamma1 = product(&last, &point.b, n, n, m);
        if !with_derivatives {
            return DiscreteStep { phi: value.phi, gamma0, gamma1, psi1: value.psi1, lines: SensitivityRows::default() };
        }
        let factors = 2 * n + 2 * m + 1;
        let mut full = vec![0.0; n * factors * stride];
        let mut add = |matrix: &[f64], columns: usize, from: usize, column: usize| {
            for i in 0..n {
                for l in 0..columns {
                    full[(i * factors + from + l) * stride + column] += matrix[i * columns + l];
                }
            }
        };
        for ((j, _), change) in self.da.iter().zip(&changes) {
            add(&change.phi, n, 0, *j);
            add(&product(&early(&change.psi1, &change.psi2), &point.b, n, n, m), m, n, *j);
            add(&product(&late(&change.psi2), &point.b, n, n, m), m, n + m, *j);
            add(&change.psi1, n, n + 2 * m, *j);
        }
        for (j, db) in &self.db {
            add(&product(&first, db, n, n, m), m, n, *j);
            add(&product(&last, db, n, n, m), m, n + m, *j);
        }
        for (place, &state) in self.layout.state_bias.iter().enumerate() {
            let column: Vec<f64> = (0..n).map(|i| value.psi1[i * n + state]).collect();
            add(&column, 1, 2 * n + 2 * m, self.layout.state_bias_at() + place);
        }
        let lines = SensitivityRows::new(&full, n, factors, stride);
        DiscreteStep { phi: value.phi, gamma0, gamma1, psi1: value.psi1, lines }
    }

    /// Derivatives (4) of the outputs.
    pub fn output_lines(&self) -> SensitivityRows {
        let (n, m, stride) = (self.layout.states, self.layout.inputs, self.layout.stride());
        let factors = n + m + 1;
        let outputs = self.layout.outputs;
        let mut full = vec![0.0; outputs * factors * stride];
        for (list, columns, from) in [(&self.dc, n, 0), (&self.dd, m, n)] {
            for (j, matrix) in list {
                for o in 0..outputs {
                    for l in 0..columns {
                        full[(o * factors + from + l) * stride + j] += matrix[o * columns + l];
                    }
                }
            }
        }
        for (place, &output) in self.layout.output_bias.iter().enumerate() {
            full[(output * factors + n + m) * stride + self.layout.output_bias_at() + place] += 1.0;
        }
        SensitivityRows::new(&full, outputs, factors, stride)
    }

    /// Inputs that a parameter multiplies, each with the places of those parameters.
    pub fn parameters_of_input(&self, input: usize) -> Vec<usize> {
        let m = self.layout.inputs;
        let acts = |list: &[(usize, Vec<f64>)]| -> Vec<usize> {
            let touches = |matrix: &[f64]| matrix.iter().skip(input).step_by(m).any(|&x| x != 0.0);
            list.iter().filter(|(_, matrix)| touches(matrix)).map(|(j, _)| *j).collect()
        };
        let delays = self.layout.delays.iter().filter(|delay| delay.input == input).map(|delay| delay.parameter);
        let mut all: Vec<usize> = acts(&self.db).into_iter().chain(acts(&self.dd)).chain(delays).collect();
        all.sort_unstable();
        all.dedup();
        all
    }
}

/// `left right`, with `left` \[rows x inner\] and `right` \[inner x columns\].
fn product(left: &[f64], right: &[f64], rows: usize, inner: usize, columns: usize) -> Vec<f64> {
    let mut out = vec![0.0; rows * columns];
    add_product(left, right, inner, columns, &mut out);
    out
}
