//! The result of one estimated run, live or replayed: tables for a person, numbers for a program, and what was lost.

use super::run_log::ClosedRunLog;
use sideslip::flight::channel::ControlNames;
use sideslip::io::outputs::event_ring::{FoldedEvent, FoldedText};
use sideslip::io::outputs::json::derivatives_json::RunEstimates;
use sideslip::io::outputs::record::EventKind;
use sideslip::io::outputs::tables::terminal::{EstimateTable, Style};
use sideslip::io::outputs::words::event_text::{Severity, event_severity};
use sideslip::io::outputs::words::finding_text::FindingsTable;
use sideslip::io::outputs::words::noise_text::NoiseUsed;
use sideslip::io::outputs::words::output_error_text::OutputErrorTable;
use sideslip::io::outputs::words::status_text::ReasonText;
use sideslip::live::record_sink::RecordSink;
use sideslip::live::wiring::FinishedRun;
use sideslip::realtime::estimation::record::{Aid, EstimationEvent};
use sideslip::realtime::modes::record::ModesRecord;
use sideslip::realtime::regression::record::{DerivativesRecord, Reason, Status};
use std::fmt::Write;

pub(crate) struct RunResult {
    pub(crate) name: String,
    controls: ControlNames,
    pub(crate) rows: u64,
    /// First and last time, s.
    pub(crate) range_s: Option<(f64, f64)>,
    sink: RecordSink,
    events: Vec<FoldedEvent>,
    /// Derivatives and modes of the frequency domain alone.
    in_band: (DerivativesRecord, ModesRecord),
    /// R^2 of incidence and sideslip against kinematics.
    consistency: [Option<f64>; 2],
    noise: Option<NoiseUsed>,
    /// Sentences about the recording itself, the first so many of them losses, which are said at the end.
    notes: Vec<String>,
    losses: usize,
    warnings: Vec<String>,
    log: Option<ClosedRunLog>,
    lost_by_output_error: u64,
    lost_by_diagnosis: u64,
}

impl RunResult {
    pub(crate) fn new(
        name: String,
        controls: ControlNames,
        range_s: Option<(f64, f64)>,
        run: FinishedRun,
        log: Option<ClosedRunLog>,
    ) -> Self {
        let FinishedRun { pipeline, sink, rows, lost_by_output_error, lost_by_diagnosis, .. } = run;
        let events = sink.events.entries().to_vec();
        let mut result = RunResult {
            name,
            controls,
            rows,
            range_s,
            sink,
            events,
            in_band: pipeline.in_band(),
            consistency: pipeline.estimator().consistency(),
            noise: NoiseUsed::of(pipeline.estimator().noise(), pipeline.estimator().instrumentation()),
            notes: Vec::new(),
            losses: 0,
            warnings: Vec::new(),
            log,
            lost_by_output_error,
            lost_by_diagnosis,
        };
        result.warnings = result.warnings();
        result
    }

    /// The result of a recording: with notes on the file, the first so many of which are losses, and a vane's disagreement as it
    /// stands at the end, not at first sight.
    pub(crate) fn of_recording(self, notes: Vec<String>, losses: usize) -> Self {
        let events = self.events.iter().map(|event| with_final_r2(*event, self.consistency)).collect();
        let mut result = RunResult { events, notes, losses, ..self };
        result.warnings = result.warnings();
        result
    }

    pub(crate) fn estimates(&self) -> RunEstimates<'_> {
        RunEstimates {
            run: &self.name,
            controls: self.controls,
            state: self.sink.state.as_ref(),
            derivatives: self.sink.derivatives.as_ref(),
            modes: self.sink.modes.as_ref(),
            output_error: self.sink.output_error.as_ref(),
            findings: self.sink.findings.records(),
            warnings: &self.warnings,
            consistency: self.consistency,
            noise: self.noise,
        }
    }

    /// The same with the derivatives and modes of the frequency domain alone.
    pub(crate) fn estimates_in_band(&self) -> RunEstimates<'_> {
        let (derivatives, modes) = &self.in_band;
        RunEstimates { derivatives: Some(derivatives), modes: Some(modes), ..self.estimates() }
    }

    /// Whether any derivative was estimated, by the regression or by output error.
    pub(crate) fn has_derivatives(&self) -> bool {
        let regression = self.sink.derivatives.iter().flat_map(|record| &record.equations);
        regression.flat_map(|equation| &equation.terms).any(|term| term.variable.is_some() && term.std.is_finite())
            || self.sink.output_error.as_ref().is_some_and(|record| !record.parameters.is_empty())
    }

    /// Why the pipeline withholds derivatives, where an instrument is in doubt.
    pub(crate) fn instrument_doubt(&self) -> Option<String> {
        let equations = self.sink.derivatives.iter().flat_map(|record| &record.equations);
        let reason = equations.filter_map(|equation| match equation.status {
            Status::NotIdentifiable(reason @ Reason::InstrumentDoubted { .. }) => Some(reason),
            _ => None,
        });
        reason.map(|reason| ReasonText { reason, controls: self.controls }.to_string()).next()
    }

    /// Data that were lost or not used, a sentence each.
    pub(crate) fn losses(&self) -> Vec<String> {
        let mut losses = self.sink.losses(self.rows);
        losses.extend(self.log.as_ref().and_then(ClosedRunLog::loss));
        losses
    }

    /// Every table, from the derivatives on.
    pub(crate) fn tables(&self, style: Style) -> String {
        let controls = self.controls;
        let (derivatives, modes) = (self.sink.derivatives.as_ref(), self.sink.modes.as_ref());
        let excited_until_s = self.sink.excited_until_s;
        let notes = self.notes.get(self.losses..).unwrap_or_default();
        let mut text =
            EstimateTable { controls, derivatives, modes, excited_until_s, events: &self.events, notes, style }.to_string();
        if let Some(record) = &self.sink.output_error {
            let now_s = self.range_s.map_or(record.time_s, |(_, to_s)| to_s);
            let _ = write!(text, "{}", OutputErrorTable { record, now_s, controls, style });
        }
        let _ = write!(text, "{}", FindingsTable { findings: self.sink.findings.records(), style });
        for (what, lost) in [("output error", self.lost_by_output_error), ("the diagnosis", self.lost_by_diagnosis)] {
            if lost > 0 {
                let _ = writeln!(text, "{what} did not keep up: {lost} samples and publications were dropped");
            }
        }
        if let Some(noise) = &self.noise {
            let _ = writeln!(text, "{noise}");
        }
        if let Some(log) = &self.log {
            let _ = writeln!(text, "log: {}, {} messages", log.path.display(), log.written);
        }
        text
    }

    fn warnings(&self) -> Vec<String> {
        let shown = self.events.iter().filter(|event| event_severity(&event.kind) > Severity::Info);
        let events = shown.map(|event| FoldedText { event, controls: self.controls }.to_string());
        self.notes.iter().cloned().chain(events).collect()
    }
}

fn with_final_r2(mut event: FoldedEvent, consistency: [Option<f64>; 2]) -> FoldedEvent {
    if let EventKind::Estimation(EstimationEvent::KinematicsDisagree { aid, r_squared }) = &mut event.kind {
        let [alpha, beta] = consistency;
        let at_end = if *aid == Aid::Incidence { alpha } else { beta };
        *r_squared = at_end.unwrap_or(*r_squared);
    }
    event
}
