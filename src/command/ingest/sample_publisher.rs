//! Publishes samples in shared memory; where none may be lost it waits for the estimator's acknowledgement.

use crate::command::message;
use sideslip::error::Failure;
use sideslip::flight::sample::Sample;
use sideslip::io::bus::payload::{AcknowledgementPayload, SAMPLE, SAMPLE_TO_ACKNOWLEDGE, SamplePayload};
use sideslip::io::bus::service::{Bus, Publisher, Subscriber};
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
}

impl SamplePublisher {
    /// Takes its place; with `lossless` it waits for the estimator.
    pub(super) fn new(bus: &Bus, lossless: bool) -> Result<Self, Failure> {
        let taken = if lossless { Some((bus.subscriber()?, 0)) } else { None };
        Ok(SamplePublisher { publisher: bus.publisher()?, taken, incarnation: bus.incarnation() })
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
        self.publisher.publish(&SamplePayload::the_end(time_s), None)?;
        if self.taken.is_none() || !self.room_for(1, stop)? {
            std::thread::sleep(LINGER);
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
                None => std::thread::sleep(POLL),
            }
            if !said && since.elapsed() > SAY_WAITING {
                said = true;
                message(format_args!("sideslip: waiting for an estimator to take the samples"));
            }
        }
        Ok(true)
    }
}
