//! Recordings read whole, a run each, as commands on samples take them.

use super::recording_losses::losses;
use crate::command::options::telemetry_source::RecordingSource;
use crate::command::recordings::run_head::{HeadedRecording, head_of};
use crate::command::terminal::console::message_once;
use sideslip::error::Failure;
use sideslip::flight::channel::ControlNames;
use sideslip::flight::file::run_file::RunInfo;
use sideslip::flight::sample::Sample;
use sideslip::io::outputs::words::control_scale::assumed_scale;
use sideslip::io::telemetry::recording_config::RecordingConfig as Mapping;
use sideslip::postflight::reconstruction::screening::{Screened, screen};
use std::path::Path;

pub(crate) struct RunInput {
    pub(crate) name: String,
    pub(crate) info: RunInfo,
    pub(crate) samples: Vec<Sample>,
    /// What of it was lost, a sentence each.
    pub(crate) losses: Vec<String>,
}

/// Reads a recording.
pub(crate) fn read_run(source: &RecordingSource, mapping: &Mapping) -> Result<RunInput, Failure> {
    let file = &source.file;
    let HeadedRecording { mut recording, info, .. } = head_of(source, source.open_with_note(mapping)?)?;
    if let Some(note) = assumed_scale(&info) {
        message_once(format_args!("note: {}: {note}", file.display()));
    }
    let mut samples = Vec::new();
    while let Some(row) = recording.next_row()? {
        samples.push(row.sample);
    }
    let losses = losses(file, &recording, samples.len());
    Ok(RunInput { name: info.run().unwrap_or_default().to_owned(), info, samples, losses })
}

/// The same, samples that no instrument measured taken out and told among the losses.
pub(crate) fn read_screened(source: &RecordingSource, mapping: &Mapping) -> Result<RunInput, Failure> {
    let mut run = read_run(source, mapping)?;
    let taken = screen(&mut run.samples);
    let controls = run.info.geometry().controls;
    run.losses.extend(taken.iter().map(|one| screened(&source.file, one, controls)));
    Ok(run)
}

/// Runs of two aircraft have no one model.
pub(crate) fn refuse_two_aircraft<'r>(runs: impl Iterator<Item = (&'r RunInput, &'r RecordingSource)>) -> Result<(), Failure> {
    let mut named = runs.filter_map(|(one, source)| Some((one.info.aircraft()?, &source.file)));
    let Some((first, _)) = named.next() else { return Ok(()) };
    match named.find(|(other, _)| *other != first) {
        Some((other, file)) => Err(Failure::file(file, format!("expected runs of one aircraft, `{first}`, found `{other}`"))),
        None => Ok(()),
    }
}

/// What was not used of a recording, in one line.
pub(crate) fn screened(file: &Path, one: &Screened, controls: ControlNames) -> String {
    let (file, channel, why) = (file.display(), one.channel.name(controls), one.damage.words());
    let [from_s, to_s] = one.range_s;
    let when = if one.count == 1 { format!("at {from_s:.2} s") } else { format!("from {from_s:.2} to {to_s:.2} s") };
    format!(
        "{file}: {} of {channel} not used, {when}: {why}",
        if one.count == 1 { "1 sample".to_owned() } else { format!("{} samples", one.count) }
    )
}
