//! The likelihood of filter error at given unknowns, and its information.
//!
//! Consumes a checked `OutputErrorProblem`, the disturbances, and the unknowns theta, ln q by gust, ln r by output; with
//! innovations v and variances s of `filter` over all measured values of all runs, produces
//!     J = 1/2 sum (v^2/s + ln s) + 1/2 sum ((theta_j - m_j)/sigma_j)^2                              (1)
//!     M = sum dv dv'/s + 1/2 sum ds ds'/s^2,   g = - sum v dv/s - 1/2 sum ds/s (1 - v^2/s)          (2)
//! in the order theta, ln q, ln r, run parameters: two rows for each value, [-dv | v]/sqrt(s) and [ds | v^2 - s]/(sqrt(2) s).
//! M is the expected (Fisher) information.

use super::discrete_noise::{DiscreteNoise, NoiseSources};
use super::filter::{ScalarInnovation, SensitivityFilter};
use super::process_noise::Disturbances;
use crate::num::dense::Dense;
use crate::postflight::output_error::discrete::{DiscreteStep, ModelMatrices};
use crate::postflight::output_error::error::OutputErrorFitError;
use crate::postflight::output_error::information::add_squares;
use crate::postflight::output_error::problem::OutputErrorProblem;
use crate::postflight::output_error::run_parameters::RunParameters;

const ROWS: usize = 40;

pub(crate) struct FilterErrorLikelihood<'a> {
    pub(crate) problem: OutputErrorProblem<'a>,
    pub(crate) disturbances: &'a Disturbances,
    /// Parameters of the structure, the first unknowns.
    pub(crate) parameters: usize,
    /// Inputs that have noise in some run.
    noisy: Vec<usize>,
    /// Gusts of density 0.
    pub(crate) still: Vec<bool>,
}

#[derive(Clone)]
pub(crate) struct FilterErrorIterate {
    pub(crate) theta: Vec<f64>,
    pub(crate) run_parameters: Vec<RunParameters>,
    pub(crate) point: ModelMatrices,
    pub(crate) cost: f64,
}

pub(crate) struct FilterErrorSearch {
    pub(crate) stand: FilterErrorIterate,
    pub(crate) iterations: usize,
    pub(crate) converged: bool,
}

impl<'a> FilterErrorLikelihood<'a> {
    pub(crate) fn new(problem: OutputErrorProblem<'a>, disturbances: &'a Disturbances, parameters: usize) -> Self {
        let any = |l: &usize| disturbances.inputs.iter().any(|run| run.get(*l).is_some_and(|s| s.iter().any(|&s| s > 0.0)));
        let noisy = (0..problem.prepared.layout.inputs).filter(any).collect();
        let still = vec![false; disturbances.gusts.len()];
        FilterErrorLikelihood { problem, disturbances, parameters, noisy, still }
    }

    /// q by gust.
    pub(crate) fn densities(&self, theta: &[f64]) -> Vec<f64> {
        let logs = theta.iter().skip(self.parameters).zip(&self.still);
        logs.map(|(log, still)| if *still { 0.0 } else { libm::exp(*log) }).collect()
    }

    /// r by output.
    pub(crate) fn noise(&self, theta: &[f64]) -> Vec<f64> {
        theta.iter().skip(self.parameters + self.still.len()).map(|log| libm::exp(*log)).collect()
    }

    /// Unknowns that stay where they are.
    pub(crate) fn held(&self) -> Vec<usize> {
        self.still.iter().enumerate().filter(|(_, still)| **still).map(|(place, _)| self.parameters + place).collect()
    }

    /// Goes through one run at a place.
    pub(crate) fn run(
        &mut self,
        run: usize,
        (theta, run_parameters, point): (&[f64], &RunParameters, &ModelMatrices),
        derivatives: bool,
        take: impl FnMut(&ScalarInnovation<'_>),
    ) {
        let (densities, noise) = (self.densities(theta), self.noise(theta));
        let Some(one) = self.problem.runs.get_mut(run) else { return };
        let prepared = &self.problem.prepared;
        one.delay(&prepared.layout, theta);
        let sources =
            NoiseSources { gusts: &self.disturbances.gusts, densities: &densities, column: self.parameters, inputs: &self.noisy };
        let steps: Vec<DiscreteStep> = prepared.steps(point, &one.timeline, derivatives);
        let spread = |&h: &f64| DiscreteNoise::new(prepared, point, h, &sources, derivatives);
        let spreads: Vec<DiscreteNoise> = one.timeline.distinct_s.iter().map(spread).collect();
        let filter = SensitivityFilter {
            prepared,
            point,
            output_lines: &self.problem.output_lines,
            noise: &noise,
            noise_column: self.parameters + self.still.len(),
            inputs: &self.noisy,
        };
        let known = self.disturbances.inputs.get(run).map_or(&[][..], Vec::as_slice);
        filter.run(one, run_parameters, (&steps, &spreads), known, derivatives, take);
    }

    /// (1); refused where the innovations run away.
    pub(crate) fn at(
        &mut self,
        theta: Vec<f64>,
        run_parameters: Vec<RunParameters>,
    ) -> Result<FilterErrorIterate, OutputErrorFitError> {
        let point = self.problem.prepared.at(&theta);
        let mut cost = 0.0;
        for (run, run_parameters) in run_parameters.iter().enumerate() {
            let mut sum = 0.0;
            self.run(run, (&theta, run_parameters, &point), false, |one| sum += 0.5 * (one.v * one.v / one.s + libm::log(one.s)));
            if !sum.is_finite() {
                return Err(OutputErrorFitError::Diverges { run });
            }
            cost += sum;
        }
        for (theta, parameter) in theta.iter().zip(self.problem.parameters) {
            if let Some((mean, std)) = parameter.prior {
                cost += 0.5 * (theta - mean) * (theta - mean) / (std * std);
            }
        }
        Ok(FilterErrorIterate { theta, run_parameters, point, cost })
    }

    /// (2) of every run, columns + 1 square, the residual last.
    pub(crate) fn information(&mut self, stand: &FilterErrorIterate) -> Vec<Dense> {
        (0..stand.run_parameters.len())
            .map(|run| {
                let (means, variances) = self.information_of(run, stand, |_| {});
                Dense::from_fn(means.rows(), means.columns(), |i, j| means[(i, j)] + variances[(i, j)])
            })
            .collect()
    }

    /// Both parts of (2) of one run.
    pub(crate) fn information_of(
        &mut self,
        run: usize,
        stand: &FilterErrorIterate,
        mut observe: impl FnMut(&ScalarInnovation<'_>),
    ) -> (Dense, Dense) {
        let layout = &self.problem.prepared.layout;
        let (stride, columns) = (layout.stride(), layout.columns());
        let mut sums = [vec![0.0; stride * stride], vec![0.0; stride * stride]];
        let mut rows = [Vec::with_capacity((ROWS + 1) * stride), Vec::with_capacity((ROWS + 1) * stride)];
        let Some(run_parameters) = stand.run_parameters.get(run) else { return Default::default() };
        self.run(run, (&stand.theta, run_parameters, &stand.point), true, |one| {
            observe(one);
            let (root, [means, variances]) = (libm::sqrt(one.s), &mut rows);
            means.extend(one.change.iter().map(|x| x / root));
            let last = means.len() - stride + columns;
            means[last] = one.v / root;
            let (from, scale) = (variances.len(), 1.0 / (core::f64::consts::SQRT_2 * one.s));
            variances.resize(from + stride, 0.0);
            for (&column, change) in one.columns.iter().zip(one.variance_changes) {
                variances[from + column] = scale * change;
            }
            variances[from + columns] = scale * (one.v * one.v - one.s);
            if means.len() >= ROWS * stride {
                for (rows, sums) in rows.iter_mut().zip(&mut sums) {
                    add_squares(rows, stride, columns + 1, sums);
                    rows.clear();
                }
            }
        });
        let [means, variances] = [0, 1].map(|part: usize| {
            add_squares(&rows[part], stride, columns + 1, &mut sums[part]);
            Dense::from_fn(columns + 1, columns + 1, |i, j| sums[part][i.min(j) * stride + i.max(j)])
        });
        (means, variances)
    }
}
