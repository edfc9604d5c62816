//! A finding as a JSON object: the payload of `/finding`, and an entry of `findings` in `derivatives.json`.
//!
//! The effect has the keys of model files (`kind`, and by kind `axis`, `variable`, `delta`, ...), so that the entry can be copied
//! into a model file.

use super::effect_json::effect_json;
use crate::flight::channel::ControlNames;
use crate::flight::file::effect_file::DeclaredEffect;
use crate::postflight::diagnosis::record::FindingRecord;
use serde::Serialize;
use serde_json::{Map, Value};

#[derive(Serialize)]
pub(crate) struct FindingJson {
    time: f64,
    standing: &'static str,
    number: u32,
    #[serde(flatten)]
    effect: Map<String, Value>,
    /// `null` where it cannot be said.
    probability: Option<f64>,
    rivals: u32,
    manoeuvres: u32,
    statement: String,
}

impl FindingJson {
    pub(crate) fn new(record: &FindingRecord, controls: ControlNames) -> Self {
        let there = |value: f64| value.is_finite().then_some(value);
        let declared = DeclaredEffect { effect: record.effect, std: there(record.std) };
        FindingJson {
            time: record.time_s,
            standing: record.standing.name(),
            number: record.number,
            effect: effect_json(&declared, controls),
            probability: there(record.probability),
            rivals: record.rivals,
            manoeuvres: record.manoeuvres,
            statement: record.statement.as_str().to_owned(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::flight::channel::Channel;
    use crate::flight::effect::Effect;
    use crate::postflight::diagnosis::record::FindingStatus;
    use serde_json::json;

    #[test]
    fn an_effect_stands_with_the_keys_of_model_files() {
        let effect = Effect::SensorDelay { channel: Channel::R, delay: 0.12 };
        let (standing, number) = (FindingStatus::Found, 2);
        let record = FindingRecord { time_s: 9.0, standing, number, effect, std: 0.01, ..FindingRecord::EMPTY };
        let value = serde_json::to_value(FindingJson::new(&record, ControlNames::Rotorcraft)).unwrap();
        let wanted = json!({ "time": 9.0, "standing": "found", "number": 2, "kind": "sensor_delay", "channel": "r", "delay": 0.12,
            "std": 0.01, "probability": null, "rivals": 0, "manoeuvres": 0, "statement": "" });
        assert_eq!(value, wanted);
    }
}
