//! The inverse of an information matrix, or the names of the unknowns that it does not identify.
//!
//! Consumes M [n x n], symmetric, and the unknowns' names; inverts it scaled to a unit diagonal,
//!     M_s = D M D,   D = diag(M_jj^-1/2),   M^-1 = D M_s^-1 D                                        (1)
//! Where a pivot of M_s's Cholesky factor vanishes, the unknowns are named that take part in the eigenvector of its smallest
//! eigenvalue by more than 0.2 of the largest component; where M_jj is not positive, unknown j is named.

use super::error::OutputErrorFitError;
use crate::num::dense::Dense;

/// Inverse of an information matrix, or the names that it does not tell apart.
pub(crate) fn inverse_or_names(matrix: &Dense, names: &[String]) -> Result<Dense, OutputErrorFitError> {
    let diagonal = matrix.diagonal();
    let blind: Vec<String> = diagonal
        .iter()
        .zip(names)
        .filter(|(value, _)| !(**value > 0.0) || !value.is_finite())
        .map(|(_, name)| name.clone())
        .collect();
    if !blind.is_empty() {
        return Err(OutputErrorFitError::Singular { names: blind, smallest: 0.0 });
    }
    let scale: Vec<f64> = diagonal.iter().map(|value| 1.0 / libm::sqrt(*value)).collect();
    let scaled = Dense::from_fn(matrix.rows(), matrix.rows(), |i, j| matrix[(i, j)] * scale[i] * scale[j]);
    if let Some(inverse) = scaled.inverse() {
        return Ok(Dense::from_fn(matrix.rows(), matrix.rows(), |i, j| inverse[(i, j)] * scale[i] * scale[j]));
    }
    let (values, vectors) = scaled.symmetric_eigen();
    let part = |i: usize| vectors[(i, 0)].abs();
    let most = (0..names.len()).map(part).fold(0.0, f64::max);
    let names = names.iter().enumerate().filter(|(i, _)| part(*i) > 0.2 * most).map(|(_, name)| name.clone()).collect();
    Err(OutputErrorFitError::Singular { names, smallest: values.first().copied().unwrap_or(0.0) })
}
