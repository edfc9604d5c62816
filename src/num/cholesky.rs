//! Cholesky factors of a symmetric matrix that lies row by row in a slice; a pivot that has vanished is refused by its place.
//!
//! Consumes A [n x n], of which the lower half is read; leaves L in it, the upper half zero:
//!     L L' = A,   L_jj = sqrt(d_j),   d_j = A_jj - sum_(k<j) L_jk^2                                    (1)
//! and solves L L' x = y. A pivot counts if d_j > tau A_jj; tau is the caller's, for only he knows how exact A is.
//! Source: the factorisation by columns, as in textbooks of numerical linear algebra.
//! Numerics: sums run upward from zero. Entries that are no numbers are refused at their pivot.

/// The row whose pivot is not above the least part of its diagonal entry.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct VanishedPivot(pub(crate) usize);

/// (1) in place.
///
/// # Errors
/// The first [`VanishedPivot`].
pub(crate) fn factor(a: &mut [f64], n: usize, least_part: f64) -> Result<(), VanishedPivot> {
    for j in 0..n {
        let whole = a[j * n + j];
        let mut pivot = whole;
        for k in 0..j {
            pivot -= a[j * n + k] * a[j * n + k];
        }
        if !(pivot > least_part * whole) || !pivot.is_finite() {
            return Err(VanishedPivot(j));
        }
        let root = libm::sqrt(pivot);
        a[j * n + j] = root;
        for i in j + 1..n {
            let mut sum = a[i * n + j];
            for k in 0..j {
                sum -= a[i * n + k] * a[j * n + k];
            }
            a[i * n + j] = sum / root;
        }
        a[j * n + j + 1..(j + 1) * n].fill(0.0);
    }
    Ok(())
}

/// Solves L L' x = y; `x` holds y before.
pub(crate) fn solve(l: &[f64], n: usize, x: &mut [f64]) {
    for i in 0..n {
        let mut sum = x[i];
        for k in 0..i {
            sum -= l[i * n + k] * x[k];
        }
        x[i] = sum / l[i * n + i];
    }
    for i in (0..n).rev() {
        let mut sum = x[i];
        for k in i + 1..n {
            sum -= l[k * n + i] * x[k];
        }
        x[i] = sum / l[i * n + i];
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_factor_is_that_found_by_hand_and_solves() {
        // [[4, 2], [2, 10]] = L L' with L = [[2, 0], [1, 3]]; the upper half is not read.
        let mut a = [4.0, f64::NAN, 2.0, 10.0];
        factor(&mut a, 2, 1e-12).unwrap();
        assert!(a.iter().zip([2.0, 0.0, 1.0, 3.0]).all(|(found, by_hand)| (found - by_hand).abs() < 1e-15), "{a:?}");
        let mut x = [8.0, 22.0];
        solve(&a, 2, &mut x);
        assert!((x[0] - 1.0).abs() < 1e-15 && (x[1] - 2.0).abs() < 1e-15, "{x:?}");
    }

    #[test]
    fn a_pivot_that_has_vanished_is_refused_by_its_place() {
        // The third column is the sum of the others.
        let sums = [2.0, 0.0, 2.0, 0.0, 3.0, 3.0, 2.0, 3.0, 5.0];
        assert_eq!(factor(&mut sums.clone(), 3, 1e-12), Err(VanishedPivot(2)));
        assert_eq!(factor(&mut [0.0], 1, 1e-12), Err(VanishedPivot(0)));
        assert_eq!(factor(&mut [1.0, 0.0, f64::NAN, 1.0], 2, 1e-12), Err(VanishedPivot(1)));
        assert_eq!(factor(&mut [f64::INFINITY], 1, 1e-12), Err(VanishedPivot(0)));
    }
}
