//! A run's channels as traces, and the level and noise of each in trim.

use crate::flight::channel::{CHANNELS, Channel};
use crate::flight::control::{CONTROLS, Control};
use crate::flight::sample::Sample;
use crate::flight::signal::trace::Trace;

/// Every channel of a run that was sampled often enough.
#[derive(Clone, Debug)]
pub(crate) struct Channels {
    traces: [Option<Trace>; CHANNELS],
}

impl Channels {
    /// Gathers a run's samples.
    pub(crate) fn of(samples: &[Sample]) -> Self {
        Channels { traces: Channel::ALL.map(|channel| Trace::of(samples, channel)) }
    }

    pub(crate) fn get(&self, channel: Channel) -> Option<&Trace> {
        self.traces.get(channel.index()).and_then(Option::as_ref)
    }

    pub(crate) fn controls(&self) -> [Option<Trace>; CONTROLS] {
        Control::ALL.map(|control| self.get(control.channel()).cloned())
    }

    /// First and last time of any channel, s.
    pub(crate) fn range_s(&self) -> (f64, f64) {
        let ranges = self.traces.iter().flatten().map(Trace::range_s);
        ranges.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), (c, d)| (a.min(c), b.max(d)))
    }
}

/// Level of a channel in trim.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Rest {
    pub(crate) mean: f64,
    /// Standard deviation of the smoothed channel beyond white noise: disturbances, and a trim that is not held.
    pub(crate) motion: f64,
    /// Standard error of a smoothed reading by white noise.
    pub(crate) smooth: f64,
}

impl Rest {
    /// Of the channel over the trim window; `None` where there are too few readings.
    pub(crate) fn of(trace: &Trace, from_s: f64, to_s: f64) -> Option<Rest> {
        let (mean, std, _) = trace.mean(from_s, to_s)?;
        let half_s = trace.half_window_s();
        let per_window = (2.0 * half_s / trace.interval_s()).max(1.0);
        let noise = trace.noise();
        // Quantisation and short windows: up to 1.5 times the noise counts as noise.
        let beyond = std * std - 1.5 * noise * noise;
        Some(Rest { mean, motion: libm::sqrt(beyond.max(0.0)), smooth: noise / libm::sqrt(per_window) })
    }

    /// Standard error of a smoothed deviation from the mean.
    pub(crate) fn deviation_std(&self) -> f64 {
        libm::sqrt(self.motion * self.motion + self.smooth * self.smooth)
    }
}
