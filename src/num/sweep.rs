//! The sweep operator: least squares on a matrix of sums of products, one variable entered or removed at a time.
//!
//! Consumes S [N x N], the symmetric matrix of sums of products of regressors and responses. After sweeping the set A
//! of regressors (Goodnight 1979),
//!     S_AA -> -(X'X)^-1,   S_Ay -> theta,   S_yy -> sum of squared residuals                       (1)
//! and for a regressor j not in A, S_jj is its sum of squares after regression on A, S_jy its product with the residual:
//! its entry would bring theta_j = S_jy/S_jj and lower the sum of squares by S_jy^2/S_jj.             (2)
//! Sweeping k twice with opposite sign undoes it.
//! Source: J. H. Goodnight, A Tutorial on the SWEEP Operator, The American Statistician 33(3), 1979.
//! Numerics: the caller scales S to unit diagonal; a pivot below `tolerance` of its original means that the regressor
//! is a combination of those in A, and is refused.

/// Sums of products under sweeping.
#[derive(Clone, Debug)]
pub struct Swept<const N: usize> {
    s: [[f64; N]; N],
    inside: [bool; N],
}

impl<const N: usize> Swept<N> {
    /// Nothing swept yet.
    pub fn new(sums: [[f64; N]; N]) -> Self {
        Swept { s: sums, inside: [false; N] }
    }

    /// Whether k has been swept in.
    pub fn is_inside(&self, k: usize) -> bool {
        self.inside[k]
    }

    /// Entry of the matrix as it stands, see (1) and (2).
    pub fn at(&self, i: usize, j: usize) -> f64 {
        self.s[i][j]
    }

    /// Brings k in. Returns `false` and changes nothing where its pivot is not above `tolerance` or k is already in.
    #[must_use]
    pub fn enter(&mut self, k: usize, tolerance: f64) -> bool {
        if self.inside[k] || !(self.s[k][k] > tolerance) {
            return false;
        }
        self.pivot(k, 1.0);
        self.inside[k] = true;
        true
    }

    /// Takes k out again. Returns `false` and changes nothing where k is not in.
    #[must_use]
    pub fn remove(&mut self, k: usize) -> bool {
        if !self.inside[k] || !(self.s[k][k] < 0.0) {
            return false;
        }
        self.pivot(k, -1.0);
        self.inside[k] = false;
        true
    }

    fn pivot(&mut self, k: usize, sign: f64) {
        pivot(self.s.as_flattened_mut(), N, k, sign);
    }
}

/// Sweeps k of the matrix of that order, row after row: in with `sign` 1, out with -1. For sums whose number is known only at
/// run time; the caller sees to it that the pivot is fit and what is in.
#[inline(always)]
pub fn pivot(s: &mut [f64], order: usize, k: usize, sign: f64) {
    let pivot = s[k * order + k];
    for i in 0..order {
        if i == k {
            continue;
        }
        let factor = s[k * order + i] / pivot;
        for j in 0..order {
            if j != k {
                s[i * order + j] -= factor * s[k * order + j];
            }
        }
    }
    for i in 0..order {
        if i != k {
            s[k * order + i] = sign * s[k * order + i] / pivot;
            s[i * order + k] = s[k * order + i];
        }
    }
    s[k * order + k] = -1.0 / pivot;
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::{DMatrix, DVector};

    fn data() -> DMatrix<f64> {
        // Four regressors and two responses, 40 rows, nothing special about them.
        DMatrix::from_fn(40, 6, |i, j| libm::sin(0.37 * (i * (j + 1)) as f64 + j as f64) + 0.1 * libm::cos((i + 3 * j) as f64))
    }

    fn sums(z: &DMatrix<f64>) -> [[f64; 6]; 6] {
        let s = z.transpose() * z;
        core::array::from_fn(|i| core::array::from_fn(|j| s[(i, j)]))
    }

    #[test]
    fn a_swept_set_gives_the_least_squares_of_a_qr_factorisation() {
        let z = data();
        let mut swept = Swept::new(sums(&z));
        for k in [2, 0, 3] {
            assert!(swept.enter(k, 1e-12));
        }
        let x = z.select_columns(&[0, 2, 3]);
        for response in [4, 5] {
            let y: DVector<f64> = z.column(response).into();
            let theta = x.clone().svd(true, true).solve(&y, 1e-14).unwrap();
            let residual = &y - &x * &theta;
            for (place, k) in [0, 2, 3].into_iter().enumerate() {
                assert!((swept.at(k, response) - theta[place]).abs() < 1e-11);
            }
            assert!((swept.at(response, response) - residual.norm_squared()).abs() < 1e-10);
            // What regressor 1 would bring.
            let drop = swept.at(1, response) * swept.at(1, response) / swept.at(1, 1);
            let wider = z.columns(0, 4).into_owned();
            let theta = wider.clone().svd(true, true).solve(&y, 1e-14).unwrap();
            let smaller = (&y - &wider * &theta).norm_squared();
            assert!((residual.norm_squared() - drop - smaller).abs() < 1e-10);
        }
        let inverse = (x.transpose() * &x).try_inverse().unwrap();
        assert!((swept.at(2, 3) + inverse[(1, 2)]).abs() < 1e-11);
    }

    #[test]
    fn removal_undoes_entry() {
        let original = sums(&data());
        let mut swept = Swept::new(original);
        for k in [1, 3, 0] {
            assert!(swept.enter(k, 1e-12));
        }
        assert!(!swept.enter(3, 1e-12));
        for k in [3, 1, 0] {
            assert!(swept.remove(k));
        }
        assert!(!swept.remove(0));
        for (i, row) in original.iter().enumerate() {
            for (j, entry) in row.iter().enumerate() {
                assert!((swept.at(i, j) - entry).abs() < 1e-10);
            }
        }
    }

    #[test]
    fn a_regressor_that_is_a_combination_of_others_is_refused() {
        let mut z = data();
        let copy = z.column(0) * 2.0 - z.column(1);
        z.set_column(2, &copy);
        let mut swept = Swept::new(sums(&z));
        assert!(swept.enter(0, 1e-8) && swept.enter(1, 1e-8));
        assert!(!swept.enter(2, 1e-8));
    }
}
