//! Convergence: whether an equation's primary terms have stayed within their standard errors for long enough.
//!
//! Consumes the equation at each publication; produces yes or no. A reference is kept; where a primary term leaves two
//! standard errors around it, or the set of primary terms changes, the reference is taken anew and the clock starts again.

use super::record::EquationRecord;
use crate::flight::derivative::VARIABLES;

/// Standard errors within which an estimate counts as unmoved.
const SIGMAS: f64 = 2.0;

/// The reference and since when it holds.
#[derive(Clone, Copy, Debug)]
pub struct Settling {
    needed_s: f64,
    since_s: Option<f64>,
    reference: [f64; VARIABLES],
    inside: [bool; VARIABLES],
}

impl Settling {
    /// Settled after so long.
    pub const fn new(needed_s: f64) -> Self {
        Settling { needed_s, since_s: None, reference: [0.0; VARIABLES], inside: [false; VARIABLES] }
    }

    /// Takes the equation in; whether it has settled.
    pub fn step(&mut self, time_s: f64, equation: &EquationRecord) -> bool {
        let mut values = [0.0; VARIABLES];
        let mut inside = [false; VARIABLES];
        let mut moved = false;
        for term in equation.terms.iter().filter(|term| term.primary) {
            let Some(place) = term.variable.map(|variable| variable.index()) else { continue };
            values[place] = term.value;
            inside[place] = true;
            moved |= !((term.value - self.reference[place]).abs() <= SIGMAS * term.std);
        }
        if moved || inside != self.inside || self.since_s.is_none_or(|since_s| since_s > time_s) {
            self.reference = values;
            self.inside = inside;
            self.since_s = Some(time_s);
        }
        self.since_s.is_some_and(|since_s| time_s - since_s >= self.needed_s)
    }
}
