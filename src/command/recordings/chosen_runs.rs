//! The runs of a call: each recording, or what of it was asked for, with the keys that are overridden.

use super::run_head::{HeadedRecording, head_of};
use crate::command::options::run_parts::{ManoeuvreChoice, PartChoice, PartOptions};
use crate::command::options::telemetry_source::{KeptRows, RecordingSource};
use sideslip::error::Failure;
use sideslip::flight::channel::ControlNames;
use sideslip::io::telemetry::alignment::aligned_recording::TimeSpan;
use sideslip::io::telemetry::recording_config::RecordingConfig;
use sideslip::postflight::manoeuvres::flight_parts::{FlightPart, flight_parts};
use std::sync::Arc;

/// The runs of several lists of recordings, such as those that are fitted and those of the hold-out; `set` are keys of runs. A
/// recording is read for its manoeuvres where one was asked for, once.
pub(crate) fn chosen_runs<const N: usize>(
    lists: [&[RecordingSource]; N],
    parts: &PartOptions,
    set: &[String],
    mapping: &RecordingConfig,
) -> Result<[Vec<RecordingSource>; N], Failure> {
    let sources: Vec<&RecordingSource> = lists.iter().copied().flatten().collect();
    let mut choices = parts.choices(&sources, set)?.into_iter();
    let mut chosen = [const { Vec::new() }; N];
    for (list, chosen) in lists.into_iter().zip(&mut chosen) {
        for (source, choice) in list.iter().zip(&mut choices) {
            chosen.extend(runs_of(source, choice, mapping)?);
        }
    }
    Ok(chosen)
}

/// The one run of a command that takes one; `set` are keys of it.
pub(crate) fn chosen_run(
    source: &RecordingSource,
    parts: &PartOptions,
    set: &[String],
    mapping: &RecordingConfig,
) -> Result<RecordingSource, Failure> {
    let [mut runs] = chosen_runs([std::slice::from_ref(source)], parts, set, mapping)?;
    match (runs.len(), runs.pop()) {
        (1, Some(one)) => Ok(one),
        (count, _) => Err(Failure::Input(format!("--manoeuvre: expected one manoeuvre for this command, found {count}"))),
    }
}

fn runs_of(source: &RecordingSource, choice: PartChoice, mapping: &RecordingConfig) -> Result<Vec<RecordingSource>, Failure> {
    let PartChoice { span, manoeuvres, set } = choice;
    let whole = RecordingSource { span, set, ..source.clone() };
    let Some(manoeuvres) = manoeuvres else { return Ok(vec![whole]) };
    let whole = RecordingSource { kept: Some(KeptRows(Arc::new(whole.open(mapping)?.read_to_end()?))), ..whole };
    let FlightManoeuvres { parts, .. } = manoeuvres_of(&whole, mapping)?;
    let found = match parts.len() {
        0 => "found none in it: no control moves and comes to rest".to_owned(),
        1 => "found one in it".to_owned(),
        count => format!("found {count} in it"),
    };
    let numbers = match manoeuvres {
        ManoeuvreChoice::All if parts.is_empty() => {
            return Err(Failure::file(&source.file, format!("--manoeuvre: expected manoeuvres, {found}")));
        }
        ManoeuvreChoice::All => (1..=parts.len()).collect(),
        ManoeuvreChoice::Numbers(numbers) => numbers,
    };
    let one = |number: usize| {
        let part = number.checked_sub(1).and_then(|place| parts.get(place)).ok_or_else(|| {
            let what = format!(
                "--manoeuvre: expected one of its manoeuvres, {found}, not number {number}; inspect --manoeuvres lists them"
            );
            Failure::file(&source.file, what)
        })?;
        let span = TimeSpan { from_s: Some(part.from_s), to_s: Some(part.to_s) };
        Ok(RecordingSource { span, manoeuvre: Some(number), ..whole.clone() })
    };
    numbers.into_iter().map(one).collect()
}

/// The manoeuvres of a recording, how its controls are called, and the date that its run states.
pub(crate) struct FlightManoeuvres {
    pub(crate) parts: Vec<FlightPart>,
    pub(crate) controls: ControlNames,
    pub(crate) recorded_at: Option<String>,
}

/// Reads them.
pub(crate) fn manoeuvres_of(source: &RecordingSource, mapping: &RecordingConfig) -> Result<FlightManoeuvres, Failure> {
    let HeadedRecording { mut recording, info, .. } = head_of(source, source.open(mapping)?)?;
    let mut samples = Vec::new();
    while let Some(row) = recording.next_row()? {
        samples.push(row.sample);
    }
    let controls = info.geometry().controls;
    let recorded_at = info.recorded_at().map(str::to_owned);
    Ok(FlightManoeuvres { parts: flight_parts(&samples, controls), controls, recorded_at })
}
