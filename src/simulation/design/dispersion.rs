//! What information is worth: dispersion, standard errors, the determinant.
//!
//! Consumes the information matrix F; produces D = F^-1, whose diagonal holds the Cramer-Rao bounds of the variances. F is scaled
//! to a unit diagonal and factored by Cholesky; a pivot below 1e-10 means that a derivative is imitated by the others and the
//! biases to five digits, and it is named instead of inverted.

#![expect(clippy::needless_range_loop, reason = "indices are those of the matrix")]

use super::information::{Information, Parameter};

/// Why there is no dispersion.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Uninformed(
    /// The first derivative that the others and the biases imitate, or that nothing moves.
    pub Parameter,
);

impl Information {
    /// With another manoeuvre's, of the same derivatives, each with biases of its own.
    #[must_use]
    pub fn plus(mut self, other: &Information) -> Self {
        for (row, others) in self.fisher.iter_mut().zip(&other.fisher) {
            row.iter_mut().zip(others).for_each(|(entry, other)| *entry += other);
        }
        self.excursion.iter_mut().zip(other.excursion).for_each(|(most, other)| *most = most.max(other));
        self
    }

    /// D; (4).
    ///
    /// # Errors
    /// [`Uninformed`] where F is singular.
    pub fn dispersion(&self) -> Result<Vec<Vec<f64>>, Uninformed> {
        let lower = self.cholesky()?;
        let n = lower.len();
        // Columns of the inverse of the factor, and D = L^-T L^-1.
        let mut inverse = vec![vec![0.0; n]; n];
        for column in 0..n {
            for row in column..n {
                let seen: f64 = (column..row).map(|k| lower[row][k] * inverse[k][column]).sum();
                let unit = f64::from(u8::from(row == column));
                inverse[row][column] = (unit - seen) / lower[row][row];
            }
        }
        let entry = |i: usize, j: usize| (i.max(j)..n).map(|k| inverse[k][i] * inverse[k][j]).sum();
        let scale = self.scales();
        Ok((0..n)
            .map(|i| {
                (0..n)
                    .map(|j| {
                        let d: f64 = entry(i, j);
                        d / (scale[i] * scale[j])
                    })
                    .collect()
            })
            .collect())
    }

    /// Standard errors to be expected at best, in the order of the derivatives.
    ///
    /// # Errors
    /// [`Uninformed`] where F is singular.
    pub fn standard_errors(&self) -> Result<Vec<f64>, Uninformed> {
        let dispersion = self.dispersion()?;
        Ok(dispersion.iter().enumerate().filter_map(|(i, row)| row.get(i)).map(|&variance| libm::sqrt(variance)).collect())
    }

    /// Logarithm of the determinant of D.
    ///
    /// # Errors
    /// [`Uninformed`] where F is singular.
    pub fn log_determinant(&self) -> Result<f64, Uninformed> {
        let lower = self.cholesky()?;
        let scaled: f64 = lower.iter().enumerate().filter_map(|(i, row)| row.get(i)).map(|&pivot| -2.0 * libm::log(pivot)).sum();
        Ok(scaled - self.scales().iter().map(|&scale| 2.0 * libm::log(scale)).sum::<f64>())
    }

    /// Square roots of the diagonal.
    fn scales(&self) -> Vec<f64> {
        let diagonal = self.fisher.iter().enumerate().filter_map(|(i, row)| row.get(i));
        diagonal.map(|&entry| if entry > 0.0 { libm::sqrt(entry) } else { 1.0 }).collect()
    }

    /// Lower factor of F scaled to a unit diagonal.
    fn cholesky(&self) -> Result<Vec<Vec<f64>>, Uninformed> {
        const SINGULAR: f64 = 1e-10;
        let (n, scale) = (self.parameters.len(), self.scales());
        let mut lower = vec![vec![0.0; n]; n];
        for i in 0..n {
            for j in 0..=i {
                let seen: f64 = (0..j).map(|k| lower[i][k] * lower[j][k]).sum();
                let rest = self.fisher[i][j] / (scale[i] * scale[j]) - seen;
                lower[i][j] = if i == j {
                    if !(rest > SINGULAR) {
                        return Err(Uninformed(self.parameters[i]));
                    }
                    libm::sqrt(rest)
                } else {
                    rest / lower[j][j]
                };
            }
        }
        Ok(lower)
    }
}

#[cfg(test)]
mod tests {
    use super::super::information::outputs;
    use super::super::information::tests::{LATERAL, manoeuvre, puma};
    use super::*;
    use crate::simulation::instrument::Instruments;

    #[test]
    fn dispersion_is_the_inverse_and_information_adds() {
        let model = puma();
        let parameters = LATERAL.map(|(axis, variable)| Parameter { axis, variable });
        let outputs = outputs(&model, &Instruments::flight_quality(1.0));
        let one =
            Information::of(&model, &parameters, &outputs, &manoeuvre(&["pedal:3211:0.02:0.7", "lat_cyclic:3211:0.01:0.5:6"]));
        let dispersion = one.dispersion().unwrap();
        for i in 0..7 {
            for j in 0..7 {
                let product: f64 = (0..7).map(|k| one.fisher[i][k] * dispersion[k][j]).sum();
                let scale = (one.fisher[i][i] / one.fisher[j][j]).sqrt();
                assert!((product - f64::from(u8::from(i == j))).abs() < 1e-8 * scale.max(1.0), "{i} {j} {product}");
            }
        }
        let twice = one.clone().plus(&one);
        let (once, twice_std) = (one.standard_errors().unwrap(), twice.standard_errors().unwrap());
        assert!(once.iter().zip(&twice_std).all(|(once, twice)| (once / twice - 2f64.sqrt()).abs() < 1e-9));
        let (single, double) = (one.log_determinant().unwrap(), twice.log_determinant().unwrap());
        assert!((single - double - 7.0 * 2f64.ln()).abs() < 1e-9);
    }

    #[test]
    fn what_nothing_moves_is_named() {
        let model = puma();
        let parameters = LATERAL.map(|(axis, variable)| Parameter { axis, variable });
        let outputs = outputs(&model, &Instruments::flight_quality(1.0));
        let pedal_only = Information::of(&model, &parameters, &outputs, &manoeuvre(&["pedal:3211:0.02:0.7"]));
        assert_eq!(pedal_only.dispersion(), Err(Uninformed(parameters[6])));
    }
}
