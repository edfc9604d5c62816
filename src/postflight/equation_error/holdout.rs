//! An equation on a record that was not fitted.
//!
//! Consumes a fitted equation and a table of hold-out records; produces for each the error of the response y by its own measured
//! terms x_i, about the record's own trim, the mean over its first seconds (nothing is fitted):
//!     e(t) = (y - y_trim) - sum of theta_i (x_i - x_i,trim)                                            (1)
//!     R2 = 1 - sum e^2 / sum (y - y_mean)^2                                                            (2)
//!     TIC = rms(e) / (rms(y - y_trim) + rms(y - y_trim - e))                                           (3)
//! (2) is negative where the mean of the record predicts better. Rows with a value that is not finite are not used.
//! Source of (3): H. Theil, Economic Forecasts and Policy, 1961. Returns `None` where the trim or the rest has no row.

use super::design::Design;
use super::expression::{Expression, UnknownColumn};
use super::fit::EquationFit;
use super::table::RegressionTable;
use crate::postflight::validation::metrics::PredictionMoments;

/// How well an equation predicts the response in one record.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EquationPrediction {
    /// Rows that were compared.
    pub samples: usize,
    /// (2).
    pub r_squared: f64,
    /// Root mean square of (1), in the response's unit.
    pub rms: f64,
    /// Root mean square of the response about its trim, in its unit.
    pub response_rms: f64,
    /// (3): 0 perfect, 1 no relation.
    pub theil: f64,
}

/// The equation on every record of a table; trims are means over so many seconds at the beginning of each.
///
/// # Errors
/// [`UnknownColumn`] where a column of the equation is not in the table.
pub fn predict(
    design: &Design,
    fit: &EquationFit,
    response: &Expression,
    table: &RegressionTable,
    trim_window_s: f64,
) -> Result<Vec<Option<EquationPrediction>>, UnknownColumn> {
    if table.records() == 0 {
        return Ok(Vec::new());
    }
    let values = |term: &Expression| {
        let found = term.values(table.rows(), |name| table.column(name));
        found.map_err(|column| UnknownColumn { term: Some(term.to_string()), column, columns: table.names().to_vec() })
    };
    let measured = values(response)?;
    let mut explained = vec![0.0; table.rows()];
    for term in &fit.terms {
        let Some(candidate) = design.candidates.get(term.place) else { continue };
        explained.iter_mut().zip(values(&candidate.term)?).for_each(|(sum, x)| *sum += term.value * x);
    }
    let of_record = |record: usize| {
        let rows: Vec<(f64, f64, f64)> = table
            .rows_of(record)
            .filter_map(|row| Some((*table.time_s().get(row)?, *measured.get(row)?, *explained.get(row)?)))
            .filter(|(_, y, x)| y.is_finite() && x.is_finite())
            .collect();
        let end_s = rows.first()?.0 + trim_window_s;
        let trim: Vec<&(f64, f64, f64)> = rows.iter().take_while(|(time_s, ..)| *time_s <= end_s).collect();
        let count = trim.len() as f64;
        let y_trim = trim.iter().map(|(_, y, _)| y).sum::<f64>() / count;
        let x_trim = trim.iter().map(|(.., x)| x).sum::<f64>() / count;
        let moments = PredictionMoments::of(rows.iter().map(|(_, y, x)| (y - y_trim, x - x_trim)));
        (rows.len() > trim.len()).then(|| EquationPrediction {
            samples: rows.len(),
            r_squared: 1.0 - moments.error_square / moments.measured_variance,
            rms: moments.rms(),
            response_rms: libm::sqrt(moments.measured_square),
            theil: moments.theil(),
        })
    };
    Ok((0..table.records()).map(of_record).collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::postflight::equation_error::design::{Bias, CandidateTerm};
    use crate::postflight::equation_error::stepwise::{StepwiseRules, select};

    fn record(table: &mut RegressionTable, x: &[f64], y: impl Fn(f64) -> f64) {
        let times_s: Vec<f64> = (0..x.len()).map(|place| 0.5 * place as f64).collect();
        let y: Vec<f64> = x.iter().map(|x| y(*x)).collect();
        table.add_record(&times_s, &[("a", x), ("y", &y)]).unwrap();
    }

    #[test]
    fn the_error_is_about_the_records_own_trim_as_by_hand() {
        let mut fitted = RegressionTable::new();
        let x: Vec<f64> = (0..200).map(|place| libm::sin(0.3 * f64::from(place))).collect();
        record(&mut fitted, &x, |x| 2.0 * x + 5.0);
        let (response, candidates) = (Expression::parse("y").unwrap(), [CandidateTerm::offered("a").unwrap()]);
        let design = Design::new(&fitted, &response, &candidates, &fitted.whole(), Bias::EachRecord).unwrap();
        let fit = select(&design, &StepwiseRules::for_candidates(1)).unwrap().fit;
        assert!((fit.terms[0].value - 2.0).abs() < 1e-9);
        let mut holdout = RegressionTable::new();
        // Another trim, and a slope of 3: y - y_trim = 0 0 3 -3, predicted 0 0 2 -2, error 0 0 1 -1.
        record(&mut holdout, &[1.0, 1.0, 2.0, 0.0], |x| 3.0 * x - 7.0);
        let found = predict(&design, &fit, &response, &holdout, 0.5).unwrap()[0].unwrap();
        let known = [1.0 - 2.0 / 18.0, libm::sqrt(0.5), libm::sqrt(4.5), libm::sqrt(0.5) / (libm::sqrt(4.5) + libm::sqrt(2.0))];
        let numbers = [found.r_squared, found.rms, found.response_rms, found.theil];
        assert!(numbers.iter().zip(known).all(|(found, known)| (found - known).abs() < 1e-9), "{found:?}");
        assert_eq!(found.samples, 4);
        assert_eq!(predict(&design, &fit, &response, &holdout, 5.0).unwrap(), [None]);
    }
}
