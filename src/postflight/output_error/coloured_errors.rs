//! Standard errors for coloured residuals: the covariance of the likelihood's gradient with the residuals' own autocovariance.
//!
//! Consumes a run at the end of the search: residuals v [samples x outputs] and output sensitivities S [outputs x columns] at
//! each sample. Produces the covariance of the gradient sum S'R^-1 v, which is M = sum S'R^-1 S for white residuals only:
//!     W = sum_ij S_i'R^-1 R_vv(i - j) R^-1 S_j = 1/F sum_f A(f)* P(f) A(f),   C = M^-1 W M^-1       (1)
//! with A the Fourier transform of R^-1 S over the run and P the one of the residuals' covariances R_vv(l), all outputs with all
//! others, under a flat-top lag window: 1 up to half of its width, then falling linearly to 0. Its width is twice the lag after
//! which [`INSIGNIFICANT_LAGS`] consecutive correlations are below 2 sqrt(log10 n/n), at most a quarter of the run.
//! The fit has absorbed the part of the noise that lies along S, so R_vv is biased low: with C known, S C S' is added to the
//! covariances of the residuals and (1) is repeated (`corrected_gradient_cov`). White residuals give W = M but for chance.
//! Source of (1): E. A. Morelli and V. Klein, J. Guidance 20(1), 1997; of the window: D. N. Politis, J. Nonparametric
//! Statistics 15(4-5), 2003.
//! Numerics: sensitivities vary slowly compared with the sampling. B samples form one block (sums of v, means of R^-1 S), B the
//! largest whose blocks retain [`RETAINED_ENERGY`] of every sensitivity's sum of squares, and each is scaled to its full sum. F
//! is longer than run and window together, so nothing wraps around. The window can make a power spectrum negative: it is limited
//! from below to [`LEAST_POWER`] of its mean, and a cross spectrum to the geometric mean of its two power spectra.

use super::information::SensitivityModel;
use super::run_parameters::RunParameters;
use super::simulated_outputs::{PreparedRun, SimulatedOutputs};
use crate::num::dense::Dense;
use crate::num::fft::{ComplexSeries, FourierTransform};

/// Consecutive insignificant correlations that end the correlogram.
pub const INSIGNIFICANT_LAGS: usize = 5;
/// Least power over the mean power.
pub const LEAST_POWER: f64 = 1e-3;
/// Part of a sensitivity's sum of squares that blocks have to retain.
pub const RETAINED_ENERGY: f64 = 0.97;
const BLOCKS: usize = 256;
const LONGEST_BLOCK: usize = 16;

/// Width of the window for covariances at lags 0, 1, ...; `counts` are the pairs at each.
pub fn width(covariances: &[f64], counts: &[f64]) -> usize {
    let Some((&power, rest)) = covariances.split_first() else { return 0 };
    let pairs = counts.first().copied().unwrap_or(0.0).max(2.0);
    let small = 2.0 * libm::sqrt(libm::log10(pairs) / pairs) * power;
    let (mut last, mut insignificant) = (0, 0);
    for (lag, covariance) in rest.iter().enumerate() {
        if counts.get(lag + 1).is_none_or(|&pairs| pairs < 0.5) {
            continue;
        }
        if covariance.abs() < small {
            insignificant += 1;
        } else {
            (last, insignificant) = (lag + 1, 0);
        }
        if insignificant == INSIGNIFICANT_LAGS {
            break;
        }
    }
    (2 * last).max(1).min(covariances.len().saturating_sub(1))
}

/// 1 up to half of the width, then falling to 0.
fn window(lag: usize, width: usize) -> f64 {
    let part = lag as f64 / (width + 1) as f64;
    (2.0 * (1.0 - part)).clamp(0.0, 1.0)
}

/// One run's spectra, from which (1) follows for any covariance of the estimates.
pub struct ColouredGradient {
    outputs: usize,
    columns: usize,
    transform: FourierTransform,
    lags: usize,
    /// Cross spectra of the residuals as they are, by pair a <= b.
    residuals: Vec<ComplexSeries>,
    /// How many products each lag of a pair has, by pair.
    counts: Vec<Vec<f64>>,
    /// A: real and imaginary parts by frequency, output, column.
    re: Vec<f64>,
    im: Vec<f64>,
    /// R in units of a block, which turns A into the transform of S.
    noise_cov: Dense,
}

/// `a conj(b)` added to `out` under a weight.
fn add_cross(a: &ComplexSeries, b: &ComplexSeries, out: &mut ComplexSeries) {
    for f in 0..out.re.len() {
        out.re[f] += a.re[f] * b.re[f] + a.im[f] * b.im[f];
        out.im[f] += a.im[f] * b.re[f] - a.re[f] * b.im[f];
    }
}

/// Sensitivities R^-1 S in rows of outputs x columns, a row a block.
struct Rows {
    width: usize,
    data: Vec<f64>,
}

impl Rows {
    /// Means of neighbours; an odd last one is left out.
    fn halved(&self) -> Rows {
        let mut data = Vec::with_capacity(self.data.len() / 2 + self.width);
        for two in self.data.chunks_exact(2 * self.width) {
            let (one, other) = two.split_at(self.width);
            data.extend(one.iter().zip(other).map(|(a, b)| 0.5 * (a + b)));
        }
        Rows { width: self.width, data }
    }

    /// Sum of squares by column of the row.
    fn squares(&self) -> Vec<f64> {
        let mut sums = vec![0.0; self.width];
        for row in self.data.chunks_exact(self.width) {
            for (sum, x) in sums.iter_mut().zip(row) {
                *sum += x * x;
            }
        }
        sums
    }
}

/// Means over the longest blocks that retain the sensitivities' energy, each scaled to its full sum of squares; and their length.
fn blocked(rows: Rows, columns: usize, noise: &[f64]) -> (Rows, usize) {
    let samples = rows.data.len() / rows.width.max(1);
    let whole = rows.squares();
    let energy = |squares: &[f64], column: usize| -> f64 {
        noise.iter().enumerate().map(|(o, variance)| variance * squares[o * columns + column]).sum()
    };
    let (mut best, mut block, mut kept) = (rows, 1, whole.clone());
    while 2 * block <= LONGEST_BLOCK && samples / (2 * block) >= BLOCKS {
        let tried = best.halved();
        let squares: Vec<f64> = tried.squares().iter().map(|square| (2 * block) as f64 * square).collect();
        if (0..columns).any(|column| energy(&squares, column) < RETAINED_ENERGY * energy(&whole, column)) {
            break;
        }
        (best, block, kept) = (tried, 2 * block, squares);
    }
    let scale: Vec<f64> =
        whole.iter().zip(&kept).map(|(whole, kept)| if *kept > 0.0 { libm::sqrt(whole / kept) } else { 1.0 }).collect();
    for row in best.data.chunks_exact_mut(best.width) {
        row.iter_mut().zip(&scale).for_each(|(x, scale)| *x *= scale);
    }
    (best, block)
}

impl ColouredGradient {
    /// Of residuals whose sensitivities are given by sample, output and column, already weighed with R^-1.
    pub(crate) fn of(run: &PreparedRun, columns: usize, residuals: &[f64], data: Vec<f64>, noise_cov: &Dense) -> Self {
        let outputs = noise_cov.rows();
        let rows = Rows { width: outputs * columns, data };
        let whole = run.counts.iter().all(|&count| count == run.samples);
        let (rows, block) = if whole { blocked(rows, columns, &noise_cov.diagonal()) } else { (rows, 1) };
        let blocks = run.samples / block;
        let lags = (blocks / 4).max(1);
        let transform = FourierTransform::at_least(blocks + lags + 1);
        let column = |o: usize| -> Vec<f64> {
            let values = residuals.iter().skip(o).step_by(outputs);
            let values: Vec<f64> = values.map(|v| if v.is_finite() { *v } else { 0.0 }).collect();
            values.chunks_exact(block).map(|part| part.iter().sum()).collect()
        };
        let sampled = |o: usize| -> Vec<f64> {
            if whole {
                return Vec::new();
            }
            residuals.iter().skip(o).step_by(outputs).map(|v| f64::from(u8::from(v.is_finite()))).collect()
        };
        let spectra: Vec<(ComplexSeries, ComplexSeries)> =
            (0..outputs).map(|o| transform.of_two(&column(o), &sampled(o))).collect();
        let (mut residuals, mut counts) = (Vec::new(), Vec::new());
        let length = transform.length();
        let half = length / 2 + 1;
        for a in 0..outputs {
            for b in a..outputs {
                let mut cross = ComplexSeries::zeros(half);
                add_cross(&spectra[a].0, &spectra[b].0, &mut cross);
                residuals.push(cross);
                counts.push(if whole {
                    (0..length).map(|place| blocks.saturating_sub(place.min(length - place)) as f64).collect()
                } else {
                    let mut pairs = ComplexSeries::zeros(half);
                    add_cross(&spectra[a].1, &spectra[b].1, &mut pairs);
                    transform.back(&pairs)
                });
            }
        }
        let width = outputs * columns;
        let (mut re, mut im) = (vec![0.0; half * width], vec![0.0; half * width]);
        let squares = rows.squares();
        let used: Vec<usize> = (0..width).filter(|&i| squares[i] > 0.0).collect();
        let column = |i: usize| -> Vec<f64> { rows.data.iter().skip(i).step_by(width).copied().collect() };
        for two in used.chunks(2) {
            let second = two.get(1).map_or_else(Vec::new, |&i| column(i));
            let (first, other) = transform.of_two(&column(two[0]), &second);
            for (place, spectrum) in two.iter().zip([first, other]) {
                for f in 0..half {
                    re[f * width + place] = spectrum.re[f];
                    im[f * width + place] = spectrum.im[f];
                }
            }
        }
        let noise_cov = Dense::from_fn(outputs, outputs, |a, b| block as f64 * noise_cov[(a, b)]);
        ColouredGradient { outputs, columns, transform, lags, residuals, counts, re, im, noise_cov }
    }

    fn pair(&self, a: usize, b: usize) -> usize {
        a * self.outputs - a * (a + 1) / 2 + b
    }

    /// W from the residuals as they are.
    pub fn gradient_cov(&self) -> Dense {
        self.weighed(&self.powers(&self.residuals))
    }

    /// W with what the fit took from the residuals given back: `cov` is Sigma of theta and the run's own.
    pub fn corrected_gradient_cov(&self, cov: &Dense) -> Dense {
        let mut sums = self.residuals.clone();
        let (outputs, columns) = (self.outputs, self.columns);
        let width = outputs * columns;
        // Sigma = B B' column by column, of what is positive in it.
        let (values, vectors) = cov.symmetric_eigen();
        let root = Dense::from_fn(columns, columns, |i, j| vectors[(i, j)] * libm::sqrt(values[j].max(0.0)));
        let half = self.transform.length() / 2 + 1;
        let (mut re, mut im) = (vec![0.0; width], vec![0.0; width]);
        for f in 0..half {
            let from = f * width;
            re.fill(0.0);
            im.fill(0.0);
            for a in 0..outputs {
                for b in 0..outputs {
                    let factor = self.noise_cov[(a, b)];
                    if factor == 0.0 {
                        continue;
                    }
                    for i in 0..columns {
                        let (x, y) = (factor * self.re[from + b * columns + i], factor * self.im[from + b * columns + i]);
                        if x == 0.0 && y == 0.0 {
                            continue;
                        }
                        let (re, im) = (&mut re[a * columns..][..columns], &mut im[a * columns..][..columns]);
                        for ((re, im), r) in re.iter_mut().zip(im).zip(root.row(i)) {
                            *re += x * r;
                            *im += y * r;
                        }
                    }
                }
            }
            for a in 0..outputs {
                for b in a..outputs {
                    let pair = self.pair(a, b);
                    for i in 0..columns {
                        let (x, y) = (re[a * columns + i], im[a * columns + i]);
                        let (u, v) = (re[b * columns + i], im[b * columns + i]);
                        sums[pair].re[f] += x * u + y * v;
                        sums[pair].im[f] += y * u - x * v;
                    }
                }
            }
        }
        self.weighed(&self.powers(&sums))
    }

    /// P by pair, from cross spectra.
    fn powers(&self, sums: &[ComplexSeries]) -> Vec<ComplexSeries> {
        let (length, lags, outputs) = (self.transform.length(), self.lags, self.outputs);
        let mut covariances = Vec::new();
        for (sums, counts) in sums.iter().zip(&self.counts) {
            let series = self.transform.back(sums);
            let at = |place: usize| if counts[place] > 0.5 { series[place] / counts[place] } else { 0.0 };
            let ahead: Vec<f64> = (0..=lags).map(at).collect();
            let behind: Vec<f64> = (0..=lags).map(|lag| at((length - lag) % length)).collect();
            covariances.push((ahead, behind));
        }
        let own = |a: usize| (&covariances[self.pair(a, a)].0, &self.counts[self.pair(a, a)]);
        let widths: Vec<usize> = (0..outputs).map(|a| width(own(a).0, own(a).1)).collect();
        let mut powers = Vec::new();
        for a in 0..outputs {
            for b in a..outputs {
                let (ahead, behind) = &covariances[self.pair(a, b)];
                let wide = widths[a].max(widths[b]);
                let mut series = ComplexSeries::zeros(length);
                for lag in 0..=wide.min(lags) {
                    series.re[lag] = window(lag, wide) * ahead[lag];
                    if lag > 0 {
                        series.re[length - lag] = window(lag, wide) * behind[lag];
                    }
                }
                self.transform.forward(&mut series);
                series.re.truncate(length / 2 + 1);
                series.im.truncate(length / 2 + 1);
                powers.push(series);
            }
        }
        self.hold_positive(&mut powers);
        powers
    }

    /// Powers above their least, cross powers below the powers' product.
    fn hold_positive(&self, powers: &mut [ComplexSeries]) {
        let count = self.transform.length() / 2 + 1;
        for a in 0..self.outputs {
            let own = &mut powers[self.pair(a, a)];
            let mean = own.re.iter().sum::<f64>() / count as f64;
            for (re, im) in own.re.iter_mut().zip(&mut own.im) {
                *re = re.max(LEAST_POWER * mean);
                *im = 0.0;
            }
        }
        for a in 0..self.outputs {
            for b in a + 1..self.outputs {
                for f in 0..count {
                    let most = powers[self.pair(a, a)].re[f] * powers[self.pair(b, b)].re[f];
                    let pair = &mut powers[self.pair(a, b)];
                    let squared = pair.re[f] * pair.re[f] + pair.im[f] * pair.im[f];
                    if squared > most {
                        let scale = libm::sqrt(most / squared);
                        pair.re[f] *= scale;
                        pair.im[f] *= scale;
                    }
                }
            }
        }
    }

    /// (1) by frequency.
    fn weighed(&self, powers: &[ComplexSeries]) -> Dense {
        let (outputs, columns) = (self.outputs, self.columns);
        let (length, width) = (self.transform.length(), outputs * columns);
        let half = length / 2 + 1;
        let mut sums = vec![0.0; columns * columns];
        let (mut turned_re, mut turned_im) = (vec![0.0; columns], vec![0.0; columns]);
        for f in 0..half {
            let weight = if f == 0 || f + 1 == half { 1.0 } else { 2.0 } / length as f64;
            let (re, im) = (&self.re[f * width..(f + 1) * width], &self.im[f * width..(f + 1) * width]);
            for a in 0..outputs {
                turned_re.fill(0.0);
                turned_im.fill(0.0);
                for b in 0..outputs {
                    let (power, sign) = if a <= b { (&powers[self.pair(a, b)], 1.0) } else { (&powers[self.pair(b, a)], -1.0) };
                    let (p, q) = (weight * power.re[f], sign * weight * power.im[f]);
                    let (re, im) = (&re[b * columns..][..columns], &im[b * columns..][..columns]);
                    for (((u, v), x), y) in turned_re.iter_mut().zip(&mut turned_im).zip(re).zip(im) {
                        *u += p * x - q * y;
                        *v += p * y + q * x;
                    }
                }
                for i in 0..columns {
                    let (x, y) = (re[a * columns + i], im[a * columns + i]);
                    if x == 0.0 && y == 0.0 {
                        continue;
                    }
                    let line = &mut sums[i * columns..(i + 1) * columns];
                    for ((sum, u), v) in line.iter_mut().zip(&turned_re).zip(&turned_im) {
                        *sum += x * u + y * v;
                    }
                }
            }
        }
        Dense::from_fn(columns, columns, |i, j| 0.5 * (sums[i * columns + j] + sums[j * columns + i]))
    }
}

/// R^-1 S in rows by sample, 0 where an output was not sampled.
pub(crate) fn weighed_sensitivities(
    linear: &SensitivityModel<'_>,
    run: &PreparedRun,
    simulated: &SimulatedOutputs,
    run_parameters: &RunParameters,
    inverse_cov: &Dense,
) -> Vec<f64> {
    let layout = &linear.prepared.layout;
    let (outputs, stride, columns) = (layout.outputs, layout.stride(), layout.columns());
    let width = outputs * columns;
    let mut data = vec![0.0; run.samples * width];
    linear.pass(run, simulated, run_parameters, |k, rows| {
        let line = &mut data[k * width..(k + 1) * width];
        for (b, row) in rows.chunks_exact(stride).enumerate() {
            if !row[columns].is_finite() {
                continue;
            }
            for (a, part) in line.chunks_exact_mut(columns).enumerate() {
                let factor = inverse_cov[(a, b)];
                if factor != 0.0 {
                    part.iter_mut().zip(row).for_each(|(sum, x)| *sum += factor * x);
                }
            }
        }
    });
    data
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_window_is_as_wide_as_the_residuals_remember() {
        let pairs: Vec<f64> = (0..200).map(|l| 1000.0 - f64::from(l)).collect();
        let forgetting: Vec<f64> = (0..200).map(|l| libm::pow(0.9, f64::from(l))).collect();
        let wide = width(&forgetting, &pairs);
        assert!((38..=50).contains(&wide), "{wide}");
        let white: Vec<f64> = (0..200).map(|l| f64::from(u8::from(l == 0))).collect();
        assert_eq!(width(&white, &pairs), 1);
    }
}
