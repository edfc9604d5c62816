//! One run through the whole model: whitened innovations and their sensitivities to every column.
//!
//! Consumes a run on its mesh, the model with its hypotheses, and noise; produces the innovations e = (z - y)/sqrt(s) of every
//! reading in order of time, their cost sum(e^2 + ln s), and the sums S'S, S'e with S = dy/dtheta/sqrt(s). The state is
//! velocity, rates, attitude, height, gusts and the lag of at most one output; its motion that of `motion` with the forces of
//! `aircraft`. What the model does not explain is white noise of forces and moments, so that a wrong model does not
//! throw the state off, and a right one is as sharp as output error:
//!     x+ = x + dt f(x + f dt/2, u)        P+ = Phi P Phi' + dt Gamma q Gamma'                         (1)
//!     v = z - y,  s = H P H' + R,  K = P H'/s,  x <- x + K v,  P <- P - K s K'                           (2)
//!     dx+ = Phi dx + dt Gamma dF/dtheta        dx <- dx - K (H dx + dy/dtheta)                           (3)
//! with u the mean over each step, and K taken as independent of theta. By the logarithm of each noise density, with M = dP and
//! m = dx of it and g = M H',
//!     dv = -H m,  ds = H g,  m <- m + (g - K ds) v/s + K dv,  M <- M - K g' - g K' + K K' ds
//!     d cost = sum (2 v dv - (v^2/s - 1) ds)/s        d^2 cost = sum (ds/s)^2 + 2 dv^2/s, expected       (4)
//! Source: R. V. Jategaonkar, Flight Vehicle System Identification, 2nd ed. 2015, ch. 5 (filter error).

use super::covariance::{add_noise, correct, propagated, transition};
use super::noise_score::NoiseScore;
use super::parameter::ParameterKind;
use super::run_model::{OperatingPoint, RunModel, force_rate, initial_state};
use super::sensitivity::{NormalSums, correct_sensitivities, propagate_sensitivities, step_lag};
use super::state::{FilterNoise, FilterResult, FilterState, LAG, STATES};
use super::unseen_velocity;
use crate::flight::derivative::AXES;
use crate::flight::effect::PositionedSensor;
use crate::postflight::diagnosis::data::blade_input::InputVector;
use crate::postflight::diagnosis::data::run_data::{ALPHA_OUTPUT, BETA_OUTPUT, FLOW_OUTPUTS, FORCE_OUTPUT, RATE_OUTPUT, ROTOR};

/// States without gusts and lag.
const CORE: usize = LAG;
/// Standard deviations before the first reading.
const START_STD: [f64; STATES] = [10.0, 10.0, 10.0, 0.5, 0.5, 0.5, 0.5, 0.5, 1.0, 300.0, 0.0, 0.0, 0.0, 10.0];

/// Its standard deviation where there is none, m/s.
const START_STD_UNSEEN: f64 = 2.0;

/// What is asked of a pass.
#[derive(Clone, Copy, Debug)]
pub struct FilterRequest<'c> {
    /// Sensitivities to these.
    pub columns: &'c [ParameterKind],
    /// Rows of S'S that are kept.
    pub kept: usize,
    /// Whether the noises' slopes are summed.
    pub noises: bool,
    /// Whether states and innovations are kept.
    pub traces: bool,
}

/// Runs the filter; `None` where the motion leaves what the kinematics can carry.
pub fn run_filter(run: &RunModel<'_>, noise: &FilterNoise, request: FilterRequest<'_>) -> Option<FilterResult> {
    let record = run.record;
    let dt = record.mesh.step_s;
    let width = request.columns.len();
    let kept = request.kept.min(width);
    let gust_s = noise.gust.1.max(dt);
    let mut noise_score = request.noises.then_some(NoiseScore::START);
    let mut result = FilterResult {
        information: vec![0.0; kept * width],
        diagonal: vec![0.0; width],
        gradient: vec![0.0; width],
        strength: vec![0.0; width],
        ..FilterResult::default()
    };
    let n = if noise.gust.0 > 0.0 {
        STATES
    } else if run.lag.is_some() {
        LAG + 1
    } else {
        CORE
    };
    let mut x = initial_state(run)?;
    let mut p = [[0.0; STATES]; STATES];
    for (i, std) in START_STD.into_iter().enumerate() {
        // Without a vane the flow is near that of the trim.
        let std = if (i == 1 || i == 2) && record.outputs[FLOW_OUTPUTS[i]].is_none() { START_STD_UNSEEN } else { std };
        p[i][i] = std * std;
    }
    if run.lag.is_none() {
        p[LAG][LAG] = 0.0;
    }
    let mut d = vec![0.0f32; STATES * width];
    let mut moved_d = vec![0.0f32; STATES * width];
    let (mut forces, mut forces_before) = (vec![0.0f32; AXES * width], vec![0.0f32; AXES * width]);
    let mut rows = NormalSums::new(width, kept);
    let unseen = unseen_velocity::unseen(run);
    let lag_seen = |x: &FilterState, here: &OperatingPoint| run.lag.and_then(|(output, _)| run.predict(output, x, here));
    let mut lag_before: Option<(f64, FilterState)> = None;
    for node in 0..record.mesh.nodes {
        if request.traces {
            result.scores.resize((node + 1) * kept, 0.0);
        }
        let moved = *run.blade_input.nodes.get(node)?;
        let mut step = None;
        if node > 0 {
            let over = *run.blade_input.steps.get(node - 1)?;
            let force0 = run.force(&x, &over);
            let f0 = run.rate(&x, &force0, gust_s)?;
            let middle: FilterState = core::array::from_fn(|i| x[i] + 0.5 * dt * f0[i]);
            let force = run.force(&middle, &over);
            let f = run.rate(&middle, &force, gust_s)?;
            let by = run.model.partials(&run.deviations(&middle, &over), over[ROTOR]);
            let a = run.jacobian(&middle, &by, gust_s)?;
            let (phi, gamma) = transition(&a, dt);
            x.iter_mut().zip(&f).for_each(|(x, f)| *x += dt * f);
            p = propagated(&phi, &p, n);
            add_noise(&mut p, &gamma, noise, dt);
            if let Some(noise_score) = &mut noise_score {
                noise_score.propagate((&phi, &gamma), noise, dt, n);
            }
            step = Some((phi, gamma));
        }
        let here = run.operating_point(&x, &moved);
        if width > 0 {
            run.parameter_forces(request.columns, &here, node, &mut forces);
            if let Some((phi, gamma)) = &step {
                propagate_sensitivities(phi, gamma, &d, &mut moved_d, (&forces_before, &forces), dt, width);
                core::mem::swap(&mut d, &mut moved_d);
            }
            for (k, strength) in result.strength.iter_mut().enumerate() {
                *strength += (0..AXES).map(|axis| f64::from(forces[axis * width + k])).map(|f| f * f).sum::<f64>();
            }
        }
        if let (Some((_, tau)), Some((value, h, by_force))) = (run.lag, lag_seen(&x, &here)) {
            let now = (value, h);
            let before = lag_before.unwrap_or(now);
            step_lag(
                &mut x,
                &mut p,
                (&mut d, noise_score.as_mut()),
                (before, now),
                (tau, dt),
                request.columns,
                (&by_force, &forces),
                node == 0,
            );
            lag_before = Some(now);
        }
        let before = x;
        for &place in &unseen {
            unseen_velocity::hold(place, run, (&mut x, &mut p), (&mut d, width), noise_score.as_mut(), n)?;
        }
        let flow = run.rate(&x, &here.force, gust_s)?;
        let around = |k: usize| run.blade_input.nodes.get(k).copied().unwrap_or(moved);
        let (earlier, later) = (around(node.saturating_sub(1)), around(node + 1));
        let turning: InputVector = core::array::from_fn(|i| (later[i] - earlier[i]) / (2.0 * dt));
        for reading in run.readings.at(node) {
            let c = reading.output;
            let lagged = run.lag.is_some_and(|(output, _)| output == c);
            // Forces are those of the prediction; a correction within the node moves them by their slopes.
            let here = run.updated(here, &x, &before);
            let (mut value, mut h, by_force) = run.predict(c, &x, &here)?;
            // Of an accelerometer the controls' own motion counts: taken across the node, so that their noise there does not.
            let pushed = |axis: usize| force_rate(&here, axis, &turning);
            let slope = h.iter().zip(&flow).map(|(h, f)| h * f).sum::<f64>()
                + by_force
                    .iter()
                    .enumerate()
                    .filter(|(_, weight)| **weight != 0.0)
                    .map(|(axis, weight)| weight * pushed(axis))
                    .sum::<f64>();
            if lagged {
                value = x[LAG];
                h = [0.0; STATES];
                h[LAG] = 1.0;
            }
            let factor = run.factor[c];
            value += reading.late_s * slope;
            let predicted = factor * value + run.bias[c];
            h.iter_mut().for_each(|slope| *slope *= factor);
            let mut ph = [0.0; STATES];
            for (ph, row) in ph.iter_mut().zip(&p).take(n) {
                *ph = row.iter().zip(&h).take(n).map(|(p, h)| p * h).sum();
            }
            let s = h.iter().zip(&ph).map(|(h, ph)| h * ph).sum::<f64>() + noise.output[c] / reading.count;
            if !(s.is_finite() && s > 0.0) {
                return None;
            }
            let v = reading.value - predicted;
            let root = libm::sqrt(s);
            let e = v / root;
            result.cost += e * e + libm::log(s);
            result.squares[c].0 += e * e;
            result.squares[c].1 += 1.0;
            if request.traces {
                result.innovations.push((node, c, e));
            }
            let gain: FilterState = core::array::from_fn(|i| ph[i] / s);
            if width > 0 {
                let row = rows.next();
                for (state, slope) in h.iter().enumerate() {
                    if *slope != 0.0 {
                        let column = &d[state * width..(state + 1) * width];
                        let slope = *slope as f32;
                        row.iter_mut().zip(column).for_each(|(row, d)| *row += slope * d);
                    }
                }
                if !lagged {
                    for (axis, weight) in by_force.into_iter().enumerate() {
                        if weight != 0.0 {
                            let own = &forces[axis * width..(axis + 1) * width];
                            let weight = (factor * weight) as f32;
                            row.iter_mut().zip(own).for_each(|(row, force)| *row += weight * force);
                        }
                    }
                }
                for (k, &column) in request.columns.iter().enumerate() {
                    match column {
                        ParameterKind::Bias(output) if output == c => row[k] += 1.0,
                        ParameterKind::Scale(output) if output == c => row[k] += value as f32,
                        ParameterKind::Timing(output) if output == c => row[k] -= (factor * slope) as f32,
                        ParameterKind::Place(sensor, axis) if !lagged => {
                            let of = match c {
                                FORCE_OUTPUT..RATE_OUTPUT => Some(PositionedSensor::Accelerometer),
                                ALPHA_OUTPUT | BETA_OUTPUT => Some(PositionedSensor::Vane),
                                _ => None,
                            };
                            if of == Some(sensor) {
                                row[k] += (factor * run.by_sensor_position(c, axis, &x, &here)) as f32;
                            }
                        }
                        _ => {}
                    }
                }
                correct_sensitivities(&mut d, row, &gain);
                let per_root = (1.0 / root) as f32;
                row.iter_mut().for_each(|entry| *entry *= per_root);
                let scores = result.scores.iter_mut().skip(node * kept);
                scores.zip(row.iter()).for_each(|(score, s)| *score += f64::from(*s) * e);
                rows.take(e, &mut result);
            }
            if let Some(noise_score) = &mut noise_score {
                noise_score.correct(&h, &gain, (v, s), &mut result.noise_score, n);
            }
            correct(&mut x, &mut p, (&gain, &ph), v, n);
            if !x.iter().all(|x| x.is_finite()) {
                return None;
            }
        }
        if request.traces {
            result.states.push(x);
        }
        core::mem::swap(&mut forces, &mut forces_before);
    }
    rows.finish(&mut result);
    let nodes = record.mesh.nodes.max(1) as f64;
    result.strength.iter_mut().for_each(|strength| *strength = libm::sqrt(*strength / nodes));
    Some(result)
}
