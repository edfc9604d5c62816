//! Covariance of the filter's state: over a step, through the lag of an output, and how it hangs on each noise density.
//!
//! Consumes Jacobians and noise; produces (1) and (4) of `filter`. Only the first `n` states are carried where the others are
//! none.

use super::filter::{GUST, LAG, Noise, STATES, Square, State};
use super::posed::gust_time;
use crate::flight::derivative::AXES;

/// Phi = I + dt A (I + dt/2 A) and Gamma = I + dt/2 A, the columns of velocities, rates and gusts.
pub(super) fn transition(a: &Square, dt: f64) -> (Square, Square) {
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
pub(super) fn propagated(phi: &Square, p: &Square, n: usize) -> Square {
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

pub(super) fn add_noise(p: &mut Square, gamma: &Square, noise: &Noise, dt: f64) {
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

/// Covariance after a' = e a + weight h x.
pub(super) fn lag_covariance(p: &mut Square, h: &State, e: f64, weight: f64) {
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

/// How the covariance and the state hang on the logarithm of one noise density.
#[derive(Clone, Copy)]
pub(super) struct Noisier {
    pub(super) covariance: Square,
    pub(super) state: State,
}

impl Noisier {
    pub(super) const NONE: Noisier = Noisier { covariance: [[0.0; STATES]; STATES], state: [0.0; STATES] };

    pub(super) fn propagate(&mut self, (phi, gamma): (&Square, &Square), of: usize, noise: &Noise, dt: f64, n: usize) {
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
    pub(super) fn correct(&mut self, h: &State, gain: &State, (v, s): (f64, f64), n: usize) -> (f64, f64) {
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
