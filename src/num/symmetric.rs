//! Eigenvalues and eigenvectors of a symmetric matrix whose order is known only at run time.
//!
//! Consumes A [n x n], row after row; leaves its eigenvalues on the diagonal and the eigenvectors as columns of V:
//!     A <- J' A J,  V <- V J,  J the plane rotation that annihilates entry (i, j)                  (1)
//! for every pair in turn (cyclic Jacobi), until the matrix is diagonal.
//! Source: C. G. J. Jacobi, 1846, in the form of H. Rutishauser, Numer. Math. 9, 1966.
//! Numerics: small eigenvalues of a matrix with unit diagonal come out to nearly full relative accuracy (Demmel and Veselic,
//! SIAM J. Matrix Anal. 13, 1992), which condition indexes need.

/// Rounds over all pairs.
const ROUNDS: usize = 60;

/// An entry smaller than this part of its diagonal entries counts as none.
const NONE: f64 = 1e-16;

/// (1): `a` becomes diagonal, `v` the eigenvectors; both of `order * order` entries. `false` where it does not end (entries
/// that are no numbers).
#[must_use]
pub fn diagonalise(a: &mut [f64], v: &mut [f64], order: usize) -> bool {
    v.fill(0.0);
    v.iter_mut().step_by(order + 1).for_each(|entry| *entry = 1.0);
    for _ in 0..ROUNDS {
        let mut turned = false;
        for i in 0..order {
            for j in i + 1..order {
                turned |= turn(a, v, order, i, j);
            }
        }
        if !turned {
            return a.iter().all(|entry| entry.is_finite());
        }
    }
    false
}

fn turn(a: &mut [f64], v: &mut [f64], order: usize, i: usize, j: usize) -> bool {
    let (own_i, own_j, both) = (a[i * order + i], a[j * order + j], a[i * order + j]);
    if libm::fabs(both) <= NONE * libm::sqrt(libm::fabs(own_i * own_j)) {
        return false;
    }
    let ratio = (own_j - own_i) / (2.0 * both);
    let sign = if ratio < 0.0 { -1.0 } else { 1.0 };
    let tangent = sign / (libm::fabs(ratio) + libm::sqrt(ratio * ratio + 1.0));
    let cosine = 1.0 / libm::sqrt(tangent * tangent + 1.0);
    let sine = tangent * cosine;
    for k in 0..order {
        rotate(a, k * order + i, k * order + j, cosine, sine);
    }
    for k in 0..order {
        rotate(a, i * order + k, j * order + k, cosine, sine);
        rotate(v, k * order + i, k * order + j, cosine, sine);
    }
    true
}

fn rotate(entries: &mut [f64], first: usize, second: usize, cosine: f64, sine: f64) {
    let (x, y) = (entries[first], entries[second]);
    entries[first] = cosine * x - sine * y;
    entries[second] = sine * x + cosine * y;
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::DMatrix;

    #[test]
    fn the_decomposition_is_that_of_nalgebra_and_gives_the_matrix_back() {
        let x = DMatrix::from_fn(30, 7, |i, j| libm::sin(0.4 * (i * (j + 1)) as f64) + 0.3 * j as f64);
        let matrix = x.transpose() * &x;
        let (mut a, mut v) = (matrix.as_slice().to_vec(), vec![0.0; 49]);
        assert!(diagonalise(&mut a, &mut v, 7));
        let mut own: Vec<f64> = (0..7).map(|i| a[8 * i]).collect();
        let mut theirs: Vec<f64> = matrix.symmetric_eigenvalues().iter().copied().collect();
        own.sort_by(f64::total_cmp);
        theirs.sort_by(f64::total_cmp);
        assert!(own.iter().zip(&theirs).all(|(a, b)| (a - b).abs() < 1e-10 * theirs[6]), "{own:?} {theirs:?}");
        for i in 0..7 {
            for j in 0..7 {
                let back: f64 = (0..7).map(|k| v[7 * i + k] * a[8 * k] * v[7 * j + k]).sum();
                assert!((back - matrix[(i, j)]).abs() < 1e-10 * theirs[6]);
            }
        }
    }

    #[test]
    fn what_is_no_number_is_refused() {
        let (mut a, mut v) = ([1.0, f64::NAN, f64::NAN, 1.0], [0.0; 4]);
        assert!(!diagonalise(&mut a, &mut v, 2));
    }
}
