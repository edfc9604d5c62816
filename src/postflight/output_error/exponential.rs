//! The three integrals of a matrix exponential that an exact step needs, and how they change with the matrix.
//!
//! Consumes A (n x n) and an interval h; produces
//!     Phi = e^(A h),  Psi1 = int_0^h e^(A s) ds,  Psi2 = int_0^h (h - s) e^(A s) ds                 (1)
//! With Z = A h/2^k small, phi2 by its series, phi1 = 1 + Z phi2, phi0 = 1 + Z phi1, then k doublings
//!     phi2 <- (phi0 phi2 + phi1 + phi2)/4,  phi1 <- (phi0 + 1) phi1/2,  phi0 <- phi0 phi0           (2)
//! and Phi = phi0, Psi1 = h phi1, Psi2 = h^2 phi2. Derivatives for A in a direction dA: the product rule on every line.
//! Numerics: |Z| <= 1/2 and fourteen terms leave less than 1e-17. A matrix that is not finite gives NaN.

use crate::num::product::{add_product, set_product};

const TERMS: usize = 14;

/// Phi, Psi1, Psi2, each n x n, row by row.
#[derive(Clone, Debug, PartialEq)]
pub struct ExponentialIntegrals {
    /// e^(A h).
    pub phi: Vec<f64>,
    /// Its integral.
    pub psi1: Vec<f64>,
    /// Its double integral.
    pub psi2: Vec<f64>,
}

fn add_identity(matrix: &mut [f64], n: usize, scale: f64) {
    matrix.iter_mut().step_by(n + 1).for_each(|entry| *entry += scale);
}

/// Largest sum of a row's magnitudes.
fn norm(a: &[f64], n: usize) -> f64 {
    a.chunks_exact(n).map(|row| row.iter().map(|x| x.abs()).sum()).fold(0.0, f64::max)
}

/// (1), and its derivatives for A in every direction given.
pub fn integrals(a: &[f64], n: usize, h: f64, directions: &[Vec<f64>]) -> (ExponentialIntegrals, Vec<ExponentialIntegrals>) {
    if n == 0 {
        let none = ExponentialIntegrals { phi: Vec::new(), psi1: Vec::new(), psi2: Vec::new() };
        return (none.clone(), vec![none; directions.len()]);
    }
    let size = norm(a, n) * h.abs();
    let doublings = if size > 0.5 && size.is_finite() { libm::ceil(libm::log2(2.0 * size)) as i32 } else { 0 };
    let scale = libm::ldexp(h, -doublings);
    let z: Vec<f64> = a.iter().map(|x| x * scale).collect();
    let dz: Vec<Vec<f64>> = directions.iter().map(|da| da.iter().map(|x| x * scale).collect()).collect();
    let mut now = series(&z, &dz, n);
    for _ in 0..doublings {
        now = doubled(&now, n);
    }
    let finish = |[phi, psi1, psi2]: [Vec<f64>; 3]| ExponentialIntegrals {
        phi,
        psi1: psi1.into_iter().map(|x| x * h).collect(),
        psi2: psi2.into_iter().map(|x| x * h * h).collect(),
    };
    let (value, derivatives) = now;
    (finish(value), derivatives.into_iter().map(finish).collect())
}

type Phis = ([Vec<f64>; 3], Vec<[Vec<f64>; 3]>);

/// The phi functions of a small matrix.
fn series(z: &[f64], dz: &[Vec<f64>], n: usize) -> Phis {
    let mut factors = [0.0; TERMS + 1];
    let mut factor = 1.0;
    for (k, slot) in factors.iter_mut().enumerate() {
        factor /= if k == 0 { 2.0 } else { (k + 2) as f64 };
        *slot = factor;
    }
    let mut phi2 = vec![0.0; n * n];
    add_identity(&mut phi2, n, factors[TERMS]);
    let mut dphi2 = vec![vec![0.0; n * n]; dz.len()];
    let mut next = vec![0.0; n * n];
    for &factor in factors[..TERMS].iter().rev() {
        for (dz, d) in dz.iter().zip(&mut dphi2) {
            set_product(z, d, n, n, &mut next);
            add_product(dz, &phi2, n, n, &mut next);
            d.copy_from_slice(&next);
        }
        set_product(z, &phi2, n, n, &mut next);
        add_identity(&mut next, n, factor);
        core::mem::swap(&mut next, &mut phi2);
    }
    let up = |phi: &[f64]| {
        let mut out = vec![0.0; n * n];
        set_product(z, phi, n, n, &mut out);
        add_identity(&mut out, n, 1.0);
        out
    };
    let phi1 = up(&phi2);
    let phi0 = up(&phi1);
    let derivatives = dz.iter().zip(dphi2).map(|(dz, dphi2)| {
        let mut dphi1 = vec![0.0; n * n];
        set_product(z, &dphi2, n, n, &mut dphi1);
        add_product(dz, &phi2, n, n, &mut dphi1);
        let mut dphi0 = vec![0.0; n * n];
        set_product(z, &dphi1, n, n, &mut dphi0);
        add_product(dz, &phi1, n, n, &mut dphi0);
        [dphi0, dphi1, dphi2]
    });
    let derivatives = derivatives.collect();
    ([phi0, phi1, phi2], derivatives)
}

/// (2).
fn doubled(now: &Phis, n: usize) -> Phis {
    let ([phi0, phi1, phi2], derivatives) = now;
    let mut raised = phi0.clone();
    add_identity(&mut raised, n, 1.0);
    let mut next = [vec![0.0; n * n], vec![0.0; n * n], vec![0.0; n * n]];
    set_product(phi0, phi0, n, n, &mut next[0]);
    set_product(&raised, phi1, n, n, &mut next[1]);
    set_product(phi0, phi2, n, n, &mut next[2]);
    finish_doubling(&mut next, phi1, phi2);
    let changes = derivatives.iter().map(|[d0, d1, d2]| {
        let mut next = [vec![0.0; n * n], vec![0.0; n * n], vec![0.0; n * n]];
        set_product(d0, phi0, n, n, &mut next[0]);
        add_product(phi0, d0, n, n, &mut next[0]);
        set_product(d0, phi1, n, n, &mut next[1]);
        add_product(&raised, d1, n, n, &mut next[1]);
        set_product(d0, phi2, n, n, &mut next[2]);
        add_product(phi0, d2, n, n, &mut next[2]);
        finish_doubling(&mut next, d1, d2);
        next
    });
    let changes = changes.collect();
    (next, changes)
}

fn finish_doubling(next: &mut [Vec<f64>; 3], phi1: &[f64], phi2: &[f64]) {
    next[1].iter_mut().for_each(|x| *x *= 0.5);
    for ((x, one), two) in next[2].iter_mut().zip(phi1).zip(phi2) {
        *x = 0.25 * (*x + one + two);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_state_is_the_closed_form() {
        for (a, h) in [(-1.7, 0.04), (-3.0, 2.0), (0.0, 0.5), (0.8, 1.0)] {
            let (found, changes) = integrals(&[a], 1, h, &[vec![1.0]]);
            let (e, z) = (libm::exp(a * h), a * h);
            let psi1 = if a == 0.0 { h } else { libm::expm1(z) / a };
            let psi2 = if a == 0.0 { 0.5 * h * h } else { (libm::expm1(z) - z) / (a * a) };
            for (found, expected) in [(found.phi[0], e), (found.psi1[0], psi1), (found.psi2[0], psi2), (changes[0].phi[0], h * e)]
            {
                assert!((found - expected).abs() < 1e-13 * expected.abs().max(1.0), "{a} {h}: {found} {expected}");
            }
        }
    }

    #[test]
    fn derivatives_are_those_of_central_differences() {
        let n = 3;
        let a = [-0.5, 1.0, 0.2, -8.0, -2.0, 0.1, 0.0, 1.0, 0.0];
        let direction = vec![0.3, 0.0, 1.0, 0.0, -0.7, 0.0, 0.2, 0.0, 0.5];
        let moved = |t: f64| -> Vec<f64> { a.iter().zip(&direction).map(|(a, d)| a + t * d).collect() };
        for h in [0.02, 0.9] {
            let (_, exact) = integrals(&a, n, h, std::slice::from_ref(&direction));
            let (up, _) = integrals(&moved(1e-5), n, h, &[]);
            let (down, _) = integrals(&moved(-1e-5), n, h, &[]);
            let three = [
                (&up.phi, &down.phi, &exact[0].phi),
                (&up.psi1, &down.psi1, &exact[0].psi1),
                (&up.psi2, &down.psi2, &exact[0].psi2),
            ];
            for (up, down, exact) in three {
                for ((up, down), exact) in up.iter().zip(down).zip(exact) {
                    assert!(((up - down) / 2e-5 - exact).abs() < 1e-9, "{h}");
                }
            }
        }
    }
}
