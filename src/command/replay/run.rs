//! One run: a recording through a pipeline of its own, and what it came to.

use super::super::estimation_options::OutputError;
use super::super::ingest::head_of;
use super::super::model_beside::{Beside, ModelBeside};
use super::super::progress::Progress;
use super::from_bus::FromBus;
use super::log::{Log, Logged};
use super::sink::Sink;
use super::smoothed::{Record, Written};
use ::replay::{MonotonicClock, Pace};
use sideslip::error::Failure;
use sideslip::estimation::record::{Aid, EstimationEvent};
use sideslip::flight::channel::ControlNames;
use sideslip::flight::log_head::LogHead;
use sideslip::flight::run_file::RunInfo;
use sideslip::identification::follower::Follow;
use sideslip::identification::live::{Live, Seen};
use sideslip::modes::record::ModesRecord;
use sideslip::outputs::derivatives_json::RunEstimates;
use sideslip::outputs::event_ring::{FoldedEvent, FoldedText};
use sideslip::outputs::finding_text::FindingsTable;
use sideslip::outputs::noise::NoiseUsed;
use sideslip::outputs::output_error_text::OutputErrorTable;
use sideslip::outputs::record::EventKind;
use sideslip::outputs::terminal::{Style, Table};
use sideslip::outputs::text::{Severity, event_severity};
use sideslip::pipeline::{Config, Pipeline};
use sideslip::regression::record::DerivativesRecord;
use sideslip::telemetry::mavlink::mapping::Config as Mapping;
use sideslip::telemetry::mavlink::recording::Traffic;
use sideslip::telemetry::recording::Recording;
use std::fmt::Write;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};

/// The way of a recording to the pipeline.
pub(in super::super) enum From<'a> {
    /// Read in this process.
    File,
    /// Through shared memory, read by another process with the same keys overridden.
    Bus {
        /// As given to `--set`.
        overrides: &'a [String],
        /// As given to `--config`.
        config: Option<&'a Path>,
    },
}

/// What a run writes besides its answer.
pub(in super::super) struct Files<'a> {
    /// Its log.
    pub(in super::super) log: Option<&'a Path>,
    /// Its smoothed states.
    pub(in super::super) smoothed: Option<&'a Path>,
}

/// A recording with its pipeline, before the first sample.
pub(in super::super) struct Run {
    file: PathBuf,
    recording: Recording,
    info: RunInfo,
    head: LogHead,
    config: Config,
    pipeline: Box<Pipeline>,
    live: Option<Live>,
    beside: Option<Beside>,
}

/// What a run came to.
pub(in super::super) struct Played {
    file: PathBuf,
    name: String,
    controls: ControlNames,
    /// Aircraft and manoeuvre, where the run names them.
    about: Vec<String>,
    /// Who sent how much, of a recording of MAVLink.
    traffic: Option<String>,
    rows: u64,
    range_s: Option<(f64, f64)>,
    sink: Sink,
    events: Vec<FoldedEvent>,
    in_band: (DerivativesRecord, ModesRecord),
    consistency: [Option<f64>; 2],
    noise: Option<NoiseUsed>,
    /// Rows skipped, a file cut short: sentences about the recording itself; the first so many are losses.
    notes: Vec<String>,
    losses: usize,
    warnings: Vec<String>,
    log: Option<Logged>,
    smoothed: Option<Written>,
    /// Whether a signal stopped it before its end.
    pub(super) interrupted: bool,
}

impl Run {
    /// Opens a recording, overrides keys of its run and readies the pipeline.
    pub(in super::super) fn open(file: &Path, overrides: &[String], config: &Config, mapping: &Mapping) -> Result<Self, Failure> {
        let recording = Recording::open_with(file, mapping)?;
        let (info, head) = head_of(file, &recording, overrides)?;
        let pipeline = Pipeline::new(config, *info.geometry()).map_err(|wrong| Failure::Input(wrong.to_string()))?;
        Ok(Run {
            file: file.into(),
            recording,
            info,
            head,
            config: *config,
            pipeline: Box::new(pipeline),
            live: None,
            beside: None,
        })
    }

    /// The same with output error beside it, in step with the record's own time.
    pub(in super::super) fn with_output_error(self, when: OutputError) -> Self {
        let live = when.live(*self.info.geometry());
        Run { live, ..self }
    }

    /// The same held against a model, where there is one, in step with the record's own time.
    pub(in super::super) fn held_against(self, model: Option<&ModelBeside>) -> Self {
        let beside = model.map(|model| model.live(*self.info.geometry()));
        Run { beside, ..self }
    }

    /// Plays it to its end, or until `stop`. Where reading fails in the middle, the log is closed with what came before.
    pub(in super::super) fn play(
        mut self,
        from: &From<'_>,
        pace: Pace,
        files: &Files<'_>,
        stop: &AtomicBool,
    ) -> Result<Played, Failure> {
        let mut player = ::replay::Player::<MonotonicClock>::new(pace);
        let mut bus = match from {
            From::File => None,
            From::Bus { overrides, config } => Some(FromBus::start(&self.file, &self.head, pace, overrides, *config)?),
        };
        let mut progress = Progress::new();
        let name = self.info.run().unwrap_or_default().to_owned();
        let mut rows = 0;
        let mut range_s: Option<(f64, f64)> = None;
        let (mut writing, mut kept) = (None, Vec::new());
        let mut sink = Sink::new(None);
        let (on_bus, mut interrupted) = (bus.is_some(), false);
        let read = loop {
            let row = match &mut bus {
                None => self.recording.next_row().map_err(Failure::from),
                Some(bus) => bus.next_row(stop),
            };
            let row = match row {
                Ok(Some(row)) => row,
                ended => break ended.map(|_| ()),
            };
            if rows == 0
                && let Some(path) = files.log
            {
                // A file waits for its log at any pace; what comes over the bus does not.
                let (sender, started) = Log::start(path, self.head.clone(), if on_bus { pace } else { Pace::Max })?;
                sink = Sink::new(Some(sender));
                writing = Some(started);
            }
            let time_s = row.sample.time_s;
            // On the bus the process that brings the recording in keeps the pace.
            if !on_bus && !player.wait_for(time_s, || !stop.load(Ordering::Relaxed)) {
                interrupted = true;
                break Ok(());
            }
            rows += 1;
            if time_s.is_finite() {
                range_s = Some(range_s.map_or((time_s, time_s), |(from, to)| (from.min(time_s), to.max(time_s))));
            }
            let sample = row.sample;
            if files.smoothed.is_some() {
                kept.push(row.clone());
            }
            sink.row(row);
            let tick = self.pipeline.step(&sample);
            if let Some(bus) = &mut bus {
                bus.tick(tick)?;
            }
            sink.tick(tick);
            let seen = tick.derivatives.as_ref().map(Seen::from);
            let mut told = Ok(());
            if let Some(live) = &mut self.live {
                live.step(&sample, seen.as_ref(), &mut |record| {
                    sink.output_error(&record);
                    if let (Some(bus), Ok(())) = (bus.as_mut(), &told) {
                        told = bus.output_error(&record);
                    }
                });
            }
            if let Some(beside) = &mut self.beside {
                beside.step(&sample, seen.as_ref(), &mut |record| {
                    sink.finding(&record);
                    if let (Some(bus), Ok(())) = (bus.as_mut(), &told) {
                        told = bus.finding(&record);
                    }
                });
            }
            told?;
            progress.show(|| progress_line(&name, time_s, &sink));
        };
        sink.tick(self.pipeline.finish());
        if let Some(live) = &mut self.live {
            live.finish();
            if live.is_due() {
                sink.output_error(live.refit());
            }
        }
        if let Some(beside) = &mut self.beside {
            beside.end(&mut |record| sink.finding(&record));
        }
        sink.close();
        let log = writing.map(Log::finish).transpose()?;
        read?;
        if let Some(bus) = bus {
            interrupted = stop.load(Ordering::Relaxed);
            bus.end()?;
            // What the recording lacks is the recording's to say.
            while !interrupted && self.recording.next_row()?.is_some() {}
        }
        let mut smoothed = None;
        if let Some(path) = files.smoothed.filter(|_| !interrupted) {
            let record = Record { file: &self.file, info: &self.info, head: &self.head, rows: &kept };
            smoothed = record.write(path, &self.config.estimation, |part| {
                progress.show(|| format!("{name}: smoothing, {:.0} % done", 100.0 * part));
                !stop.load(Ordering::Relaxed)
            })?;
            interrupted = smoothed.is_none();
        }
        drop(progress);
        let played = self.played(name, rows, range_s, sink, log, interrupted);
        Ok(Played { smoothed, ..played })
    }

    fn played(
        self,
        name: String,
        rows: u64,
        range_s: Option<(f64, f64)>,
        sink: Sink,
        log: Option<Logged>,
        interrupted: bool,
    ) -> Played {
        let consistency = self.pipeline.estimator().consistency();
        let events = sink.events.entries().iter().map(|event| with_final_r2(*event, consistency)).collect();
        let controls = self.info.geometry().controls;
        let about = ["aircraft", "manoeuvre", "flight_path"].iter().filter_map(|key| self.info.text(key)).map(String::from);
        let traffic = self.recording.traffic().map(|traffic| {
            let (messages, senders) = (traffic.tally.good, traffic.senders.iter().count());
            let Traffic { vehicle, boots, .. } = traffic;
            format!("MAVLink: {messages} messages of {senders} senders; vehicle {vehicle}, {boots} boots")
        });
        let notes = recording_losses(&self.recording, rows);
        let mut played = Played {
            about: about.collect(),
            traffic,
            losses: notes.len(),
            notes,
            file: self.file,
            name,
            controls,
            rows,
            range_s,
            sink,
            events,
            in_band: self.pipeline.in_band(),
            consistency,
            noise: NoiseUsed::of(self.pipeline.estimator().noise(), self.pipeline.estimator().instrumentation()),
            warnings: Vec::new(),
            log,
            smoothed: None,
            interrupted,
        };
        if self.recording.ends_abruptly() && played.losses == 0 && !interrupted {
            let note = "the last line has no end: the file may have been cut short, and the last value with it";
            played.notes.push(note.into());
        }
        played.warnings = played.warnings();
        played
    }
}

/// A vane's disagreement as it stands at the end, not at first sight.
fn with_final_r2(mut event: FoldedEvent, consistency: [Option<f64>; 2]) -> FoldedEvent {
    if let EventKind::Estimation(EstimationEvent::KinematicsDisagree { aid, r_squared }) = &mut event.kind {
        let [alpha, beta] = consistency;
        let at_end = if *aid == Aid::Incidence { alpha } else { beta };
        *r_squared = at_end.unwrap_or(*r_squared);
    }
    event
}

fn recording_losses(recording: &Recording, rows: u64) -> Vec<String> {
    let skipped = recording.skipped();
    let mut losses = Vec::new();
    if skipped.rows() > 0 {
        let mut sentence = format!("{} of {} rows skipped", skipped.rows(), skipped.rows() + rows);
        for reason in skipped.reasons() {
            let place = format_args!("first at {} {}: {}", recording.counted_in(), reason.first, reason.example);
            let _ = write!(sentence, "; {} for: {}, {place}", reason.rows, reason.reason.words());
        }
        losses.push(sentence);
    }
    losses.extend(recording.shortfall());
    losses
}

fn progress_line(name: &str, time_s: f64, sink: &Sink) -> String {
    let name: String = name.chars().take(30).collect();
    match sink.modes.and_then(|modes| modes.dutch_roll) {
        Some(pair) => format!("{name}: {time_s:.1} s, Dutch roll omega {:.3} rad/s, zeta {:.3}", pair.omega, pair.zeta),
        None => format!("{name}: {time_s:.1} s"),
    }
}

impl Played {
    /// The numbers for a program.
    pub(in super::super) fn estimates(&self) -> RunEstimates<'_> {
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

    /// The same from the band of frequencies alone.
    pub(in super::super) fn estimates_in_band(&self) -> RunEstimates<'_> {
        let (derivatives, modes) = &self.in_band;
        RunEstimates { derivatives: Some(derivatives), modes: Some(modes), ..self.estimates() }
    }

    /// What was lost or skipped, a sentence each.
    pub(super) fn losses(&self) -> Vec<String> {
        let mut losses: Vec<String> = self.notes.iter().take(self.losses).cloned().collect();
        losses.extend(self.sink.losses(self.rows));
        losses.extend(self.log.as_ref().and_then(Logged::loss));
        let file = self.file.display();
        losses.into_iter().map(|loss| format!("{file}: {loss}")).collect()
    }

    /// That a signal stopped it and where, and how many recordings it kept from being played.
    pub(super) fn interruption(&self, unplayed: usize) -> String {
        let reached = match self.range_s {
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

    /// The answer for a person.
    pub(super) fn table(&self, style: Style) -> String {
        let mut text = format!("{}: {} samples", self.file.display(), self.rows);
        if let Some((from, to)) = self.range_s {
            let _ = write!(text, ", {from:.2} to {to:.2} s");
        }
        let _ = write!(text, "\nrun {}", self.name);
        for about in &self.about {
            let _ = write!(text, ", {about}");
        }
        if let Some(traffic) = &self.traffic {
            let _ = write!(text, "\n{traffic}");
        }
        let (derivatives, modes) = (self.sink.derivatives.as_ref(), self.sink.modes.as_ref());
        let table = Table { controls: self.controls, derivatives, modes, events: &self.events, notes: &self.notes, style };
        let _ = write!(text, "\n{table}");
        if let Some(record) = &self.sink.output_error {
            let now_s = self.range_s.map_or(record.time_s, |(_, to_s)| to_s);
            let _ = write!(text, "{}", OutputErrorTable { record, now_s, controls: self.controls, style });
        }
        let _ = write!(text, "{}", FindingsTable { findings: self.sink.findings.records(), style });
        if let Some(noise) = &self.noise {
            let _ = writeln!(text, "{noise}");
        }
        if let Some(log) = &self.log {
            let _ = writeln!(text, "log: {}, {} messages", log.path.display(), log.written);
        }
        if let Some(smoothed) = &self.smoothed {
            let _ = writeln!(text, "{}", smoothed.line());
        }
        text
    }

    fn warnings(&self) -> Vec<String> {
        let told = self.events.iter().filter(|event| event_severity(&event.kind) > Severity::Info);
        let events = told.map(|event| FoldedText { event, controls: self.controls }.to_string());
        self.notes.iter().cloned().chain(events).collect()
    }
}
