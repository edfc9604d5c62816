//! One recording through the pipeline: from a file in this process, or through shared memory.

use super::bus_source::BusSource;
use super::derivative_history::DerivativeHistory;
use super::smoothed_file::{RunToSmooth, SmoothedFile};
use crate::command::options::estimation_options::OutputErrorSchedule;
use crate::command::options::live_diagnosis_options::LiveDiagnosisModel;
use crate::command::options::mapping_input::MapOption;
use crate::command::options::telemetry_source::RecordingSource;
use crate::command::recordings::provenance::Provenance;
use crate::command::recordings::recording_losses::recording_notes;
use crate::command::recordings::run_head::{HeadedRecording, head_of};
use crate::command::recordings::run_log::{ClosedRunLog, RunLog};
use crate::command::recordings::run_result::RunResult;
use crate::command::terminal::progress_line::ProgressLine;
use ::replay::{MonotonicClock, Pace};
use sideslip::error::Failure;
use sideslip::flight::file::log_head::LogHead;
use sideslip::flight::file::run_file::RunInfo;
use sideslip::io::outputs::json::derivatives_json::RunEstimates;
use sideslip::io::outputs::tables::terminal::Style;
use sideslip::io::outputs::words::printable::printable;
use sideslip::io::telemetry::alignment::aligned_recording::AlignedRecording;
use sideslip::io::telemetry::mavlink::recording::Traffic;
use sideslip::io::telemetry::recording_config::RecordingConfig as Mapping;
use sideslip::live::record_sink::RecordSink;
use sideslip::live::wiring::{FinishedRun, Schedule, WiredRun};
use sideslip::live::{diagnosis, output_error};
use sideslip::realtime::pipeline::{Pipeline, PipelineConfig};
use std::fmt::Write;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// The way of a recording to the pipeline.
pub(super) enum ReplaySource<'a> {
    /// Read in this process.
    File,
    /// Through shared memory, read by another process.
    Bus {
        /// As given to `--config`.
        config: Option<&'a Path>,
        /// As given to `--map`.
        map: &'a MapOption,
    },
}

/// What a run writes besides its answer.
pub(super) struct ReplayFiles<'a> {
    pub(super) log: Option<&'a Path>,
    pub(super) smoothed: Option<&'a Path>,
    pub(super) derivatives: Option<&'a Path>,
}

/// A recording with its pipeline, before the first sample.
pub(super) struct ReplayRun {
    source: RecordingSource,
    recording: AlignedRecording,
    /// What the run is called in the answer.
    pub(super) name: String,
    info: RunInfo,
    head: LogHead,
    config: PipelineConfig,
    pipeline: Pipeline,
    output_error: Option<output_error::LiveOutputError>,
    diagnosis: Option<diagnosis::LiveDiagnosis>,
}

/// A replayed run with its results.
pub(super) struct ReplayedRun {
    file: PathBuf,
    result: RunResult,
    /// Aircraft and manoeuvre, where the run names them.
    about: Vec<String>,
    /// Senders and message counts of a recording of MAVLink.
    traffic: Option<String>,
    /// Rows skipped, a file cut short: a sentence each.
    recording_losses: Vec<String>,
    smoothed: Option<SmoothedFile>,
    /// Whether a signal stopped it before its end.
    pub(super) interrupted: bool,
    recorded_at: Option<String>,
}

impl ReplayRun {
    /// Opens a recording, overrides keys of its run and readies the pipeline.
    pub(super) fn open(source: &RecordingSource, config: &PipelineConfig, mapping: &Mapping) -> Result<Self, Failure> {
        let HeadedRecording { recording, info, mut head } = head_of(source, source.open_with_note(mapping)?)?;
        head.origin = Provenance::of(source.files()).dated(&source.file, info.recorded_at()).origin();
        let pipeline = Pipeline::new(config, *info.geometry()).map_err(|wrong| Failure::Input(wrong.to_string()))?;
        Ok(ReplayRun {
            source: source.clone(),
            recording,
            name: info.run().unwrap_or_default().to_owned(),
            info,
            head,
            config: *config,
            pipeline,
            output_error: None,
            diagnosis: None,
        })
    }

    /// The same with output error beside it, in step with the record's own time.
    pub(super) fn with_output_error(self, when: OutputErrorSchedule) -> Self {
        let output_error = when.live(*self.info.geometry());
        ReplayRun { output_error, ..self }
    }

    /// The same held against a model, where there is one, in step with the record's own time.
    pub(super) fn with_diagnosis(self, model: Option<&LiveDiagnosisModel>) -> Self {
        let diagnosis = model.map(|model| model.live(*self.info.geometry()));
        ReplayRun { diagnosis, ..self }
    }

    /// Plays it to its end, or until `stop`. Where reading fails in the middle, the log is closed with what came before.
    pub(super) fn play(
        mut self,
        from: &ReplaySource<'_>,
        pace: Pace,
        files: &ReplayFiles<'_>,
        stop: &Arc<AtomicBool>,
    ) -> Result<ReplayedRun, Failure> {
        self.recording.recording.stop_by(Arc::clone(stop));
        let mut player = ::replay::Player::<MonotonicClock>::new(pace);
        let mut bus = match from {
            ReplaySource::File => None,
            ReplaySource::Bus { config, map } => Some(BusSource::start(&self.source, &self.head, pace, *config, map)?),
        };
        let mut progress = ProgressLine::new();
        let name = std::mem::take(&mut self.name);
        let (mut writing, mut kept, mut history) = (None, Vec::new(), DerivativeHistory::default());
        let ReplayRun { output_error, diagnosis, .. } = &mut self;
        let (output_error, diagnosis) = (output_error.take().map(Schedule::InStep), diagnosis.take().map(Schedule::InStep));
        let mut wired = WiredRun::new(self.pipeline, self.info.geometry().controls, output_error, diagnosis);
        let on_bus = bus.is_some();
        let mut interrupted;
        let read = loop {
            let next = match &mut bus {
                None => self.recording.next_row().map(|row| row.map(|row| (row, None))).map_err(Failure::from),
                Some(bus) => bus.next_row(stop).map(|next| next.map(|(row, publication)| (row, Some(publication)))),
            };
            let (row, publication) = match next {
                Ok(Some(next)) => next,
                ended => {
                    interrupted = stop.load(Ordering::Relaxed);
                    break ended.map(|_| ());
                }
            };
            if wired.rows() == 0
                && let Some(path) = files.log
            {
                // A file waits for its log at any pace; what comes over the bus does not.
                let (sender, started) = RunLog::start(path, self.head.clone(), if on_bus { pace } else { Pace::Max })?;
                wired.sink = RecordSink::new(Some(sender));
                writing = Some(started);
            }
            let time_s = row.sample.time_s;
            // On the bus the process that brings the recording in keeps the pace.
            if !on_bus && !player.wait_for(time_s, || !stop.load(Ordering::Relaxed)) {
                interrupted = true;
                break Ok(());
            }
            if files.smoothed.is_some() {
                kept.push(row.clone());
            }
            match publication {
                Some(mut publication) => wired.step(row, &mut publication)?,
                None => wired.step(row, &mut ()).unwrap_or_else(|never| match never {}),
            }
            if files.derivatives.is_some() {
                history.take(wired.sink.derivatives.as_ref(), wired.sink.modes.as_ref());
            }
            progress.show(|| wired.sink.progress(&name, time_s));
        };
        let finished = wired.finish(&mut ()).unwrap_or_else(|never| match never {});
        if let Some(path) = files.derivatives {
            history.take(finished.sink.derivatives.as_ref(), finished.sink.modes.as_ref());
            history.write(path, &self.info)?;
        }
        let log = writing.map(RunLog::finish).transpose()?;
        read?;
        if let Some(bus) = bus {
            interrupted = stop.load(Ordering::Relaxed);
            bus.end()?;
            // What the recording lacks is the recording's to say.
            while !interrupted && self.recording.next_row()?.is_some() {}
        }
        let mut smoothed = None;
        if let Some(path) = files.smoothed.filter(|_| !interrupted) {
            let record = RunToSmooth { file: &self.source.file, info: &self.info, head: &self.head, rows: &kept };
            smoothed = record.write(path, &self.config.estimation, |part| {
                progress.show(|| format!("{name}: smoothing, {:.0} % done", 100.0 * part));
                !stop.load(Ordering::Relaxed)
            })?;
            interrupted = smoothed.is_none();
        }
        drop(progress);
        let ended = EndedReplay { file: self.source.file, info: &self.info, recording: &self.recording, name, interrupted };
        let played = ReplayedRun::new(ended, finished, log);
        Ok(ReplayedRun { smoothed, ..played })
    }
}

/// A recording at its end, before its result is made.
struct EndedReplay<'a> {
    file: PathBuf,
    info: &'a RunInfo,
    recording: &'a AlignedRecording,
    name: String,
    interrupted: bool,
}

impl ReplayedRun {
    fn new(run: EndedReplay<'_>, finished: FinishedRun, log: Option<ClosedRunLog>) -> Self {
        let EndedReplay { file, info, recording, name, interrupted } = run;
        let about = ["aircraft", "manoeuvre", "flight_path"].iter().filter_map(|key| info.text(key)).map(String::from);
        let traffic = recording.recording.traffic().map(|traffic| {
            let (messages, senders) = (traffic.tally.good, traffic.senders.iter().count());
            let Traffic { vehicle, boots, .. } = traffic;
            format!("MAVLink: {messages} messages of {senders} senders; vehicle {vehicle}, {boots} boots")
        });
        let (notes, losses) = recording_notes(recording, finished.rows, interrupted);
        let recording_losses = notes.iter().take(losses).cloned().collect();
        let result = RunResult::new(name, info.geometry().controls, finished.range_s, finished, log).of_recording(notes, losses);
        ReplayedRun {
            file,
            result,
            about: about.collect(),
            traffic,
            recording_losses,
            smoothed: None,
            interrupted,
            recorded_at: info.recorded_at().map(str::to_owned),
        }
    }

    /// Its file, and the date that its run states.
    pub(super) fn date(&self) -> (&Path, Option<&str>) {
        (&self.file, self.recorded_at.as_deref())
    }

    pub(super) fn estimates(&self) -> RunEstimates<'_> {
        self.result.estimates()
    }

    /// Whether any derivative was estimated.
    pub(super) fn has_derivatives(&self) -> bool {
        self.result.has_derivatives()
    }

    /// Data that were lost or skipped, a sentence each.
    pub(super) fn losses(&self) -> Vec<String> {
        let file = self.file.display();
        let losses = self.recording_losses.iter().cloned().chain(self.result.losses());
        losses.map(|loss| format!("{file}: {loss}")).collect()
    }

    /// Where a signal stopped it, and how many recordings were not played.
    pub(super) fn interruption(&self, unplayed: usize) -> String {
        let reached = match self.result.range_s {
            _ if !self.interrupted => "at its end".to_owned(),
            None => "before its first sample".to_owned(),
            Some((_, to_s)) => format!("at {to_s:.2} s"),
        };
        let others = match unplayed {
            0 => String::new(),
            count => format!(", and {count} more not played"),
        };
        format!("{}: stopped by a signal {reached}{others}", self.file.display())
    }

    pub(super) fn table(&self, style: Style) -> String {
        let mut text = format!("{}: {} samples", printable(&self.file.display().to_string()), self.result.rows);
        if let Some((from, to)) = self.result.range_s {
            let _ = write!(text, ", {from:.2} to {to:.2} s");
        }
        let _ = write!(text, "\nrun {}", printable(&self.result.name));
        for about in &self.about {
            let _ = write!(text, ", {}", printable(about));
        }
        if let Some(traffic) = &self.traffic {
            let _ = write!(text, "\n{traffic}");
        }
        let _ = write!(text, "\n{}", self.result.tables(style));
        if let Some(smoothed) = &self.smoothed {
            let _ = writeln!(text, "{}", smoothed.line());
        }
        text
    }
}
