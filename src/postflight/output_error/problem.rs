//! A fit as posed: checked data, the model at any place, its cost, and the information there.
//!
//! Consumes a structure, parameters and records as they come; produces for any parameters and own values the residuals, R, and
//! the cost of `fit` (1), or refuses what no search could mend.
//! Numerics: R is held above [`LEAST_NOISE`] of each output's own spread, so that data without noise have an answer.

use super::discrete::{ModelMatrices, PreparedModel, SensitivityRows, UnknownLayout};
use super::error::OutputErrorFitError;
use super::information::{SensitivityModel, Whitening};
use super::model::{FitParameter, InputDelay, InputOutputRecord, ModelStructure};
use super::run_parameters::RunParameters;
use super::settings::NoiseCovariance;
use super::simulated_outputs::{PreparedRun, SimulatedOutputs, simulate};
use crate::num::dense::Dense;
use crate::postflight::work_progress::Watch;

/// Least standard deviation of the noise, over the spread of an output.
const LEAST_NOISE: f64 = 1e-9;

/// A checked fit: model, parameters, prepared runs.
pub(crate) struct OutputErrorProblem<'a> {
    pub(crate) prepared: PreparedModel<'a>,
    pub(crate) output_lines: SensitivityRows,
    pub(crate) parameters: &'a [FitParameter],
    pub(crate) runs: Vec<PreparedRun>,
    noise: NoiseCovariance,
    pub(crate) floors: Vec<f64>,
    /// By output.
    pub(crate) counts: Vec<f64>,
    /// Who watches the search.
    pub(crate) watch: Watch,
}

/// One point of the search, with its residuals, R and cost.
#[derive(Clone)]
pub(crate) struct OutputErrorIterate {
    pub(crate) theta: Vec<f64>,
    pub(crate) run_parameters: Vec<RunParameters>,
    pub(crate) point: ModelMatrices,
    pub(crate) simulated: Vec<SimulatedOutputs>,
    pub(crate) noise_cov: Dense,
    pub(crate) whitening: Whitening,
    pub(crate) cost: f64,
}

pub(crate) struct OutputErrorSearch {
    pub(crate) place: OutputErrorIterate,
    pub(crate) information: Vec<Dense>,
    pub(crate) iterations: usize,
    pub(crate) converged: bool,
}

impl<'a> OutputErrorProblem<'a> {
    pub(crate) fn new(
        structure: &'a ModelStructure,
        parameters: &'a [FitParameter],
        delays: &[InputDelay],
        records: &[InputOutputRecord],
        noise: NoiseCovariance,
    ) -> Result<Self, OutputErrorFitError> {
        structure.check(parameters.len(), delays)?;
        for parameter in parameters {
            let (mean, std) = parameter.prior.unwrap_or((0.0, 1.0));
            for (value, good) in [(parameter.start, true), (mean, true), (std, std > 0.0)] {
                if !good || !value.is_finite() {
                    return Err(OutputErrorFitError::Parameter { name: parameter.name.clone(), value });
                }
            }
        }
        for (run, record) in records.iter().enumerate() {
            structure.check_record(record, run)?;
        }
        let prepared = PreparedModel::new(structure, UnknownLayout::new(structure, parameters.len(), delays));
        let layout = &prepared.layout;
        let runs: Vec<PreparedRun> = records.iter().map(|record| PreparedRun::new(record, layout)).collect();
        let counts: Vec<f64> =
            (0..layout.outputs).map(|o| runs.iter().filter_map(|run| run.counts.get(o)).sum::<usize>() as f64).collect();
        if let Some(output) = counts.iter().zip(&structure.outputs).find(|(count, _)| **count < 0.5) {
            return Err(OutputErrorFitError::NeverSampled { output: output.1.clone() });
        }
        for (place, name) in structure.outputs.iter().enumerate() {
            let mut values = records.iter().filter_map(|record| record.outputs.get(place)).flatten().filter(|z| z.is_finite());
            let first = values.next().copied().unwrap_or(f64::NAN);
            if values.clone().count() > 0 && values.all(|z| z.total_cmp(&first).is_eq()) {
                return Err(OutputErrorFitError::StillOutput { output: name.clone(), value: first });
            }
        }
        let values = counts.iter().sum::<f64>() as usize;
        let priors = parameters.iter().filter(|parameter| parameter.prior.is_some()).count();
        let unknowns = parameters.len() + records.len() * layout.run_parameter_count();
        if values + priors <= unknowns {
            return Err(OutputErrorFitError::TooFewSamples { values, unknowns });
        }
        for (place, input) in structure.inputs.iter().enumerate() {
            let names: Vec<String> = prepared
                .parameters_of_input(place)
                .iter()
                .map(|&j| &parameters[j])
                .filter(|p| p.prior.is_none())
                .map(|p| p.name.clone())
                .collect();
            let still = |record: &InputOutputRecord| {
                record.inputs.get(place).is_some_and(|u| u.windows(2).all(|two| two[0].total_cmp(&two[1]).is_eq()))
            };
            if !names.is_empty() && records.iter().all(still) {
                let value = records.iter().find_map(|record| record.inputs.get(place)?.first().copied()).unwrap_or(f64::NAN);
                return Err(OutputErrorFitError::StillInput { input: input.clone(), value, parameters: names });
            }
        }
        if noise == NoiseCovariance::Full {
            for (run, one) in runs.iter().enumerate() {
                let part = one
                    .outputs
                    .chunks_exact(layout.outputs)
                    .position(|z| z.iter().any(|z| z.is_nan()) && z.iter().any(|z| !z.is_nan()));
                if let Some(sample) = part {
                    return Err(OutputErrorFitError::NotSampledTogether { run, sample });
                }
            }
        }
        let floors = (0..layout.outputs).map(|o| LEAST_NOISE * LEAST_NOISE * spread(records, o).max(1e-200)).collect();
        let output_lines = prepared.output_lines();
        Ok(OutputErrorProblem { prepared, output_lines, parameters, runs, noise, floors, counts, watch: None })
    }

    /// The model with these values; refused where its outputs run away.
    pub(crate) fn at(
        &mut self,
        theta: Vec<f64>,
        run_parameters: Vec<RunParameters>,
    ) -> Result<OutputErrorIterate, OutputErrorFitError> {
        let point = self.prepared.at(&theta);
        let layout = &self.prepared.layout;
        let mut simulated = Vec::with_capacity(self.runs.len());
        for (run, run_parameters) in self.runs.iter_mut().zip(&run_parameters) {
            run.delay(layout, &theta);
            let steps = self.prepared.steps(&point, &run.timeline, false);
            simulated.push(simulate(layout, &point, &steps, run, run_parameters));
        }
        let runs_away = |one: &SimulatedOutputs| !one.outputs.iter().map(|y| y * y).sum::<f64>().is_finite();
        if let Some(run) = simulated.iter().position(runs_away) {
            return Err(OutputErrorFitError::Diverges { run });
        }
        let (noise_cov, whitening, mut cost) = self.noise(&simulated)?;
        for (theta, parameter) in theta.iter().zip(self.parameters) {
            if let Some((mean, std)) = parameter.prior {
                cost += 0.5 * (theta - mean) * (theta - mean) / (std * std);
            }
        }
        Ok(OutputErrorIterate { theta, run_parameters, point, simulated, noise_cov, whitening, cost })
    }

    /// (2) and the cost with it.
    fn noise(&self, simulated: &[SimulatedOutputs]) -> Result<(Dense, Whitening, f64), OutputErrorFitError> {
        let outputs = self.prepared.layout.outputs;
        let mut sums = Dense::zeros(outputs, outputs);
        for one in simulated {
            for v in one.residuals.chunks_exact(outputs) {
                for (i, vi) in v.iter().enumerate() {
                    for (j, vj) in v[..=i].iter().enumerate() {
                        if (i == j || self.noise == NoiseCovariance::Full) && !(vi * vj).is_nan() {
                            sums[(i, j)] += vi * vj;
                        }
                    }
                }
            }
        }
        let count = |o: usize| self.counts[o];
        let mut cov = Dense::from_fn(outputs, outputs, |i, j| sums[(i.max(j), i.min(j))] / count(i));
        for o in 0..outputs {
            cov[(o, o)] = cov[(o, o)].max(self.floors[o]);
        }
        if self.noise == NoiseCovariance::Diagonal {
            let costs = (0..outputs).map(|o| 0.5 * (sums[(o, o)] / cov[(o, o)] + count(o) * libm::log(cov[(o, o)])));
            let cost = costs.sum();
            let factors = cov.diagonal().iter().map(|variance| 1.0 / libm::sqrt(*variance)).collect();
            return Ok((cov, Whitening::Diagonal(factors), cost));
        }
        let factor = cov.cholesky().ok_or(OutputErrorFitError::NoiseNotPositive)?;
        let half: f64 = factor.diagonal().iter().map(|root| libm::log(*root)).sum();
        let inverse = lower_inverse(&factor);
        let cost = count(0) * (0.5 * outputs as f64 + half);
        Ok((cov, Whitening::Full(inverse), cost))
    }

    /// Puts the delays of a place into the runs.
    pub(crate) fn delay(&mut self, place: &OutputErrorIterate) {
        for run in &mut self.runs {
            run.delay(&self.prepared.layout, &place.theta);
        }
    }

    /// Information of every run at a place: theta, own, residual.
    pub(crate) fn information(&mut self, place: &OutputErrorIterate) -> Vec<Dense> {
        let mut all = Vec::with_capacity(self.runs.len());
        for ((run, simulated), run_parameters) in self.runs.iter_mut().zip(&place.simulated).zip(&place.run_parameters) {
            run.delay(&self.prepared.layout, &place.theta);
            let steps = self.prepared.steps(&place.point, &run.timeline, true);
            let linear = SensitivityModel {
                prepared: &self.prepared,
                point: &place.point,
                steps: &steps,
                output_lines: &self.output_lines,
            };
            all.push(linear.information(run, simulated, run_parameters, &place.whitening));
        }
        all
    }
}

/// Variance of an output over all records.
fn spread(records: &[InputOutputRecord], output: usize) -> f64 {
    let values = || records.iter().filter_map(|record| record.outputs.get(output)).flatten().filter(|z| z.is_finite());
    let count = values().count() as f64;
    let mean = values().sum::<f64>() / count;
    values().map(|z| (z - mean) * (z - mean)).sum::<f64>() / count
}

fn lower_inverse(factor: &Dense) -> Dense {
    let n = factor.rows();
    let mut inverse = Dense::zeros(n, n);
    for j in 0..n {
        inverse[(j, j)] = 1.0 / factor[(j, j)];
        for i in j + 1..n {
            let sum: f64 = (j..i).map(|k| factor[(i, k)] * inverse[(k, j)]).sum();
            inverse[(i, j)] = -sum / factor[(i, i)];
        }
    }
    inverse
}
