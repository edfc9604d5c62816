//! The wiring of one run: pipeline, then the record sink (log and newest records), then output error, then the diagnosis.
//!
//! This is the only place that joins the real-time pipeline with what runs beside it, whoever feeds the samples (shared memory,
//! a recording, a link). In: rows in order. Out: every record, first to a [`RecordPublisher`], then to the [`RecordSink`].
//! Output error and diagnosis run in step with the samples (a recording: the same numbers at any speed) or on threads of their
//! own (live: the sample path never waits for them); see [`Schedule`].

use super::agreement::{MethodAgreement, cover_difference, limit_modes, withhold_axes};
use super::diagnosis;
use super::output_error;
use super::record_sink::RecordSink;
use super::regression_report::RegressionReport;
use super::worker::{Task, Worker};
use crate::flight::channel::ControlNames;
use crate::flight::derivative::AXES;
use crate::flight::sample::Sample;
use crate::io::outputs::words::status_text::ReasonText;
use crate::io::telemetry::record::RecordingRow;
use crate::postflight::diagnosis::record::{FindingRecord, FindingStatus};
use crate::postflight::output_error::record::{OutputErrorProgress, OutputErrorRecord};
use crate::realtime::estimation::record::Doubt;
use crate::realtime::pipeline::{Pipeline, Tick};
use crate::realtime::regression::record::Reason;
use std::io;
use std::time::Duration;

/// The longest wait for the last fit of output error, and for the last diagnosis, where they run on threads.
const LAST_FIT: Duration = Duration::from_secs(3);
const LAST_DIAGNOSIS: Duration = Duration::from_secs(8);

/// Takes the records of a sample as they are computed, such as onto shared memory.
pub trait RecordPublisher {
    /// Why a record could not be published.
    type Error;

    /// Publishes the pipeline's records of one sample.
    ///
    /// # Errors
    /// Where publishing failed.
    fn tick(&mut self, tick: &Tick) -> Result<(), Self::Error>;

    /// Publishes a fit of output error.
    ///
    /// # Errors
    /// Where publishing failed.
    fn output_error(&mut self, record: &OutputErrorRecord) -> Result<(), Self::Error>;

    /// Publishes a finding of the diagnosis.
    ///
    /// # Errors
    /// Where publishing failed.
    fn finding(&mut self, record: &FindingRecord) -> Result<(), Self::Error>;
}

/// No publisher: records go to the sink alone.
impl RecordPublisher for () {
    type Error = std::convert::Infallible;

    fn tick(&mut self, _: &Tick) -> Result<(), Self::Error> {
        Ok(())
    }

    fn output_error(&mut self, _: &OutputErrorRecord) -> Result<(), Self::Error> {
        Ok(())
    }

    fn finding(&mut self, _: &FindingRecord) -> Result<(), Self::Error> {
        Ok(())
    }
}

/// How a follower is scheduled relative to the samples.
pub enum Schedule<F: Task> {
    /// On the caller's thread: its work is done before the next sample.
    InStep(F),
    /// On a thread of its own, through bounded queues.
    Thread(Worker<F>),
}

impl<F: Task> Schedule<F> {
    /// Starts a thread for the follower.
    ///
    /// # Errors
    /// Where the system gives no thread.
    pub fn thread(follow: F) -> io::Result<Self> {
        Worker::spawn(follow).map(Schedule::Thread)
    }

    fn step(&mut self, sample: &Sample, report: Option<RegressionReport>, take: &mut dyn FnMut(F::Record)) {
        match self {
            Schedule::InStep(task) => task.step(sample, report.as_ref(), take),
            Schedule::Thread(worker) => worker.step(sample, report).into_iter().for_each(take),
        }
    }

    /// Samples and publications that found no room in the thread's queue.
    fn lost(&self) -> u64 {
        match self {
            Schedule::InStep(_) => 0,
            Schedule::Thread(follower) => follower.lost(),
        }
    }
}

impl Task for diagnosis::LiveDiagnosis {
    type Record = FindingRecord;
    const THREAD: &'static str = "sideslip-search";
    const WAITING: usize = 32_768;
    const RECORDS: usize = 32;

    fn status(&mut self, publish: &mut dyn FnMut(FindingRecord)) {
        self.current_findings().into_iter().for_each(publish);
    }

    fn sample(&mut self, sample: &Sample) {
        diagnosis::LiveDiagnosis::sample(self, sample);
    }

    fn regression_report(&mut self, report: &RegressionReport, _: &mut dyn FnMut(FindingRecord)) {
        diagnosis::LiveDiagnosis::set_excited(self, report.time_s, report.excited);
    }

    fn is_due(&self) -> bool {
        diagnosis::LiveDiagnosis::is_due(self)
    }

    fn work(&mut self, publish: &mut dyn FnMut(FindingRecord)) {
        self.run_due().into_iter().for_each(publish);
    }

    fn finish(&mut self) {
        diagnosis::LiveDiagnosis::finish(self);
    }

    fn ended() -> FindingRecord {
        let mut record = FindingRecord { standing: FindingStatus::Failed, ..FindingRecord::EMPTY };
        record.set_statement("the thread that diagnoses has ended");
        record
    }
}

/// Limits the modes of a fit by the newest regression's, marks a fit that is apart from it, and the regression where a converged
/// fit contradicts it: numbers that output error itself doubts contradict nothing.
fn compare(pipeline: &mut Pipeline, sink: &RecordSink, fit: &mut OutputErrorRecord, controls: ControlNames) {
    if let Some(doubt) = pipeline.estimator().instrumentation().doubt {
        return withhold(fit, doubt, controls);
    }
    withhold_axes(sink.derivatives.as_ref(), fit);
    limit_modes(sink.modes.as_ref(), fit);
    let agreement = MethodAgreement::new(sink.derivatives.as_ref(), sink.modes.as_ref(), fit);
    match fit.progress {
        OutputErrorProgress::Converged => pipeline.set_contradicted(agreement.apart),
        OutputErrorProgress::Converging => pipeline.set_contradicted([false; AXES]),
        _ => {}
    }
    cover_difference(sink.derivatives.as_ref(), sink.modes.as_ref(), fit);
    agreement.mark(fit, controls);
}

/// Takes the numbers out of a fit while an instrument is in doubt: they rest on its readings as the regression's do.
fn withhold(fit: &mut OutputErrorRecord, doubt: Doubt, controls: ControlNames) {
    fit.withhold();
    fit.explain(ReasonText { reason: Reason::InstrumentDoubted { channel: doubt.channel() }, controls });
}

/// A run being estimated: the pipeline with everything that its records go through.
pub struct WiredRun {
    pipeline: Box<Pipeline>,
    /// How the controls are called.
    controls: ControlNames,
    output_error: Option<Schedule<output_error::LiveOutputError>>,
    diagnosis: Option<Schedule<diagnosis::LiveDiagnosis>>,
    /// The newest records, and the way to the log.
    pub sink: RecordSink,
    rows: u64,
    range_s: Option<(f64, f64)>,
}

/// A run at its end.
pub struct FinishedRun {
    /// The pipeline after its last record.
    pub pipeline: Box<Pipeline>,
    /// The last records; its way to the log is closed.
    pub sink: RecordSink,
    /// Rows that were taken.
    pub rows: u64,
    /// First and last of their times that are finite, s.
    pub range_s: Option<(f64, f64)>,
    /// Samples and publications that output error had no room for.
    pub lost_by_output_error: u64,
    /// The same of the diagnosis.
    pub lost_by_diagnosis: u64,
}

impl WiredRun {
    /// A run before its first sample, with no log.
    pub fn new(
        pipeline: Pipeline,
        controls: ControlNames,
        output_error: Option<Schedule<output_error::LiveOutputError>>,
        diagnosis: Option<Schedule<diagnosis::LiveDiagnosis>>,
    ) -> Self {
        WiredRun {
            pipeline: Box::new(pipeline),
            controls,
            output_error,
            diagnosis,
            sink: RecordSink::new(None),
            rows: 0,
            range_s: None,
        }
    }

    /// Rows that were taken so far.
    pub fn rows(&self) -> u64 {
        self.rows
    }

    /// One row: estimate, publish, log.
    ///
    /// # Errors
    /// Where publishing failed.
    pub fn step<P: RecordPublisher>(&mut self, row: &RecordingRow, publisher: &mut P) -> Result<(), P::Error> {
        let WiredRun { pipeline, controls, output_error, diagnosis, sink, rows, range_s } = self;
        *rows += 1;
        let time_s = row.sample.time_s;
        if time_s.is_finite() {
            *range_s = Some(range_s.map_or((time_s, time_s), |(from, to)| (from.min(time_s), to.max(time_s))));
        }
        sink.row(row);
        let tick = pipeline.step(&row.sample);
        publisher.tick(tick)?;
        sink.tick(tick);
        let derivatives = tick.derivatives.clone();
        let report = derivatives.map(|derivatives| RegressionReport::new(&derivatives, pipeline.regression()));
        let mut published = Ok(());
        if report.is_some()
            && let Some(doubt) = pipeline.estimator().instrumentation().doubt
            && let Some(mut record) = sink.output_error.as_ref().filter(|fit| !fit.parameters.is_empty()).cloned()
        {
            withhold(&mut record, doubt, *controls);
            publisher.output_error(&record)?;
            sink.output_error(&record);
        }
        if let Some(output_error) = output_error {
            output_error.step(&row.sample, report, &mut |mut record| {
                compare(pipeline, sink, &mut record, *controls);
                if published.is_ok() {
                    published = publisher.output_error(&record);
                }
                sink.output_error(&record);
            });
        }
        if let Some(diagnosis) = diagnosis {
            diagnosis.step(&row.sample, report, &mut |record| {
                if published.is_ok() {
                    published = publisher.finding(&record);
                }
                sink.finding(&record);
            });
        }
        published
    }

    /// The end of the run: the last fit, lagged records, the last diagnosis; the way to the log is closed.
    ///
    /// # Errors
    /// Where publishing failed.
    pub fn finish<P: RecordPublisher>(self, publisher: &mut P) -> Result<FinishedRun, P::Error> {
        let WiredRun { mut pipeline, controls, output_error, diagnosis, mut sink, rows, range_s } = self;
        let lost_by_output_error = output_error.as_ref().map_or(0, Schedule::lost);
        let lost_by_diagnosis = diagnosis.as_ref().map_or(0, Schedule::lost);
        let last_fit = match output_error {
            None => None,
            Some(Schedule::InStep(mut live)) => {
                live.finish();
                live.is_due().then(|| live.refit().clone())
            }
            Some(Schedule::Thread(follower)) => follower.finish(LAST_FIT).last(),
        };
        if let Some(mut record) = last_fit {
            compare(&mut pipeline, &sink, &mut record, controls);
            publisher.output_error(&record)?;
            sink.output_error(&record);
        }
        let tick = pipeline.finish();
        publisher.tick(tick)?;
        sink.tick(tick);
        let mut last_findings = Vec::new();
        match diagnosis {
            None => {}
            Some(Schedule::InStep(mut live)) => live.end(&mut |record| last_findings.push(record)),
            Some(Schedule::Thread(follower)) => last_findings.extend(follower.finish(LAST_DIAGNOSIS)),
        }
        for record in &last_findings {
            publisher.finding(record)?;
            sink.finding(record);
        }
        sink.close();
        Ok(FinishedRun { pipeline, sink, rows, range_s, lost_by_output_error, lost_by_diagnosis })
    }
}
