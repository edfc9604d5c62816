//! Effects as JSON objects, with the keys that model files have.

use crate::flight::channel::ControlNames;
use crate::flight::file::effect_file::{DeclaredEffect, EffectValue};
use serde_json::{Map, Value, json};

/// An effect as model files have it.
pub fn effect_json(effect: &DeclaredEffect, controls: ControlNames) -> Map<String, Value> {
    let value = |value| match value {
        EffectValue::Name(name) => json!(name),
        EffectValue::Names(names) => json!(names),
        EffectValue::Number(number) => json!(number),
        EffectValue::Vector(vector) => json!(vector),
    };
    effect.entries(controls).into_iter().map(|(key, entry)| (key.to_owned(), value(entry))).collect()
}
