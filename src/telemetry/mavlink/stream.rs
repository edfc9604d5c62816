//! One vehicle's packets as samples: its clock, its channels, messages of the same instant put together.
//!
//! Consumes packets as they arrive; produces [`Timed`] samples in order of time, live and from files by the same code.
//! Messages within a millisecond (what the millisecond clocks cut off) make one sample, at the time of the one that
//! brings rates. A sample waits until the vehicle's clock is `reorder_us` further, so that late messages find their
//! place; a message later than that is not used, and counted. No sample mixes two boots.
//! The vehicle is the one that was named; else the first that sends motion. Of other senders only MANUAL_CONTROL for
//! the vehicle is used.

use super::clock::{Clock, Placed};
use super::mapping::{Config, Mapping};
use super::message::{Body, Kind, Reading};
use super::packet::Packet;
use super::senders::Sender;
use crate::flight::channel::Channel;
use crate::telemetry::record::Sample;
use std::collections::VecDeque;

/// Messages so near to each other are of one instant, us.
const INSTANT_US: i64 = 1000;
/// Samples that wait for late messages at most; the oldest goes when there are more.
const HELD_MAX: usize = 256;

/// A sample and the boot that it belongs to.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Timed {
    /// The sample, on the vehicle's own clock (see [`Clock`]).
    pub sample: Sample,
    /// Which boot, from 0.
    pub boot: u32,
}

/// What was not used.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Unused {
    /// Messages that came too late to find their place.
    pub late: u64,
    /// Messages whose time contradicts the others.
    pub in_doubt: u64,
    /// Messages before any clock was known.
    pub no_clock: u64,
}

#[derive(Clone, Copy, Debug)]
struct Tick {
    time_us: i64,
    sample: Sample,
}

/// One vehicle's stream.
#[derive(Clone, Debug)]
pub struct Stream {
    vehicle: Option<Sender>,
    mapping: Mapping,
    clock: Clock,
    /// In order of time.
    held: VecDeque<Tick>,
    ready: VecDeque<Timed>,
    boot: u32,
    released_us: i64,
    unused: Unused,
}

impl Stream {
    /// A stream of that vehicle, or of the first that the configuration admits.
    pub fn new(config: Config, vehicle: Option<Sender>) -> Self {
        Stream {
            vehicle,
            mapping: config.mapping(),
            clock: Clock::default(),
            held: VecDeque::new(),
            ready: VecDeque::new(),
            boot: 0,
            released_us: i64::MIN,
            unused: Unused::default(),
        }
    }

    /// The vehicle, once it is known.
    pub fn vehicle(&self) -> Option<Sender> {
        self.vehicle
    }

    /// The vehicle's clock.
    pub fn clock(&self) -> &Clock {
        &self.clock
    }

    /// What was not used so far.
    pub fn unused(&self) -> Unused {
        Unused { in_doubt: self.clock.in_doubt(), ..self.unused }
    }

    /// Takes in a packet that arrived at that host time, us.
    pub fn packet(&mut self, packet: &Packet, host_us: Option<u64>) {
        let Some(reading) = Reading::of(packet) else { return };
        let sender = Sender::of(packet);
        let admitted = admits(self.mapping.config(), sender);
        if self.vehicle.is_none() && reading.kind.is_motion() && admitted {
            self.vehicle = Some(sender);
        }
        let Some(vehicle) = self.vehicle else { return };
        let to_vehicle = matches!(reading.body, Body::Sticks { target, .. } if target == vehicle.system || target == 0);
        if sender != vehicle && !to_vehicle {
            return;
        }
        if reading.kind == Kind::Heartbeat {
            return;
        }
        match self.clock.place(reading.stamp, host_us) {
            Placed::At { time_us, boot } => {
                if boot != self.boot {
                    self.flush();
                    self.boot = boot;
                }
                self.put(&reading, time_us);
            }
            Placed::InDoubt => {}
            Placed::NoClock => self.unused.no_clock += 1,
        }
    }

    /// The next sample that waits no longer.
    pub fn next_sample(&mut self) -> Option<Timed> {
        self.ready.pop_front()
    }

    /// Lets every sample go: at the end, or where the vehicle has fallen silent.
    pub fn flush(&mut self) {
        while let Some(tick) = self.held.pop_front() {
            self.release(tick);
        }
    }

    fn put(&mut self, reading: &Reading, time_us: i64) {
        let mut sample = Sample::new(0.0);
        self.mapping.map(reading, time_us, |channel, value| sample.set(channel, value));
        if sample.present != 0 {
            if time_us <= self.released_us {
                self.unused.late += 1;
            } else {
                self.hold(time_us, sample);
            }
        }
        let newest_us = self.clock.newest_us().unwrap_or(time_us);
        let reorder_us = self.mapping.config().reorder_us;
        while let Some(tick) = self.held.front().copied() {
            if tick.time_us + reorder_us >= newest_us && self.held.len() <= HELD_MAX {
                break;
            }
            self.held.pop_front();
            self.release(tick);
        }
    }

    /// Puts what was measured into its instant, or makes a new one.
    fn hold(&mut self, time_us: i64, measured: Sample) {
        let fits = |tick: &&mut Tick| {
            let apart = (tick.time_us - time_us).abs();
            apart == 0 || (apart < INSTANT_US && tick.sample.present & measured.present == 0)
        };
        if let Some(tick) = self.held.iter_mut().rev().find(fits) {
            for channel in Channel::ALL {
                if let Some(value) = measured.get(channel) {
                    tick.sample.set(channel, value);
                }
            }
            if measured.get(Channel::P).is_some() {
                tick.time_us = time_us;
                self.held.make_contiguous().sort_by_key(|tick| tick.time_us);
            }
            return;
        }
        let place = self.held.iter().rposition(|tick| tick.time_us < time_us).map_or(0, |before| before + 1);
        self.held.insert(place, Tick { time_us, sample: measured });
    }

    fn release(&mut self, tick: Tick) {
        self.released_us = self.released_us.max(tick.time_us);
        #[expect(clippy::cast_precision_loss, reason = "below 2^53 us, 285 years")]
        let time_s = tick.time_us as f64 / 1e6;
        self.ready.push_back(Timed { sample: Sample { time_s, ..tick.sample }, boot: self.boot });
    }
}

/// Whether a sender can be the vehicle.
pub fn admits(config: &Config, sender: Sender) -> bool {
    config.system.is_none_or(|system| system == sender.system)
        && config.component.is_none_or(|component| component == sender.component)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::telemetry::mavlink::encode::{Frames, ME};
    use crate::telemetry::mavlink::packet::{Framer, Framing};
    use mavlink::dialects::ardupilotmega::{
        AOA_SSA_DATA, ATTITUDE_DATA, HIGHRES_IMU_DATA, HighresImuUpdatedFlags, MavMessage, VFR_HUD_DATA,
    };

    fn samples(messages: &[MavMessage], config: Config) -> (Vec<Timed>, Unused) {
        let mut frames = Frames::new(ME);
        let mut framer = Framer::new(Framing::Bare);
        let mut stream = Stream::new(config, None);
        for message in messages {
            framer.take(frames.frame(message));
            while let Some(packet) = framer.next_packet() {
                stream.packet(&packet, None);
            }
        }
        stream.flush();
        (std::iter::from_fn(|| stream.next_sample()).collect(), stream.unused())
    }

    fn imu(time_us: u64) -> MavMessage {
        MavMessage::HIGHRES_IMU(HIGHRES_IMU_DATA {
            time_usec: time_us,
            xgyro: 0.5,
            fields_updated: HighresImuUpdatedFlags::all(),
            ..Default::default()
        })
    }

    fn attitude(ms: u32, roll: f32) -> MavMessage {
        MavMessage::ATTITUDE(ATTITUDE_DATA { time_boot_ms: ms, roll, ..Default::default() })
    }

    #[test]
    fn messages_of_one_instant_make_one_sample_at_the_time_of_the_rates() {
        let flow = |time_us| MavMessage::AOA_SSA(AOA_SSA_DATA { time_usec: time_us, AOA: 180.0, SSA: -90.0 });
        let air = MavMessage::VFR_HUD(VFR_HUD_DATA { airspeed: 50.0, alt: 100.0, ..Default::default() });
        let messages =
            [imu(430), attitude(20, 0.25), imu(20_430), flow(20_430), air, imu(40_430), attitude(40, 0.5), imu(60_430)];
        let (samples, unused) = samples(&messages, Config::default());
        let times: Vec<f64> = samples.iter().map(|timed| timed.sample.time_s).collect();
        assert_eq!((times, unused), (vec![0.00043, 0.02043, 0.04043, 0.06043], Unused::default()));
        let first = samples[1].sample;
        let expected = [(Channel::P, 0.5), (Channel::Phi, 0.25), (Channel::Tas, 50.0)];
        assert!(expected.iter().all(|(channel, value)| first.get(*channel) == Some(*value)));
        assert_eq!(first.get(Channel::Alpha), Some(std::f64::consts::PI));
    }

    #[test]
    fn a_late_message_finds_its_place_and_one_that_is_too_late_is_counted() {
        let messages = [imu(100_000), imu(110_000), attitude(104, 0.1), imu(200_000), attitude(105, 0.2), imu(300_000)];
        let (samples, unused) = samples(&messages, Config::default());
        let times: Vec<f64> = samples.iter().map(|timed| timed.sample.time_s).collect();
        assert_eq!(times, [0.1, 0.104, 0.11, 0.2, 0.3]);
        assert_eq!(unused, Unused { late: 1, ..Unused::default() });
    }

    #[test]
    fn each_boot_is_its_own_segment() {
        let messages: Vec<_> = [600_000, 600_050, 1000, 1050, 1100, 1150].map(|ms| attitude(ms, 0.0)).into();
        let (samples, unused) = samples(&messages, Config::default());
        let found: Vec<(u32, f64)> = samples.iter().map(|timed| (timed.boot, timed.sample.time_s)).collect();
        assert_eq!(found, [(0, 600.0), (0, 600.05), (1, 602.05), (1, 602.1)]);
        assert_eq!(unused.in_doubt, 2);
    }
}
