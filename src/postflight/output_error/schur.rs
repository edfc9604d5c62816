//! The step of a search from every run's information, the run parameters eliminated first.
//!
//! With theta (p) shared by all runs and r_i (q) of run i, information M and gradient g,
//!     [ M_tt M_tr ; M_rt M_rr ] [dtheta ; dr] = [g_t ; g_r]                                         (1)
//!     (M_tt - sum_i M_tr M_rr^-1 M_rt) dtheta = g_t - sum_i M_tr M_rr^-1 g_r                        (2)
//!     dr_i = M_rr^-1 (g_r - M_rt dtheta)                                                            (3)
//! (2) is the Schur complement: p square, however many runs there are.
//! Refused: a run whose M_rr is singular, with the names of the run parameters that it does not identify.

use super::error::OutputErrorFitError;
use super::identifiability::inverse_or_names;
use super::model::FitParameter;
use crate::num::dense::Dense;

/// (1) without the runs' own unknowns.
pub(crate) struct SchurComplement {
    pub(crate) matrix: Dense,
    gradient: Vec<f64>,
    /// By run: its own step is `base - slope dtheta`.
    runs: Vec<(Dense, Dense)>,
    /// What the runs' own unknowns alone still lower.
    own_length: f64,
}

impl SchurComplement {
    /// Of every run's information in columns theta, own, residual.
    pub(crate) fn of(
        p: usize,
        information: &[Dense],
        run_parameter_names: impl Fn(usize) -> Vec<String>,
    ) -> Result<Self, OutputErrorFitError> {
        let mut matrix = Dense::zeros(p, p);
        let mut gradient = vec![0.0; p];
        let mut runs = Vec::with_capacity(information.len());
        let mut own_length = 0.0;
        for (run, one) in information.iter().enumerate() {
            let all = one.columns() - 1;
            let inner = one.part(p..all, p..all);
            // own = base - slope dtheta
            let right = one.part(p..all, 0..p);
            let g = one.part(p..all, all..all + 1);
            let (base, slope) = if all > p {
                let inverse = inverse_or_names(&inner, &run_parameter_names(run))?;
                (inverse.times(&g), inverse.times(&right))
            } else {
                (Dense::zeros(0, 1), Dense::zeros(0, p))
            };
            own_length += (0..all - p).map(|i| base[(i, 0)] * g[(i, 0)]).sum::<f64>();
            for i in 0..p {
                gradient[i] += one[(i, all)] - (0..all - p).map(|l| right[(l, i)] * base[(l, 0)]).sum::<f64>();
                for j in 0..p {
                    matrix[(i, j)] += one[(i, j)] - (0..all - p).map(|l| right[(l, i)] * slope[(l, j)]).sum::<f64>();
                }
            }
            runs.push((base, slope));
        }
        Ok(SchurComplement { matrix, gradient, runs, own_length })
    }

    /// Adds what is known beforehand of the first parameters.
    pub(crate) fn with_priors(&mut self, parameters: &[FitParameter], theta: &[f64]) {
        for (j, (parameter, theta)) in parameters.iter().zip(theta).enumerate() {
            if let Some((mean, std)) = parameter.prior {
                self.matrix[(j, j)] += 1.0 / (std * std);
                self.gradient[j] -= (theta - mean) / (std * std);
            }
        }
    }

    /// Keeps these parameters where they are.
    pub(crate) fn hold(&mut self, held: &[usize]) {
        for &j in held {
            for i in 0..self.gradient.len() {
                self.matrix[(i, j)] = 0.0;
                self.matrix[(j, i)] = 0.0;
            }
            self.matrix[(j, j)] = 1.0;
            self.gradient[j] = 0.0;
            for (_, slope) in &mut self.runs {
                for i in 0..slope.rows() {
                    slope[(i, j)] = 0.0;
                }
            }
        }
    }

    /// The damped step, each run's own, and their length in standard errors; none where the matrix is singular.
    pub(crate) fn step(&self, damping: f64) -> Option<(Vec<f64>, Vec<Vec<f64>>, f64)> {
        let p = self.gradient.len();
        let damped = Dense::from_fn(p, p, |i, j| self.matrix[(i, j)] * if i == j { 1.0 + damping } else { 1.0 });
        let solved = damped.cholesky()?.solve_factored(&Dense::from_fn(p, 1, |i, _| self.gradient[i]));
        let step: Vec<f64> = (0..p).map(|i| solved[(i, 0)]).collect();
        let run_step = |(base, slope): &(Dense, Dense)| -> Vec<f64> {
            (0..base.rows()).map(|i| base[(i, 0)] - (0..p).map(|j| slope[(i, j)] * step[j]).sum::<f64>()).collect()
        };
        let run_steps = self.runs.iter().map(run_step).collect();
        let squared: f64 = self.own_length + step.iter().zip(&self.gradient).map(|(step, g)| step * g).sum::<f64>();
        Some((step, run_steps, libm::sqrt(squared.max(0.0))))
    }
}
