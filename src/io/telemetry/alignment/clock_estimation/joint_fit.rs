//! Maximum likelihood of a clock relation: one signal, a spline, measured by both recordings with white noise.
//!
//! The model, of samples y of ours and z of theirs:
//!     ours    y_i = s(t_i) + e_i                                                                       (1)
//!     theirs  z_j = a_0 + a_1 u_j + b s(m + x_j + d x_j) + f_j,   x_j = t_j - r,   u_j = x_j/X         (2)
//! with noise of variance sigma_e^2, sigma_f^2; unknown are the coefficients of s, bias a_0, trend a_1 and scale b of theirs,
//! our time m at their reference r, and the drift d. Errors of both are accounted for, since s is estimated from both. Least
//! squares, iterated (Gauss-Newton), with the coefficients of s eliminated (A is a band matrix):
//! ```text
//!     [ A   C ] [ dc ]   [ g_c ]
//!     [ C'  G ] [ dg ] = [ g_g ],   S = G - C' A^-1 C                                                  (3)
//! ```
//! and after each step the variances from the residuals and their degrees of freedom,
//!     sigma^2 = sum e^2/(n - sum_i lever_i)                                                            (4)
//! Covariance of bias, trend, scale, m and d:
//!     P = kappa H^-1 S H^-1                                                                            (5)
//! with H as S from the second derivatives of the likelihood, in whose mean the noise of s' (which S takes for signal) is not
//! contained. kappa is in [`super::coloured_residuals`]. The search is in the unit of the signals' standard deviations.
//! Source: (5) for an unknown signal that is as noisy as its measurement: W. A. Fuller, Measurement Error Models, 1987, on
//! functional models; (5) for it is checked by coverage where the noise is as large as the signal.

use super::spline::{SplineKnots, SplineRow};
use crate::num::banded::{BandFactor, BandMatrix};
use crate::num::dense::Dense;

/// Unknowns besides the spline: a_0, a_1, b, m, d X.
pub(super) const GLOBALS: usize = 5;
/// Places of m and d X.
pub(super) const TIME: usize = 3;
pub(super) const DRIFT: usize = 4;
/// Iterations at most.
const STEPS: usize = 40;
/// A step of so small a part of the standard error is the last.
const SETTLED: f64 = 1e-2;
/// Weight of the second differences of the coefficients, of the mean information: bridges gaps and nothing else.
const BRIDGE: f64 = 1e-6;
/// Least standard deviation of noise, of the signal's.
const LEAST_STD: f64 = 1e-6;

/// Samples of both in the overlap, times from the references, values in units of their standard deviation.
#[derive(Clone, Debug)]
pub(super) struct JointData {
    pub(super) ours: Vec<(f64, f64)>,
    pub(super) theirs: Vec<(f64, f64)>,
    /// X of (2), s.
    pub(super) half_s: f64,
    /// Whether d is estimated.
    pub(super) with_drift: bool,
}

/// What is estimated.
#[derive(Clone, Debug)]
pub(super) struct JointFit {
    pub(super) knots: SplineKnots,
    pub(super) coefficients: Vec<f64>,
    pub(super) globals: [f64; GLOBALS],
    pub(super) noise_var: [f64; 2],
    /// S of (3) at the end.
    pub(super) information: Dense,
    /// Whether the last step was small.
    pub(super) settled: bool,
    /// H of (5).
    pub(super) observed: Dense,
    /// -2 ln of the generalised cross-validation: smaller is better.
    pub(super) criterion: f64,
    pub(super) factor: BandFactor,
    /// A^-1 C, one column for each of the globals.
    pub(super) projection: Dense,
    /// Sum of levers over the number of samples.
    pub(super) lever: [f64; 2],
}

/// A row of theirs at the present estimate.
pub(super) struct TheirRow {
    pub(super) spline: SplineRow,
    /// Derivatives of the prediction by the globals.
    pub(super) globals: [f64; GLOBALS],
    pub(super) residual: f64,
    slope: f64,
    curvature: f64,
    place: f64,
}

/// Sums of (3).
struct NormalEquations {
    slope: Vec<f64>,
    cross: Dense,
    global_slope: [f64; GLOBALS],
    factor: BandFactor,
    global: Dense,
}

impl JointData {
    pub(super) fn their_row(&self, fit: &JointFit, (x, z): (f64, f64)) -> TheirRow {
        let [a0, a1, scale, time, drift] = fit.globals;
        let place = x / self.half_s;
        let spline = fit.knots.at(time + x + drift * place);
        let s = spline.of(&spline.value, &fit.coefficients);
        let slope = spline.of(&spline.slope, &fit.coefficients);
        let curvature = spline.of(&spline.curvature, &fit.coefficients);
        TheirRow {
            globals: [1.0, place, s, scale * slope, scale * slope * place],
            residual: z - (a0 + a1 * place + scale * s),
            spline,
            slope,
            curvature,
            place,
        }
    }

    pub(super) fn our_row(fit: &JointFit, (t, y): (f64, f64)) -> (SplineRow, f64) {
        let row = fit.knots.at(t);
        let residual = y - row.of(&row.value, &fit.coefficients);
        (row, residual)
    }

    /// The spline through ours alone on these knots, and bias and scale of theirs against it; the start of the search.
    fn started(&self, knots: SplineKnots, time: f64, drift: f64) -> Option<JointFit> {
        let order = knots.coefficients();
        let mut information = BandMatrix::zeros(order, 3);
        let mut coefficients = vec![0.0; order];
        for &(t, y) in &self.ours {
            add_row(&mut information, &mut coefficients, &knots.at(t), 1.0, y);
        }
        bridge(&mut information, self.ours.len() as f64 / order as f64, 1e3 * BRIDGE);
        let factor = information.factored().ok()?;
        factor.solve(&mut coefficients);
        let empty = Dense::zeros(GLOBALS, GLOBALS);
        let mut fit = JointFit {
            knots,
            coefficients,
            globals: [0.0, 0.0, 0.0, time, drift],
            noise_var: [1.0; 2],
            information: empty.clone(),
            settled: false,
            observed: empty,
            criterion: f64::INFINITY,
            factor,
            projection: Dense::zeros(order, GLOBALS),
            lever: [0.0; 2],
        };
        let (mut normal, mut right) = (Dense::zeros(3, 3), Dense::zeros(3, 1));
        for &sample in &self.theirs {
            let row = self.their_row(&fit, sample);
            for i in 0..3 {
                right[(i, 0)] += row.globals[i] * sample.1;
                for j in 0..3 {
                    normal[(i, j)] += row.globals[i] * row.globals[j];
                }
            }
        }
        let start = normal.cholesky()?.solve_factored(&right);
        (0..3).for_each(|i| fit.globals[i] = start[(i, 0)]);
        let mut squares = [0.0; 2];
        self.ours.iter().for_each(|&sample| squares[0] += square(JointData::our_row(&fit, sample).1));
        self.theirs.iter().for_each(|&sample| squares[1] += square(self.their_row(&fit, sample).residual));
        for (var, (sum, count)) in fit.noise_var.iter_mut().zip(squares.into_iter().zip([self.ours.len(), self.theirs.len()])) {
            *var = (sum / count as f64).max(square(LEAST_STD));
        }
        Some(fit)
    }

    /// Sums of (3) at the present estimate; `None` where A cannot be factored.
    fn normal_equations(&self, fit: &JointFit) -> Option<NormalEquations> {
        let order = fit.knots.coefficients();
        let scale = fit.globals[2];
        let [our_weight, their_weight] = fit.noise_var.map(f64::recip);
        let (mut band, mut slope) = (BandMatrix::zeros(order, 3), vec![0.0; order]);
        let (mut cross, mut global) = (Dense::zeros(order, GLOBALS), Dense::zeros(GLOBALS, GLOBALS));
        let mut global_slope = [0.0; GLOBALS];
        for &sample in &self.ours {
            let (row, residual) = JointData::our_row(fit, sample);
            add_row(&mut band, &mut slope, &row, our_weight, residual);
        }
        for &sample in &self.theirs {
            let row = self.their_row(fit, sample);
            let scaled = SplineRow { value: row.spline.value.map(|value| scale * value), ..row.spline };
            add_row(&mut band, &mut slope, &scaled, their_weight, row.residual);
            for i in 0..GLOBALS {
                let weighted = their_weight * row.globals[i];
                global_slope[i] += weighted * row.residual;
                (0..GLOBALS).for_each(|j| global[(i, j)] += weighted * row.globals[j]);
                (0..4).for_each(|k| cross[(scaled.first + k, i)] += weighted * scaled.value[k]);
            }
        }
        let density = our_weight * self.ours.len() as f64 + their_weight * square(scale) * self.theirs.len() as f64;
        let strength = bridge(&mut band, density / order as f64, BRIDGE);
        pull(&mut slope, &fit.coefficients, strength);
        Some(NormalEquations { slope, cross, global_slope, factor: band.factored().ok()?, global })
    }

    /// G - C' A^-1 C with what is not estimated held.
    fn eliminated(&self, global: &Dense, cross: &Dense, projection: &Dense) -> Dense {
        let inner = cross.transposed().times(projection);
        let held = |i: usize| i == DRIFT && !self.with_drift;
        Dense::from_fn(GLOBALS, GLOBALS, |i, j| match (held(i) || held(j), i == j) {
            (true, same) => f64::from(u8::from(same)),
            _ => global[(i, j)] - 0.5 * (inner[(i, j)] + inner[(j, i)]),
        })
    }

    /// Variances by (4) and the criterion, with the levers by the inverse of A.
    fn renew_variances(&self, fit: &mut JointFit) {
        let inverse = fit.factor.inverse_band();
        let lever = |row: &SplineRow, weight: f64| {
            let mut sum = 0.0;
            for i in 0..4 {
                for j in 0..4 {
                    let (low, high) = (row.first + i.min(j), row.first + i.max(j));
                    sum += row.value[i] * row.value[j] * inverse.at(high, low);
                }
            }
            weight * sum
        };
        let (mut squares, mut levers) = ([0.0; 2], [0.0, GLOBALS as f64]);
        let weights = [1.0 / fit.noise_var[0], square(fit.globals[2]) / fit.noise_var[1]];
        for &sample in &self.ours {
            let (row, residual) = JointData::our_row(fit, sample);
            squares[0] += square(residual);
            levers[0] += lever(&row, weights[0]);
        }
        for &sample in &self.theirs {
            let row = self.their_row(fit, sample);
            squares[1] += square(row.residual);
            levers[1] += lever(&row.spline, weights[1]);
        }
        fit.criterion = 0.0;
        for (k, count) in [self.ours.len(), self.theirs.len()].into_iter().enumerate() {
            let count = count as f64;
            fit.lever[k] = (levers[k] / count).clamp(0.0, 0.95);
            let free = 1.0 - fit.lever[k];
            fit.noise_var[k] = (squares[k] / (count * free)).max(square(LEAST_STD));
            fit.criterion += count * (libm::log((squares[k] / count).max(square(LEAST_STD))) - 2.0 * libm::log(free));
        }
    }

    /// Iterates from this time and drift (in units of X) on these knots; `None` where that breaks down.
    pub(super) fn fit(&self, knots: SplineKnots, time: f64, drift: f64) -> Option<JointFit> {
        let mut fit = self.started(knots, time, drift)?;
        for _ in 0..STEPS {
            let NormalEquations { mut slope, cross, global_slope, factor, global } = self.normal_equations(&fit)?;
            let projection = solved(&factor, &cross);
            let information = self.eliminated(&global, &cross, &projection);
            let mut right = Dense::from_fn(GLOBALS, 1, |i, _| {
                global_slope[i] - (0..slope.len()).map(|k| projection[(k, i)] * slope[k]).sum::<f64>()
            });
            if !self.with_drift {
                right[(DRIFT, 0)] = 0.0;
            }
            let step = information.cholesky()?.solve_factored(&right);
            let moved = libm::fabs(step[(TIME, 0)]) + libm::fabs(step[(DRIFT, 0)]);
            let part = (0.5 * fit.knots.step_s / moved.max(1e-300)).min(1.0);
            factor.solve(&mut slope);
            for (k, c) in fit.coefficients.iter_mut().enumerate() {
                let along: f64 = (0..GLOBALS).map(|i| projection[(k, i)] * step[(i, 0)]).sum();
                *c += part * (slope[k] - along);
            }
            (0..GLOBALS).for_each(|i| fit.globals[i] += part * step[(i, 0)]);
            let size: f64 = (0..GLOBALS).map(|i| step[(i, 0)] * right[(i, 0)]).sum();
            (fit.factor, fit.projection, fit.information) = (factor, projection, information);
            let before = fit.noise_var;
            self.renew_variances(&mut fit);
            let still = before.iter().zip(fit.noise_var).all(|(before, now)| libm::fabs(now / before - 1.0) < 0.01);
            if !fit.globals.iter().all(|x| x.is_finite()) {
                return None;
            }
            if still && part >= 1.0 && size < square(SETTLED) {
                fit.settled = true;
                return self.with_observed(fit);
            }
        }
        Some(fit)
    }

    /// S and H at the end.
    fn with_observed(&self, mut fit: JointFit) -> Option<JointFit> {
        let NormalEquations { mut cross, factor, mut global, .. } = self.normal_equations(&fit)?;
        fit.projection = solved(&factor, &cross);
        fit.information = self.eliminated(&global, &cross, &fit.projection);
        let (scale, weight) = (fit.globals[2], 1.0 / fit.noise_var[1]);
        for &sample in &self.theirs {
            let row = self.their_row(&fit, sample);
            let pull = weight * row.residual;
            for k in 0..4 {
                let at = row.spline.first + k;
                cross[(at, 2)] -= pull * row.spline.value[k];
                cross[(at, TIME)] -= pull * scale * row.spline.slope[k];
                cross[(at, DRIFT)] -= pull * scale * row.spline.slope[k] * row.place;
            }
            let (bend, u) = (pull * scale * row.curvature, row.place);
            for (i, j, second) in [(2, TIME, pull * row.slope), (2, DRIFT, pull * row.slope * u), (TIME, DRIFT, bend * u)] {
                global[(i, j)] -= second;
                global[(j, i)] -= second;
            }
            global[(TIME, TIME)] -= bend;
            global[(DRIFT, DRIFT)] -= bend * u * u;
        }
        fit.observed = self.eliminated(&global, &cross, &solved(&factor, &cross));
        fit.factor = factor;
        Some(fit)
    }
}

fn square(x: f64) -> f64 {
    x * x
}

fn add_row(band: &mut BandMatrix, right: &mut [f64], row: &SplineRow, weight: f64, value: f64) {
    for i in 0..4 {
        right[row.first + i] += weight * row.value[i] * value;
        (0..=i).for_each(|j| band.add(row.first + i, row.first + j, weight * row.value[i] * row.value[j]));
    }
}

const SECOND_DIFFERENCE: [f64; 3] = [1.0, -2.0, 1.0];

/// Adds the square of second differences with this part of the mean information; returns their weight.
fn bridge(band: &mut BandMatrix, density: f64, part: f64) -> f64 {
    let strength = part * density;
    for k in 0..band.order().saturating_sub(2) {
        for (i, row) in SECOND_DIFFERENCE.iter().enumerate() {
            for (j, column) in SECOND_DIFFERENCE.iter().enumerate().take(i + 1) {
                band.add(k + i, k + j, strength * row * column);
            }
        }
    }
    strength
}

/// The slope of those squares.
fn pull(slope: &mut [f64], coefficients: &[f64], strength: f64) {
    for k in 0..coefficients.len().saturating_sub(2) {
        let difference: f64 = (0..3).map(|i| SECOND_DIFFERENCE[i] * coefficients[k + i]).sum();
        (0..3).for_each(|i| slope[k + i] -= strength * SECOND_DIFFERENCE[i] * difference);
    }
}

fn solved(factor: &BandFactor, right: &Dense) -> Dense {
    let mut columns = right.transposed();
    let order = right.rows();
    for i in 0..columns.rows() {
        let mut column = columns.row(i).to_vec();
        factor.solve(&mut column);
        (0..order).for_each(|k| columns[(i, k)] = column[k]);
    }
    columns.transposed()
}
