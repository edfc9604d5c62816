//! Stepwise regression over whole records: terms enter and leave one a step, and every step is kept.
//!
//! Consumes a [`Design`] and [`StepwiseRules`]; produces a [`Selection`]: all steps with their criteria, the step that is kept
//! and its fit, why each term left out was left out, and the collapse where there was one.
//! Entry: the candidate with the largest partial F (the highest partial correlation with the residual) enters if its F for
//! coloured residuals exceeds `f_enter`, R2 rises by `r_squared_rise` and, where `predicts`, PSE and PRESS fall; else the next
//! one is tried. Where no term enters alone, pairs are tried: both must exceed `f_enter`, and R2 must rise as much by both.
//! Removal: after each entry terms below `f_remove` leave, the smallest F first, and stay out.
//! The model is stopped before an entry at which the partial F of primary terms collapses (`collapse`).
//! Source: Padfield et al. 1987, section 2.2.5 and Figs 10-13, 18; rules after V. Klein and E. A. Morelli, Aircraft System
//! Identification, 2006, section 5.4, with F for coloured residuals.

use super::collapse::{Collapse, CollapseLimits, CollapseMonitor};
use super::coloured_errors::ErrorModelOrder;
use super::design::{CandidateRole, Design};
use super::fit::{EquationFit, FitError, TermEstimate, Working};
use super::step::{StepwiseStep, TermChange};
use std::fmt;

/// Criteria of entry and removal.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StepwiseRules {
    /// A term enters above this partial F.
    pub f_enter: f64,
    /// A term leaves below this partial F.
    pub f_remove: f64,
    /// A term enters only if R2 rises by more than this.
    pub r_squared_rise: f64,
    /// Whether PSE and PRESS have to fall at an entry.
    pub predicts: bool,
    /// Whether F is for coloured residuals; for white ones otherwise, as in Padfield et al. 1987.
    pub corrected: bool,
    /// Limits of the collapse.
    pub collapse: CollapseLimits,
    /// Whether steps beyond the collapse are recorded too; the model kept is the one before it.
    pub beyond: bool,
    /// Whether pairs are tried where no term enters alone.
    pub pairs: bool,
    /// Largest number of terms.
    pub terms_max: usize,
    /// Order of the model of coloured residuals.
    pub colour: ErrorModelOrder,
}

/// Number of pairs tried, those of largest gain in R2.
const PAIRS: usize = 6;

/// Probability that any of the candidates enters though none has an effect.
const ACCIDENT: f64 = 0.01;

impl StepwiseRules {
    /// Rules for so many candidates: `f_enter` is 12, or the chi-square limit (one degree of freedom) at a probability of 1 %
    /// over the candidates (Bonferroni) where that is larger.
    pub fn for_candidates(count: usize) -> StepwiseRules {
        StepwiseRules {
            f_enter: chi_square_above(ACCIDENT / count.max(1) as f64).max(12.0),
            f_remove: 8.0,
            r_squared_rise: 0.005,
            predicts: true,
            corrected: true,
            collapse: CollapseLimits::default(),
            beyond: false,
            pairs: true,
            terms_max: usize::MAX,
            colour: ErrorModelOrder::default(),
        }
    }

    fn f(&self, term: &TermEstimate) -> f64 {
        if self.corrected { term.f } else { term.f_white }
    }
}

/// Quantile of chi-square with one degree of freedom, exceeded with that probability, by bisection.
fn chi_square_above(probability: f64) -> f64 {
    let (mut low, mut high) = (0.0, 40.0);
    for _ in 0..80 {
        let z = 0.5 * (low + high);
        if libm::erfc(z * core::f64::consts::FRAC_1_SQRT_2) > probability { low = z } else { high = z }
    }
    low * low
}

/// Why a candidate is not in the equation.
#[derive(Clone, Debug, PartialEq)]
pub enum RejectionReason {
    /// It does not vary.
    Still,
    /// It is a linear combination of the terms in; its R2 on them.
    Explained(f64),
    /// R2 would rise by this much, less than `r_squared_rise`.
    Rise(f64),
    /// Its partial F, below `f_enter`.
    PartialF(f64),
    /// PSE or PRESS would rise.
    Predicts,
    /// It was removed at this step.
    Left(usize),
    /// Partial F of primary terms collapsed with it.
    Collapse,
    /// The selection ended before it was tried.
    Ended,
}

/// A candidate that is not in the equation.
#[derive(Clone, Debug, PartialEq)]
pub struct RejectedCandidate {
    /// Place among the candidates.
    pub place: usize,
    /// Criterion that it failed.
    pub reason: RejectionReason,
}

/// Steps of a selection and the fit that is kept.
#[derive(Clone, Debug, PartialEq)]
pub struct Selection {
    /// Every step, beginning with biases and [`CandidateRole::Kept`] terms.
    pub steps: Vec<StepwiseStep>,
    /// Index of the step that is kept.
    pub kept: usize,
    /// The fit of the step that is kept.
    pub fit: EquationFit,
    /// Candidates that are not in that fit.
    pub rejected: Vec<RejectedCandidate>,
    /// The collapse, where there was one.
    pub collapse: Option<Collapse>,
}

/// Selects terms and fits them.
///
/// # Errors
/// [`FitError`] where the [`CandidateRole::Kept`] terms cannot be fitted.
pub fn select(design: &Design, rules: &StepwiseRules) -> Result<Selection, FitError> {
    let mut working = Working::new(design);
    for (place, candidate) in design.candidates().iter().enumerate() {
        if candidate.role == CandidateRole::Kept && !working.enter(place) {
            return Err(FitError::Dependent { term: design.names()[place].clone() });
        }
    }
    let fit = working.fit(rules.colour)?;
    let mut course = StepwiseRun {
        rules,
        watch: CollapseMonitor::new(design, rules.collapse),
        steps: vec![StepwiseStep::new(TermChange::Begun, &fit)],
        left: vec![None; design.names().len()],
        rejected: Vec::new(),
        kept: None,
        collapse: None,
    };
    course.watch.record(&fit);
    let mut fit = fit;
    while let Some((next, entered)) = course.entry(&working, &fit) {
        let name = |place: Option<&usize>| place.and_then(|&place| design.names().get(place)).map_or("", String::as_str);
        let collapsed = course.watch.collapse(&course.steps, &fit, &entered, name(next.places.first()));
        if let (Some(collapse), None) = (collapsed, &course.collapse) {
            course
                .rejected
                .extend(next.places.iter().map(|&place| RejectedCandidate { place, reason: RejectionReason::Collapse }));
            course.kept = Some(collapse.kept);
            course.collapse = Some(collapse);
            if !rules.beyond {
                break;
            }
        }
        if let [first, _] = next.places[..] {
            let mut between = working.clone();
            let _ = between.enter(first);
            course.steps.push(StepwiseStep::new(TermChange::Entered(first), &between.fit(rules.colour)?));
        }
        working = next.working;
        fit = entered;
        let last = next.places.last().copied().unwrap_or_default();
        course.steps.push(StepwiseStep::new(TermChange::Entered(last), &fit));
        course.watch.record(&fit);
        while let Some(place) = course.weakest(design, &fit) {
            working.leave(place);
            fit = working.fit(rules.colour)?;
            course.left[place] = Some(course.steps.len());
            course.steps.push(StepwiseStep::new(TermChange::Left(place), &fit));
            course.watch.record(&fit);
        }
    }
    course.ended(design)
}

/// Candidates that may enter, one or a pair, and the sums with them in.
struct TrialEntry<'a> {
    places: Vec<usize>,
    working: Working<'a>,
}

struct StepwiseRun<'a> {
    rules: &'a StepwiseRules,
    watch: CollapseMonitor,
    steps: Vec<StepwiseStep>,
    /// Step at which a candidate left.
    left: Vec<Option<usize>>,
    rejected: Vec<RejectedCandidate>,
    /// The step before the collapse.
    kept: Option<usize>,
    collapse: Option<Collapse>,
}

impl StepwiseRun<'_> {
    /// The next candidate in, and the fit with it.
    fn entry<'a>(&mut self, working: &Working<'a>, now: &EquationFit) -> Option<(TrialEntry<'a>, EquationFit)> {
        if self.collapse.is_none() {
            self.rejected.clear();
        }
        if working.inside.len() >= self.rules.terms_max {
            return None;
        }
        let mut open: Vec<(usize, f64)> = (0..self.left.len())
            .filter(|&place| self.left[place].is_none() && working.can_enter(place))
            .map(|place| (place, working.gain(place)))
            .collect();
        open.sort_by(|(_, a), (_, b)| b.total_cmp(a));
        for &(place, gain) in &open {
            match self.tried(working, now, &[place], gain) {
                Ok(found) => return Some(found),
                Err(reason) if self.collapse.is_none() => self.rejected.push(RejectedCandidate { place, reason }),
                Err(_) => {}
            }
        }
        if !self.rules.pairs || working.inside.len() + 2 > self.rules.terms_max {
            return None;
        }
        let mut pairs = Vec::new();
        for (count, &(first, _)) in open.iter().enumerate() {
            for &(second, _) in open.iter().skip(count + 1) {
                let gain = working.gain_of_pair(first, second);
                if gain > self.rules.r_squared_rise {
                    pairs.push((first, second, gain));
                }
            }
        }
        pairs.sort_by(|(_, _, a), (_, _, b)| b.total_cmp(a));
        pairs.into_iter().take(PAIRS).find_map(|(first, second, gain)| self.tried(working, now, &[first, second], gain).ok())
    }

    fn tried<'a>(
        &self,
        working: &Working<'a>,
        now: &EquationFit,
        places: &[usize],
        gain: f64,
    ) -> Result<(TrialEntry<'a>, EquationFit), RejectionReason> {
        if !(gain > self.rules.r_squared_rise) {
            return Err(RejectionReason::Rise(gain));
        }
        if self.rules.predicts && working.pse_with(places.len(), gain) >= working.pse_with(0, 0.0) {
            return Err(RejectionReason::Predicts);
        }
        let mut with = working.clone();
        let mut explained = 0.0;
        for &place in places {
            explained = with.explained(place);
            if !with.enter(place) {
                return Err(RejectionReason::Explained(explained));
            }
        }
        let Ok(fit) = with.fit(self.rules.colour) else { return Err(RejectionReason::Explained(explained)) };
        let entered = fit.terms.iter().rev().take(places.len());
        let f = entered.map(|term| self.rules.f(term)).fold(f64::INFINITY, f64::min);
        if !(f > self.rules.f_enter) {
            return Err(RejectionReason::PartialF(f));
        }
        if self.rules.predicts && fit.quality.press >= now.quality.press {
            return Err(RejectionReason::Predicts);
        }
        Ok((TrialEntry { places: places.to_vec(), working: with }, fit))
    }

    /// The term with the smallest partial F, where that is below `f_remove` and it may leave.
    fn weakest(&self, design: &Design, fit: &EquationFit) -> Option<usize> {
        let may = |term: &&TermEstimate| {
            design.candidates()[term.place].role != CandidateRole::Kept && self.rules.f(term) < self.rules.f_remove
        };
        let weakest = fit.terms.iter().filter(may).min_by(|a, b| self.rules.f(a).total_cmp(&self.rules.f(b)));
        weakest.map(|term| term.place)
    }

    fn ended(self, design: &Design) -> Result<Selection, FitError> {
        let kept = self.kept.unwrap_or(self.steps.len() - 1);
        let places: Vec<usize> = self.steps[kept].terms.iter().map(|term| term.place).collect();
        let fit = EquationFit::of(design, &places, self.rules.colour)?;
        let working = Working::new(design);
        let reason = |place: usize| {
            let recorded_reason =
                self.rejected.iter().find(|rejected| rejected.place == place).map(|rejected| rejected.reason.clone());
            if !(design.scale[place] > 0.0) {
                return RejectionReason::Still;
            }
            let left = self.left[place].filter(|&step| step <= kept).map(RejectionReason::Left);
            recorded_reason.or(left).unwrap_or(RejectionReason::Ended)
        };
        let mut with = working;
        for &place in &places {
            let _ = with.enter(place);
        }
        let rejected = (0..design.names().len()).filter(|place| !places.contains(place)).map(|place| {
            let reason = match reason(place) {
                RejectionReason::Ended if !with.can_enter(place) => RejectionReason::Explained(with.explained(place)),
                reason => reason,
            };
            RejectedCandidate { place, reason }
        });
        Ok(Selection { rejected: rejected.collect(), kept, fit, collapse: self.collapse, steps: self.steps })
    }
}

impl fmt::Display for RejectionReason {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            RejectionReason::Still => f.write_str("does not move"),
            RejectionReason::Explained(part) => write!(f, "is a combination of the terms in ({:.4} of its variance)", part),
            RejectionReason::Rise(rise) => write!(f, "R2 would rise by {:.3} % only", 100.0 * rise),
            RejectionReason::PartialF(partial) => write!(f, "its partial F would be {partial:.1} only"),
            RejectionReason::Predicts => f.write_str("the predicted error (PSE or PRESS) would not fall"),
            RejectionReason::Left(step) => write!(f, "its partial F fell and it left at step {step}"),
            RejectionReason::Collapse => f.write_str("the partial F of primary terms collapsed with it"),
            RejectionReason::Ended => f.write_str("was not tested: the selection had ended"),
        }
    }
}
