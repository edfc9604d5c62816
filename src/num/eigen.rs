//! Eigenvalues of small real matrices and their exact sensitivity to every entry.
//!
//! Consumes A [N x N]; produces lambda \[N\] and, for a simple lambda,
//!     d lambda / d A_ij = adj(lambda I - A)_ji / trace adj(lambda I - A)                          (1)
//! with the adjugate as a polynomial in lambda, adj(lambda I - A) = sum_k lambda^(N-1-k) B_k (Faddeev and LeVerrier):
//!     B_0 = I,  c_k = -trace(A B_(k-1))/k,  B_k = A B_(k-1) + c_k I                               (2)
//! (1) follows from adj(lambda I - A) = (product of the other lambda - lambda_i) x y', x and y the right and left
//! eigenvectors; its trace is the derivative of the characteristic polynomial.
//! Participation factors of a mode: with right and left eigenvectors v and w of its eigenvalue, state k takes part with
//!     p_k = |v_k w_k| / sum_j |v_j w_j|                                                          (3)
//! which no change of a state's unit alters.
//! Source: F. R. Gantmacher, The Theory of Matrices, 1959, ch. IV.5; P. Lancaster, On eigenvalues of matrices dependent on
//! a parameter, Numer. Math. 6, 1964; of (3) I. J. Perez-Arriaga, G. C. Verghese, F. C. Schweppe, IEEE Trans. PAS-101(9), 1982.
//! Eigenvalues by nalgebra's real Schur form, eigenvectors by inverse iteration beside the eigenvalue.
//! Numerics: double eigenvalues have no derivative; [`sensitivity`] then returns `None`, never a huge number.

#![expect(clippy::needless_range_loop, reason = "indices are those of the equations")]

use nalgebra::allocator::Allocator;
use nalgebra::{Complex, DefaultAllocator, DimMin, Matrix4, OMatrix, OVector, SMatrix, Schur};

/// Largest number of iterations of the Schur form.
const ITERATIONS: usize = 500;

/// Two eigenvalues closer than this part of the matrix' size count as double.
const DOUBLE: f64 = 1e-9;

/// Eigenvalues of a 4 x 4 matrix; `None` where it is not finite or the iteration does not converge.
pub fn eigenvalues_4(a: &[[f64; 4]; 4]) -> Option<[Complex<f64>; 4]> {
    let matrix = Matrix4::from_fn(|i, j| a[i][j]);
    if !matrix.iter().all(|entry| entry.is_finite()) {
        return None;
    }
    let roots = Schur::try_new(matrix, f64::EPSILON, ITERATIONS)?.complex_eigenvalues();
    Some([roots[0], roots[1], roots[2], roots[3]])
}

/// Eigenvalues of an 8 x 8 matrix; `None` where it is not finite or the iteration does not converge.
pub fn eigenvalues_8(a: &[[f64; 8]; 8]) -> Option<[Complex<f64>; 8]> {
    let matrix = SMatrix::<f64, 8, 8>::from_fn(|i, j| a[i][j]);
    if !matrix.iter().all(|entry| entry.is_finite()) {
        return None;
    }
    let roots = Schur::try_new(matrix, f64::EPSILON, ITERATIONS)?.complex_eigenvalues();
    Some(core::array::from_fn(|i| roots[i]))
}

/// (1): entry `[i][j]` is the derivative of the eigenvalue `lambda` of `a` with respect to `a[i][j]`; `None` where `lambda`
/// is (nearly) a double eigenvalue.
pub fn sensitivity<const N: usize>(a: &[[f64; N]; N], lambda: Complex<f64>) -> Option<[[Complex<f64>; N]; N]> {
    let mut b = [[0.0; N]; N];
    let mut adjugate = [[Complex::new(0.0, 0.0); N]; N];
    for i in 0..N {
        b[i][i] = 1.0;
        adjugate[i][i] = Complex::new(1.0, 0.0);
    }
    for k in 1..N {
        let mut ab = [[0.0; N]; N];
        for i in 0..N {
            for j in 0..N {
                for (l, row) in b.iter().enumerate() {
                    ab[i][j] += a[i][l] * row[j];
                }
            }
        }
        let mut trace = 0.0;
        for (i, row) in ab.iter().enumerate() {
            trace += row[i];
        }
        b = ab;
        for (i, row) in b.iter_mut().enumerate() {
            row[i] -= trace / k as f64;
        }
        for i in 0..N {
            for j in 0..N {
                adjugate[i][j] = adjugate[i][j] * lambda + b[i][j];
            }
        }
    }
    let mut trace = Complex::new(0.0, 0.0);
    let mut largest: f64 = 0.0;
    for i in 0..N {
        trace += adjugate[i][i];
        for entry in &adjugate[i] {
            largest = largest.max(libm::hypot(entry.re, entry.im));
        }
    }
    let slope = libm::hypot(trace.re, trace.im);
    if !(slope > DOUBLE * largest) {
        return None;
    }
    Some(core::array::from_fn(|i| core::array::from_fn(|j| adjugate[j][i] / trace)))
}

/// (3) for the mode of an eigenvalue of `a`; `None` where no eigenvector comes out.
pub fn participation<D>(a: &OMatrix<f64, D, D>, lambda: Complex<f64>) -> Option<OVector<f64, D>>
where
    D: DimMin<D, Output = D>,
    DefaultAllocator: Allocator<D> + Allocator<D, D>,
{
    let (right, left) = (eigenvector(a, lambda)?, eigenvector(&a.transpose(), lambda)?);
    let products = right.zip_map(&left, |v, w| libm::hypot(v.re, v.im) * libm::hypot(w.re, w.im));
    let sum: f64 = products.iter().sum();
    (sum > 0.0 && sum.is_finite()).then(|| products.map(|product| product / sum))
}

/// Inverse iteration: solving with A less almost the eigenvalue leaves little but its eigenvector.
fn eigenvector<D>(a: &OMatrix<f64, D, D>, lambda: Complex<f64>) -> Option<OVector<Complex<f64>, D>>
where
    D: DimMin<D, Output = D>,
    DefaultAllocator: Allocator<D> + Allocator<D, D>,
{
    const BESIDE: f64 = 1e-8;
    let beside = lambda + Complex::from(BESIDE * (1.0 + libm::hypot(lambda.re, lambda.im)));
    let size = a.shape_generic().0;
    let shifted = OMatrix::<Complex<f64>, D, D>::from_fn_generic(size, size, |row, column| {
        Complex::from(a[(row, column)]) - if row == column { beside } else { Complex::from(0.0) }
    });
    let lu = shifted.lu();
    let mut vector = OVector::<Complex<f64>, D>::from_element_generic(size, nalgebra::Const::<1>, Complex::new(1.0, 0.5));
    for _ in 0..3 {
        vector = lu.solve(&vector)?;
        let size = vector.iter().map(|part| libm::fabs(part.re).max(libm::fabs(part.im))).fold(0.0, f64::max);
        vector /= Complex::from(size);
    }
    Some(vector)
}

/// Largest condition index of the columns `chosen` of X (at most 11) brought to unit length: largest over smallest singular
/// value, from their sums of products X'X; infinite where they are dependent.
///
/// Source: D. A. Belsley, E. Kuh and R. E. Welsch, Regression Diagnostics, 1980, ch. 3.
pub fn condition_index<const N: usize>(sums: &[[f64; N]; N], chosen: &[usize]) -> f64 {
    // A column that is not chosen stands as one of its own: eigenvalue 1, which is never the largest or the smallest.
    let scaled = SMatrix::<f64, CHOSEN, CHOSEN>::from_fn(|i, j| match (chosen.get(i), chosen.get(j)) {
        (Some(&a), Some(&b)) => sums[a][b] / libm::sqrt(sums[a][a] * sums[b][b]),
        _ if i == j => 1.0,
        _ => 0.0,
    });
    if !scaled.iter().all(|entry| entry.is_finite()) {
        return f64::INFINITY;
    }
    let values = scaled.symmetric_eigenvalues();
    let (smallest, largest) = (values.min(), values.max());
    if smallest > 0.0 { libm::sqrt(largest / smallest) } else { f64::INFINITY }
}

/// Columns that [`condition_index`] can take.
const CHOSEN: usize = 11;

#[cfg(test)]
mod tests {
    use super::*;

    const A: [[f64; 4]; 4] =
        [[-0.138, 0.0, 9.81, -51.44], [-0.0702, -1.79, 0.0, 0.138], [0.0, 1.0, 0.0, 0.01], [0.0056, -0.21, 0.0, -0.5]];

    #[test]
    fn participation_is_that_of_a_mode_found_by_hand() {
        // x1' = -x1 + x2, x2' = -3 x2: of -1 the right eigenvector is (1, 0), the left (2, 1); of -3 (1, -2) and (0, 1). The
        // unit of a state alters neither. An integrator beside them takes part in its own mode alone, also at the root zero.
        for unit in [1.0, 1e4] {
            let a = nalgebra::Matrix3::new(-1.0, unit, 0.0, 0.0, -3.0, 0.0, 0.0, 0.0, 0.0);
            for (place, root) in [-1.0, -3.0, 0.0].into_iter().enumerate() {
                let shares = participation(&a, Complex::from(root)).unwrap();
                for (state, share) in shares.iter().enumerate() {
                    assert!((share - f64::from(u8::from(state == place))).abs() < 1e-6, "{root}: {shares}");
                }
            }
        }
        // An oscillator at rest in neither of its states: half each.
        let oscillator = nalgebra::DMatrix::from_row_slice(2, 2, &[0.0, 4.0, -1.0, 0.0]);
        let shares = participation(&oscillator, Complex::new(0.0, 2.0)).unwrap();
        assert!(shares.iter().all(|share| (share - 0.5).abs() < 1e-6), "{shares}");
    }

    #[test]
    fn a_companion_matrix_has_the_roots_of_its_polynomial() {
        // (s + 1)(s + 2)(s^2 + 2 s + 5): roots -1, -2, -1 +- 2j.
        let companion = [[-5.0, -13.0, -19.0, -10.0], [1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]];
        let roots = eigenvalues_4(&companion).unwrap();
        for expected in [(-2.0, 0.0), (-1.0, -2.0), (-1.0, 0.0), (-1.0, 2.0)] {
            let near = |root: &Complex<f64>| (root.re - expected.0).abs() < 1e-12 && (root.im - expected.1).abs() < 1e-12;
            assert_eq!(roots.iter().filter(|root| near(root)).count(), 1, "{expected:?} in {roots:?}");
        }
    }

    #[test]
    fn sensitivity_is_the_central_difference_of_the_eigenvalue() {
        let roots = eigenvalues_4(&A).unwrap();
        for root in roots {
            let slope = sensitivity(&A, root).unwrap();
            for i in 0..4 {
                for j in 0..4 {
                    let step = 1e-6;
                    let moved = |sign: f64| {
                        let mut a = A;
                        a[i][j] += sign * step;
                        let near = eigenvalues_4(&a).unwrap();
                        *near.iter().min_by(|x, y| (*x - root).norm_sqr().partial_cmp(&(*y - root).norm_sqr()).unwrap()).unwrap()
                    };
                    let difference = (moved(1.0) - moved(-1.0)) / (2.0 * step);
                    assert!((difference - slope[i][j]).norm_sqr() < 1e-10 * (1.0 + slope[i][j].norm_sqr()), "{i} {j}");
                }
            }
        }
    }

    #[test]
    fn condition_index_of_two_columns_is_the_closed_form() {
        // Unit columns with cosine c: singular values sqrt(1 +- c).
        let c: f64 = 0.96;
        let sums = [[4.0, 7.0, 2.0 * 3.0 * c], [7.0, 50.0, 1.0], [2.0 * 3.0 * c, 1.0, 9.0]];
        assert!((condition_index(&sums, &[0, 2]) - libm::sqrt((1.0 + c) / (1.0 - c))).abs() < 1e-12);
        assert!((condition_index(&sums, &[1]) - 1.0).abs() < 1e-12);
        assert!(condition_index(&[[1.0, 1.0], [1.0, 1.0]], &[0, 1]) > 1e7);
    }

    #[test]
    fn a_double_eigenvalue_has_no_sensitivity_and_nan_no_eigenvalue() {
        let defective = [[1.0, 1.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 2.0, 0.0], [0.0, 0.0, 0.0, 3.0]];
        assert!(sensitivity(&defective, Complex::new(1.0, 0.0)).is_none());
        assert!(eigenvalues_4(&[[f64::NAN; 4]; 4]).is_none());
    }
}
