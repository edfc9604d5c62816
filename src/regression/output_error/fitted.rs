//! What a fit gives: estimates, their errors, how each run is followed, and which parameters do not belong.
//!
//! | figure | meaning |
//! | --- | --- |
//! | Theil's coefficient | rms(v)/(rms(z) + rms(y)): 0 is exact, below 0.25-0.3 is called good |
//! | VAF | 1 - var(v)/var(z) |
//! | insensitivity | 1/sqrt(M_jj): how far theta_j alone may move for half a unit of cost |
//! | F corrected | (theta_j/sigma_j)^2 with the error that knows of the residuals' colour |
//! A parameter does not belong where its F corrected is below [`BELONGS_F`]: without it the cost rises by no more than chance
//! would. The weakest goes first and the others are taken as refitted without it (to the second order of the cost), so of two
//! that stand for each other one stays.

use super::dense::Dense;
use super::discrete::Layout;
use super::model::Parameter;
use super::own::Own;
use super::simulated::{Run, Simulated};

/// 95 % of a chi-square of one degree.
pub const BELONGS_F: f64 = 3.84;
/// Correlations above this are listed.
pub const CORRELATED: f64 = 0.9;

/// How one run came out.
#[derive(Clone, Debug, PartialEq)]
pub struct FittedRun {
    /// Initial state and biases.
    pub own: Own,
    /// Their standard errors, 0 where they were not free.
    pub own_std: Own,
    /// Outputs of the model, by output and sample.
    pub predicted: Vec<Vec<f64>>,
    /// Measured less predicted, NaN where not measured.
    pub residuals: Vec<Vec<f64>>,
    /// Theil's inequality coefficient, by output.
    pub theil: Vec<f64>,
    /// Variance accounted for, by output.
    pub vaf: Vec<f64>,
}

/// The answer.
#[derive(Clone, Debug, PartialEq)]
pub struct Fitted {
    /// Estimates, in the order of the parameters.
    pub theta: Vec<f64>,
    /// Standard errors by the Cramer-Rao bound: white residuals.
    pub std_cramer_rao: Vec<f64>,
    /// Standard errors corrected for the residuals' colour.
    pub std: Vec<f64>,
    /// Covariance corrected for colour.
    pub cov: Dense,
    /// Covariance by the Cramer-Rao bound.
    pub cov_cramer_rao: Dense,
    /// R.
    pub noise_cov: Dense,
    /// Negative logarithm of the likelihood but for a constant, with the priors.
    pub cost: f64,
    /// Steps that were taken on all samples.
    pub iterations: usize,
    /// Whether the next step would be below the tolerance.
    pub converged: bool,
    /// 1/sqrt(M_jj).
    pub insensitivity: Vec<f64>,
    /// Pairs with a correlation (Cramer-Rao) above [`CORRELATED`] in magnitude.
    pub correlated: Vec<(usize, usize, f64)>,
    /// By run.
    pub runs: Vec<FittedRun>,
    /// (theta/std)^2, corrected for colour.
    pub f_corrected: Vec<f64>,
    /// What the cost rises by without the parameter, the others refitted.
    pub cost_rise: Vec<f64>,
    /// Parameters that the records do not ask for, the weakest first.
    pub does_not_belong: Vec<usize>,
}

impl Fitted {
    /// How many times the standard errors are what white residuals would give: the median over the parameters.
    pub fn colour(&self) -> Option<f64> {
        let mut ratios: Vec<f64> = self.std.iter().zip(&self.std_cramer_rao).map(|(std, bound)| std / bound).collect();
        ratios.retain(|ratio| ratio.is_finite());
        ratios.sort_by(f64::total_cmp);
        ratios.get(ratios.len() / 2).copied()
    }
}

impl FittedRun {
    pub(crate) fn new(layout: &Layout, run: &Run, own: Own, own_std: Own, simulated: &Simulated) -> Self {
        let by_output = |values: &[f64]| -> Vec<Vec<f64>> {
            (0..layout.outputs).map(|o| values.iter().skip(o).step_by(layout.outputs).copied().collect()).collect()
        };
        let (measured, predicted) = (by_output(&run.outputs), by_output(&simulated.outputs));
        let residuals = by_output(&simulated.residuals);
        let figures = measured.iter().zip(&predicted).map(|(z, y)| agreement(z, y));
        let (theil, vaf) = figures.unzip();
        FittedRun { own, own_std, predicted, residuals, theil, vaf }
    }
}

/// Theil's coefficient and VAF over the samples that were measured.
fn agreement(measured: &[f64], predicted: &[f64]) -> (f64, f64) {
    let pairs = || measured.iter().zip(predicted).filter(|(z, _)| z.is_finite());
    let count = pairs().count() as f64;
    let mean = |of: &dyn Fn(f64, f64) -> f64| pairs().map(|(&z, &y)| of(z, y)).sum::<f64>() / count;
    let rms = |of: &dyn Fn(f64, f64) -> f64| libm::sqrt(mean(&|z, y| of(z, y) * of(z, y)));
    let (middle, offset) = (mean(&|z, _| z), mean(&|z, y| z - y));
    let spread = mean(&|z, _| (z - middle) * (z - middle));
    let left = mean(&|z, y| (z - y - offset) * (z - y - offset));
    (rms(&|z, y| z - y) / (rms(&|z, _| z) + rms(&|_, y| y)), 1.0 - left / spread)
}

/// Correlated pairs of a covariance.
pub(crate) fn correlated(cov: &Dense) -> Vec<(usize, usize, f64)> {
    let mut found = Vec::new();
    for i in 0..cov.rows() {
        for j in i + 1..cov.rows() {
            let rho = cov[(i, j)] / libm::sqrt(cov[(i, i)] * cov[(j, j)]);
            if rho.abs() > CORRELATED {
                found.push((i, j, rho));
            }
        }
    }
    found
}

/// Parameters that do not belong: the weakest is taken out until all that are left are strong. What a prior says is kept.
pub(crate) fn does_not_belong(theta: &[f64], cramer_rao: &Dense, cov: &Dense, parameters: &[Parameter]) -> Vec<usize> {
    let (mut theta, mut c, mut sigma) = (theta.to_vec(), cramer_rao.clone(), cov.clone());
    let mut left: Vec<usize> = (0..theta.len()).filter(|&j| parameters.get(j).is_some_and(|p| p.prior.is_none())).collect();
    let mut out = Vec::new();
    loop {
        let strength = |j: usize| theta[j] * theta[j] / sigma[(j, j)];
        let Some((place, &weakest)) = left.iter().enumerate().min_by(|a, b| strength(*a.1).total_cmp(&strength(*b.1))) else {
            break;
        };
        if !(strength(weakest) < BELONGS_F) {
            break;
        }
        out.push(weakest);
        left.remove(place);
        let n = theta.len();
        let gain: Vec<f64> = (0..n).map(|i| c[(i, weakest)] / c[(weakest, weakest)]).collect();
        let value = theta[weakest];
        theta.iter_mut().zip(&gain).for_each(|(theta, gain)| *theta -= gain * value);
        let turn = Dense::from_fn(n, n, |i, j| f64::from(u8::from(i == j)) - if j == weakest { gain[i] } else { 0.0 });
        sigma = turn.times(&sigma).times(&turn.transposed());
        c = turn.times(&c).times(&turn.transposed());
    }
    out
}
