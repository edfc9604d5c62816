//! `inspect --manoeuvres`: the manoeuvres of a flight by number, each with control, shape and condition, for `--manoeuvre`.

use crate::command::message_text;
use crate::command::options::telemetry_source::RecordingSource;
use crate::command::recordings::chosen_runs::{FlightManoeuvres, manoeuvres_of};
use crate::command::recordings::provenance::Provenance;
use crate::command::terminal::console::print;
use serde_json::{Value, json};
use sideslip::error::{Failure, Outcome};
use sideslip::flight::channel::ControlNames;
use sideslip::io::outputs::json::document_schema::DocumentSchema;
use sideslip::io::outputs::number::Fixed;
use sideslip::io::outputs::words::printable::printable;
use sideslip::io::telemetry::recording_config::RecordingConfig;
use sideslip::postflight::manoeuvres::flight_parts::FlightPart;
use sideslip::postflight::manoeuvres::record::Measured;
use std::fmt::Write;
use std::path::{Path, PathBuf};

/// Reads the recording and lists its manoeuvres; `files` are all that are read.
pub(super) fn run(
    source: &RecordingSource,
    config: &RecordingConfig,
    json: Option<&Path>,
    files: impl IntoIterator<Item = PathBuf>,
) -> Result<Outcome, Failure> {
    let FlightManoeuvres { parts, controls, recorded_at } = manoeuvres_of(source, config)?;
    let text = text(source, &parts, controls);
    match json {
        None => print(&text)?,
        Some(target) => {
            message_text(text.trim_end());
            let manoeuvres: Vec<Value> = parts.iter().enumerate().map(|(place, part)| entry(place, part, controls)).collect();
            let document = json!({ "file": source.file.display().to_string(), "manoeuvres": manoeuvres });
            let provenance = Provenance::of(files).dated(&source.file, recorded_at.as_deref());
            provenance.write_json(target, DocumentSchema::Manoeuvres, &format!("{document:#}\n"))?;
        }
    }
    Ok(if parts.is_empty() { Outcome::NotGood } else { Outcome::Done })
}

fn text(source: &RecordingSource, parts: &[FlightPart], controls: ControlNames) -> String {
    let name = source.file.display().to_string();
    let file = printable(&name);
    if parts.is_empty() {
        return format!("{file}: no manoeuvre: no control is recorded in rad, or none moves and comes to rest\n");
    }
    let mut text = format!("{file}: {} manoeuvre{}\n", parts.len(), if parts.len() == 1 { "" } else { "s" });
    let titles =
        ["N", "control", "shape", "first, rad", "control moves, s", "run, s", "tas, m/s", "climb, m/s", "altitude, m", "trim"];
    let rows: Vec<Vec<String>> = std::iter::once(titles.map(str::to_owned).to_vec())
        .chain(parts.iter().enumerate().map(|(place, part)| cells(place, part, controls)))
        .collect();
    let width = |column: usize| rows.iter().filter_map(|row| row.get(column)).map(|cell| cell.chars().count()).max().unwrap_or(0);
    let widths: Vec<usize> = (0..titles.len()).map(width).collect();
    for row in &rows {
        let line: String = row.iter().zip(&widths).map(|(cell, width)| format!("  {cell:<width$}")).collect();
        let _ = writeln!(text, "{}", line.trim_end());
    }
    let _ = writeln!(text, "A run of its own: --manoeuvre N on every command that reads runs (several as 1,3, or all)");
    text
}

fn cells(place: usize, part: &FlightPart, controls: ControlNames) -> Vec<String> {
    let FlightPart { from_s, to_s, manoeuvre } = part;
    let number =
        |value: Option<f64>, places: u8| value.map_or_else(|| "-".to_owned(), |value| Fixed(value, places.into()).to_string());
    let trim = manoeuvre.trim.as_ref().ok();
    let mut names = manoeuvre.control.name(controls).to_owned();
    manoeuvre.others.iter().for_each(|(other, _)| {
        let _ = write!(names, " + {}", other.name(controls));
    });
    let value = |measured: Option<Measured>| measured.map(|measured| measured.value);
    let steady = match trim {
        None => "none before it",
        Some(trim) if trim.unsteady.is_empty() => "steady",
        Some(_) => "not steady",
    };
    vec![
        (place + 1).to_string(),
        names,
        manoeuvre.shape.to_string(),
        format!("{:+}", Fixed(manoeuvre.amplitude, 4)),
        format!("{} to {}", Fixed(manoeuvre.start_s, 1), Fixed(manoeuvre.end_s, 1)),
        format!("{} to {}", Fixed(*from_s, 1), Fixed(*to_s, 1)),
        number(trim.and_then(|trim| value(trim.tas)), 1),
        number(trim.and_then(|trim| value(trim.climb)), 1),
        number(trim.and_then(|trim| trim.altitude), 0),
        steady.to_owned(),
    ]
}

fn entry(place: usize, part: &FlightPart, controls: ControlNames) -> Value {
    let FlightPart { from_s, to_s, manoeuvre } = part;
    let trim = manoeuvre.trim.as_ref().ok();
    let measured = |one: Option<Measured>| one.map(|one| json!({ "value": one.value, "std": one.std }));
    json!({
        "number": place + 1,
        "control": manoeuvre.control.name(controls),
        "other_controls": manoeuvre.others.iter().map(|(other, _)| other.name(controls)).collect::<Vec<_>>(),
        "shape": manoeuvre.shape.to_string(),
        "amplitude": manoeuvre.amplitude,
        "start_s": manoeuvre.start_s,
        "end_s": manoeuvre.end_s,
        "from_s": from_s,
        "to_s": to_s,
        "trim": trim.map(|trim| json!({
            "tas": measured(trim.tas),
            "climb": measured(trim.climb),
            "altitude": trim.altitude,
            "rho": trim.rho,
            "unsteady": trim.unsteady,
        })),
    })
}
