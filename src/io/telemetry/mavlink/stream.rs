//! Packets of one vehicle as samples: its clock, its channels, messages of the same instant combined.
//!
//! Consumes packets as they arrive; produces [`TimedSample`]s in order of time, live and from files by the same code. Messages
//! within 1 ms (the resolution of millisecond clocks) form one sample, at the time of the message with angular rates. A sample is
//! released when the vehicle's clock is `reorder_us` ahead of it, so that late messages are put in order; a message later than
//! that is counted and not used. No sample combines two boots. The vehicle is the one named; otherwise the first sender of motion
//! (a recording names the sender of most messages of motion, and so does [`vehicle_selection`](super::vehicle_selection) live).
//! Of other senders only MANUAL_CONTROL for the vehicle is used. Live, messages that arrive while the clock is uncertain are
//! held, and none of a new boot is lost.

use super::clock::{BootClock, TimePlacement, has_boot_time};
use super::clock_monitor::ClockMonitor;
use super::mapping::{Mapping, MavlinkConfig};
use super::message::{MessageBody, MessageKind, MessageReading};
use super::packet::Packet;
use super::senders::Sender;
use crate::flight::channel::Channel;
use crate::flight::sample::Sample;
use std::collections::VecDeque;

/// Messages so near to each other are of one instant, us.
const INSTANT_US: i64 = 1000;
/// Samples that wait for late messages at most; the oldest goes when there are more.
const HELD_MAX: usize = 256;
/// Samples that wait to be taken at most, and messages that wait for a clock; the oldest goes when there are more.
pub const READY_MAX: usize = 4096;

/// A sample and the boot that it belongs to.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TimedSample {
    /// The sample, on the vehicle's own clock (see [`BootClock`]).
    pub sample: Sample,
    /// Which boot, from 0.
    pub boot: u32,
    /// Live, when it was sent: host time, us, by the vehicle's clock, and not after its first message arrived.
    pub sent_us: Option<i64>,
}

/// What was not used.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct UnusedMessages {
    /// Messages that came too late to find their place.
    pub late: u64,
    /// Messages whose time contradicts the others.
    pub in_doubt: u64,
    /// Messages before any clock was known.
    pub no_clock: u64,
    /// Samples that nobody took in time, and messages that waited too long for a clock.
    pub overrun: u64,
}

#[derive(Clone, Copy, Debug)]
struct HeldSample {
    time_us: i64,
    sample: Sample,
    sent_us: Option<i64>,
}

/// One vehicle's stream.
#[derive(Clone, Debug)]
pub struct VehicleStream {
    vehicle: Option<Sender>,
    mapping: Mapping,
    clock: BootClock,
    /// In order of time.
    held: VecDeque<HeldSample>,
    ready: VecDeque<TimedSample>,
    /// Live, messages whose clock is in doubt, with their arrival.
    doubtful: VecDeque<(MessageReading, Option<u64>)>,
    heard_us: Option<u64>,
    boot: u32,
    released_us: i64,
    unused: UnusedMessages,
}

impl VehicleStream {
    /// A stream of that vehicle, or of the first that the configuration admits.
    pub fn new(config: MavlinkConfig, vehicle: Option<Sender>) -> Self {
        VehicleStream {
            vehicle,
            mapping: config.mapping(),
            clock: BootClock::default(),
            held: VecDeque::new(),
            ready: VecDeque::new(),
            doubtful: VecDeque::new(),
            heard_us: None,
            boot: 0,
            released_us: i64::MIN,
            unused: UnusedMessages::default(),
        }
    }

    /// A stream of that vehicle live, on that clock.
    pub fn live(config: MavlinkConfig, vehicle: Sender, clock: BootClock) -> Self {
        let boot = clock.boot();
        VehicleStream { clock, boot, ..VehicleStream::new(config, Some(vehicle)) }
    }

    /// When the vehicle was last heard, us of host time.
    pub fn heard_us(&self) -> Option<u64> {
        self.heard_us
    }

    /// The vehicle, once it is known.
    pub fn vehicle(&self) -> Option<Sender> {
        self.vehicle
    }

    /// The vehicle's clock.
    pub fn clock(&self) -> &BootClock {
        &self.clock
    }

    /// What was not used so far.
    pub fn unused(&self) -> UnusedMessages {
        UnusedMessages { in_doubt: self.clock.in_doubt(), ..self.unused }
    }

    /// Takes in a packet that arrived at that host time, us.
    pub fn packet(&mut self, packet: &Packet, host_us: Option<u64>) {
        let Some(reading) = MessageReading::of(packet) else { return };
        let sender = Sender::of(packet);
        let admitted = admits(self.mapping.config(), sender);
        if self.vehicle.is_none() && reading.kind.is_motion() && admitted {
            self.vehicle = Some(sender);
        }
        let Some(vehicle) = self.vehicle else { return };
        let to_vehicle = matches!(reading.body, MessageBody::Sticks { target, .. } if target == vehicle.system || target == 0);
        if sender != vehicle && !to_vehicle {
            return;
        }
        self.heard_us = host_us.filter(|_| sender == vehicle).or(self.heard_us);
        if reading.kind == MessageKind::Heartbeat {
            return;
        }
        self.place(&reading, host_us);
    }

    fn place(&mut self, reading: &MessageReading, host_us: Option<u64>) {
        match self.clock.place(reading.stamp, host_us) {
            TimePlacement::At { time_us, boot } => {
                if boot != self.boot {
                    self.flush();
                    self.boot = boot;
                }
                if !self.doubtful.is_empty() && self.clock.witness().is_none_or(|witness| witness.waiting() == 0) {
                    self.no_doubt();
                }
                self.put(reading, time_us, host_us);
            }
            TimePlacement::InDoubt => match self.clock.witness().map(ClockMonitor::waiting) {
                None | Some(0) => {}
                Some(waiting) => {
                    if waiting == 1 && has_boot_time(reading.stamp) {
                        // Another clock than the one that was in doubt before.
                        self.doubtful.retain(|(before, _)| !has_boot_time(before.stamp));
                    }
                    if self.doubtful.len() >= READY_MAX {
                        self.doubtful.pop_front();
                        self.unused.overrun += 1;
                    }
                    self.doubtful.push_back((*reading, host_us));
                }
            },
            TimePlacement::Restarted => {
                let again = std::mem::take(&mut self.doubtful);
                for (before, host_us) in again {
                    self.place(&before, host_us);
                }
                self.place(reading, host_us);
            }
            TimePlacement::NoClock => self.unused.no_clock += 1,
        }
    }

    /// What waited was of strays or of another sender, save what has no boot time: that was the vehicle's.
    fn no_doubt(&mut self) {
        for (reading, host_us) in std::mem::take(&mut self.doubtful) {
            if !has_boot_time(reading.stamp)
                && let TimePlacement::At { time_us, .. } = self.clock.place(reading.stamp, host_us)
            {
                self.put(&reading, time_us, host_us);
            }
        }
    }

    /// The next sample that waits no longer.
    pub fn next_sample(&mut self) -> Option<TimedSample> {
        self.ready.pop_front()
    }

    /// Lets every sample go: at the end, or where the vehicle has fallen silent.
    pub fn flush(&mut self) {
        while let Some(tick) = self.held.pop_front() {
            self.release(tick);
        }
    }

    fn put(&mut self, reading: &MessageReading, time_us: i64, host_us: Option<u64>) {
        let mut sample = Sample::new(0.0);
        self.mapping.map(reading, time_us, |channel, value| sample.set(channel, value));
        if sample.present != 0 {
            if time_us <= self.released_us {
                self.unused.late += 1;
            } else {
                self.hold(time_us, sample, self.clock.sent_us(time_us, host_us));
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
    fn hold(&mut self, time_us: i64, measured: Sample, sent_us: Option<i64>) {
        let fits = |tick: &&mut HeldSample| {
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
                tick.sent_us = sent_us.or(tick.sent_us);
                self.held.make_contiguous().sort_by_key(|tick| tick.time_us);
            }
            return;
        }
        let place = self.held.iter().rposition(|tick| tick.time_us < time_us).map_or(0, |before| before + 1);
        self.held.insert(place, HeldSample { time_us, sample: measured, sent_us });
    }

    fn release(&mut self, tick: HeldSample) {
        self.released_us = self.released_us.max(tick.time_us);
        #[expect(clippy::cast_precision_loss, reason = "below 2^53 us, 285 years")]
        let time_s = tick.time_us as f64 / 1e6;
        if self.ready.len() >= READY_MAX {
            self.ready.pop_front();
            self.unused.overrun += 1;
        }
        self.ready.push_back(TimedSample { sample: Sample { time_s, ..tick.sample }, boot: self.boot, sent_us: tick.sent_us });
    }
}

/// Whether a sender can be the vehicle.
pub fn admits(config: &MavlinkConfig, sender: Sender) -> bool {
    config.system.is_none_or(|system| system == sender.system)
        && config.component.is_none_or(|component| component == sender.component)
}

#[cfg(test)]
mod tests {
    use super::super::encode::{Frames, ME};
    use super::super::message::Stamp;
    use super::super::packet::{Framer, Framing};
    use super::*;
    use mavlink::dialects::ardupilotmega::{
        AOA_SSA_DATA, ATTITUDE_DATA, HIGHRES_IMU_DATA, HighresImuUpdatedFlags, MavMessage, SERVO_OUTPUT_RAW_DATA, VFR_HUD_DATA,
    };

    fn samples(messages: &[MavMessage], config: MavlinkConfig) -> (Vec<TimedSample>, UnusedMessages) {
        let mut frames = Frames::new(ME);
        let mut framer = Framer::new(Framing::Bare);
        let mut stream = VehicleStream::new(config, None);
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
        let (samples, unused) = samples(&messages, MavlinkConfig::default());
        let times: Vec<f64> = samples.iter().map(|timed| timed.sample.time_s).collect();
        assert_eq!((times, unused), (vec![0.00043, 0.02043, 0.04043, 0.06043], UnusedMessages::default()));
        let first = samples[1].sample;
        let expected = [(Channel::P, 0.5), (Channel::Phi, 0.25), (Channel::Tas, 50.0)];
        assert!(expected.iter().all(|(channel, value)| first.get(*channel) == Some(*value)));
        assert_eq!(first.get(Channel::Alpha), Some(std::f64::consts::PI));
    }

    #[test]
    fn a_late_message_finds_its_place_and_one_that_is_too_late_is_counted() {
        let messages = [imu(100_000), imu(110_000), attitude(104, 0.1), imu(200_000), attitude(105, 0.2), imu(300_000)];
        let (samples, unused) = samples(&messages, MavlinkConfig::default());
        let times: Vec<f64> = samples.iter().map(|timed| timed.sample.time_s).collect();
        assert_eq!(times, [0.1, 0.104, 0.11, 0.2, 0.3]);
        assert_eq!(unused, UnusedMessages { late: 1, ..UnusedMessages::default() });
    }

    #[test]
    fn each_boot_is_its_own_segment() {
        let messages: Vec<_> = [600_000, 600_050, 1000, 1050, 1100, 1150].map(|ms| attitude(ms, 0.0)).into();
        let (samples, unused) = samples(&messages, MavlinkConfig::default());
        let found: Vec<(u32, f64)> = samples.iter().map(|timed| (timed.boot, timed.sample.time_s)).collect();
        assert_eq!(found, [(0, 600.0), (0, 600.05), (1, 602.05), (1, 602.1)]);
        assert_eq!(unused.in_doubt, 2);
    }

    const HOST_US: u64 = 50_000_000;

    /// Messages that arrive at those host times, us behind [`HOST_US`], on a live clock.
    fn live(messages: &[(u64, MavMessage)]) -> (Vec<TimedSample>, UnusedMessages, VehicleStream) {
        let mut frames = Frames::new(ME);
        let mut framer = Framer::new(Framing::Bare);
        let mut stream = VehicleStream::live(MavlinkConfig::default(), ME, BootClock::live(0));
        for (arrived_us, message) in messages {
            framer.take(frames.frame(message));
            while let Some(packet) = framer.next_packet() {
                stream.packet(&packet, Some(HOST_US + arrived_us));
            }
        }
        stream.flush();
        (std::iter::from_fn(|| stream.next_sample()).collect(), stream.unused(), stream)
    }

    #[test]
    fn live_a_boot_loses_nothing_whatever_clocks_its_messages_have() {
        let unix = 1_700_000_000_000_000;
        let air = |speed| MavMessage::VFR_HUD(VFR_HUD_DATA { airspeed: speed, alt: 100.0, ..Default::default() });
        let servos = |time_usec, k| {
            let servo4_raw = 1500 + k as u16;
            MavMessage::SERVO_OUTPUT_RAW(SERVO_OUTPUT_RAW_DATA { time_usec, servo4_raw, ..Default::default() })
        };
        let mut messages = Vec::new();
        for k in 0..100_u32 {
            // Started again after the fiftieth; the clock since 1970 goes on, and the last two minutes before 2^32 us.
            let boot_ms = if k < 50 { 4_200_000 + 20 * k } else { 20 * (k - 50) + 300 };
            let host_us = u64::from(k) * 20_000;
            messages.push((host_us, attitude(boot_ms, 0.1)));
            messages.push((host_us + 500, imu(unix + host_us)));
            messages.push((host_us + 600, air(40.0 + k as f32)));
            messages.push((host_us + 700, servos(boot_ms.wrapping_mul(1000), k)));
        }
        let (samples, unused, _) = live(&messages);
        assert_eq!((samples.len(), unused), (100, UnusedMessages::default()));
        for (k, timed) in samples.iter().enumerate() {
            assert_eq!(timed.boot, u32::from(k >= 50), "{k}");
            let values =
                [Channel::P, Channel::Phi, Channel::Tas].map(|channel| timed.sample.get(channel).map(|value| value as f32));
            assert_eq!(values, [Some(0.5), Some(0.1), Some(40.0 + k as f32)], "{k}");
            let pedal = timed.sample.get(Channel::Pedal).map(|angle| (angle.to_degrees() * 50.0).round());
            assert_eq!(pedal, Some(k as f64), "{k}");
        }
        assert!(samples.windows(2).all(|pair| pair[1].sample.time_s > pair[0].sample.time_s));
    }

    #[test]
    fn live_a_second_sender_of_the_same_id_is_counted_and_starts_no_run() {
        let mut messages = Vec::new();
        for k in 0..200_u32 {
            let host_us = u64::from(k) * 20_000;
            messages.push((host_us, attitude(100_000 + 20 * k, 0.1)));
            if k >= 50 {
                messages.push((host_us + 7_000, attitude(5_000_000 + 20 * k, 0.9)));
            }
        }
        let (samples, unused, stream) = live(&messages);
        assert_eq!((samples.len(), unused), (200, UnusedMessages { in_doubt: 150, ..UnusedMessages::default() }));
        assert!(samples.iter().all(|timed| timed.boot == 0 && timed.sample.get(Channel::Phi) != Some(0.9)));
        assert!(stream.clock().witness().is_some_and(ClockMonitor::sees_two));
        // Three spoofed stamps.
        let mut messages: Vec<_> = (0..100_u32).map(|k| (u64::from(k) * 20_000, attitude(100_000 + 20 * k, 0.1))).collect();
        (0..3).for_each(|k| messages.insert(50, (980_000 + k, attitude(1000 + 20 * k as u32, 0.9))));
        let (samples, unused, stream) = live(&messages);
        assert_eq!((samples.len(), unused.in_doubt, stream.clock().boots()), (100, 3, 1));
        assert!(!stream.clock().witness().is_some_and(ClockMonitor::sees_two));
    }

    #[test]
    fn live_what_waited_in_a_socket_is_as_old_as_it_is_and_a_standing_clock_is_seen() {
        let at = |k: u32, host_us| (host_us, attitude(100_000 + 20 * k, 0.1));
        let mut messages: Vec<_> = (0..100).map(|k| at(k, u64::from(k) * 20_000)).collect();
        messages.extend((100..300).map(|k| at(k, 6_000_000)));
        let (samples, _, stream) = live(&messages);
        for (k, timed) in samples.iter().enumerate() {
            let sent_us = HOST_US as i64 + 20_000 * k as i64;
            assert!((timed.sent_us.unwrap() - sent_us).abs() < 1_000, "{k}: {timed:?}");
        }
        // The next process goes on there.
        let mut next = BootClock::resumed(&stream.clock().remembered().unwrap());
        let arrived_us = HOST_US + 9_000_000;
        let TimePlacement::At { time_us, boot: 0 } = next.place(Stamp::BootMs(107_000), Some(arrived_us)) else { panic!() };
        assert!((next.sent_us(time_us, Some(arrived_us)).unwrap() - HOST_US as i64 - 7_000_000).abs() < 1_000);
        let standing: Vec<_> = (0..200).map(|k| (20_000 * k, attitude(0, 0.1))).collect();
        let (.., stream) = live(&standing);
        assert!(stream.clock().witness().is_some_and(ClockMonitor::stands_still));
    }

    #[test]
    fn samples_that_nobody_takes_do_not_grow_without_bound() {
        let messages: Vec<_> = (0..10_000_u32).map(|k| (u64::from(k) * 20_000, attitude(20 * k, 0.1))).collect();
        let (samples, unused, _) = live(&messages);
        assert_eq!((samples.len(), unused.overrun), (READY_MAX, 10_000 - READY_MAX as u64));
        assert_eq!(samples.last().map(|timed| timed.sample.time_s), Some(199.98));
    }
}
