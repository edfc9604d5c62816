//! Live telemetry as samples: a link, its frames and the stream of the vehicle.
//!
//! Consumes bytes of a [`Link`] and host time; produces samples and counts. The caller alternates [`LiveTelemetry::poll`] and
//! [`LiveTelemetry::next_sample`], and calls [`LiveTelemetry::heartbeat`] once a second: many senders transmit only to a station
//! that sends heartbeats, and the peer of `udpout` learns the address from it. Samples that wait for late messages are released
//! when the vehicle is silent for the time limit. The end of a link is reported; the caller opens it again. Messages that arrive
//! before the vehicle is chosen ([`vehicle_selection`](super::vehicle_selection)) are queued, not lost. Where a key is set
//! ([`LiveTelemetry::set_signing`]) our heartbeats are signed, and frames that are not rightly signed are counted and go no
//! further: they make no sender and no sample. Notices for people are [`LiveNotice`]s, each kind reported once.

use super::clock::BootClock;
use super::clock_monitor::{ClockMonitor, SavedClock};
use super::encode::Frames;
use super::link::{DATAGRAM_MAX, Link, LinkError, LinkEvent, Url};
use super::mapping::MavlinkConfig;
use super::message::MessageKind;
use super::packet::{FrameTally, Framer, Framing, Packet};
use super::senders::{Sender, SenderTally, Senders};
use super::signing::{LinkSigning, REFUSALS, RefusedFrames, SigningRefusal};
use super::stream::{READY_MAX, TimedSample, UnusedMessages, VehicleStream, admits};
use super::vehicle_selection::{CLEAR, VehicleSelection};
use mavlink::dialects::ardupilotmega as dialect;
use mavlink::dialects::ardupilotmega::MavMessage;
use std::collections::VecDeque;
use std::io::Result as IoResult;
use std::time::Duration;

/// Our component id on the link that telemetry comes from: the second onboard computer. Estimates are sent as the first
/// ([`ground_station`](crate::io::ground_station)): where a router joins both links, each has running numbers of its own.
pub const COMPONENT: u8 = 192;

/// What is worth a word to a person.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum LiveNotice {
    /// The vehicle has fallen silent while another sends motion, which is the vehicle from now on.
    Changed {
        /// Who has fallen silent.
        from: Sender,
        /// Who sends.
        to: Sender,
    },
    /// Two senders use the vehicle's id with different clocks.
    TwoClocks(Sender),
    /// Two running numbers interleave under the vehicle's id.
    TwoNumbers(Sender),
    /// The vehicle's clock stands still at so many seconds.
    StandsStill(f64),
    /// The vehicle's clock was set back.
    SteppedBack {
        /// By so much, s.
        by_s: f64,
        /// When it had reached that time, s.
        at_s: f64,
    },
    /// The vehicle's clock runs so many times as fast as ours.
    RunsFast(f64),
    /// Another sender that could be the vehicle sends motion too.
    AnotherVehicle {
        /// Who is the vehicle.
        vehicle: Sender,
        /// Who sends motion too.
        other: Sender,
    },
    /// The vehicle's clock runs slower than ours: ages count from arrival.
    ByArrival,
    /// A frame was refused for that reason; those that follow are counted.
    Refused(SigningRefusal),
}

/// Live telemetry.
#[derive(Debug)]
pub struct LiveTelemetry {
    link: Link,
    patience: Duration,
    config: MavlinkConfig,
    choice: VehicleSelection,
    /// Messages before the choice, with their arrival.
    pending: VecDeque<(Packet, Option<u64>)>,
    /// What earlier vehicles left unused, and what waited too long for a choice.
    before: UnusedMessages,
    notices: VecDeque<LiveNotice>,
    /// Which of the notices that come once have been given.
    noticed: [bool; 5],
    /// Steps back of the clock that were noticed.
    steps_noticed: u32,
    /// Motion of senders that could be the vehicle and are not: how much, and whether it was noticed.
    others: u64,
    others_noticed: bool,
    /// The same of refused frames, by reason.
    refusals_noticed: [bool; REFUSALS],
    signing: Option<LinkSigning>,
    framer: Framer,
    stream: VehicleStream,
    senders: Senders,
    buffer: Box<[u8]>,
    /// Who our heartbeats come from, once the vehicle is known.
    frames: Frames,
    known_system: Option<u8>,
}

impl LiveTelemetry {
    /// Opens the link; a poll gives up after `patience`.
    ///
    /// # Errors
    /// [`LinkError`] where the link cannot be opened.
    pub fn open(url: Url, config: MavlinkConfig, patience: Duration) -> Result<Self, LinkError> {
        Ok(LiveTelemetry::on(Link::open(url, patience)?, config, patience))
    }

    /// The same on a link that is open already.
    pub fn on(link: Link, config: MavlinkConfig, patience: Duration) -> Self {
        LiveTelemetry {
            link,
            patience,
            framer: Framer::new(Framing::Bare),
            choice: VehicleSelection::default(),
            pending: VecDeque::new(),
            before: UnusedMessages::default(),
            notices: VecDeque::new(),
            noticed: [false; 5],
            steps_noticed: 0,
            others: 0,
            others_noticed: false,
            refusals_noticed: [false; REFUSALS],
            signing: None,
            stream: VehicleStream::new(config.clone(), None),
            config,
            senders: Senders::default(),
            buffer: vec![0; DATAGRAM_MAX].into(),
            frames: Frames::new(Sender { system: 1, component: COMPONENT }),
            known_system: None,
        }
    }

    /// From now on signs what is sent, and takes only what is rightly signed.
    pub fn set_signing(&mut self, signing: LinkSigning) {
        self.signing = Some(signing);
    }

    /// Opens the same link again, where it has ended; vehicle, clock and counts go on.
    ///
    /// # Errors
    /// [`LinkError`] where it cannot be opened.
    pub fn reopen(&mut self) -> Result<(), LinkError> {
        self.link = Link::open(self.link.url().clone(), self.patience)?;
        Ok(())
    }

    /// Goes on with a vehicle as another process left it; call it before the first [`LiveTelemetry::poll`]. `false` where the
    /// configuration does not admit that vehicle.
    pub fn resume(&mut self, vehicle: Sender, clock: &SavedClock) -> bool {
        let admitted = admits(&self.config, vehicle);
        if admitted {
            self.choice = VehicleSelection::made(vehicle);
            self.stream = VehicleStream::live(self.config.clone(), vehicle, BootClock::resumed(clock));
        }
        admitted
    }

    /// What the next process needs to go on; `None` before the vehicle's clock is known.
    pub fn remembered(&self) -> Option<(Sender, SavedClock)> {
        Some((self.stream.vehicle()?, self.stream.clock().remembered()?))
    }

    /// Waits for bytes and takes them in; `host_us` is the host's time then, us, on any clock that only goes forward.
    ///
    /// # Errors
    /// What the system says.
    pub fn poll(&mut self, host_us: impl FnOnce() -> Option<u64>) -> IoResult<LinkEvent> {
        let received = self.link.receive(&mut self.buffer)?;
        let host_us = host_us();
        match received {
            LinkEvent::Bytes(count) => {
                let buffer = std::mem::take(&mut self.buffer);
                let mut rest = buffer.get(..count).unwrap_or_default();
                while !rest.is_empty() {
                    let taken = self.framer.take(rest);
                    rest = rest.get(taken..).unwrap_or_default();
                    while let Some(packet) = self.framer.next_packet() {
                        self.observe(&packet, host_us);
                    }
                }
                if self.link.is_of_datagrams() {
                    while let Some(packet) = self.framer.last_packet_of_datagram() {
                        self.observe(&packet, host_us);
                    }
                }
                self.buffer = buffer;
                let quiet = host_us.zip(self.stream.heard_us()).map(|(now, heard)| now.saturating_sub(heard));
                if quiet.is_some_and(|quiet| u128::from(quiet) > self.patience.as_micros()) {
                    self.stream.flush();
                }
            }
            LinkEvent::Silence | LinkEvent::Closed => self.stream.flush(),
        }
        self.choose(host_us);
        self.notice();
        Ok(received)
    }

    /// What is worth a word, the oldest first.
    pub fn next_notice(&mut self) -> Option<LiveNotice> {
        self.notices.pop_front()
    }

    fn observe(&mut self, packet: &Packet, host_us: Option<u64>) {
        if let Some(Err(refusal)) = self.signing.as_mut().map(|signing| signing.accept(packet)) {
            if let Some(noticed @ false) = self.refusals_noticed.get_mut(refusal.index()) {
                *noticed = true;
                self.notices.push_back(LiveNotice::Refused(refusal));
            }
            return;
        }
        self.senders.count(packet);
        let Some(kind) = MessageKind::of(packet.id) else { return };
        let sender = Sender::of(packet);
        if self.choice.chosen().is_none() {
            if self.pending.len() >= READY_MAX {
                self.pending.pop_front();
                self.before.overrun += 1;
            }
            self.pending.push_back((*packet, host_us));
        } else {
            self.stream.packet(packet, host_us);
        }
        if kind.is_motion() && admits(&self.config, sender) {
            self.count_other(sender);
            self.choice.motion(sender);
            self.choose(host_us);
        }
    }

    /// Counts motion of a sender that is not the vehicle, once there is one.
    fn count_other(&mut self, other: Sender) {
        let Some(vehicle) = self.choice.chosen().filter(|vehicle| *vehicle != other) else { return };
        self.others += 1;
        if !self.others_noticed && self.senders.of(other).is_some_and(|tally| tally.motion >= u64::from(CLEAR)) {
            self.others_noticed = true;
            self.notices.push_back(LiveNotice::AnotherVehicle { vehicle, other });
        }
    }

    fn choose(&mut self, host_us: Option<u64>) {
        let before = self.choice.chosen();
        let Some(vehicle) = self.choice.change(host_us.unwrap_or(0)) else { return };
        let boot = match before {
            None => 0,
            Some(from) => {
                self.notices.push_back(LiveNotice::Changed { from, to: vehicle });
                self.before = self.unused();
                self.stream.clock().boot().saturating_add(1)
            }
        };
        self.stream = VehicleStream::live(self.config.clone(), vehicle, BootClock::live(boot));
        for (packet, host_us) in std::mem::take(&mut self.pending) {
            self.stream.packet(&packet, host_us);
        }
    }

    fn notice(&mut self) {
        let Some(vehicle) = self.stream.vehicle() else { return };
        let clock = self.stream.clock();
        let witness = |says: fn(&ClockMonitor) -> bool| clock.witness().is_some_and(says);
        #[expect(clippy::cast_precision_loss, reason = "below 2^55 us")]
        let seconds = |us: i64| us as f64 / 1e6;
        let stands_at_s = clock.newest_boot_us().map_or(0.0, seconds);
        let too_fast = clock.witness().and_then(ClockMonitor::too_fast);
        let (steps, by_us, at_us) = clock.steps_back();
        if steps != self.steps_noticed {
            self.steps_noticed = steps;
            if steps > 0 {
                self.notices.push_back(LiveNotice::SteppedBack { by_s: seconds(by_us), at_s: seconds(at_us) });
            }
        }
        let found = [
            (witness(ClockMonitor::sees_two), LiveNotice::TwoClocks(vehicle)),
            (self.senders.of(vehicle).is_some_and(SenderTally::has_two_numbers), LiveNotice::TwoNumbers(vehicle)),
            (witness(ClockMonitor::stands_still), LiveNotice::StandsStill(stands_at_s)),
            (witness(|witness| witness.offset().is_by_arrival()), LiveNotice::ByArrival),
            (too_fast.is_some(), LiveNotice::RunsFast(too_fast.unwrap_or(1.0))),
        ];
        for (noticed, (now, notice)) in self.noticed.iter_mut().zip(found) {
            if now && !*noticed {
                *noticed = true;
                self.notices.push_back(notice);
            }
        }
    }

    /// The next sample.
    pub fn next_sample(&mut self) -> Option<TimedSample> {
        self.stream.next_sample()
    }

    /// Says that we are there: an onboard computer of the vehicle's system, no autopilot. `false` where nobody is known
    /// yet to say it to, or no signature can be given.
    ///
    /// # Errors
    /// What the system says.
    pub fn heartbeat(&mut self) -> IoResult<bool> {
        let system = self.stream.vehicle().map(|vehicle| vehicle.system);
        if let Some(system) = system.filter(|_| system != self.known_system) {
            self.frames = Frames::new(Sender { system, component: COMPONENT });
            self.known_system = Some(system);
        }
        let message = MavMessage::HEARTBEAT(dialect::HEARTBEAT_DATA {
            custom_mode: 0,
            mavtype: dialect::MavType::MAV_TYPE_ONBOARD_CONTROLLER,
            autopilot: dialect::MavAutopilot::MAV_AUTOPILOT_INVALID,
            base_mode: dialect::MavModeFlag::empty(),
            system_status: dialect::MavState::MAV_STATE_ACTIVE,
            mavlink_version: 3,
        });
        let frame = self.frames.frame(&message);
        match &mut self.signing {
            None => self.link.send(frame),
            Some(signing) => signing.sign(frame).map_or(Ok(false), |signed| self.link.send(signed)),
        }
    }

    /// Frames that were refused so far, where a key is set.
    pub fn refused(&self) -> RefusedFrames {
        self.signing.as_ref().map(LinkSigning::refused).unwrap_or_default()
    }

    /// Why timestamps of signatures can no longer be kept, once where that is so.
    pub fn take_signing_fault(&mut self) -> Option<String> {
        self.signing.as_mut()?.take_fault()
    }

    /// By how many seconds the key's timestamps lead the clock, once where that is more than a minute.
    pub fn take_signing_lead_s(&mut self) -> Option<f64> {
        self.signing.as_mut()?.take_lead_s()
    }

    /// Frames with a right checksum, less those that were refused.
    pub fn accepted(&self) -> u64 {
        self.framer.tally().good.saturating_sub(self.refused().total())
    }

    /// The configuration.
    pub fn config(&self) -> &MavlinkConfig {
        &self.config
    }

    /// The link.
    pub fn link(&self) -> &Link {
        &self.link
    }

    /// The vehicle and its clock.
    pub fn stream(&self) -> &VehicleStream {
        &self.stream
    }

    /// Messages of motion of senders that could be the vehicle and are not.
    pub fn motion_of_others(&self) -> u64 {
        self.others
    }

    /// Who sent what so far.
    pub fn senders(&self) -> &Senders {
        &self.senders
    }

    /// Frames and damage so far.
    pub fn tally(&self) -> FrameTally {
        self.framer.tally()
    }

    /// Messages of the vehicle that were not used so far.
    pub fn unused(&self) -> UnusedMessages {
        let (before, now) = (self.before, self.stream.unused());
        UnusedMessages {
            late: before.late + now.late,
            in_doubt: before.in_doubt + now.in_doubt,
            no_clock: before.no_clock + now.no_clock,
            overrun: before.overrun + now.overrun,
        }
    }
}
