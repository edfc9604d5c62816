//! The input that would separate terms that are collinear in these data, in words.
//!
//! Consumes the terms of a collinear group; produces one sentence, by the kinds of its terms: roll and yaw motion coupled by one
//! mode, a control that moves only with the response it causes, two controls that move together, a term and its own nonlinear
//! forms. Names are those of run files, in either naming of the controls; `beta` counts with v, `alpha` with w, `tas` with u,
//! `phat qhat rhat` with the rates.

use super::expression::Expression;
use crate::flight::derivative::Variable;
use std::collections::BTreeSet;

/// The variable that a column stands for.
fn variable(column: &str) -> Option<Variable> {
    match column {
        "beta" => Some(Variable::V),
        "alpha" => Some(Variable::W),
        "tas" => Some(Variable::U),
        "phat" => Some(Variable::P),
        "qhat" => Some(Variable::Q),
        "rhat" => Some(Variable::R),
        "tail_pitch" => Some(Variable::Pedal),
        other => Variable::from_name(other),
    }
}

/// The sentence for those terms.
pub(crate) fn input_that_splits(terms: &[&Expression]) -> String {
    use Variable::{P, Q, R, U, V, W};
    let columns: BTreeSet<&str> = terms.iter().flat_map(|term| term.columns()).collect();
    let listed = columns.iter().copied().collect::<Vec<_>>().join(", ");
    if columns.len() == 1 {
        return format!(
            "{listed} has to be flown at two amplitudes, one twice the other, both ways: \
             functions of one variable are distinguished by amplitude only"
        );
    }
    let linear: Vec<&str> = terms.iter().filter(|term| term.is_linear()).flat_map(|term| term.columns()).collect();
    if linear.len() < terms.len() {
        return format!(
            "{listed} have to move one without the other and at two amplitudes, one twice the other: \
             products and powers follow their factors here"
        );
    }
    let known: Vec<Variable> = linear.iter().filter_map(|column| variable(column)).collect();
    let has = |wanted: Variable| known.contains(&wanted);
    let controls: Vec<&str> =
        linear.iter().copied().filter(|column| variable(column).is_some_and(Variable::is_control)).collect();
    let motion: Vec<Variable> = known.iter().copied().filter(|variable| !variable.is_control()).collect();
    if known.len() < linear.len() {
        return format!("an input that moves one of {listed} while the others stay");
    }
    match controls.as_slice() {
        [first, second, ..] if motion.is_empty() => {
            return format!("{first} and {second} have to be moved one at a time, seconds apart");
        }
        [control, ..] => {
            return format!(
                "{control} moves only with the response that it causes: a 3211 of another clock time in {control}, sharper and \
                 followed by a free response, moves it and the response apart"
            );
        }
        [] => {}
    }
    let sideways = motion.iter().copied().all(Variable::is_lateral);
    if sideways && has(P) {
        return format!(
            "a roll input (lat_cyclic or aileron doublet) beside the yaw input: in a free Dutch roll {listed} keep one ratio \
             and phase"
        );
    }
    if sideways && has(V) && has(R) {
        return "a steady-heading sideslip (v without r) or a steady turn (r without v)".into();
    }
    if has(U) && has(W) && motion.len() == 2 {
        return "a change of speed (slow, phugoid or throttle) beside a short-period input: w moves in both, u in one".into();
    }
    if has(W) && has(Q) && motion.len() == 2 {
        return "lon_cyclic or elevator 3211 at two clock times, or a climb by collective: w and q then differ in phase".into();
    }
    if motion.iter().copied().any(Variable::is_lateral) {
        return format!("a lateral input with pitch held and a longitudinal one with bank held: {listed} move together here");
    }
    format!("an input that moves one of {listed} while the others stay")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_sentence_is_of_the_kinds_of_term() {
        for (terms, words) in [
            (&["v", "p"][..], "roll input"),
            (&["beta", "p", "r"], "roll input"),
            (&["v", "r"], "steady-heading sideslip"),
            (&["pedal", "r"], "3211 of another clock time in pedal"),
            (&["aileron", "rudder"], "one at a time"),
            (&["v", "v*|v|", "v^3"], "two amplitudes"),
            (&["p*v", "p"], "one without the other and at two amplitudes"),
            (&["u", "w"], "change of speed"),
            (&["alpha", "qhat"], "two clock times"),
            (&["w", "v"], "bank held"),
            (&["something", "p"], "while the others stay"),
        ] {
            let parsed: Vec<Expression> = terms.iter().map(|text| Expression::parse(text).unwrap()).collect();
            let sentence = input_that_splits(&parsed.iter().collect::<Vec<_>>());
            assert!(sentence.contains(words), "{terms:?}: {sentence}");
        }
    }
}
