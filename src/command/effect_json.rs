//! Effects as JSON objects, with the keys that model files have.

use serde_json::{Map, Value, json};
use sideslip::flight::channel::ControlNames;
use sideslip::flight::effect_file::{DeclaredEffect, EffectValue};

/// An effect as model files have it.
pub(super) fn effect_json(effect: &DeclaredEffect, controls: ControlNames) -> Map<String, Value> {
    let value = |value| match value {
        EffectValue::Name(name) => json!(name),
        EffectValue::Number(number) => json!(number),
        EffectValue::Vector(vector) => json!(vector),
    };
    effect.entries(controls).into_iter().map(|(key, entry)| (key.to_owned(), value(entry))).collect()
}
