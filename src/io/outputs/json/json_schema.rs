//! The JSON Schema of each topic, which viewers show beside a plot, with units.
//!
//! Types are single words (`number`, `integer`, `boolean`, `string`, `object`, `array`): the schema readers of log viewers refuse
//! a channel whose schema has a list of types or none. A number that may be null (not finite) is described in words; other absent
//! values are left out of the message.

use super::message_json::STATE_FIELDS;
use crate::flight::derivative::Axis;
use crate::flight::file::log_head::{ColumnTarget, LogHead};
use serde_json::{Map, Value, json};
use std::collections::BTreeMap;

/// A topic of the log, in the order of their channels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Topic {
    /// Samples as they came in.
    Sample,
    /// The estimated state.
    State,
    /// The smoothed state of a while ago.
    Smoothed,
    /// What each aid did.
    Innovation,
    /// The derivatives so far.
    Derivatives,
    /// The modes so far.
    Modes,
    /// Output error so far.
    OutputError,
    /// What the model gets wrong.
    Finding,
    /// What a stage noticed.
    Event,
}

/// How many topics there are.
pub const TOPICS: usize = 9;

impl Topic {
    /// Every topic, in the order of its place.
    pub const ALL: [Topic; TOPICS] = [
        Topic::Sample,
        Topic::State,
        Topic::Smoothed,
        Topic::Innovation,
        Topic::Derivatives,
        Topic::Modes,
        Topic::OutputError,
        Topic::Finding,
        Topic::Event,
    ];

    /// Place in tables per topic.
    pub const fn index(self) -> usize {
        self as usize
    }

    /// The topic's name in the log.
    pub const fn name(self) -> &'static str {
        match self {
            Topic::Sample => "/sample",
            Topic::State => "/state",
            Topic::Smoothed => "/smoothed",
            Topic::Innovation => "/innovation",
            Topic::Derivatives => "/derivatives",
            Topic::Modes => "/modes",
            Topic::OutputError => "/output_error",
            Topic::Finding => "/finding",
            Topic::Event => "/event",
        }
    }

    /// The name of its schema.
    pub const fn schema_name(self) -> &'static str {
        match self {
            Topic::Sample => "sideslip.Sample",
            Topic::State => "sideslip.State",
            Topic::Smoothed => "sideslip.Smoothed",
            Topic::Innovation => "sideslip.Innovation",
            Topic::Derivatives => "sideslip.Derivatives",
            Topic::Modes => "sideslip.Modes",
            Topic::OutputError => "sideslip.OutputError",
            Topic::Finding => "sideslip.Finding",
            Topic::Event => "sideslip.Event",
        }
    }
}

/// The schema of that topic's messages, as JSON text. The head decides the fields of `/sample`.
pub fn schema(topic: Topic, head: &LogHead) -> String {
    let (about, properties, required): (&str, Value, &[&str]) = match topic {
        Topic::Sample => ("A sample as it came in, SI and radians", sample(head), &["time"]),
        Topic::State => ("Estimated state, filtered, body axes at the centre of mass", state(), &["time", "fused"]),
        Topic::Smoothed => ("State of a while ago, smoothed, body axes at the centre of mass", smoothed(), &["time", "lag"]),
        Topic::Innovation => ("What one aid did at one sample", innovation(), &["time", "aid", "fused"]),
        Topic::Derivatives => ("Stability and control derivatives so far", derivatives(), &["time", "excited", "equations"]),
        Topic::Modes => ("Lateral modes so far", modes(), &["time", "status"]),
        Topic::OutputError => ("Output error so far", output_error(), &["time", "status", "parameters"]),
        Topic::Finding => ("What the model gets wrong", finding(), &["time", "standing", "number", "kind", "statement"]),
        Topic::Event => ("What a stage noticed", event(), &["time", "severity", "kind", "text"]),
    };
    json!({
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "title": topic.schema_name(),
        "description": about,
        "type": "object",
        "properties": properties,
        "required": required,
    })
    .to_string()
}

/// The unit of every number of that topic, by its path; `see unit` where the message states it beside the number.
pub fn units(topic: Topic, head: &LogHead) -> BTreeMap<String, String> {
    let mut units = BTreeMap::new();
    let whole: Value = serde_json::from_str(&schema(topic, head)).unwrap_or_default();
    add_units(&mut units, "", &whole);
    units
}

fn add_units(units: &mut BTreeMap<String, String>, path: &str, schema: &Value) {
    for (name, field) in schema["properties"].as_object().into_iter().flatten() {
        let path = if path.is_empty() { name.clone() } else { format!("{path}.{name}") };
        let about = field["description"].as_str().unwrap_or_default();
        match field["type"].as_str() {
            Some("number") => {
                let unit = about.strip_suffix(']').and_then(|text| text.rsplit_once('[')).map_or("1", |(_, unit)| unit);
                units.insert(path, unit.to_owned());
            }
            Some("integer") => drop(units.insert(path, "1".to_owned())),
            Some("array") => add_units(units, &format!("{path}[]"), &field["items"]),
            _ => add_units(units, &path, field),
        }
    }
}

fn number(about: &str, unit: &str) -> Value {
    json!({ "type": "number", "description": format!("{about} [{unit}]") })
}

fn text(about: &str) -> Value {
    json!({ "type": "string", "description": about })
}

fn flag(about: &str) -> Value {
    json!({ "type": "boolean", "description": about })
}

fn object(about: &str, properties: Value) -> Value {
    json!({ "type": "object", "description": about, "properties": properties })
}

fn time() -> Value {
    let about =
        "time on the recording's own clock; exact, while log_time is in whole ns, by the clock that the channel's metadata name";
    number(about, "s")
}

fn sample(head: &LogHead) -> Value {
    let mut fields = Map::new();
    fields.insert("time".into(), time());
    for ((name, unit), target) in head.channels.iter().zip(head.targets()) {
        let about = match target {
            ColumnTarget::Known(_) => "absent where not sampled, null where the instrument gave no number",
            ColumnTarget::Unknown(_) => "unknown to the program, carried along; absent where not sampled",
        };
        fields.insert(name.clone(), number(about, unit));
    }
    Value::Object(fields)
}

fn state() -> Value {
    let mut fields = state_fields();
    fields.insert("fused".into(), json!({ "type": "integer", "description": "aids fused at this sample" }));
    Value::Object(fields)
}

fn smoothed() -> Value {
    let mut fields = state_fields();
    fields.insert("lag".into(), number("how much later the newest sample is that it rests on", "s"));
    Value::Object(fields)
}

fn state_fields() -> Map<String, Value> {
    let mut fields = Map::new();
    for (name, unit) in STATE_FIELDS {
        let about = match name.strip_prefix("std_") {
            Some(of) => format!("standard deviation of {of}"),
            None => match name.strip_prefix("bias_") {
                Some(of) => format!("instrument bias of {of}"),
                None => name.to_owned(),
            },
        };
        fields.insert(name.into(), number(&about, unit));
    }
    fields.insert("time".into(), time());
    fields
}

fn innovation() -> Value {
    json!({
        "time": time(),
        "aid": text("which measurement"),
        "channel": text("the channel that carries it; its SI unit is the unit here"),
        "observation": number("the measurement", "SI unit of the channel"),
        "observation_var": number("variance of its noise", "that unit squared"),
        "innovation": number("measurement less prediction", "SI unit of the channel"),
        "innovation_var": number("predicted variance of the innovation", "that unit squared"),
        "test_ratio": number("innovation^2 / (gate^2 innovation_var); above 1 it is rejected", "1"),
        "fused": flag("whether it was used"),
    })
}

fn derivatives() -> Value {
    let mut equations = Map::new();
    for axis in Axis::ALL {
        let unit = if axis.is_force() { "m/s^2" } else { "rad/s^2" };
        let term = json!({
            "name": text("AXIS_variable, or AXIS_0 for the bias"),
            "value": number("the derivative", "see unit"),
            "std": number("standard error, for coloured residuals", "see unit"),
            "partial_f": number("partial F ratio on std", "1"),
            "std_white": number("standard error, right only for white residuals", "see unit"),
            "partial_f_white": number("partial F ratio on std_white", "1"),
            "step": { "type": "integer", "description": "step of the selection at which it entered; 0 for the bias" },
            "primary": flag("in the equation whatever its F"),
            "unit": text("unit of value, std and std_white"),
            "frequency": object(
                "the same term from the frequency domain; absent where there is none",
                json!({
                    "value": number("the derivative", "see unit"),
                    "std": number("standard error, for an equation error that is white in the band", "see unit"),
                    "disagreement": number("less the term's value, in combined standard errors", "1"),
                }),
            ),
        });
        let disagreement = json!({
            "name": text("the term in which time and frequency domain disagree most"),
            "standard_errors": number("frequency domain less time domain, in combined standard errors", "1"),
        });
        let equation = json!({
            "status": text("waiting, exciting, converging, converged, disagree, depends on amplitude, stale, not identifiable: reason"),
            "reason": text("why there is no number and none to come"),
            "terms": { "type": "array", "items": { "type": "object", "properties": term } },
            "unresolved": {
                "type": "array",
                "items": { "type": "string" },
                "description": "derivatives in the equation without a number: their standard error is as large as the value",
            },
            "r2": number("multiple correlation coefficient squared", "1"),
            "f_total": number("total F ratio", "1"),
            "samples": number("samples that it rests on", "1"),
            "residual_std": number("standard deviation of the residual", unit),
            "collinearity": number("largest condition index of the regressors", "1"),
            "disagreement": object("of the frequency domain with the time domain; absent where there is none", disagreement),
        });
        equations.insert(axis.name().into(), object(&format!("equation of {}", axis.name()), equation));
    }
    json!({
        "time": time(),
        "excited": flag("whether the aircraft is being excited now"),
        "equations": object("one equation an axis", Value::Object(equations)),
    })
}

fn output_error() -> Value {
    let parameter = json!({
        "name": text("AXIS_variable"),
        "value": number("the derivative", "see unit"),
        "std": number("standard error, for coloured residuals", "see unit"),
        "std_cramer_rao": number("standard error by the bound, right only for white residuals", "see unit"),
        "unit": text("unit of value, std and std_cramer_rao"),
    });
    let Value::Object(mut fields) = modes() else { return Value::Null };
    fields.retain(|name, _| !matches!(name.as_str(), "time" | "status" | "reason"));
    if let Some(pair) = fields.get("dutch_roll").cloned() {
        fields.insert("short_period".into(), pair);
    }
    json!({
        "time": time(),
        "fitted": number("time of the newest sample that the numbers rest on; absent where there are none", "s"),
        "age": number("how old they are; absent where there are none", "s"),
        "status": text("waiting, converging, converged, disagree, stale, failed"),
        "reason": text("why there are no new numbers, or notes on them; absent where there is nothing to say"),
        "parameters": { "type": "array", "items": { "type": "object", "properties": parameter } },
        "modes": object("modes of the fitted model; each absent where there is no number", Value::Object(fields)),
        "manoeuvres": { "type": "integer", "description": "manoeuvres that the numbers rest on" },
        "dropped": { "type": "integer", "description": "manoeuvres dropped because there is no more room" },
        "samples": { "type": "integer", "description": "samples that the numbers rest on" },
    })
}

fn modes() -> Value {
    let oscillation = |about: &str| {
        object(
            about,
            json!({
                "real": number("real part, negative where damped", "1/s"),
                "imag": number("imaginary part", "rad/s"),
                "omega": number("undamped natural frequency", "rad/s"),
                "zeta": number("damping ratio", "1"),
                "std_omega": number("standard error of omega", "rad/s"),
                "std_zeta": number("standard error of zeta", "1"),
            }),
        )
    };
    let root = |about: &str| {
        object(
            about,
            json!({ "value": number("the root, negative where stable", "1/s"), "std": number("its standard error", "1/s") }),
        )
    };
    json!({
        "time": time(),
        "status": text("waiting, exciting, converging, converged, disagree, depends on amplitude, stale, not identifiable: reason"),
        "reason": text("why there is no number and none to come"),
        "dutch_roll": oscillation("Dutch roll; absent where there is no number"),
        "roll": root("roll subsidence; absent where there is no number"),
        "spiral": root("spiral; absent where there is no number"),
        "lateral_phugoid": oscillation("roll and spiral joined into a slow oscillation; mostly absent"),
        "coupled_dutch_roll": oscillation("Dutch roll of the whole aircraft, coupled to u w q; absent until all axes have numbers"),
    })
}

fn finding() -> Value {
    json!({
        "time": time(),
        "standing": text("waiting, found, taken back, or failed: why the last diagnosis gave no answer"),
        "number": { "type": "integer", "description": "which finding of this run: the same while its cause is" },
        "kind": text("kind of effect; none where the model explains what was flown, unknown where no effect does"),
        "axis": text("axis, where the kind has one"),
        "variable": text("variable, where the kind has one"),
        "term": text("nonlinear term, where the kind has one"),
        "control": text("control, where the kind has one"),
        "channel": text("channel, where the kind has one"),
        "delta": number("size of the effect on a derivative; other kinds have their own key, as in model files", "its own unit"),
        "std": number("standard error of the size", "its own unit"),
        "probability": number("probability that this is the cause; null where there is none", "1"),
        "rivals": { "type": "integer", "description": "other causes that the data do not rule out" },
        "manoeuvres": { "type": "integer", "description": "manoeuvres that it rests on" },
        "statement": text("one sentence for a person"),
    })
}

fn event() -> Value {
    json!({
        "time": time(),
        "severity": text("info, warning or data lost"),
        "kind": text("kind of event, for programs"),
        "subject": text("channel or axis that it is about"),
        "count": { "type": "integer", "description": "how many messages it is about" },
        "text": text("one sentence for a person"),
    })
}
