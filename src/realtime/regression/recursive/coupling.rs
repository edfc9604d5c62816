//! Coupling: whether the motion of one plane follows from inputs to the other.
//!
//! Consumes the six equations; produces which planes were excited. A plane whose own controls no input has moved may be moved
//! by the other plane's input, or by the air. In the first case its equations have terms of the other plane (u w q and the
//! controls of the longitudinal, v p r and those of the lateral motion) that are known and contribute to the response,
//!     |theta| > `KNOWN` s,   |theta| dev(x) > `CONTRIBUTION` dev(y)                                (1)
//! (s the standard error, x the regressor, y the response). In the second the motion is that of gusts alone, and regressors that
//! gusts move are correlated with what gusts do to the response: least squares is biased, and light gusts hide in the noise.

use super::Recursive;
use crate::flight::derivative::{AXES, Axis};
use crate::realtime::regression::candidate::{regressor, response};
use crate::realtime::regression::record::{EquationRecord, TermRecord};

/// Standard errors of a term in (1).
const KNOWN: f64 = 4.0;
/// Part of the response's deviation that it contributes.
const CONTRIBUTION: f64 = 0.1;

impl Recursive {
    /// Whether the plane of the axis was excited by an input: to itself, or to the other plane.
    pub(super) fn is_plane_excited(&self, lateral: bool, equations: &[EquationRecord; AXES]) -> bool {
        self.excitation.response_s(lateral).is_some() || equations.iter().any(|equation| self.is_coupled(lateral, equation))
    }

    /// (1) for an equation of that plane.
    fn is_coupled(&self, lateral: bool, equation: &EquationRecord) -> bool {
        let axis: Axis = equation.axis;
        let contributes = |term: &TermRecord| {
            let Some(variable) = term.variable.filter(|variable| variable.is_lateral() != lateral) else { return false };
            let contribution = term.value.abs() * self.information.deviation(regressor(variable));
            term.value.abs() > KNOWN * term.std && contribution > CONTRIBUTION * self.information.deviation(response(axis))
        };
        axis.is_lateral() == lateral && equation.terms.iter().any(contributes)
    }
}
