//! The outputs of the model over one run, and the residuals.
//!
//! Consumes a prepared run, the discrete steps of the model and the run parameters; produces, row after row of samples, states
//! x, outputs y and residuals v = z - y, NaN where an output was not sampled:
//!     y_k = C x_k + D u_k + c,   x_(k+1) = Phi x_k + G0 u_k + G1 u_(k+1) + Psi1 b                   (1)
//! Not finite where the model diverges; the cost then is not finite either, and the search refuses the step.

use super::discrete::{DiscreteStep, ModelMatrices, Timeline, UnknownLayout};
use super::input_delay::delayed_input;
use super::model::InputOutputRecord;
use super::run_parameters::RunParameters;
use crate::num::product::dot;

/// A run in the order in which it is gone through.
#[derive(Clone, Debug)]
pub struct PreparedRun {
    /// Samples.
    pub samples: usize,
    /// Intervals.
    pub timeline: Timeline,
    times_s: Vec<f64>,
    recorded: Vec<Vec<f64>>,
    /// Inputs as they act, by sample then input.
    pub inputs: Vec<f64>,
    /// Derivatives of delayed inputs, by sample then delay.
    pub input_changes: Vec<f64>,
    /// Outputs as measured, by sample then output.
    pub outputs: Vec<f64>,
    /// By output: how often it was sampled.
    pub counts: Vec<usize>,
    /// Of the white noise on each input; none where it is empty.
    pub input_noise_std: Vec<f64>,
}

fn interleaved(series: &[Vec<f64>], samples: usize) -> Vec<f64> {
    (0..samples).flat_map(|k| series.iter().map(move |one| one[k])).collect()
}

impl PreparedRun {
    /// Of a record that has been checked.
    pub fn new(record: &InputOutputRecord, layout: &UnknownLayout) -> Self {
        let samples = record.times_s.len();
        let counts = record.outputs.iter().map(|output| output.iter().filter(|z| z.is_finite()).count()).collect();
        PreparedRun {
            samples,
            timeline: Timeline::new(record),
            times_s: record.times_s.clone(),
            recorded: record.inputs.clone(),
            inputs: interleaved(&record.inputs, samples),
            input_changes: vec![0.0; samples * layout.delays.len()],
            outputs: interleaved(&record.outputs, samples),
            counts,
            input_noise_std: record.input_noise_std.clone(),
        }
    }

    /// Puts the delays at theta into the inputs.
    pub fn delay(&mut self, layout: &UnknownLayout, theta: &[f64]) {
        let (inputs, delays) = (layout.inputs, layout.delays.len());
        for (place, delay) in layout.delays.iter().enumerate() {
            let tau = theta.get(delay.parameter).copied().unwrap_or(f64::NAN);
            let recorded = self.recorded.get(delay.input).map_or(&[][..], Vec::as_slice);
            let (values, changes) = delayed_input(&self.times_s, recorded, tau);
            for (slot, value) in self.inputs.iter_mut().skip(delay.input).step_by(inputs).zip(values) {
                *slot = value;
            }
            for (slot, change) in self.input_changes.iter_mut().skip(place).step_by(delays).zip(changes) {
                *slot = change;
            }
        }
    }
}

/// What came out.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SimulatedOutputs {
    /// By sample then state.
    pub states: Vec<f64>,
    /// By sample then output.
    pub outputs: Vec<f64>,
    /// Residuals, by sample then output.
    pub residuals: Vec<f64>,
}

/// Goes through one run.
pub fn simulate(
    layout: &UnknownLayout,
    point: &ModelMatrices,
    steps: &[DiscreteStep],
    run: &PreparedRun,
    run_parameters: &RunParameters,
) -> SimulatedOutputs {
    let (n, m, outputs) = (layout.states, layout.inputs, layout.outputs);
    let mut states = vec![0.0; run.samples * n];
    let mut predicted = vec![0.0; run.samples * outputs];
    let mut x = run_parameters.initial_state.clone();
    let mut next = vec![0.0; n];
    let forced: Vec<Vec<f64>> =
        steps.iter().map(|step| rows(&step.psi1, n, n).map(|row| dot(row, &run_parameters.state_bias)).collect()).collect();
    for k in 0..run.samples {
        let u = &run.inputs[k * m..(k + 1) * m];
        states[k * n..(k + 1) * n].copy_from_slice(&x);
        for (o, y) in predicted[k * outputs..(k + 1) * outputs].iter_mut().enumerate() {
            *y = run_parameters.output_bias[o] + dot(&point.c[o * n..(o + 1) * n], &x) + dot(&point.d[o * m..(o + 1) * m], u);
        }
        let Some(&which) = run.timeline.which.get(k) else { break };
        let later = &run.inputs[(k + 1) * m..(k + 2) * m];
        let step = &steps[which];
        for (i, slot) in next.iter_mut().enumerate() {
            *slot = forced[which][i]
                + dot(&step.phi[i * n..(i + 1) * n], &x)
                + dot(&step.gamma0[i * m..(i + 1) * m], u)
                + dot(&step.gamma1[i * m..(i + 1) * m], later);
        }
        core::mem::swap(&mut x, &mut next);
    }
    let residuals = run.outputs.iter().zip(&predicted).map(|(z, y)| z - y).collect();
    SimulatedOutputs { states, outputs: predicted, residuals }
}

fn rows(matrix: &[f64], rows: usize, columns: usize) -> impl Iterator<Item = &[f64]> {
    (0..rows).map(move |i| &matrix[i * columns..(i + 1) * columns])
}
