//! Predictions over a short horizon: a run cut into windows, each predicted from the state at its beginning as the filter of the
//! diagnosis has it by then.
//!
//! Consumes a model, effects and a run on its mesh; produces, for each channel at the nodes of the mesh, the measured mean z and
//! the predicted y. Nothing of model or effects is fitted to the run; its own offsets of forces, moments and instruments are, for
//! no run is flown in exactly the model's trim, and noise of the recorded controls over the first second would become a drift.
//! From the beginning of a window on, without any reading, over n steps,
//!     x_k+1 = x_k + dt f(x_k + f dt/2, u_k)     y_k = h(x_k)                                          (1)
//! with u the mean recorded controls over each step and f, h those of `run_model`. Both models of a comparison are served alike:
//! each by its own filter, with its own noise of forces.
//! A free run over the whole record, which a small difference of trim leads away, is `free_run`.

use crate::flight::channel::Channel;
use crate::flight::derivative::AXES;
use crate::flight::effect::Effect;
use crate::flight::signal::readings::Reading;
use crate::postflight::diagnosis::data::blade_input::InputVector;
use crate::postflight::diagnosis::data::run_data::{OUTPUT_CHANNELS, OUTPUTS, RunData};
use crate::postflight::diagnosis::likelihood::aircraft::Aircraft;
use crate::postflight::diagnosis::likelihood::maximise::{Effort, maximise};
use crate::postflight::diagnosis::likelihood::normal_equations::{Detail, linearise};
use crate::postflight::diagnosis::likelihood::parameter::{RunInstrumentErrors, output_of};
use crate::postflight::diagnosis::likelihood::parameter_set::ParameterSet;
use crate::postflight::diagnosis::likelihood::problem::DiagnosisProblem;
use crate::postflight::diagnosis::likelihood::run_model::{RunModel, force_rate};
use crate::postflight::diagnosis::likelihood::state::{FilterState, LAG};
use crate::postflight::validation::free_run::{FreeRunPrediction, PredictedChannel};
use crate::simulation::flight_model::FlightModel;
use crate::simulation::fly::recorded_as;

/// Length of a window, s.
pub const HORIZON_S: f64 = 2.0;

/// A run predicted window by window. Where the model cannot be filtered along the run, it diverges at its start.
pub fn predict_over_horizon(model: &FlightModel, effects: &[Effect], run: &RunData) -> FreeRunPrediction {
    let flown: Vec<Effect> = effects.iter().copied().filter(|effect| !matches!(effect, Effect::Turbulence { .. })).collect();
    let mut problem =
        DiagnosisProblem::new(Aircraft::of(model), flown.clone(), vec![run.clone()], model.file.tolerance, &model.file.stds);
    // The model as it is, without what it may be off by.
    problem.derivative_tolerances.clear();
    let (first_s, last_s) = (run.mesh.time_s(0), run.mesh.time_s(run.mesh.nodes.saturating_sub(1)));
    let unpredicted = FreeRunPrediction {
        channels: Vec::new(),
        not_predicted: Vec::new(),
        effects: flown,
        diverged_at_s: Some(first_s),
        range_s: [first_s, last_s],
    };
    let Some((point, states)) = filtered(&problem) else { return unpredicted };
    let Predictions { of_output, diverged_at_s } = predict_windows(&problem, &point, (0, &states), HORIZON_S);
    let channels = of_output.into_iter().enumerate().filter(|(output, pairs)| is_covered(&problem, *output) && !pairs.is_empty());
    FreeRunPrediction {
        channels: channels
            .filter_map(|(output, pairs)| {
                let (place, pairs) = as_recorded(&unpredicted.effects, output, pairs);
                channel(run, place, pairs)
            })
            .collect(),
        diverged_at_s,
        ..unpredicted
    }
}

/// The error of the model by channel: mean over runs of mean (z - y)^2/sigma^2, sigma the noise of z. None where it cannot be
/// followed along any run.
pub(crate) fn errors_over_horizon(model: &FlightModel, effects: &[Effect], runs: &[RunData]) -> Vec<(Channel, f64)> {
    let predictions = runs.iter().flat_map(|run| predict_over_horizon(model, effects, run).channels);
    let mut sums: Vec<(Channel, f64, f64)> = Vec::new();
    for one in predictions {
        let squares = one.measured.iter().zip(&one.predicted).map(|(z, y)| (z - y) / one.noise_std).map(|e| e * e);
        let error = squares.sum::<f64>() / one.measured.len().max(1) as f64;
        match sums.iter_mut().find(|(channel, ..)| *channel == one.channel) {
            _ if !error.is_finite() => {}
            Some((_, sum, count)) => (*sum, *count) = (*sum + error, *count + 1.0),
            None => sums.push((one.channel, error, 1.0)),
        }
    }
    sums.into_iter().map(|(channel, sum, count)| (channel, sum / count)).collect()
}

/// Under the name and in the sign of the record: the problem has it as it should have been recorded.
fn as_recorded(effects: &[Effect], output: usize, mut pairs: Vec<PredictedReading>) -> (usize, Vec<PredictedReading>) {
    let mut place = output;
    for effect in effects {
        match *effect {
            Effect::SensorScale { factor, .. } if factor < 0.0 && output_of(effect) == Some(place) => {
                for (_, reading, predicted) in &mut pairs {
                    (reading.value, *predicted) = (-reading.value, -*predicted);
                }
            }
            Effect::Exchanged { .. } => {
                let named = OUTPUT_CHANNELS.get(place).map(|&channel| recorded_as(channel, &[*effect]));
                place = OUTPUT_CHANNELS.iter().position(|channel| Some(*channel) == named).unwrap_or(place);
            }
            _ => {}
        }
    }
    (place, pairs)
}

/// The run's own offsets where they settle, and the states of the filter there.
fn filtered(problem: &DiagnosisProblem) -> Option<(ParameterSet, Vec<FilterState>)> {
    let start = problem.null_hypothesis();
    let point = maximise(problem, start.clone(), Effort::SETTLED).map_or(start, |(point, _)| point);
    let local = linearise(problem, &point, &[], Detail::Traces)?;
    let states = local.runs.into_iter().next()?.states;
    Some((point, states))
}

/// Axes that an output is a prediction of: where the model is silent on one, the output is measured motion.
fn axes_of(output: usize) -> &'static [usize] {
    match OUTPUT_CHANNELS.get(output) {
        Some(Channel::Ax | Channel::Tas) => &[0],
        Some(Channel::Ay | Channel::Beta) => &[1],
        Some(Channel::Az | Channel::Alpha | Channel::Altitude) => &[2],
        Some(Channel::P | Channel::Phi) => &[3],
        Some(Channel::Q | Channel::Theta) => &[4],
        _ => &[5],
    }
}

/// Whether the model covers every axis that an output is a prediction of.
pub(crate) fn is_covered(problem: &DiagnosisProblem, output: usize) -> bool {
    axes_of(output).iter().all(|&axis| !problem.unmodelled[axis])
}

/// Of one output at one node: time, reading, prediction.
pub(crate) type PredictedReading = (f64, Reading, f64);

/// Predictions of a run, up to where the motion leaves what the kinematics can carry.
#[derive(Default)]
pub(crate) struct Predictions {
    pub(crate) of_output: [Vec<PredictedReading>; OUTPUTS],
    pub(crate) diverged_at_s: Option<f64>,
}

/// (1) from the beginning of every window of that length of a run, by its number and the states of the filter.
pub(crate) fn predict_windows(
    problem: &DiagnosisProblem,
    point: &ParameterSet,
    (number, states): (usize, &[FilterState]),
    horizon_s: f64,
) -> Predictions {
    let mut predictions = Predictions::default();
    let (Some(record), Some(own)) = (problem.runs.get(number), point.run_offsets.get(number)) else { return predictions };
    let effects = problem.effects(point);
    let model = problem.aircraft.changed(&effects, &point.derivative_errors);
    let blade_input = problem.blade_input(record, &effects);
    let instruments = RunInstrumentErrors::of(record, own, &effects);
    let readings = record.readings(&instruments.late_s);
    let mut constant = [0.0; AXES];
    constant.copy_from_slice(&own[..AXES]);
    let run = RunModel {
        record,
        model: &model,
        trim: problem.aircraft.trim(),
        blade_input: &blade_input,
        blade_input_changes: &[],
        readings: &readings,
        constant,
        bias: instruments.bias,
        factor: instruments.factor,
        accelerometer_m: instruments.accelerometer_m,
        vane_m: instruments.vane_m,
        lag: instruments.lag,
    };
    let steps = (libm::round(horizon_s / record.mesh.step_s) as usize).max(1);
    for begin in (0..states.len()).step_by(steps) {
        let Some(&start) = states.get(begin) else { break };
        if let Err(node) = window(&run, start, (begin, steps), &mut predictions.of_output) {
            predictions.diverged_at_s.get_or_insert(record.mesh.time_s(node));
        }
    }
    predictions
}

/// One window; the node where the motion leaves what the kinematics can carry.
fn window(
    run: &RunModel<'_>,
    mut x: FilterState,
    (begin, steps): (usize, usize),
    of_output: &mut [Vec<PredictedReading>; OUTPUTS],
) -> Result<(), usize> {
    let dt = run.record.mesh.step_s;
    // Gusts to come are none.
    x.iter_mut().skip(LAG + 1).for_each(|gust| *gust = 0.0);
    let mut lag_before = None;
    for node in begin..(begin + steps).min(run.record.mesh.nodes) {
        let Some(&moved) = run.blade_input.nodes.get(node) else { break };
        if node > begin {
            let Some(over) = run.blade_input.steps.get(node - 1) else { break };
            let rate = |x: &FilterState| run.rate(x, &run.force(x, over), f64::INFINITY);
            let first = rate(&x).ok_or(node)?;
            let middle: FilterState = core::array::from_fn(|i| x[i] + 0.5 * dt * first[i]);
            let second = rate(&middle).ok_or(node)?;
            x.iter_mut().zip(&second).for_each(|(x, rate)| *x += dt * rate);
        }
        let here = run.operating_point(&x, &moved);
        if let Some((output, tau)) = run.lag {
            let (now, ..) = run.predict(output, &x, &here).ok_or(node)?;
            let before = lag_before.replace(now).unwrap_or(now);
            if node > begin {
                x[LAG] += (1.0 - libm::exp(-dt / tau.max(1e-4))) * (0.5 * (before + now) - x[LAG]);
            }
        }
        // The beginning's own readings are in its state.
        if node == begin {
            continue;
        }
        let flow = run.rate(&x, &here.force, f64::INFINITY).ok_or(node)?;
        let around = |node: usize| run.blade_input.nodes.get(node).copied().unwrap_or(moved);
        let (earlier, later) = (around(node - 1), around(node + 1));
        let turning: InputVector = core::array::from_fn(|i| (later[i] - earlier[i]) / (2.0 * dt));
        for reading in run.readings.at(node) {
            let (value, slopes, by_force) = run.predict(reading.output, &x, &here).ok_or(node)?;
            let lagged = run.lag.is_some_and(|(output, _)| output == reading.output);
            let pushed = by_force.iter().enumerate().filter(|(_, weight)| **weight != 0.0);
            let slope = slopes.iter().zip(&flow).map(|(h, rate)| h * rate).sum::<f64>()
                + pushed.map(|(axis, weight)| weight * force_rate(&here, axis, &turning)).sum::<f64>();
            let value = if lagged { x[LAG] } else { value } + reading.late_s * slope;
            let predicted = run.factor[reading.output] * value + run.bias[reading.output];
            if !predicted.is_finite() {
                return Err(node);
            }
            of_output[reading.output].push((run.record.mesh.time_s(node) + reading.late_s, *reading, predicted));
        }
    }
    Ok(())
}

/// A channel's pairs as a prediction, its noise that of the means.
fn channel(run: &RunData, output: usize, pairs: Vec<PredictedReading>) -> Option<PredictedChannel> {
    let count = pairs.iter().map(|(_, reading, _)| reading.count).sum::<f64>() / pairs.len() as f64;
    let noise_std = run.recorded_noise.get(output)? / libm::sqrt(count.max(1.0));
    let predicted: Vec<f64> = pairs.iter().map(|(.., predicted)| *predicted).collect();
    Some(PredictedChannel {
        channel: *OUTPUT_CHANNELS.get(output)?,
        times_s: pairs.iter().map(|(time_s, ..)| *time_s).collect(),
        measured: pairs.iter().map(|(_, reading, _)| reading.value).collect(),
        at_trim: *predicted.first()?,
        predicted,
        offset: 0.0,
        noise_std,
    })
}
