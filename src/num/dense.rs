//! A small dense matrix of any size: Cholesky factors, inverses and eigenvalues of symmetric ones.
//!
//! Numerics: `cholesky` refuses a pivot below [`PIVOT`] of its own diagonal entry (`num::cholesky`).

use crate::num::cholesky::{self, VanishedPivot};
use crate::num::symmetric::diagonalise;
use core::ops::{Index, IndexMut};

/// Smallest pivot that counts, over the diagonal entry that it came from.
pub const PIVOT: f64 = 1e-13;

/// Row by row.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Dense {
    rows: usize,
    columns: usize,
    data: Vec<f64>,
}

impl Index<(usize, usize)> for Dense {
    type Output = f64;
    fn index(&self, (i, j): (usize, usize)) -> &f64 {
        &self.data[i * self.columns + j]
    }
}

impl IndexMut<(usize, usize)> for Dense {
    fn index_mut(&mut self, (i, j): (usize, usize)) -> &mut f64 {
        &mut self.data[i * self.columns + j]
    }
}

impl Dense {
    /// Zeros.
    pub fn zeros(rows: usize, columns: usize) -> Self {
        Dense { rows, columns, data: vec![0.0; rows * columns] }
    }

    /// Each entry by its row and column.
    pub fn from_fn(rows: usize, columns: usize, mut entry: impl FnMut(usize, usize) -> f64) -> Self {
        let mut out = Dense::zeros(rows, columns);
        for i in 0..rows {
            for j in 0..columns {
                out[(i, j)] = entry(i, j);
            }
        }
        out
    }

    /// Rows.
    pub fn rows(&self) -> usize {
        self.rows
    }

    /// Columns.
    pub fn columns(&self) -> usize {
        self.columns
    }

    /// One row.
    pub fn row(&self, i: usize) -> &[f64] {
        &self.data[i * self.columns..(i + 1) * self.columns]
    }

    /// The diagonal.
    pub fn diagonal(&self) -> Vec<f64> {
        (0..self.rows.min(self.columns)).map(|i| self[(i, i)]).collect()
    }

    /// The product.
    pub fn times(&self, other: &Dense) -> Dense {
        let mut out = Dense::zeros(self.rows, other.columns);
        for i in 0..self.rows {
            for l in 0..self.columns.min(other.rows) {
                let factor = self[(i, l)];
                if factor != 0.0 {
                    for j in 0..other.columns {
                        out[(i, j)] += factor * other[(l, j)];
                    }
                }
            }
        }
        out
    }

    /// The transpose.
    pub fn transposed(&self) -> Dense {
        Dense::from_fn(self.columns, self.rows, |i, j| self[(j, i)])
    }

    /// The part between these rows and columns.
    pub fn part(&self, rows: core::ops::Range<usize>, columns: core::ops::Range<usize>) -> Dense {
        Dense::from_fn(rows.len(), columns.len(), |i, j| self[(rows.start + i, columns.start + j)])
    }

    /// Lower factor L with L L' = the matrix; none where it is not positive definite to working precision.
    pub fn cholesky(&self) -> Option<Dense> {
        self.cholesky_above(PIVOT).ok()
    }

    /// The same with another least pivot, over the diagonal entry that it comes from.
    ///
    /// # Errors
    /// The first row whose pivot is not above it.
    pub(crate) fn cholesky_above(&self, least_part: f64) -> Result<Dense, VanishedPivot> {
        let mut l = self.clone();
        cholesky::factor(&mut l.data, self.rows, least_part)?;
        Ok(l)
    }

    /// Solves L L' X = `right` for a lower factor L.
    pub fn solve_factored(&self, right: &Dense) -> Dense {
        let mut columns = right.transposed();
        for column in columns.data.chunks_exact_mut(self.rows.max(1)) {
            cholesky::solve(&self.data, self.rows, column);
        }
        columns.transposed()
    }

    /// Inverse of a positive definite matrix, symmetric to the bit.
    pub fn inverse(&self) -> Option<Dense> {
        let identity = Dense::from_fn(self.rows, self.rows, |i, j| f64::from(u8::from(i == j)));
        let x = self.cholesky()?.solve_factored(&identity);
        Some(Dense::from_fn(self.rows, self.rows, |i, j| 0.5 * (x[(i, j)] + x[(j, i)])))
    }

    /// Eigenvalues of a symmetric matrix, ascending, and the vectors as columns; entries that are no numbers stay so.
    pub fn symmetric_eigen(&self) -> (Vec<f64>, Dense) {
        let n = self.rows;
        let (mut a, mut v) = (self.clone(), Dense::zeros(n, n));
        if !diagonalise(&mut a.data, &mut v.data, n) {
            return (vec![f64::NAN; n], Dense::from_fn(n, n, |_, _| f64::NAN));
        }
        let mut order: Vec<usize> = (0..n).collect();
        order.sort_by(|&i, &j| a[(i, i)].total_cmp(&a[(j, j)]));
        let values = order.iter().map(|&i| a[(i, i)]).collect();
        (values, Dense::from_fn(n, n, |i, j| v[(i, order[j])]))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn case() -> Dense {
        let rows = [[4.0, 1.0, 0.5], [1.0, 3.0, -0.2], [0.5, -0.2, 1.0]];
        Dense::from_fn(3, 3, |i, j| rows[i][j])
    }

    #[test]
    fn inverse_times_itself_is_one_and_singular_is_refused() {
        let a = case();
        let one = a.times(&a.inverse().unwrap());
        for i in 0..3 {
            for j in 0..3 {
                assert!((one[(i, j)] - f64::from(u8::from(i == j))).abs() < 1e-14);
            }
        }
        assert!(Dense::from_fn(2, 2, |_, _| 1.0).inverse().is_none());
    }

    #[test]
    fn eigenvectors_diagonalise() {
        let a = case();
        let (values, v) = a.symmetric_eigen();
        let back = v.transposed().times(&a).times(&v);
        assert!(values.is_sorted());
        for i in 0..3 {
            for j in 0..3 {
                let expected = if i == j { values[i] } else { 0.0 };
                assert!((back[(i, j)] - expected).abs() < 1e-12, "{i} {j}");
            }
        }
    }
}
