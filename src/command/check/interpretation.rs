//! The first look at the runs: what was flown, how it answered, and whether it answers alike and in proportion.

use super::Read;
use serde_json::Value;
use sideslip::estimation::interpretation::record::Interpretation;
use sideslip::estimation::interpretation::{Run, interpret, json, table};

/// Looks at every run and at all of them together.
pub(super) fn of(read: &[Read]) -> Interpretation {
    let runs: Vec<Run<'_>> = read
        .iter()
        .map(|one| {
            let (name, samples) = (one.candidate.name.as_str(), one.candidate.samples.as_slice());
            Run { name, samples, controls: one.candidate.geometry.controls }
        })
        .collect();
    interpret(&runs)
}

/// For a person.
pub(super) fn text(all: &Interpretation) -> String {
    format!("\n{}", table::text(all))
}

/// For a program, under `interpretation`.
pub(super) fn document(all: &Interpretation) -> Value {
    json::document(all)
}
