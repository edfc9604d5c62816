//! Framing of MAVLink 1 and 2: packets from bytes that arrive in chunks of any size, with other bytes between frames.
//!
//! Consumes bytes; produces every [`Packet`] with a correct checksum, in order. After a failure the search continues one byte
//! later, so that no valid frame is lost to a false start marker. A frame with a wrong checksum, or of a message that the dialect
//! does not contain, is counted as a frame only if it begins at the end of the frame before and is followed by a start marker or
//! the end of the bytes; other bytes are counted as garbage. Signatures are kept with the packet and verified by
//! [`signing`](super::signing). Memory: one buffer of [`BUFFER`] bytes. A false start marker delays what follows by at most its
//! supposed length, 280 bytes, and nothing beyond the end of a datagram ([`Framer::last_packet_of_datagram`]).

use super::frame_signature::{FrameSignature, SIGNATURE};
use super::running_crc::RunningCrc;
use crate::io::telemetry::byte_window::ByteWindow;
use mavlink::Message as _;
use mavlink::dialects::ardupilotmega::MavMessage;

/// Bytes that are kept at most.
pub const BUFFER: usize = 4096;
/// The longest payload, bytes.
pub const PAYLOAD_MAX: usize = 255;

const MARKER_1: u8 = 0xFE;
/// The first byte of a frame of MAVLink 2.
pub(super) const MARKER_2: u8 = 0xFD;
/// The incompatibility flag of a signed frame.
pub(super) const FLAG_SIGNED: u8 = 1;
/// Bytes of a frame of MAVLink 2 before its payload.
pub(super) const HEADER_2: usize = 10;
/// Time stamps of logs are microseconds before the year 2112.
const STAMP_BITS: u32 = 52;

/// What stands before each frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Framing {
    /// Nothing: a link.
    Bare,
    /// Eight bytes, big-endian microseconds since 1970: a tlog.
    Stamped,
}

impl Framing {
    const fn prefix(self) -> u64 {
        match self {
            Framing::Bare => 0,
            Framing::Stamped => 8,
        }
    }
}

/// One frame with a right checksum.
#[derive(Clone, Copy, PartialEq, Eq)]
pub struct Packet {
    /// Version of the protocol, 1 or 2.
    pub version: u8,
    /// System id of the sender.
    pub system: u8,
    /// Component id of the sender.
    pub component: u8,
    /// The sender's running number.
    pub sequence: u8,
    /// Id of the message.
    pub id: u32,
    /// Where its first byte stood, bytes from the start.
    pub at: u64,
    /// Where it ended: the place of the first byte behind it (and behind its signature).
    pub end: u64,
    /// When it was received, microseconds since 1970, where a log says so.
    pub stamp_us: Option<u64>,
    /// Its signature, unverified, where it has one.
    pub signature: Option<FrameSignature>,
    compatibility: u8,
    checksum: [u8; 2],
    length: u8,
    payload: [u8; PAYLOAD_MAX],
}

impl Packet {
    /// The payload, filled up with zeros as MAVLink 2 demands (trailing zeros are not sent).
    pub fn payload(&self) -> &[u8; PAYLOAD_MAX] {
        &self.payload
    }

    /// How many bytes of the payload were sent.
    pub fn length(&self) -> u8 {
        self.length
    }

    /// The frame as it was sent, up to the end of its checksum, in pieces; of MAVLink 2 alone.
    pub(super) fn sent_bytes(&self, mut take: impl FnMut(&[u8])) {
        let [low, middle, high, _] = self.id.to_le_bytes();
        let flags = if self.signature.is_some() { FLAG_SIGNED } else { 0 };
        let (length, compatibility) = (self.length, self.compatibility);
        take(&[MARKER_2, length, flags, compatibility, self.sequence, self.system, self.component, low, middle, high]);
        take(self.payload.get(..usize::from(length)).unwrap_or_default());
        take(&self.checksum);
    }
}

impl std::fmt::Debug for Packet {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(
            f,
            "Packet(v{} {}/{} #{} id {} {} bytes)",
            self.version, self.system, self.component, self.sequence, self.id, self.length
        )
    }
}

/// What was found so far.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct FrameTally {
    /// Frames with a right checksum.
    pub good: u64,
    /// Frames with a wrong checksum, or with flags that the protocol does not define.
    pub bad_checksum: u64,
    /// Frames of messages that the dialect lacks: their checksum cannot be verified.
    pub unknown: u64,
    /// Bytes that belong to no frame.
    pub garbage_bytes: u64,
    /// Where the first bad frame or the first garbage began, bytes from the start.
    pub first_damage_at: Option<u64>,
}

/// A frame that could not be verified, until it shows what follows it.
#[derive(Clone, Copy, Debug)]
struct Unverified {
    known: bool,
    from: u64,
    length: u64,
}

/// What the bytes at a marker are.
enum FrameCandidate {
    Incomplete,
    Good { length: usize, header: usize },
    Unverified { known: bool, length: usize },
}

/// Finds frames.
pub struct Framer {
    framing: Framing,
    window: ByteWindow,
    sums: RunningCrc,
    /// The eight bytes before it, big-endian.
    before: u64,
    /// Where the last frame ended.
    frame_end: u64,
    /// Where the next frame must begin, as long as frames stand in step.
    expected: Option<u64>,
    pending: Option<Unverified>,
    /// Bytes that belong to frames and their stamps.
    accounted: u64,
    tally: FrameTally,
}

impl std::fmt::Debug for Framer {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Framer").field("position", &self.window.position()).field("tally", &self.tally).finish_non_exhaustive()
    }
}

impl Framer {
    /// Nothing seen yet.
    pub fn new(framing: Framing) -> Self {
        Framer {
            framing,
            window: ByteWindow::new(BUFFER),
            sums: RunningCrc::new(),
            before: 0,
            frame_end: 0,
            expected: Some(framing.prefix()),
            pending: None,
            accounted: 0,
            tally: FrameTally::default(),
        }
    }

    /// Takes in what there is room for and says how many bytes that was; at least one where [`Framer::next_packet`] has
    /// just given `None`.
    pub fn take(&mut self, bytes: &[u8]) -> usize {
        self.window.take(bytes)
    }

    /// The next frame in what was taken in; `None` where more bytes are needed.
    pub fn next_packet(&mut self) -> Option<Packet> {
        self.search(false)
    }

    /// The next frame where no more bytes will come; `None` after the last.
    pub fn last_packet(&mut self) -> Option<Packet> {
        let packet = self.search(true);
        if packet.is_none() && self.window.position() > self.frame_end {
            match self.pending.take() {
                Some(pending) if pending.from + pending.length == self.window.position() => self.confirm(pending),
                _ => self.lose_step(),
            }
        }
        packet
    }

    /// The next frame of a datagram, all of which was taken in: no frame goes on in another. `None` after the last.
    pub fn last_packet_of_datagram(&mut self) -> Option<Packet> {
        let packet = self.last_packet();
        if packet.is_none() {
            self.frame_end = self.window.position();
            self.expected = Some(self.frame_end + self.framing.prefix());
        }
        packet
    }

    /// What was found so far; bytes that still wait for a decision do not count yet.
    pub fn tally(&self) -> FrameTally {
        let undecided = if self.expected.is_some() { self.window.position() - self.frame_end } else { 0 };
        FrameTally { garbage_bytes: self.window.position().saturating_sub(self.accounted + undecided), ..self.tally }
    }

    fn search(&mut self, ended: bool) -> Option<Packet> {
        loop {
            let window = self.window.bytes();
            let first = *window.first()?;
            let in_step = self.expected == Some(self.window.position());
            if first != MARKER_1 && first != MARKER_2 {
                if in_step {
                    self.lose_step();
                }
                self.skip(first);
                continue;
            }
            match judge(window, self.window.position(), &mut self.sums) {
                FrameCandidate::Incomplete if !ended => return None,
                FrameCandidate::Incomplete => {
                    if in_step {
                        self.confirm_pending();
                        self.lose_step();
                    }
                    self.skip(first);
                }
                FrameCandidate::Unverified { known, length } => {
                    if in_step {
                        self.confirm_pending();
                        let length = length as u64;
                        self.pending = Some(Unverified { known, from: self.window.position(), length });
                        self.expected = Some(self.window.position() + length + self.framing.prefix());
                    }
                    self.skip(first);
                }
                FrameCandidate::Good { length, header } => {
                    if in_step {
                        self.confirm_pending();
                    } else {
                        self.lose_step();
                    }
                    return self.accept(length, header);
                }
            }
        }
    }

    fn skip(&mut self, byte: u8) {
        self.before = self.before << 8 | u64::from(byte);
        self.window.advance(1);
    }

    /// What was taken for frames was none: the bytes since the last one are garbage.
    fn lose_step(&mut self) {
        let damaged = self.pending.take().is_some() || self.expected.is_some();
        if damaged {
            self.tally.first_damage_at.get_or_insert(self.frame_end);
        }
        self.expected = None;
    }

    fn confirm_pending(&mut self) {
        if let Some(pending) = self.pending.take() {
            self.confirm(pending);
        }
    }

    fn confirm(&mut self, pending: Unverified) {
        if pending.known {
            self.tally.bad_checksum += 1;
            self.tally.first_damage_at.get_or_insert(pending.from);
        } else {
            self.tally.unknown += 1;
        }
        self.accounted += pending.length + self.framing.prefix().min(pending.from);
        self.frame_end = pending.from + pending.length;
    }

    fn accept(&mut self, length: usize, header: usize) -> Option<Packet> {
        let frame = self.window.bytes().get(..length)?;
        let packet = packet(frame, header)?;
        let at = self.window.position();
        let gap = at - self.frame_end;
        let stamped = self.framing == Framing::Stamped && gap >= 8;
        let stamp_us = (stamped && self.before >> STAMP_BITS == 0).then_some(self.before);
        self.accounted += length as u64 + if stamped { 8 } else { 0 };
        self.window.advance(length);
        self.frame_end = self.window.position();
        self.expected = Some(self.window.position() + self.framing.prefix());
        self.tally.good += 1;
        Some(Packet { at, end: self.frame_end, stamp_us, ..packet })
    }
}

/// What stands at the start of the bytes, the first of which is a marker.
fn judge(bytes: &[u8], position: u64, sums: &mut RunningCrc) -> FrameCandidate {
    let (header, signature, flags) = match bytes {
        [MARKER_1, ..] => (6, 0, 0),
        [MARKER_2, _, flags, ..] => (HEADER_2, if flags & FLAG_SIGNED != 0 { SIGNATURE } else { 0 }, *flags),
        _ => return FrameCandidate::Incomplete,
    };
    let Some(&payload) = bytes.get(1) else { return FrameCandidate::Incomplete };
    let end = header + usize::from(payload);
    let length = end + 2 + signature;
    let Some(frame) = bytes.get(..length) else { return FrameCandidate::Incomplete };
    if flags & !FLAG_SIGNED != 0 {
        return FrameCandidate::Unverified { known: true, length };
    }
    let (Some(id), Some(&[low, high])) = (id_of(frame), frame.get(end..end + 2)) else {
        return FrameCandidate::Incomplete;
    };
    let extra = MavMessage::extra_crc(id);
    if extra == 0 && MavMessage::default_message_from_id(id).is_none() {
        return FrameCandidate::Unverified { known: false, length };
    }
    if sums.of(position, bytes, (1, end), extra) == Some(u16::from_le_bytes([low, high])) {
        FrameCandidate::Good { length, header }
    } else {
        FrameCandidate::Unverified { known: true, length }
    }
}

fn id_of(frame: &[u8]) -> Option<u32> {
    match frame {
        [MARKER_1, _, _, _, _, id, ..] => Some(u32::from(*id)),
        [MARKER_2, _, _, _, _, _, _, low, middle, high, ..] => Some(u32::from_le_bytes([*low, *middle, *high, 0])),
        _ => None,
    }
}

fn packet(frame: &[u8], header: usize) -> Option<Packet> {
    let id = id_of(frame)?;
    let (version, sequence, system, component) = match frame {
        [MARKER_1, _, sequence, system, component, ..] => (1, *sequence, *system, *component),
        [_, _, _, _, sequence, system, component, ..] => (2, *sequence, *system, *component),
        _ => return None,
    };
    let length = *frame.get(1)?;
    let mut payload = [0; PAYLOAD_MAX];
    let sent = frame.get(header..header + usize::from(length))?;
    payload.get_mut(..sent.len())?.copy_from_slice(sent);
    let behind = frame.get(header + sent.len()..)?;
    let checksum = *behind.first_chunk()?;
    let signature = behind.get(2..).and_then(<[u8]>::first_chunk).map(FrameSignature::from_bytes);
    let compatibility = if version == 2 { *frame.get(3)? } else { 0 };
    Some(Packet {
        version,
        system,
        component,
        sequence,
        id,
        at: 0,
        end: 0,
        stamp_us: None,
        signature,
        compatibility,
        checksum,
        length,
        payload,
    })
}

/// The name of a message of the dialect.
pub fn name_of(id: u32) -> Option<&'static str> {
    MavMessage::default_message_from_id(id).map(|message| message.message_name())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A heartbeat of version 1, its checksum computed bit by bit after the definition (X.25 with the seed byte 50).
    fn heartbeat(sequence: u8) -> Vec<u8> {
        let mut frame = vec![0xFE, 9, sequence, 1, 1, 0, 0, 0, 0, 0, 4, 3, 0, 0, 3];
        let mut crc = 0xFFFF_u16;
        for byte in frame.iter().skip(1).chain(&[50]) {
            crc ^= u16::from(*byte);
            for _ in 0..8 {
                crc = if crc & 1 == 1 { crc >> 1 ^ 0x8408 } else { crc >> 1 };
            }
        }
        frame.extend(crc.to_le_bytes());
        frame
    }

    fn found(framing: Framing, bytes: &[u8]) -> (Vec<u8>, FrameTally) {
        let mut framer = Framer::new(framing);
        let mut sequences = Vec::new();
        for chunk in bytes.chunks(7) {
            assert_eq!(framer.take(chunk), chunk.len());
            sequences.extend(std::iter::from_fn(|| framer.next_packet()).map(|packet| packet.sequence));
        }
        sequences.extend(std::iter::from_fn(|| framer.last_packet()).map(|packet| packet.sequence));
        (sequences, framer.tally())
    }

    #[test]
    fn frames_are_found_between_garbage_and_everything_is_counted() {
        let mut bad = heartbeat(2);
        bad[8] ^= 1;
        let mut unknown = heartbeat(3);
        unknown[5] = 199;
        let bytes = [heartbeat(1), bad, heartbeat(4), unknown, heartbeat(5), vec![0xFE, 200, 1, 0xFD], heartbeat(6)].concat();
        let tally = FrameTally { good: 4, bad_checksum: 1, unknown: 1, garbage_bytes: 4, first_damage_at: Some(17) };
        assert_eq!(found(Framing::Bare, &bytes), (vec![1, 4, 5, 6], tally));
        // A bad frame at the very end, and a frame that is cut short.
        let mut bad = heartbeat(9);
        bad[3] ^= 1;
        let (_, tally) = found(Framing::Bare, &[heartbeat(1), bad].concat());
        assert_eq!((tally.good, tally.bad_checksum, tally.garbage_bytes), (1, 1, 0));
        let (_, tally) = found(Framing::Bare, &[heartbeat(1), heartbeat(2)[..10].to_vec()].concat());
        assert_eq!((tally.good, tally.bad_checksum, tally.garbage_bytes), (1, 0, 10));
    }

    #[test]
    fn stamps_are_those_before_each_frame() {
        let stamp = 1_500_000_000_000_000_u64;
        let record = |frame: Vec<u8>, us: u64| [(stamp + us).to_be_bytes().to_vec(), frame].concat();
        let mut bad = heartbeat(2);
        bad[8] ^= 1;
        let bytes = [
            record(heartbeat(1), 0),
            record(bad, 1),
            record(heartbeat(3), 2),
            vec![1, 2, 3],
            record(heartbeat(4), 3),
            heartbeat(5),
        ];
        let mut framer = Framer::new(Framing::Stamped);
        framer.take(&bytes.concat());
        let packets: Vec<Packet> = std::iter::from_fn(|| framer.last_packet()).collect();
        let stamps: Vec<_> = packets.iter().map(|packet| packet.stamp_us.map(|us| us - stamp)).collect();
        assert_eq!(stamps, [Some(0), Some(2), Some(3), None]);
        let tally = framer.tally();
        assert_eq!((tally.good, tally.bad_checksum, tally.garbage_bytes), (4, 1, 3));
    }
}
