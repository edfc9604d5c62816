//! Dispersion, standard errors and determinant of an information matrix.
//!
//! Consumes the information matrix F; produces D = F^-1, whose diagonal holds the Cramer-Rao bounds of the variances. F is scaled
//! to a unit diagonal and factored by Cholesky; a pivot below 1e-10 means that a derivative is collinear with the others and the
//! biases to five digits: it is named, and nothing is inverted.
//!
//! Of n derivatives of interest among others that have to be estimated with them the information is
//!     F_nn - F_no F_oo^-1 F_on                                                             (1)
//! whose inverse is their block of F^-1. Others that nothing moves, or that only imitate one another, take nothing away and
//! are passed over.

use super::information::{DesignParameter, InputInformation};
use crate::num::cholesky::VanishedPivot;
use crate::num::dense::Dense;

/// Why there is no dispersion.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct InformationError(
    /// The first derivative that the others and the biases imitate, or that nothing moves.
    pub DesignParameter,
);

/// Pivots of a matrix with unit diagonal below this are none.
const SINGULAR: f64 = 1e-10;

impl InputInformation {
    /// About these derivatives alone, the others estimated besides; (1).
    ///
    /// # Errors
    /// [`InformationError`] with the first of them that the others and the biases imitate, that nothing moves, or that is not
    /// here.
    pub fn about(&self, wanted: &[DesignParameter]) -> Result<Self, InformationError> {
        let place =
            |wanted: &DesignParameter| self.parameters.iter().position(|here| here == wanted).ok_or(InformationError(*wanted));
        let places = wanted.iter().map(place).collect::<Result<Vec<usize>, InformationError>>()?;
        let mut f = self.fisher.clone();
        let full: Vec<f64> = (0..f.len()).map(|i| f[i][i]).collect();
        // One other after the other is eliminated.
        for k in (0..f.len()).filter(|k| !places.contains(k)) {
            let pivot = f[k][k];
            if !(pivot > SINGULAR * full[k]) {
                continue;
            }
            let row = f[k].clone();
            for entries in &mut f {
                let share = entries[k] / pivot;
                entries.iter_mut().zip(&row).for_each(|(entry, of_other)| *entry -= share * of_other);
            }
        }
        if let Some((_, lost)) = places.iter().zip(wanted).find(|(place, _)| !(f[**place][**place] > SINGULAR * full[**place])) {
            return Err(InformationError(*lost));
        }
        let fisher = places.iter().map(|&i| places.iter().map(|&j| 0.5 * (f[i][j] + f[j][i])).collect()).collect();
        Ok(InputInformation { parameters: wanted.to_vec(), fisher, excursion: self.excursion })
    }

    /// With another manoeuvre's, of the same derivatives, each with biases of its own.
    #[must_use]
    pub fn plus(mut self, other: &InputInformation) -> Self {
        for (row, others) in self.fisher.iter_mut().zip(&other.fisher) {
            row.iter_mut().zip(others).for_each(|(entry, other)| *entry += other);
        }
        self.excursion.iter_mut().zip(other.excursion).for_each(|(most, other)| *most = most.max(other));
        self
    }

    /// D; (4).
    ///
    /// # Errors
    /// [`InformationError`] where F is singular.
    pub fn dispersion(&self) -> Result<Vec<Vec<f64>>, InformationError> {
        let (lower, scale) = (self.cholesky()?, self.scales());
        let n = scale.len();
        let scaled = lower.solve_factored(&Dense::from_fn(n, n, |i, j| f64::from(u8::from(i == j))));
        let entry = |i: usize, j: usize| 0.5 * (scaled[(i, j)] + scaled[(j, i)]) / (scale[i] * scale[j]);
        Ok((0..n).map(|i| (0..n).map(|j| entry(i, j)).collect()).collect())
    }

    /// Standard errors to be expected at best, in the order of the derivatives.
    ///
    /// # Errors
    /// [`InformationError`] where F is singular.
    pub fn standard_errors(&self) -> Result<Vec<f64>, InformationError> {
        let dispersion = self.dispersion()?;
        Ok(dispersion.iter().enumerate().filter_map(|(i, row)| row.get(i)).map(|&variance| libm::sqrt(variance)).collect())
    }

    /// Logarithm of the determinant of D.
    ///
    /// # Errors
    /// [`InformationError`] where F is singular.
    pub fn log_determinant(&self) -> Result<f64, InformationError> {
        let lower = self.cholesky()?;
        let scaled: f64 = lower.diagonal().into_iter().map(|pivot| -2.0 * libm::log(pivot)).sum();
        Ok(scaled - self.scales().iter().map(|&scale| 2.0 * libm::log(scale)).sum::<f64>())
    }

    /// Square roots of the diagonal.
    fn scales(&self) -> Vec<f64> {
        let diagonal = self.fisher.iter().enumerate().filter_map(|(i, row)| row.get(i));
        diagonal.map(|&entry| if entry > 0.0 { libm::sqrt(entry) } else { 1.0 }).collect()
    }

    /// Lower factor of F scaled to a unit diagonal.
    fn cholesky(&self) -> Result<Dense, InformationError> {
        let scale = self.scales();
        let scaled = Dense::from_fn(scale.len(), scale.len(), |i, j| self.fisher[i][j] / (scale[i] * scale[j]));
        scaled.cholesky_above(SINGULAR).map_err(|VanishedPivot(row)| InformationError(self.parameters[row]))
    }
}

#[cfg(test)]
mod tests {
    use super::super::information::outputs;
    use super::super::information::tests::{LATERAL, manoeuvre, puma};
    use super::*;
    use crate::flight::derivative::{Axis, Variable};
    use crate::simulation::instrument::InstrumentSet;

    #[test]
    #[expect(clippy::needless_range_loop, reason = "indices are those of the matrix")]
    fn dispersion_is_the_inverse_and_information_adds() {
        let model = puma();
        let parameters = LATERAL.map(|(axis, variable)| DesignParameter { axis, variable });
        let outputs = outputs(&model, &InstrumentSet::flight_quality(1.0));
        let one = InputInformation::of(
            &model,
            &parameters,
            &outputs,
            &manoeuvre(&["pedal:3211:0.02:0.7", "lat_cyclic:3211:0.01:0.5:6"]),
        );
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
    fn of_some_among_others_it_is_their_block_of_the_whole_inverse() {
        let model = puma();
        let parameters = LATERAL.map(|(axis, variable)| DesignParameter { axis, variable });
        let outputs = outputs(&model, &InstrumentSet::flight_quality(1.0));
        let flown = manoeuvre(&["pedal:3211:0.02:0.7", "lat_cyclic:3211:0.01:0.5:6"]);
        let whole = InputInformation::of(&model, &parameters, &outputs, &flown);
        let all = whole.dispersion().unwrap();
        let wanted = [parameters[2], parameters[0], parameters[3]];
        let some = whole.about(&wanted).unwrap().dispersion().unwrap();
        for (i, of_i) in [2, 0, 3].into_iter().enumerate() {
            for (j, of_j) in [2, 0, 3].into_iter().enumerate() {
                let scale = (all[of_i][of_i] * all[of_j][of_j]).sqrt();
                assert!((some[i][j] - all[of_i][of_j]).abs() < 1e-9 * scale, "{i} {j}: {} {}", some[i][j], all[of_i][of_j]);
            }
        }
        // Known, the others take nothing away: the bound is no larger.
        let alone = InputInformation::of(&model, &wanted, &outputs, &flown).standard_errors().unwrap();
        assert!(alone.iter().enumerate().all(|(i, std)| *std < some[i][i].sqrt()), "{alone:?} {some:?}");
        assert_eq!(whole.about(&parameters).unwrap().fisher.len(), 7);
    }

    #[test]
    fn others_that_nothing_moves_or_that_imitate_one_another_are_passed_over() {
        let model = puma();
        let named = [(Axis::N, Variable::V), (Axis::N, Variable::R), (Axis::N, Variable::Pedal)];
        let named = named.map(|(axis, variable)| DesignParameter { axis, variable });
        let outputs = outputs(&model, &InstrumentSet::flight_quality(1.0));
        let flown = manoeuvre(&["pedal:3211:0.02:0.7"]);
        let known = InputInformation::of(&model, &named, &outputs, &flown).standard_errors().unwrap();
        // Nothing moves the stick; the pedal's effect twice over is the same column twice.
        let still = DesignParameter { axis: Axis::N, variable: Variable::LonCyclic };
        let with_still = InputInformation::of(&model, &[&[still][..], &named].concat(), &outputs, &flown);
        assert_eq!(with_still.about(&named).unwrap().standard_errors().unwrap(), known);
        let others =
            [(Axis::L, Variable::Pedal), (Axis::L, Variable::Pedal)].map(|(axis, variable)| DesignParameter { axis, variable });
        let once = InputInformation::of(&model, &[&others[..1], &named].concat(), &outputs, &flown);
        let twice = InputInformation::of(&model, &[&others[..], &named].concat(), &outputs, &flown);
        let (once, twice) = (once.about(&named).unwrap(), twice.about(&named).unwrap());
        for (one, other) in once.standard_errors().unwrap().iter().zip(twice.standard_errors().unwrap()) {
            assert!((one / other - 1.0).abs() < 1e-9);
        }
        // One that another imitates is named, and so is one that is not here.
        let doubled = InputInformation::of(&model, &[named[2], named[2], named[0]], &outputs, &flown);
        assert_eq!(doubled.about(&[named[0], named[2]]), Err(InformationError(named[2])));
        assert_eq!(with_still.about(&[still]), Err(InformationError(still)));
        assert_eq!(once.about(&others[..1]), Err(InformationError(others[0])));
    }

    #[test]
    fn what_nothing_moves_is_named() {
        let model = puma();
        let parameters = LATERAL.map(|(axis, variable)| DesignParameter { axis, variable });
        let outputs = outputs(&model, &InstrumentSet::flight_quality(1.0));
        let pedal_only = InputInformation::of(&model, &parameters, &outputs, &manoeuvre(&["pedal:3211:0.02:0.7"]));
        assert_eq!(pedal_only.dispersion(), Err(InformationError(parameters[6])));
    }
}
