//! Which samples of a flight a logger writes: each kind of message at most so often.
//!
//! Consumes samples in order of time; tells of each which channels are due, by kinds of message. A logger takes what is there
//! when it is due and averages nothing. Each channel has its own clock: those sampled at other moments or rates do not take its
//! place. Inertial measurements come as fast as the loggers of both autopilots write them where they are set up to identify the
//! aircraft; the others come at most 50 times a second.
//! Sources: PX4, `logged_topics.cpp` (profile for system identification); ArduPilot, LOG_BITMASK (fast IMU, medium attitude).

use crate::flight::channel::{CHANNELS, Channel};
use crate::flight::sample::Sample;

/// Inertial messages of ArduPilot a second, at most.
pub const DATAFLASH_IMU_HZ: f64 = 400.0;
/// Inertial messages of PX4 a second, at most.
pub const ULOG_IMU_HZ: f64 = 250.0;
/// Every other message a second, at most.
pub const SLOW_HZ: f64 = 50.0;
/// A message is due so much of its interval early: times are rounded.
const EARLY: f64 = 0.01;

/// Kinds of messages.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LoggedKind {
    /// Gyros and accelerometers.
    Imu,
    /// Attitude.
    Attitude,
    /// Incidence and sideslip.
    Flow,
    /// Airspeed.
    Airspeed,
    /// Static pressure.
    Pressure,
    /// Outputs to servos.
    Controls,
    /// Rotor speed.
    Rotor,
}

impl LoggedKind {
    const fn channels(self) -> &'static [Channel] {
        match self {
            LoggedKind::Imu => &[Channel::P, Channel::Q, Channel::R, Channel::Ax, Channel::Ay, Channel::Az],
            LoggedKind::Attitude => &[Channel::Phi, Channel::Theta, Channel::Psi],
            LoggedKind::Flow => &[Channel::Alpha, Channel::Beta],
            LoggedKind::Airspeed => &[Channel::Tas],
            LoggedKind::Pressure => &[Channel::Altitude],
            LoggedKind::Controls => &Channel::CONTROLS,
            LoggedKind::Rotor => &[Channel::RotorSpeed],
        }
    }
}

/// The clock of each channel.
#[derive(Clone, Copy, Debug)]
pub struct SampleRates {
    imu_s: f64,
    last_s: [Option<f64>; CHANNELS],
}

impl SampleRates {
    /// Nothing written yet; inertial messages at most so often, Hz.
    pub fn new(imu_hz: f64) -> Self {
        SampleRates { imu_s: 1.0 / imu_hz, last_s: [None; CHANNELS] }
    }

    /// The channels of that kind that the sample has and that are due; they count as written. `None` where there is none.
    pub fn due(&mut self, kind: LoggedKind, sample: &Sample) -> Option<Sample> {
        let interval_s = if kind == LoggedKind::Imu { self.imu_s } else { 1.0 / SLOW_HZ };
        let mut part = Sample::new(sample.time_s);
        for &channel in kind.channels() {
            let (Some(value), Some(last_s)) = (sample.get(channel), self.last_s.get_mut(channel.index())) else { continue };
            if last_s.is_none_or(|last_s| sample.time_s - last_s > interval_s * (1.0 - EARLY)) {
                *last_s = Some(sample.time_s);
                part.set(channel, value);
            }
        }
        (part.present != 0).then_some(part)
    }
}

/// The channels of those that neither log has a message for, besides what `extra` carries.
pub fn not_carried(channels: &[Channel], extra: &[Channel]) -> Vec<Channel> {
    let carried = |channel: &Channel| {
        use LoggedKind::{Airspeed, Attitude, Controls, Flow, Imu, Pressure, Rotor};
        [Imu, Attitude, Flow, Airspeed, Pressure, Controls, Rotor].iter().any(|kind| kind.channels().contains(channel))
    };
    channels.iter().filter(|channel| !carried(channel) && !extra.contains(channel)).copied().collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn channels_sampled_at_different_moments_do_not_take_each_others_place() {
        let mut rates = SampleRates::new(ULOG_IMU_HZ);
        let (mut of_p, mut of_q) = (0, 0);
        for at in 0..1000_u32 {
            // Roll rate 200 times a second, pitch rate 1 ms behind each fourth of it.
            let mut sample = Sample::new(f64::from(at) / 1000.0);
            let (rolls, pitches) = (at % 5 == 0, at % 20 == 1);
            if rolls {
                sample.set(Channel::P, 0.0);
            }
            if pitches {
                sample.set(Channel::Q, 0.0);
            }
            let due = rates.due(LoggedKind::Imu, &sample);
            of_p += u32::from(due.is_some_and(|due| due.get(Channel::P).is_some()));
            of_q += u32::from(due.is_some_and(|due| due.get(Channel::Q).is_some()));
        }
        assert_eq!((of_p, of_q), (200, 50));
    }

    #[test]
    fn each_kind_comes_at_its_own_rate_and_only_where_it_was_sampled() {
        let mut rates = SampleRates::new(DATAFLASH_IMU_HZ);
        let mut counts = [0; 3];
        for at in 0..2000_u32 {
            let mut sample = Sample::new(f64::from(at) / 1000.0);
            sample.set(Channel::P, 0.0);
            sample.set(Channel::Phi, 0.0);
            if at % 40 == 0 {
                sample.set(Channel::Tas, 50.0);
            }
            for (kind, count) in [LoggedKind::Imu, LoggedKind::Attitude, LoggedKind::Airspeed].into_iter().zip(&mut counts) {
                *count += u32::from(rates.due(kind, &sample).is_some());
            }
            assert_eq!(rates.due(LoggedKind::Flow, &sample), None);
        }
        // A fast channel beside a slow one keeps its own clock.
        let mut mixed = SampleRates::new(ULOG_IMU_HZ);
        let mut headings = Vec::new();
        for at in 0..128_u32 {
            let mut sample = Sample::new(f64::from(at) / 128.0);
            sample.set(Channel::Psi, 0.0);
            if at % 4 == 0 {
                sample.set(Channel::Phi, 0.0);
            }
            let due = mixed.due(LoggedKind::Attitude, &sample);
            headings.extend(due.filter(|due| due.get(Channel::Psi).is_some()).map(|_| at));
        }
        assert!(headings.windows(2).all(|pair| pair[1] - pair[0] == 3), "{headings:?}");
        // Of samples a millisecond apart the inertial ones come every third: 400 a second are at least 2.5 ms apart.
        assert_eq!(counts, [667, 100, 50]);
        assert_eq!(not_carried(&[Channel::P, Channel::Flap0, Channel::Rho], &[Channel::Rho]), [Channel::Flap0]);
    }
}
