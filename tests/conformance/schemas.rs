//! Documents against their JSON Schemas: every key is described, every number has a unit, every document of every command obeys.

use crate::support::program::{ended, folder, own, path, puma, real, sideslip};
use serde_json::Value;
use sideslip::io::outputs::json::document_schema::DocumentSchema;
use std::path::{Path, PathBuf};

/// What a value breaks, with its path: types, required keys, keys that the schema does not describe, numbers without a unit.
fn breaks(schema: &Value, value: &Value, at: &str, found: &mut Vec<String>) {
    let types: Vec<&str> = match &schema["type"] {
        Value::String(one) => vec![one],
        Value::Array(several) => several.iter().filter_map(Value::as_str).collect(),
        _ => Vec::new(),
    };
    let own = match value {
        Value::Null => "null",
        Value::Bool(_) => "boolean",
        Value::Number(_) => "number",
        Value::String(_) => "string",
        Value::Array(_) => "array",
        Value::Object(_) => "object",
    };
    if !types.contains(&own) && !schema.as_object().is_some_and(serde_json::Map::is_empty) {
        found.push(format!("{at}: expected {types:?}, found {own}"));
        return;
    }
    match value {
        Value::Number(_) if !schema["unit"].is_string() => found.push(format!("{at}: no unit")),
        Value::Array(entries) => entries.iter().for_each(|entry| breaks(&schema["items"], entry, &format!("{at}[]"), found)),
        Value::Object(fields) => {
            for needed in schema["required"].as_array().into_iter().flatten().filter_map(Value::as_str) {
                if !fields.contains_key(needed) {
                    found.push(format!("{at}: expected the key {needed}"));
                }
            }
            for (name, field) in fields {
                let place = format!("{at}.{name}");
                match (&schema["properties"][name], &schema["additionalProperties"]) {
                    (Value::Null, Value::Bool(true)) => {}
                    (Value::Null, Value::Null) => found.push(format!("{place}: not described")),
                    (Value::Null, other) => breaks(other, field, &place, found),
                    (known, _) => breaks(known, field, &place, found),
                }
            }
        }
        _ => {}
    }
}

/// The document of a call obeys that schema and names it.
fn obeys(schema: DocumentSchema, args: &[&str]) {
    let (status, text, said) = ended(&sideslip(&[args, &["--json", "-"]].concat()));
    assert!(matches!(status, 0 | 3 | 4), "{args:?}: {status} {said}");
    let document: Value = serde_json::from_str(&text).unwrap();
    assert_eq!(document["provenance"]["schema"], schema.name(), "{args:?}");
    let mut found = Vec::new();
    breaks(&serde_json::from_str(schema.text()).unwrap(), &document, schema.name(), &mut found);
    found.sort();
    found.dedup();
    assert!(found.is_empty(), "{args:?}:\n{}", found.join("\n"));
    let units = &document["provenance"]["units"];
    assert_eq!(units["provenance.files[].bytes"], "1", "{args:?}");
}

fn flown(folder: &Path, name: &str, model: &str, input: &str) -> PathBuf {
    let (file, model) = (folder.join(name), own(model));
    let call = ["simulate", "--model", path(&model), "--input", input, "--noise", "--duration", "12", "--out", path(&file)];
    let (status, _, said) = ended(&sideslip(&call));
    assert!(matches!(status, 0 | 3), "{said}");
    file
}

#[test]
fn documents_of_estimates_and_recordings_obey_their_schemas() {
    let (puma, folder, model) = (puma(), folder("schemas-estimates"), own("replay/models/puma-like.toml"));
    let (run, model) = (path(&puma), path(&model));
    obeys(DocumentSchema::Estimates, &["replay", run]);
    obeys(DocumentSchema::Estimates, &["replay", run, "--model", model, "--output-error", "streaming"]);
    obeys(DocumentSchema::Inspect, &["inspect", run]);
    obeys(DocumentSchema::Manoeuvres, &["inspect", run, "--manoeuvres"]);
    for name in ["flight.tlog", "flight.bin", "flight.ulg", "flight.mcap"] {
        let file = flown(&folder, name, "replay/models/puma-like.toml", "pedal:doublet:0.01:1");
        obeys(DocumentSchema::Inspect, &["inspect", path(&file)]);
    }
    for name in ["hfb320.csv", "uav-2022-ail-2.csv", "citation-2018-dutchroll.csv"] {
        let Some(file) = real(name) else { continue };
        obeys(DocumentSchema::Inspect, &["inspect", path(&file)]);
        obeys(DocumentSchema::Estimates, &["replay", path(&file)]);
        obeys(DocumentSchema::Check, &["check", path(&file)]);
    }
    obeys(DocumentSchema::Check, &["check", run]);
}

#[test]
fn documents_of_identify_obey_their_schemas() {
    let folder = folder("schemas-identify");
    let fly = |name: &str, model: &str, input: &str| flown(&folder, name, &format!("replay/models/{model}.toml"), input);
    let (a, b) = (fly("a.csv", "puma-like", "pedal:3211:0.02:0.7"), fly("b.csv", "puma-like", "lat_cyclic:3211:0.01:0.5"));
    let descent = fly("c.csv", "puma-flight-descent", "pedal:3211:0.02:0.7");
    let lateral = ["--states", "v,p,phi,r", "--inputs", "lat_cyclic,pedal"];
    let rotor = ["--set", "reference={rotor_radius_m=7.5,tip_speed_mps=208}"];
    let identify = DocumentSchema::Identify;
    let with = |runs: &[&Path], more: &[&str]| {
        let runs: Vec<&str> = runs.iter().map(|run| path(run)).collect();
        obeys(identify, &[&["identify"], &runs[..], &lateral, more].concat());
    };
    let kept = fly("h.csv", "puma-like", "pedal:doublet:0.02:1");
    with(&[&a, &b], &["--holdout", path(&kept)]);
    with(&[&a, &b], &[rotor[0], rotor[1], "--domain", "frequency", "--doubt-instruments"]);
    with(&[&a, &b], &["--method", "filter-error"]);
    let points = ["identify", path(&a), path(&descent), "--states", "v,p,phi,r", "--inputs", "pedal", "--model", "puma"];
    obeys(identify, &[&points[..], &["--density", "1.024"]].concat());
    let regression = ["identify", path(&a), "--response", "ay", "--candidates", "beta;p;r;pedal", "--holdout", path(&kept)];
    obeys(DocumentSchema::Regression, &regression);
}

#[test]
fn documents_on_models_obey_their_schemas() {
    let folder = folder("schemas-models");
    let model = own("replay/models/puma-like.toml");
    let text = std::fs::read_to_string(&model).unwrap();
    let wrong = folder.join("wrong.toml");
    assert!(text.contains("r = -0.66163"));
    std::fs::write(&wrong, text.replace("r = -0.66163", "r = -0.5")).unwrap();
    let a = flown(&folder, "a.csv", path(&wrong), "pedal:3211:0.02:0.7");
    let h = flown(&folder, "h.csv", path(&wrong), "pedal:doublet:0.02:1");
    let (a, h, model, wrong) = (path(&a), path(&h), path(&model), path(&wrong));
    obeys(DocumentSchema::Compare, &["compare", a, h, "--model", model, "--beside", wrong]);
    obeys(DocumentSchema::Compare, &["compare", a, "--model", model]);
    obeys(DocumentSchema::Diagnose, &["diagnose", "--model", model, "--fit", a, "--holdout", h]);
    obeys(DocumentSchema::Linearise, &["linearise", "--model", model]);
    obeys(DocumentSchema::Linearise, &["linearise", "--model", "puma"]);
}

#[test]
fn every_key_of_every_schema_is_described_in_the_guide_and_every_number_has_a_unit() {
    let guide = std::fs::read_to_string(own("src/guide/json.md")).unwrap();
    fn walk(schema: &Value, at: &str, guide: &str, found: &mut Vec<String>) {
        for (name, field) in schema["properties"].as_object().into_iter().flatten() {
            let is_name = sideslip::flight::channel::Channel::from_name(name).is_some() || name.len() == 1;
            if !is_name && !guide.contains(&format!("`{name}`")) {
                found.push(format!("{at}.{name}: not in the guide"));
            }
            walk(field, &format!("{at}.{name}"), guide, found);
        }
        let may_be =
            |kind: &str| schema["type"] == kind || schema["type"].as_array().is_some_and(|all| all.iter().any(|one| one == kind));
        if may_be("number") && !schema["unit"].is_string() {
            found.push(format!("{at}: no unit"));
        }
        for inner in ["items", "additionalProperties"].map(|key| &schema[key]).into_iter().filter(|inner| inner.is_object()) {
            walk(inner, &format!("{at}[]"), guide, found);
        }
    }
    let mut found = Vec::new();
    for document in DocumentSchema::ALL {
        assert!(guide.contains(&format!("schema/{}.json", document.name())), "{}", document.name());
        walk(&serde_json::from_str(document.text()).unwrap(), document.name(), &guide, &mut found);
    }
    assert!(found.is_empty(), "{}", found.join("\n"));
}
