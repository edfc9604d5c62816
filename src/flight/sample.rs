//! The published vocabulary of telemetry: one time-stamped sample from any source.

use super::channel::{CHANNELS, Channel};

/// What was measured at one instant, SI and radians. It carries only those channels that were sampled at its time.
///
/// A channel that was sampled and gave no number (NaN, infinity) is present with that value: admission to the
/// estimator flags it, telemetry does not hide it.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C)]
pub struct Sample {
    /// Time of the sample, s, on the recording's own clock.
    pub time_s: f64,
    /// Bit `Channel::index()` is set where the channel was sampled.
    pub present: u32,
    /// Values by `Channel::index()`; meaningless where not present.
    pub values: [f64; CHANNELS],
}

impl Sample {
    /// A sample at that time that carries nothing yet.
    pub const fn new(time_s: f64) -> Self {
        Sample { time_s, present: 0, values: [0.0; CHANNELS] }
    }

    /// The channel's value, where it was sampled.
    pub fn get(&self, channel: Channel) -> Option<f64> {
        if self.present & (1 << channel.index()) != 0 { Some(self.values[channel.index()]) } else { None }
    }

    /// Sets the channel as sampled with that value.
    pub fn set(&mut self, channel: Channel, value: f64) {
        self.values[channel.index()] = value;
        self.present |= 1 << channel.index();
    }

    /// Takes the channel out, as if it had not been sampled.
    pub fn clear(&mut self, channel: Channel) {
        self.values[channel.index()] = 0.0;
        self.present &= !(1 << channel.index());
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_channel_is_there_only_after_it_was_set() {
        let mut sample = Sample::new(1.5);
        assert_eq!(sample.get(Channel::Rho), None);
        sample.set(Channel::Rho, 1.0);
        assert_eq!((sample.get(Channel::Rho), sample.get(Channel::Ax)), (Some(1.0), None));
        sample.clear(Channel::Rho);
        assert_eq!(sample, Sample::new(1.5));
    }
}
