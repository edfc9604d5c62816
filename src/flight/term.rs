//! Regressor terms: on which quantities a force or moment may depend, by name and by value.
//!
//! Consumes deviations from trim by [`Variable`] place (m/s, rad/s, rad); produces a term's value.
//! Terms over the motion `u v w p q r`, written without spaces:
//!     `x`        any variable, controls too                                             (1)
//!     `x*|x|`    signed square                                                          (2)
//!     `x^3`      cube                                                                   (3)
//!     `x*y`      product, the two in alphabetical order (`p*v`, never `v*p`)            (4)
//! A square `x*x` is the product (4) of a variable with itself. Unit: that of the product of its factors.

use super::channel::ControlNames;
use super::derivative::{VARIABLES, Variable};
use core::fmt;

/// A regressor term.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Term {
    /// A variable itself, equation (1).
    Linear(Variable),
    /// `x*|x|`, equation (2).
    SignedSquare(Variable),
    /// `x^3`, equation (3).
    Cube(Variable),
    /// `x*y`, equation (4), in alphabetical order.
    Product(Variable, Variable),
}

/// Why a text is no term.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TermError {
    /// None of the four forms over known variables.
    Unknown,
    /// A product in the wrong order; the right one is carried.
    Order(Term),
    /// A nonlinear term over a control.
    OfControl(Variable),
}

impl fmt::Display for TermError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            TermError::Unknown => {
                f.write_str("expected a variable, or \"x*|x|\", \"x^3\" or \"x*y\" over u v w p q r without spaces")
            }
            TermError::Order(term) => write!(f, "factors stand in alphabetical order: \"{term}\""),
            TermError::OfControl(variable) => {
                write!(
                    f,
                    "a nonlinear term is over u v w p q r, not over a control ({})",
                    variable.name(ControlNames::Rotorcraft)
                )
            }
        }
    }
}

/// The motion's variables, which nonlinear terms are made of.
pub const MOTION: [Variable; 6] = [Variable::U, Variable::V, Variable::W, Variable::P, Variable::Q, Variable::R];

impl Term {
    /// The term of that name, controls in either naming.
    ///
    /// # Errors
    /// [`TermError`] where the text is no term, or not written as terms are.
    pub fn from_name(name: &str) -> Result<Term, TermError> {
        if let Some(variable) = Variable::from_name(name) {
            return Ok(Term::Linear(variable));
        }
        if let Some(base) = name.strip_suffix("^3") {
            return motion_variable(base).map(Term::Cube);
        }
        let (first, second) = name.split_once('*').ok_or(TermError::Unknown)?;
        let first = motion_variable(first)?;
        if let Some(inner) = second.strip_prefix('|').and_then(|rest| rest.strip_suffix('|')) {
            let inner = motion_variable(inner)?;
            return if inner == first { Ok(Term::SignedSquare(first)) } else { Err(TermError::Unknown) };
        }
        let second = motion_variable(second)?;
        if letter(first) <= letter(second) {
            Ok(Term::Product(first, second))
        } else {
            Err(TermError::Order(Term::Product(second, first)))
        }
    }

    /// The term's value for these deviations from trim.
    pub fn value(self, deviations: &[f64; VARIABLES]) -> f64 {
        let at = |variable: Variable| deviations[variable.index()];
        match self {
            Term::Linear(x) => at(x),
            Term::SignedSquare(x) => at(x) * libm::fabs(at(x)),
            Term::Cube(x) => at(x) * at(x) * at(x),
            Term::Product(x, y) => at(x) * at(y),
        }
    }

    /// Whether the term is nonlinear.
    pub const fn is_nonlinear(self) -> bool {
        !matches!(self, Term::Linear(_))
    }

    /// The name with controls after the aircraft's own naming.
    pub const fn named(self, controls: ControlNames) -> TermName {
        TermName { term: self, controls }
    }

    /// The nonlinear library: signed squares, cubes and products of two different variables; 27 terms.
    pub fn library() -> impl Iterator<Item = Term> {
        let squares = MOTION.into_iter().map(Term::SignedSquare);
        let cubes = MOTION.into_iter().map(Term::Cube);
        let products = MOTION
            .into_iter()
            .flat_map(|x| MOTION.into_iter().filter(move |&y| letter(x) < letter(y)).map(move |y| Term::Product(x, y)));
        squares.chain(cubes).chain(products)
    }
}

/// A term ready to be written, controls after one naming.
#[derive(Clone, Copy, Debug)]
pub struct TermName {
    term: Term,
    controls: ControlNames,
}

impl fmt::Display for TermName {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.term {
            Term::Linear(x) => f.write_str(x.name(self.controls)),
            Term::SignedSquare(x) => write!(f, "{0}*|{0}|", letter(x)),
            Term::Cube(x) => write!(f, "{}^3", letter(x)),
            Term::Product(x, y) => write!(f, "{}*{}", letter(x), letter(y)),
        }
    }
}

impl fmt::Display for Term {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.named(ControlNames::Rotorcraft).fmt(f)
    }
}

const fn letter(variable: Variable) -> &'static str {
    variable.name(ControlNames::Rotorcraft)
}

fn motion_variable(name: &str) -> Result<Variable, TermError> {
    match Variable::from_name(name) {
        Some(variable) if variable.is_control() => Err(TermError::OfControl(variable)),
        Some(variable) => Ok(variable),
        None => Err(TermError::Unknown),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_name_comes_back_and_the_library_has_no_double() {
        let all: Vec<Term> = Term::library().chain(Variable::ALL.into_iter().map(Term::Linear)).collect();
        assert_eq!(all.len(), 6 + 6 + 15 + 10);
        for (place, term) in all.iter().enumerate() {
            assert_eq!(Term::from_name(&term.to_string()), Ok(*term));
            assert!(!all[..place].contains(term), "{term} twice");
        }
        assert_eq!(Term::from_name("rudder"), Ok(Term::Linear(Variable::Pedal)));
        assert_eq!(Term::Linear(Variable::Pedal).named(ControlNames::FixedWing).to_string(), "rudder");
    }

    #[test]
    fn values_are_those_computed_by_hand() {
        let mut deviations = [0.0; VARIABLES];
        deviations[Variable::V.index()] = -3.0;
        deviations[Variable::P.index()] = 0.5;
        let value = |name: &str| Term::from_name(name).unwrap().value(&deviations);
        assert_eq!((value("v"), value("v*|v|"), value("v^3"), value("p*v"), value("v*v")), (-3.0, -9.0, -27.0, -1.5, 9.0));
    }

    #[test]
    fn what_is_not_written_as_terms_are_is_told() {
        assert_eq!(Term::from_name("v*p"), Err(TermError::Order(Term::Product(Variable::P, Variable::V))));
        assert_eq!(Term::from_name("p*pedal"), Err(TermError::OfControl(Variable::Pedal)));
        for wrong in ["", "v * |v|", "v*|p|", "v^2", "beta", "v*", "*v", "v*|v", "p*q*r"] {
            assert_eq!(Term::from_name(wrong), Err(TermError::Unknown), "{wrong}");
        }
    }
}
