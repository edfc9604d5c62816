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
//! Numerics: (1), (2) by Runge-Kutta of fourth order from bend to bend of the controls, steps of 20 ms at most.

use crate::dynamics::linear::{AXIS_ROWS, INPUTS, VARIABLE_STATES, input_matrix, state_matrix};
use crate::flight::channel::Channel;
use crate::flight::control::CONTROLS;
use crate::flight::derivative::{Axis, Variable};
use crate::flight::model::LinearModel;
use crate::flight::signal::piecewise_linear::History;
use crate::simulation::instrument::InstrumentSet;
use nalgebra::{SMatrix, SVector};

/// The longest step of (1) and (2), s.
const STEP_S: f64 = 0.02;

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

struct Slopes {
    a: SMatrix<f64, 8, 8>,
    b: SMatrix<f64, 8, 4>,
}

/// Variable's value in states and controls.
fn value(variable: Variable, x: &SVector<f64, 8>, c: &SVector<f64, 4>) -> f64 {
    let state = VARIABLE_STATES.iter().find(|(of, _)| *of == variable).map(|&(_, place)| x[place]);
    let control = || INPUTS.iter().position(|input| input.variable() == variable).map(|place| c[place]);
    state.or_else(control).unwrap_or(0.0)
}

impl InputInformation {
    /// Information of one manoeuvre about those derivatives.
    pub fn of(
        model: &LinearModel,
        parameters: &[DesignParameter],
        outputs: &[MeasuredOutput],
        manoeuvre: &DesignManoeuvre,
    ) -> Self {
        let (a, b) = (state_matrix(model), input_matrix(model, &[]));
        let slopes: Vec<Slopes> = parameters.iter().map(slopes).collect();
        let n = parameters.len();
        let count = sample_count(manoeuvre);
        let mut times: Vec<(f64, bool)> = (0..count).map(|k| (k as f64 / manoeuvre.rate_hz, true)).collect();
        let last_s = times.last().map_or(0.0, |(time_s, _)| *time_s);
        let bends = manoeuvre.controls.iter().flat_map(History::times);
        times.extend(bends.filter(|time_s| (0.0..last_s).contains(time_s)).map(|time_s| (time_s, false)));
        times.sort_by(|one, other| one.0.total_cmp(&other.0));
        let mut x = vec![SVector::<f64, 8>::zeros(); n + 1];
        let mut sums = vec![0.0; outputs.len() * n];
        let mut fisher = vec![vec![0.0; n]; n];
        let mut excursion = [0.0_f64; 8];
        let mut now_s = 0.0;
        let controls = |time_s: f64| SVector::<f64, 4>::from(INPUTS.map(|input| manoeuvre.controls[input.index()].at(time_s)));
        for (time_s, is_sample) in times {
            let steps = libm::ceil((time_s - now_s) / STEP_S).max(0.0);
            let h = (time_s - now_s) / steps.max(1.0);
            for k in 0..steps as usize {
                step(&mut x, now_s + h * k as f64, h, &a, &b, &slopes, &controls);
            }
            now_s = time_s;
            if !is_sample {
                continue;
            }
            let c = controls(time_s);
            if let Some(state) = x.first() {
                excursion.iter_mut().zip(state.iter()).for_each(|(most, now)| *most = most.max(now.abs()));
            }
            for (output, sums) in outputs.iter().zip(sums.chunks_mut(n.max(1))) {
                let s: Vec<f64> = sensitivities(model, output, parameters, &x, &c);
                for (i, (row, si)) in fisher.iter_mut().zip(&s).enumerate() {
                    row.iter_mut().zip(&s).take(i + 1).for_each(|(entry, sj)| *entry += si * sj);
                }
                sums.iter_mut().zip(&s).for_each(|(sum, s)| *sum += s);
            }
        }
        // The mean of each channel is its bias's.
        for sums in sums.chunks(n.max(1)) {
            for (i, (row, si)) in fisher.iter_mut().zip(sums).enumerate() {
                row.iter_mut().zip(sums).take(i + 1).for_each(|(entry, sj)| *entry -= si * sj / count as f64);
            }
        }
        mirror(&mut fisher);
        InputInformation { parameters: parameters.to_vec(), fisher, excursion }
    }
}

/// Copies the lower triangle into the upper.
#[expect(clippy::needless_range_loop, reason = "indices are those of the matrix")]
fn mirror(matrix: &mut [Vec<f64>]) {
    for i in 0..matrix.len() {
        for j in 0..i {
            matrix[j][i] = matrix[i][j];
        }
    }
}

fn sample_count(manoeuvre: &DesignManoeuvre) -> usize {
    let count = libm::floor(manoeuvre.duration_s * manoeuvre.rate_hz + 1e-9) + 1.0;
    if count.is_finite() && count >= 1.0 { count.min(1e7) as usize } else { 1 }
}

fn slopes(parameter: &DesignParameter) -> Slopes {
    let (mut a, mut b) = (SMatrix::zeros(), SMatrix::zeros());
    let row = AXIS_ROWS.iter().find(|(axis, _)| *axis == parameter.axis).map(|&(_, row)| row);
    let column = VARIABLE_STATES.iter().find(|(variable, _)| *variable == parameter.variable).map(|&(_, column)| column);
    let input = INPUTS.iter().position(|input| input.variable() == parameter.variable);
    match (row, column, input) {
        (Some(row), Some(column), _) => a[(row, column)] = 1.0,
        (Some(row), None, Some(input)) => b[(row, input)] = 1.0,
        _ => {}
    }
    Slopes { a, b }
}

/// (3) for one output.
fn sensitivities(
    model: &LinearModel,
    output: &MeasuredOutput,
    parameters: &[DesignParameter],
    x: &[SVector<f64, 8>],
    c: &SVector<f64, 4>,
) -> Vec<f64> {
    let Some((state, slopes)) = x.split_first() else { return Vec::new() };
    let none = SVector::<f64, 4>::zeros();
    let force = |axis: Axis, of: &SVector<f64, 8>| -> f64 {
        let terms = VARIABLE_STATES.iter().map(|&(variable, _)| model.derivative(axis, variable) * value(variable, of, &none));
        terms.sum()
    };
    let one = |(parameter, slope): (&DesignParameter, &SVector<f64, 8>)| {
        let through_states = match output.axis {
            None => output.states.dot(slope),
            Some(axis) => force(axis, slope),
        };
        let direct = if output.axis == Some(parameter.axis) { value(parameter.variable, state, c) } else { 0.0 };
        (through_states + direct) / output.noise_std
    };
    parameters.iter().zip(slopes).map(one).collect()
}

/// One step of (1) and (2).
fn step(
    x: &mut [SVector<f64, 8>],
    from_s: f64,
    h: f64,
    a: &SMatrix<f64, 8, 8>,
    b: &SMatrix<f64, 8, 4>,
    slopes: &[Slopes],
    controls: &impl Fn(f64) -> SVector<f64, 4>,
) {
    let c = [controls(from_s), controls(from_s + 0.5 * h), controls(from_s + h)];
    let rate = |x: &SVector<f64, 8>, drive: SVector<f64, 8>| a * x + drive;
    let Some((state, sensitivities)) = x.split_first_mut() else { return };
    // The states at the stages drive the sensitivities at theirs.
    let x1 = *state;
    let k1 = rate(&x1, b * c[0]);
    let x2 = x1 + k1 * (0.5 * h);
    let k2 = rate(&x2, b * c[1]);
    let x3 = x1 + k2 * (0.5 * h);
    let k3 = rate(&x3, b * c[1]);
    let x4 = x1 + k3 * h;
    let k4 = rate(&x4, b * c[2]);
    *state = x1 + (k1 + k2 * 2.0 + k3 * 2.0 + k4) * (h / 6.0);
    for (s, slope) in sensitivities.iter_mut().zip(slopes) {
        let s1 = *s;
        let k1 = rate(&s1, slope.a * x1 + slope.b * c[0]);
        let k2 = rate(&(s1 + k1 * (0.5 * h)), slope.a * x2 + slope.b * c[1]);
        let k3 = rate(&(s1 + k2 * (0.5 * h)), slope.a * x3 + slope.b * c[1]);
        let k4 = rate(&(s1 + k3 * h), slope.a * x4 + slope.b * c[2]);
        *s = s1 + (k1 + k2 * 2.0 + k3 * 2.0 + k4) * (h / 6.0);
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use crate::flight::control::Control;
    use crate::flight::file::model_file::ModelFile;
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
