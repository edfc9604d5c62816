//! Random states of flight, as numbers and as independent variables.

use super::dual::Dual;
use crate::support::uniform::Uniform;
use sideslip::realtime::estimation::process::{STATES, State};

/// States drawn for each comparison.
pub(crate) const DRAWS: usize = 5_000;

/// A state: any bank and heading, pitch to 86 deg either way.
pub(crate) fn draw(uniform: &mut Uniform) -> State {
    let mut state = [0.0; STATES];
    let navigation = [90.0, 40.0, 40.0, 3.1, 1.5, 6.2, 5e3];
    let inertial = [3.0, 3.0, 3.0, 8.0, 8.0, 8.0, 20.0, 20.0, 30.0];
    let errors = [1.0, 1.0, 1.0, 0.1, 0.1, 0.1, 0.2, 0.2, 0.2];
    for (entry, half) in state.iter_mut().zip(navigation.into_iter().chain(inertial).chain(errors)) {
        *entry = uniform.within(half);
    }
    state
}

/// The same as independent variables.
pub(crate) fn variables(state: &State) -> [Dual; STATES] {
    std::array::from_fn(|i| Dual::variable(state[i], i))
}

/// Finite, and equal to what is expected within 1e-11 of its size or of 1; no NaN passes.
pub(crate) fn assert_close(found: f64, expected: f64, what: &dyn Fn() -> String) {
    assert!(found.is_finite() && expected.is_finite(), "{}: found {found}, expected {expected}", what());
    let error = (found - expected).abs();
    assert!(error <= 1e-11 * expected.abs().max(1.0), "{}: found {found}, expected {expected}, error {error:e}", what());
}
