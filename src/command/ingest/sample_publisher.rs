//! Publishes samples in shared memory; where none may be lost it waits for the estimator's acknowledgement.
//!
//! Samples of a live run whose channels have latencies are aligned before: each channel at the time at which it was measured,
//! rows in order of time. They wait for the largest latency and the next row then, in memory that is taken when the run begins.

use crate::command::message;
use sideslip::error::Failure;
use sideslip::flight::file::run_file::RunInfo;
use sideslip::flight::sample::Sample;
use sideslip::io::bus::clock::monotonic_ns;
use sideslip::io::bus::payload::{AcknowledgementPayload, SAMPLE, SAMPLE_TO_ACKNOWLEDGE, SamplePayload};
use sideslip::io::bus::service::{Bus, Publisher, Subscriber};
use sideslip::io::telemetry::alignment::row_alignment::RowAlignment;
use sideslip::io::telemetry::record::RecordingRow;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

/// Samples that may be under way where none may be lost; the estimator's place holds twice as many.
const IN_FLIGHT: u64 = 512;
/// Polling interval of the estimator's acknowledgement.
const POLL: Duration = Duration::from_micros(50);
/// Silence after which it is said that nobody takes the samples.
const SAY_WAITING: Duration = Duration::from_secs(3);
/// What was published last stays in reach for subscribers that have not found this publisher yet.
const LINGER: Duration = Duration::from_millis(100);

/// The way of samples onto the bus.
pub(super) struct SamplePublisher {
    publisher: Publisher<SamplePayload>,
    /// Where none may be lost: what the estimator has taken.
    taken: Option<(Subscriber<AcknowledgementPayload>, u64)>,
    incarnation: u64,
    /// Of the run that goes on, where it has latencies.
    alignment: Option<Box<LiveAlignment>>,
    /// Of the runs that have ended: what was dropped, and what was put right, in words.
    lost: Vec<String>,
    noted: Vec<String>,
}

/// Rows of a live run on their way.
struct LiveAlignment {
    rows: RowAlignment,
    /// From the run's time to the monotonic clock, ns, by the newest row.
    offset_ns: i64,
}

/// When a row of that time was measured, monotonic clock.
fn sampled_ns(time_s: f64, offset_ns: i64) -> u64 {
    u64::try_from(nanoseconds(time_s).saturating_add(offset_ns)).unwrap_or_default()
}

fn nanoseconds(time_s: f64) -> i64 {
    #[expect(clippy::cast_possible_truncation, reason = "a cast of a float saturates, and a run of 290 years is none")]
    let ns = libm::round(time_s * 1e9) as i64;
    ns
}

impl SamplePublisher {
    /// Takes its place; with `lossless` it waits for the estimator.
    pub(super) fn new(bus: &Bus, lossless: bool) -> Result<Self, Failure> {
        let taken = if lossless { Some((bus.subscriber()?, 0)) } else { None };
        let (publisher, incarnation) = (bus.publisher()?, bus.incarnation());
        Ok(SamplePublisher { publisher, taken, incarnation, alignment: None, lost: Vec::new(), noted: Vec::new() })
    }

    /// A live run begins: the rows that follow, with so many other columns, are aligned where it has latencies, and its head
    /// says afterwards that they are.
    pub(super) fn begin_run(&mut self, info: &mut RunInfo, others: usize) -> Result<(), Failure> {
        let Some(latencies) = info.take_latencies() else { return Ok(()) };
        let rows = RowAlignment::new(&latencies, others, 0.0).map_err(|wrong| Failure::Input(wrong.to_string()))?;
        let controls = info.geometry().controls;
        message(format_args!(
            "sideslip: rows wait {} s and to the next row for the channels that are late: {}",
            latencies.largest_s(),
            latencies.words(controls)
        ));
        self.alignment = Some(Box::new(LiveAlignment { rows, offset_ns: 0 }));
        Ok(())
    }

    /// What the alignment of all runs that have ended dropped, and what it put right, in words.
    pub(super) fn take_aligned(&mut self) -> (Vec<String>, Vec<String>) {
        (std::mem::take(&mut self.lost), std::mem::take(&mut self.noted))
    }

    /// Publishes a sample with its other columns; it was measured at `sampled_ns`, monotonic clock, or now where that is
    /// `None`. False where it was stopped while it waited for room.
    pub(super) fn sample(
        &mut self,
        sample: &Sample,
        others: &[Option<f64>],
        sampled_ns: Option<u64>,
        stop: &AtomicBool,
    ) -> Result<bool, Failure> {
        let Some(mut alignment) = self.alignment.take() else { return self.publish(sample, others, sampled_ns, stop) };
        let sampled_ns = sampled_ns.unwrap_or_else(monotonic_ns);
        let axis_s = sample.time_s + alignment.rows.shift_s();
        alignment.offset_ns = i64::try_from(sampled_ns).unwrap_or(i64::MAX).saturating_sub(nanoseconds(axis_s));
        let went = self.aligned(&mut alignment, stop, |rows, mut each| rows.push(0, sample, others, &mut each));
        self.alignment = Some(alignment);
        went
    }

    /// Publishes the rows that become due.
    fn aligned(
        &mut self,
        alignment: &mut LiveAlignment,
        stop: &AtomicBool,
        step: impl FnOnce(&mut RowAlignment, &mut dyn FnMut(&RecordingRow)),
    ) -> Result<bool, Failure> {
        let LiveAlignment { rows, offset_ns } = alignment;
        let mut went = Ok(true);
        step(rows, &mut |row| {
            if matches!(went, Ok(true)) {
                let sampled_ns = sampled_ns(row.sample.time_s, *offset_ns);
                went = self.publish(&row.sample, &row.others, Some(sampled_ns), stop);
            }
        });
        went
    }

    fn publish(
        &mut self,
        sample: &Sample,
        others: &[Option<f64>],
        sampled_ns: Option<u64>,
        stop: &AtomicBool,
    ) -> Result<bool, Failure> {
        if !self.room_for(IN_FLIGHT, stop)? {
            return Ok(false);
        }
        let others = others.iter().map(|other| other.unwrap_or(f64::NAN));
        let kind = if self.taken.is_some() { SAMPLE_TO_ACKNOWLEDGE } else { SAMPLE };
        self.publisher.publish(&SamplePayload::new(sample, others, kind), sampled_ns)?;
        Ok(true)
    }

    /// Says that the run has ended, and stays until that has been heard.
    pub(super) fn end(&mut self, time_s: f64, stop: &AtomicBool) -> Result<(), Failure> {
        if let Some(mut alignment) = self.alignment.take() {
            self.aligned(&mut alignment, stop, |rows, mut each| rows.finish(&mut each))?;
            let tally = alignment.rows.tally();
            self.lost.extend(tally.losses());
            self.noted.extend(tally.notes());
        }
        self.publisher.publish(&SamplePayload::the_end(time_s), None)?;
        if self.taken.is_none() || !self.room_for(1, stop)? {
            let begun = Instant::now();
            while begun.elapsed() < LINGER {
                self.publisher.meet()?;
                std::thread::sleep(LINGER / 20);
            }
        }
        Ok(())
    }

    /// Waits until fewer than so many samples are under way; false where it was stopped before.
    fn room_for(&mut self, limit: u64, stop: &AtomicBool) -> Result<bool, Failure> {
        let Some((taken, count)) = &mut self.taken else { return Ok(true) };
        let mut since = Instant::now();
        let mut said = false;
        while self.publisher.published() - *count >= limit {
            match taken.receive()? {
                Some(answer) if answer.of_incarnation == self.incarnation => {
                    *count = answer.taken.clamp(*count, self.publisher.published());
                    since = Instant::now();
                }
                Some(_) => {}
                None if stop.load(Ordering::Relaxed) => return Ok(false),
                None => {
                    // Who came since the last sample would hear nothing until the next, which waits for him.
                    self.publisher.meet()?;
                    std::thread::sleep(POLL);
                }
            }
            if !said && since.elapsed() > SAY_WAITING {
                said = true;
                message(format_args!("sideslip: waiting for an estimator to take the samples"));
            }
        }
        Ok(true)
    }
}
