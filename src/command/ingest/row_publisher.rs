//! Rows of PCM onto the bus, each as old as the offset of its time to this machine's clock says.

use super::sample_publisher::SamplePublisher;
use crate::command::message;
use sideslip::error::Failure;
use sideslip::io::bus::clock::monotonic_ns;
use sideslip::io::telemetry::mavlink::host_time::HostOffset;
use sideslip::io::telemetry::record::RecordingRow;
use std::sync::atomic::AtomicBool;

/// Publishes rows; where that fails, nothing more, until it is asked.
pub(super) struct RowPublisher<'s> {
    publisher: SamplePublisher,
    offset: HostOffset,
    stop: &'s AtomicBool,
    /// Time of the newest row, s.
    pub(super) newest_s: f64,
    pub(super) samples: u64,
    failed: Option<Failure>,
    /// Whether it was stopped while it waited for room.
    stopped: bool,
}

impl<'s> RowPublisher<'s> {
    /// On that way to the bus.
    pub(super) fn new(publisher: SamplePublisher, stop: &'s AtomicBool) -> Self {
        let offset = HostOffset::default();
        RowPublisher { publisher, offset, stop, newest_s: 0.0, samples: 0, failed: None, stopped: false }
    }

    /// What was measured at that time, s, arrived at that host time, us.
    pub(super) fn arrived(&mut self, time_s: f64, host_us: i64) {
        self.offset.observe(microseconds(time_s), host_us);
    }

    /// The time that arrives at that host time, s; `None` before anything has.
    pub(super) fn expected_s(&self, host_us: i64) -> Option<f64> {
        self.offset.least_us().map(|least_us| (host_us - least_us) as f64 * 1e-6)
    }

    /// Publishes a row that came at that host time, us.
    pub(super) fn row(&mut self, row: &RecordingRow, host_us: i64) {
        if self.failed.is_some() || self.stopped {
            return;
        }
        let time_s = row.sample.time_s;
        let sampled_us = self.offset.host_of(microseconds(time_s), host_us);
        let sampled_ns = u64::try_from(sampled_us).unwrap_or_default().saturating_mul(1000);
        match self.publisher.sample(&row.sample, &row.others, Some(sampled_ns), self.stop) {
            Ok(true) => {
                self.newest_s = time_s;
                self.samples += 1;
            }
            Ok(false) => self.stopped = true,
            Err(failed) => self.failed = Some(failed),
        }
    }

    /// Whether everything went out.
    pub(super) fn published(&mut self) -> Result<(), Failure> {
        self.failed.take().map_or(Ok(()), Err)
    }

    /// What the alignment dropped, in words; what it put right is said.
    pub(super) fn take_losses(&mut self) -> Vec<String> {
        let (lost, noted) = self.publisher.take_aligned();
        noted.iter().for_each(|what| message(format_args!("sideslip: {what}")));
        lost
    }

    /// Says that the run has ended.
    pub(super) fn end(&mut self) -> Result<(), Failure> {
        self.publisher.end(self.newest_s, self.stop)
    }
}

/// This machine's clock, us.
pub(super) fn host_us() -> i64 {
    i64::try_from(monotonic_ns() / 1000).unwrap_or(i64::MAX)
}

fn microseconds(time_s: f64) -> i64 {
    #[expect(clippy::cast_possible_truncation, reason = "a cast of a float saturates, and a stream of 300,000 years is none")]
    let us = libm::round(time_s * 1e6) as i64;
    us
}
