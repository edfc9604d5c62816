//! The JSON Schema of every document that a command writes, and the unit of each of its numbers.
//!
//! The schemas stand in the folder `schema`, one a document; every number in them has a key `unit`: SI, or in words where the
//! unit follows from a name (of a channel, of a derivative), or `unit` where it stands beside the number under that key.

use serde_json::Value;
use std::collections::BTreeMap;

/// A document.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DocumentSchema {
    /// Of `check`.
    Check,
    /// Of `compare`.
    Compare,
    /// Of `design`.
    Design,
    /// Of `diagnose`.
    Diagnose,
    /// Of `identify`.
    Identify,
    /// Of `identify --response`.
    Regression,
    /// Of `inspect`.
    Inspect,
    /// Of `inspect` on a recording of Chapter 10.
    Chapter10,
    /// Of `inspect --manoeuvres`.
    Manoeuvres,
    /// Of `linearise`.
    Linearise,
    /// Of `replay`, `live`, `estimate` and `demo`.
    Estimates,
}

impl DocumentSchema {
    /// Every one.
    pub const ALL: [DocumentSchema; 11] = [
        DocumentSchema::Check,
        DocumentSchema::Compare,
        DocumentSchema::Design,
        DocumentSchema::Diagnose,
        DocumentSchema::Identify,
        DocumentSchema::Regression,
        DocumentSchema::Inspect,
        DocumentSchema::Chapter10,
        DocumentSchema::Manoeuvres,
        DocumentSchema::Linearise,
        DocumentSchema::Estimates,
    ];

    /// Its name, which stands in the document.
    pub const fn name(self) -> &'static str {
        match self {
            DocumentSchema::Check => "check",
            DocumentSchema::Compare => "compare",
            DocumentSchema::Design => "design",
            DocumentSchema::Diagnose => "diagnose",
            DocumentSchema::Identify => "identify",
            DocumentSchema::Regression => "regression",
            DocumentSchema::Inspect => "inspect",
            DocumentSchema::Chapter10 => "chapter10",
            DocumentSchema::Manoeuvres => "manoeuvres",
            DocumentSchema::Linearise => "linearise",
            DocumentSchema::Estimates => "estimates",
        }
    }

    /// The schema as JSON text.
    pub const fn text(self) -> &'static str {
        match self {
            DocumentSchema::Check => include_str!("schema/check.json"),
            DocumentSchema::Compare => include_str!("schema/compare.json"),
            DocumentSchema::Design => include_str!("schema/design.json"),
            DocumentSchema::Diagnose => include_str!("schema/diagnose.json"),
            DocumentSchema::Identify => include_str!("schema/identify.json"),
            DocumentSchema::Regression => include_str!("schema/regression.json"),
            DocumentSchema::Inspect => include_str!("schema/inspect.json"),
            DocumentSchema::Chapter10 => include_str!("schema/chapter10.json"),
            DocumentSchema::Manoeuvres => include_str!("schema/manoeuvres.json"),
            DocumentSchema::Linearise => include_str!("schema/linearise.json"),
            DocumentSchema::Estimates => include_str!("schema/estimates.json"),
        }
    }

    /// The unit of every number by its path: `[]` is any entry of a list, `*` any key.
    pub fn units(self) -> BTreeMap<String, String> {
        let mut units = BTreeMap::new();
        let schema: Value = serde_json::from_str(self.text()).unwrap_or_default();
        add_units(&mut units, String::new(), &schema);
        units
    }
}

fn add_units(units: &mut BTreeMap<String, String>, path: String, schema: &Value) {
    for (name, field) in schema["properties"].as_object().into_iter().flatten() {
        add_units(units, if path.is_empty() { name.clone() } else { format!("{path}.{name}") }, field);
    }
    if schema["additionalProperties"].is_object() {
        add_units(units, format!("{path}.*"), &schema["additionalProperties"]);
    }
    if schema["items"].is_object() {
        add_units(units, format!("{path}[]"), &schema["items"]);
    }
    if let Some(unit) = schema["unit"].as_str() {
        units.insert(path, unit.to_owned());
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_document_has_its_schema_with_units() {
        for document in DocumentSchema::ALL {
            let schema: Value = serde_json::from_str(document.text()).unwrap();
            assert_eq!(schema["$id"], format!("sideslip/{}", document.name()));
        }
        let units = DocumentSchema::Estimates.units();
        assert_eq!(units["runs[].modes.dutch_roll.omega"], "rad/s");
        assert_eq!(units["runs[].noise.*.std"], "SI unit of the channel");
        assert_eq!(units["provenance.files[].bytes"], "1");
    }
}
