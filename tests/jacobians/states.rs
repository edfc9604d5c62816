//! Random states of flight, as numbers and as independent variables.

use crate::dual::{Dual, PARTIALS};
use crate::uniform::Uniform;
use sideslip::estimation::process::{INPUTS, Input, STATES, State};

/// States drawn for each comparison.
pub(crate) const DRAWS: usize = 5_000;

/// A state with biases and the measured inputs of the same instant: any bank and heading, pitch to 86 deg either way.
pub(crate) fn draw(uniform: &mut Uniform) -> (State, Input) {
    let half = [90.0, 40.0, 40.0, 3.1, 1.5, 6.2, 5e3, 1.0, 1.0, 1.0, 0.1, 0.1, 0.1];
    let state = half.map(|half| uniform.within(half));
    let input = [20.0, 20.0, 30.0, 3.0, 3.0, 3.0].map(|half| uniform.within(half));
    (state, input)
}

/// The same as independent variables: the state first, then the inputs.
pub(crate) fn variables(state: &State, input: &Input) -> ([Dual; STATES], [Dual; INPUTS]) {
    assert_eq!(STATES + INPUTS, PARTIALS);
    let variables = std::array::from_fn(|i| Dual::variable(state[i], i));
    (variables, std::array::from_fn(|i| Dual::variable(input[i], STATES + i)))
}

/// Finite, and equal to what is expected within 1e-11 of its size or of 1; no NaN passes.
pub(crate) fn assert_close(found: f64, expected: f64, what: &dyn Fn() -> String) {
    assert!(found.is_finite() && expected.is_finite(), "{}: found {found}, expected {expected}", what());
    let error = (found - expected).abs();
    assert!(error <= 1e-11 * expected.abs().max(1.0), "{}: found {found}, expected {expected}, error {error:e}", what());
}
