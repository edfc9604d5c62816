//! The small dense symmetric system of the check: normal equations by Cholesky.

/// A square matrix by rows.
#[derive(Clone, Debug, PartialEq)]
pub struct Square {
    /// Its order.
    pub order: usize,
    /// Its entries, row after row.
    pub entries: Vec<f64>,
}

impl Square {
    /// Zeros.
    pub fn zeros(order: usize) -> Self {
        Square { order, entries: vec![0.0; order * order] }
    }

    /// One entry; zero outside.
    pub fn at(&self, row: usize, column: usize) -> f64 {
        if column < self.order { self.entries.get(row * self.order + column).copied().unwrap_or(0.0) } else { 0.0 }
    }

    /// One entry.
    pub fn at_mut(&mut self, row: usize, column: usize) -> &mut f64 {
        &mut self.entries[row * self.order + column]
    }

    /// The inverse of a symmetric positive definite matrix; `None` where it is not one.
    pub fn inverse(&self) -> Option<Square> {
        let n = self.order;
        let mut l = Square::zeros(n);
        for i in 0..n {
            for j in 0..=i {
                let (head_i, head_j) = (&l.entries[i * n..i * n + j], &l.entries[j * n..j * n + j]);
                let rest = self.at(i, j) - head_i.iter().zip(head_j).map(|(a, b)| a * b).sum::<f64>();
                if i == j {
                    if !(rest > 0.0) {
                        return None;
                    }
                    *l.at_mut(i, i) = libm::sqrt(rest);
                } else {
                    *l.at_mut(i, j) = rest / l.at(j, j);
                }
            }
        }
        // Inverse of the factor, kept transposed: row j holds column j.
        let mut u = Square::zeros(n);
        for j in 0..n {
            *u.at_mut(j, j) = 1.0 / l.at(j, j);
            for i in j + 1..n {
                let sum: f64 = (j..i).map(|k| l.at(i, k) * u.at(j, k)).sum();
                *u.at_mut(j, i) = -sum / l.at(i, i);
            }
        }
        let mut inverse = Square::zeros(n);
        for i in 0..n {
            for j in i..n {
                let sum: f64 = (j..n).map(|k| u.at(i, k) * u.at(j, k)).sum();
                *inverse.at_mut(i, j) = sum;
                *inverse.at_mut(j, i) = sum;
            }
        }
        Some(inverse)
    }

    /// Times a column.
    pub fn times(&self, column: &[f64]) -> Vec<f64> {
        self.entries.chunks(self.order.max(1)).map(|row| row.iter().zip(column).map(|(a, b)| a * b).sum()).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_inverse_by_hand() {
        // [[4, 2], [2, 3]] has the inverse [[3, -2], [-2, 4]]/8.
        let inverse = Square { order: 2, entries: vec![4.0, 2.0, 2.0, 3.0] }.inverse().unwrap();
        let wanted = [0.375, -0.25, -0.25, 0.5];
        assert!(inverse.entries.iter().zip(wanted).all(|(a, b)| (a - b).abs() < 1e-15));
        assert!(inverse.times(&[8.0, 0.0]).iter().zip([3.0, -2.0]).all(|(a, b)| (a - b).abs() < 1e-14));
        assert!(Square { order: 2, entries: vec![1.0, 2.0, 2.0, 1.0] }.inverse().is_none());
    }
}
