//! A run's channels as traces, and where each stands in trim.

use super::trace::Trace;
use crate::flight::channel::{CHANNELS, Channel};
use crate::flight::control::{CONTROLS, Control};
use crate::flight::sample::Sample;

/// Every channel of a run that was sampled often enough.
#[derive(Clone, Debug)]
pub struct Channels {
    traces: [Option<Trace>; CHANNELS],
}

impl Channels {
    /// Gathers a run's samples.
    pub fn of(samples: &[Sample]) -> Self {
        Channels { traces: Channel::ALL.map(|channel| Trace::of(samples, channel)) }
    }

    /// One of them.
    pub fn get(&self, channel: Channel) -> Option<&Trace> {
        self.traces.get(channel.index()).and_then(Option::as_ref)
    }

    /// The four controls.
    pub fn controls(&self) -> [Option<Trace>; CONTROLS] {
        Control::ALL.map(|control| self.get(control.channel()).cloned())
    }

    /// First and last time of any channel, s.
    pub fn range_s(&self) -> (f64, f64) {
        let ranges = self.traces.iter().flatten().map(Trace::range_s);
        ranges.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), (c, d)| (a.min(c), b.max(d)))
    }
}

/// Where a channel stands before a manoeuvre.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rest {
    /// Its mean.
    pub mean: f64,
    /// What it does about the mean once smoothed as a local line is, beyond white noise: disturbances and trim not held.
    pub motion: f64,
    /// Standard error of a smoothed reading by white noise.
    pub smooth: f64,
}

impl Rest {
    /// Of the channel over the trim window; `None` where there are too few readings.
    pub fn of(trace: &Trace, from_s: f64, to_s: f64) -> Option<Rest> {
        let (mean, std, _) = trace.mean(from_s, to_s)?;
        let half_s = trace.half_window_s();
        let per_window = (2.0 * half_s / trace.interval_s()).max(1.0);
        let noise = trace.noise();
        // Quantisation and short windows: what is no more than half as much again as the noise is the noise.
        let beyond = std * std - 1.5 * noise * noise;
        Some(Rest { mean, motion: libm::sqrt(beyond.max(0.0)), smooth: noise / libm::sqrt(per_window) })
    }

    /// Standard error of a smoothed deviation from the mean.
    pub fn deviation_std(&self) -> f64 {
        libm::sqrt(self.motion * self.motion + self.smooth * self.smooth)
    }
}
