//! Who sent what: messages by system and component id, and which of the senders is the vehicle.
//!
//! Consumes packets; produces counts, in memory that strangers cannot grow: senders beyond [`SENDERS_MAX`] are counted
//! together. The vehicle is who sends most messages of motion (inertial or attitude); of two with the same number the
//! one with the lower ids.

use super::message::{Body, Kind, Reading};
use super::packet::{Packet, name_of};
use std::collections::BTreeMap;

/// Senders that are kept apart.
pub const SENDERS_MAX: usize = 256;

/// Id of HEARTBEAT.
const HEARTBEAT: u32 = 0;
/// MAV_TYPE of a fixed wing.
const FIXED_WING: u8 = 1;
/// MAV_AUTOPILOT of one that is no autopilot.
const NO_AUTOPILOT: u8 = 8;

/// Who sends, by system and component id.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Sender {
    /// System id.
    pub system: u8,
    /// Component id.
    pub component: u8,
}

impl Sender {
    /// Who sent a packet.
    pub fn of(packet: &Packet) -> Self {
        Sender { system: packet.system, component: packet.component }
    }
}

impl std::fmt::Display for Sender {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}/{}", self.system, self.component)
    }
}

/// What one sender sent.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct SenderTally {
    messages: BTreeMap<u32, u64>,
    /// Messages of motion.
    pub motion: u64,
    /// Whether its heartbeat says that it is a fixed wing.
    pub fixed_wing: bool,
    /// Messages that never came, by the gaps in its running numbers.
    pub missing: u64,
    newest: Option<u8>,
}

impl SenderTally {
    /// How many messages in all.
    pub fn total(&self) -> u64 {
        self.messages.values().sum()
    }

    /// Whether a heartbeat has said what it is.
    pub fn has_introduced_itself(&self) -> bool {
        self.messages.contains_key(&HEARTBEAT)
    }

    /// A gap of half the numbers or more is one that came late.
    fn number(&mut self, sequence: u8) {
        let ahead = self.newest.map_or(1, |newest| sequence.wrapping_sub(newest));
        if (1..128).contains(&ahead) {
            self.missing += u64::from(ahead - 1);
            self.newest = Some(sequence);
        }
    }

    /// Name and number of each message, in the order of their names.
    pub fn by_name(&self) -> BTreeMap<String, u64> {
        let name = |id: u32| name_of(id).map_or_else(|| format!("message {id}"), str::to_owned);
        self.messages.iter().map(|(&id, &count)| (name(id), count)).collect()
    }
}

/// Every sender.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Senders {
    tallies: BTreeMap<Sender, SenderTally>,
    /// Messages of senders beyond those that are kept apart.
    pub others: u64,
}

impl Senders {
    /// Counts one packet.
    pub fn count(&mut self, packet: &Packet) {
        let sender = Sender::of(packet);
        if self.tallies.len() >= SENDERS_MAX && !self.tallies.contains_key(&sender) {
            self.others += 1;
            return;
        }
        let tally = self.tallies.entry(sender).or_default();
        tally.number(packet.sequence);
        *tally.messages.entry(packet.id).or_default() += 1;
        match Kind::of(packet.id) {
            Some(Kind::Heartbeat) => {
                if let Some(Reading { body: Body::Presence { vehicle, autopilot }, .. }) = Reading::of(packet) {
                    tally.fixed_wing = vehicle == FIXED_WING && autopilot != NO_AUTOPILOT;
                }
            }
            Some(kind) if kind.is_motion() => tally.motion += 1,
            _ => {}
        }
    }

    /// Each sender, in the order of ids.
    pub fn iter(&self) -> impl Iterator<Item = (Sender, &SenderTally)> {
        self.tallies.iter().map(|(sender, tally)| (*sender, tally))
    }

    /// What one of them sent.
    pub fn of(&self, sender: Sender) -> Option<&SenderTally> {
        self.tallies.get(&sender)
    }

    /// How many messages in all.
    pub fn total(&self) -> u64 {
        self.others + self.tallies.values().map(SenderTally::total).sum::<u64>()
    }

    /// Who of the admitted sends most messages of motion; `None` where none of them sends any.
    pub fn vehicle(&self, admitted: impl Fn(Sender) -> bool) -> Option<Sender> {
        let candidates = || self.iter().filter(|(sender, tally)| tally.motion > 0 && admitted(*sender));
        let most = candidates().map(|(_, tally)| tally.motion).max()?;
        candidates().find(|(_, tally)| tally.motion == most).map(|(sender, _)| sender)
    }
}
