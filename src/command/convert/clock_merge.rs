//! A second recording of the same flight, with a clock of its own: the relation of the clocks given, or estimated from a channel
//! that both have.

use crate::command::message;
use crate::command::options::telemetry_source::RecordingSource;
use crate::command::recordings::run_head::aligned_by_its_own;
use sideslip::error::Failure;
use sideslip::flight::channel::Channel;
use sideslip::flight::file::run_file::{RecordingColumn, RecordingTarget};
use sideslip::flight::signal::series::Series;
use sideslip::io::telemetry::alignment::aligned_recording::AlignedRecording;
use sideslip::io::telemetry::alignment::clock_estimation::estimate_clock_relation;
use sideslip::io::telemetry::alignment::clock_estimation::record::ClockSearch;
use sideslip::io::telemetry::alignment::clock_relation::ClockRelation;
use sideslip::io::telemetry::alignment::merge::{Merge, MergeRule};
use sideslip::io::telemetry::recording_config::RecordingConfig;
use std::path::PathBuf;

/// Rows of the two recordings nearer to each other than this are one, s.
const TOLERANCE_S: f64 = 0.1e-3;
/// Samples of the shared channel that are read at most.
const SAMPLES_MAX: usize = 20_000_000;
const PPM: f64 = 1e-6;
/// No clock drifts more, ppm.
const DRIFT_MAX_PPM: f64 = 1e5;

/// `--merge` and what belongs to it.
#[derive(clap::Args)]
pub(super) struct ClockOptions {
    /// A second recording of the flight, with another clock, whose channels are added
    #[arg(long, value_name = "RECORDING", value_parser = RecordingSource::parser())]
    merge: Option<RecordingSource>,
    /// The channel of both recordings by which their clocks are compared
    #[arg(long, value_name = "CHANNEL", requires = "merge", conflicts_with = "clock_offset")]
    shared: Option<String>,
    /// Time of the first recording where the second one's clock is zero, s, instead of an estimate
    #[arg(long, value_name = "S", requires = "merge", allow_negative_numbers = true)]
    clock_offset: Option<f64>,
    /// How much faster the first one's clock counts, parts per million; with --shared it is not estimated then
    #[arg(long, value_name = "PPM", requires = "merge", allow_negative_numbers = true)]
    clock_drift: Option<f64>,
}

/// The second recording, where there is one.
pub(super) enum SecondRecording {
    None,
    Related(Box<RelatedRecording>),
    /// The recordings do not determine the relation, which was said.
    Unknown,
}

/// A recording and the relation of its clock to the first one's.
pub(super) struct RelatedRecording {
    pub(super) file: PathBuf,
    pub(super) recording: AlignedRecording,
    relation: ClockRelation,
}

impl RelatedRecording {
    /// Its rows into those of a recording with these columns.
    pub(super) fn merge(&self, first: &[RecordingColumn]) -> Merge {
        Merge::new(first, self.recording.recording.columns(), self.relation, TOLERANCE_S, |_| MergeRule::First)
    }
}

impl ClockOptions {
    /// The files that are read.
    pub(super) fn files(&self) -> Vec<PathBuf> {
        self.merge.as_ref().map(RecordingSource::files).unwrap_or_default()
    }

    /// Opens the second recording and finds the relation of its clock to that of `first`.
    pub(super) fn second(&self, first: &RecordingSource, mapping: &RecordingConfig) -> Result<SecondRecording, Failure> {
        let Some(source) = &self.merge else { return Ok(SecondRecording::None) };
        if let Some(ppm) = self.clock_drift.filter(|ppm| !(libm::fabs(*ppm) <= DRIFT_MAX_PPM)) {
            return Err(Failure::Input(format!("--clock-drift: expected {DRIFT_MAX_PPM} ppm at most, found {ppm}")));
        }
        let drift = self.clock_drift.map(|ppm| ppm * PPM);
        let relation = match (&self.shared, self.clock_offset) {
            (Some(shared), None) => {
                let channel = Channel::from_name(shared).map(|(channel, _)| channel);
                let ours = shared_channel(first, mapping, shared, channel)?;
                let theirs = shared_channel(source, mapping, shared, channel)?;
                match estimate_clock_relation(&ours, &theirs, &ClockSearch { drift, ..ClockSearch::default() }) {
                    Ok(estimate) => {
                        let relation = estimate.relation;
                        message(format_args!(
                            "clocks by {shared}: offset {:.6} +- {:.6} s, drift {:.2} +- {:.2} ppm, over {:.1} s in common",
                            relation.offset_s(),
                            relation.offset_std_s().unwrap_or_default(),
                            relation.drift() / PPM,
                            relation.drift_std().unwrap_or_default() / PPM,
                            estimate.overlap_s
                        ));
                        relation
                    }
                    Err(why) => {
                        message(format_args!("sideslip: relation of the clocks by {shared}: {why}; nothing is written"));
                        return Ok(SecondRecording::Unknown);
                    }
                }
            }
            (None, Some(offset_s)) => ClockRelation::given(offset_s, drift.unwrap_or(0.0))
                .ok_or_else(|| Failure::Input("--clock-offset: expected a finite number of seconds".to_owned()))?,
            _ => return Err(Failure::Input("--merge: expected --shared CHANNEL or --clock-offset S beside it".to_owned())),
        };
        let recording = aligned_by_its_own(source, source.open_with_note(mapping)?)?;
        Ok(SecondRecording::Related(Box::new(RelatedRecording { file: source.file.clone(), recording, relation })))
    }
}

/// The samples of a channel, or of another column of that name.
fn shared_channel(
    source: &RecordingSource,
    mapping: &RecordingConfig,
    name: &str,
    channel: Option<Channel>,
) -> Result<Series, Failure> {
    let mut aligned = aligned_by_its_own(source, source.open(mapping)?)?;
    let recording = &aligned.recording;
    let is_shared = |column: &&RecordingColumn| match (column.target, channel) {
        (RecordingTarget::Known { channel, .. }, Some(wanted)) => channel == wanted,
        (RecordingTarget::Other, None) => column.name == name,
        _ => false,
    };
    if !recording.columns().iter().any(|column| is_shared(&column)) {
        return Err(Failure::file(&source.file, format_args!("--shared: expected a column `{name}`, found none")));
    }
    let place =
        RecordingColumn::others(recording.columns()).enumerate().find(|(_, column)| column.name == name).map(|(place, _)| place);
    let mut samples = Vec::new();
    while let Some(row) = aligned.next_row()? {
        let value = match (channel, place) {
            (Some(channel), _) => row.sample.get(channel),
            (None, Some(place)) => row.others.get(place).copied().flatten(),
            (None, None) => None,
        };
        samples.extend(value.map(|value| (row.sample.time_s, value)));
        if samples.len() > SAMPLES_MAX {
            return Err(Failure::file(&source.file, format_args!("more than {SAMPLES_MAX} samples of `{name}`")));
        }
    }
    let series = Series::of(samples);
    let turns = matches!(channel, Some(Channel::Psi | Channel::Phi));
    Ok(if turns { series.unwrapped() } else { series })
}
