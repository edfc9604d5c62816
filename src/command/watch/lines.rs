//! The newest estimates as plain text, one below the other, or as a JSON object a line.

use super::bus_picture::BusPicture;
use serde_json::{Value, json};
use sideslip::error::Failure;
use sideslip::io::bus::reader::NewestEstimate;
use sideslip::io::outputs::json::derivatives_json::{RunEstimates, derivatives_json};
use sideslip::io::outputs::tables::terminal::{EstimateTable, Style};
use sideslip::io::outputs::words::finding_text::FindingsTable;
use sideslip::io::outputs::words::output_error_text::OutputErrorTable;
use sideslip::io::outputs::words::status_text::StatusText;

/// For a person: a heading, the table, what output error and the diagnosis say.
pub(super) fn table(picture: &BusPicture) -> String {
    let Some(estimate) = &picture.estimate else { return "no estimate yet\n".to_owned() };
    let controls = picture.controls;
    let status = StatusText { status: estimate.status, controls };
    let NewestEstimate { derivatives, modes, age, sequence, missed, .. } = estimate;
    let style = Style::of_stream(&std::io::stdout());
    let table = EstimateTable {
        controls,
        derivatives: Some(derivatives),
        modes: Some(modes),
        excited_until_s: None,
        events: &[],
        notes: &[],
        style,
    };
    let now_s = derivatives.time_s;
    let fitted = picture.output_error.as_ref();
    let fitted = fitted.map(|record| OutputErrorTable { record, now_s, controls, style }.to_string()).unwrap_or_default();
    let held = FindingsTable { findings: picture.findings(), style };
    let (name, age_s) = (&picture.run, age.as_secs_f64());
    format!("run {name}, estimate {sequence}, {age_s:.2} s old, {missed} missed: {status}\n{table}{fitted}{held}\n")
}

/// For a program.
pub(super) fn json_line(picture: &BusPicture) -> Result<Value, Failure> {
    let Some(estimate) = &picture.estimate else {
        return Ok(json!({
            "age": null,
            "sequence": null,
            "incarnation": null,
            "missed": 0,
            "status": "waiting",
            "valid": false,
            "estimate": null,
        }));
    };
    let run = RunEstimates {
        run: &picture.run,
        controls: picture.controls,
        state: None,
        derivatives: Some(&estimate.derivatives),
        modes: Some(&estimate.modes),
        output_error: picture.output_error.as_ref(),
        findings: picture.findings(),
        warnings: &[],
        consistency: [None, None],
        noise: None,
    };
    let wrong = |error: serde_json::Error| Failure::Running(error.to_string());
    let document: Value = serde_json::from_str(&derivatives_json(&[run]).map_err(wrong)?).map_err(wrong)?;
    Ok(json!({
        "age": estimate.age.as_secs_f64(),
        "sequence": estimate.sequence,
        "incarnation": estimate.incarnation,
        "missed": estimate.missed,
        "status": StatusText { status: estimate.status, controls: picture.controls }.to_string(),
        "valid": estimate.is_valid(),
        "estimate": document.pointer("/runs/0"),
    }))
}
