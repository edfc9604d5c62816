//! The controls of a recorded run, as `simulate` flies them again.

use crate::command::options::telemetry_source::RecordingSource;
use crate::command::recordings::run_head::aligned_by_its_own;
use sideslip::error::Failure;
use sideslip::flight::channel::Channel;
use sideslip::flight::control::{CONTROLS, Control};
use sideslip::flight::signal::piecewise_linear::History;
use sideslip::io::telemetry::recording_config::RecordingConfig;

/// Controls and rotor speed of a run over its own time.
#[derive(Debug)]
pub(crate) struct ControlHistory {
    /// By [`Control`] place; `None` where the run has no such channel.
    pub(crate) controls: [Option<History>; CONTROLS],
    /// Rotor speed, where the run has it.
    pub(crate) rotor_speed: Option<History>,
    /// Times of the run's samples, s.
    pub(crate) times_s: Vec<f64>,
    /// What the run's header says of the Level-1 model that flew it; empty where it says nothing.
    pub(crate) level1: toml::Table,
    /// What of the recording could not be read, a sentence each.
    pub(crate) losses: Vec<String>,
}

impl ControlHistory {
    /// Flight condition and options that the header has otherwise than `flown`: key, value then, value now.
    pub(crate) fn differing(&self, flown: &toml::Table) -> Vec<(String, toml::Value, toml::Value)> {
        let mut all = Vec::new();
        for table in ["flight", "options"] {
            let (Some(then), Some(now)) = (part(&self.level1, table), part(flown, table)) else { continue };
            for (key, was) in then {
                if let Some(is) = now.get(key).filter(|is| *is != was) {
                    all.push((format!("{table}.{key}"), was.clone(), is.clone()));
                }
            }
        }
        all
    }

    /// The first sample's time, s.
    pub(crate) fn start_s(&self) -> f64 {
        self.times_s.first().copied().unwrap_or_default()
    }

    /// The last sample's time, s.
    pub(crate) fn end_s(&self) -> f64 {
        self.times_s.last().copied().unwrap_or_default()
    }
}

fn part<'a>(table: &'a toml::Table, key: &str) -> Option<&'a toml::Table> {
    table.get(key).and_then(toml::Value::as_table)
}

/// Reads the controls of a recording. A row that cannot be read is left out (a straight line goes past it) and counted.
pub(crate) fn read_controls(source: &RecordingSource, mapping: &RecordingConfig) -> Result<ControlHistory, Failure> {
    let path = source.file.as_path();
    let mut aligned = aligned_by_its_own(source, source.open_with_note(mapping)?)?;
    let recording = &aligned.recording;
    let mut times_s: Vec<f64> = Vec::new();
    let mut points: [Vec<(f64, f64)>; CONTROLS + 1] = Default::default();
    let wanted = [Channel::CONTROLS.as_slice(), &[Channel::RotorSpeed]].concat();
    let level1 = part(recording.info().document(), "level1").cloned().unwrap_or_default();
    let (counted_in, controls) = (recording.counted_in(), recording.info().geometry().controls);
    while let Some(row) = aligned.next_row()? {
        let wrong = |what: String| Failure::file(path, format_args!("{counted_in} {}: {what}", row.number));
        let time_s = row.sample.time_s;
        if !time_s.is_finite() || times_s.last().is_some_and(|&last| time_s <= last) {
            return Err(wrong(format!("expected a time that increases, found {time_s} s")));
        }
        times_s.push(time_s);
        for (&channel, points) in wanted.iter().zip(&mut points) {
            let Some(value) = row.sample.get(channel) else { continue };
            if !value.is_finite() {
                return Err(wrong(format!("`{}`: expected a finite number, found {value}", channel.name(controls))));
            }
            points.push((time_s, value));
        }
    }
    let recording = &aligned.recording;
    let skipped = recording.skipped().reasons().iter();
    let losses = skipped
        .map(|rows| format!("{} rows skipped for: {}, first at {counted_in} {}", rows.rows, rows.reason.words(), rows.first))
        .chain(aligned.losses())
        .collect();
    let mut histories = points.into_iter().map(|points| History::through(points).ok());
    let controls = Control::ALL.map(|_| histories.next().flatten());
    Ok(ControlHistory { controls, rotor_speed: histories.next().flatten(), times_s, level1, losses })
}
