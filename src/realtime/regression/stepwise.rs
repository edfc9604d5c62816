//! Stepwise regression on the information matrix: the terms of an equation, and its least squares.
//!
//! Consumes an information matrix, the response and the terms that are offered; produces a [`Fit`].
//!     theta = (X'X)^-1 X'y                                                                           (1)
//!     F_i = theta_i^2/s_i^2                                       s_i for coloured residuals        (2)
//! Primary terms enter first, the one with the largest partial F ahead; then, one a step, the term with the largest partial F
//! (the highest partial correlation with the residual) whose corrected F exceeds `f_enter`; after each entry terms that are not
//! primary and have fallen below `f_remove` leave, and stay out. A second pass enters all the others at once and removes the
//! insignificant ones, for terms that are significant only together. Last, terms leave that fall below `f_remove` on their final
//! standard errors. What the terms left out may hide is added to the covariance: `omitted`.
//! Source: Padfield et al. 1987, (18), (22) and section 2.2.5; N. R. Draper and H. Smith, Applied Regression Analysis, 3rd ed.,
//! ch. 15.
//! Numerics: sums scaled to unit diagonal, pivots below `PIVOT_MIN` refused: such a term is collinear with those in.

mod omitted;

use super::candidate::Coefficients;
use super::candidate::{BIAS, REGRESSORS, SIGNALS};
use super::information::Information;
use crate::num::sweep::Swept;
use crate::realtime::regression::coloured_errors;
use heapless::Vec;

/// Pivot below which a regressor counts as a combination of those in.
const PIVOT_MIN: f64 = 1e-9;

/// The same for terms that enter together: condition indexes stay in the tens.
const PIVOT_SECOND: f64 = 1e-4;

/// Thresholds of entry and removal, on the corrected partial F.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Thresholds {
    /// A term enters above this.
    pub f_enter: f64,
    /// A term leaves below this.
    pub f_remove: f64,
}

/// Which terms are offered, by place in z.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Offer {
    /// Terms that stay whatever their F.
    pub primary: [bool; REGRESSORS],
    /// Terms that have to earn their place.
    pub optional: [bool; REGRESSORS],
    /// Terms of which, left out, at least the standard error counts: those that belong to the equation and hardly moved,
    /// motions of the other plane, and all those of a plane that follows the other.
    pub undetermined: [bool; REGRESSORS],
    /// Motions of the fast modes (all but u) that belong to the equation, whether they moved or not.
    pub belongs: [bool; REGRESSORS],
    /// Whether no input moved the equation's own plane of motion.
    pub follows: bool,
    /// Variances of the noise on the regressors.
    pub noise_vars: [f64; REGRESSORS],
}

impl Offer {
    /// Nothing but the bias.
    pub const NONE: Offer = Offer {
        primary: [false; REGRESSORS],
        optional: [false; REGRESSORS],
        undetermined: [false; REGRESSORS],
        belongs: [false; REGRESSORS],
        follows: false,
        noise_vars: [0.0; REGRESSORS],
    };
}

/// A fitted equation.
#[derive(Clone, Debug)]
pub struct Fit {
    /// Places of its terms in the order of entry, the bias first.
    pub order: Vec<usize, REGRESSORS>,
    /// Estimates by place; zero where a term is not in.
    pub theta: [f64; REGRESSORS],
    /// (X'X)^-1 by place; zero where a term is not in.
    pub dispersion: [[f64; REGRESSORS]; REGRESSORS],
    /// Covariance of the estimates by place, corrected for coloured residuals and for what was left out.
    pub cov: [[f64; REGRESSORS]; REGRESSORS],
    /// Variance of the bias of least squares, by place, where the disturbance may move the aircraft.
    pub bias_var: [f64; REGRESSORS],
    /// Part of the variance of every estimate that curvature of the forces and moments accounts for.
    pub curvature_var: [f64; REGRESSORS],
    /// The residual over z.
    pub residual: Coefficients,
    /// Weighted sum of squared residuals.
    pub squares: f64,
    /// Weighted sum of squares of the response about its mean.
    pub response_squares: f64,
}

/// The selection at work: scaled sums under sweeping.
struct SweptSelection<'a> {
    information: &'a Information<SIGNALS>,
    swept: Swept<SIGNALS>,
    /// Square roots of the original diagonal.
    scale: [f64; SIGNALS],
    response: usize,
    order: Vec<usize, REGRESSORS>,
    /// Terms that left: they stay out, so that the selection ends.
    left: [bool; REGRESSORS],
}

/// Selects terms for the response at that place of z and fits them; `None` where there are not yet more samples than terms.
pub fn fit(information: &Information<SIGNALS>, response: usize, offer: &Offer, thresholds: &Thresholds) -> Option<Fit> {
    let mut selection = SweptSelection::new(information, response)?;
    while let Some(best) = selection.largest(&offer.primary) {
        if !selection.enter(best) {
            break;
        }
    }
    let mut open = offer.optional;
    while let Some(best) = selection.largest(&open) {
        if selection.partial_f(best) < thresholds.f_enter {
            break;
        }
        open[best] = false;
        if selection.corrected_f_of_entry(best) > thresholds.f_enter && selection.enter(best) {
            // The residual is another one now: what was refused before may be asked again.
            open = core::array::from_fn(|place| offer.optional[place] && !selection.left[place]);
            while let Some(worst) = selection.smallest(offer, thresholds.f_remove) {
                if !selection.leave(worst) {
                    break;
                }
                open[worst] = false;
            }
        }
    }
    let mut selection = selection.second_look(offer, thresholds);
    let mut fit = selection.finish();
    while let Some(worst) = fit.weakest(offer, thresholds.f_remove)
        && selection.leave(worst)
    {
        fit = selection.finish();
    }
    selection.add_omitted(&mut fit, offer);
    Some(fit)
}

impl Fit {
    /// Multiplies the covariance of the estimates by `factor`.
    pub fn scale_covariance(&mut self, factor: f64) {
        self.cov.iter_mut().flatten().for_each(|entry| *entry *= factor);
    }

    /// Adds to the covariance d d', d the differences of the estimates by place.
    fn add_shift(&mut self, shift: impl Fn(usize) -> f64) {
        let mut by_place = [0.0; REGRESSORS];
        for &i in &self.order {
            by_place[i] = shift(i);
        }
        for &i in &self.order {
            for &j in &self.order {
                self.cov[i][j] += by_place[i] * by_place[j];
            }
        }
    }

    /// The optional term with the smallest F on its final standard error, where that is below `f_remove`.
    fn weakest(&self, offer: &Offer, f_remove: f64) -> Option<usize> {
        let mut worst: Option<(usize, f64)> = None;
        for &place in self.order.iter().filter(|&&place| place != BIAS && !offer.primary[place]) {
            let f = self.theta[place] * self.theta[place] / self.cov[place][place];
            if f < f_remove && worst.is_none_or(|(_, smallest)| f < smallest) {
                worst = Some((place, f));
            }
        }
        worst.map(|(place, _)| place)
    }
}

impl<'a> SweptSelection<'a> {
    fn new(information: &'a Information<SIGNALS>, response: usize) -> Option<Self> {
        if !(information.effective_samples() > REGRESSORS as f64 + 2.0) {
            return None;
        }
        let sums = information.sums();
        let scale: [f64; SIGNALS] = core::array::from_fn(|i| libm::sqrt(sums[i][i]));
        let scaled = core::array::from_fn(|i| {
            core::array::from_fn(|j| {
                let both = scale[i] * scale[j];
                if both > 0.0 { sums[i][j] / both } else { 0.0 }
            })
        });
        let mut selection = SweptSelection {
            information,
            swept: Swept::new(scaled),
            scale,
            response,
            order: Vec::new(),
            left: [false; REGRESSORS],
        };
        selection.enter(BIAS).then_some(selection)
    }

    fn enter(&mut self, place: usize) -> bool {
        let entered = self.swept.enter(place, PIVOT_MIN);
        // A place enters at most once at a time, so the list has room.
        entered && self.order.push(place).is_ok()
    }

    fn leave(&mut self, place: usize) -> bool {
        self.order.retain(|&other| other != place);
        self.left[place] = true;
        self.swept.remove(place)
    }

    /// Partial F that the term would enter with, for white residuals.
    fn partial_f(&self, place: usize) -> f64 {
        let (pivot, product) = (self.swept.at(place, place), self.swept.at(place, self.response));
        let drop = product * product / pivot;
        let left = self.swept.at(self.response, self.response) - drop;
        let freedom = self.information.effective_samples() - (self.order.len() + 1) as f64;
        if left > 0.0 { drop / left * freedom } else { f64::INFINITY }
    }

    /// The term among `open`, not yet in and not a combination of those in, with the largest partial F.
    fn largest(&self, open: &[bool; REGRESSORS]) -> Option<usize> {
        let mut best: Option<(usize, f64)> = None;
        for (place, &is_open) in open.iter().enumerate() {
            if !is_open || self.swept.is_inside(place) || !(self.swept.at(place, place) > PIVOT_MIN) {
                continue;
            }
            let f = self.partial_f(place);
            if best.is_none_or(|(_, largest)| f > largest) {
                best = Some((place, f));
            }
        }
        best.map(|(place, _)| place)
    }

    /// The residual over z with the terms that are in.
    fn residual(&self) -> Coefficients {
        let mut residual = [0.0; SIGNALS];
        residual[self.response] = 1.0;
        for &place in &self.order {
            residual[place] = -self.theta(place);
        }
        residual
    }

    fn theta(&self, place: usize) -> f64 {
        self.swept.at(place, self.response) * self.scale[self.response] / self.scale[place]
    }

    /// Partial F on the corrected standard error that the term would have once in.
    fn corrected_f_of_entry(&self, place: usize) -> f64 {
        // The regressor after regression on those in, and its own estimate.
        let mut direction = [0.0; SIGNALS];
        direction[place] = 1.0;
        for &other in &self.order {
            direction[other] = -self.swept.at(other, place) * self.scale[place] / self.scale[other];
        }
        let squares = self.swept.at(place, place) * self.scale[place] * self.scale[place];
        let theta =
            self.swept.at(place, self.response) / self.swept.at(place, place) * self.scale[self.response] / self.scale[place];
        let mut residual = self.residual();
        for (r, d) in residual.iter_mut().zip(&direction) {
            *r -= theta * d;
        }
        let covariance = coloured_errors::residual_covariance(self.information, &residual, &residual, self.order.len() + 1);
        theta * theta / coloured_errors::variance(self.information, &direction, squares, &covariance)
    }

    /// The term that is not primary and has the smallest corrected F, where that is below `f_remove`.
    fn smallest(&self, offer: &Offer, f_remove: f64) -> Option<usize> {
        let residual = self.residual();
        let covariance = coloured_errors::residual_covariance(self.information, &residual, &residual, self.order.len());
        let middle = coloured_errors::middle(self.information, &self.order, &covariance);
        let mut worst: Option<(usize, f64)> = None;
        for &place in &self.order {
            if place == BIAS || offer.primary[place] {
                continue;
            }
            let mut dispersion = [0.0; REGRESSORS];
            for &other in &self.order {
                dispersion[other] = -self.swept.at(place, other) / (self.scale[place] * self.scale[other]);
            }
            let theta = self.theta(place);
            let f = theta * theta / coloured_errors::row_variance(&middle, &dispersion);
            if f < f_remove && worst.is_none_or(|(_, smallest)| f < smallest) {
                worst = Some((place, f));
            }
        }
        worst.map(|(place, _)| place)
    }

    /// Terms that matter only together are refused one by one: each alone leaves a residual that the other colours. So all
    /// that are still out enter at once, and those below `f_enter` leave again, the weakest first. What remains of them has
    /// earned its place beside everything else; where nothing does, the selection stands as it was.
    fn second_look(self, offer: &Offer, thresholds: &Thresholds) -> Self {
        let mut wider = SweptSelection { swept: self.swept.clone(), order: self.order.clone(), ..self };
        for place in 0..REGRESSORS {
            if offer.optional[place] && wider.swept.at(place, place) > PIVOT_SECOND {
                let _ = wider.enter(place);
            }
        }
        while let Some(worst) = wider.smallest(offer, thresholds.f_enter) {
            if !wider.leave(worst) {
                break;
            }
        }
        let gained = wider.order.iter().any(|place| !self.order.contains(place));
        if gained { wider } else { self }
    }

    /// The fit as the selection stands.
    fn finish(&self) -> Fit {
        let mut theta = [0.0; REGRESSORS];
        let mut dispersion = [[0.0; REGRESSORS]; REGRESSORS];
        for &i in &self.order {
            theta[i] = self.theta(i);
            for &j in &self.order {
                dispersion[i][j] = -self.swept.at(i, j) / (self.scale[i] * self.scale[j]);
            }
        }
        let sums = self.information.sums();
        let y = self.response;
        let residual = self.residual();
        Fit {
            cov: coloured_errors::equation_covariance(self.information, &self.order, &dispersion, &residual),
            bias_var: [0.0; REGRESSORS],
            curvature_var: [0.0; REGRESSORS],
            residual,
            theta,
            dispersion,
            squares: self.swept.at(y, y) * self.scale[y] * self.scale[y],
            response_squares: sums[y][y] - sums[BIAS][y] * sums[BIAS][y] / self.information.weight(),
            order: self.order.clone(),
        }
    }
}
