//! How the filter's covariance and state hang on the logarithm of each noise density, (4) of `filter`.
//!
//! Consumes transition matrices, gains and readings; produces the cost's slope by each logarithm and its expected second
//! derivative. All densities go through side by side: for each entry of M = dP and m = dx the numbers of all of them lie
//! together, so that one instruction takes four. Single precision is ample for slopes that steer noise densities.

use super::state::{FilterNoise, FilterState, GUST, LAG, NOISES, STATES, StateMatrix, gust_time};
use crate::flight::derivative::AXES;

/// Densities side by side, and one that is none.
const SIDE: usize = NOISES + 1;
type Side = [f32; SIDE];
const NONE: Side = [0.0; SIDE];

fn add(sum: &mut Side, part: f32, of: &Side) {
    sum.iter_mut().zip(of).for_each(|(sum, of)| *sum += part * of);
}

/// M and m of every density; M is kept with both its triangles.
#[derive(Clone)]
pub(crate) struct NoiseScore {
    covariance: [[Side; STATES]; STATES],
    state: [Side; STATES],
}

impl NoiseScore {
    /// Nothing hangs on anything yet.
    pub(crate) const START: NoiseScore = NoiseScore { covariance: [[NONE; STATES]; STATES], state: [NONE; STATES] };

    /// Over a step, of the first `n` states.
    pub(crate) fn propagate(&mut self, (phi, gamma): (&StateMatrix, &StateMatrix), noise: &FilterNoise, dt: f64, n: usize) {
        let phi = phi.map(|row| row.map(|entry| entry as f32));
        let mut half = [[NONE; STATES]; STATES];
        let mut state = [NONE; STATES];
        for ((half, state), phi) in half.iter_mut().zip(&mut state).zip(&phi).take(n) {
            for ((part, row), own) in phi.iter().zip(&self.covariance).zip(&self.state).take(n) {
                if *part != 0.0 {
                    half.iter_mut().zip(row).take(n).for_each(|(half, entry)| add(half, *part, entry));
                    add(state, *part, own);
                }
            }
        }
        self.state = state;
        for (i, (half, row)) in half.iter().zip(&mut self.covariance).enumerate().take(n) {
            for (entry, phi) in row.iter_mut().zip(&phi).take(n).skip(i) {
                *entry = NONE;
                let moving = half.iter().zip(phi).take(n).filter(|(_, part)| **part != 0.0);
                moving.for_each(|(half, part)| add(entry, *part, half));
            }
        }
        let gust = |source: usize| 2.0 * noise.gust.0 * noise.gust.0 / gust_time(source - GUST, noise.gust.1.max(dt));
        let forces = noise.force.iter().enumerate().map(|(axis, density)| (axis, axis, *density));
        let gusts = (GUST..STATES).map(|source| (AXES, source, gust(source))).filter(|_| noise.gust.0 > 0.0);
        for (of, source, density) in forces.chain(gusts) {
            for (i, row) in self.covariance.iter_mut().enumerate().take(n) {
                let part = gamma[i][source] * density * dt;
                if part != 0.0 {
                    for (entry, gamma) in row.iter_mut().zip(gamma).take(n).skip(i) {
                        entry[of] += (part * gamma[source]) as f32;
                    }
                }
            }
        }
        self.mirror(n);
    }

    fn mirror(&mut self, n: usize) {
        for i in 1..n {
            for j in 0..i {
                self.covariance[i][j] = self.covariance[j][i];
            }
        }
    }

    /// (4) for one reading: slope and expected second derivative of its cost by each density.
    pub(crate) fn correct(
        &mut self,
        h: &FilterState,
        gain: &FilterState,
        (v, s): (f64, f64),
        sums: &mut [(f64, f64); NOISES],
        n: usize,
    ) {
        let (h, gain) = (h.map(|h| h as f32), gain.map(|gain| gain as f32));
        let mut g = [NONE; STATES];
        let (mut ds, mut dv) = (NONE, NONE);
        for (j, slope) in h.iter().enumerate().take(n).filter(|(_, slope)| **slope != 0.0) {
            g.iter_mut().zip(&self.covariance[j]).take(n).for_each(|(g, entry)| add(g, *slope, entry));
            add(&mut dv, -slope, &self.state[j]);
        }
        h.iter().zip(&g).take(n).filter(|(slope, _)| **slope != 0.0).for_each(|(slope, g)| add(&mut ds, *slope, g));
        let per = (v / s) as f32;
        for i in 0..n {
            let back = gain[i];
            add(&mut self.state[i], per, &g[i]);
            add(&mut self.state[i], -per * back, &ds);
            add(&mut self.state[i], back, &dv);
            let mut own = NONE;
            add(&mut own, back, &ds);
            add(&mut own, -1.0, &g[i]);
            for j in i..n {
                let mut entry = self.covariance[i][j];
                add(&mut entry, gain[j], &own);
                add(&mut entry, -back, &g[j]);
                self.covariance[i][j] = entry;
                self.covariance[j][i] = entry;
            }
        }
        for (((slope, curvature), ds), dv) in sums.iter_mut().zip(ds).zip(dv) {
            let (ds, dv) = (f64::from(ds), f64::from(dv));
            *slope += (2.0 * v * dv - (v * v / s - 1.0) * ds) / s;
            *curvature += ds * ds / (s * s) + 2.0 * dv * dv / s;
        }
    }

    /// Through the lag of an output, a' = e a + weight h x.
    pub(crate) fn lag(&mut self, h: &FilterState, e: f64, weight: f64) {
        let mut row = [NONE; STATES];
        let through = |of: &mut dyn FnMut(usize, f32)| {
            of(LAG, e as f32);
            h.iter().enumerate().filter(|(_, h)| **h != 0.0).for_each(|(state, h)| of(state, (weight * h) as f32));
        };
        through(&mut |state, part| row.iter_mut().zip(&self.covariance[state]).for_each(|(row, entry)| add(row, part, entry)));
        let (mut own, mut state) = (NONE, NONE);
        through(&mut |from, part| {
            add(&mut own, part, &row[from]);
            add(&mut state, part, &self.state[from]);
        });
        row[LAG] = own;
        self.state[LAG] = state;
        for (column, entry) in row.into_iter().enumerate() {
            self.covariance[LAG][column] = entry;
            self.covariance[column][LAG] = entry;
        }
    }
}
