//! Symmetric positive definite band matrices: Cholesky factors, solutions, and the inverse within the band.
//!
//! Consumes A [n x n] of half width w (A_ij = 0 for |i - j| > w), of which the lower half is stored; produces
//!     L L' = A,   A x = y,   Z = A^-1 for |i - j| <= w
//! in O(n w^2), the last by the recursion of Takahashi, from the last column back:
//!     Z_ij = delta_ij/L_jj^2 - sum_(k = j + 1 .. j + w) (L_kj/L_jj) Z_ik                              (1)
//! Refused: a pivot that is not above [`LEAST_PIVOT`] of its own diagonal entry, by its place.
//! Source: K. Takahashi, J. Fagan, M. Chin, 8th PICA Conference, 1973.

use super::cholesky::VanishedPivot;

/// Smallest pivot that counts, over the diagonal entry that it came from.
const LEAST_PIVOT: f64 = 1e-13;

/// The lower half of a band matrix, or its factor L: row i holds the columns i - w to i.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct BandMatrix {
    half_width: usize,
    data: Vec<f64>,
}

impl BandMatrix {
    /// Zeros.
    pub(crate) fn zeros(order: usize, half_width: usize) -> Self {
        BandMatrix { half_width, data: vec![0.0; order * (half_width + 1)] }
    }

    /// n.
    pub(crate) fn order(&self) -> usize {
        self.data.len() / (self.half_width + 1)
    }

    fn place(&self, i: usize, j: usize) -> usize {
        i * (self.half_width + 1) + self.half_width + j - i
    }

    /// Entry (i, j) of the lower half within the band: j <= i <= j + w.
    pub(crate) fn at(&self, i: usize, j: usize) -> f64 {
        self.data[self.place(i, j)]
    }

    /// Adds to the entry (i, j) of the lower half within the band.
    pub(crate) fn add(&mut self, i: usize, j: usize, value: f64) {
        let place = self.place(i, j);
        self.data[place] += value;
    }

    /// L.
    ///
    /// # Errors
    /// The first [`VanishedPivot`].
    pub(crate) fn factored(mut self) -> Result<BandFactor, VanishedPivot> {
        let w = self.half_width;
        for i in 0..self.order() {
            let whole = self.at(i, i);
            for j in i.saturating_sub(w)..=i {
                let mut sum = self.at(i, j);
                // j <= i, so that every column of row i's band is in row j's.
                for k in i.saturating_sub(w)..j {
                    sum -= self.at(i, k) * self.at(j, k);
                }
                let place = self.place(i, j);
                if i == j {
                    if !(sum > LEAST_PIVOT * whole) || !sum.is_finite() {
                        return Err(VanishedPivot(i));
                    }
                    self.data[place] = libm::sqrt(sum);
                } else {
                    self.data[place] = sum / self.at(j, j);
                }
            }
        }
        Ok(BandFactor(self))
    }
}

/// L of a band matrix.
#[derive(Clone, Debug)]
pub(crate) struct BandFactor(BandMatrix);

impl BandFactor {
    /// Solves A x = y; `x` holds y before.
    pub(crate) fn solve(&self, x: &mut [f64]) {
        let (l, w, n) = (&self.0, self.0.half_width, self.0.order());
        for i in 0..n {
            let mut sum = x[i];
            let first = i.saturating_sub(w);
            for (k, known) in x[first..i].iter().enumerate() {
                sum -= l.at(i, first + k) * known;
            }
            x[i] = sum / l.at(i, i);
        }
        for i in (0..n).rev() {
            let mut sum = x[i];
            for (k, known) in x[i + 1..(i + w + 1).min(n)].iter().enumerate() {
                sum -= l.at(i + 1 + k, i) * known;
            }
            x[i] = sum / l.at(i, i);
        }
    }

    /// Z of (1).
    pub(crate) fn inverse_band(&self) -> BandMatrix {
        let (l, w, n) = (&self.0, self.0.half_width, self.0.order());
        let mut z = BandMatrix::zeros(n, w);
        for j in (0..n).rev() {
            let pivot = l.at(j, j);
            for i in (j..(j + w + 1).min(n)).rev() {
                let mut sum = if i == j { 1.0 / (pivot * pivot) } else { 0.0 };
                for k in j + 1..(j + w + 1).min(n) {
                    sum -= l.at(k, j) / pivot * z.at(i.max(k), i.min(k));
                }
                z.add(i, j, sum);
            }
        }
        z
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::num::dense::Dense;

    #[test]
    fn solution_and_inverse_are_those_of_the_dense_matrix() {
        let (n, w) = (9, 3);
        let mut band = BandMatrix::zeros(n, w);
        for i in 0..n {
            for j in i.saturating_sub(w)..=i {
                band.add(i, j, if i == j { 4.0 + 0.3 * i as f64 } else { 1.0 / (1.0 + (i + 2 * j) as f64) });
            }
        }
        let dense = Dense::from_fn(n, n, |i, j| if i.abs_diff(j) <= w { band.at(i.max(j), i.min(j)) } else { 0.0 });
        let inverse = dense.inverse().unwrap();
        let factor = band.factored().unwrap();
        let z = factor.inverse_band();
        for i in 0..n {
            for j in i.saturating_sub(w)..=i {
                assert!((z.at(i, j) - inverse[(i, j)]).abs() < 1e-14, "{i} {j}");
            }
            let mut column: Vec<f64> = (0..n).map(|k| f64::from(u8::from(k == i))).collect();
            factor.solve(&mut column);
            assert!(column.iter().enumerate().all(|(k, x)| (x - inverse[(k, i)]).abs() < 1e-14));
        }
        assert_eq!(BandMatrix::zeros(2, 1).factored().unwrap_err(), VanishedPivot(0));
    }
}
