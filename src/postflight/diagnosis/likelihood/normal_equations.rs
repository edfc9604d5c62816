//! Every run at a point: the normal equations over all of them, with the priors in.
//!
//! Consumes the problem, a point and candidates; produces the cost, A and b of (1) of `problem`, ln det A + ln det Lambda of its
//! (2), and of each candidate its products with all parameters, with itself and with the innovations.

use super::filter::{FilterRequest, run_filter};
use super::parameter::RUN_OFFSETS;
use super::parameter::{ParameterKind, RunInstrumentErrors, moves_blades, parameter_kind};
use super::parameter_set::ParameterSet;
use super::problem::DiagnosisProblem;
use super::run_model::RunModel;
use super::state::{FilterNoise, FilterResult, NOISES};
use crate::flight::derivative::{AXES, Axis, Variable};
use crate::postflight::diagnosis::data::blade_input::BladeInput;
use crate::postflight::diagnosis::data::run_data::RunData;
use nalgebra::{Cholesky, DMatrix, DVector, Dyn};

/// Standard deviations of a run's own biases of accelerometers and gyros.
const BIAS_STD: [f64; 6] = [0.03, 0.03, 0.03, 0.0005, 0.0005, 0.0005];

/// The neighbourhood of a point.
#[derive(Clone, Debug)]
pub struct Linearisation {
    /// Cost with the priors.
    pub cost: f64,
    /// A of (1), its factor, and b.
    pub factor: Cholesky<f64, Dyn>,
    /// b of (1).
    pub gradient: DVector<f64>,
    /// ln det A + ln det Lambda.
    pub volume: f64,
    /// Products of the kept columns with the candidates' [kept x candidates].
    pub cross: DMatrix<f64>,
    /// Of each candidate with itself.
    pub diagonal: Vec<f64>,
    /// Of each candidate with the innovations.
    pub candidate_gradient: Vec<f64>,
    /// Root mean square force of each candidate's column.
    pub strength: Vec<f64>,
    /// Slope and second derivative of the cost by the logarithm of each noise, (3); zero where there are candidates.
    pub noise_score: [(f64, f64); NOISES],
    /// Every run.
    pub runs: Vec<FilterResult>,
}

impl Linearisation {
    /// (2).
    pub fn evidence(&self) -> f64 {
        self.cost + self.volume
    }

    /// Standard deviation of a parameter.
    pub fn std(&self, place: usize) -> f64 {
        let order = self.gradient.len();
        let mut unit = DVector::zeros(order);
        if let Some(entry) = unit.get_mut(place) {
            *entry = 1.0;
        }
        libm::sqrt(self.factor.solve(&unit).get(place).copied().unwrap_or(f64::NAN))
    }
}

/// A candidate: its column, and where that changes what reaches the blades, for every run how.
#[derive(Clone, Debug)]
pub struct CandidateParameter {
    /// What it acts on.
    pub column: ParameterKind,
    /// Changes of what reaches the blades, by run, per unit.
    pub blade_input_changes: Vec<BladeInput>,
}

/// How much is made of a pass.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Detail {
    /// The cost alone.
    Cost,
    /// And its slopes by the noises.
    Noises,
    /// Sensitivities.
    Slopes,
    /// Sensitivities, states and innovations.
    Traces,
}

/// The columns of a point's hypotheses.
fn own_columns(problem: &DiagnosisProblem, point: &ParameterSet) -> (Vec<ParameterKind>, Vec<Vec<BladeInput>>) {
    let effects = problem.effects(point);
    let mut moved: Vec<Vec<BladeInput>> = Vec::new();
    let mut columns = Vec::new();
    for (hypothesis, component) in point.places() {
        let place = problem.fixed.len() + hypothesis;
        let Some(effect) = effects.get(place) else { continue };
        columns.push(if moves_blades(effect) {
            moved.push(problem.blade_input_slope(&effects, place));
            ParameterKind::BladeInput(moved.len() - 1)
        } else {
            parameter_kind(effect, component)
        });
    }
    (columns, moved)
}

fn noise(problem: &DiagnosisProblem, run: &RunData, point: &ParameterSet) -> FilterNoise {
    let mut output = run.output_noise.map(|std| std * std);
    // An accelerometer feels the blades at once, so that the recorded controls' noise is in what it is compared with.
    for (axis, variance) in Axis::ALL.into_iter().zip(output.iter_mut().take(3)) {
        for (variable, noise) in Variable::CONTROLS.into_iter().zip(run.input_noise) {
            let by = problem.aircraft.linear.derivative(axis, variable) * noise;
            *variance += by * by;
        }
    }
    FilterNoise { force: point.force_density, gust: point.gust, output }
}

/// Every run at a point, with sensitivities to its parameters and to the candidates, or the cost alone.
pub fn linearise(
    problem: &DiagnosisProblem,
    point: &ParameterSet,
    candidates: &[&CandidateParameter],
    with: Detail,
) -> Option<Linearisation> {
    let effects = problem.effects(point);
    let model = problem.aircraft.changed(&effects, &point.derivative_errors);
    let sloped = matches!(with, Detail::Slopes | Detail::Traces);
    let (own_columns, own_moved) = if sloped { own_columns(problem, point) } else { (Vec::new(), Vec::new()) };
    let (order, shared) = problem.layout(point);
    let mut columns: Vec<ParameterKind> = Vec::new();
    if sloped {
        columns.extend(&own_columns);
        columns
            .extend(problem.derivative_tolerances.iter().map(|&(axis, variable, _)| ParameterKind::Derivative(axis, variable)));
        columns.extend(Axis::ALL.map(ParameterKind::Constant));
        columns.extend((0..6).map(ParameterKind::Bias));
    }
    let kept = columns.len();
    let mut moving = own_moved.len();
    columns.extend(candidates.iter().map(|candidate| match candidate.column {
        ParameterKind::BladeInput(_) => {
            moving += 1;
            ParameterKind::BladeInput(moving - 1)
        }
        column => column,
    }));
    let mut information = DMatrix::<f64>::zeros(order, order);
    let mut gradient = DVector::<f64>::zeros(order);
    let mut cross = DMatrix::<f64>::zeros(order, candidates.len());
    let mut diagonal = vec![0.0; candidates.len()];
    let mut candidate_gradient = vec![0.0; candidates.len()];
    let mut strength = vec![0.0; candidates.len()];
    let (mut cost, mut runs) = (0.0, Vec::new());
    let mut noise_score = [(0.0, 0.0); NOISES];
    for (number, record) in problem.runs.iter().enumerate() {
        let blade_input = problem.blade_input(record, &effects);
        let moved: Vec<&BladeInput> = own_moved
            .iter()
            .filter_map(|by_run| by_run.get(number))
            .chain(
                candidates
                    .iter()
                    .filter(|c| matches!(c.column, ParameterKind::BladeInput(_)))
                    .filter_map(|c| c.blade_input_changes.get(number)),
            )
            .collect();
        let own = point.run_offsets.get(number).copied().unwrap_or([0.0; RUN_OFFSETS]);
        let instruments = RunInstrumentErrors::of(record, &own, &effects);
        let readings = record.readings(&instruments.late_s);
        let mut constant = [0.0; AXES];
        constant.copy_from_slice(&own[..AXES]);
        let run_model = RunModel {
            record,
            model: &model,
            trim: problem.aircraft.trim(),
            blade_input: &blade_input,
            blade_input_changes: &moved,
            readings: &readings,
            constant,
            bias: instruments.bias,
            factor: instruments.factor,
            accelerometer_m: instruments.accelerometer_m,
            vane_m: instruments.vane_m,
            lag: instruments.lag,
        };
        // Nobody steps the noises by a pass that scores candidates.
        let noises = with != Detail::Cost && candidates.is_empty();
        let request = FilterRequest { columns: &columns, kept, noises, traces: with == Detail::Traces };
        let result = run_filter(&run_model, &noise(problem, record, point), request)?;
        cost += result.cost;
        let width = columns.len();
        let global = |local: usize| if local < shared { local } else { local + number * RUN_OFFSETS };
        for i in 0..kept {
            let row = &result.information[i * width..(i + 1) * width];
            gradient[global(i)] += result.gradient[i];
            for j in i..kept {
                information[(global(i), global(j))] += row[j];
            }
            for (c, value) in row[kept..].iter().enumerate() {
                cross[(global(i), c)] += value;
            }
        }
        for c in 0..candidates.len() {
            diagonal[c] += result.diagonal[kept + c];
            candidate_gradient[c] += result.gradient[kept + c];
            strength[c] = f64::max(strength[c], result.strength[kept + c]);
        }
        for (sum, (slope, curvature)) in noise_score.iter_mut().zip(result.noise_score) {
            sum.0 += slope;
            sum.1 += curvature;
        }
        runs.push(result);
    }
    let mut log_priors = 0.0;
    let mut hold = |place: usize, value: f64, std: f64| {
        let weight = 1.0 / (std * std);
        cost += value * value * weight;
        if sloped {
            information[(place, place)] += weight;
            gradient[place] -= value * weight;
        }
        log_priors += 2.0 * libm::log(std);
    };
    let places = point.places();
    for (place, &key) in places.iter().enumerate() {
        let Some(hypothesis) = point.hypotheses.get(key.0) else { continue };
        hold(place, point.number(key) - hypothesis.beforehand(key.1), hypothesis.prior_std);
    }
    for (k, &(axis, variable, std)) in problem.derivative_tolerances.iter().enumerate() {
        hold(places.len() + k, point.derivative_errors[axis.index()][variable.index()], std);
    }
    for (number, own) in point.run_offsets.iter().enumerate() {
        for (k, (value, std)) in own.iter().zip(problem.constant_std.iter().chain(&BIAS_STD)).enumerate() {
            hold(shared + number * RUN_OFFSETS + k, *value, *std);
        }
    }
    if !sloped {
        information = DMatrix::identity(order, order);
    }
    information.fill_lower_triangle_with_upper_triangle();
    let factor = Cholesky::new(information)?;
    let volume = log_priors + 2.0 * factor.l_dirty().diagonal().iter().map(|entry| libm::log(*entry)).sum::<f64>();
    Some(Linearisation { cost, factor, gradient, volume, cross, diagonal, candidate_gradient, strength, noise_score, runs })
}
