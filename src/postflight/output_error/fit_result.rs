//! The result of a fit: estimates, standard errors, measures of fit of every run, and the parameters that are not significant.
//!
//! | figure | meaning |
//! | --- | --- |
//! | Theil's coefficient, VAF | those of `validation::metrics`; a coefficient below 0.25 to 0.3 is called good |
//! | insensitivity | 1/sqrt(M_jj): the change of theta_j alone that raises the cost by 1/2 |
//! | F corrected | (theta_j/sigma_j)^2 with the standard error corrected for coloured residuals |
//! A parameter is not significant where its corrected F is below [`SIGNIFICANT_F`]: without it the cost rises by no more than
//! chance would explain. Backward elimination: the weakest leaves first, and the others are updated to the optimum without it (to
//! second order of the cost), so of two parameters that are nearly exchangeable one stays.

use super::covariance::standard_errors;
use super::discrete::UnknownLayout;
use super::model::FitParameter;
use super::run_parameters::RunParameters;
use super::simulated_outputs::{PreparedRun, SimulatedOutputs};
use crate::num::dense::Dense;
use crate::postflight::validation::metrics::PredictionMoments;

/// 95 % of a chi-square of one degree.
pub const SIGNIFICANT_F: f64 = 3.84;
/// Correlations above this are listed.
pub const CORRELATED: f64 = 0.9;

/// One run at the estimates.
#[derive(Clone, Debug, PartialEq)]
pub struct FittedRun {
    /// Initial state and biases.
    pub run_parameters: RunParameters,
    /// Their standard errors, 0 where they were not free.
    pub run_parameters_std: RunParameters,
    /// Outputs of the model, by output and sample.
    pub predicted: Vec<Vec<f64>>,
    /// Measured less predicted, NaN where not measured.
    pub residuals: Vec<Vec<f64>>,
    /// Theil's inequality coefficient, by output.
    pub theil: Vec<f64>,
    /// Variance accounted for, by output.
    pub vaf: Vec<f64>,
}

/// Result of a fit by output error or filter error.
#[derive(Clone, Debug, PartialEq)]
pub struct FitResult {
    /// Estimates, in the order of the parameters.
    pub theta: Vec<f64>,
    /// Standard errors by the Cramer-Rao bound: white residuals.
    pub std_cramer_rao: Vec<f64>,
    /// Standard errors corrected for coloured residuals.
    pub std: Vec<f64>,
    /// Covariance corrected for coloured residuals.
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
    /// (theta/std)^2, std corrected for coloured residuals.
    pub f_corrected: Vec<f64>,
    /// Increase of the cost without the parameter, the others refitted.
    pub cost_rise: Vec<f64>,
    /// Parameters that are not significant, the weakest first.
    pub insignificant: Vec<usize>,
}

impl FitResult {
    /// Ratio of corrected standard errors to those for white residuals: the median over the parameters.
    pub fn colour_ratio(&self) -> Option<f64> {
        let mut ratios: Vec<f64> = self.std.iter().zip(&self.std_cramer_rao).map(|(std, bound)| std / bound).collect();
        ratios.retain(|ratio| ratio.is_finite());
        ratios.sort_by(f64::total_cmp);
        ratios.get(ratios.len() / 2).copied()
    }
}

/// Where a fit ended: what [`FitResult::new`] takes as it is.
pub(crate) struct FitEnd {
    /// Estimates of the parameters (p), the first of all unknowns.
    pub(crate) theta: Vec<f64>,
    pub(crate) noise_cov: Dense,
    pub(crate) cost: f64,
    pub(crate) iterations: usize,
    pub(crate) converged: bool,
    pub(crate) runs: Vec<FittedRun>,
}

impl FitResult {
    /// From the information and both covariances over all unknowns, of which theta are the first.
    pub(crate) fn new(
        end: FitEnd,
        information: &Dense,
        cramer_rao: &Dense,
        corrected: &Dense,
        parameters: &[FitParameter],
    ) -> Self {
        let FitEnd { theta, noise_cov, cost, iterations, converged, runs } = end;
        let p = theta.len();
        let (cov_cramer_rao, cov) = (cramer_rao.part(0..p, 0..p), corrected.part(0..p, 0..p));
        let std = standard_errors(&cov);
        FitResult {
            std_cramer_rao: standard_errors(&cov_cramer_rao),
            insensitivity: (0..p).map(|j| 1.0 / libm::sqrt(information[(j, j)])).collect(),
            correlated: correlated_pairs(&cov_cramer_rao),
            f_corrected: theta.iter().zip(&std).map(|(theta, std)| theta * theta / (std * std)).collect(),
            cost_rise: theta.iter().zip(cov_cramer_rao.diagonal()).map(|(theta, var)| 0.5 * theta * theta / var).collect(),
            insignificant: insignificant(&theta, &cov_cramer_rao, &cov, parameters),
            theta,
            std,
            cov,
            cov_cramer_rao,
            noise_cov,
            cost,
            iterations,
            converged,
            runs,
        }
    }
}

impl FittedRun {
    pub(crate) fn new(
        layout: &UnknownLayout,
        run: &PreparedRun,
        run_parameters: RunParameters,
        run_parameters_std: RunParameters,
        simulated: &SimulatedOutputs,
    ) -> Self {
        let by_output = |values: &[f64]| -> Vec<Vec<f64>> {
            (0..layout.outputs).map(|o| values.iter().skip(o).step_by(layout.outputs).copied().collect()).collect()
        };
        let (measured, predicted) = (by_output(&run.outputs), by_output(&simulated.outputs));
        let residuals = by_output(&simulated.residuals);
        let moments = measured.iter().zip(&predicted).map(|(measured, predicted)| {
            let pairs = measured.iter().copied().zip(predicted.iter().copied());
            PredictionMoments::of(pairs.filter(|(z, _)| z.is_finite()))
        });
        let (theil, vaf) = moments.map(|moments| (moments.theil(), moments.vaf())).unzip();
        FittedRun { run_parameters, run_parameters_std, predicted, residuals, theil, vaf }
    }
}

/// Correlated pairs of a covariance.
fn correlated_pairs(cov: &Dense) -> Vec<(usize, usize, f64)> {
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

/// Parameters that are not significant, by backward elimination; those with a prior stay.
fn insignificant(theta: &[f64], cramer_rao: &Dense, cov: &Dense, parameters: &[FitParameter]) -> Vec<usize> {
    let (mut theta, mut c, mut sigma) = (theta.to_vec(), cramer_rao.clone(), cov.clone());
    let mut left: Vec<usize> = (0..theta.len()).filter(|&j| parameters.get(j).is_some_and(|p| p.prior.is_none())).collect();
    let mut out = Vec::new();
    loop {
        let strength = |j: usize| theta[j] * theta[j] / sigma[(j, j)];
        let Some((place, &weakest)) = left.iter().enumerate().min_by(|a, b| strength(*a.1).total_cmp(&strength(*b.1))) else {
            break;
        };
        if !(strength(weakest) < SIGNIFICANT_F) {
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
