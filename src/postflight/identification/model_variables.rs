//! Which states, inputs and outputs a linear model has, by name, and why no model can be built from a choice of them.
//!
//! A name is that of a channel; `v` and `beta` (and `w` and `alpha`) are two forms of the same state, so a model has one of them.

use super::columns::ColumnError;
use crate::flight::derivative::Variable;

/// Names of what can be a state, in the order in which they are shown.
pub const STATES: [&str; 10] = ["u", "v", "w", "p", "q", "r", "phi", "theta", "alpha", "beta"];

/// What is to be identified.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ModelVariables {
    /// States by name.
    pub states: Vec<String>,
    /// Inputs by name: controls, or any measured channel.
    pub inputs: Vec<String>,
    /// Outputs by name: states' channels, `tas alpha beta`, `ax ay az`.
    pub outputs: Vec<String>,
}

/// Why there is no structure.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum IdentificationModelError {
    /// A name that can be no state.
    #[error("--states: `{0}` is no state; expected some of {states}", states = STATES.join(", "))]
    State(String),
    /// A name that can be no output of these states.
    #[error("--outputs: `{name}` cannot be computed from the states; expected a state, or {expected}")]
    Output {
        /// The name.
        name: String,
        /// What could be.
        expected: &'static str,
    },
    /// A name stands twice.
    #[error("`{0}` stands twice among states and inputs")]
    Twice(String),
    /// Nothing to find.
    #[error("expected at least one state")]
    NoState,
    /// Nothing to find it by.
    #[error("no control moves in these runs: expected a test input, or what else acts on the states in --inputs")]
    NoInput,
    /// v beside beta, or w beside alpha.
    #[error("`{0}` and `{1}` are the same state; expected one of them")]
    Same(&'static str, &'static str),
    /// Runs at different speeds.
    #[error(
        "`{first}` was flown at {first_speed:.1} m/s and `{other}` at {other_speed:.1} m/s: expected runs of one flight condition"
    )]
    Speeds {
        /// A run.
        first: String,
        /// Its airspeed, m/s.
        first_speed: f64,
        /// Another.
        other: String,
        /// Its airspeed, m/s.
        other_speed: f64,
    },
    /// A run lacks something.
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

pub(crate) fn is_control(name: &str) -> bool {
    name == "tail_pitch" || Variable::from_name(name).is_some_and(|variable| Variable::CONTROLS.contains(&variable))
}

pub(crate) fn is_attitude(name: &str) -> bool {
    matches!(name, "phi" | "theta" | "psi")
}
