//! Stepwise regression over whole records: terms enter and leave one a step, and every step is kept.
//!
//! Consumes a [`Design`] and [`Rules`]; produces a [`Selection`]: all steps with what they were judged by, the step that is
//! kept and its fit, why each term left out was left out, and the collapse where there was one.
//! Entry: the candidate with the largest partial F (the highest partial correlation with the residual) is tried; it
//! enters if its F for coloured residuals exceeds `f_enter`, R2 rises by `r_squared_rise` and, where asked for, PSE and
//! PRESS fall; else the next one is tried. Where no term enters alone, pairs are tried that may matter only together:
//! both must exceed `f_enter` and bring the rise between them. Removal: after each entry terms below `f_remove` leave,
//! the weakest first, and stay out.
//! The model is stopped before an entry at which the partial F of primary terms collapses (`collapse`).
//! Source: RAE/Glasgow paper, section 2.2.5 and Figs 10-13, 18; rules after V. Klein and E. A. Morelli, Aircraft System
//! Identification, 2006, section 5.4, with F for coloured residuals.

use super::collapse::{Collapse, Limits, Watch};
use super::colour::Colour;
use super::design::{Design, Role};
use super::fit::{Fit, FitError, Quality, Term, Working};
use std::fmt;

/// When terms enter and leave.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rules {
    /// A term enters above this partial F.
    pub f_enter: f64,
    /// A term leaves below this partial F.
    pub f_remove: f64,
    /// A term enters only if R2 rises by more than this.
    pub r_squared_rise: f64,
    /// Whether PSE and PRESS have to fall at an entry.
    pub predicts: bool,
    /// Whether F is for coloured residuals; for white ones otherwise, as in the paper.
    pub corrected: bool,
    /// What counts as the collapse.
    pub collapse: Limits,
    /// Whether steps beyond the collapse are taken too, for the record: the model kept is the one before it all the same.
    pub beyond: bool,
    /// Whether pairs are tried where no term enters alone.
    pub pairs: bool,
    /// Most terms.
    pub terms_max: usize,
    /// How the colour of residuals is taken.
    pub colour: Colour,
}

/// Pairs that are tried at a time, those that bring most.
const PAIRS: usize = 6;

/// Chance of letting any of the candidates in by accident.
const ACCIDENT: f64 = 0.01;

impl Rules {
    /// The rules for so many candidates: F above 12, or above what one in a hundred selections from so many candidates that
    /// are nothing would exceed.
    pub fn for_candidates(count: usize) -> Rules {
        Rules {
            f_enter: chi_square_above(ACCIDENT / count.max(1) as f64).max(12.0),
            f_remove: 8.0,
            r_squared_rise: 0.005,
            predicts: true,
            corrected: true,
            collapse: Limits::default(),
            beyond: false,
            pairs: true,
            terms_max: usize::MAX,
            colour: Colour::default(),
        }
    }

    /// Those of the paper: whatever has F above 1 for white residuals enters, and nothing leaves.
    pub fn of_the_paper() -> Rules {
        Rules {
            f_enter: 1.0,
            f_remove: 0.0,
            r_squared_rise: 0.0,
            predicts: false,
            corrected: false,
            beyond: true,
            pairs: false,
            ..Rules::for_candidates(1)
        }
    }

    fn f(&self, term: &Term) -> f64 {
        if self.corrected { term.f } else { term.f_white }
    }
}

/// The value that chi-square with one degree of freedom exceeds with that probability, by halving.
fn chi_square_above(probability: f64) -> f64 {
    let (mut low, mut high) = (0.0, 40.0);
    for _ in 0..80 {
        let z = 0.5 * (low + high);
        if libm::erfc(z * core::f64::consts::FRAC_1_SQRT_2) > probability { low = z } else { high = z }
    }
    low * low
}

/// What happened at a step.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Change {
    /// Biases and kept terms only.
    Begun,
    /// That candidate entered.
    Entered(usize),
    /// That candidate left.
    Left(usize),
}

/// The equation after one step.
#[derive(Clone, Debug, PartialEq)]
pub struct Step {
    /// What happened.
    pub change: Change,
    /// Terms in, with both their partial F.
    pub terms: Vec<Term>,
    /// What the whole is judged by.
    pub quality: Quality,
}

/// Why a candidate is not in.
#[derive(Clone, Debug, PartialEq)]
pub enum Reason {
    /// It does not move.
    Still,
    /// Those in explain it: that part of its variance.
    Explained(f64),
    /// R2 would rise by that only.
    Rise(f64),
    /// Its partial F would be that only.
    PartialF(f64),
    /// PSE or PRESS would rise.
    Predicts,
    /// It left at that step.
    Left(usize),
    /// Partial F of primary terms collapsed with it.
    Collapse,
    /// The selection ended before it was tried.
    Ended,
}

/// A candidate that is not in.
#[derive(Clone, Debug, PartialEq)]
pub struct Refused {
    /// Which one.
    pub place: usize,
    /// Why.
    pub reason: Reason,
}

/// What the selection came to.
#[derive(Clone, Debug, PartialEq)]
pub struct Selection {
    /// Every step, from biases and kept terms on.
    pub steps: Vec<Step>,
    /// Which of them is kept.
    pub kept: usize,
    /// The fit of the step that is kept.
    pub fit: Fit,
    /// Candidates that are not in it.
    pub refused: Vec<Refused>,
    /// The collapse, where there was one.
    pub collapse: Option<Collapse>,
}

/// Selects terms and fits them.
///
/// # Errors
/// [`FitError`] where the terms that are kept whatever their F cannot be fitted.
pub fn select(design: &Design, rules: &Rules) -> Result<Selection, FitError> {
    let mut working = Working::new(design);
    for (place, candidate) in design.candidates().iter().enumerate() {
        if candidate.role == Role::Kept && !working.enter(place) {
            return Err(FitError::Dependent { term: design.names()[place].clone() });
        }
    }
    let fit = working.fit(rules.colour)?;
    let mut course = Course {
        rules,
        watch: Watch::new(design, rules.collapse),
        steps: vec![step(Change::Begun, &fit)],
        left: vec![None; design.names().len()],
        refused: Vec::new(),
        kept: None,
        collapse: None,
    };
    course.watch.see(&fit);
    let mut fit = fit;
    while let Some((next, entered)) = course.entry(&working, &fit) {
        let name = |place: Option<&usize>| place.and_then(|&place| design.names().get(place)).map_or("", String::as_str);
        let collapsed = course.watch.collapse(&course.steps, &fit, &entered, name(next.places.first()));
        if let (Some(collapse), None) = (collapsed, &course.collapse) {
            course.refused.extend(next.places.iter().map(|&place| Refused { place, reason: Reason::Collapse }));
            course.kept = Some(collapse.kept);
            course.collapse = Some(collapse);
            if !rules.beyond {
                break;
            }
        }
        if let [first, _] = next.places[..] {
            let mut between = working.clone();
            let _ = between.enter(first);
            course.steps.push(step(Change::Entered(first), &between.fit(rules.colour)?));
        }
        working = next.working;
        fit = entered;
        let last = next.places.last().copied().unwrap_or_default();
        course.steps.push(step(Change::Entered(last), &fit));
        course.watch.see(&fit);
        while let Some(place) = course.weakest(design, &fit) {
            working.leave(place);
            fit = working.fit(rules.colour)?;
            course.left[place] = Some(course.steps.len());
            course.steps.push(step(Change::Left(place), &fit));
            course.watch.see(&fit);
        }
    }
    course.ended(design)
}

fn step(change: Change, fit: &Fit) -> Step {
    Step { change, terms: fit.terms.clone(), quality: fit.quality }
}

/// Candidates that may enter, one or a pair, and the sums with them in.
struct Entry<'a> {
    places: Vec<usize>,
    working: Working<'a>,
}

/// The selection under way.
struct Course<'a> {
    rules: &'a Rules,
    watch: Watch,
    steps: Vec<Step>,
    /// Step at which a candidate left.
    left: Vec<Option<usize>>,
    /// Of the last round.
    refused: Vec<Refused>,
    /// The step before the collapse.
    kept: Option<usize>,
    collapse: Option<Collapse>,
}

impl Course<'_> {
    /// The next candidate in, and the fit with it.
    fn entry<'a>(&mut self, working: &Working<'a>, now: &Fit) -> Option<(Entry<'a>, Fit)> {
        if self.collapse.is_none() {
            self.refused.clear();
        }
        if working.inside.len() >= self.rules.terms_max {
            return None;
        }
        let mut open: Vec<(usize, f64)> = (0..self.left.len())
            .filter(|&place| self.left[place].is_none() && working.may_enter(place))
            .map(|place| (place, working.gain(place)))
            .collect();
        open.sort_by(|(_, a), (_, b)| b.total_cmp(a));
        for &(place, gain) in &open {
            match self.tried(working, now, &[place], gain) {
                Ok(found) => return Some(found),
                Err(reason) if self.collapse.is_none() => self.refused.push(Refused { place, reason }),
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

    fn tried<'a>(&self, working: &Working<'a>, now: &Fit, places: &[usize], gain: f64) -> Result<(Entry<'a>, Fit), Reason> {
        if !(gain > self.rules.r_squared_rise) {
            return Err(Reason::Rise(gain));
        }
        if self.rules.predicts && working.pse_with(places.len(), gain) >= working.pse_with(0, 0.0) {
            return Err(Reason::Predicts);
        }
        let mut with = working.clone();
        let mut explained = 0.0;
        for &place in places {
            explained = with.explained(place);
            if !with.enter(place) {
                return Err(Reason::Explained(explained));
            }
        }
        let Ok(fit) = with.fit(self.rules.colour) else { return Err(Reason::Explained(explained)) };
        let entered = fit.terms.iter().rev().take(places.len());
        let f = entered.map(|term| self.rules.f(term)).fold(f64::INFINITY, f64::min);
        if !(f > self.rules.f_enter) {
            return Err(Reason::PartialF(f));
        }
        if self.rules.predicts && fit.quality.press >= now.quality.press {
            return Err(Reason::Predicts);
        }
        Ok((Entry { places: places.to_vec(), working: with }, fit))
    }

    /// The term with the smallest partial F, where that is below `f_remove` and it may leave.
    fn weakest(&self, design: &Design, fit: &Fit) -> Option<usize> {
        let may = |term: &&Term| design.candidates()[term.place].role != Role::Kept && self.rules.f(term) < self.rules.f_remove;
        let weakest = fit.terms.iter().filter(may).min_by(|a, b| self.rules.f(a).total_cmp(&self.rules.f(b)));
        weakest.map(|term| term.place)
    }

    fn ended(self, design: &Design) -> Result<Selection, FitError> {
        let kept = self.kept.unwrap_or(self.steps.len() - 1);
        let places: Vec<usize> = self.steps[kept].terms.iter().map(|term| term.place).collect();
        let fit = Fit::of(design, &places, self.rules.colour)?;
        let working = Working::new(design);
        let reason = |place: usize| {
            let told = self.refused.iter().find(|refused| refused.place == place).map(|refused| refused.reason.clone());
            if !(design.scale[place] > 0.0) {
                return Reason::Still;
            }
            let left = self.left[place].filter(|&step| step <= kept).map(Reason::Left);
            told.or(left).unwrap_or(Reason::Ended)
        };
        let mut with = working;
        for &place in &places {
            let _ = with.enter(place);
        }
        let refused = (0..design.names().len()).filter(|place| !places.contains(place)).map(|place| {
            let reason = match reason(place) {
                Reason::Ended if !with.may_enter(place) => Reason::Explained(with.explained(place)),
                reason => reason,
            };
            Refused { place, reason }
        });
        Ok(Selection { refused: refused.collect(), kept, fit, collapse: self.collapse, steps: self.steps })
    }
}

impl fmt::Display for Reason {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Reason::Still => f.write_str("does not move"),
            Reason::Explained(part) => write!(f, "is a combination of the terms in ({:.4} of its variance)", part),
            Reason::Rise(rise) => write!(f, "R2 would rise by {:.3} % only", 100.0 * rise),
            Reason::PartialF(partial) => write!(f, "its partial F would be {partial:.1} only"),
            Reason::Predicts => f.write_str("the predicted error (PSE or PRESS) would not fall"),
            Reason::Left(step) => write!(f, "its partial F fell and it left at step {step}"),
            Reason::Collapse => f.write_str("the partial F of primary terms collapsed with it"),
            Reason::Ended => f.write_str("was not tried: the selection had ended"),
        }
    }
}
