//! Candidate terms by name: products of columns of a table.
//!
//! Consumes a text; produces a product of up to three factors, evaluated row by row:
//!     term   = factor | factor*factor | factor*factor*factor                                          (1)
//!     factor = name | |name| | name^n | spline(name,knot) | spline(name,knot,order)                    (2)
//! with n and order from 1 to 9, and the one-sided spline (x - knot)^order where x > knot, else 0        (3)
//! (order 1, a change of slope, where none is given; 3 is the cubic one). `v*|v|` and `v^3` of the nonlinear library are such
//! terms. Factors are kept in alphabetical order and powers of one column joined, so that two spellings are one term:
//! `v*p` is `p*v`, `v*v` is `v^2`. Unit: the product of the factors' units.
//! Source of (3): V. Klein and J. G. Batterson, NASA TP-2200, 1983.

use crate::flight::channel::ControlNames;
use crate::flight::derivative::Variable;
use crate::flight::term::Term;
use std::fmt;

/// Largest number of factors of a product.
const FACTORS: usize = 3;

const POWER_MAX: u8 = 9;

/// One factor, (2).
#[derive(Clone, Debug, PartialEq)]
enum Factor {
    /// A power of a column, the column itself with power 1.
    Power { column: String, power: u8 },
    /// The size of a column.
    Size { column: String },
    /// The one-sided spline (3).
    Spline { column: String, knot: f64, order: u8 },
}

/// A candidate term, (1).
#[derive(Clone, Debug, PartialEq)]
pub struct Expression {
    factors: Vec<Factor>,
}

/// Why a text is not a term.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("term \"{term}\": expected {expected}, found {found}")]
pub struct ExpressionError {
    /// The whole text.
    pub term: String,
    /// Syntax that was expected.
    pub expected: String,
    /// Text in its place.
    pub found: String,
}

/// A term that needs a column which the table does not have.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{}: no column `{column}`; the table has {}", wanting(.term.as_deref()), .columns.join(" "))]
pub struct UnknownColumn {
    /// The term; `None` for the response.
    pub term: Option<String>,
    /// The missing column.
    pub column: String,
    /// Columns of the table.
    pub columns: Vec<String>,
}

fn wanting(term: Option<&str>) -> String {
    term.map_or_else(|| "response".to_owned(), |term| format!("term \"{term}\""))
}

impl Expression {
    /// The term of that name.
    ///
    /// # Errors
    /// [`ExpressionError`] with what was expected and found.
    pub fn parse(text: &str) -> Result<Expression, ExpressionError> {
        let wrong = |expected: &str, found: &str| ExpressionError {
            term: text.into(),
            expected: expected.into(),
            found: if found.is_empty() { "nothing".into() } else { format!("\"{found}\"") },
        };
        let mut factors = Vec::new();
        for part in text.split('*') {
            factors.push(factor(part.trim()).map_err(|expected| wrong(expected, part.trim()))?);
        }
        if factors.len() > FACTORS {
            return Err(wrong("a product of at most three factors", text));
        }
        Ok(Expression { factors: joined(factors) })
    }

    /// The columns that the term needs.
    pub fn columns(&self) -> impl Iterator<Item = &str> {
        self.factors.iter().map(Factor::column)
    }

    /// Whether it is a single column.
    pub fn is_linear(&self) -> bool {
        matches!(self.factors.as_slice(), [Factor::Power { power: 1, .. }])
    }

    /// The same as a [`Term`] of a model file; `None` where there is none.
    pub fn term(&self) -> Option<Term> {
        match self.factors.as_slice() {
            [Factor::Power { column, power: 2 }] => {
                let variable = Variable::from_name(column).filter(|variable| !variable.is_control())?;
                Some(Term::Product(variable, variable))
            }
            _ => Term::from_name(&self.to_string()).ok(),
        }
    }

    /// Values at each row, from the columns that `find` returns, each of `rows` entries.
    ///
    /// # Errors
    /// The name of the first column that `find` does not have.
    pub fn values<'a>(&self, rows: usize, find: impl Fn(&str) -> Option<&'a [f64]>) -> Result<Vec<f64>, String> {
        let mut values = vec![1.0; rows];
        for factor in &self.factors {
            let column = find(factor.column()).ok_or_else(|| factor.column().to_owned())?;
            for (value, &x) in values.iter_mut().zip(column) {
                *value *= factor.value(x);
            }
        }
        Ok(values)
    }
}

impl From<Term> for Expression {
    fn from(term: Term) -> Self {
        Expression::named(term, ControlNames::default())
    }
}

impl Expression {
    /// A [`Term`] of a model file, with the aircraft's names of the controls.
    pub fn named(term: Term, controls: ControlNames) -> Self {
        let power = |variable: Variable, power| Factor::Power { column: variable.name(controls).into(), power };
        let factors = match term {
            Term::Linear(x) => vec![power(x, 1)],
            Term::SignedSquare(x) => vec![power(x, 1), Factor::Size { column: x.name(controls).into() }],
            Term::Cube(x) => vec![power(x, 3)],
            Term::Product(x, y) => vec![power(x, 1), power(y, 1)],
        };
        Expression { factors: joined(factors) }
    }
}

impl Factor {
    fn column(&self) -> &str {
        match self {
            Factor::Power { column, .. } | Factor::Size { column } | Factor::Spline { column, .. } => column,
        }
    }

    fn value(&self, x: f64) -> f64 {
        match *self {
            Factor::Power { power, .. } => raised(x, power),
            Factor::Size { .. } => libm::fabs(x),
            Factor::Spline { knot, order, .. } if x > knot => raised(x - knot, order),
            // NaN stays NaN, which the comparison alone would turn into zero.
            Factor::Spline { .. } => 0.0 * x,
        }
    }

    /// Place in a product: by column, powers before sizes before splines.
    fn place(&self) -> (&str, u8) {
        let kind = match self {
            Factor::Power { .. } => 0,
            Factor::Size { .. } => 1,
            Factor::Spline { .. } => 2,
        };
        (self.column(), kind)
    }
}

fn raised(x: f64, power: u8) -> f64 {
    (1..power).fold(x, |product, _| product * x)
}

/// In order, with powers of one column joined.
fn joined(mut factors: Vec<Factor>) -> Vec<Factor> {
    factors.sort_by(|a, b| a.place().cmp(&b.place()));
    let mut out: Vec<Factor> = Vec::new();
    for factor in factors {
        if let (Some(Factor::Power { column, power }), Factor::Power { column: same, power: more }) = (out.last_mut(), &factor)
            && column == same
        {
            *power += more;
            continue;
        }
        out.push(factor);
    }
    out
}

/// One factor, or what was expected of it.
fn factor(text: &str) -> Result<Factor, &'static str> {
    if let Some(inside) = text.strip_prefix("spline(") {
        let inside = inside.strip_suffix(')').ok_or("`)` after spline(name,knot")?;
        let mut parts = inside.split(',').map(str::trim);
        let column = name(parts.next().unwrap_or(""))?;
        let knot: f64 = parts.next().and_then(|knot| knot.parse().ok()).ok_or("a knot that is a number: spline(name,knot)")?;
        if !knot.is_finite() {
            return Err("a finite knot");
        }
        let order = match parts.next() {
            None => 1,
            Some(order) => exponent(order).ok_or("a spline's order from 1 to 9")?,
        };
        return if parts.next().is_some() {
            Err("spline(name,knot,order) and no more")
        } else {
            Ok(Factor::Spline { column, knot, order })
        };
    }
    if let Some(inside) = text.strip_prefix('|') {
        let inside = inside.strip_suffix('|').ok_or("`|` after the name")?;
        return Ok(Factor::Size { column: name(inside)? });
    }
    match text.split_once('^') {
        None => Ok(Factor::Power { column: name(text)?, power: 1 }),
        Some((base, power)) => {
            Ok(Factor::Power { column: name(base)?, power: exponent(power).ok_or("a whole power from 1 to 9")? })
        }
    }
}

fn exponent(text: &str) -> Option<u8> {
    text.parse().ok().filter(|power| (1..=POWER_MAX).contains(power))
}

fn name(text: &str) -> Result<String, &'static str> {
    let first_is_letter = text.chars().next().is_some_and(|c| c.is_alphabetic() || c == '_');
    if first_is_letter && text.chars().all(|c| c.is_alphanumeric() || "_.'".contains(c)) {
        Ok(text.to_owned())
    } else {
        Err("a column's name, |name|, name^n or spline(name,knot)")
    }
}

impl fmt::Display for Factor {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Factor::Power { column, power: 1 } => f.write_str(column),
            Factor::Power { column, power } => write!(f, "{column}^{power}"),
            Factor::Size { column } => write!(f, "|{column}|"),
            Factor::Spline { column, knot, order: 1 } => write!(f, "spline({column},{knot})"),
            Factor::Spline { column, knot, order } => write!(f, "spline({column},{knot},{order})"),
        }
    }
}

impl fmt::Display for Expression {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (place, factor) in self.factors.iter().enumerate() {
            if place > 0 {
                f.write_str("*")?;
            }
            factor.fmt(f)?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn value(text: &str, alpha: f64, v: f64) -> f64 {
        let (alpha, v) = ([alpha], [v]);
        let find = |name: &str| match name {
            "alpha" => Some(&alpha[..]),
            "v" => Some(&v[..]),
            _ => None,
        };
        Expression::parse(text).unwrap().values(1, find).unwrap()[0]
    }

    #[test]
    fn values_are_those_computed_by_hand() {
        for (text, expected) in [
            ("alpha", 0.3),
            ("v*|v|", -4.0),
            ("v^3", -8.0),
            ("alpha*v*v", 1.2),
            ("spline(alpha,0.1)", 0.2),
            ("spline(alpha,0.1,3)", 0.008),
            ("spline(alpha, 0.4)*v", 0.0),
            ("v*spline(alpha,-0.2,2)", -0.5),
        ] {
            assert!((value(text, 0.3, -2.0) - expected).abs() < 1e-12, "{text}: {}", value(text, 0.3, -2.0));
        }
        assert!(value("spline(alpha,0.1)", f64::NAN, 0.0).is_nan(), "what was not sampled is not made up");
    }

    #[test]
    fn two_spellings_are_one_term() {
        for (text, name) in [("v*p", "p*v"), ("|v|*v", "v*|v|"), ("v*v", "v^2"), ("v*v^2", "v^3"), ("qhat * alpha", "alpha*qhat")]
        {
            assert_eq!(Expression::parse(text).unwrap().to_string(), name);
            assert_eq!(Expression::parse(text).unwrap(), Expression::parse(name).unwrap());
        }
    }

    #[test]
    fn the_library_of_the_models_comes_back() {
        for term in Term::library().chain(Variable::ALL.into_iter().map(Term::Linear)) {
            let expression = Expression::parse(&term.to_string()).unwrap();
            assert_eq!(expression, Expression::from(term), "{term}");
            assert_eq!(expression.term(), Some(term));
        }
        assert_eq!(Expression::parse("v*v").unwrap().term(), Some(Term::Product(Variable::V, Variable::V)));
        assert_eq!(Expression::parse("alpha^2").unwrap().term(), None);
    }

    #[test]
    fn what_is_no_term_is_told_with_what_was_expected() {
        for (text, expected) in [
            ("", "a column's name"),
            ("alpha*", "a column's name"),
            ("2*alpha", "a column's name"),
            ("alpha^0", "power from 1 to 9"),
            ("alpha^x", "power from 1 to 9"),
            ("|v", "`|`"),
            ("spline(alpha)", "a knot"),
            ("spline(alpha,nan)", "a finite knot"),
            ("spline(alpha,1,0)", "order"),
            ("spline(alpha,1,3,4)", "no more"),
            ("spline(alpha,1", "`)`"),
            ("a*b*c*d", "at most three"),
        ] {
            let error = Expression::parse(text).unwrap_err();
            assert!(error.to_string().contains(expected), "{error}");
        }
        let find = |_: &str| None;
        assert_eq!(Expression::parse("alpha*beta").unwrap().values(1, find), Err("alpha".into()));
    }
}
