//! Equation error: the model structure and the estimates of one equation, from whole records.
//!
//! In: named columns over time, of one record or several, and candidate terms by name. Out: every step of a stepwise regression,
//! the equation that is kept with standard errors for coloured residuals, the best subset of each size, and the groups of terms
//! that are collinear in these data.
//! Assumed: regressors without noise (smoothed signals), rows of a record evenly spaced. Refused: a column or term that the table
//! does not have, a term that does not vary, fewer rows than terms; a model beyond the collapse of its partial F.

pub mod collapse;
pub mod collinearity;
pub mod coloured_errors;
pub mod design;
#[cfg(test)]
mod equation_error_tests;
pub mod expression;
pub mod fit;
pub mod holdout;
pub(crate) mod separation;
pub mod step;
pub mod stepwise;
pub mod subset;
pub mod table;
