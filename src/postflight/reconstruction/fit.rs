//! Joint fit of several runs: instrument errors shared by all runs, and each run's own.
//!
//! Consumes records with their noise, and which parameters are free; minimises
//!     J = sum_runs sum(e^2 + ln s) + sum theta_i^2/sigma_i^2                                          (1)
//! (sigma normal or free, see `parameter`) by Gauss-Newton with step halving on the innovations of `filter`. With C the
//! inverse of the information and theta the minimum, releasing parameter i (its prior from sigma to the free one) gives
//!     theta' = theta/(1 - D C_ii),  C' = C_ii/(1 - D C_ii),  J falls by theta^2 D/(1 - D C_ii)          (2)
//! with D = 1/sigma^2 - 1/sigma_free^2: every hypothesis is judged from one matrix, the other parameters refitted.
//! Residuals of flight data are coloured: the variance of theta_i is that for white ones times
//!     c = sum_l rho(l) sum_k g_k g_(k+l)/sum_k g_k^2                                                (3)
//! with g the row of influence of theta_i on the readings of each output and rho the innovations' correlation there.
//! Source of (3): E. A. Morelli and V. Klein, J. Aircraft 34(2), 1997.

use super::filter::{KinematicNoise, Prepared, RunInnovations, pass};
use super::parameter::{
    ACCELEROMETER_PLACE, ALPHA_PLACE, BETA_PLACE, InstrumentError, MEASURED, MISALIGNMENT, OUTPUTS, PARAMETERS, PER_RUN, SCALE,
    TIMING, Theta, VANE_PLACE,
};
use super::record::InstrumentErrorKind;
use super::run_channels::RunChannels;
use crate::postflight::work_progress::{Watch, is_stopped};
use nalgebra::DMatrix;

/// Parameters that hold over all runs.
pub const SHARED: usize = PARAMETERS - PER_RUN;
/// Correlations of the innovations are counted up to this, s.
const COLOUR_S: f64 = 1.0;
/// Part of a sample by which healthy channels are apart.
const TIMING_SAMPLES: f64 = 0.1;
const STEPS_MAX: usize = 8;
/// Convergence: predicted decrease of (1).
const CLOSE: f64 = 0.05;
/// The same for fits that are only compared with each other.
pub const ROUGH: f64 = 0.5;
/// Precision that holds parameters without prior at zero.
const HELD: f64 = 1e18;

/// A run with its noise.
#[derive(Clone, Debug)]
pub struct RunWithNoise {
    /// The channels.
    pub record: RunChannels,
    /// Their noise.
    pub noise: KinematicNoise,
    /// Parameters that act on this run's channels.
    pub active: Vec<usize>,
    /// Who watches fits of it, and may end them: then none has a result.
    pub watch: Watch,
}

/// Parameter values, and which are free.
#[derive(Clone, Debug, PartialEq)]
pub struct ParameterPoint {
    /// Those of all runs, then each run's own.
    pub values: Vec<f64>,
    /// By channel: whether its timing is a lag.
    pub lag: [bool; MEASURED],
    /// Which are free, by place among `values`.
    pub free: Vec<usize>,
    /// Interval of the slowest run's gyros, s: instruments that are read in turn are apart by up to so much.
    pub sample_s: f64,
}

/// The place among all values of a run's parameter.
pub fn place_of(run: usize, index: usize) -> usize {
    if index < PER_RUN { SHARED + run * PER_RUN + index } else { index - PER_RUN }
}

/// The parameter at a place among all values, and the run that it belongs to where it is one run's own.
pub fn parameter_at(place: usize) -> (InstrumentError, Option<usize>) {
    match place.checked_sub(SHARED) {
        None => (InstrumentError::at(place + PER_RUN), None),
        Some(own) => (InstrumentError::at(own % PER_RUN), Some(own / PER_RUN)),
    }
}

impl ParameterPoint {
    /// No error anywhere.
    pub fn zero(runs: &[RunWithNoise]) -> Self {
        let sample_s = runs.iter().map(|run| run.record.sample_s).fold(0.0, f64::max);
        ParameterPoint { values: vec![0.0; SHARED + runs.len() * PER_RUN], lag: [false; MEASURED], free: Vec::new(), sample_s }
    }

    /// The parameters of one run.
    pub fn theta(&self, run: usize) -> Theta {
        let values = core::array::from_fn(|index| self.values.get(place_of(run, index)).copied().unwrap_or(0.0));
        Theta { values, lag: self.lag }
    }

    /// Standard deviation of a parameter's prior.
    pub fn prior_std(&self, place: usize) -> Option<f64> {
        let (normal, free) = self.priors(place)?;
        Some(if self.free.contains(&place) { free } else { normal })
    }

    /// Standard deviations, normal and free: of timing at least a tenth of a sample.
    pub fn priors(&self, place: usize) -> Option<(f64, f64)> {
        let parameter = parameter_at(place).0;
        let (normal, free) = parameter.priors()?;
        let sampled = if parameter.kind == InstrumentErrorKind::Timing { TIMING_SAMPLES * self.sample_s } else { 0.0 };
        Some((normal.max(sampled.min(free)), free))
    }

    /// The prior's part of (1).
    pub fn prior_cost(&self) -> f64 {
        (0..self.values.len()).map(|place| self.prior_at(place)).sum()
    }

    /// That of one run's own parameters.
    pub fn own_prior_cost(&self, run: usize) -> f64 {
        (0..PER_RUN).map(|index| self.prior_at(place_of(run, index))).sum()
    }

    fn prior_at(&self, place: usize) -> f64 {
        let value = self.values.get(place).copied().unwrap_or(0.0);
        self.prior_std(place).map_or(0.0, |std| value * value / (std * std))
    }
}

/// (1) linearised about a point: normal equations of Gauss-Newton.
#[derive(Clone, Debug)]
pub struct FitLinearisation {
    /// (1).
    pub cost: f64,
    /// Inverse of the information, C.
    pub dispersion: DMatrix<f64>,
    /// Minus half the gradient of (1).
    pub pull: Vec<f64>,
    /// Each run through the filter there.
    pub runs: Vec<RunInnovations>,
}

/// Which parameters act on a record.
pub fn active(record: &RunChannels) -> Vec<usize> {
    let has = |measured: usize| {
        let inputs = record.inputs.len();
        match measured.checked_sub(inputs) {
            None => record.inputs[measured].is_some() && (measured >= 3 || record.velocities),
            Some(output) => record.outputs[output].is_some(),
        }
    };
    let vanes = |output: usize| record.outputs[output].is_some();
    (0..PARAMETERS)
        .filter(|&index| {
            let parameter = InstrumentError::at(index);
            parameter.priors().is_some()
                && match (parameter.measured, index) {
                    (Some(measured), _) => has(measured),
                    (None, MISALIGNMENT..) => true,
                    (None, ALPHA_PLACE..BETA_PLACE) => vanes(1),
                    (None, BETA_PLACE..VANE_PLACE) => vanes(2),
                    (None, VANE_PLACE..ACCELEROMETER_PLACE) => vanes(1) || vanes(2),
                    (None, _) => record.velocities,
                }
        })
        .collect()
}

/// (1) at a point; `None` where the filter fails.
pub fn cost(runs: &[RunWithNoise], point: &ParameterPoint) -> Option<f64> {
    let mut sum = point.prior_cost();
    for (place, run) in runs.iter().enumerate() {
        sum += pass(&Prepared::of(&run.record, &point.theta(place)), &run.noise, &[], true)?.cost;
    }
    Some(sum)
}

/// Linearises (1) about a point.
pub fn linearise(runs: &[RunWithNoise], point: &ParameterPoint) -> Option<FitLinearisation> {
    if runs.iter().any(|run| is_stopped(run.watch)) {
        return None;
    }
    let order = point.values.len();
    let mut information = DMatrix::<f64>::zeros(order, order);
    let mut pull = vec![0.0; order];
    let mut cost = point.prior_cost();
    let mut passes = Vec::with_capacity(runs.len());
    for (number, run) in runs.iter().enumerate() {
        let passed = pass(&Prepared::of(&run.record, &point.theta(number)), &run.noise, &run.active, false)?;
        cost += passed.cost;
        let width = run.active.len();
        let mut own = DMatrix::<f64>::zeros(width, width);
        let mut side = vec![0.0; width];
        for (row, innovation) in passed.rows.chunks(width.max(1)).zip(&passed.innovations) {
            for (i, a) in row.iter().enumerate() {
                side[i] += a * innovation.whitened;
                for (entry, b) in own.as_mut_slice()[i * width + i..(i + 1) * width].iter_mut().zip(&row[i..]) {
                    *entry += a * b;
                }
            }
        }
        for (i, side) in side.into_iter().enumerate() {
            let global = place_of(number, run.active[i]);
            pull[global] += side;
            for j in 0..width {
                information[(global, place_of(number, run.active[j]))] += own[(i.max(j), i.min(j))];
            }
        }
        passes.push(passed);
    }
    for (place, (pull, value)) in pull.iter_mut().zip(&point.values).enumerate() {
        match point.prior_std(place) {
            Some(std) => {
                information[(place, place)] += 1.0 / (std * std);
                *pull -= value / (std * std);
            }
            None => information[(place, place)] += HELD,
        }
    }
    let dispersion = information.cholesky()?.inverse();
    Some(FitLinearisation { cost, dispersion, pull, runs: passes })
}

fn times(matrix: &DMatrix<f64>, column: &[f64]) -> Vec<f64> {
    matrix.row_iter().map(|row| row.iter().zip(column).map(|(a, b)| a * b).sum()).collect()
}

/// Goes to the minimum of (1) from a point; returns it with its neighbourhood.
pub fn minimise(runs: &[RunWithNoise], start: &ParameterPoint) -> Option<(ParameterPoint, FitLinearisation)> {
    minimise_to(runs, start, CLOSE)
}

/// The same until no more than `tolerance` is left to gain.
pub fn minimise_to(runs: &[RunWithNoise], start: &ParameterPoint, tolerance: f64) -> Option<(ParameterPoint, FitLinearisation)> {
    let mut point = start.clone();
    let mut local = linearise(runs, &point)?;
    for _ in 0..STEPS_MAX {
        let step = local.step();
        let promised: f64 = step.iter().zip(&local.pull).map(|(a, b)| a * b).sum();
        if promised < tolerance {
            break;
        }
        let mut length = 1.0;
        let mut better = None;
        for _ in 0..6 {
            let mut tried = point.clone();
            tried.values.iter_mut().zip(&step).for_each(|(value, step)| *value += length * step);
            bound(&mut tried);
            if let Some(next) = linearise(runs, &tried).filter(|next| next.cost < local.cost) {
                better = Some((tried, next));
                break;
            }
            length *= 0.4;
        }
        let Some((next_point, next)) = better else { break };
        let gained = local.cost - next.cost;
        (point, local) = (next_point, next);
        if gained < tolerance {
            break;
        }
    }
    Some((point, local))
}

/// Keeps a lag positive and a factor away from zero.
fn bound(point: &mut ParameterPoint) {
    for measured in 0..MEASURED {
        if point.lag[measured] {
            let value = &mut point.values[TIMING + measured - PER_RUN];
            *value = value.clamp(0.002, 2.0);
        }
        let timing = &mut point.values[TIMING + measured - PER_RUN];
        *timing = timing.clamp(-1.0, 2.0);
        let factor = &mut point.values[SCALE + measured - PER_RUN];
        *factor = factor.clamp(-0.8, 3.0);
    }
}

/// A parameter released by (2): its estimate under the free prior.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Released {
    /// Its place.
    pub place: usize,
    /// Its value.
    pub value: f64,
    /// Its standard error for white residuals.
    pub std: f64,
    /// How much (1) falls.
    pub fall: f64,
}

impl FitLinearisation {
    /// The step to the minimum of the linearised (1), which falls there by its product with the pull.
    pub fn step(&self) -> Vec<f64> {
        times(&self.dispersion, &self.pull)
    }

    /// The minimum of the linearised (1).
    pub fn minimum(&self, point: &ParameterPoint) -> Vec<f64> {
        point.values.iter().zip(self.step()).map(|(value, step)| value + step).collect()
    }

    /// (2) of one parameter.
    pub fn released(&self, point: &ParameterPoint, minimum: &[f64], place: usize) -> Option<Released> {
        let (normal, free) = point.priors(place)?;
        let variance = self.dispersion[(place, place)];
        let value = *minimum.get(place)?;
        if point.free.contains(&place) {
            return Some(Released { place, value, std: libm::sqrt(variance), fall: 0.0 });
        }
        let drop = 1.0 / (normal * normal) - 1.0 / (free * free);
        let rest = 1.0 - drop * variance;
        if !(rest > 1e-9) {
            return None;
        }
        Some(Released { place, value: value / rest, std: libm::sqrt(variance / rest), fall: value * value * drop / rest })
    }

    /// Variance of a sum of parameters for white residuals.
    pub fn variance_of(&self, places: &[usize]) -> f64 {
        places.iter().flat_map(|&i| places.iter().map(move |&j| self.dispersion[(i, j)])).sum()
    }

    /// (3): how much larger the variance of a sum of parameters is for the residuals being coloured; at least one.
    pub fn colour(&self, runs: &[RunWithNoise], places: &[usize]) -> f64 {
        let (mut with, mut without) = (0.0, 0.0);
        for (number, (run, passed)) in runs.iter().zip(&self.runs).enumerate() {
            let weight = |&index: &usize| places.iter().map(|&place| self.dispersion[(place_of(number, index), place)]).sum();
            let weights: Vec<f64> = run.active.iter().map(weight).collect();
            let width = run.active.len().max(1);
            let mut by_output: [Vec<(f64, f64)>; OUTPUTS] = Default::default();
            for (row, innovation) in passed.rows.chunks(width).zip(&passed.innovations) {
                let influence: f64 = row.iter().zip(&weights).map(|(a, b)| a * b).sum();
                by_output[innovation.output].push((innovation.whitened, influence));
            }
            for series in by_output.iter().filter(|series| series.len() > 10) {
                let interval_s = run.record.mesh.length_s() / series.len() as f64;
                let lags = ((COLOUR_S / interval_s) as usize).clamp(1, series.len() / 4);
                let at_lag = |lag: usize, of: fn(&(f64, f64)) -> f64| -> f64 {
                    series.iter().zip(series.iter().skip(lag)).map(|(a, b)| of(a) * of(b)).sum()
                };
                let power = at_lag(0, |x| x.0);
                let influence = at_lag(0, |x| x.1);
                without += influence;
                let mean_square = power / series.len() as f64;
                let mut sum = influence;
                for lag in 1..=lags {
                    let taper = 1.0 - lag as f64 / (lags + 1) as f64;
                    sum += 2.0 * taper * at_lag(lag, |x| x.0) / power * at_lag(lag, |x| x.1);
                }
                with += mean_square * sum;
            }
        }
        if without > 0.0 { (with / without).max(1.0) } else { 1.0 }
    }
}
