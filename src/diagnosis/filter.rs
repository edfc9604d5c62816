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

use super::column::Column;
use super::covariance::{add_noise, propagated, transition};
use super::driven::Moved;
use super::noisier::Noisier;
use super::posed::{Here, Posed, pushed_by, start};
use super::run_record::{OUTPUTS, ROTOR};
use super::slopes::{Gathered, propagate_columns, step_lag};
use crate::flight::derivative::AXES;
use crate::flight::effect::PositionedSensor;

/// Velocity, rates, attitude, height, gusts, a lag.
pub const STATES: usize = 14;
/// Place of the lag of an output among the states.
pub const LAG: usize = 10;
/// Place of the gusts among the states.
pub const GUST: usize = 11;
/// States without gusts and lag.
const CORE: usize = 10;
/// Standard deviations before the first reading.
const START_STD: [f64; STATES] = [10.0, 10.0, 10.0, 0.5, 0.5, 0.5, 0.5, 0.5, 1.0, 300.0, 0.0, 0.0, 0.0, 10.0];

/// The vane that shows a component of the velocity.
const FLOW: [usize; 3] = [9, 11, 10];
/// Its standard deviation where there is none, m/s.
const START_STD_UNSEEN: f64 = 2.0;

/// Noises that are found: of six axes, and of gusts.
pub const NOISES: usize = AXES + 1;

/// The state.
pub type State = [f64; STATES];
/// A matrix over it.
pub type Square = [[f64; STATES]; STATES];

/// Noise of one run.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Noise {
    /// Spectral density of forces and moments by axis, (m/s^2)^2 s and (rad/s^2)^2 s.
    pub force: [f64; AXES],
    /// Standard deviation of each gust component, m/s, and its time constant L/V, s.
    pub gust: (f64, f64),
    /// Variance of one sample of each output.
    pub output: [f64; OUTPUTS],
}

/// What came of a run.
#[derive(Clone, Debug, Default)]
pub struct Passed {
    /// Sum of squares and logarithms of variances.
    pub cost: f64,
    /// By output: sum of squared whitened innovations, and their number.
    pub squares: [(f64, f64); OUTPUTS],
    /// Slope of the cost by the logarithm of each density, gusts' last, and its expected second derivative.
    pub noisier: [(f64, f64); NOISES],
    /// S'S, the first `kept` rows of it, [kept x columns].
    pub information: Vec<f64>,
    /// Diagonal of S'S.
    pub diagonal: Vec<f64>,
    /// S'e.
    pub pull: Vec<f64>,
    /// Root mean square of each column's force, where it has one: of its axis.
    pub strength: Vec<f64>,
    /// States after each node's readings.
    pub states: Vec<State>,
    /// Whitened innovations: node, output, value; only where asked for.
    pub innovations: Vec<(usize, usize, f64)>,
}

/// What is asked of a pass.
#[derive(Clone, Copy, Debug)]
pub struct Asked<'c> {
    /// Sensitivities to these.
    pub columns: &'c [Column],
    /// Rows of S'S that are kept.
    pub kept: usize,
    /// Whether the noises' slopes are summed.
    pub noises: bool,
    /// Whether states and innovations are kept.
    pub traces: bool,
}

/// Runs the filter; `None` where the motion leaves what the kinematics can carry.
pub fn pass(posed: &Posed<'_>, noise: &Noise, asked: Asked<'_>) -> Option<Passed> {
    let record = posed.record;
    let dt = record.mesh.step_s;
    let width = asked.columns.len();
    let kept = asked.kept.min(width);
    let gust_s = noise.gust.1.max(dt);
    let mut noisier = asked.noises.then_some(Noisier::START);
    let mut passed = Passed {
        information: vec![0.0; kept * width],
        diagonal: vec![0.0; width],
        pull: vec![0.0; width],
        strength: vec![0.0; width],
        ..Passed::default()
    };
    let n = if noise.gust.0 > 0.0 {
        STATES
    } else if posed.lag.is_some() {
        LAG + 1
    } else {
        CORE
    };
    let mut x = start(posed)?;
    let mut p = [[0.0; STATES]; STATES];
    for (i, std) in START_STD.into_iter().enumerate() {
        // Without a vane the flow is near that of the trim.
        let std = if (i == 1 || i == 2) && record.outputs[FLOW[i]].is_none() { START_STD_UNSEEN } else { std };
        p[i][i] = std * std;
    }
    if posed.lag.is_none() {
        p[LAG][LAG] = 0.0;
    }
    let mut d = vec![0.0f32; STATES * width];
    let mut moved_d = vec![0.0f32; STATES * width];
    let (mut forces, mut forces_before) = (vec![0.0f32; AXES * width], vec![0.0f32; AXES * width]);
    let mut rows = Gathered::new(width, kept);
    let lag_seen = |x: &State, here: &Here| posed.lag.and_then(|(output, _)| posed.seen(output, x, here));
    let mut lag_before: Option<(f64, State)> = None;
    for node in 0..record.mesh.nodes {
        let moved = *posed.driven.nodes.get(node)?;
        let mut step = None;
        if node > 0 {
            let over = *posed.driven.steps.get(node - 1)?;
            let force0 = posed.force(&x, &over);
            let f0 = posed.rate(&x, &force0, gust_s)?;
            let middle: State = core::array::from_fn(|i| x[i] + 0.5 * dt * f0[i]);
            let force = posed.force(&middle, &over);
            let f = posed.rate(&middle, &force, gust_s)?;
            let by = posed.model.partials(&posed.deviations(&middle, &over), over[ROTOR]);
            let a = posed.jacobian(&middle, &by, gust_s)?;
            let (phi, gamma) = transition(&a, dt);
            x.iter_mut().zip(&f).for_each(|(x, f)| *x += dt * f);
            p = propagated(&phi, &p, n);
            add_noise(&mut p, &gamma, noise, dt);
            if let Some(noisier) = &mut noisier {
                noisier.propagate((&phi, &gamma), noise, dt, n);
            }
            step = Some((phi, gamma));
        }
        let here = posed.here(&x, &moved);
        if width > 0 {
            posed.all_forces(asked.columns, &here, node, &mut forces);
            if let Some((phi, gamma)) = &step {
                propagate_columns(phi, gamma, &d, &mut moved_d, (&forces_before, &forces), dt, width);
                core::mem::swap(&mut d, &mut moved_d);
            }
            for (k, strength) in passed.strength.iter_mut().enumerate() {
                *strength += (0..AXES).map(|axis| f64::from(forces[axis * width + k])).map(|f| f * f).sum::<f64>();
            }
        }
        if let (Some((_, tau)), Some((value, h, by_force))) = (posed.lag, lag_seen(&x, &here)) {
            let now = (value, h);
            let before = lag_before.unwrap_or(now);
            step_lag(
                &mut x,
                &mut p,
                (&mut d, noisier.as_mut()),
                (before, now),
                (tau, dt),
                asked.columns,
                (&by_force, &forces),
                node == 0,
            );
            lag_before = Some(now);
        }
        let before = x;
        let flow = posed.rate(&x, &here.force, gust_s)?;
        let around = |k: usize| posed.driven.nodes.get(k).copied().unwrap_or(moved);
        let (earlier, later) = (around(node.saturating_sub(1)), around(node + 1));
        let turning: Moved = core::array::from_fn(|i| (later[i] - earlier[i]) / (2.0 * dt));
        for reading in posed.readings.at(node) {
            let c = reading.output;
            let lagged = posed.lag.is_some_and(|(output, _)| output == c);
            // Forces are those of the prediction; a correction within the node moves them by their slopes.
            let here = posed.at(here, &x, &before);
            let (mut value, mut h, by_force) = posed.seen(c, &x, &here)?;
            // Of an accelerometer the controls' own motion counts: taken across the node, so that their noise there does not.
            let pushed = |axis: usize| pushed_by(&here, axis, &turning);
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
            let factor = posed.factor[c];
            value += reading.late_s * slope;
            let predicted = factor * value + posed.bias[c];
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
            passed.cost += e * e + libm::log(s);
            passed.squares[c].0 += e * e;
            passed.squares[c].1 += 1.0;
            if asked.traces {
                passed.innovations.push((node, c, e));
            }
            let gain: State = core::array::from_fn(|i| ph[i] / s);
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
                for (k, &column) in asked.columns.iter().enumerate() {
                    match column {
                        Column::Bias(output) if output == c => row[k] += 1.0,
                        Column::Scale(output) if output == c => row[k] += value as f32,
                        Column::Timing(output) if output == c => row[k] -= (factor * slope) as f32,
                        Column::Place(sensor, axis) if !lagged => {
                            let of = match c {
                                0..=2 => Some(PositionedSensor::Accelerometer),
                                10 | 11 => Some(PositionedSensor::Vane),
                                _ => None,
                            };
                            if of == Some(sensor) {
                                row[k] += (factor * posed.by_place(c, axis, &x, &here)) as f32;
                            }
                        }
                        _ => {}
                    }
                }
                for (state, gain) in gain.iter().enumerate() {
                    if *gain != 0.0 {
                        let column = &mut d[state * width..(state + 1) * width];
                        let gain = *gain as f32;
                        column.iter_mut().zip(row.iter()).for_each(|(d, row)| *d -= gain * row);
                    }
                }
                let per_root = (1.0 / root) as f32;
                row.iter_mut().for_each(|entry| *entry *= per_root);
                rows.take(e, &mut passed);
            }
            if let Some(noisier) = &mut noisier {
                noisier.correct(&h, &gain, (v, s), &mut passed.noisier, n);
            }
            for i in 0..n {
                x[i] += gain[i] * v;
                for (entry, ph) in p[i].iter_mut().zip(&ph).take(n) {
                    *entry -= gain[i] * ph;
                }
            }
            if !x.iter().all(|x| x.is_finite()) {
                return None;
            }
        }
        if asked.traces {
            passed.states.push(x);
        }
        core::mem::swap(&mut forces, &mut forces_before);
    }
    rows.finish(&mut passed);
    let nodes = record.mesh.nodes.max(1) as f64;
    passed.strength.iter_mut().for_each(|strength| *strength = libm::sqrt(*strength / nodes));
    Some(passed)
}
