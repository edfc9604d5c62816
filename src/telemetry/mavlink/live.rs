//! A link, its frames and the vehicle's stream in one: live telemetry as samples.
//!
//! Consumes bytes of a [`Link`] and the host's time; produces samples and counts. Whoever runs it calls [`Live::poll`] in
//! turn with [`Live::next_sample`], and [`Live::heartbeat`] once a second: without it many senders send nothing, and the
//! one that is called by `udpout` does not know of us. Where the link is silent for its time limit, the samples that
//! wait for late messages are let go. An end of the link is reported, and is for the caller to mend by opening it anew.

use super::encode::Frames;
use super::link::{DATAGRAM_MAX, Link, LinkError, Received, Url};
use super::mapping::Config;
use super::packet::{Framer, Framing, Packet, Tally};
use super::senders::{Sender, Senders};
use super::stream::{Stream, Timed, Unused};
use mavlink::dialects::ardupilotmega as dialect;
use mavlink::dialects::ardupilotmega::MavMessage;
use std::io::Result as IoResult;
use std::time::Duration;

/// Our component id beside an autopilot: that of an onboard computer.
pub const COMPONENT: u8 = 191;

/// Live telemetry.
#[derive(Debug)]
pub struct Live {
    link: Link,
    patience: Duration,
    framer: Framer,
    stream: Stream,
    senders: Senders,
    buffer: Box<[u8]>,
    /// Who our heartbeats come from, once the vehicle is known.
    frames: Frames,
    known_system: Option<u8>,
}

impl Live {
    /// Opens the link; a poll gives up after `patience`.
    ///
    /// # Errors
    /// [`LinkError`] where the link cannot be opened.
    pub fn open(url: Url, config: Config, patience: Duration) -> Result<Self, LinkError> {
        Ok(Live::on(Link::open(url, patience)?, config, patience))
    }

    /// The same on a link that is open already.
    pub fn on(link: Link, config: Config, patience: Duration) -> Self {
        Live {
            link,
            patience,
            framer: Framer::new(Framing::Bare),
            stream: Stream::new(config, None),
            senders: Senders::default(),
            buffer: vec![0; DATAGRAM_MAX].into(),
            frames: Frames::new(Sender { system: 1, component: COMPONENT }),
            known_system: None,
        }
    }

    /// Opens the same link again, where it has ended; vehicle, clock and counts go on.
    ///
    /// # Errors
    /// [`LinkError`] where it cannot be opened.
    pub fn reopen(&mut self) -> Result<(), LinkError> {
        self.link = Link::open(self.link.url().clone(), self.patience)?;
        Ok(())
    }

    /// Waits for bytes and takes them in; `host_us` is the host's time then, us, on any clock that only goes forward.
    ///
    /// # Errors
    /// What the system says.
    pub fn poll(&mut self, host_us: impl FnOnce() -> Option<u64>) -> IoResult<Received> {
        let received = self.link.receive(&mut self.buffer)?;
        match received {
            Received::Bytes(count) => {
                let host_us = host_us();
                let mut rest = self.buffer.get(..count).unwrap_or_default();
                while !rest.is_empty() {
                    let taken = self.framer.take(rest);
                    rest = rest.get(taken..).unwrap_or_default();
                    while let Some(packet) = self.framer.next_packet() {
                        hear(&mut self.senders, &mut self.stream, &packet, host_us);
                    }
                }
            }
            Received::Silence | Received::Closed => self.stream.flush(),
        }
        Ok(received)
    }

    /// The next sample.
    pub fn next_sample(&mut self) -> Option<Timed> {
        self.stream.next_sample()
    }

    /// Says that we are there: an onboard computer of the vehicle's system, no autopilot. `false` where nobody is known
    /// yet to say it to.
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
        self.link.send(self.frames.frame(&message))
    }

    /// The link.
    pub fn link(&self) -> &Link {
        &self.link
    }

    /// The vehicle and its clock.
    pub fn stream(&self) -> &Stream {
        &self.stream
    }

    /// Who sent what so far.
    pub fn senders(&self) -> &Senders {
        &self.senders
    }

    /// Frames and damage so far.
    pub fn tally(&self) -> Tally {
        self.framer.tally()
    }

    /// Messages of the vehicle that were not used so far.
    pub fn unused(&self) -> Unused {
        self.stream.unused()
    }
}

fn hear(senders: &mut Senders, stream: &mut Stream, packet: &Packet, host_us: Option<u64>) {
    senders.count(packet);
    stream.packet(packet, host_us);
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::flight::channel::{Channel, ControlNames};
    use crate::telemetry::mavlink::encode::{Encoder, ME};
    use crate::telemetry::record::Sample;

    #[test]
    fn a_sender_on_the_loopback_is_heard_and_hears_our_heartbeat() {
        let patience = Duration::from_millis(20);
        let mut live = Live::open(Url::UdpIn("127.0.0.1:0".into()), Config::default(), patience).unwrap();
        let address = live.link().local_address().unwrap().to_string();
        assert!(!live.heartbeat().unwrap());
        let mut sender = Link::open(Url::UdpOut(address), patience).unwrap();
        let mut encoder = Encoder::new(ME, Config::default(), ControlNames::Rotorcraft);
        let mut heard = Vec::new();
        for i in 0..50 {
            let mut sample = Sample::new(10.0 + 0.02 * f64::from(i));
            sample.set(Channel::R, 0.125 * f64::from(i));
            sample.set(Channel::Pedal, 0.0);
            encoder.sample(&sample, |frame| assert!(sender.send(frame).unwrap())).unwrap();
            while heard.len() < usize::try_from(i).unwrap() && live.poll(|| Some(1)).unwrap() != Received::Silence {
                heard.extend(std::iter::from_fn(|| live.next_sample()).map(|timed| timed.sample));
            }
        }
        while live.poll(|| None).unwrap() != Received::Silence {}
        heard.extend(std::iter::from_fn(|| live.next_sample()).map(|timed| timed.sample));
        assert_eq!(heard.len(), 50);
        assert_eq!(heard.last().and_then(|last| last.get(Channel::R)), Some(0.125 * 49.0));
        assert!(live.heartbeat().unwrap());
        let mut buffer = [0; 64];
        assert_eq!(sender.receive(&mut buffer).unwrap(), Received::Bytes(21));
        assert_eq!((buffer[5], buffer[6]), (1, COMPONENT));
        assert_eq!(live.stream().vehicle(), Some(ME));
    }
}
