//! Covariance of the filter's state: over a step, by a reading, through the lag of an output, and how it hangs on each noise
//! density.
//!
//! Consumes Jacobians, noise and gains; produces (1), (2) and (4) of `filter`. Only the first `n` states are carried where the
//! others are none.

use super::state::{FilterNoise, FilterState, GUST, LAG, STATES, StateMatrix, gust_time};
/// Phi = I + dt A (I + dt/2 A) and Gamma = I + dt/2 A, the columns of velocities, rates and gusts.
pub(crate) fn transition(a: &StateMatrix, dt: f64) -> (StateMatrix, StateMatrix) {
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
pub(crate) fn propagated(phi: &StateMatrix, p: &StateMatrix, n: usize) -> StateMatrix {
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

pub(crate) fn add_noise(p: &mut StateMatrix, gamma: &StateMatrix, noise: &FilterNoise, dt: f64) {
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

/// (2) of `filter` for one reading: K, P H' and the innovation; of the first `n` states.
pub(crate) fn correct(x: &mut FilterState, p: &mut StateMatrix, (gain, ph): (&FilterState, &FilterState), v: f64, n: usize) {
    for i in 0..n {
        x[i] += gain[i] * v;
        for (entry, ph) in p[i].iter_mut().zip(ph).take(n) {
            *entry -= gain[i] * ph;
        }
    }
}

/// Covariance after a' = e a + weight h x.
pub(crate) fn lag_covariance(p: &mut StateMatrix, h: &FilterState, e: f64, weight: f64) {
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
