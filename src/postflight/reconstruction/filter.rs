//! One run through the kinematic model: whitened innovations and their sensitivities to every parameter.
//!
//! Consumes a `RunChannels`, parameters and noise; produces the innovations e = (z - y)/sqrt(s) of every reading in
//! order of time, their cost sum(e^2 + ln s), and S = -de/dtheta. Noise of the inputs integrates into drift, so a plain output
//! error would see coloured residuals; the Kalman filter with that noise as its process noise whitens them, and generalised
//! least squares on e is then efficient, with standard errors that hold:
//!     x+ = x + dt f(x + f dt/2, u)        P+ = Phi P Phi' + Gamma (q/dt) Gamma'                         (1)
//!     v = z - y,  s = H P H' + R,  K = P H'/s,  x <- x + K v,  P <- P - K s K'                           (2)
//!     dx <- dx - K (H dx + dy/dtheta)        S = (H dx + dy/dtheta)/sqrt(s)                              (3)
//! with u the mean of the measured inputs over each step, corrected by the parameters, and K taken as independent of theta.
//! Every start (and every gap) begins with a covariance so large that nothing is assumed.
//!
//! A lag of an output is a state of its own, a' = (y - a)/tau, integrated for y a straight line within the step; a lag of an
//! input is undone by its differential equation, true = z + tau z'; a skew moves the readings to when they were true.
//! Source: R. V. Jategaonkar, Flight Vehicle System Identification, 2nd ed. 2015, ch. 5 (filter error).

use super::motion::{Observation, STATES, jacobians, observe, rate};
use super::parameter::{
    ACCELEROMETER_PLACE, ALPHA_PLACE, BETA_PLACE, BIAS, FLOW, INPUTS, MISALIGNMENT, OUTPUTS, SCALE, SHARED_BIAS, TIMING, Theta,
    VANE_PLACE,
};
use super::run_channels::RunChannels;
use crate::flight::signal::readings::Readings;

/// States with a lag of every output.
const AUGMENTED: usize = STATES + OUTPUTS;
/// Half width of the mean at either end of a step of which a lag is undone, in steps.
const END_PART: f64 = 0.5;
/// Standard deviations before the first reading: velocities, attitude, altitude, wind; lags.
const START_STD: [f64; AUGMENTED] = [30.0, 30.0, 30.0, 0.5, 0.5, 1.0, 300.0, 0.5, 30.0, 1.0, 1.0, 1.0, 1.0, 1.0, 300.0];

/// Noise of the instruments and of the air.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct KinematicNoise {
    /// Power spectral density of the inputs' white noise (gusts and vibration in it), unit^2 s.
    pub input: [f64; INPUTS],
    /// Of the walk of the vertical wind, m^2/s^3.
    pub climb: f64,
    /// Variance of a reading of each output.
    pub output: [f64; OUTPUTS],
}

/// One innovation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WhitenedInnovation {
    /// Which output.
    pub output: usize,
    /// At which node.
    pub node: usize,
    /// In its own standard deviations.
    pub whitened: f64,
}

/// Innovations, sensitivities and states of one run.
#[derive(Clone, Debug, Default)]
pub struct RunInnovations {
    /// Sum of squares and logarithms of the variances.
    pub cost: f64,
    /// The innovations in order of time; empty where only the cost was asked for.
    pub innovations: Vec<WhitenedInnovation>,
    /// Sensitivities, a row of `active.len()` an innovation.
    pub rows: Vec<f64>,
    /// Velocity and attitude at each node after its readings.
    pub states: Vec<[f64; STATES]>,
}

/// The inputs of one step or of one node.
#[derive(Clone, Copy, Default)]
struct StepInput {
    value: [f64; INPUTS],
    slope: [f64; INPUTS],
}

impl StepInput {
    fn over(record: &RunChannels, theta: &Theta, from_s: f64, to_s: f64) -> StepInput {
        let mut driven = StepInput::default();
        for (i, series) in record.inputs.iter().enumerate() {
            let Some(series) = series else {
                driven.value[i] = if i == 2 { -crate::flight::unit::STANDARD_GRAVITY } else { 0.0 };
                continue;
            };
            let skew = theta.skew_s(i);
            // A lag is undone by the slope, in which the samples' noise would pass for motion: the ends are means then.
            let half = if theta.lag[i] { END_PART * (to_s - from_s) } else { 0.0 };
            let end = |time_s: f64| series.mean(time_s + skew - half, time_s + skew + half);
            let slope = (end(to_s) - end(from_s)) / (to_s - from_s);
            let read = series.mean(from_s + skew, to_s + skew) + theta.lag_s(i) * slope;
            driven.value[i] = (read - theta.bias(i)) / theta.factor(i);
            driven.slope[i] = slope / theta.factor(i);
        }
        let (value, slope) = (driven.value, driven.slope);
        for k in 0..6 {
            let (gyro, other) = Theta::misaligned_axes(k);
            let part = theta.values[MISALIGNMENT + k];
            driven.value[gyro] -= part * value[other];
            driven.slope[gyro] -= part * slope[other];
        }
        driven
    }

    fn omega(&self) -> [f64; 3] {
        [self.value[3], self.value[4], self.value[5]]
    }

    /// Derivative of input i by the parameter at that place, where it is one of input i.
    fn by(&self, theta: &Theta, index: usize) -> Option<(usize, f64)> {
        for (from, kind) in [(BIAS, 0), (SHARED_BIAS, 0), (SCALE, 1), (TIMING, 2)] {
            if (from..from + INPUTS).contains(&index) {
                let i = index - from;
                return Some((
                    i,
                    match kind {
                        0 => -1.0 / theta.factor(i),
                        1 => -self.value[i] / theta.factor(i),
                        _ => self.slope[i],
                    },
                ));
            }
        }
        let k = index.checked_sub(MISALIGNMENT).filter(|&k| k < 6)?;
        let (gyro, other) = Theta::misaligned_axes(k);
        Some((gyro, -self.value[other]))
    }
}

/// Weights of the lag over one step, E, w0, w1, and their derivatives by tau.
fn lag_weights(dt: f64, tau: f64) -> ([f64; 3], [f64; 3]) {
    let tau = tau.max(1e-4);
    let e = libm::exp(-dt / tau);
    let de = e * dt / (tau * tau);
    let ratio = tau / dt;
    let rest = ratio * (1.0 - e);
    let drest = (1.0 - e) / dt - ratio * de;
    ([e, rest - e, 1.0 - rest], [de, drest - de, -drest])
}

/// Where an output stands, from the accelerometers.
fn place(record: &RunChannels, theta: &Theta, output: usize) -> [f64; 3] {
    let offset = theta.place(ACCELEROMETER_PLACE);
    let stands: [f64; 3] = core::array::from_fn(|axis| record.accelerometer_place[axis] + offset[axis]);
    let (vane, apart) = match output {
        1 => (theta.place(VANE_PLACE), theta.place(ALPHA_PLACE)),
        2 => (theta.place(VANE_PLACE), theta.place(BETA_PLACE)),
        _ => return stands.map(|part| -part),
    };
    core::array::from_fn(|axis| record.vane_place[axis] + vane[axis] + apart[axis] - stands[axis])
}

type Augmented = [f64; AUGMENTED];

/// A run's inputs and readings as certain parameters correct them.
pub struct Prepared<'r> {
    record: &'r RunChannels,
    theta: &'r Theta,
    steps: Vec<StepInput>,
    nodes: Vec<StepInput>,
    readings: Readings,
    places: [[f64; 3]; OUTPUTS],
}

impl<'r> Prepared<'r> {
    /// Corrects a run.
    pub fn of(record: &'r RunChannels, theta: &'r Theta) -> Self {
        let dt = record.mesh.step_s;
        let over = |node: usize, from: f64, to: f64| {
            let time_s = record.mesh.time_s(node);
            StepInput::over(record, theta, time_s + from * dt, time_s + to * dt)
        };
        Prepared {
            record,
            theta,
            steps: (0..record.mesh.nodes).map(|node| over(node, 0.0, 1.0)).collect(),
            nodes: (0..record.mesh.nodes).map(|node| over(node, -0.5, 0.5)).collect(),
            readings: record.readings(theta),
            places: core::array::from_fn(|c| place(record, theta, c)),
        }
    }

    /// An output without its instrument, flow bent by sideslip.
    fn observe(&self, output: usize, x: &[f64; STATES], omega: [f64; 3]) -> Option<(Observation, f64)> {
        let mut own = observe(output, x, omega, self.places[output])?;
        if output > 1 {
            return Some((own, 0.0));
        }
        let beta = observe(2, x, omega, self.places[2])?;
        let [by_beta, by_square, speed] = self.theta.place(FLOW);
        let (add, slope) = match output {
            0 => (speed * own.value * beta.value * beta.value, 2.0 * speed * own.value * beta.value),
            _ => ((by_beta + by_square * beta.value) * beta.value, by_beta + 2.0 * by_square * beta.value),
        };
        own.value += add;
        own.by_state.iter_mut().zip(beta.by_state).for_each(|(own, beta)| *own += slope * beta);
        own.by_rates.iter_mut().zip(beta.by_rates).for_each(|(own, beta)| *own += slope * beta);
        Some((own, beta.value))
    }

    /// Derivative of an output without its instrument by a parameter, the state held.
    fn direct(&self, (observed, beta): &(Observation, f64), output: usize, driven: &StepInput, index: usize) -> f64 {
        if let Some((i, slope)) = driven.by(self.theta, index) {
            return if i >= 3 { observed.by_rates[i - 3] * slope } else { 0.0 };
        }
        match (output, index) {
            (1, ALPHA_PLACE..BETA_PLACE) => observed.by_place[index - ALPHA_PLACE],
            (2, BETA_PLACE..VANE_PLACE) => observed.by_place[index - BETA_PLACE],
            (1 | 2, VANE_PLACE..ACCELEROMETER_PLACE) => observed.by_place[index - VANE_PLACE],
            (_, ACCELEROMETER_PLACE..FLOW) => -observed.by_place[index - ACCELEROMETER_PLACE],
            (1, FLOW) => *beta,
            (1, index) if index == FLOW + 1 => beta * beta,
            (0, index) if index == FLOW + 2 => observed.value * beta * beta,
            _ => 0.0,
        }
    }
}

/// Runs the filter. Sensitivities are taken to the parameters `active`; with none of them only the cost is made.
///
/// `None` where the motion leaves what the kinematics can carry.
pub fn pass(prepared: &Prepared<'_>, noise: &KinematicNoise, active: &[usize], light: bool) -> Option<RunInnovations> {
    let (record, theta) = (prepared.record, prepared.theta);
    let dt = record.mesh.step_s;
    let mut passed = RunInnovations::default();
    let lagged: [bool; OUTPUTS] = core::array::from_fn(|c| record.outputs[c].is_some() && theta.lag[INPUTS + c]);
    let any_lag = lagged.iter().any(|is| *is);
    let size = if any_lag { AUGMENTED } else { STATES };
    let mut x: Augmented = [0.0; AUGMENTED];
    let mut p = [[0.0; AUGMENTED]; AUGMENTED];
    let mut d: Vec<Augmented> = vec![[0.0; AUGMENTED]; active.len()];
    let base = |x: &Augmented| -> [f64; STATES] { core::array::from_fn(|i| x[i]) };
    for node in 0..record.mesh.nodes {
        let here = *prepared.nodes.get(node)?;
        if node == 0 || record.starts_anew(node) {
            x = [0.0; AUGMENTED];
            let start = record.start(node, theta);
            x[..STATES].copy_from_slice(&start);
            for c in 0..OUTPUTS {
                if record.outputs[c].is_some() {
                    x[STATES + c] = prepared.observe(c, &start, here.omega())?.0.value;
                }
            }
            p = [[0.0; AUGMENTED]; AUGMENTED];
            for i in 0..size {
                let carried = i >= 3 || record.velocities;
                p[i][i] = if carried { START_STD[i] * START_STD[i] } else { 0.0 };
            }
            d.iter_mut().for_each(|column| *column = [0.0; AUGMENTED]);
        } else {
            let driven = *prepared.steps.get(node - 1)?;
            let before = base(&x);
            let f0 = rate(&before, &driven.value)?;
            let middle: [f64; STATES] = core::array::from_fn(|i| before[i] + 0.5 * dt * f0[i]);
            let f = rate(&middle, &driven.value)?;
            let (a, g) = jacobians(&middle, &driven.value)?;
            // Phi = I + dt A (I + dt/2 A), Gamma = dt (I + dt/2 A) G.
            let half = |m: &[f64; STATES], i: usize, column: usize| -> f64 {
                (if i == column { 1.0 } else { 0.0 }) + 0.5 * dt * m[column]
            };
            let mut phi = [[0.0; AUGMENTED]; AUGMENTED];
            let mut gamma = [[0.0; INPUTS]; AUGMENTED];
            for i in 0..STATES {
                for j in 0..STATES {
                    let second: f64 = (0..STATES).map(|k| a[i][k] * a[k][j]).sum();
                    phi[i][j] = (if i == j { 1.0 } else { 0.0 }) + dt * a[i][j] + 0.5 * dt * dt * second;
                }
                for j in 0..INPUTS {
                    gamma[i][j] = dt * (0..STATES).map(|k| half(&a[i], i, k) * g[k][j]).sum::<f64>();
                }
            }
            let mut after = x;
            for i in 0..STATES {
                after[i] = before[i] + dt * f[i];
            }
            let moved = base(&after);
            let (mut seen0, mut seen1) = ([(Observation::default(), 0.0); OUTPUTS], [(Observation::default(), 0.0); OUTPUTS]);
            let mut there = StepInput::default();
            let mut weights = [([0.0; 3], [0.0; 3]); OUTPUTS];
            if any_lag {
                there = *prepared.nodes.get(node - 1)?;
                for c in (0..OUTPUTS).filter(|&c| lagged[c]) {
                    seen0[c] = prepared.observe(c, &before, there.omega())?;
                    seen1[c] = prepared.observe(c, &moved, here.omega())?;
                    weights[c] = lag_weights(dt, theta.lag_s(INPUTS + c));
                    let [e, w0, w1] = weights[c].0;
                    let s = STATES + c;
                    after[s] = e * x[s] + w0 * seen0[c].0.value + w1 * seen1[c].0.value;
                    phi[s][s] = e;
                    let (before, now) = (seen0[c].0.by_state, seen1[c].0.by_state);
                    for (j, before) in before.into_iter().enumerate() {
                        let carried: f64 = now.iter().zip(&phi).map(|(by, row)| by * row[j]).sum();
                        phi[s][j] = w0 * before + w1 * carried;
                    }
                    gamma[s] = core::array::from_fn(|j| w1 * now.iter().zip(&gamma).map(|(by, row)| by * row[j]).sum::<f64>());
                }
            }
            for (place, &index) in active.iter().enumerate() {
                let old = d[place];
                let mut new = [0.0; AUGMENTED];
                for i in 0..STATES {
                    new[i] = (0..STATES).map(|k| phi[i][k] * old[k]).sum();
                }
                if let Some((i, slope)) = driven.by(theta, index) {
                    (0..STATES).for_each(|k| new[k] += gamma[k][i] * slope);
                }
                for c in (0..OUTPUTS).filter(|&c| lagged[c]) {
                    let s = STATES + c;
                    let ([e, w0, w1], [de, dw0, dw1]) = weights[c];
                    let dot = |row: &[f64; STATES], column: &Augmented| -> f64 { (0..STATES).map(|k| row[k] * column[k]).sum() };
                    new[s] = e * old[s]
                        + w0 * (dot(&seen0[c].0.by_state, &old) + prepared.direct(&seen0[c], c, &there, index))
                        + w1 * (dot(&seen1[c].0.by_state, &new) + prepared.direct(&seen1[c], c, &here, index));
                    if index == TIMING + INPUTS + c {
                        new[s] += de * x[s] + dw0 * seen0[c].0.value + dw1 * seen1[c].0.value;
                    }
                }
                d[place] = new;
            }
            x = after;
            let mut half_step = [[0.0; AUGMENTED]; AUGMENTED];
            for i in 0..size {
                let reach = if i < STATES { STATES } else { size };
                for j in 0..size {
                    half_step[i][j] = (0..reach).map(|k| phi[i][k] * p[k][j]).sum();
                }
            }
            for i in 0..size {
                for j in i..size {
                    let reach = if j < STATES { STATES } else { size };
                    let carried: f64 = (0..reach).map(|k| half_step[i][k] * phi[j][k]).sum();
                    let noisy: f64 = (0..INPUTS).map(|k| gamma[i][k] * gamma[j][k] * noise.input[k] / dt).sum();
                    let climb = if i == 7 && j == 7 { noise.climb * dt } else { 0.0 };
                    p[i][j] = carried + noisy + climb;
                    p[j][i] = p[i][j];
                }
            }
            if !record.velocities {
                for i in 0..3 {
                    p[i] = [0.0; AUGMENTED];
                    p.iter_mut().for_each(|row| row[i] = 0.0);
                    x[i] = before[i];
                }
            }
        }
        for reading in prepared.readings.at(node) {
            let c = reading.output;
            let now = base(&x);
            let both = prepared.observe(c, &now, here.omega())?;
            let observed = both.0;
            let measured = INPUTS + c;
            let factor = theta.factor(measured);
            let (mut h, value, slope): (Augmented, f64, f64);
            h = [0.0; AUGMENTED];
            if lagged[c] {
                h[STATES + c] = factor;
                value = x[STATES + c];
                slope = (observed.value - value) / theta.lag_s(measured).max(0.25 * dt);
            } else {
                (0..STATES).for_each(|k| h[k] = factor * observed.by_state[k]);
                value = observed.value;
                let f = rate(&now, &here.value)?;
                slope = (0..STATES).map(|k| observed.by_state[k] * f[k]).sum::<f64>()
                    + (0..3).map(|k| observed.by_rates[k] * here.slope[k + 3]).sum::<f64>();
            }
            let about = record.about[c];
            let expected = factor * (value - about + reading.late_s * slope) + about + theta.bias(measured);
            let ph: Augmented = core::array::from_fn(|i| if i < size { (0..size).map(|k| p[i][k] * h[k]).sum() } else { 0.0 });
            let variance = (0..size).map(|k| h[k] * ph[k]).sum::<f64>() + noise.output[c] / reading.count;
            let innovation = reading.value - expected;
            if !(variance > 0.0) || !innovation.is_finite() {
                return None;
            }
            passed.cost += innovation * innovation / variance + libm::log(variance);
            let scale = 1.0 / libm::sqrt(variance);
            for (place, &index) in active.iter().enumerate() {
                let column = &mut d[place];
                let mut by: f64 = (0..size).map(|k| h[k] * column[k]).sum();
                if !lagged[c] {
                    by += factor * prepared.direct(&both, c, &here, index);
                }
                if index == BIAS + measured || index == SHARED_BIAS + measured {
                    by += 1.0;
                } else if index == SCALE + measured {
                    by += value - about;
                } else if index == TIMING + measured && !lagged[c] {
                    by -= factor * slope;
                }
                passed.rows.push(by * scale);
                let gain = by / variance;
                (0..size).for_each(|k| column[k] -= ph[k] * gain);
            }
            let gain = innovation / variance;
            for i in 0..size {
                x[i] += ph[i] * gain;
                for j in 0..size {
                    p[i][j] -= ph[i] * ph[j] / variance;
                }
            }
            if !light {
                passed.innovations.push(WhitenedInnovation { output: c, node, whitened: innovation * scale });
            }
        }
        if !light {
            passed.states.push(base(&x));
        }
    }
    passed.cost.is_finite().then_some(passed)
}
