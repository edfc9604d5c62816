//! Names of states, inputs and outputs of a linear model, and the errors of a choice that gives no model.
//!
//! A name is that of a channel; `v` and `beta` (and `w` and `alpha`) are two forms of one state, so a model has one of them.

use super::columns::ColumnError;
use crate::flight::derivative::Variable;

/// Names of possible states, in the order in which they are shown.
pub const STATES: [&str; 10] = ["u", "v", "w", "p", "q", "r", "phi", "theta", "alpha", "beta"];

/// States, inputs and outputs of a model by name.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ModelVariables {
    /// Some of [`STATES`].
    pub states: Vec<String>,
    /// Controls, or any measured channel.
    pub inputs: Vec<String>,
    /// Channels of states, `tas alpha beta`, `ax ay az`.
    pub outputs: Vec<String>,
}

/// Why there is no structure.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[expect(missing_docs, reason = "the message of each says what its fields are")]
pub enum IdentificationModelError {
    #[error("--states: `{0}` is no state; expected some of {states}", states = STATES.join(", "))]
    State(String),
    #[error("--outputs: `{name}` cannot be computed from the states; expected a state, or {expected}")]
    Output { name: String, expected: &'static str },
    #[error("`{0}` stands twice among states and inputs")]
    Twice(String),
    #[error("expected at least one state")]
    NoState,
    #[error(
        "no control moves in these runs (channels that are not a deflection in rad or deg do not count): expected a test input, or what else acts on the states in --inputs"
    )]
    NoInput,
    #[error("`{0}` and `{1}` are the same state; expected one of them")]
    Same(&'static str, &'static str),
    #[error(
        "`{first}` was flown at {first_speed:.1} m/s and `{other}` at {other_speed:.1} m/s: expected runs of one flight condition"
    )]
    Speeds { first: String, first_speed: f64, other: String, other_speed: f64 },
    #[error(transparent)]
    Column(#[from] ColumnError),
}

/// The axis whose derivatives stand in a state's row; `None` for the attitudes.
pub fn axis(state: &str) -> Option<char> {
    match state {
        "u" => Some('X'),
        "v" | "beta" => Some('Y'),
        "w" | "alpha" => Some('Z'),
        "p" => Some('L'),
        "q" => Some('M'),
        "r" => Some('N'),
        _ => None,
    }
}

/// Whether a name is that of a control, or of the measured tail pitch.
pub fn is_control(name: &str) -> bool {
    name == "tail_pitch" || Variable::from_name(name).is_some_and(|variable| Variable::CONTROLS.contains(&variable))
}

pub(crate) fn is_attitude(name: &str) -> bool {
    matches!(name, "phi" | "theta" | "psi")
}
