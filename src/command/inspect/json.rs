//! The answer of `inspect` for a program: SI units, `null` where there is no number.

use super::estimable::{EstimableQuantities, Feasibility};
use super::survey::{ColumnSurvey, Survey};
use super::table::column_name;
use serde_json::{Map, Value, json};
use sideslip::flight::file::run_file::{RecordingTarget, RunInfo};
use sideslip::io::outputs::words::control_scale::assumed_names;
use sideslip::io::telemetry::alignment::dropout::Dropout;
use sideslip::io::telemetry::alignment::row_alignment::RowAlignment;
use sideslip::io::telemetry::mavlink::recording::Traffic;
use sideslip::io::telemetry::mavlink::senders::{Sender, SenderTally};
use sideslip::io::telemetry::recording::Recording;
use std::path::Path;

pub(super) fn document(
    file: &Path,
    recording: &Recording,
    info: &RunInfo,
    survey: &Survey,
    order: &RowAlignment,
    estimable: &EstimableQuantities,
) -> Value {
    let controls = recording.info().geometry().controls;
    let times = &survey.times;
    let skipped = recording.skipped();
    let reasons: Vec<Value> = skipped
        .reasons()
        .iter()
        .map(|rows| json!({"reason": rows.reason.words(), "rows": rows.rows, "first": rows.first, "example": rows.example}))
        .collect();
    let gaps: Vec<Value> = times.gaps().map(|gap| json!({"from": gap.from_s, "to": gap.to_s})).collect();
    let axes: Map<String, Value> = estimable.axes.iter().map(|axis| (axis.what.name().into(), answer(axis))).collect();
    let by: Map<String, Value> =
        estimable.variables.iter().map(|variable| (variable.what.name(controls).into(), answer(variable))).collect();
    let mut state = answer(&estimable.state);
    if let Some(state) = state.as_object_mut() {
        state.insert("aids".into(), json!(estimable.aids));
        state.insert("aids_missing".into(), json!(estimable.aids_missing));
    }
    let mut document = json!({
        "file": file.display().to_string(),
        "format": recording.format(),
        "run": from_toml(&toml::Value::Table(info.document().clone())),
        "rows": survey.rows,
        "skipped": {"rows": skipped.rows(), "reasons": reasons},
        "ends_abruptly": recording.ends_abruptly(),
        "found_out": recording.found_out(),
        "shortfall": recording.shortfall(),
        "time": {
            "start": times.range_s.map(|(start, _)| start),
            "end": times.range_s.map(|(_, end)| end),
            "unit": "s",
            "rate_hz": times.rate_hz(),
            "duplicates": times.duplicates,
            "went_back": times.went_back,
            "not_finite": times.not_finite,
            "gaps": gaps,
            "order": times_in_order(recording, order),
        },
        "channels": survey.columns.iter().map(channel).collect::<Vec<_>>(),
        "messages": recording.traffic().map(messages),
        "estimable": {"state": state, "axes": axes, "by": by, "dutch_roll": answer(&estimable.dutch_roll)},
    });
    let assumed = assumed_names(info);
    if !assumed.is_empty() {
        document["assumed_scale"] = json!(assumed);
    }
    document
}

/// How the samples are put in order of time, counted by single channels, and what is missing at their own rates.
fn times_in_order(recording: &Recording, order: &RowAlignment) -> Value {
    let tally = order.tally();
    let dropout = |dropout: &Dropout| {
        json!({
            "channel": column_name(recording, dropout.channel),
            "from": dropout.from_s,
            "to": dropout.to_s,
            "missing": dropout.missing,
        })
    };
    json!({
        "samples": tally.taken,
        "reordered": tally.reordered,
        "late": tally.late,
        "repeated": tally.repeated,
        "contradicting": tally.contradicting,
        "strays": tally.strays,
        "no_time": tally.no_time,
        "jumps_back": tally.jumps_back,
        "jumps_forward": tally.jumps_forward,
        "rate_changes": tally.rate_changes,
        "dropouts": order.dropouts().iter().map(dropout).collect::<Vec<_>>(),
        "missing": tally.missing,
    })
}

/// Who sent what, where the recording is made of messages.
fn messages(traffic: &Traffic) -> Value {
    let sender = |(sender, tally): (Sender, &SenderTally)| {
        json!({
            "system": sender.system,
            "component": sender.component,
            "vehicle": sender == traffic.vehicle,
            "messages": tally.total(),
            "by_name": tally.by_name(),
        })
    };
    json!({
        "total": traffic.tally.good,
        "bad_checksum": traffic.tally.bad_checksum,
        "unknown": traffic.tally.unknown,
        "garbage_bytes": traffic.tally.garbage_bytes,
        "boots": traffic.boots,
        "senders": traffic.senders.iter().map(sender).collect::<Vec<_>>(),
        "other_senders": traffic.senders.others,
    })
}

fn channel(survey: &ColumnSurvey) -> Value {
    let column = &survey.column;
    json!({
        "name": column.name,
        "known": !matches!(column.target, RecordingTarget::Other),
        "unit": column.inner_unit(),
        "unit_in_file": column.unit_text,
        "samples": survey.samples,
        "not_finite": survey.not_finite,
        "min": survey.range.map(|(least, _)| least),
        "max": survey.range.map(|(_, greatest)| greatest),
        "moves": survey.moves(),
        "rate_hz": survey.times.rate_hz(),
        "gaps": survey.times.gaps().count(),
        "longest_gap_s": survey.times.longest_gap_s(),
    })
}

fn answer<T>(answer: &Feasibility<T>) -> Value {
    json!({"possible": answer.possible, "reasons": answer.reasons})
}

/// A TOML value as JSON; dates and numbers that JSON lacks become their text.
fn from_toml(value: &toml::Value) -> Value {
    match value {
        toml::Value::String(text) => json!(text),
        toml::Value::Integer(number) => json!(number),
        toml::Value::Float(number) if number.is_finite() => json!(number),
        toml::Value::Float(_) | toml::Value::Datetime(_) => json!(value.to_string()),
        toml::Value::Boolean(truth) => json!(truth),
        toml::Value::Array(entries) => entries.iter().map(from_toml).collect(),
        toml::Value::Table(table) => {
            table.iter().map(|(key, value)| (key.clone(), from_toml(value))).collect::<Map<_, _>>().into()
        }
    }
}
