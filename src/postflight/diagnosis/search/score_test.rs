//! Score test of all hypotheses: the gain in evidence by each, linearised, with all other parameters free.
//!
//! Consumes the linearisation at a point; produces for each entry, with A, b of `problem` (1), the products c of its sensitivity
//! with the other columns, I_0 with itself and u_0 with the innovations,
//!     I = I_0 - c' A^-1 c     u = u_0 - c' A^-1 b     size = u/(I + 1/s^2)                             (1)
//!     gain = u^2/(I + 1/s^2) - ln(1 + s^2 I)                                                          (2)
//! (2) is twice the logarithm of the Bayes factor, s the prior standard deviation of the parameter. Where the parameter has no
//! prior of its own, s makes the force of the hypothesis as large as the model's own on that axis.

use super::hypotheses::LibraryEntry;
use crate::flight::derivative::{AXES, Axis};
use crate::flight::effect::Effect;
use crate::postflight::diagnosis::likelihood::normal_equations::Linearisation;
use crate::postflight::diagnosis::likelihood::parameter::output_of;
use nalgebra::{Cholesky, DMatrix, DVector, Dyn};

/// Least information of the data over that of the prior.
const INFORMATION_OVER_PRIOR: f64 = 1.0;

/// What an entry would gain.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HypothesisScore {
    /// Its place in the library.
    pub entry: usize,
    /// (2).
    pub gain: f64,
    /// (1).
    pub size: f64,
    /// Standard error of that.
    pub std: f64,
    /// s.
    pub prior_std: f64,
}

/// All entries, the greatest gain first.
pub fn score_test(local: &Linearisation, entries: &[LibraryEntry], usual: &[f64; AXES]) -> Vec<HypothesisScore> {
    let answer = local.factor.solve(&local.gradient);
    let answering =
        FreeParameters { factor: &local.factor, answer: &answer, cross: &local.cross, gradient: &local.candidate_gradient };
    scores(local, entries, usual, &answering)
}

/// The parameters that are free to answer.
pub(crate) struct FreeParameters<'a> {
    pub(crate) factor: &'a Cholesky<f64, Dyn>,
    pub(crate) answer: &'a DVector<f64>,
    /// Their products with the candidates.
    pub(crate) cross: &'a DMatrix<f64>,
    /// What pulls at the candidates.
    pub(crate) gradient: &'a [f64],
}

/// (1) and (2) of the entries where those parameters answer, the greatest gain first.
pub(crate) fn scores(
    local: &Linearisation,
    entries: &[LibraryEntry],
    usual: &[f64; AXES],
    answering: &FreeParameters<'_>,
) -> Vec<HypothesisScore> {
    let FreeParameters { factor, answer, cross, gradient } = answering;
    let reduced: DMatrix<f64> = factor.solve(*cross);
    let mut scores: Vec<HypothesisScore> = entries
        .iter()
        .enumerate()
        .filter_map(|(place, entry)| {
            let column = cross.column(place);
            let information = local.diagonal.get(place)? - column.dot(&reduced.column(place));
            let gradient = gradient.get(place)? - column.dot(answer);
            let prior_std = prior_of(entry, local, place, usual)?;
            let (gain, size, std) = scored(information, gradient, prior_std)?;
            Some(HypothesisScore { entry: place, gain, size, std, prior_std })
        })
        .collect();
    scores.sort_by(|a, b| b.gain.total_cmp(&a.gain));
    scores
}

/// Gain (2), size (1) and its standard error from I, u and s; `None` where the data have less information than the prior.
pub(crate) fn scored(information: f64, gradient: f64, prior_std: f64) -> Option<(f64, f64, f64)> {
    let variance = prior_std * prior_std;
    if !(information * variance >= INFORMATION_OVER_PRIOR) {
        return None;
    }
    let whole = information + 1.0 / variance;
    let gain = gradient * gradient / whole - libm::log(1.0 + variance * information);
    gain.is_finite().then(|| (gain, gradient / whole, 1.0 / libm::sqrt(whole)))
}

/// s of an entry, the candidate at that place: its own, or what makes its force as large as is usual on its axis.
pub(crate) fn prior_of(entry: &LibraryEntry, local: &Linearisation, place: usize, usual: &[f64; AXES]) -> Option<f64> {
    entry.prior_std.or_else(|| {
        let strength = *local.strength.get(place)?;
        let axis = entry.effect.axis()?;
        (strength > 0.0).then(|| usual[axis.index()] / strength)
    })
}

/// The axis whose force or moment an effect adds to, or whose reading it takes for one.
pub fn acts_on(effect: &Effect) -> Option<Axis> {
    effect.axis().or_else(|| Axis::ALL.get(output_of(effect)?).copied())
}
