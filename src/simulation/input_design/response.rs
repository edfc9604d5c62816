//! The linear response to a manoeuvre, step by step, and what a force or moment adds to it.
//!
//! Consumes A [8 x 8], B [8 x 4] and controls over time, straight from node to node; produces the states u w q theta v p phi r
//! at the nodes. A step h of Runge-Kutta of fourth order of dz/dt = A z + d, with d at its beginning, twice in its middle and at
//! its end, is
//!     z+ = Phi z + W1 d1 + W2 d2 + W3 d3 + W4 d4                                              (1)
//!     Phi = I + hA + (hA)^2/2 + (hA)^3/6 + (hA)^4/24,   W4 = h/6 I
//!     W1 = h/6 (I + hA + (hA)^2/2 + (hA)^3/4),   W2 = h/6 (2I + hA + (hA)^2/2),   W3 = h/6 (2I + hA)
//! the same for the states (d = B c) and for each of their sensitivities, so that most steps, of one length, share the matrices.
//! Before the first control moves nothing does, and no step is made.

use crate::dynamics::linear::{INPUTS, input_matrix, state_matrix};
use crate::flight::control::CONTROLS;
use crate::flight::model::LinearModel;
use crate::flight::signal::piecewise_linear::History;
use nalgebra::{SMatrix, SVector};

pub(super) const STATES: usize = 8;
pub(super) type StateDeviations = SVector<f64, STATES>;
pub(super) type Controls = SVector<f64, CONTROLS>;
type SystemMatrix = SMatrix<f64, STATES, STATES>;

/// The longest step, s.
const STEP_S: f64 = 0.02;
/// Times nearer to each other than this are one, s.
const SAME_S: f64 = 1e-9;

/// A manoeuvre: the controls' deviations from trim, and when it is measured.
#[derive(Clone, Debug, PartialEq)]
pub struct DesignManoeuvre {
    /// By place of the control.
    pub controls: [History; CONTROLS],
    /// Length of the record, s.
    pub duration_s: f64,
    /// Samples a second.
    pub rate_hz: f64,
}

/// A time at which the manoeuvre is measured or a control bends.
#[derive(Clone, Copy, Debug)]
pub(super) struct ManoeuvreNode {
    time_s: f64,
    is_sample: bool,
    controls: Controls,
}

/// How often a manoeuvre is measured.
pub(super) fn sample_count(manoeuvre: &DesignManoeuvre) -> usize {
    let count = libm::floor(manoeuvre.duration_s * manoeuvre.rate_hz + 1e-9) + 1.0;
    if count.is_finite() && count >= 1.0 { count.min(1e7) as usize } else { 1 }
}

/// Samples, and bends between them, in order.
pub(super) fn nodes(manoeuvre: &DesignManoeuvre) -> Vec<ManoeuvreNode> {
    let count = sample_count(manoeuvre);
    let sample_s = |k: usize| k as f64 / manoeuvre.rate_hz;
    let last_s = sample_s(count - 1);
    let mut times: Vec<(f64, bool)> = (0..count).map(|k| (sample_s(k), true)).collect();
    let bends = manoeuvre.controls.iter().flat_map(|history| history.times());
    times.extend(bends.filter(|time_s| (0.0..last_s).contains(time_s)).map(|time_s| (time_s, false)));
    times.sort_by(|one, other| one.0.total_cmp(&other.0).then(other.1.cmp(&one.1)));
    let mut places = [0; CONTROLS];
    let mut nodes: Vec<ManoeuvreNode> = Vec::with_capacity(times.len());
    for (time_s, is_sample) in times {
        let mut at = |k: usize| manoeuvre.controls[INPUTS[k].index()].at_next(time_s, &mut places[k]);
        let controls = Controls::from_fn(|k, _| at(k));
        match nodes.last_mut().filter(|last| time_s - last.time_s < SAME_S) {
            Some(last) if !is_sample => last.controls = controls,
            Some(last) if !last.is_sample => *last = ManoeuvreNode { time_s, is_sample, controls },
            _ => nodes.push(ManoeuvreNode { time_s, is_sample, controls }),
        }
    }
    nodes
}

/// The matrices of (1) for one length of step.
#[derive(Clone, Debug)]
pub(super) struct StepMatrices {
    pub(super) step_s: f64,
    pub(super) phi: SystemMatrix,
    pub(super) by_drive: [SystemMatrix; 4],
    /// W1 B, (W2 + W3) B, W4 B.
    by_controls: [SMatrix<f64, STATES, CONTROLS>; 3],
}

impl StepMatrices {
    fn advance(&self, x: &StateDeviations, [begin, middle, end]: &[Controls; 3]) -> StateDeviations {
        let [first, between, last] = &self.by_controls;
        self.phi * x + first * begin + between * middle + last * end
    }
}

/// A linear aircraft, and its steps between samples.
#[derive(Clone, Debug)]
pub(super) struct LinearResponse {
    a: SystemMatrix,
    b: SMatrix<f64, STATES, CONTROLS>,
    usual: StepMatrices,
}

impl LinearResponse {
    pub(super) fn of(model: &LinearModel, rate_hz: f64) -> Self {
        let (a, b) = (state_matrix(model), input_matrix(model, &[]));
        let between_s = 1.0 / rate_hz;
        LinearResponse { a, b, usual: step_matrices(&a, &b, between_s / step_count(between_s)) }
    }

    /// Goes along the nodes: `step` sees each step with the states and controls that it begins with, `sample` each sample.
    pub(super) fn follow(
        &self,
        nodes: &[ManoeuvreNode],
        mut step: impl FnMut(&StepMatrices, &StateDeviations, &[Controls; 3]),
        mut sample: impl FnMut(&StateDeviations, &Controls),
    ) {
        let (mut x, mut now_s, mut before, mut still) = (StateDeviations::zeros(), 0.0, Controls::zeros(), true);
        for node in nodes {
            still = still && before == Controls::zeros() && node.controls == Controls::zeros();
            let length_s = node.time_s - now_s;
            if length_s > 0.0 && !still {
                let count = step_count(length_s);
                let step_s = length_s / count;
                let other;
                let matrices = if (step_s - self.usual.step_s).abs() < SAME_S {
                    &self.usual
                } else {
                    other = step_matrices(&self.a, &self.b, step_s);
                    &other
                };
                let moved = node.controls - before;
                for k in 0..count as usize {
                    let controls = [0.0, 0.5, 1.0].map(|part| before + moved * ((k as f64 + part) / count));
                    step(matrices, &x, &controls);
                    x = matrices.advance(&x, &controls);
                }
            }
            if node.is_sample {
                sample(&x, &node.controls);
            }
            (now_s, before) = (node.time_s, node.controls);
        }
    }

    /// The states at the four stages of a step.
    pub(super) fn stages(&self, h: f64, x: &StateDeviations, [begin, middle, _]: &[Controls; 3]) -> [StateDeviations; 4] {
        let rate = |x: &StateDeviations, controls: &Controls| self.a * x + self.b * controls;
        let second = x + rate(x, begin) * (0.5 * h);
        let third = x + rate(&second, middle) * (0.5 * h);
        let fourth = x + rate(&third, middle) * h;
        [*x, second, third, fourth]
    }

    /// Largest deviation of each state at the samples.
    pub(super) fn excursion(&self, nodes: &[ManoeuvreNode]) -> [f64; STATES] {
        let mut excursion = [0.0_f64; STATES];
        let most = |x: &StateDeviations, _: &Controls| {
            excursion.iter_mut().zip(x.iter()).for_each(|(most, now)| *most = most.max(now.abs()));
        };
        self.follow(nodes, |_, _, _| (), most);
        excursion
    }

    /// States that these nodes' controls move, directly or through others; the others are zero throughout.
    pub(super) fn moved_states(&self, nodes: &[ManoeuvreNode]) -> ([bool; STATES], [bool; CONTROLS]) {
        let controls: [bool; CONTROLS] = core::array::from_fn(|k| nodes.iter().any(|node| node.controls[k] != 0.0));
        let mut states = [false; STATES];
        for _ in 0..STATES {
            let by_controls = |i: usize| (0..CONTROLS).any(|k| controls[k] && self.b[(i, k)] != 0.0);
            let by_states = |i: usize| (0..STATES).any(|k| states[k] && self.a[(i, k)] != 0.0);
            states = core::array::from_fn(|i| states[i] || by_controls(i) || by_states(i));
        }
        (states, controls)
    }
}

fn step_count(length_s: f64) -> f64 {
    libm::ceil(length_s / STEP_S - SAME_S).max(1.0)
}

/// (1) for this step, s.
fn step_matrices(a: &SystemMatrix, b: &SMatrix<f64, STATES, CONTROLS>, step_s: f64) -> StepMatrices {
    let one = SystemMatrix::identity();
    let ha = a * step_s;
    let (second, sixth) = (ha * ha, step_s / 6.0);
    let third = second * ha;
    let phi = one + ha + second * 0.5 + third * (1.0 / 6.0) + third * ha * (1.0 / 24.0);
    let by_drive = [
        (one + ha + second * 0.5 + third * 0.25) * sixth,
        (one * 2.0 + ha + second * 0.5) * sixth,
        (one * 2.0 + ha) * sixth,
        one * sixth,
    ];
    let by_controls = [by_drive[0] * b, (by_drive[1] + by_drive[2]) * b, by_drive[3] * b];
    StepMatrices { step_s, phi, by_drive, by_controls }
}

#[cfg(test)]
mod tests {
    use super::super::information::tests::{manoeuvre, puma};
    use super::*;

    /// Against the classical form of Runge-Kutta in steps of a tenth of the usual ones.
    #[test]
    fn the_states_are_those_of_small_steps() {
        let model = puma();
        let flown = manoeuvre(&["pedal:3211:0.02:0.73", "lat_cyclic:doublet:0.01:0.6:6"]);
        let (response, nodes) = (LinearResponse::of(&model, flown.rate_hz), nodes(&flown));
        let mut states = Vec::new();
        response.follow(&nodes, |_, _, _| (), |x, _| states.push(*x));
        assert_eq!(states.len(), sample_count(&flown));
        let controls = |time_s: f64| Controls::from_fn(|k, _| flown.controls[INPUTS[k].index()].at(time_s));
        let rate = |x: &StateDeviations, time_s: f64| response.a * x + response.b * controls(time_s);
        let (mut x, h) = (StateDeviations::zeros(), 0.0005);
        let per_sample = (1.0 / flown.rate_hz / h).round() as usize;
        for (place, expected) in states.iter().enumerate() {
            assert!(
                (x - expected).amax() < 1e-5 * states.iter().map(|x| x.amax()).fold(0.0, f64::max),
                "{place}: {x} {expected}"
            );
            for k in 0..per_sample {
                let t = (place * per_sample + k) as f64 * h;
                let k1 = rate(&x, t);
                let k2 = rate(&(x + k1 * (0.5 * h)), t + 0.5 * h);
                let k3 = rate(&(x + k2 * (0.5 * h)), t + 0.5 * h);
                let k4 = rate(&(x + k3 * h), t + h);
                x += (k1 + k2 * 2.0 + k3 * 2.0 + k4) * (h / 6.0);
            }
        }
    }

    #[test]
    fn only_what_a_control_reaches_moves() {
        let model = puma();
        let nodes = nodes(&manoeuvre(&["pedal:doublet:0.02:0.7"]));
        let response = LinearResponse::of(&model, 20.0);
        let (moved, controls) = response.moved_states(&nodes);
        let excursion = response.excursion(&nodes);
        assert!(moved.iter().zip(excursion).all(|(moved, most)| *moved == (most > 0.0)), "{moved:?} {excursion:?}");
        assert_eq!(controls.iter().filter(|moved| **moved).count(), 1);
    }
}
