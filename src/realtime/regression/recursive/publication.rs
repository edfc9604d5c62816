//! The fit of an equation as it is published: which terms have numbers, and whether these have settled.
//!
//! Consumes a fit and what was offered to it; produces an [`EquationRecord`] without the terms that the data do not tell, and its
//! status.

use super::Recursive;
use crate::flight::derivative::{Axis, Variable};
use crate::num::eigen::condition_index;
use crate::realtime::estimation::record::Instrumentation;
use crate::realtime::regression::candidate::{self, BIAS, is_primary, regressor, response};
use crate::realtime::regression::record::{EquationRecord, Reason, Status, TermRecord};
use crate::realtime::regression::stepwise::{Fit, Offer};
use crate::realtime::regression::{coloured_errors, endogeneity};

/// Independent samples for each term before an equation has converged.
const SETTLED_PER_TERM: f64 = 2.0;
/// Deviation of a control in a test input, rad.
const TEST_INPUT_RAD: f64 = 0.01;
/// Standard error of a term, as part of the response's deviation, above which a term that is not known from zero has no number.
const SMALL_CONTRIBUTION: f64 = 0.1;

/// Standard errors from zero at which L_p is known well enough for L_v and L_r: of 2,028 readings of L_r that were beyond four
/// standard errors, of helicopters after pedal alone, 1,676 stood beside an L_p that was not, or had no number.
const DAMPING_KNOWN: f64 = 2.0;

impl Recursive {
    /// Whether the data tell the term: from zero, or that it hardly matters. A control that hardly moved did little whatever its
    /// derivative, so it counts as moved by a test input.
    pub(super) fn is_resolved(&self, axis: Axis, place: usize, value: f64, std: f64) -> bool {
        let is_control = candidate::variable(place).is_some_and(Variable::is_control);
        let moved = self.information.deviation(place).max(if is_control { TEST_INPUT_RAD } else { 0.0 });
        let contribution = std * moved / self.information.deviation(response(axis));
        place == BIAS || std < value.abs() || contribution < SMALL_CONTRIBUTION
    }

    /// The fit as a record, without the terms that are not resolved; the status is still to come.
    pub(super) fn written(
        &self,
        axis: Axis,
        fit: &Fit,
        offer: &Offer,
        residual_var: f64,
        instruments: &Instrumentation,
    ) -> EquationRecord {
        let withheld = self.withheld(axis, instruments);
        let information = &self.information;
        let parameters = fit.order.len();
        let cov_white = coloured_errors::white_covariance(information, &fit.dispersion, residual_var);
        let samples = information.effective_samples();
        let r_squared = if fit.response_squares > 0.0 { 1.0 - fit.squares / fit.response_squares } else { 0.0 };
        let mut equation = EquationRecord::empty(axis, Status::Converging);
        equation.r_squared = r_squared;
        // (21) of Padfield et al. 1987: p parameters, the bias among them, on m samples.
        equation.f_total = r_squared / (parameters as f64 - 1.0) * (samples - parameters as f64) / (1.0 - r_squared);
        equation.samples = samples;
        equation.residual_std = libm::sqrt(residual_var);
        equation.condition_index = condition_index(information.sums(), &fit.order);
        for (step, &place) in fit.order.iter().enumerate() {
            let (variable, value) = (candidate::variable(place), fit.theta[place]);
            let hidden = variable.map_or(0.0, |variable| self.hidden_error(axis, variable, value));
            let term = TermRecord {
                variable,
                value,
                std: libm::hypot(libm::sqrt(fit.cov[place][place]), hidden),
                std_white: libm::sqrt(cov_white[place][place]),
                step: step as u8,
                primary: offer.primary[place],
                frequency: None,
            };
            match term.variable {
                Some(variable) if withheld[place] || !self.is_resolved(axis, place, term.value, term.std) => {
                    equation.unresolved |= 1 << variable.index();
                }
                _ => {
                    let _ = equation.terms.push(term);
                }
            }
        }
        withhold_followers(&mut equation, offer.follows);
        equation
    }

    /// Whether the equation's numbers have settled.
    pub(super) fn status(&mut self, equation: &EquationRecord, time_s: f64) -> Status {
        if !equation.terms.iter().all(|term| term.value.is_finite() && term.std.is_finite()) {
            return Status::NotIdentifiable(Reason::Collinear { condition_index: equation.condition_index });
        }
        let settled = self.settling[equation.axis.index()].step(time_s, equation);
        if self.quiet_s + self.silent_s > self.config.stale_s {
            return Status::Stale;
        }
        let deviation = self.information.deviation(response(equation.axis));
        let known = equation.terms.iter().filter(|term| term.primary).all(|term| {
            let Some(variable) = term.variable else { return true };
            let contribution = term.std * self.information.deviation(regressor(variable)) / deviation;
            term.std < self.config.known_relative * term.value.abs() || contribution < self.config.known_contribution
        });
        // What the equation is about has to be among it: terms of other motion alone absorb whatever was left out.
        let about = equation.terms.iter().any(|term| term.primary && term.std < self.config.known_relative * term.value.abs());
        let resolved = equation.unresolved_variables().all(|variable| !is_primary(equation.axis, variable));
        let independent = endogeneity::independent_samples(equation.samples, self.interval_s);
        let enough = independent >= SETTLED_PER_TERM * equation.terms.len() as f64;
        if settled && known && about && resolved && enough { Status::Converged } else { Status::Converging }
    }
}

/// Takes L_v and L_r out where L_p is not known: a fast roll mode follows v and r, and they then have part of what p does. In a
/// plane that follows the other one, everything of L: there the roll rate of a helicopter after its collective is a combination
/// of all the other motions.
fn withhold_followers(equation: &mut EquationRecord, follows: bool) {
    let is_known = |term: &TermRecord| term.value.abs() > DAMPING_KNOWN * term.std;
    if equation.axis != Axis::L || equation.term(Variable::P).is_some_and(is_known) {
        return;
    }
    for variable in Variable::ALL.into_iter().filter(|variable| follows || matches!(variable, Variable::V | Variable::R)) {
        if equation.term(variable).is_some() {
            equation.terms.retain(|term| term.variable != Some(variable));
            equation.unresolved |= 1 << variable.index();
        }
    }
}
