//! The lateral subsystem: its matrix, its roots, and standard errors propagated from the derivatives.
//!
//! Consumes the lateral derivatives with their joint covariance and the trim; produces the modes. States v p phi r:
//!     A = | Y_v   Y_p + w0   g cos(theta0) cos(phi0)   Y_r - u0           |
//!         | L_v   L_p        0                         L_r                |
//!         | 0     1          0                         tan(theta0) cos(phi0) |
//!         | N_v   N_p        0                         N_r                |                        (1)
//! which is (2), (4), (23) and (24) of Padfield et al. 1987, linearised about trim. Dutch roll: the faster complex pair; with its
//! root lambda = sigma + j omega_d,
//!     omega = |lambda|,   zeta = -sigma/omega                                                      (2)
//!     d omega = Re(conj(lambda) d lambda)/omega,   d zeta = -(d sigma + zeta d omega)/omega         (3)
//! and, with d lambda/d A exact (`num::eigen`), variances by the delta method, g' Sigma g,             (4)
//! the uncertainty of u0 and w0 included.
//! Roll is the real root largest in size, spiral the smallest. Where they are a second complex pair, that is reported.
//! Numerics: (4) is first order: valid while the standard errors are small beside the distances between roots.
//! Returns no roots where A is not finite, and no standard error at a double root.

use super::record::{ModesRecord, OscillatoryMode, RealRoot};
use crate::dynamics::linear::kinematic_entries;
use crate::num::eigen::{eigenvalues_4, sensitivity};
use crate::realtime::regression::record::{LATERAL, LateralDerivatives, Status};
use nalgebra::Complex;

/// Place of v p phi r among the states of `linear`: the last four.
const LATERAL_STATES: usize = 4;

/// Where each lateral derivative stands in A.
const PLACES: [(usize, usize); LATERAL] = [(0, 0), (0, 1), (0, 3), (1, 0), (1, 1), (1, 3), (3, 0), (3, 1), (3, 3)];

/// Places of Y_p and Y_r among them.
const Y_P: usize = 1;
const Y_R: usize = 2;

/// Roots this close to the real axis (relative) count as real.
const REAL: f64 = 1e-9;

/// (1).
pub fn matrix(lateral: &LateralDerivatives) -> [[f64; 4]; 4] {
    let mut a = [[0.0; 4]; 4];
    for (value, (i, j)) in lateral.values.into_iter().zip(PLACES) {
        a[i][j] = value;
    }
    // Of the whole aircraft's states the last four; its v0 stands in none of their rows.
    for (row, column, value) in kinematic_entries([lateral.u0, 0.0, lateral.w0], lateral.phi0, lateral.theta0) {
        if let (Some(row), Some(column)) = (row.checked_sub(LATERAL_STATES), column.checked_sub(LATERAL_STATES)) {
            a[row][column] += value;
        }
    }
    a
}

/// Gradient of a root with respect to the lateral derivatives; zero at a double root, where there is none.
fn gradient(a: &[[f64; 4]; 4], root: Complex<f64>) -> Option<[Complex<f64>; LATERAL]> {
    let slope = sensitivity(a, root)?;
    Some(PLACES.map(|(i, j)| slope[i][j]))
}

/// g' Sigma g.
fn variance(gradient: &[f64; LATERAL], cov: &[[f64; LATERAL]; LATERAL]) -> f64 {
    let mut sum = 0.0;
    for (row, gi) in cov.iter().zip(gradient) {
        for (entry, gj) in row.iter().zip(gradient) {
            sum += gi * entry * gj;
        }
    }
    sum
}

/// d omega and d zeta of a root for d lambda; (3).
pub(super) fn d_omega_zeta(root: Complex<f64>, d: Complex<f64>) -> [f64; 2] {
    let omega = libm::hypot(root.re, root.im);
    let zeta = -root.re / omega;
    let d_omega = (root.re * d.re + root.im * d.im) / omega;
    [d_omega, -(d.re + zeta * d_omega) / omega]
}

/// Of the pairs among the roots the one nearest to `guide`, imaginary part positive.
pub(super) fn nearest(roots: &[Complex<f64>], guide: Complex<f64>) -> Option<Complex<f64>> {
    let pairs = roots.iter().filter(|root| root.im > REAL * libm::hypot(root.re, root.im));
    pairs.copied().min_by(|one, other| (one - guide).norm_sqr().total_cmp(&(other - guide).norm_sqr()))
}

/// A complex pair with its standard errors, (2) to (4).
fn oscillation(a: &[[f64; 4]; 4], cov: &[[f64; LATERAL]; LATERAL], root: Complex<f64>) -> OscillatoryMode {
    let omega = libm::hypot(root.re, root.im);
    let zeta = -root.re / omega;
    let (mut std_omega, mut std_zeta) = (f64::NAN, f64::NAN);
    if let Some(slope) = gradient(a, root) {
        let moved = slope.map(|d| d_omega_zeta(root, d));
        std_omega = libm::sqrt(variance(&moved.map(|[d_omega, _]| d_omega), cov));
        std_zeta = libm::sqrt(variance(&moved.map(|[_, d_zeta]| d_zeta), cov));
    }
    OscillatoryMode { real: root.re, imag: root.im, omega, zeta, std_omega, std_zeta }
}

fn real_root(a: &[[f64; 4]; 4], cov: &[[f64; LATERAL]; LATERAL], root: Complex<f64>) -> RealRoot {
    let std = gradient(a, root).map_or(f64::NAN, |slope| libm::sqrt(variance(&slope.map(|d| d.re), cov)));
    RealRoot { value: root.re, std }
}

/// The modes of the lateral subsystem; `None` where its matrix is not finite.
pub fn modes(time_s: f64, status: Status, lateral: &LateralDerivatives) -> Option<ModesRecord> {
    let a = matrix(lateral);
    let roots = eigenvalues_4(&a)?;
    // u0 and w0 are in A at the places of Y_r and Y_p, with the standard errors of the trim.
    let mut cov = lateral.cov;
    for (trim_std, place) in lateral.trim_std.into_iter().zip([Y_R, Y_P]) {
        cov[place][place] += trim_std * trim_std;
    }
    let mut record = ModesRecord::empty(time_s, status);
    let mut pairs: [Option<Complex<f64>>; 2] = [None; 2];
    for root in roots {
        let size = libm::hypot(root.re, root.im);
        if root.im > REAL * size {
            let slower = pairs[0].replace(root);
            pairs[1] = slower;
        } else if root.im.abs() <= REAL * size {
            let real = real_root(&a, &cov, root);
            if record.roll.is_none_or(|roll| size > roll.value.abs()) {
                record.roll = Some(real);
            }
            if record.spiral.is_none_or(|spiral| size < spiral.value.abs()) {
                record.spiral = Some(real);
            }
        }
    }
    if let [Some(first), Some(second)] = pairs
        && second.norm_sqr() > first.norm_sqr()
    {
        pairs.swap(0, 1);
    }
    let [dutch_roll, phugoid] = pairs.map(|pair| pair.map(|root| oscillation(&a, &cov, root)));
    record.dutch_roll = dutch_roll;
    record.lateral_phugoid = phugoid;
    Some(record)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn paper_level() -> LateralDerivatives {
        // Published HELISTAB level case: Dutch roll -0.057 +- 0.94 j, roll -2.136, spiral -0.178; L_v and N_v solved for it.
        LateralDerivatives {
            values: [-0.138, 0.0, 0.0, -0.070_244_671_607_728_38, -1.79, 0.138, 0.005_648_012_037_947_431, -0.21, -0.5],
            cov: [[0.0; LATERAL]; LATERAL],
            u0: 51.44,
            w0: 0.0,
            trim_std: [0.0; 2],
            phi0: 0.0,
            theta0: 0.0,
        }
    }

    #[test]
    fn the_papers_level_case_has_its_dutch_roll() {
        let modes = modes(0.0, Status::Converged, &paper_level()).unwrap();
        let dutch_roll = modes.dutch_roll.unwrap();
        // The case was solved with g = 9.81; ours is 9.80665.
        assert!((dutch_roll.real + 0.057).abs() < 2e-4 && (dutch_roll.imag - 0.94).abs() < 2e-4, "{dutch_roll:?}");
        assert!((modes.roll.unwrap().value + 2.136).abs() < 1e-3 && (modes.spiral.unwrap().value + 0.178).abs() < 1e-3);
        assert!(modes.lateral_phugoid.is_none());
    }

    #[test]
    fn standard_errors_are_those_of_a_monte_carlo() {
        let mut lateral = paper_level();
        // Correlated: N_r and N_p move together, L_p on its own.
        lateral.cov[8][8] = 4e-4;
        lateral.cov[7][7] = 1e-4;
        lateral.cov[7][8] = 1.5e-4;
        lateral.cov[8][7] = 1.5e-4;
        lateral.cov[4][4] = 1e-3;
        let modes = modes(0.0, Status::Converged, &lateral).unwrap();
        let mut seed = 7_u64;
        let mut uniform = || {
            seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            ((seed >> 11) as f64 + 0.5) / (1_u64 << 53) as f64
        };
        let mut normal = || libm::sqrt(-2.0 * libm::log(uniform())) * libm::cos(2.0 * core::f64::consts::PI * uniform());
        let n = 20_000;
        let (mut omega, mut zeta, mut roll) = ([0.0; 2], [0.0; 2], [0.0; 2]);
        for _ in 0..n {
            let (a, b, c) = (normal(), normal(), normal());
            let mut drawn = lateral;
            drawn.values[7] += 0.01 * a;
            drawn.values[8] += 0.015 * a + libm::sqrt(4e-4 - 2.25e-4) * b;
            drawn.values[4] += libm::sqrt(1e-3) * c;
            let drawn = super::modes(0.0, Status::Converged, &drawn).unwrap();
            let pair = drawn.dutch_roll.unwrap();
            for (sums, value) in [(&mut omega, pair.omega), (&mut zeta, pair.zeta), (&mut roll, drawn.roll.unwrap().value)] {
                sums[0] += value;
                sums[1] += value * value;
            }
        }
        let std = |sums: [f64; 2]| libm::sqrt(sums[1] / f64::from(n) - libm::pow(sums[0] / f64::from(n), 2.0));
        let pair = modes.dutch_roll.unwrap();
        // 20,000 draws know a standard deviation to 0.5 %; the rest is the curvature that (4) leaves out.
        assert!((std(omega) / pair.std_omega - 1.0).abs() < 0.03, "{} {}", std(omega), pair.std_omega);
        assert!((std(zeta) / pair.std_zeta - 1.0).abs() < 0.03, "{} {}", std(zeta), pair.std_zeta);
        assert!((std(roll) / modes.roll.unwrap().std - 1.0).abs() < 0.03);
    }

    #[test]
    fn a_matrix_that_is_not_finite_has_no_modes() {
        let mut lateral = paper_level();
        lateral.values[3] = f64::NAN;
        assert!(modes(0.0, Status::Converged, &lateral).is_none());
    }
}
