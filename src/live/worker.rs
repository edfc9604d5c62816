//! Work that takes longer than a sample (output error, the diagnosis) on a thread of its own, beside the sample path, which hands
//! over samples, takes records, and never waits.
//!
//! Both queues are bounded, and the thread runs at low priority. Where it does not keep up, samples are dropped and counted, and
//! the manoeuvre shows a gap. A thread that hangs or has ended costs its own records only: at the end of a run it is waited for
//! until a deadline.

use super::output_error::LiveOutputError;
use super::regression_report::RegressionReport;
use crate::flight::sample::Sample;
use crate::postflight::output_error::record::{OutputErrorProgress, OutputErrorRecord};
use crossbeam::channel::{Receiver, Sender, TryRecvError, bounded};
use std::io;
use std::time::Duration;

/// Niceness of the thread: where processors are few, samples and estimates come first.
const GIVES_WAY: i32 = 15;

/// Work on the samples of a flight, done on a thread of its own.
pub trait Task: Send + 'static {
    /// What it publishes: of fixed size, so that receiving it allocates nothing.
    type Record: Send + 'static;
    /// Name of its thread.
    const THREAD: &'static str;
    /// Capacity of the input queue: 32768 are four minutes of work at 128 Hz.
    const WAITING: usize;
    /// Capacity of the output queue; where it is full, the newest records are lost and published again with the next ones.
    const RECORDS: usize;

    /// Publishes the status without new results: the first record, and the last where no work is due.
    fn status(&mut self, publish: &mut dyn FnMut(Self::Record));
    /// A sample as it came.
    fn sample(&mut self, sample: &Sample);
    /// A publication of the regression.
    fn regression_report(&mut self, report: &RegressionReport, publish: &mut dyn FnMut(Self::Record));
    /// Whether there is work.
    fn is_due(&self) -> bool;
    /// Does the work that is due.
    fn work(&mut self, publish: &mut dyn FnMut(Self::Record));
    /// End of the run: an open manoeuvre ends.
    fn finish(&mut self);
    /// The record of a thread that has ended early.
    fn ended() -> Self::Record;

    /// A sample, the regression's publication with it, and the work that is due then: for a recording, step by step.
    fn step(&mut self, sample: &Sample, report: Option<&RegressionReport>, publish: &mut dyn FnMut(Self::Record)) {
        self.sample(sample);
        if let Some(report) = report {
            self.regression_report(report, publish);
        }
        if self.is_due() {
            self.work(publish);
        }
    }

    /// End of the run: the last work, or the status where none is due.
    fn end(&mut self, publish: &mut dyn FnMut(Self::Record)) {
        self.finish();
        if self.is_due() { self.work(publish) } else { self.status(publish) }
    }
}

impl Task for LiveOutputError {
    type Record = OutputErrorRecord;
    const THREAD: &'static str = "sideslip-fit";
    const WAITING: usize = 4096;
    const RECORDS: usize = 8;

    fn status(&mut self, publish: &mut dyn FnMut(OutputErrorRecord)) {
        publish(self.record().clone());
    }

    fn sample(&mut self, sample: &Sample) {
        LiveOutputError::sample(self, sample);
    }

    fn regression_report(&mut self, report: &RegressionReport, publish: &mut dyn FnMut(OutputErrorRecord)) {
        if let Some(record) = LiveOutputError::regression_report(self, report) {
            publish(record.clone());
        }
    }

    fn is_due(&self) -> bool {
        LiveOutputError::is_due(self)
    }

    fn work(&mut self, publish: &mut dyn FnMut(OutputErrorRecord)) {
        publish(self.refit().clone());
    }

    fn finish(&mut self) {
        LiveOutputError::finish(self);
    }

    fn ended() -> OutputErrorRecord {
        let mut record = OutputErrorRecord { progress: OutputErrorProgress::Failed, ..OutputErrorRecord::EMPTY };
        record.explain("the thread that fits has ended");
        record
    }
}

#[expect(clippy::large_enum_variant, reason = "a box would be an allocation in the sample path")]
enum WorkerInput {
    Sample(Sample),
    Report(RegressionReport),
}

/// The sample path's side of a worker thread.
#[derive(Debug)]
pub struct Worker<T: Task> {
    to: Sender<WorkerInput>,
    from: Receiver<T::Record>,
    lost: u64,
    ended: bool,
}

impl std::fmt::Debug for WorkerInput {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            WorkerInput::Sample(_) => "sample",
            WorkerInput::Report(_) => "report",
        })
    }
}

impl<T: Task> Worker<T> {
    /// Starts the thread. Everything that the sample path needs is allocated here.
    ///
    /// # Errors
    /// Where the system refuses a thread.
    pub fn spawn(task: T) -> io::Result<Self> {
        let (to, inputs) = bounded(T::WAITING);
        let (publish, from) = bounded(T::RECORDS);
        std::thread::Builder::new().name(T::THREAD.to_owned()).spawn(move || work(task, &inputs, &publish))?;
        Ok(Worker { to, from, lost: 0, ended: false })
    }

    /// Hands over a sample and the regression's publication with it; the next record, if any.
    pub fn step(&mut self, sample: &Sample, report: Option<RegressionReport>) -> Option<T::Record> {
        self.sample(sample);
        if let Some(report) = report {
            self.regression_report(report);
        }
        self.next_record()
    }

    /// Hands over a sample; counted as lost where the queue is full.
    pub fn sample(&mut self, sample: &Sample) {
        self.lost += u64::from(self.to.try_send(WorkerInput::Sample(*sample)).is_err());
    }

    /// Hands over a publication of the regression; likewise.
    pub fn regression_report(&mut self, report: RegressionReport) {
        self.lost += u64::from(self.to.try_send(WorkerInput::Report(report)).is_err());
    }

    /// Inputs lost to a full queue.
    pub fn lost(&self) -> u64 {
        self.lost
    }

    /// The next record, if any. A thread that has ended is reported once.
    pub fn next_record(&mut self) -> Option<T::Record> {
        match self.from.try_recv() {
            Ok(record) => Some(record),
            Err(TryRecvError::Disconnected) if !self.ended => {
                self.ended = true;
                Some(T::ended())
            }
            Err(_) => None,
        }
    }

    /// End of the run: the last records, until `patience` has passed.
    pub fn finish(self, patience: Duration) -> impl Iterator<Item = T::Record> {
        let Worker { to, from, .. } = self;
        drop(to);
        let until = std::time::Instant::now() + patience;
        std::iter::from_fn(move || from.recv_deadline(until).ok())
    }
}

fn work<T: Task>(mut task: T, inputs: &Receiver<WorkerInput>, to: &Sender<T::Record>) {
    // Of this thread alone, on Linux. Refused, it works all the same.
    let _ = rustix::process::nice(GIVES_WAY);
    let mut publish = |record: T::Record| {
        let _ = to.try_send(record);
    };
    task.status(&mut publish);
    while let Ok(first) = inputs.recv() {
        // All that is there before the next work, so that it is of the newest; no more than there is room for, so that it comes.
        for one in std::iter::once(first).chain(inputs.try_iter().take(T::WAITING)) {
            match one {
                WorkerInput::Sample(sample) => task.sample(&sample),
                WorkerInput::Report(report) => task.regression_report(&report, &mut publish),
            }
        }
        if task.is_due() {
            task.work(&mut publish);
        }
    }
    task.end(&mut publish);
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::flight::derivative::AXES;
    use crate::flight::run::RunGeometry;
    use crate::live::output_error_config::LiveOutputErrorConfig;
    use std::time::Instant;

    /// Output error with another way to fit.
    struct Odd(LiveOutputError, fn());

    impl Task for Odd {
        type Record = OutputErrorRecord;
        const THREAD: &'static str = "odd";
        const WAITING: usize = 4096;
        const RECORDS: usize = 8;
        fn status(&mut self, publish: &mut dyn FnMut(OutputErrorRecord)) {
            self.0.status(publish);
        }
        fn sample(&mut self, sample: &Sample) {
            Task::sample(&mut self.0, sample);
        }
        fn regression_report(&mut self, report: &RegressionReport, publish: &mut dyn FnMut(OutputErrorRecord)) {
            Task::regression_report(&mut self.0, report, publish);
        }
        fn is_due(&self) -> bool {
            self.0.is_due()
        }
        fn work(&mut self, _: &mut dyn FnMut(OutputErrorRecord)) {
            self.1();
        }
        fn finish(&mut self) {
            Task::finish(&mut self.0);
        }
        fn ended() -> OutputErrorRecord {
            LiveOutputError::ended()
        }
    }

    fn live() -> LiveOutputError {
        LiveOutputError::new(LiveOutputErrorConfig::default(), RunGeometry::DEFAULT)
    }

    /// A flight of a minute at 128 Hz, excited all along but at its end; how long the sample path took at most.
    fn fly<T: Task<Record = OutputErrorRecord>>(worker: &mut Worker<T>) -> (Duration, Vec<OutputErrorRecord>) {
        let (mut longest, mut records) = (Duration::ZERO, Vec::new());
        for k in 0..7680_u32 {
            let time_s = f64::from(k) / 128.0;
            let begun = Instant::now();
            worker.sample(&Sample::new(time_s));
            if k % 8 == 0 {
                worker.regression_report(RegressionReport {
                    time_s,
                    excited: k < 7000,
                    terms: [7; AXES],
                    ..RegressionReport::NONE
                });
            }
            records.extend(worker.next_record());
            longest = longest.max(begun.elapsed());
        }
        (longest, records)
    }

    #[test]
    fn a_fit_that_hangs_costs_its_numbers_and_nothing_else() {
        let mut worker = Worker::spawn(Odd(live(), || std::thread::sleep(Duration::from_secs(3600)))).unwrap();
        let (longest, _) = fly(&mut worker);
        assert!(longest < Duration::from_millis(500), "{longest:?}");
        assert!(worker.lost() > 0, "what finds no room is counted");
        let begun = Instant::now();
        let _ = worker.finish(Duration::from_millis(50)).last();
        assert!(begun.elapsed() < Duration::from_secs(2));
    }

    #[test]
    fn a_fit_that_panics_is_said_once() {
        let mut worker = Worker::spawn(Odd(live(), || panic!("on purpose"))).unwrap();
        let (_, mut records) = fly(&mut worker);
        let until = Instant::now() + Duration::from_secs(20);
        let mut time_s = 60.0;
        while records.last().is_none_or(|last| last.progress != OutputErrorProgress::Failed) && Instant::now() < until {
            // The manoeuvre's end may have found no room: it is said until the thread hears it.
            time_s += 0.1;
            worker.regression_report(RegressionReport { time_s, excited: false, terms: [7; AXES], ..RegressionReport::NONE });
            std::thread::sleep(Duration::from_millis(1));
            records.extend(worker.next_record());
        }
        assert!(records.last().unwrap().reason.contains("has ended"));
        assert!(worker.next_record().is_none());
    }

    #[test]
    fn what_cannot_be_fitted_is_said_at_the_end_too() {
        let mut worker = Worker::spawn(live()).unwrap();
        let (_, first) = fly(&mut worker);
        let last = worker.finish(Duration::from_secs(60)).last().or(first.last().cloned()).unwrap();
        assert_eq!(last.progress, OutputErrorProgress::Failed);
    }
}
