//! Roots of the model, as given and with an extension.

use crate::command::diagnose::answer::Answer;
use serde_json::{Value, json};
use sideslip::dynamics::linear::{state_matrix, with_effects};
use sideslip::flight::effect::Effect;
use sideslip::flight::file::effect_file::DeclaredEffect;
use sideslip::realtime::modes::naming::{Eigenmodes, eigenmodes};

/// The Dutch roll of the model with its own effects and these.
pub(super) fn dutch_roll(answer: &Answer, extension: &[DeclaredEffect]) -> Value {
    let root = modes(answer, extension).and_then(|modes| modes.dutch_roll);
    root.map_or(Value::Null, |root| json!({ "real": root.re, "imag": root.im }))
}

pub(super) fn modes(answer: &Answer, extension: &[DeclaredEffect]) -> Option<Eigenmodes> {
    let effects: Vec<Effect> = answer.model.file.effects.iter().chain(extension).map(|declared| declared.effect).collect();
    eigenmodes(&state_matrix(&with_effects(answer.model.linear(), &effects).ok()?))
}
