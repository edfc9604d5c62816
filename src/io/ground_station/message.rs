//! What may leave towards a ground station, and its frames.
//!
//! Consumes a [`StationMessage`]; produces a frame of MAVLink 2. The enumeration is all there is: its payloads are written
//! here, byte by byte, and no other message of MAVLink can be given to [`StationFrames`]. No command, parameter, mission,
//! setpoint, override or manual control can be expressed, nor a heartbeat of an autopilot.

use crate::io::telemetry::mavlink::senders::Sender;
use mavlink::Message as _;
use mavlink::dialects::ardupilotmega::MavMessage;

/// Component id of the estimates: MAV_COMP_ID_ONBOARD_COMPUTER.
pub const COMPONENT: u8 = 191;
/// Letters of a name.
pub const NAME: usize = 10;
/// Bytes of a chunk of text.
pub const CHUNK: usize = 50;

const MARKER: u8 = 0xFD;
const HEADER: usize = 10;
/// MAV_TYPE_ONBOARD_CONTROLLER.
const ONBOARD_CONTROLLER: u8 = 18;
/// MAV_AUTOPILOT_INVALID: no autopilot.
const NO_AUTOPILOT: u8 = 8;
/// MAV_STATE_ACTIVE.
const ACTIVE: u8 = 4;
const PROTOCOL_VERSION: u8 = 3;

/// MAV_SEVERITY, of what is sent.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub enum StationSeverity {
    /// The answer may be worse for it.
    Warning = 4,
    /// Worth acting on, though nothing is wrong here: an error of the model.
    Notice = 5,
    /// Worth knowing.
    Info = 6,
}

/// Everything that may leave.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum StationMessage {
    /// HEARTBEAT: an onboard computer, active; no autopilot, no mode.
    Heartbeat,
    /// NAMED_VALUE_FLOAT.
    NamedValue {
        /// Time since the vehicle's boot, ms.
        time_boot_ms: u32,
        /// The name, filled up with zeros.
        name: [u8; NAME],
        /// The value; NaN says that there is none any more.
        value: f32,
    },
    /// STATUSTEXT, one chunk of it.
    Text {
        /// How much it matters.
        severity: StationSeverity,
        /// The text, filled up with zeros.
        text: [u8; CHUNK],
        /// Which text the chunk is of; 0 where it is the only one.
        id: u16,
        /// Its number in the text, from 0.
        chunk: u8,
    },
}

impl StationMessage {
    /// The ids of everything that may leave: HEARTBEAT, NAMED_VALUE_FLOAT, STATUSTEXT.
    pub const IDS: [u32; 3] = [0, 251, 253];

    /// The id of the message in MAVLink.
    pub const fn id(&self) -> u32 {
        let [heartbeat, named_value, text] = StationMessage::IDS;
        match self {
            StationMessage::Heartbeat => heartbeat,
            StationMessage::NamedValue { .. } => named_value,
            StationMessage::Text { .. } => text,
        }
    }

    /// A value with its name; more than ten letters have no place.
    pub fn named(name: &str, value: f32, time_boot_ms: u32) -> Self {
        StationMessage::NamedValue { time_boot_ms, name: filled(name.as_bytes()), value }
    }

    /// Writes the payload, in the order of MAVLink: the largest fields first, extensions last.
    fn payload(&self, bytes: &mut Vec<u8>) {
        match self {
            StationMessage::Heartbeat => {
                bytes.extend([0; 4]);
                bytes.extend([ONBOARD_CONTROLLER, NO_AUTOPILOT, 0, ACTIVE, PROTOCOL_VERSION]);
            }
            StationMessage::NamedValue { time_boot_ms, name, value } => {
                bytes.extend(time_boot_ms.to_le_bytes());
                bytes.extend(value.to_le_bytes());
                bytes.extend(name);
            }
            StationMessage::Text { severity, text, id, chunk } => {
                bytes.push(*severity as u8);
                bytes.extend(text);
                bytes.extend(id.to_le_bytes());
                bytes.push(*chunk);
            }
        }
    }
}

/// The first bytes of a text, filled up with zeros.
pub(super) fn filled<const N: usize>(text: &[u8]) -> [u8; N] {
    let mut bytes = [0; N];
    bytes.iter_mut().zip(text).for_each(|(to, from)| *to = *from);
    bytes
}

/// Numbers messages and puts them into frames.
#[derive(Debug)]
pub struct StationFrames {
    system: u8,
    sequence: u8,
    frame: Vec<u8>,
}

impl StationFrames {
    /// Frames of the onboard computer of that system.
    pub fn new(system: u8) -> Self {
        StationFrames { system, sequence: 0, frame: Vec::new() }
    }

    /// From now on of that system.
    pub fn set_system(&mut self, system: u8) {
        self.system = system;
    }

    /// Who sends them.
    pub fn sender(&self) -> Sender {
        Sender { system: self.system, component: COMPONENT }
    }

    /// The next frame.
    pub fn frame(&mut self, message: &StationMessage) -> &[u8] {
        let [low, middle, high, _] = message.id().to_le_bytes();
        self.frame.clear();
        self.frame.extend([MARKER, 0, 0, 0, self.sequence, self.system, COMPONENT, low, middle, high]);
        message.payload(&mut self.frame);
        // Zeros at the end are not sent, save the first byte.
        while self.frame.len() > HEADER + 1 && self.frame.last() == Some(&0) {
            self.frame.pop();
        }
        let length = self.frame.len().saturating_sub(HEADER);
        if let Some(place) = self.frame.get_mut(1) {
            // The longest payload is that of a text, 54 bytes.
            *place = length as u8;
        }
        let checked = self.frame.get(1..).unwrap_or_default();
        let checksum = mavlink::calculate_crc(checked, MavMessage::extra_crc(message.id()));
        self.frame.extend(checksum.to_le_bytes());
        self.sequence = self.sequence.wrapping_add(1);
        &self.frame
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::io::telemetry::mavlink::packet::{Framer, Framing, Packet};
    use mavlink::dialects::ardupilotmega::{MavAutopilot, MavModeFlag, MavSeverity, MavState, MavType};
    use mavlink::{MavlinkVersion, Message};

    /// Every kind of message that can be given to the encoder.
    fn every() -> [StationMessage; 3] {
        [
            StationMessage::Heartbeat,
            StationMessage::named("N_v", 0.5, 1234),
            StationMessage::Text { severity: StationSeverity::Notice, text: filled(b"a word"), id: 300, chunk: 2 },
        ]
    }

    fn packet(frames: &mut StationFrames, message: &StationMessage) -> Packet {
        let mut framer = Framer::new(Framing::Bare);
        framer.take(frames.frame(message));
        framer.next_packet().unwrap()
    }

    #[test]
    fn nothing_leaves_but_heartbeats_values_and_texts() {
        let mut frames = StationFrames::new(7);
        let ids = every().map(|message| packet(&mut frames, &message).id);
        assert_eq!(ids, StationMessage::IDS);
        let names = ids.map(|id| MavMessage::default_message_from_id(id).unwrap().message_name());
        assert_eq!(names, ["HEARTBEAT", "NAMED_VALUE_FLOAT", "STATUSTEXT"]);
        for banned in ["COMMAND_", "PARAM_", "SET_", "MISSION_", "RC_CHANNELS_OVERRIDE", "MANUAL_", "ACTUATOR", "SETUP_", "FILE_"]
        {
            assert!(names.iter().all(|name| !name.starts_with(banned)), "{banned}");
        }
        // A new kind of message does not compile here until it is added above.
        every().iter().for_each(|message| match message {
            StationMessage::Heartbeat | StationMessage::NamedValue { .. } | StationMessage::Text { .. } => {}
        });
    }

    #[test]
    fn another_decoder_reads_what_was_meant() {
        let mut frames = StationFrames::new(7);
        let mut read = |message: &StationMessage| {
            let packet = packet(&mut frames, message);
            assert_eq!((packet.version, packet.system, packet.component), (2, 7, 191));
            (packet.sequence, MavMessage::parse(MavlinkVersion::V2, packet.id, packet.payload()).unwrap())
        };
        let [heartbeat, value, text] = every();
        let (0, MavMessage::HEARTBEAT(beat)) = read(&heartbeat) else { panic!() };
        assert_eq!((beat.mavtype, beat.autopilot), (MavType::MAV_TYPE_ONBOARD_CONTROLLER, MavAutopilot::MAV_AUTOPILOT_INVALID));
        assert_eq!((beat.base_mode, beat.system_status), (MavModeFlag::empty(), MavState::MAV_STATE_ACTIVE));
        assert_eq!((beat.custom_mode, beat.mavlink_version), (0, 3));
        let (1, MavMessage::NAMED_VALUE_FLOAT(named)) = read(&value) else { panic!() };
        assert_eq!((named.time_boot_ms, named.value.to_bits()), (1234, 0.5_f32.to_bits()));
        assert_eq!(named.name.to_str(), Ok("N_v"));
        let (2, MavMessage::STATUSTEXT(words)) = read(&text) else { panic!() };
        assert_eq!((words.severity, words.text.to_str()), (MavSeverity::MAV_SEVERITY_NOTICE, Ok("a word")));
        // The dialect as it is built here has no extensions: id and chunk stand behind the text.
        assert_eq!(packet(&mut frames, &text).payload()[51..54], [44, 1, 2]);
    }

    #[test]
    fn a_long_name_is_cut_and_a_payload_of_zeros_keeps_one_byte() {
        let mut frames = StationFrames::new(1);
        let long = packet(&mut frames, &StationMessage::named("abcdefghijklm", f32::NAN, 0));
        assert_eq!(&long.payload()[8..20], b"abcdefghij\0\0");
        let zeros = packet(&mut frames, &StationMessage::named("", 0.0, 0));
        assert_eq!((zeros.length(), zeros.payload()[0]), (1, 0));
    }
}
