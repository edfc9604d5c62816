//! Slopes of the state by the columns, (3) of `filter`, and the sums of their products.
//!
//! Consumes transition matrices and the columns' forces; single precision is ample for slopes, the sums are double.

use super::covariance::lag_covariance;
use super::noise_score::NoiseScore;
use super::parameter::ParameterKind;
use super::state::{FilterResult, FilterState, LAG, STATES, StateMatrix};
use crate::flight::derivative::AXES;

/// Rows that are gathered before their products are added up.
const ROWS: usize = 8;

/// (3) over a step: the columns' forces at both its ends.
pub(crate) fn propagate_sensitivities(
    phi: &StateMatrix,
    gamma: &StateMatrix,
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

/// (3) by a reading: its slopes H dx + dy/dtheta by column, and K.
pub(crate) fn correct_sensitivities(d: &mut [f32], reading: &[f32], gain: &FilterState) {
    for (state, gain) in d.chunks_exact_mut(reading.len()).zip(gain).filter(|(_, gain)| **gain != 0.0) {
        let gain = *gain as f32;
        state.iter_mut().zip(reading).for_each(|(d, reading)| *d -= gain * reading);
    }
}

/// The lag's state over a step, tau a' = y - a with y a straight line; its covariance and columns with it.
#[expect(clippy::too_many_arguments, reason = "one step of one state, with everything that it hangs on")]
pub(crate) fn step_lag(
    x: &mut FilterState,
    p: &mut StateMatrix,
    (d, noise_score): (&mut [f32], Option<&mut NoiseScore>),
    ((before, _), (now, h)): ((f64, FilterState), (f64, FilterState)),
    (tau, dt): (f64, f64),
    columns: &[ParameterKind],
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
    if let Some(noise_score) = noise_score {
        noise_score.lag(&h, e, weight);
    }
    for k in 0..width {
        let direct: f64 = (0..AXES).map(|axis| by_force[axis] * f64::from(forces[axis * width + k])).sum();
        let carried: f64 = h.iter().enumerate().map(|(state, h)| h * f64::from(d[state * width + k])).sum();
        let mut new = e * f64::from(d[LAG * width + k]) + weight * (carried + direct);
        if matches!(columns[k], ParameterKind::Lag) {
            new += de * old + dw0 * before + dw1 * now;
        }
        d[LAG * width + k] = new as f32;
    }
}

/// Rows of S, their products added up a few at a time; single precision is ample for slopes, the sums are double.
pub(crate) struct NormalSums {
    width: usize,
    kept: usize,
    rows: Vec<f32>,
    count: usize,
}

impl NormalSums {
    pub(crate) fn new(width: usize, kept: usize) -> Self {
        NormalSums { width, kept, rows: vec![0.0; ROWS * width], count: 0 }
    }

    pub(crate) fn next(&mut self) -> &mut [f32] {
        let row = &mut self.rows[self.count * self.width..(self.count + 1) * self.width];
        row.fill(0.0);
        row
    }

    pub(crate) fn take(&mut self, e: f64, passed: &mut FilterResult) {
        let row = &self.rows[self.count * self.width..(self.count + 1) * self.width];
        passed.gradient.iter_mut().zip(row).for_each(|(gradient, s)| *gradient += f64::from(*s) * e);
        passed.diagonal.iter_mut().zip(row).for_each(|(sum, s)| *sum += f64::from(s * s));
        self.count += 1;
        if self.count == ROWS {
            self.flush(passed);
        }
    }

    fn flush(&mut self, passed: &mut FilterResult) {
        let (width, kept) = (self.width, self.kept);
        let mut rows = self.rows.chunks_exact(width.max(1));
        let rows: [&[f32]; ROWS] = core::array::from_fn(|_| rows.next().unwrap_or(&[]));
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

    pub(crate) fn finish(&mut self, passed: &mut FilterResult) {
        if self.count > 0 {
            self.rows[self.count * self.width..].fill(0.0);
            self.flush(passed);
        }
    }
}
