//! Default candidates of every axis, for helicopters and for fixed wing.
//!
//! Consumes the axis and how the controls are called; produces the linear terms in all motion and control variables, the
//! primary ones marked, and where asked for the nonlinear library `x*|x|`, `x^3`, `x*y` over `u v w p q r`.

use super::design::{Candidate, Role};
use super::expression::Expression;
use crate::flight::channel::ControlNames;
use crate::flight::derivative::{Axis, Variable};
use crate::flight::term::Term;
use crate::regression::candidate::is_primary;

/// Whether the term is one of the stiffness, damping and control terms of the axis.
fn primary(axis: Axis, variable: Variable, controls: ControlNames) -> bool {
    let unlike_rotor = controls == ControlNames::FixedWing
        && match axis {
            // The throttle lifts no wing and the elevator drives no aircraft.
            Axis::Z | Axis::M => variable == Variable::Collective,
            Axis::X => variable == Variable::LonCyclic,
            Axis::Y | Axis::L | Axis::N => false,
        };
    is_primary(axis, variable) && !unlike_rotor
}

/// The candidates of an axis; columns are called as in a run file.
pub fn default_set(axis: Axis, controls: ControlNames, nonlinear: bool) -> Vec<Candidate> {
    let linear = Variable::ALL.into_iter().map(|variable| Candidate {
        term: Expression::named(Term::Linear(variable), controls),
        role: if primary(axis, variable, controls) { Role::Primary } else { Role::Offered },
    });
    let library = Term::library().filter(|_| nonlinear);
    let library = library.map(|term| Candidate { term: Expression::named(term, controls), role: Role::Offered });
    linear.chain(library).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sets_are_those_of_the_aircraft() {
        let names = |candidates: &[Candidate], role: Role| -> Vec<String> {
            candidates.iter().filter(|c| c.role == role).map(|c| c.term.to_string()).collect()
        };
        let puma = default_set(Axis::N, ControlNames::Rotorcraft, false);
        assert_eq!(names(&puma, Role::Primary), ["v", "p", "r", "lat_cyclic", "pedal"]);
        assert_eq!(puma.len(), 10);
        let otter = default_set(Axis::M, ControlNames::FixedWing, true);
        assert_eq!(names(&otter, Role::Primary), ["u", "w", "q", "elevator"]);
        assert_eq!(otter.len(), 37);
        assert!(names(&otter, Role::Offered).contains(&"v*|v|".to_owned()));
    }
}
