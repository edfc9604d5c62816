//! Covariances of all unknowns at the end of a fit: the Cramer-Rao bound, and the one corrected for coloured residuals.
//!
//! The unknowns are theta (p) and then the parameters of every run in turn (q each). The information M (p + N q square) of N
//! runs is bordered: a run's block M_i [p + q square] is added where theta and that run's parameters stand.
//!     C_CR = M^-1                                                                                   (1)
//!     C = M^-1 W M^-1,   W = sum_i W_i + M_0                                                        (2)
//! W is the covariance of the likelihood's gradient, W_i a run's part of it (`coloured_errors`), M_0 = diag(1/sigma_j^2) the
//! priors' information, which is in M too. W_i is biased low, because the fit has taken from the residuals what resembles a
//! sensitivity; so (2) is done once more with C of the first time given back ([`BIAS_CORRECTIONS`]).
//! Source of (2): E. A. Morelli and V. Klein, J. Guidance 20(1), 1997.

use super::discrete::UnknownLayout;
use super::run_parameters::RunParameters;
use crate::num::dense::Dense;

/// How often C is given back to W; a second time changes standard errors by less than 1 %.
const BIAS_CORRECTIONS: usize = 1;

/// Standard errors: square roots of the variances.
pub(crate) fn standard_errors(cov: &Dense) -> Vec<f64> {
    cov.diagonal().iter().map(|variance| libm::sqrt(*variance)).collect()
}

/// Places of the unknowns of all runs.
#[derive(Clone, Copy, Debug)]
pub(crate) struct AllUnknowns {
    parameters: usize,
    per_run: usize,
    runs: usize,
}

impl AllUnknowns {
    pub(crate) fn new(layout: &UnknownLayout, runs: usize) -> Self {
        AllUnknowns { parameters: layout.parameters, per_run: layout.run_parameter_count(), runs }
    }

    /// p + N q.
    pub(crate) fn size(&self) -> usize {
        self.parameters + self.per_run * self.runs
    }

    /// Place among all unknowns of place i of a run's block.
    fn place(&self, run: usize, i: usize) -> usize {
        if i < self.parameters { i } else { i + run * self.per_run }
    }

    /// Adds a run's block where it belongs.
    pub(crate) fn add_block(&self, all: &mut Dense, block: &Dense, run: usize) {
        let size = block.rows().min(block.columns());
        for i in 0..size {
            for j in 0..size {
                all[(self.place(run, i), self.place(run, j))] += block[(i, j)];
            }
        }
    }

    /// A run's block of a matrix over all unknowns.
    fn block(&self, all: &Dense, run: usize) -> Dense {
        let columns = self.parameters + self.per_run;
        Dense::from_fn(columns, columns, |i, j| all[(self.place(run, i), self.place(run, j))])
    }

    /// Standard errors of a run's parameters; 0 of those that are not free.
    pub(crate) fn run_parameters_std(&self, layout: &UnknownLayout, stds: &[f64], run: usize) -> RunParameters {
        let from = self.parameters + run * self.per_run;
        RunParameters::zero(layout).moved(layout, &stds[from..from + self.per_run])
    }

    /// (2). `gradient_cov` gives the parts of a run's W_i, for a covariance of that run's unknowns that is given back.
    pub(crate) fn corrected(
        &self,
        cramer_rao: &Dense,
        prior: &[f64],
        gradient_cov: impl Fn(usize, Option<&Dense>) -> Vec<Dense>,
    ) -> Dense {
        let sandwich = |given_back: Option<&Dense>| {
            let mut w = Dense::zeros(self.size(), self.size());
            for run in 0..self.runs {
                let cov = given_back.map(|all| self.block(all, run));
                for block in gradient_cov(run, cov.as_ref()) {
                    self.add_block(&mut w, &block, run);
                }
            }
            for (j, weight) in prior.iter().enumerate() {
                w[(j, j)] += weight;
            }
            cramer_rao.times(&w).times(cramer_rao)
        };
        let mut cov = sandwich(None);
        for _ in 0..BIAS_CORRECTIONS {
            cov = sandwich(Some(&cov));
        }
        cov
    }
}
