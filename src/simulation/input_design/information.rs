//! Fisher information of a test input: what standard errors output error could reach at best.
//!
//! Consumes a linear model, the derivatives theta to be known, instruments and controls over time; produces their information
//! matrix F ([`super::dispersion`] turns it into standard errors). States x = u w q theta v p phi r, deviations from trim,
//!     dx/dt = A(theta) x + B(theta) c                                                       (1)
//!     dx_j/dt = A x_j + (dA/dtheta_j) x + (dB/dtheta_j) c,   x_j(0) = 0                     (2)
//!     y = C(theta) x + E(theta) c + b,   s_j = dy/dtheta_j                                  (3)
//!     F = Sum_k Sum_channels (s_j - mean s_j)(s_i - mean s_i) / sigma^2                     (4)
//! where taking out the mean accounts for an unknown bias b of each channel. Specific forces are those of the model's X, Y, Z;
//! flow angles and airspeed are linearised; all at the centre of mass.
//! Source: Maine and Iliff, Application of Parameter Estimation to Aircraft Stability and Control, NASA RP 1168 (1986), ch. 5;
//! Padfield et al. 1987, section 2.1, names the criterion.
//! Numerics: (1), (2) by Runge-Kutta of fourth order from bend to bend of the controls, steps of 20 ms at most (`response`).
//! Derivatives of what the controls do not reach are left out of the sums: their rows and columns of F are zero.

pub use super::response::DesignManoeuvre;
use super::response::{Controls, LinearResponse, ManoeuvreNode, STATES, StateDeviations, StepMatrices, nodes, sample_count};
use crate::dynamics::linear::{AXIS_ROWS, INPUTS, VARIABLE_STATES};
use crate::flight::channel::Channel;
use crate::flight::derivative::{Axis, Variable};
use crate::flight::model::LinearModel;
use crate::simulation::instrument::InstrumentSet;
use core::cell::RefCell;
use nalgebra::SVector;

/// A derivative by its name.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct DesignParameter {
    /// Its axis.
    pub axis: Axis,
    /// Its variable.
    pub variable: Variable,
}

/// A channel that is measured, and how well.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MeasuredOutput {
    /// Which.
    pub channel: Channel,
    /// Standard deviation of its white noise.
    pub noise_std: f64,
    /// Derivative of its reading with respect to the states.
    states: SVector<f64, 8>,
    /// The force that it feels, where it is an accelerometer.
    axis: Option<Axis>,
}

/// The outputs that those instruments read, controls and what does not depend on (1) left out.
pub fn outputs(model: &LinearModel, instruments: &InstrumentSet) -> Vec<MeasuredOutput> {
    let trim = &model.trim;
    let speed = trim.airspeed();
    let plane = libm::hypot(trim.u, trim.w);
    let one = |place: usize| SVector::from_fn(|row, _| if row == place { 1.0 } else { 0.0 });
    let of = |u: f64, v: f64, w: f64| SVector::from([u, w, 0.0, 0.0, v, 0.0, 0.0, 0.0]);
    let row = |channel: Channel| {
        Some(match channel {
            Channel::Ax => (SVector::zeros(), Some(Axis::X)),
            Channel::Ay => (SVector::zeros(), Some(Axis::Y)),
            Channel::Az => (SVector::zeros(), Some(Axis::Z)),
            Channel::P => (one(5), None),
            Channel::Q => (one(2), None),
            Channel::R => (one(7), None),
            Channel::Phi => (one(6), None),
            Channel::Theta => (one(3), None),
            Channel::Tas => (of(trim.u / speed, trim.v / speed, trim.w / speed), None),
            Channel::Alpha => (of(-trim.w / (plane * plane), 0.0, trim.u / (plane * plane)), None),
            Channel::Beta => {
                let along = -trim.v / (plane * speed * speed);
                (of(along * trim.u, plane / (speed * speed), along * trim.w), None)
            }
            _ => return None,
        })
    };
    let noisy = instruments.channels.iter().filter(|instrument| instrument.noise_std > 0.0);
    let read = noisy.filter_map(|instrument| {
        let (states, axis) = row(instrument.channel)?;
        let finite = states.iter().all(|entry: &f64| entry.is_finite());
        finite.then_some(MeasuredOutput { channel: instrument.channel, noise_std: instrument.noise_std, states, axis })
    });
    read.collect()
}

/// What a manoeuvre brings.
#[derive(Clone, Debug, PartialEq)]
pub struct InputInformation {
    /// The derivatives, in the order of rows and columns.
    pub parameters: Vec<DesignParameter>,
    /// F, row by row; (4).
    pub fisher: Vec<Vec<f64>>,
    /// Largest deviation of each state, u w q theta v p phi r.
    pub excursion: [f64; 8],
}

/// What a derivative is multiplied by: a state or a control by its place.
#[derive(Clone, Copy, Debug)]
enum DesignRegressor {
    State(usize),
    Control(usize),
}

impl DesignRegressor {
    fn of(variable: Variable) -> Option<Self> {
        let state = VARIABLE_STATES.iter().find(|(of, _)| *of == variable).map(|&(_, place)| DesignRegressor::State(place));
        state.or_else(|| INPUTS.iter().position(|input| input.variable() == variable).map(DesignRegressor::Control))
    }

    fn value(self, x: &StateDeviations, c: &Controls) -> f64 {
        match self {
            DesignRegressor::State(place) => x[place],
            DesignRegressor::Control(place) => c[place],
        }
    }
}

/// A derivative that this manoeuvre shows: where it stands among all, the state that it drives, what it is multiplied by.
#[derive(Clone, Copy, Debug)]
struct MovedParameter {
    place: usize,
    axis: Axis,
    row: usize,
    regressor: DesignRegressor,
}

/// An output's reading by the states, divided by its noise, without zeros.
struct OutputRow {
    by_state: Vec<(usize, f64)>,
    axis: Option<Axis>,
    per_noise: f64,
}

impl OutputRow {
    fn of(model: &LinearModel, output: &MeasuredOutput) -> Self {
        let mut states = output.states;
        if let Some(axis) = output.axis {
            VARIABLE_STATES.iter().for_each(|&(variable, place)| states[place] += model.derivative(axis, variable));
        }
        let per_noise = 1.0 / output.noise_std;
        let by_state = states.iter().enumerate().filter(|(_, by)| **by != 0.0).map(|(place, by)| (place, by * per_noise));
        OutputRow { by_state: by_state.collect(), axis: output.axis, per_noise }
    }
}

impl InputInformation {
    /// Information of one manoeuvre about those derivatives.
    pub fn of(
        model: &LinearModel,
        parameters: &[DesignParameter],
        outputs: &[MeasuredOutput],
        manoeuvre: &DesignManoeuvre,
    ) -> Self {
        let (response, nodes) = (LinearResponse::of(model, manoeuvre.rate_hz), nodes(manoeuvre));
        let (states, controls) = response.moved_states(&nodes);
        let moved = |(place, parameter): (usize, &DesignParameter)| {
            let &(_, row) = AXIS_ROWS.iter().find(|(axis, _)| *axis == parameter.axis)?;
            let regressor = DesignRegressor::of(parameter.variable).filter(|regressor| match regressor {
                DesignRegressor::State(place) => states[*place],
                DesignRegressor::Control(place) => controls[*place],
            })?;
            Some(MovedParameter { place, axis: parameter.axis, row, regressor })
        };
        let moved: Vec<MovedParameter> = parameters.iter().enumerate().filter_map(moved).collect();
        let sums = measured(model, &response, &nodes, &moved, outputs);
        let (n, width, count) = (parameters.len(), sums.width, sample_count(manoeuvre) as f64);
        let mut fisher = vec![vec![0.0; n]; n];
        for (i, one) in moved.iter().enumerate() {
            for (j, other) in moved.iter().enumerate().take(i + 1) {
                // The mean of each channel is its bias's.
                let means: f64 = sums.outputs.chunks_exact(width).map(|sums| sums[i] * sums[j]).sum();
                let entry = sums.products[i * width + j] - means / count;
                fisher[one.place][other.place] = entry;
                fisher[other.place][one.place] = entry;
            }
        }
        InputInformation { parameters: parameters.to_vec(), fisher, excursion: sums.excursion }
    }

    /// Largest deviation of each state, u w q theta v p phi r, of one manoeuvre: what [`InputInformation::of`] has too, sooner.
    pub fn excursion(model: &LinearModel, manoeuvre: &DesignManoeuvre) -> [f64; 8] {
        LinearResponse::of(model, manoeuvre.rate_hz).excursion(&nodes(manoeuvre))
    }
}

/// Sums over the samples of a manoeuvre, of derivatives padded to `width`.
struct MeasuredSums {
    width: usize,
    /// s_i s_j over outputs and samples, lower triangle [width x width].
    products: Vec<f64>,
    /// s_i of each output over the samples [outputs x width].
    outputs: Vec<f64>,
    excursion: [f64; 8],
}

/// So many sensitivities are worked on at once.
const LANES: usize = 4;
/// So many rows of sensitivities are gathered before their products are summed.
const ROWS: usize = 64;

/// (2), (3) and the sums of (4).
fn measured(
    model: &LinearModel,
    response: &LinearResponse,
    nodes: &[ManoeuvreNode],
    moved: &[MovedParameter],
    outputs: &[MeasuredOutput],
) -> MeasuredSums {
    let width = moved.len().next_multiple_of(LANES).max(LANES);
    let output_rows: Vec<OutputRow> = outputs.iter().map(|output| OutputRow::of(model, output)).collect();
    // Sensitivities of the states [8 x width].
    let (sensitivities, mut next) = (RefCell::new(vec![0.0; STATES * width]), vec![0.0; STATES * width]);
    let mut sums = MeasuredSums {
        width,
        products: vec![0.0; width * width],
        outputs: vec![0.0; outputs.len() * width],
        excursion: [0.0; 8],
    };
    let mut rows: Vec<f64> = Vec::with_capacity((ROWS + outputs.len()) * width);
    let step = |matrices: &StepMatrices, x: &StateDeviations, controls: &[Controls; 3]| {
        let stages = response.stages(matrices.step_s, x, controls);
        let [begin, middle, end] = controls;
        let controls = [begin, middle, middle, end];
        let mut sensitivities = sensitivities.borrow_mut();
        for (i, row) in next.chunks_exact_mut(width).enumerate() {
            row.fill(0.0);
            for (k, from) in sensitivities.chunks_exact(width).enumerate() {
                let by = matrices.phi[(i, k)];
                if by != 0.0 {
                    row.iter_mut().zip(from).for_each(|(to, from)| *to += by * from);
                }
            }
        }
        for (j, parameter) in moved.iter().enumerate() {
            let drive: [f64; 4] = core::array::from_fn(|stage| parameter.regressor.value(&stages[stage], controls[stage]));
            for (i, row) in next.chunks_exact_mut(width).enumerate() {
                let by = |stage: usize| matrices.by_drive[stage][(i, parameter.row)] * drive[stage];
                row[j] += by(0) + by(1) + by(2) + by(3);
            }
        }
        core::mem::swap(&mut *sensitivities, &mut next);
    };
    let sample = |x: &StateDeviations, c: &Controls| {
        sums.excursion.iter_mut().zip(x.iter()).for_each(|(most, now)| *most = most.max(now.abs()));
        let sensitivities = sensitivities.borrow();
        for (output, sum) in output_rows.iter().zip(sums.outputs.chunks_exact_mut(width)) {
            let from = rows.len();
            rows.resize(from + width, 0.0);
            let Some(row) = rows.get_mut(from..) else { continue };
            for &(place, by) in &output.by_state {
                let of_state = sensitivities.chunks_exact(width).nth(place).unwrap_or_default();
                row.iter_mut().zip(of_state).for_each(|(to, from)| *to += by * from);
            }
            for (to, parameter) in row.iter_mut().zip(moved).filter(|(_, parameter)| output.axis == Some(parameter.axis)) {
                *to += parameter.regressor.value(x, c) * output.per_noise;
            }
            sum.iter_mut().zip(&*row).for_each(|(sum, s)| *sum += s);
        }
        if rows.len() >= ROWS * width {
            add_products(&mut sums.products, &rows, width);
            rows.clear();
        }
    };
    response.follow(nodes, step, sample);
    add_products(&mut sums.products, &rows, width);
    sums
}

/// Adds the products of all pairs in each row, of which the lower triangle counts.
fn add_products(products: &mut [f64], rows: &[f64], width: usize) {
    for (i, of_i) in products.chunks_exact_mut(width).enumerate() {
        for (block, entries) in of_i.chunks_exact_mut(LANES).enumerate().take(i / LANES + 1) {
            let mut sums = [0.0; LANES];
            for row in rows.chunks_exact(width) {
                let (own, others) = (row[i], &row[block * LANES..(block + 1) * LANES]);
                sums.iter_mut().zip(others).for_each(|(sum, other)| *sum += own * other);
            }
            entries.iter_mut().zip(sums).for_each(|(entry, sum)| *entry += sum);
        }
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use crate::flight::control::{CONTROLS, Control};
    use crate::flight::file::model_file::ModelFile;
    use crate::flight::signal::piecewise_linear::History;
    use crate::simulation::fly::{Flight, Inputs, uniform_times};
    use crate::simulation::input::InputSpec;

    pub(crate) fn puma() -> LinearModel {
        ModelFile::parse(include_str!("../../../replay/models/puma-like.toml")).unwrap().linear
    }

    pub(crate) fn manoeuvre(texts: &[&str]) -> DesignManoeuvre {
        let mut controls = [const { None }; CONTROLS].map(|_: Option<()>| History::constant(0.0));
        for text in texts {
            let spec = InputSpec::parse(text).unwrap();
            let control = Control::ALL.into_iter().find(|control| control.channel() == spec.channel).unwrap();
            controls[control.index()] = controls[control.index()].plus(1.0, &spec.deviation(1.0));
        }
        DesignManoeuvre { controls, duration_s: 12.0, rate_hz: 20.0 }
    }

    pub(crate) const LATERAL: [(Axis, Variable); 7] = [
        (Axis::N, Variable::V),
        (Axis::N, Variable::P),
        (Axis::N, Variable::R),
        (Axis::N, Variable::Pedal),
        (Axis::L, Variable::P),
        (Axis::Y, Variable::V),
        (Axis::L, Variable::LatCyclic),
    ];

    /// Readings of the nonlinear simulation with a derivative changed by that much.
    fn flown(model: &LinearModel, manoeuvre: &DesignManoeuvre, parameter: DesignParameter, delta: f64) -> Vec<f64> {
        let mut changed = model.clone();
        *changed.derivative_mut(parameter.axis, parameter.variable) += delta;
        let mut inputs = Inputs::at_trim(model);
        for (history, deviation) in inputs.controls.iter_mut().zip(&manoeuvre.controls) {
            *history = history.plus(1.0, deviation);
        }
        let times_s = uniform_times(0.0, manoeuvre.duration_s, manoeuvre.rate_hz).unwrap();
        let flight = Flight { inputs, times_s, max_step_s: Some(0.01), ..Flight::of(changed) };
        let outputs = outputs(model, &InstrumentSet::flight_quality(1.0));
        let samples = flight.fly().unwrap().samples;
        outputs
            .iter()
            .flat_map(|output| samples.iter().map(|sample| sample.get(output.channel).unwrap() / output.noise_std))
            .collect()
    }

    #[test]
    fn it_is_what_differences_of_the_nonlinear_simulation_give_for_small_inputs() {
        let model = puma();
        // So small that the kinematics are linear.
        let manoeuvre = manoeuvre(&["pedal:3211:0.00002:0.7", "lat_cyclic:doublet:0.00001:0.6:6"]);
        let parameters = LATERAL.map(|(axis, variable)| DesignParameter { axis, variable });
        let outputs = outputs(&model, &InstrumentSet::flight_quality(1.0));
        let information = InputInformation::of(&model, &parameters, &outputs, &manoeuvre);
        let slopes = parameters.map(|parameter| {
            let delta = 1e-3 * model.derivative(parameter.axis, parameter.variable).abs();
            let (up, down) = (flown(&model, &manoeuvre, parameter, delta), flown(&model, &manoeuvre, parameter, -delta));
            let slope: Vec<f64> = up.iter().zip(&down).map(|(up, down)| (up - down) / (2.0 * delta)).collect();
            let count = slope.len() / outputs.len();
            let mean = |channel: &[f64]| channel.iter().sum::<f64>() / count as f64;
            slope
                .chunks(count)
                .flat_map(|channel| channel.iter().map(|s| s - mean(channel)).collect::<Vec<_>>())
                .collect::<Vec<_>>()
        });
        for i in 0..parameters.len() {
            for j in 0..=i {
                let expected: f64 = slopes[i].iter().zip(&slopes[j]).map(|(a, b)| a * b).sum();
                let scale = (information.fisher[i][i] * information.fisher[j][j]).sqrt();
                assert!(
                    (information.fisher[i][j] - expected).abs() < 2e-3 * scale,
                    "{i} {j}: {} {expected}",
                    information.fisher[i][j]
                );
            }
        }
    }
}
