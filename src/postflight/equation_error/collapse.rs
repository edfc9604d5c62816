//! The collapse of partial F: partial F of primary terms falls as terms enter, while R2 still rises.
//!
//! Consumes the equation before and after each entry; produces a [`Collapse`] where, of a monitored term,
//!     F <= best F so far/fall, for coloured and for white residuals, and F < f_known                  (1)
//! while R2 rises and the term loses by a larger factor than the fit gains: best F/F > SSE before/SSE after.     (2) Below
//! `f_known` = 100 a standard error exceeds a tenth of the value. Monitored are primary terms, or all linear ones where none is
//! primary. The step kept is the one before the entry at which the term lost most. Cause: the new term is nearly a linear
//! combination of those in the equation, so that its effect and theirs are exchangeable; the fit error does not show it, the
//! partial F do.
//! Source: Padfield et al. 1987, sections 2.2.5 and 3, Figs 10 to 13 and 18; the limits of (1) and (2) are ours.

use super::design::{CandidateRole, Design};
use super::fit::EquationFit;
use super::step::{StepwiseStep, TermChange};
use std::fmt;

/// Limits of (1).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CollapseLimits {
    /// Ratio by which partial F has fallen; infinite for no test.
    pub fall: f64,
    /// Partial F above which a term counts as known.
    pub f_known: f64,
}

impl Default for CollapseLimits {
    fn default() -> Self {
        CollapseLimits { fall: 4.0, f_known: 100.0 }
    }
}

/// A monitored term before and after.
#[derive(Clone, Debug, PartialEq)]
pub struct FallenTerm {
    /// Name of the term.
    pub name: String,
    /// Partial F for coloured residuals: largest so far, and last.
    pub f: (f64, f64),
    /// The same for white residuals.
    pub f_white: (f64, f64),
    /// Estimates at these.
    pub value: (f64, f64),
}

/// A collapse of partial F.
#[derive(Clone, Debug, PartialEq)]
pub struct Collapse {
    /// Index of the step that is kept.
    pub kept: usize,
    /// Name of the term at whose entry it was detected.
    pub entered: String,
    /// Name of the first term that is not in the model kept.
    pub cause: String,
    /// The terms that fell, the deepest fall first.
    pub fallen: Vec<FallenTerm>,
    /// R2 before and after.
    pub r_squared: (f64, f64),
    /// Largest condition index before and after.
    pub condition_index: (f64, f64),
}

#[derive(Clone, Debug)]
struct BestEstimate {
    place: usize,
    f: f64,
    f_white: f64,
    value: f64,
}

/// The monitored terms.
#[derive(Clone, Debug)]
pub(super) struct CollapseMonitor {
    limits: CollapseLimits,
    watched: Vec<bool>,
    best: Vec<BestEstimate>,
}

impl CollapseMonitor {
    pub(super) fn new(design: &Design, limits: CollapseLimits) -> CollapseMonitor {
        let primary = |role: CandidateRole| role == CandidateRole::Primary || role == CandidateRole::Kept;
        let mut watched: Vec<bool> = design.candidates().iter().map(|candidate| primary(candidate.role)).collect();
        if !watched.contains(&true) {
            watched = design.candidates().iter().map(|candidate| candidate.term.is_linear()).collect();
        }
        CollapseMonitor { limits, watched, best: Vec::new() }
    }

    /// Records a step.
    pub(super) fn record(&mut self, fit: &EquationFit) {
        self.best.retain(|best| fit.terms.iter().any(|term| term.place == best.place));
        for term in fit.terms.iter().filter(|term| self.watched[term.place]) {
            match self.best.iter_mut().find(|best| best.place == term.place) {
                Some(best) if term.f > best.f => {
                    *best =
                        BestEstimate { place: term.place, f: term.f, f_white: best.f_white.max(term.f_white), value: term.value };
                }
                Some(best) => best.f_white = best.f_white.max(term.f_white),
                None => self.best.push(BestEstimate { place: term.place, f: term.f, f_white: term.f_white, value: term.value }),
            }
        }
    }

    /// The collapse by an entry, (1) and (2).
    pub(super) fn collapse(
        &self,
        steps: &[StepwiseStep],
        before: &EquationFit,
        after: &EquationFit,
        entered: &str,
    ) -> Option<Collapse> {
        let gain = before.quality.squares / after.quality.squares;
        if !(gain > 1.0) {
            return None;
        }
        let mut fallen = Vec::new();
        for best in &self.best {
            let Some(now) = after.terms.iter().find(|term| term.place == best.place) else { continue };
            let fell = now.f < self.limits.f_known
                && now.f * self.limits.fall <= best.f
                && now.f_white * self.limits.fall <= best.f_white
                && best.f > gain * now.f;
            if fell {
                fallen.push(FallenTerm {
                    name: now.name.clone(),
                    f: (best.f, now.f),
                    f_white: (best.f_white, now.f_white),
                    value: (best.value, now.value),
                });
            }
        }
        fallen.sort_by(|a, b| (b.f.0 / b.f.1).total_cmp(&(a.f.0 / a.f.1)));
        let deepest = fallen.first()?;
        let kept = steepest(steps, &deepest.name, deepest.f.1);
        let kept_step = steps.get(kept)?;
        let cause = match steps.get(kept + 1).map(|step| &step.change) {
            Some(TermChange::Entered(place)) => {
                steps.iter().flat_map(|step| &step.terms).find(|term| term.place == *place).map_or("", |term| &term.name)
            }
            _ => entered,
        };
        Some(Collapse {
            kept,
            entered: entered.to_owned(),
            cause: cause.to_owned(),
            r_squared: (kept_step.quality.r_squared, after.quality.r_squared),
            condition_index: (kept_step.quality.condition_index, after.quality.condition_index),
            fallen,
        })
    }
}

/// Step after which the partial F of the term fell by the largest factor, to `last` at the end.
fn steepest(steps: &[StepwiseStep], name: &str, last: f64) -> usize {
    let f_at = |step: &StepwiseStep| step.terms.iter().find(|term| term.name == name).map(|term| term.f);
    let mut found = (steps.len().saturating_sub(1), 0.0);
    for (place, step) in steps.iter().enumerate() {
        let Some(f) = f_at(step) else { continue };
        let next = steps.get(place + 1).map_or(Some(last), f_at);
        if let Some(next) = next
            && f / next >= found.1
        {
            found = (place, f / next);
        }
    }
    found.0
}

impl fmt::Display for Collapse {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (count, fallen) in self.fallen.iter().enumerate() {
            let separator = if count == 0 { "" } else { ", " };
            write!(f, "{separator}{} from F {:.0} to {:.0}", fallen.name, fallen.f.0, fallen.f.1)?;
            write!(f, " (value {:.4} to {:.4})", fallen.value.0, fallen.value.1)?;
        }
        write!(f, " fell when {} entered", self.entered)?;
        if self.cause != self.entered {
            write!(f, ", mostly when {} had", self.cause)?;
        }
        write!(
            f,
            ", while R2 rose from {:.5} to {:.5}; condition index {:.0} to {:.0}: the model stops before {}",
            self.r_squared.0, self.r_squared.1, self.condition_index.0, self.condition_index.1, self.cause
        )
    }
}
