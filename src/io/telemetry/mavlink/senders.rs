//! Senders on a link: message counts by system and component id, and the vehicle among them.
//!
//! Consumes packets; produces counts in bounded memory: senders beyond [`SENDERS_MAX`] are counted together, and a sender of
//! motion replaces one without, or the one with the least. The vehicle is the sender of most messages of motion (inertial or
//! attitude); of two with equal counts the one with the lower ids. This rule is for a whole recording; live, see
//! [`vehicle_selection`](super::vehicle_selection).

use super::message::{MessageBody, MessageKind, MessageReading};
use super::packet::{Packet, name_of};
use std::collections::BTreeMap;

/// Senders that are kept apart.
pub const SENDERS_MAX: usize = 256;

const HEARTBEAT: u32 = 0;
/// How the source of a run from MAVLink begins.
const SOURCE: &str = "MAVLink, sender ";
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

    /// As the source of a run.
    pub fn as_source(self) -> String {
        format!("{SOURCE}{self}")
    }

    /// The sender that is the source of a run; `None` for a run from elsewhere.
    pub fn from_source(text: &str) -> Option<Self> {
        let (system, component) = text.strip_prefix(SOURCE)?.split_once('/')?;
        Some(Sender { system: system.parse().ok()?, component: component.parse().ok()? })
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
    /// MAV_TYPE of its newest heartbeat.
    pub vehicle_type: Option<u8>,
    /// Messages that never came, by the gaps in its running numbers.
    pub missing: u64,
    /// Messages that came after later ones, by the same numbers; they are not missing.
    pub late: u64,
    newest: Option<u8>,
    /// Which of the newest numbers came: bit k is that of the newest less k.
    came: u128,
    numbers: Numbers,
}

/// Two running numbers that are this near are one, out of order or sent twice.
const NEAR: u8 = 16;
/// Changes between two running numbers that show them.
const CHANGES: u32 = 50;

/// The running numbers that come next, of the one that was followed last and of the one before it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
struct Numbers {
    next: [Option<u8>; 2],
    changes: u32,
}

impl Numbers {
    fn take(&mut self, sequence: u8) {
        let [current, left] = self.next;
        let following = Some(sequence.wrapping_add(1));
        if current == Some(sequence) {
            self.next = [following, left];
            return;
        }
        if left == Some(sequence)
            && let Some(current) = current
            && sequence.wrapping_sub(current).min(current.wrapping_sub(sequence)) > NEAR
        {
            self.changes = self.changes.saturating_add(1);
        }
        self.next = [following, current];
    }
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

    /// Whether two running numbers interleave: two senders of one id, or one that comes by two ways.
    pub fn has_two_numbers(&self) -> bool {
        self.numbers.changes >= CHANGES
    }

    /// A gap of half the numbers or more is one that came late, and is missing no longer.
    fn number(&mut self, sequence: u8) {
        self.numbers.take(sequence);
        let ahead = self.newest.map_or(1, |newest| sequence.wrapping_sub(newest));
        if (1..128).contains(&ahead) {
            self.missing += u64::from(ahead - 1);
            self.newest = Some(sequence);
            self.came = self.came << ahead | 1;
            return;
        }
        let place = 1_u128.checked_shl(u32::from(ahead.wrapping_neg())).unwrap_or(0);
        // What was sent twice, and what is older than the first number, was not missing.
        if place != 0 && self.came & place == 0 && self.missing > 0 {
            self.came |= place;
            self.missing -= 1;
            self.late += 1;
        }
    }

    /// The kind of aircraft that its heartbeat names; `None` before the first.
    pub fn aircraft(&self) -> Option<String> {
        let kind = match self.vehicle_type? {
            1 => "fixed wing",
            2 => "quadrotor",
            3 => "coaxial helicopter",
            4 => "helicopter",
            13 => "hexarotor",
            14 => "octorotor",
            15 => "tricopter",
            19..=25 => "VTOL aircraft",
            29 => "dodecarotor",
            other => return Some(format!("aircraft of MAV_TYPE {other}")),
        };
        Some(kind.to_owned())
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
    /// Counts one packet; gives the sender whose place was taken for it, if any.
    pub fn count(&mut self, packet: &Packet) -> Option<Sender> {
        let sender = Sender::of(packet);
        let mut gone = None;
        if self.tallies.len() >= SENDERS_MAX && !self.tallies.contains_key(&sender) {
            gone = MessageKind::of(packet.id).filter(|kind| kind.is_motion()).and_then(|_| self.least());
            let Some(tally) = gone.and_then(|gone| self.tallies.remove(&gone)) else {
                self.others += 1;
                return None;
            };
            self.others += tally.total();
        }
        let tally = self.tallies.entry(sender).or_default();
        tally.number(packet.sequence);
        *tally.messages.entry(packet.id).or_default() += 1;
        match MessageKind::of(packet.id) {
            Some(MessageKind::Heartbeat) => {
                if let Some(MessageReading { body: MessageBody::Presence { vehicle, autopilot }, .. }) =
                    MessageReading::of(packet)
                {
                    tally.fixed_wing = vehicle == FIXED_WING && autopilot != NO_AUTOPILOT;
                    tally.vehicle_type = Some(vehicle);
                }
            }
            Some(kind) if kind.is_motion() => tally.motion += 1,
            _ => {}
        }
        gone
    }

    /// Who sends least motion, and of those the fewest messages.
    fn least(&self) -> Option<Sender> {
        self.iter().min_by_key(|(_, tally)| (tally.motion, tally.total())).map(|(sender, _)| sender)
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

#[cfg(test)]
mod tests {
    use super::super::encode::Frames;
    use super::super::packet::{Framer, Framing};
    use super::*;
    use mavlink::dialects::ardupilotmega::{ATTITUDE_DATA, HEARTBEAT_DATA, MavMessage};

    fn packets(frames: &mut Frames, message: &MavMessage) -> Packet {
        let mut framer = Framer::new(Framing::Bare);
        framer.take(frames.frame(message));
        framer.next_packet().unwrap()
    }

    fn motion() -> MavMessage {
        MavMessage::ATTITUDE(ATTITUDE_DATA::default())
    }

    #[test]
    fn who_sends_motion_is_counted_however_many_strangers_came_first() {
        for strangers in [MavMessage::HEARTBEAT(HEARTBEAT_DATA::default()), motion()] {
            let mut senders = Senders::default();
            for (system, component) in (2..=200).flat_map(|system| [(system, 1), (system, 2)]) {
                senders.count(&packets(&mut Frames::new(Sender { system, component }), &strangers));
            }
            let vehicle = Sender { system: 1, component: 1 };
            let mut frames = Frames::new(vehicle);
            for _ in 0..50 {
                senders.count(&packets(&mut frames, &motion()));
            }
            assert_eq!((senders.iter().count(), senders.total()), (SENDERS_MAX, 448));
            assert_eq!(senders.vehicle(|_| true), Some(vehicle));
            assert_eq!(senders.of(vehicle).map(|tally| (tally.motion, tally.missing)), Some((50, 0)));
        }
    }

    #[test]
    fn a_source_names_its_sender() {
        let sender = Sender { system: 42, component: 7 };
        assert_eq!(sender.as_source(), "MAVLink, sender 42/7");
        assert_eq!(Sender::from_source(&sender.as_source()), Some(sender));
        for other in ["", "flight.csv", "MAVLink, sender 300/1", "MAVLink, sender 1"] {
            assert_eq!(Sender::from_source(other), None, "{other}");
        }
    }

    #[test]
    fn who_comes_late_is_not_missing_and_who_comes_twice_hides_nobody() {
        let counts = |order: &mut dyn Iterator<Item = u32>| {
            let mut tally = SenderTally::default();
            order.for_each(|k| tally.number((k % 256) as u8));
            (tally.missing, tally.late)
        };
        // Each block of 60 comes from its end; the last of all stays the newest.
        let blocks = |k: u32| k / 60 * 60 + 59 - k % 60;
        // Before the first number that came nothing is known to be missing.
        assert_eq!(counts(&mut (0..6000).map(blocks)), (0, 99 * 59), "late");
        assert_eq!(counts(&mut (0..6000).filter(|k| k % 7 != 0).map(|k| k ^ 1)).0, 858, "late and lost");
        // Of 858 that are lost the first comes before every number that is known, and the last behind.
        assert_eq!(counts(&mut (0..6000).filter(|k| k % 7 != 0).flat_map(|k| [k, k])), (856, 0), "twice and lost");
    }

    #[test]
    fn two_running_numbers_are_seen_and_losses_late_ones_and_doubles_are_none() {
        let changes = |order: &mut dyn Iterator<Item = u8>| {
            let mut numbers = Numbers::default();
            order.for_each(|sequence| numbers.take(sequence));
            numbers.changes
        };
        let wrapping = |k: u32| (k % 256) as u8;
        assert_eq!(changes(&mut (0..2000).filter(|k| k % 7 != 0).map(wrapping)), 0, "losses");
        assert_eq!(changes(&mut (0..2000).map(|k| wrapping(k ^ 1))), 0, "late");
        assert_eq!(changes(&mut (0..2000).map(|k| wrapping(k / 2))), 0, "doubles");
        let both =
            changes(&mut (0..2000).map(|k| wrapping(if k / 5 % 2 == 0 { k / 10 * 5 + k % 5 } else { 90 + k / 10 * 5 + k % 5 })));
        assert!(both >= 390, "{both}");
    }
}
