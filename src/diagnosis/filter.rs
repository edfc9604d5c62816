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

use super::aircraft::{Changed, Partials};
use super::column::Column;
use super::driven::{Driven, Moved};
use super::record::{INPUTS, OUTPUTS, ROTOR, Readings, Record};
use crate::estimation::kinematics::{Attitude, velocity_rate, velocity_rate_by_rates, velocity_rate_by_velocity};
use crate::flight::derivative::{AXES, VARIABLES, Variable};
use crate::flight::effect::PositionedSensor;
use crate::flight::model::Trim;

/// Velocity, rates, attitude, height, gusts, a lag.
pub const STATES: usize = 14;
const LAG: usize = 10;
/// Place of the gusts among the states.
pub const GUST: usize = 11;
/// States without gusts and lag.
const CORE: usize = 10;
/// Standard deviations before the first reading.
const START_STD: [f64; STATES] = [10.0, 10.0, 10.0, 0.5, 0.5, 0.5, 0.5, 0.5, 1.0, 300.0, 0.0, 0.0, 0.0, 10.0];
/// Rows that are gathered before their products are added up.
const GATHERED: usize = 8;
/// Forward speed below which vanes tell nothing, m/s.
const SPEED_MIN: f64 = 2.0;

/// Noises that are found: of six axes, and of gusts.
pub const NOISES: usize = AXES + 1;

type State = [f64; STATES];
type Square = [[f64; STATES]; STATES];

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

/// A run with the model and everything that reaches it.
pub struct Posed<'a> {
    /// The run.
    pub record: &'a Record,
    /// The model.
    pub model: &'a Changed<'a>,
    /// Its trim.
    pub trim: &'a Trim,
    /// What reaches the blades.
    pub driven: &'a Driven,
    /// Changes of that, by place.
    pub moved: &'a [Driven],
    /// The outputs' readings, skews undone.
    pub readings: &'a Readings,
    /// Offset of the forces and moments of this run.
    pub constant: [f64; AXES],
    /// Biases and factors of the outputs.
    pub bias: [f64; OUTPUTS],
    /// See `bias`.
    pub factor: [f64; OUTPUTS],
    /// Where accelerometers stand, m.
    pub accelerometer_m: [f64; 3],
    /// Where vanes stand, m.
    pub vane_m: [f64; 3],
    /// The output with a lag of its own, and its time constant, s.
    pub lag: Option<(usize, f64)>,
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
    /// Sensitivities to these; none makes the cost alone.
    pub columns: &'c [Column],
    /// Rows of S'S that are kept.
    pub kept: usize,
    /// Whether states and innovations are kept.
    pub traces: bool,
}

/// Forces and their slopes at a node.
struct Here {
    force: [f64; AXES],
    by: Partials,
    by_rotor: [f64; AXES],
    deviations: [f64; VARIABLES],
    moved: Moved,
}

impl Posed<'_> {
    fn deviations(&self, x: &State, moved: &Moved) -> [f64; VARIABLES] {
        let trim = self.trim;
        let mut deviations = [0.0; VARIABLES];
        deviations[0] = x[0] - x[GUST] - trim.u;
        deviations[1] = x[1] - x[GUST + 1] - trim.v;
        deviations[2] = x[2] - x[GUST + 2] - trim.w;
        deviations[3..6].copy_from_slice(&x[3..6]);
        for (place, variable) in Variable::CONTROLS.into_iter().enumerate() {
            deviations[variable.index()] = moved[place];
        }
        deviations
    }

    fn force(&self, x: &State, moved: &Moved) -> [f64; AXES] {
        let mut force = self.model.forces(&self.deviations(x, moved), moved[ROTOR]);
        force.iter_mut().zip(self.constant).for_each(|(force, constant)| *force += constant);
        force
    }

    /// Rate of change of the state.
    fn rate(&self, x: &State, force: &[f64; AXES], gust_s: f64) -> Option<State> {
        let attitude = Attitude::regular(x[6], x[7])?;
        let (velocity, rates) = ([x[0], x[1], x[2]], [x[3], x[4], x[5]]);
        let [du, dv, dw] = velocity_rate(velocity, rates, [force[0], force[1], force[2]]);
        let [gx, gy, gz] = attitude.gravity();
        let [dphi, dtheta, dpsi] = attitude.euler_rates(rates);
        let mut rate = [0.0; STATES];
        rate[..10].copy_from_slice(&[
            du + gx,
            dv + gy,
            dw + gz,
            force[3],
            force[4],
            force[5],
            dphi,
            dtheta,
            dpsi,
            attitude.climb(velocity),
        ]);
        for axis in 0..3 {
            rate[GUST + axis] = -x[GUST + axis] / gust_time(axis, gust_s);
        }
        Some(rate)
    }

    /// Jacobian of the rate of change by the state.
    fn jacobian(&self, x: &State, by: &Partials, gust_s: f64) -> Option<Square> {
        let attitude = Attitude::regular(x[6], x[7])?;
        let (velocity, rates) = ([x[0], x[1], x[2]], [x[3], x[4], x[5]]);
        let (by_velocity, by_rates) = (velocity_rate_by_velocity(rates), velocity_rate_by_rates(velocity));
        let (gravity, euler) = (attitude.gravity_partials(), attitude.euler_partials(rates));
        let mut a = [[0.0; STATES]; STATES];
        for i in 0..3 {
            for j in 0..3 {
                a[i][j] = by_velocity[i][j];
                a[i][3 + j] = by_rates[i][j];
                a[6 + i][3 + j] = euler.by_rates[i][j];
            }
            a[i][6..8].copy_from_slice(&gravity[i]);
            a[6 + i][6..8].copy_from_slice(&euler.by_attitude[i]);
            a[GUST + i][GUST + i] = -1.0 / gust_time(i, gust_s);
        }
        a[9][..3].copy_from_slice(&attitude.climb_by_vector());
        a[9][6..8].copy_from_slice(&attitude.climb_by_attitude(velocity));
        for (row, by) in a.iter_mut().zip(by) {
            for j in 0..6 {
                row[j] += by[j];
            }
            for j in 0..3 {
                row[GUST + j] -= by[j];
            }
        }
        Some(a)
    }

    /// An output's true value, its slope by the state, and by forces and moments.
    fn seen(&self, output: usize, x: &State, here: &Here) -> Option<(f64, State, [f64; AXES])> {
        let mut h = [0.0; STATES];
        let mut by_force = [0.0; AXES];
        let [p, q, r] = [x[3], x[4], x[5]];
        let value = match output {
            0..=2 => {
                let [rx, ry, rz] = self.accelerometer_m;
                let [dp, dq, dr] = [here.force[3], here.force[4], here.force[5]];
                let (tangential, centripetal, by_moment, by_rate) = match output {
                    0 => (
                        dq * rz - dr * ry,
                        p * (q * ry + r * rz) - (q * q + r * r) * rx,
                        [0.0, rz, -ry],
                        [q * ry + r * rz, p * ry - 2.0 * q * rx, p * rz - 2.0 * r * rx],
                    ),
                    1 => (
                        dr * rx - dp * rz,
                        q * (p * rx + r * rz) - (p * p + r * r) * ry,
                        [-rz, 0.0, rx],
                        [q * rx - 2.0 * p * ry, p * rx + r * rz, q * rz - 2.0 * r * ry],
                    ),
                    _ => (
                        dp * ry - dq * rx,
                        r * (p * rx + q * ry) - (p * p + q * q) * rz,
                        [ry, -rx, 0.0],
                        [r * rx - 2.0 * p * rz, r * ry - 2.0 * q * rz, p * rx + q * ry],
                    ),
                };
                by_force[output] = 1.0;
                by_force[3..].copy_from_slice(&by_moment);
                for (j, slope) in by_rate.into_iter().enumerate() {
                    h[3 + j] += slope;
                }
                for (axis, weight) in by_force.into_iter().enumerate() {
                    if weight != 0.0 {
                        let by = &here.by[axis];
                        h.iter_mut().zip(by).take(6).for_each(|(h, by)| *h += weight * by);
                        h.iter_mut().skip(GUST).zip(by).take(3).for_each(|(h, by)| *h -= weight * by);
                    }
                }
                here.force[output] + tangential + centripetal
            }
            3..=8 => {
                h[output] = 1.0;
                x[output]
            }
            9..=11 => {
                let [rx, ry, rz] = if output == 9 { [0.0; 3] } else { self.vane_m };
                let u = x[0] - x[GUST] + q * rz - r * ry;
                let v = x[1] - x[GUST + 1] + r * rx - p * rz;
                let w = x[2] - x[GUST + 2] + p * ry - q * rx;
                if !(u > SPEED_MIN) {
                    return None;
                }
                let s2 = u * u + w * w;
                let speed2 = s2 + v * v;
                let (s, speed) = (libm::sqrt(s2), libm::sqrt(speed2));
                let (value, [a, b, c]) = match output {
                    9 => (speed, [u / speed, v / speed, w / speed]),
                    10 => (libm::atan2(w, u), [-w / s2, 0.0, u / s2]),
                    _ => (libm::atan2(v, s), [-v * u / (s * speed2), s / speed2, -v * w / (s * speed2)]),
                };
                for (j, slope) in [a, b, c].into_iter().enumerate() {
                    h[j] = slope;
                    h[GUST + j] = -slope;
                }
                h[3] = c * ry - b * rz;
                h[4] = a * rz - c * rx;
                h[5] = b * rx - a * ry;
                value
            }
            _ => {
                h[9] = 1.0;
                x[9]
            }
        };
        Some((value, h, by_force))
    }

    /// Slope of an output by the place of its sensor.
    fn by_place(&self, output: usize, axis: usize, x: &State, here: &Here) -> f64 {
        let [p, q, r] = [x[3], x[4], x[5]];
        let [dp, dq, dr] = [here.force[3], here.force[4], here.force[5]];
        match output {
            0..=2 => {
                let rows = [
                    [-(q * q + r * r), p * q - dr, p * r + dq],
                    [p * q + dr, -(p * p + r * r), q * r - dp],
                    [p * r - dq, q * r + dp, -(p * p + q * q)],
                ];
                rows[output][axis]
            }
            10 | 11 => {
                let Some((_, h, _)) = self.seen(output, x, here) else { return 0.0 };
                let [a, b, c] = [h[0], h[1], h[2]];
                [b * r - c * q, c * p - a * r, a * q - b * p][axis]
            }
            _ => 0.0,
        }
    }

    /// Axis of a column's force or moment and its value per unit of the parameter, of one that acts on one axis.
    fn column_force(column: Column, here: &Here) -> Option<(usize, f64)> {
        match column {
            Column::Derivative(axis, variable) => Some((axis.index(), here.deviations[variable.index()])),
            Column::Term(axis, term) => Some((axis.index(), term.value(&here.deviations))),
            Column::RotorSpeed(axis) => Some((axis.index(), here.moved[ROTOR])),
            Column::Constant(axis) => Some((axis.index(), 1.0)),
            _ => None,
        }
    }

    /// The same of one that moves all axes.
    fn column_forces(column: Column, here: &Here, moved: impl Fn(usize) -> Moved) -> Option<[f64; AXES]> {
        match column {
            Column::Effectiveness(control) => {
                let variable = Variable::CONTROLS.get(control)?.index();
                Some(core::array::from_fn(|axis| here.by[axis][variable] * here.deviations[variable]))
            }
            Column::Moved(place) => {
                let moved = moved(place);
                Some(core::array::from_fn(|axis| {
                    let blades = Variable::CONTROLS
                        .into_iter()
                        .zip(&moved)
                        .map(|(variable, moved)| here.by[axis][variable.index()] * moved);
                    blades.sum::<f64>() + here.by_rotor[axis] * moved[ROTOR]
                }))
            }
            _ => None,
        }
    }

    /// Forces of all columns at a node, [axes x columns].
    fn all_forces(&self, columns: &[Column], here: &Here, node: usize, out: &mut [f32]) {
        out.fill(0.0);
        let width = columns.len();
        let moved =
            |place: usize| self.moved.get(place).and_then(|driven| driven.nodes.get(node)).copied().unwrap_or([0.0; INPUTS]);
        for (k, &column) in columns.iter().enumerate() {
            if let Some((axis, value)) = Self::column_force(column, here) {
                out[axis * width + k] = value as f32;
            } else if let Some(values) = Self::column_forces(column, here, moved) {
                values.into_iter().enumerate().for_each(|(axis, value)| out[axis * width + k] = value as f32);
            }
        }
    }
}

/// Runs the filter; `None` where the motion leaves what the kinematics can carry.
pub fn pass(posed: &Posed<'_>, noise: &Noise, asked: Asked<'_>) -> Option<Passed> {
    let record = posed.record;
    let dt = record.step_s;
    let width = asked.columns.len();
    let kept = asked.kept.min(width);
    let gust_s = noise.gust.1.max(dt);
    // Without gusts their noise has no logarithm.
    let noises = if width == 0 {
        0
    } else if noise.gust.0 > 0.0 {
        NOISES
    } else {
        AXES
    };
    let mut noisier = vec![Noisier::NONE; noises];
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
    for node in 0..record.nodes {
        let moved = *posed.driven.nodes.get(node)?;
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
            for (of, one) in noisier.iter_mut().enumerate() {
                one.propagate((&phi, &gamma), of, noise, dt, n);
            }
            if width > 0 {
                let here = posed.here(&x, &moved);
                posed.all_forces(asked.columns, &here, node, &mut forces);
                propagate_columns(&phi, &gamma, &d, &mut moved_d, (&forces_before, &forces), dt, width);
                core::mem::swap(&mut d, &mut moved_d);
            }
        }
        let here = posed.here(&x, &moved);
        if width > 0 {
            posed.all_forces(asked.columns, &here, node, &mut forces);
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
                (&mut d, &mut noisier),
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
            let here = Here { deviations: here.deviations, moved, force: here.force, by: here.by, by_rotor: here.by_rotor };
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
            for (one, (slope, curvature)) in noisier.iter_mut().zip(&mut passed.noisier) {
                let (by, expected) = one.correct(&h, &gain, (v, s), n);
                *slope += by;
                *curvature += expected;
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
    let nodes = record.nodes.max(1) as f64;
    passed.strength.iter_mut().for_each(|strength| *strength = libm::sqrt(*strength / nodes));
    Some(passed)
}

impl Posed<'_> {
    fn here(&self, x: &State, moved: &Moved) -> Here {
        let deviations = self.deviations(x, moved);
        Here {
            force: self.force(x, moved),
            by: self.model.partials(&deviations, moved[ROTOR]),
            by_rotor: self.model.by_rotor(&deviations, moved[ROTOR]),
            deviations,
            moved: *moved,
        }
    }

    /// The same after the state has been corrected.
    fn at(&self, mut here: Here, x: &State, before: &State) -> Here {
        for (axis, force) in here.force.iter_mut().enumerate() {
            for j in 0..6 {
                *force += here.by[axis][j] * (x[j] - before[j]);
            }
            for j in 0..3 {
                *force -= here.by[axis][j] * (x[GUST + j] - before[GUST + j]);
            }
        }
        here
    }
}

/// Time constant of the first-order gust along an axis: across the flight Dryden's is of second order, and has both the variance
/// and the roughness of a first-order one that is a third faster.
fn gust_time(axis: usize, gust_s: f64) -> f64 {
    if axis == 0 { gust_s } else { gust_s * (2.0 / 3.0) }
}

/// A first guess of the state, by what is measured at the start.
fn start(posed: &Posed<'_>) -> Option<State> {
    let record = posed.record;
    let time_s = record.time_s(0);
    let read = |output: usize| {
        let series = record.outputs.get(output).and_then(Option::as_ref)?;
        Some((series.mean(time_s, time_s + 0.2) - posed.bias[output]) / posed.factor[output])
    };
    let trim = posed.trim;
    let speed = read(9).unwrap_or(trim.airspeed()).max(3.0);
    let alpha = read(10).unwrap_or(libm::atan2(trim.w, trim.u));
    let beta = read(11).unwrap_or(libm::asin((trim.v / trim.airspeed().max(1.0)).clamp(-1.0, 1.0)));
    let (sin_beta, cos_beta) = libm::sincos(beta);
    let (sin_alpha, cos_alpha) = libm::sincos(alpha);
    let mut x = [0.0; STATES];
    x[..3].copy_from_slice(&[speed * cos_alpha * cos_beta, speed * sin_beta, speed * sin_alpha * cos_beta]);
    for (output, x) in x.iter_mut().enumerate().take(9).skip(3) {
        let at_trim = match output {
            6 => trim.phi,
            7 => trim.theta,
            _ => 0.0,
        };
        *x = read(output).unwrap_or(at_trim);
    }
    x[9] = read(12).unwrap_or(0.0);
    x.iter().all(|x| x.is_finite()).then_some(x)
}

/// Phi = I + dt A (I + dt/2 A) and Gamma = I + dt/2 A, the columns of velocities, rates and gusts.
fn transition(a: &Square, dt: f64) -> (Square, Square) {
    let mut phi = [[0.0; STATES]; STATES];
    let mut gamma = [[0.0; STATES]; STATES];
    for i in 0..STATES {
        let mut second = [0.0; STATES];
        for (part, row) in a[i].iter().zip(a) {
            if *part != 0.0 {
                second.iter_mut().zip(row).for_each(|(sum, entry)| *sum += part * entry);
            }
        }
        for j in 0..STATES {
            let own = if i == j { 1.0 } else { 0.0 };
            phi[i][j] = own + dt * a[i][j] + 0.5 * dt * dt * second[j];
            gamma[i][j] = own + 0.5 * dt * a[i][j];
        }
    }
    (phi, gamma)
}

/// Phi P Phi' of the first `n` states.
fn propagated(phi: &Square, p: &Square, n: usize) -> Square {
    let mut half = [[0.0; STATES]; STATES];
    for (half, phi) in half.iter_mut().zip(phi).take(n) {
        for (part, p) in phi.iter().zip(p).take(n) {
            if *part != 0.0 {
                half.iter_mut().zip(p).take(n).for_each(|(sum, entry)| *sum += part * entry);
            }
        }
    }
    let mut whole = [[0.0; STATES]; STATES];
    for i in 0..n {
        for j in i..n {
            let sum: f64 = half[i].iter().zip(&phi[j]).take(n).map(|(a, b)| a * b).sum();
            whole[i][j] = sum;
            whole[j][i] = sum;
        }
    }
    whole
}

fn add_noise(p: &mut Square, gamma: &Square, noise: &Noise, dt: f64) {
    let (gust_std, gust_s) = (noise.gust.0, noise.gust.1.max(dt));
    for source in (0..6).chain(GUST..STATES) {
        let gust = || 2.0 * gust_std * gust_std / gust_time(source.saturating_sub(GUST), gust_s);
        let density = noise.force.get(source).copied().unwrap_or_else(gust) * dt;
        if density == 0.0 {
            continue;
        }
        for i in 0..STATES {
            let part = gamma[i][source] * density;
            if part != 0.0 {
                for (entry, row) in p[i].iter_mut().zip(gamma) {
                    *entry += part * row[source];
                }
            }
        }
    }
}

/// (3) over a step: the columns' forces at both its ends.
fn propagate_columns(
    phi: &Square,
    gamma: &Square,
    d: &[f32],
    moved: &mut [f32],
    (before, after): (&[f32], &[f32]),
    dt: f64,
    width: usize,
) {
    for i in 0..STATES {
        let row = &mut moved[i * width..(i + 1) * width];
        row.fill(0.0);
        for (k, &part) in phi[i].iter().enumerate() {
            if part != 0.0 {
                let part = part as f32;
                row.iter_mut().zip(&d[k * width..(k + 1) * width]).for_each(|(row, d)| *row += part * d);
            }
        }
        for axis in 0..AXES {
            let part = 0.5 * dt * gamma[i][axis];
            if libm::fabs(part) > 1e-9 {
                let part = part as f32;
                let (a, b) = (&before[axis * width..(axis + 1) * width], &after[axis * width..(axis + 1) * width]);
                for ((row, a), b) in row.iter_mut().zip(a).zip(b) {
                    *row += part * (a + b);
                }
            }
        }
    }
}

/// Covariance after a' = e a + weight h x.
fn lag_covariance(p: &mut Square, h: &State, e: f64, weight: f64) {
    let mut row = [0.0; STATES];
    for (column, row) in row.iter_mut().enumerate() {
        *row = e * p[LAG][column] + weight * h.iter().zip(&*p).map(|(h, p)| h * p[column]).sum::<f64>();
    }
    let own = e * row[LAG] + weight * h.iter().zip(&row).map(|(h, row)| h * row).sum::<f64>();
    for column in (0..STATES).filter(|&column| column != LAG) {
        p[LAG][column] = row[column];
        p[column][LAG] = row[column];
    }
    p[LAG][LAG] = own;
}

/// The lag's state over a step, tau a' = y - a with y a straight line; its covariance and columns with it.
#[expect(clippy::too_many_arguments, reason = "one step of one state, with everything that it hangs on")]
fn step_lag(
    x: &mut State,
    p: &mut Square,
    (d, noisier): (&mut [f32], &mut [Noisier]),
    ((before, _), (now, h)): ((f64, State), (f64, State)),
    (tau, dt): (f64, f64),
    columns: &[Column],
    (by_force, forces): (&[f64; AXES], &[f32]),
    first: bool,
) {
    let tau = tau.max(1e-4);
    let width = columns.len();
    let e = if first { 0.0 } else { libm::exp(-dt / tau) };
    let de = if first { 0.0 } else { e * dt / (tau * tau) };
    let ratio = tau / dt;
    let (w0, dw0) = if first { (0.0, 0.0) } else { (ratio * (1.0 - e) - e, (1.0 - e) / dt - ratio * de - de) };
    let (w1, dw1) = (1.0 - e - w0, -de - dw0);
    let old = x[LAG];
    x[LAG] = e * old + w0 * before + w1 * now;
    // What the lag has of the step's beginning is taken at its end: the state has hardly moved in between.
    let weight = w0 + w1;
    lag_covariance(p, &h, e, weight);
    for one in noisier {
        lag_covariance(&mut one.covariance, &h, e, weight);
        one.state[LAG] = e * one.state[LAG] + weight * h.iter().zip(&one.state).map(|(h, m)| h * m).sum::<f64>();
    }
    for k in 0..width {
        let direct: f64 = (0..AXES).map(|axis| by_force[axis] * f64::from(forces[axis * width + k])).sum();
        let carried: f64 = h.iter().enumerate().map(|(state, h)| h * f64::from(d[state * width + k])).sum();
        let mut new = e * f64::from(d[LAG * width + k]) + weight * (carried + direct);
        if matches!(columns[k], Column::Lag) {
            new += de * old + dw0 * before + dw1 * now;
        }
        d[LAG * width + k] = new as f32;
    }
}

/// Rate of change of an axis's force or moment by the controls and the rotor.
fn pushed_by(here: &Here, axis: usize, turning: &Moved) -> f64 {
    let blades = Variable::CONTROLS.into_iter().zip(turning).map(|(variable, rate)| here.by[axis][variable.index()] * rate);
    blades.sum::<f64>() + here.by_rotor[axis] * turning[ROTOR]
}

/// How the covariance and the state hang on the logarithm of one noise density.
#[derive(Clone, Copy)]
struct Noisier {
    covariance: Square,
    state: State,
}

impl Noisier {
    const NONE: Noisier = Noisier { covariance: [[0.0; STATES]; STATES], state: [0.0; STATES] };

    fn propagate(&mut self, (phi, gamma): (&Square, &Square), of: usize, noise: &Noise, dt: f64, n: usize) {
        self.covariance = propagated(phi, &self.covariance, n);
        let mut only = Noise { force: [0.0; AXES], gust: (0.0, noise.gust.1), output: noise.output };
        match (only.force.get_mut(of), noise.force.get(of)) {
            (Some(own), Some(density)) => *own = *density,
            _ => only.gust.0 = noise.gust.0,
        }
        add_noise(&mut self.covariance, gamma, &only, dt);
        self.state = core::array::from_fn(|i| phi[i].iter().zip(&self.state).map(|(a, b)| a * b).sum());
    }

    /// (4) for one reading.
    fn correct(&mut self, h: &State, gain: &State, (v, s): (f64, f64), n: usize) -> (f64, f64) {
        let mut g = [0.0; STATES];
        for (g, row) in g.iter_mut().zip(&self.covariance).take(n) {
            *g = row.iter().zip(h).take(n).map(|(m, h)| m * h).sum();
        }
        let ds: f64 = h.iter().zip(&g).map(|(h, g)| h * g).sum();
        let dv = -h.iter().zip(&self.state).map(|(h, m)| h * m).sum::<f64>();
        for i in 0..n {
            self.state[i] += (g[i] - gain[i] * ds) * v / s + gain[i] * dv;
            let (own, back) = (gain[i] * ds - g[i], gain[i]);
            for ((entry, gain), g) in self.covariance[i].iter_mut().zip(gain).zip(&g).take(n) {
                *entry += own * gain - back * g;
            }
        }
        ((2.0 * v * dv - (v * v / s - 1.0) * ds) / s, ds * ds / (s * s) + 2.0 * dv * dv / s)
    }
}

/// Rows of S, their products added up a few at a time; single precision is ample for slopes, the sums are double.
struct Gathered {
    width: usize,
    kept: usize,
    rows: Vec<f32>,
    count: usize,
}

impl Gathered {
    fn new(width: usize, kept: usize) -> Self {
        Gathered { width, kept, rows: vec![0.0; GATHERED * width], count: 0 }
    }

    fn next(&mut self) -> &mut [f32] {
        let row = &mut self.rows[self.count * self.width..(self.count + 1) * self.width];
        row.fill(0.0);
        row
    }

    fn take(&mut self, e: f64, passed: &mut Passed) {
        let row = &self.rows[self.count * self.width..(self.count + 1) * self.width];
        passed.pull.iter_mut().zip(row).for_each(|(pull, s)| *pull += f64::from(*s) * e);
        passed.diagonal.iter_mut().zip(row).for_each(|(sum, s)| *sum += f64::from(s * s));
        self.count += 1;
        if self.count == GATHERED {
            self.flush(passed);
        }
    }

    fn flush(&mut self, passed: &mut Passed) {
        let (width, kept) = (self.width, self.kept);
        let mut rows = self.rows.chunks_exact(width.max(1));
        let rows: [&[f32]; GATHERED] = core::array::from_fn(|_| rows.next().unwrap_or(&[]));
        for i in 0..kept {
            let own = rows.map(|row| row[i]);
            let sums = &mut passed.information[i * width + i..(i + 1) * width];
            let [r0, r1, r2, r3, r4, r5, r6, r7] = rows.map(|row| &row[i..]);
            let pairs = r0.iter().zip(r1).zip(r2).zip(r3).zip(r4).zip(r5).zip(r6).zip(r7);
            for (sum, (((((((b0, b1), b2), b3), b4), b5), b6), b7)) in sums.iter_mut().zip(pairs) {
                let first = own[0] * b0 + own[1] * b1 + own[2] * b2 + own[3] * b3;
                let second = own[4] * b4 + own[5] * b5 + own[6] * b6 + own[7] * b7;
                *sum += f64::from(first + second);
            }
        }
        self.count = 0;
    }

    fn finish(&mut self, passed: &mut Passed) {
        if self.count > 0 {
            self.rows[self.count * self.width..].fill(0.0);
            self.flush(passed);
        }
    }
}
