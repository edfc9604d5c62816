//! Candidate terms and stepwise rules of the paper, for tests of the structure of an equation.

use sideslip::flight::channel::ControlNames;
use sideslip::flight::derivative::{Axis, Variable};
use sideslip::flight::term::Term;
use sideslip::postflight::equation_error::design::{CandidateRole, CandidateTerm};
use sideslip::postflight::equation_error::expression::Expression;
use sideslip::postflight::equation_error::stepwise::StepwiseRules;
use sideslip::realtime::regression::candidate::is_primary;

/// The linear terms of a helicopter's axis in all motion and control variables, the axis' own ones as primary terms.
pub(crate) fn linear_candidates(axis: Axis) -> Vec<CandidateTerm> {
    let candidate = |variable: Variable| CandidateTerm {
        term: Expression::named(Term::Linear(variable), ControlNames::Rotorcraft),
        role: if is_primary(axis, variable) { CandidateRole::Primary } else { CandidateRole::Offered },
    };
    Variable::ALL.into_iter().map(candidate).collect()
}

/// Whatever has F above 1 for white residuals enters, and nothing leaves.
pub(crate) fn rules_of_the_paper() -> StepwiseRules {
    StepwiseRules {
        f_enter: 1.0,
        f_remove: 0.0,
        r_squared_rise: 0.0,
        predicts: false,
        corrected: false,
        beyond: true,
        pairs: false,
        ..StepwiseRules::for_candidates(1)
    }
}
