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
//! the uncertainty of u0, w0 and theta0 included.
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

/// What a root of A moves by: the lateral derivatives and the pitch attitude in trim.
struct RootSlopes {
    derivatives: [Complex<f64>; LATERAL],
    pitch: Complex<f64>,
}

/// Those of a root; none at a double root.
fn slopes(a: &[[f64; 4]; 4], root: Complex<f64>, by_pitch: &[(usize, usize, f64)]) -> Option<RootSlopes> {
    let slope = sensitivity(a, root)?;
    let mut pitch = Complex::new(0.0, 0.0);
    for &(row, column, entry) in by_pitch {
        if let (Some(row), Some(column)) = (row.checked_sub(LATERAL_STATES), column.checked_sub(LATERAL_STATES)) {
            pitch += slope[row][column] * entry;
        }
    }
    Some(RootSlopes { derivatives: PLACES.map(|(i, j)| slope[i][j]), pitch })
}

/// What the derivatives and the trim are known to.
struct Uncertainty {
    cov: [[f64; LATERAL]; LATERAL],
    pitch_std: f64,
}

impl Uncertainty {
    /// Standard error of what moves by so much with the derivatives and the pitch attitude.
    fn std(&self, derivatives: &[f64; LATERAL], pitch: f64) -> f64 {
        libm::hypot(libm::sqrt(variance(derivatives, &self.cov)), pitch * self.pitch_std)
    }
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

/// Step of the pitch attitude for the slopes of A by it, rad.
const PITCH_STEP: f64 = 1e-4;

/// d A/d theta0: the kinematic entries, central differences.
pub(super) fn by_pitch(velocity: [f64; 3], phi0: f64, theta0: f64) -> [(usize, usize, f64); 16] {
    let mut slopes = kinematic_entries(velocity, phi0, theta0 + PITCH_STEP);
    for (slope, (.., before)) in slopes.iter_mut().zip(kinematic_entries(velocity, phi0, theta0 - PITCH_STEP)) {
        slope.2 = (slope.2 - before) / (2.0 * PITCH_STEP);
    }
    slopes
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
fn oscillation(root: Complex<f64>, slopes: Option<RootSlopes>, uncertainty: &Uncertainty) -> OscillatoryMode {
    let omega = libm::hypot(root.re, root.im);
    let zeta = -root.re / omega;
    let (mut std_omega, mut std_zeta) = (f64::NAN, f64::NAN);
    if let Some(slopes) = slopes {
        let moved = slopes.derivatives.map(|d| d_omega_zeta(root, d));
        let by_pitch = d_omega_zeta(root, slopes.pitch);
        std_omega = uncertainty.std(&moved.map(|[d_omega, _]| d_omega), by_pitch[0]);
        std_zeta = uncertainty.std(&moved.map(|[_, d_zeta]| d_zeta), by_pitch[1]);
    }
    OscillatoryMode { real: root.re, imag: root.im, omega, zeta, std_omega, std_zeta }
}

fn real_root(root: Complex<f64>, slopes: Option<RootSlopes>, uncertainty: &Uncertainty) -> RealRoot {
    let std = |slopes: RootSlopes| uncertainty.std(&slopes.derivatives.map(|d| d.re), slopes.pitch.re);
    RealRoot { value: root.re, std: slopes.map_or(f64::NAN, std) }
}

/// The modes of the lateral subsystem, its pitch attitude in trim known; `None` where its matrix is not finite.
pub fn modes(time_s: f64, status: Status, lateral: &LateralDerivatives) -> Option<ModesRecord> {
    modes_of_trim(time_s, status, lateral, 0.0)
}

/// The same with the standard error of the pitch attitude, rad.
pub fn modes_of_trim(time_s: f64, status: Status, lateral: &LateralDerivatives, pitch_std: f64) -> Option<ModesRecord> {
    let a = matrix(lateral);
    let roots = eigenvalues_4(&a)?;
    // u0 and w0 are in A at the places of Y_r and Y_p, with the standard errors of the trim.
    let mut cov = lateral.cov;
    for (trim_std, place) in lateral.trim_std.into_iter().zip([Y_R, Y_P]) {
        cov[place][place] += trim_std * trim_std;
    }
    let uncertainty = Uncertainty { cov, pitch_std };
    let by_pitch = by_pitch([lateral.u0, 0.0, lateral.w0], lateral.phi0, lateral.theta0);
    let mut record = ModesRecord::empty(time_s, status);
    let mut pairs: [Option<Complex<f64>>; 2] = [None; 2];
    for root in roots {
        let size = libm::hypot(root.re, root.im);
        if root.im > REAL * size {
            let slower = pairs[0].replace(root);
            pairs[1] = slower;
        } else if root.im.abs() <= REAL * size {
            let real = real_root(root, slopes(&a, root, &by_pitch), &uncertainty);
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
    let [dutch_roll, phugoid] = pairs.map(|pair| pair.map(|root| oscillation(root, slopes(&a, root, &by_pitch), &uncertainty)));
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

    /// By the pitch attitude alone each root moves as it does where the trim is another.
    #[test]
    fn a_pitch_attitude_that_is_not_known_is_in_the_standard_errors() {
        let mut lateral = paper_level();
        (lateral.theta0, lateral.phi0) = (0.06, 0.2);
        let at = |by: f64| {
            let mut moved = lateral;
            moved.theta0 += by;
            modes(0.0, Status::Converged, &moved).unwrap()
        };
        let found = modes_of_trim(0.0, Status::Converged, &lateral, 0.01).unwrap();
        let (up, down) = (at(0.005), at(-0.005));
        let spiral = libm::fabs(up.spiral.unwrap().value - down.spiral.unwrap().value);
        assert!((found.spiral.unwrap().std / spiral - 1.0).abs() < 1e-3, "{found:?} {spiral}");
        let (pair, up, down) = (found.dutch_roll.unwrap(), up.dutch_roll.unwrap(), down.dutch_roll.unwrap());
        assert!((pair.std_zeta / libm::fabs(up.zeta - down.zeta) - 1.0).abs() < 1e-3, "{pair:?}");
        assert!((pair.std_omega / libm::fabs(up.omega - down.omega) - 1.0).abs() < 1e-2, "{pair:?}");
    }

    #[test]
    fn a_matrix_that_is_not_finite_has_no_modes() {
        let mut lateral = paper_level();
        lateral.values[3] = f64::NAN;
        assert!(modes(0.0, Status::Converged, &lateral).is_none());
    }
}
