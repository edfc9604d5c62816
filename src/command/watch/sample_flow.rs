//! How the samples come: their rate, the age of the newest, what each channel read last.

use sideslip::flight::channel::{CHANNELS, Channel};
use sideslip::io::bus::payload::{SamplePayload, THE_END};
use std::collections::VecDeque;
use std::time::Duration;

/// Time over which the rate is counted, ns.
const WINDOW_NS: u64 = 2_000_000_000;

/// Samples of the window that are kept; more come only where a recording is played much faster than it was flown.
const KEPT: usize = 8192;

/// A channel's last reading.
#[derive(Clone, Copy, Default)]
pub(super) struct ChannelReading {
    pub(super) value: f64,
    /// When it came onto the bus, monotonic clock, ns.
    pub(super) came_ns: u64,
}

/// The samples so far.
#[derive(Default)]
pub(super) struct SampleFlow {
    /// When the newest ones came, monotonic clock, ns.
    came_ns: VecDeque<u64>,
    newest_ns: Option<u64>,
    now_ns: u64,
    /// Time of the newest, s, on the recording's own clock.
    pub(super) time_s: f64,
    pub(super) ended: bool,
    pub(super) missed: u64,
    readings: [Option<ChannelReading>; CHANNELS],
    incarnation: u64,
}

impl SampleFlow {
    pub(super) fn take(&mut self, payload: &SamplePayload) {
        let header = payload.header;
        if header.incarnation != self.incarnation {
            *self = SampleFlow { incarnation: header.incarnation, now_ns: self.now_ns, ..SampleFlow::default() };
        }
        self.ended = payload.kind == THE_END;
        if self.ended {
            return;
        }
        self.time_s = header.time_s;
        self.newest_ns = Some(header.published_ns);
        if self.came_ns.len() == KEPT {
            self.came_ns.pop_front();
        }
        self.came_ns.push_back(header.published_ns);
        let sample = payload.sample();
        for (reading, channel) in self.readings.iter_mut().zip(Channel::ALL) {
            if let Some(value) = sample.get(channel) {
                *reading = Some(ChannelReading { value, came_ns: header.published_ns });
            }
        }
    }

    /// Sets the time, monotonic clock, ns.
    pub(super) fn now(&mut self, now_ns: u64) {
        self.now_ns = now_ns;
        while self.came_ns.front().is_some_and(|&came| came.saturating_add(WINDOW_NS) < now_ns) {
            self.came_ns.pop_front();
        }
    }

    /// Samples a second, over the last two.
    pub(super) fn rate_hz(&self) -> Option<f64> {
        let (first, last) = (self.came_ns.front()?, self.came_ns.back()?);
        let span_s = Duration::from_nanos(last.saturating_sub(*first)).as_secs_f64();
        (span_s > 0.0).then(|| (self.came_ns.len() - 1) as f64 / span_s)
    }

    /// How long ago the newest came; `None` before the first.
    pub(super) fn age(&self) -> Option<Duration> {
        self.newest_ns.map(|came| Duration::from_nanos(self.now_ns.saturating_sub(came)))
    }

    /// What a channel read last, and how long ago.
    pub(super) fn reading(&self, channel: Channel) -> Option<(f64, Duration)> {
        let reading = self.readings.get(channel.index()).copied().flatten()?;
        Some((reading.value, Duration::from_nanos(self.now_ns.saturating_sub(reading.came_ns))))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use sideslip::flight::sample::Sample;
    use sideslip::io::bus::payload::SAMPLE;

    #[test]
    fn rate_and_ages_follow_the_clock_of_the_bus() {
        let mut flow = SampleFlow::default();
        let second = 1_000_000_000;
        for k in 0..300_u64 {
            let mut sample = Sample::new(k as f64 * 0.02);
            sample.set(Channel::P, k as f64);
            if k < 100 {
                sample.set(Channel::Beta, 0.1);
            }
            let mut payload = SamplePayload::new(&sample, std::iter::empty(), SAMPLE);
            (payload.header.published_ns, payload.header.incarnation) = (10 * second + k * second / 50, 7);
            flow.take(&payload);
        }
        flow.now(16 * second);
        assert!((flow.rate_hz().unwrap() - 50.0).abs() < 0.01, "{:?}", flow.rate_hz());
        assert_eq!(flow.age(), Some(Duration::from_millis(20)));
        assert_eq!(flow.reading(Channel::P), Some((299.0, Duration::from_millis(20))));
        assert_eq!(flow.reading(Channel::Beta), Some((0.1, Duration::from_millis(4020))));
        assert_eq!(flow.reading(Channel::Q), None);
        flow.now(30 * second);
        assert_eq!((flow.rate_hz(), flow.ended), (None, false), "nothing comes any more");
        let mut end = SamplePayload::the_end(6.0);
        end.header.incarnation = 7;
        flow.take(&end);
        assert!(flow.ended && flow.reading(Channel::P).is_some());
    }
}
