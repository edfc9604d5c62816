//! Standard errors of the sizes of causes, by a model that is not exactly right.
//!
//! Consumes the problem and the result of the search; produces for each cause, with s the standard error of the likelihood, r its
//! ratio to the robust one (`sandwich`) and delta the size less what it is where nothing is wrong,
//!     std^2 = (r s)^2 + (D delta)^2                                                                   (1)
//! The likelihood takes one of the hypotheses to be exactly true. What the model lacks besides is correlated with the cause that
//! is fitted and moves its size: by data of any length, and so by no standard error that falls with them. Its part D is
//! [`MODEL_DISCREPANCY`] of an effect on the aircraft, measured on simulated flights in which much is a little wrong (decisions
//! page); an instrument is measured against the kinematics, which lack nothing: nought.
//! Source of the split: M. C. Kennedy and A. O'Hagan, Bayesian Calibration of Computer Models, 2001, sec. 4.2 (model inadequacy).

use crate::flight::effect::Family;
use crate::postflight::diagnosis::likelihood::problem::DiagnosisProblem;
use crate::postflight::diagnosis::likelihood::sandwich::robust_ratio;
use crate::postflight::diagnosis::search::forward_search::SearchResult;

/// D of (1).
const MODEL_DISCREPANCY: f64 = 0.06;

/// (1) of the cause at that place among the point's hypotheses.
pub(crate) fn size_std(problem: &DiagnosisProblem, searched: &SearchResult, place: usize) -> f64 {
    let ratio = robust_ratio(problem, &searched.point, &searched.local, searched.point.main_place_of(place));
    let effects = searched.point.hypotheses.get(place).map(|hypothesis| hypothesis.effect);
    let of_aircraft = effects.filter(|effect| effect.kind().family() != Family::Instrument);
    let wrong = of_aircraft.and_then(|effect| Some(effect.main_number()? - effect.kind().neutral()));
    libm::hypot(ratio * searched.std(place), MODEL_DISCREPANCY * wrong.unwrap_or(0.0))
}
