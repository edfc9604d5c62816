//! Settings of the stage, and those that cannot be.

/// How a stamp counts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum StampUnit {
    /// Seconds that do not wrap.
    Seconds,
    /// A counter of so many bits (1 to 48), each count so many seconds.
    Counter {
        /// Bits.
        bits: u32,
        /// Seconds a count.
        tick_s: f64,
    },
}

/// A stamp as it came.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum RawStamp {
    /// Of a clock in seconds.
    Seconds(f64),
    /// Of a counter.
    Count(u64),
}

/// Settings.
#[derive(Clone, Debug, PartialEq)]
pub struct ReorderConfig {
    /// How stamps count.
    pub unit: StampUnit,
    /// Samples may come so much later than newer ones, s.
    pub window_s: f64,
    /// A longer step forward needs confirmation, and is an event, s.
    pub forward_s: f64,
    /// A longer step back needs confirmation, and begins a segment, s; at least the window.
    pub back_s: f64,
    /// From the last sample of a segment to the first of the next, s: how long it really was is not known.
    pub between_s: f64,
    /// Latency of each channel, s: subtracted from its times. As many as there are channels.
    pub latencies_s: Vec<f64>,
    /// Samples that wait at most.
    pub capacity: usize,
    /// Rows of each table at most.
    pub rows_max: usize,
}

impl ReorderConfig {
    /// So many channels without latency, a window of 1 s.
    pub fn new(channels: usize, unit: StampUnit) -> Self {
        ReorderConfig {
            unit,
            window_s: 1.0,
            forward_s: 10.0,
            back_s: 2.0,
            between_s: 2.0,
            latencies_s: vec![0.0; channels],
            capacity: 4096,
            rows_max: 4096,
        }
    }

    pub(super) fn check(&self) -> Result<(), ReorderSettingError> {
        let ReorderConfig { window_s, forward_s, back_s, between_s, capacity, .. } = *self;
        let named = [("window_s", window_s), ("forward_s", forward_s), ("back_s", back_s), ("between_s", between_s)];
        if let Some((name, value)) = named.into_iter().find(|(_, value)| !(value.is_finite() && *value >= 0.0)) {
            return Err(ReorderSettingError::Negative { name, value });
        }
        if let Some((channel, &value)) = self.latencies_s.iter().enumerate().find(|(_, value)| !value.is_finite()) {
            return Err(ReorderSettingError::Latency { channel, value });
        }
        if let StampUnit::Counter { bits, tick_s } = self.unit
            && !((1..=48).contains(&bits) && tick_s.is_finite() && tick_s > 0.0)
        {
            return Err(ReorderSettingError::Counter { bits, tick_s });
        }
        if back_s < window_s {
            return Err(ReorderSettingError::BackWithinWindow { back_s, window_s });
        }
        if capacity == 0 {
            return Err(ReorderSettingError::NoCapacity);
        }
        Ok(())
    }

    /// The largest latency, not below zero, and the least, not above it, s.
    pub(super) fn latency_range_s(&self) -> (f64, f64) {
        let of = |pick: fn(f64, f64) -> f64| self.latencies_s.iter().copied().fold(0.0, pick);
        (of(f64::max), of(f64::min))
    }
}

/// Settings that cannot be.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[expect(missing_docs, reason = "the message of each says what its fields are")]
pub enum ReorderSettingError {
    #[error("{name} is {value}, expected a number that is not negative")]
    Negative { name: &'static str, value: f64 },
    #[error("the latency of channel {channel} is {value}, expected a finite number of seconds")]
    Latency { channel: usize, value: f64 },
    #[error("a counter of {bits} bits of {tick_s} s, expected 1 to 48 bits of more than 0 s")]
    Counter { bits: u32, tick_s: f64 },
    #[error("steps back from {back_s} s on are jumps, but samples may be {window_s} s late: expected no less")]
    BackWithinWindow { back_s: f64, window_s: f64 },
    #[error("room for no sample")]
    NoCapacity,
}
