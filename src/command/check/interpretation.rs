//! Preliminary interpretation of the runs: manoeuvres, responses, repeatability and linearity.

use crate::command::check::read_run::ReadRun;
use serde_json::Value;
use sideslip::io::outputs::json::manoeuvre_json;
use sideslip::io::outputs::tables::manoeuvre_table;
use sideslip::postflight::manoeuvres::record::Interpretation;
use sideslip::postflight::manoeuvres::{Run, interpret};

/// Interprets every run, and all of them together.
pub(super) fn of(read: &[ReadRun]) -> Interpretation {
    let runs: Vec<Run<'_>> = read
        .iter()
        .map(|one| {
            let (name, samples) = (one.candidate.name.as_str(), one.candidate.samples.as_slice());
            Run { name, samples, controls: one.candidate.geometry.controls }
        })
        .collect();
    interpret(&runs)
}

pub(super) fn text(all: &Interpretation) -> String {
    format!("\n{}", manoeuvre_table::text(all))
}

/// For a program, under `interpretation`.
pub(super) fn document(all: &Interpretation) -> Value {
    manoeuvre_json::document(all)
}
