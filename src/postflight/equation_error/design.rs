//! The information matrix of an equation over whole records: response and candidates about their means.
//!
//! Consumes a table, the names of the response and the candidates, the rows to use; produces, about the mean of each bias' rows,
//!     S = [X y]'[X y], scaled to unit diagonal                                                       (1)
//! and the columns themselves, for leverages and coloured errors. Subtracting the mean is equivalent to a bias term
//! (R. Frisch and F. V. Waugh, Econometrica 1(4), 1933).
//! There is one bias for all records, or one each.
//! Rows with a value that is not finite are not used; lags do not reach across such a gap, a window's edge or a record's end.

use super::expression::{Expression, ExpressionError, UnknownColumn};
use super::table::RegressionTable;
use crate::flight::derivative::Variable;
use crate::realtime::regression::candidate::{STILL as MOTIONLESS, UNMOVED};
use std::ops::Range;

/// Deviation, relative to its size, below which a column is constant.
const STILL: f64 = 1e-9;

/// Role of a candidate in the selection.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CandidateRole {
    /// In the equation whatever its partial F.
    Kept,
    /// Selected by its partial F, which is monitored for the collapse.
    Primary,
    /// Selected by its partial F.
    Offered,
}

/// A candidate term of an equation.
#[derive(Clone, Debug, PartialEq)]
pub struct CandidateTerm {
    /// Product of columns.
    pub term: Expression,
    /// Whether it is selected.
    pub role: CandidateRole,
}

impl CandidateTerm {
    /// A candidate that is selected by its partial F.
    ///
    /// # Errors
    /// [`ExpressionError`] where the text is not a term.
    pub fn offered(text: &str) -> Result<CandidateTerm, ExpressionError> {
        Ok(CandidateTerm { term: Expression::parse(text)?, role: CandidateRole::Offered })
    }
}

/// Bias terms of an equation over several records.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Bias {
    /// One for all records.
    Shared,
    /// One a record.
    #[default]
    EachRecord,
}

/// Why a design is refused.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[expect(missing_docs, reason = "the message of each says what its fields are")]
pub enum DesignError {
    #[error(transparent)]
    Unknown(#[from] UnknownColumn),
    #[error("term \"{term}\" is offered twice")]
    Twice { term: String },
    #[error("expected a mask of {expected} rows, found {found}")]
    Mask { expected: usize, found: usize },
    #[error("expected at least {needed} rows without a hole, found {found}")]
    Rows { needed: usize, found: usize },
    #[error("response \"{response}\" does not move")]
    Still { response: String },
}

/// Response and candidates of one equation.
#[derive(Clone, Debug)]
pub struct Design {
    pub(super) response_name: String,
    pub(super) candidates: Vec<CandidateTerm>,
    pub(super) names: Vec<String>,
    /// Table's row of each row that is used.
    pub(super) rows: Vec<usize>,
    pub(super) groups: Vec<Range<usize>>,
    /// Rows without a hole among them.
    pub(super) stretches: Vec<Range<usize>>,
    /// Candidates about their mean, and the response as last one.
    pub(super) columns: Vec<Vec<f64>>,
    pub(super) means: Vec<Vec<f64>>,
    /// Square roots of the sums of squares about the mean; zero where a candidate stands still.
    pub(super) scale: Vec<f64>,
    /// (1) row after row, the response last.
    pub(super) sums: Vec<f64>,
}

impl Design {
    /// Computes all columns and their sums of products (1). The response is a term itself, mostly a plain column.
    ///
    /// # Errors
    /// [`DesignError`] where a column is missing, a term is given twice, too few rows are left or the response is constant.
    pub fn new(
        table: &RegressionTable,
        response: &Expression,
        candidates: &[CandidateTerm],
        mask: &[bool],
        bias: Bias,
    ) -> Result<Design, DesignError> {
        if mask.len() != table.rows() {
            return Err(DesignError::Mask { expected: table.rows(), found: mask.len() });
        }
        let names: Vec<String> = candidates.iter().map(|candidate| candidate.term.to_string()).collect();
        if let Some((_, term)) =
            names.iter().enumerate().find(|(place, name)| names.iter().take(*place).any(|other| other == *name))
        {
            return Err(DesignError::Twice { term: term.clone() });
        }
        let values = |term: &Expression, called: Option<String>| {
            let found = term.values(table.rows(), |name| table.column(name));
            found.map_err(|column| UnknownColumn { term: called, column, columns: table.names().to_vec() })
        };
        let mut whole = Vec::with_capacity(candidates.len() + 1);
        for (candidate, name) in candidates.iter().zip(&names) {
            whole.push(values(&candidate.term, Some(name.clone()))?);
        }
        whole.push(values(response, None)?);
        let is_used = |&row: &usize| mask[row] && whole.iter().all(|column| column[row].is_finite());
        let mut design = Design {
            response_name: response.to_string(),
            candidates: candidates.to_vec(),
            names,
            rows: Vec::new(),
            groups: Vec::new(),
            stretches: Vec::new(),
            columns: Vec::new(),
            means: Vec::new(),
            scale: Vec::new(),
            sums: Vec::new(),
        };
        for record in 0..table.records() {
            let begin = design.rows.len();
            let mut open = begin;
            for row in table.rows_of(record).filter(is_used) {
                if design.rows.len() > open && design.rows.last().is_some_and(|&last| last + 1 != row) {
                    design.stretches.push(open..design.rows.len());
                    open = design.rows.len();
                }
                design.rows.push(row);
            }
            let end = design.rows.len();
            if end > open {
                design.stretches.push(open..end);
            }
            match (bias, design.groups.last_mut()) {
                (Bias::Shared, Some(all)) => all.end = end,
                _ if end > begin => design.groups.push(begin..end),
                _ => {}
            }
        }
        let (needed, found) = (design.groups.len().max(1) + 3, design.rows.len());
        if found < needed {
            return Err(DesignError::Rows { needed, found });
        }
        design.centre(&whole);
        for (place, candidate) in candidates.iter().enumerate() {
            if candidate.term.columns().any(|column| design.is_constant(table, column)) {
                design.scale[place] = 0.0;
            }
        }
        design.multiply();
        if design.response_scale() > 0.0 { Ok(design) } else { Err(DesignError::Still { response: design.response_name }) }
    }

    fn centre(&mut self, whole: &[Vec<f64>]) {
        for column in whole {
            let mut used: Vec<f64> = self.rows.iter().map(|&row| column[row]).collect();
            let size = libm::sqrt(inner(&used, &used));
            let mut means = Vec::with_capacity(self.groups.len());
            for group in &self.groups {
                let part = &mut used[group.clone()];
                // Twice, for the rounding of the first mean.
                let mut mean = 0.0;
                for _ in 0..2 {
                    let rest = total(part) / part.len() as f64;
                    part.iter_mut().for_each(|x| *x -= rest);
                    mean += rest;
                }
                means.push(mean);
            }
            let length = libm::sqrt(inner(&used, &used));
            self.scale.push(if length > STILL * size { length } else { 0.0 });
            self.means.push(means);
            self.columns.push(used);
        }
    }

    /// Whether a column of a known variable varies by less than the least excitation of that variable.
    fn is_constant(&self, table: &RegressionTable, column: &str) -> bool {
        let (Some(variable), Some(values)) = (Variable::from_name(column), table.column(column)) else { return false };
        let mut squares = 0.0;
        for group in &self.groups {
            let rows = &self.rows[group.clone()];
            let mean = rows.iter().map(|&row| values[row]).sum::<f64>() / rows.len() as f64;
            squares += rows.iter().map(|&row| (values[row] - mean) * (values[row] - mean)).sum::<f64>();
        }
        !(libm::sqrt(squares / self.samples()) > UNMOVED * MOTIONLESS[variable.index()])
    }

    fn multiply(&mut self) {
        let order = self.columns.len();
        self.sums = vec![0.0; order * order];
        for i in 0..order {
            for j in 0..=i {
                let both = self.scale[i] * self.scale[j];
                let product = if both > 0.0 { inner(&self.columns[i], &self.columns[j]) / both } else { 0.0 };
                self.sums[i * order + j] = product;
                self.sums[j * order + i] = product;
            }
        }
    }

    /// Candidates that were offered.
    pub fn candidates(&self) -> &[CandidateTerm] {
        &self.candidates
    }

    /// Names of the candidates.
    pub fn names(&self) -> &[String] {
        &self.names
    }

    /// Name of the response.
    pub fn response(&self) -> &str {
        &self.response_name
    }

    /// Rows of the table that are used.
    pub fn rows(&self) -> &[usize] {
        &self.rows
    }

    /// Places of constant candidates, which are not identifiable.
    pub fn still(&self) -> impl Iterator<Item = usize> {
        (0..self.names.len()).filter(|&place| !(self.scale[place] > 0.0))
    }

    /// Number of rows m.
    pub fn samples(&self) -> f64 {
        self.rows.len() as f64
    }

    /// Number of parameters p of an equation with so many terms, the biases among them.
    pub fn parameters(&self, terms: usize) -> f64 {
        (terms + self.groups.len()) as f64
    }

    /// Places: candidates and the response.
    pub(super) fn order(&self) -> usize {
        self.columns.len()
    }

    pub(super) fn response_scale(&self) -> f64 {
        self.scale[self.names.len()]
    }

    pub(super) fn response_column(&self) -> &[f64] {
        &self.columns[self.names.len()]
    }

    /// Correlation of two candidates about their means.
    pub fn correlation(&self, a: usize, b: usize) -> f64 {
        self.sums[a * self.order() + b]
    }
}

/// Sum of products in eight partial sums, which the processor adds in parallel.
pub(super) fn inner(a: &[f64], b: &[f64]) -> f64 {
    let (eights_a, rest_a) = a.as_chunks::<8>();
    let (eights_b, rest_b) = b.as_chunks::<8>();
    let mut sums = [0.0; 8];
    for (x, y) in eights_a.iter().zip(eights_b) {
        for ((sum, x), y) in sums.iter_mut().zip(x).zip(y) {
            *sum += x * y;
        }
    }
    let rest: f64 = rest_a.iter().zip(rest_b).map(|(x, y)| x * y).sum();
    sums.iter().sum::<f64>() + rest
}

fn total(a: &[f64]) -> f64 {
    let (eights, rest) = a.as_chunks::<8>();
    let mut sums = [0.0; 8];
    for x in eights {
        sums.iter_mut().zip(x).for_each(|(sum, x)| *sum += x);
    }
    sums.iter().sum::<f64>() + rest.iter().sum::<f64>()
}
