//! Least squares of an equation with chosen terms, its standard errors and its figures of merit.
//!
//! Consumes a [`Design`] and places of candidates; produces, for X [m x p] (biases among the p columns) and y,
//!     theta = (X'X)^-1 X'y                                                                         (1)
//!     R2 = 1 - SSE/(y'y about its mean)           about the mean                                   (2)
//!     F = R2/(p - b) (m - p)/(1 - R2)             b biases                                         (3)
//!     F_i = theta_i^2/s_i^2                       s_i for white and for coloured residuals         (4)
//!     PSE = SSE/m + var(y) p/m                    predicted squared error                          (5)
//!     PRESS = sum (v_k/(1 - h_k))^2,  h = diag X (X'X)^-1 X'                                        (6)
//! Source: (1) to (4) Padfield et al. 1987, (18) and (20) to (22), there with one bias; (5) A. R. Barron, 1984; (6) D. M. Allen,
//! Technometrics 16, 1974; coloured standard errors as in `coloured_errors`.
//! Numerics: sums about the mean, scaled to unit diagonal, by the sweep operator. Returns [`FitError`] for a term whose pivot is
//! below [`PIVOT_MIN`], a linear combination of those in, and for fewer rows than parameters.

use super::collinearity::largest_index;
use super::coloured_errors::{ErrorModel, ErrorModelOrder, FittedEquation};
use super::design::{Design, inner};
use crate::num::sweep::pivot;

/// Pivot below which a term is a linear combination of those in.
pub const PIVOT_MIN: f64 = 1e-10;

/// Relative determinant of a pair below which its terms are nearly equal.
const PAIR_MIN: f64 = 1e-6;

/// A term of a fitted equation.
#[derive(Clone, Debug, PartialEq)]
pub struct TermEstimate {
    /// Place among the candidates.
    pub place: usize,
    /// Name of the term.
    pub name: String,
    /// Estimate, unit of the response over that of the term.
    pub value: f64,
    /// Standard error for coloured residuals.
    pub std: f64,
    /// Standard error for white residuals.
    pub std_white: f64,
    /// Partial F (4) on `std`.
    pub f: f64,
    /// Partial F (4) on `std_white`: Padfield et al. 1987, (22).
    pub f_white: f64,
}

/// Figures of merit of a fit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FitQuality {
    /// Rows, m.
    pub samples: f64,
    /// Parameters, the biases among them, p.
    pub parameters: f64,
    /// Sum of squared residuals.
    pub squares: f64,
    /// (2).
    pub r_squared: f64,
    /// (3).
    pub f_total: f64,
    /// (5).
    pub pse: f64,
    /// (6).
    pub press: f64,
    /// Standard deviation of the residual.
    pub residual_std: f64,
    /// Largest condition index of the terms about their means.
    pub condition_index: f64,
}

/// A fitted equation.
#[derive(Clone, Debug, PartialEq)]
pub struct EquationFit {
    /// Name of the response.
    pub response: String,
    /// Terms in the order of entry, without the bias.
    pub terms: Vec<TermEstimate>,
    /// Biases, one or one a record.
    pub biases: Vec<f64>,
    /// Standard errors of the biases for coloured residuals.
    pub bias_stds: Vec<f64>,
    /// Covariance of the terms for coloured residuals.
    pub cov: Vec<Vec<f64>>,
    /// Covariance of the terms for white residuals.
    pub cov_white: Vec<Vec<f64>>,
    /// Figures of merit.
    pub quality: FitQuality,
    /// Autoregressive model of the equation error.
    pub error: ErrorModel,
    /// Rows of the table that were used.
    pub rows: Vec<usize>,
    /// Fitted response at each of `rows`.
    pub predicted: Vec<f64>,
    /// Response less fitted response.
    pub residuals: Vec<f64>,
}

/// Why a fit is refused.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[expect(missing_docs, reason = "the message of each says what its fields are")]
pub enum FitError {
    #[error("term \"{term}\" does not move, or is a combination of the others")]
    Dependent { term: String },
    #[error("{parameters} parameters need more than {samples} rows")]
    Rows { parameters: usize, samples: usize },
}

impl EquationFit {
    /// The fit with those candidates.
    ///
    /// # Errors
    /// [`FitError`] for a dependent term or too few rows.
    pub fn of(design: &Design, places: &[usize], colour: ErrorModelOrder) -> Result<EquationFit, FitError> {
        let mut working = Working::new(design);
        for &place in places {
            if !working.enter(place) {
                let term = design.names.get(place).cloned().unwrap_or_default();
                return Err(FitError::Dependent { term });
            }
        }
        working.fit(colour)
    }

    /// A term by its name.
    pub fn term(&self, name: &str) -> Option<&TermEstimate> {
        self.terms.iter().find(|term| term.name == name)
    }
}

#[derive(Clone, Debug)]
pub(super) struct Working<'a> {
    pub(super) design: &'a Design,
    swept: Vec<f64>,
    /// Terms in the order of entry.
    pub(super) inside: Vec<usize>,
}

impl<'a> Working<'a> {
    pub(super) fn new(design: &'a Design) -> Self {
        Working { design, swept: design.sums.clone(), inside: Vec::new() }
    }

    fn at(&self, i: usize, j: usize) -> f64 {
        self.swept[i * self.design.order() + j]
    }

    /// Whether the candidate is neither in nor a linear combination of those in.
    pub(super) fn can_enter(&self, place: usize) -> bool {
        place < self.design.names.len() && !self.inside.contains(&place) && self.at(place, place) > PIVOT_MIN
    }

    pub(super) fn enter(&mut self, place: usize) -> bool {
        let may = self.can_enter(place);
        if may {
            let order = self.design.order();
            pivot(&mut self.swept, order, place, 1.0);
            self.inside.push(place);
        }
        may
    }

    pub(super) fn leave(&mut self, place: usize) {
        if self.inside.contains(&place) {
            let order = self.design.order();
            pivot(&mut self.swept, order, place, -1.0);
            self.inside.retain(|&other| other != place);
        }
    }

    /// 1 - R2.
    pub(super) fn unexplained(&self) -> f64 {
        let y = self.design.names.len();
        self.at(y, y)
    }

    /// Increase of R2 by the candidate.
    pub(super) fn gain(&self, place: usize) -> f64 {
        let product = self.at(place, self.design.names.len());
        product * product / self.at(place, place)
    }

    /// Increase of R2 by two candidates together; zero where they are nearly equal.
    pub(super) fn gain_of_pair(&self, first: usize, second: usize) -> f64 {
        let y = self.design.names.len();
        let (own, other, both) = (self.at(first, first), self.at(second, second), self.at(first, second));
        let area = own * other - both * both;
        if !(area > PAIR_MIN * own * other) {
            return 0.0;
        }
        let (a, b) = (self.at(first, y), self.at(second, y));
        (a * a * other - 2.0 * a * b * both + b * b * own) / area
    }

    /// Decrease of R2 without that term.
    pub(super) fn loss(&self, place: usize) -> f64 {
        let product = self.at(place, self.design.names.len());
        -product * product / self.at(place, place)
    }

    /// R2 of the candidate on the terms in.
    pub(super) fn explained(&self, place: usize) -> f64 {
        if self.design.scale[place] > 0.0 { 1.0 - self.at(place, place) } else { 1.0 }
    }

    /// (5) in units of var(y), with `more` further terms that increase R2 by `gain`.
    pub(super) fn pse_with(&self, more: usize, gain: f64) -> f64 {
        self.unexplained() - gain + self.design.parameters(self.inside.len() + more) / self.design.samples()
    }

    fn value(&self, place: usize) -> f64 {
        self.at(place, self.design.names.len()) * self.design.response_scale() / self.design.scale[place]
    }

    /// The fit with the terms that are in.
    pub(super) fn fit(&self, colour: ErrorModelOrder) -> Result<EquationFit, FitError> {
        let design = self.design;
        let (m, p) = (design.samples(), design.parameters(self.inside.len()));
        if !(m > p) {
            return Err(FitError::Rows { parameters: p as usize, samples: m as usize });
        }
        let values: Vec<f64> = self.inside.iter().map(|&place| self.value(place)).collect();
        let mut residuals = design.response_column().to_vec();
        for (&place, value) in self.inside.iter().zip(&values) {
            residuals.iter_mut().zip(&design.columns[place]).for_each(|(v, x)| *v -= value * x);
        }
        let squares = inner(&residuals, &residuals);
        let response_squares = design.response_scale() * design.response_scale();
        let unexplained = squares / response_squares;
        let var_white = squares / (m - p);
        // Columns of X and of X D: first the biases', then the terms'.
        let units = self.units();
        let x: Vec<&[f64]> =
            units.iter().map(Vec::as_slice).chain(self.inside.iter().map(|&place| design.columns[place].as_slice())).collect();
        let dispersion = self.dispersion();
        let xd: Vec<Vec<f64>> = units.iter().cloned().chain(dispersion.iter().map(|row| self.combined(row))).collect();
        let mut leverage = vec![0.0; residuals.len()];
        for (x, xd) in x.iter().zip(&xd) {
            leverage.iter_mut().zip(x.iter().zip(xd)).for_each(|(h, (x, d))| *h += x * d);
        }
        let press = residuals.iter().zip(&leverage).map(|(v, h)| v / (1.0 - h)).map(|v| v * v).sum();
        let error = ErrorModel::of(&residuals, &FittedEquation { x: &x, xd: &xd, stretches: &design.stretches }, colour);
        let (cov, bias_stds) = self.covariances(&dispersion, &error.middle);
        let cov_white: Vec<Vec<f64>> = dispersion.iter().map(|row| row.iter().map(|entry| var_white * entry).collect()).collect();
        let term = |(i, (&place, &value)): (usize, (&usize, &f64))| {
            let (var, white) = (cov[i][i], cov_white[i][i]);
            TermEstimate {
                place,
                name: design.names[place].clone(),
                value,
                std: libm::sqrt(var),
                std_white: libm::sqrt(white),
                f: value * value / var,
                f_white: value * value / white,
            }
        };
        let terms: Vec<TermEstimate> = self.inside.iter().zip(&values).enumerate().map(term).collect();
        let quality = FitQuality {
            samples: m,
            parameters: p,
            squares,
            r_squared: 1.0 - unexplained,
            f_total: if terms.is_empty() { 0.0 } else { (1.0 - unexplained) / terms.len() as f64 * (m - p) / unexplained },
            pse: squares / m + response_squares / m * p / m,
            press,
            residual_std: libm::sqrt(var_white),
            condition_index: largest_index(design, &self.inside),
        };
        let mean_of = |group: usize, place: usize| design.means[place].get(group).copied().unwrap_or(0.0);
        let bias = |group: usize| {
            let carried: f64 = self.inside.iter().zip(&values).map(|(&place, value)| value * mean_of(group, place)).sum();
            mean_of(group, design.names.len()) - carried
        };
        let mut predicted = Vec::with_capacity(residuals.len());
        for (group, range) in design.groups.iter().enumerate() {
            let mean = mean_of(group, design.names.len());
            let y = &design.response_column()[range.clone()];
            predicted.extend(y.iter().zip(&residuals[range.clone()]).map(|(y, v)| y + mean - v));
        }
        Ok(EquationFit {
            response: design.response_name.clone(),
            terms,
            biases: (0..design.groups.len()).map(bias).collect(),
            bias_stds,
            cov,
            cov_white,
            quality,
            error,
            rows: design.rows.clone(),
            predicted,
            residuals,
        })
    }

    /// The biases' columns, of unit length.
    fn units(&self) -> Vec<Vec<f64>> {
        let unit = |group: &std::ops::Range<usize>| {
            let mut column = vec![0.0; self.design.rows.len()];
            column[group.clone()].fill(1.0 / libm::sqrt(group.len() as f64));
            column
        };
        self.design.groups.iter().map(unit).collect()
    }

    /// (X'X)^-1 of the terms, in the order of entry.
    fn dispersion(&self) -> Vec<Vec<f64>> {
        let scale = &self.design.scale;
        let row = |&i: &usize| self.inside.iter().map(|&j| -self.at(i, j) / (scale[i] * scale[j])).collect();
        self.inside.iter().map(row).collect()
    }

    fn combined(&self, row: &[f64]) -> Vec<f64> {
        let mut sum = vec![0.0; self.design.rows.len()];
        for (&place, factor) in self.inside.iter().zip(row) {
            sum.iter_mut().zip(&self.design.columns[place]).for_each(|(s, x)| *s += factor * x);
        }
        sum
    }

    /// Covariance of the terms and standard errors of the biases, from X' Sigma X.
    fn covariances(&self, dispersion: &[Vec<f64>], middle: &[f64]) -> (Vec<Vec<f64>>, Vec<f64>) {
        let design = self.design;
        let (groups, terms) = (design.groups.len(), self.inside.len());
        let size = groups + terms;
        // Rows that bring X'e to the parameters: terms by D, biases by their mean less what the terms carry.
        let of_term = |row: &Vec<f64>| [vec![0.0; groups], row.clone()].concat();
        let of_bias = |group: usize| {
            let mut row = vec![0.0; size];
            row[group] = 1.0 / libm::sqrt(design.groups[group].len() as f64);
            for (&place, dispersed) in self.inside.iter().zip(dispersion) {
                let mean = design.means[place].get(group).copied().unwrap_or(0.0);
                row[groups..].iter_mut().zip(dispersed).for_each(|(entry, d)| *entry -= mean * d);
            }
            row
        };
        let rows: Vec<Vec<f64>> = dispersion.iter().map(of_term).collect();
        let form = |a: &[f64], b: &[f64]| -> f64 {
            a.iter().zip(middle.chunks(size.max(1))).map(|(a, row)| a * row.iter().zip(b).map(|(m, b)| m * b).sum::<f64>()).sum()
        };
        let cov = rows.iter().map(|a| rows.iter().map(|b| form(a, b)).collect()).collect();
        let stds = (0..groups).map(of_bias).map(|row| libm::sqrt(form(&row, &row))).collect();
        (cov, stds)
    }
}
