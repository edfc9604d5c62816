//! Many causes at once: what would stand for each of them, were it not there.
//!
//! Consumes the neighbourhood of a point, A and b of (1) of `problem`; produces for a hypothesis with size theta at place p, and
//! for each candidate besides, what it gains where theta is nothing and all others are free to answer,
//!     b' = b + A_p theta     u_c' = u_c + c_p theta                                                   (1)
//! without row and column p, and then (1) and (2) of `score_test`. Two that gain alike are not separable by these runs, and one
//! that gains more than the hypothesis itself is the likelier cause.

use super::hypotheses::LibraryEntry;
use super::score_test::{FreeParameters, HypothesisScore, scored, scores};
use crate::flight::derivative::AXES;
use crate::postflight::diagnosis::likelihood::normal_equations::Linearisation;
use crate::postflight::diagnosis::likelihood::parameter_set::ParameterSet;
use nalgebra::{Cholesky, DMatrix};

/// What a hypothesis gains, and what each entry of the library would in its place.
#[derive(Clone, Debug)]
pub(crate) struct Substitutes {
    pub(crate) own: f64,
    /// The entries', the greatest gain first.
    pub(crate) others: Vec<HypothesisScore>,
}

/// For every hypothesis of the point; each has a single number.
pub(crate) fn substitutes(
    local: &Linearisation,
    point: &ParameterSet,
    entries: &[LibraryEntry],
    usual: &[f64; AXES],
) -> Option<Vec<Substitutes>> {
    let all = local.factor.l() * local.factor.l().transpose();
    (0..point.hypotheses.len()).map(|hypothesis| of_one(local, &all, point, hypothesis, entries, usual)).collect()
}

/// For the hypothesis at this place among the point's.
fn of_one(
    local: &Linearisation,
    all: &DMatrix<f64>,
    point: &ParameterSet,
    hypothesis: usize,
    entries: &[LibraryEntry],
    usual: &[f64; AXES],
) -> Option<Substitutes> {
    let place = point.place_of(hypothesis);
    let one = point.hypotheses.get(hypothesis)?;
    let theta = point.number((hypothesis, 0)) - one.beforehand(0);
    let weight = 1.0 / (one.prior_std * one.prior_std);
    let column = all.column(place).remove_row(place);
    let factor = Cholesky::new(all.clone().remove_row(place).remove_column(place))?;
    let answer = factor.solve(&(local.gradient.clone().remove_row(place) + &column * theta));
    // What the data alone know of it: the prior's part undone.
    let information = all[(place, place)] - weight - column.dot(&factor.solve(&column));
    let own_pull = local.gradient.get(place)? + all[(place, place)] * theta - column.dot(&answer);
    let own = scored(information, own_pull, one.prior_std).map_or(0.0, |(gain, ..)| gain);
    let gradient: Vec<f64> =
        local.candidate_gradient.iter().zip(&local.cross.row(place)).map(|(gradient, by)| gradient + by * theta).collect();
    let cross = local.cross.clone().remove_row(place);
    let answering = FreeParameters { factor: &factor, answer: &answer, cross: &cross, gradient: &gradient };
    Some(Substitutes { own, others: scores(local, entries, usual, &answering) })
}
