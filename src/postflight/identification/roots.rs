//! Modes of an identified model: roots of A, their names, and standard errors propagated from the derivatives.
//!
//! Consumes A [n x n] with its parameters and their covariance; produces roots. With a root lambda of A, x its right and y its
//! left eigenvector, d lambda = y' dA x/(y' x), and by the delta method
//!     var(g) = grad g' Sigma grad g     omega = |lambda|     zeta = -Re(lambda)/omega                  (1)
//!     Pr(unstable) = Phi(Re(lambda)/std(Re(lambda))), Phi the normal distribution function             (2)
//! with Sigma that of the derivatives and, independent of it, that of the trim's numbers, which are known entries of A.
//! Names by participation factors: `realtime::modes::naming`.
//! A model that takes sideslip or incidence as an input has roots that are not modes of the aircraft: `Err`.
//! Numerics: (1) with central differences of the roots over each parameter, a thousandth of its standard error wide, matched
//! to the nearest root; first order, so valid while standard errors are small beside the distances between roots.

use crate::num::dense::Dense;
use crate::postflight::output_error::{MatrixEntry, ModelStructure};
use crate::realtime::modes::naming::mode_names;
use nalgebra::{Complex, DMatrix};

/// Half width of a difference, in standard errors.
const DIFFERENCE: f64 = 1e-3;

/// A root of A with its standard errors.
#[derive(Clone, Debug, PartialEq)]
pub struct IdentifiedRoot {
    /// As `mode_names` has it; `None` where it has no name.
    pub name: Option<&'static str>,
    /// Real part, 1/s.
    pub real: f64,
    /// Imaginary part, zero or more, rad/s.
    pub imag: f64,
    /// Standard errors of both.
    pub std_real: f64,
    /// See `std_real`.
    pub std_imag: f64,
    /// |lambda|, rad/s, and its standard error.
    pub omega: f64,
    /// See `omega`.
    pub std_omega: f64,
    /// Damping ratio, and its standard error.
    pub zeta: f64,
    /// See `zeta`.
    pub std_zeta: f64,
    /// Probability that its real part is more than zero, (2).
    pub probability_unstable: f64,
}

/// Roots of the model, or the reason why they are not modes of the aircraft.
pub type Modes = Result<Vec<IdentifiedRoot>, String>;

/// A at these parameters.
pub fn matrix(rows: &[Vec<MatrixEntry>], theta: &[f64]) -> DMatrix<f64> {
    let n = rows.len();
    DMatrix::from_fn(n, n, |i, j| rows.get(i).and_then(|row| row.get(j)).map_or(0.0, |entry| entry.value(theta)))
}

/// Modes of A, from the covariance of the parameters and the change of A by one standard error of each number of the trim.
pub fn modes(structure: &ModelStructure, theta: &[f64], cov: &Dense, trim_steps: &[DMatrix<f64>]) -> Modes {
    if let Some(input) =
        structure.inputs.iter().find(|name| matches!(name.as_str(), "beta" | "alpha" | "v" | "w" | "p" | "q" | "r"))
    {
        return Err(format!(
            "`{input}` is an input here: what responds to it is no state, so the roots are no modes of the aircraft"
        ));
    }
    let centre = upper(&matrix(&structure.a, theta))?;
    let count = theta.len();
    // Derivatives of the roots with respect to each parameter.
    let mut slopes = vec![vec![Complex::new(0.0, 0.0); count]; centre.len()];
    for place in 0..count {
        let std = libm::sqrt(cov[(place, place)].max(0.0));
        let step = DIFFERENCE * std;
        if !(step > 0.0) {
            continue;
        }
        let roots_at = |by: f64| {
            let mut theta = theta.to_vec();
            if let Some(value) = theta.get_mut(place) {
                *value += by;
            }
            upper(&matrix(&structure.a, &theta))
        };
        let (ahead, behind) = (roots_at(step)?, roots_at(-step)?);
        for (slopes, root) in slopes.iter_mut().zip(&centre) {
            if let Some(slope) = slopes.get_mut(place) {
                *slope = (nearest(&ahead, *root) - nearest(&behind, *root)) / (2.0 * step);
            }
        }
    }
    // Changes by the trim's standard errors, after the parameters.
    let a = matrix(&structure.a, theta);
    for step in trim_steps {
        let (ahead, behind) = (upper(&(&a + step * DIFFERENCE))?, upper(&(&a - step * DIFFERENCE))?);
        for (slopes, root) in slopes.iter_mut().zip(&centre) {
            slopes.push((nearest(&ahead, *root) - nearest(&behind, *root)) / (2.0 * DIFFERENCE));
        }
    }
    let std = |gradient: &dyn Fn(Complex<f64>) -> f64, slopes: &[Complex<f64>]| {
        let g: Vec<f64> = slopes.iter().take(count).map(|&slope| gradient(slope)).collect();
        let mut var: f64 = slopes.iter().skip(count).map(|&slope| gradient(slope) * gradient(slope)).sum();
        for (i, gi) in g.iter().enumerate() {
            for (j, gj) in g.iter().enumerate() {
                var += gi * gj * cov[(i, j)];
            }
        }
        libm::sqrt(var.max(0.0))
    };
    let mut roots: Vec<IdentifiedRoot> = centre
        .iter()
        .zip(&slopes)
        .map(|(root, slopes)| {
            let omega = libm::hypot(root.re, root.im);
            let zeta = if omega > 0.0 { -root.re / omega } else { 0.0 };
            let d_omega = |slope: Complex<f64>| if omega > 0.0 { (root.re * slope.re + root.im * slope.im) / omega } else { 0.0 };
            let std_real = std(&|slope| slope.re, slopes);
            IdentifiedRoot {
                name: None,
                real: root.re,
                imag: root.im,
                std_real,
                probability_unstable: above_zero(root.re, std_real),
                std_imag: std(&|slope| slope.im, slopes),
                omega,
                std_omega: std(&d_omega, slopes),
                zeta,
                std_zeta: if omega > 0.0 { std(&|slope| -(slope.re + zeta * d_omega(slope)) / omega, slopes) } else { 0.0 },
            }
        })
        .collect();
    for (root, name) in roots.iter_mut().zip(mode_names(&structure.states, &a, &centre)) {
        root.name = name;
    }
    Ok(roots)
}

fn nearest(roots: &[Complex<f64>], root: Complex<f64>) -> Complex<f64> {
    roots.iter().copied().min_by(|a, b| (a - root).norm_sqr().total_cmp(&(b - root).norm_sqr())).unwrap_or(root)
}

/// (2); 0 or 1 by the sign of a value without an error.
fn above_zero(value: f64, std: f64) -> f64 {
    if std > 0.0 { 0.5 * libm::erfc(-value / (core::f64::consts::SQRT_2 * std)) } else { f64::from(u8::from(value > 0.0)) }
}

/// Roots with an imaginary part of zero or more, the fastest first.
fn upper(a: &DMatrix<f64>) -> Result<Vec<Complex<f64>>, String> {
    if a.iter().any(|entry| !entry.is_finite()) {
        return Err("the matrix is not finite".to_owned());
    }
    let schur = nalgebra::Schur::try_new(a.clone(), f64::EPSILON, 10_000).ok_or("the roots were not found")?;
    let mut roots: Vec<Complex<f64>> = schur.complex_eigenvalues().iter().copied().filter(|root| root.im >= 0.0).collect();
    roots.sort_by(|one, other| other.norm_sqr().total_cmp(&one.norm_sqr()));
    Ok(roots)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn free(place: usize) -> MatrixEntry {
        MatrixEntry { fixed: 0.0, terms: vec![(place, 1.0)] }
    }

    fn fixed(value: f64) -> MatrixEntry {
        MatrixEntry { fixed: value, terms: Vec::new() }
    }

    fn structure(states: &[&str], input: &str, a: Vec<Vec<MatrixEntry>>) -> ModelStructure {
        ModelStructure {
            states: states.iter().map(|&name| name.to_owned()).collect(),
            inputs: vec![input.to_owned()],
            outputs: Vec::new(),
            a,
            b: Vec::new(),
            c: Vec::new(),
            d: Vec::new(),
            state_bias: Vec::new(),
            output_bias: Vec::new(),
            initial_state: Vec::new(),
        }
    }

    #[test]
    fn an_oscillators_roots_and_their_errors_are_those_computed_by_hand() {
        // q' = -k alpha - c q, alpha' = q: omega^2 = k, 2 zeta omega = c.
        let structure = structure(&["alpha", "q"], "elevator", vec![vec![fixed(0.0), fixed(1.0)], vec![free(0), free(1)]]);
        let (k, c) = (4.0, 0.8);
        let entries = [[0.04, 0.002], [0.002, 0.01]];
        let cov = Dense::from_fn(2, 2, |i, j| entries[i][j]);
        let found = modes(&structure, &[-k, -c], &cov, &[]).unwrap();
        let [pair] = found.as_slice() else { panic!("{found:?}") };
        assert_eq!(pair.name, Some("short_period"));
        assert!((pair.omega - 2.0).abs() < 1e-12 && (pair.zeta - 0.2).abs() < 1e-12);
        // d omega = -d theta0/(2 omega); zeta = -theta1/(2 omega).
        assert!((pair.std_omega - 0.2 / 4.0).abs() < 1e-8, "{pair:?}");
        let (g0, g1) = (c / (4.0 * k * 2.0), -1.0 / 4.0);
        let by_hand = (g0 * g0 * 0.04 + 2.0 * g0 * g1 * 0.002 + g1 * g1 * 0.01f64).sqrt();
        assert!((pair.std_zeta - by_hand).abs() < 1e-8, "{} {by_hand}", pair.std_zeta);
        assert!(pair.std_real > 0.0 && pair.probability_unstable < 1e-10, "{pair:?}");
    }

    #[test]
    fn the_probability_of_instability_is_the_normal_distributions() {
        for (value, known) in [(0.0, 0.5), (0.1, 0.841_344_746), (-0.1, 0.158_655_254), (-0.3, 0.001_349_898)] {
            assert!((above_zero(value, 0.1) - known).abs() < 1e-9, "{value}");
        }
        assert!(above_zero(-0.1, 0.0) < 1e-12 && above_zero(0.1, 0.0) > 0.5);
    }

    #[test]
    fn roots_of_both_planes_are_assigned_by_participation() {
        // A fast lateral pair, a slower longitudinal one, weakly coupled; roll and spiral.
        let a = [
            [-0.1, 0.0, 0.0, -50.0, 0.02, 0.0],
            [-0.02, -2.0, 0.0, 0.1, 0.0, 0.01],
            [0.0, 1.0, -0.02, 0.0, 0.0, 0.0],
            [0.08, 0.0, 0.0, -0.3, 0.0, 0.01],
            [0.01, 0.0, 0.0, 0.0, -0.6, 50.0],
            [0.0, 0.02, 0.0, 0.0, -0.02, -0.7],
        ];
        let a = a.iter().map(|row| row.iter().map(|&value| fixed(value)).collect()).collect();
        let structure = structure(&["v", "p", "phi", "r", "w", "q"], "pedal", a);
        let roots = modes(&structure, &[], &Dense::from_fn(0, 0, |_, _| 0.0), &[]).unwrap();
        let named = |name: &str| roots.iter().find(|root| root.name == Some(name)).map(|root| (root.real, root.imag));
        let near = |name: &str, omega: f64| {
            let (real, imag) = named(name).unwrap();
            assert!((real.hypot(imag) / omega - 1.0).abs() < 0.1, "{name}: {real} {imag}");
        };
        // By each plane alone: sqrt(50 0.08 + 0.03), sqrt(50 0.02 + 0.42), 2, 0.02.
        near("dutch_roll", 2.007);
        near("short_period", 1.192);
        near("roll", 2.0);
        assert!(named("spiral").is_some_and(|(real, _)| real.abs() < 0.1), "{roots:?}");
    }

    #[test]
    fn a_model_fed_with_sideslip_has_no_modes() {
        let mut structure = structure(&["p"], "beta", vec![vec![free(0)]]);
        let cov = Dense::from_fn(1, 1, |_, _| 1e-4);
        assert!(modes(&structure, &[-1.0], &cov, &[]).unwrap_err().contains("`beta` is an input"));
        structure.inputs = vec!["aileron".to_owned()];
        let roots = modes(&structure, &[-1.0], &cov, &[]).unwrap();
        assert!(roots[0].name.is_none() && (roots[0].std_real - 0.01).abs() < 1e-12);
    }
}
