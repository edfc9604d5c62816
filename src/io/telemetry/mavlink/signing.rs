//! MAVLink 2 message signing of one link: outgoing frames signed, incoming frames verified.
//!
//! A signature is the first 48 bits of SHA-256 over key, frame to the end of its checksum, link id and timestamp
//! (mavlink.io, "Message Signing"). [`LinkSigning::sign`] consumes an unsigned frame of MAVLink 2 and produces the signed one;
//! [`LinkSigning::accept`] consumes a packet with a right checksum and accepts it or says why not.
//!
//! Refused and counted by reason ([`SigningRefusal`]): frames of MAVLink 1, unsigned frames, wrong signatures, and of rightly
//! signed ones those whose timestamp is not later than the one before of the same stream (system, component, link id), or on a
//! new stream more than a minute behind the time of this end. The signature is verified first: nothing that was not signed with
//! the key changes what is known of a stream.

use super::packet::{FLAG_SIGNED, HEADER_2, MARKER_2, Packet};
use super::signing_key::SigningKey;
use super::signing_time::SigningTime;
use mavlink::Message as _;
use mavlink::dialects::ardupilotmega::MavMessage;
use sha2::{Digest as _, Sha256};
use std::collections::BTreeMap;

/// How far behind a new stream may begin: a minute, in steps of 10 us.
const BEHIND_MAX: u64 = 6_000_000;
/// Streams that are kept apart; a new one beyond them is refused.
const STREAMS_MAX: usize = 256;
/// Status of a telemetry radio, which the radio itself puts into the stream; radios hold no key.
const RADIO_STATUS: u32 = 109;

/// Why a frame is not accepted where a key is set.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SigningRefusal {
    /// MAVLink 1, which has no signatures.
    Version1,
    /// No signature.
    Unsigned,
    /// No signature, and by its kind of the radio on the way, whose messages carry no flight data.
    Radio,
    /// Not signed with this key, or changed on the way.
    WrongSignature,
    /// Rightly signed, but not later than one of the same stream before it.
    NotLater,
    /// Rightly signed and the first of its stream, but more than a minute behind.
    Behind,
    /// Rightly signed and the first of its stream, of which there are too many.
    TooManyStreams,
}

/// How many reasons there are.
pub const REFUSALS: usize = 7;

impl SigningRefusal {
    /// Every reason, in the order of the counts.
    pub const ALL: [SigningRefusal; REFUSALS] = [
        SigningRefusal::Version1,
        SigningRefusal::Unsigned,
        SigningRefusal::Radio,
        SigningRefusal::WrongSignature,
        SigningRefusal::NotLater,
        SigningRefusal::Behind,
        SigningRefusal::TooManyStreams,
    ];

    /// Its place in [`SigningRefusal::ALL`].
    pub const fn index(self) -> usize {
        self as usize
    }

    /// What such frames are, for people.
    pub const fn words(self) -> &'static str {
        match self {
            SigningRefusal::Version1 => "of MAVLink 1, which cannot be signed",
            SigningRefusal::Unsigned => "without a signature",
            SigningRefusal::Radio => "of the radio, which holds no key",
            SigningRefusal::WrongSignature => "with a wrong signature",
            SigningRefusal::NotLater => "replayed or out of order, by their timestamps",
            SigningRefusal::Behind => "more than a minute behind, by their timestamps",
            SigningRefusal::TooManyStreams => "of more streams than are kept",
        }
    }

    /// Whether such a frame could have carried data of the flight.
    pub const fn is_loss(self) -> bool {
        !matches!(self, SigningRefusal::Radio)
    }
}

/// Refused frames by reason, in the order of [`SigningRefusal::ALL`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct RefusedFrames([u64; REFUSALS]);

impl RefusedFrames {
    /// How many for that reason.
    pub fn of(&self, refusal: SigningRefusal) -> u64 {
        self.0.get(refusal.index()).copied().unwrap_or(0)
    }

    /// How many in all.
    pub fn total(&self) -> u64 {
        self.0.iter().sum()
    }

    /// The reasons for which any was refused, with how many.
    pub fn iter(&self) -> impl Iterator<Item = (SigningRefusal, u64)> {
        SigningRefusal::ALL.into_iter().zip(self.0).filter(|(_, count)| *count > 0)
    }

    fn count(&mut self, refusal: SigningRefusal) {
        if let Some(count) = self.0.get_mut(refusal.index()) {
            *count += 1;
        }
    }
}

/// A stream of frames whose timestamps increase.
type Stream = (u8, u8, u8);

/// Signing on one link.
#[derive(Debug)]
pub struct LinkSigning {
    key: SigningKey,
    link_id: u8,
    time: SigningTime,
    /// The newest timestamp of each stream.
    streams: BTreeMap<Stream, u64>,
    refused: RefusedFrames,
    frame: Vec<u8>,
}

impl LinkSigning {
    /// Signing with that key, under that number of a link.
    pub fn new(key: SigningKey, link_id: u8, time: SigningTime) -> Self {
        LinkSigning { key, link_id, time, streams: BTreeMap::new(), refused: RefusedFrames::default(), frame: Vec::new() }
    }

    /// The frame with a signature; `None` where it is no unsigned frame of MAVLink 2, or no timestamp is free that is on record.
    pub fn sign(&mut self, frame: &[u8]) -> Option<&[u8]> {
        let [MARKER_2, length, 0, _, _, _, _, low, middle, high, ..] = *frame else { return None };
        let end = HEADER_2 + usize::from(length);
        let extra = MavMessage::extra_crc(u32::from_le_bytes([low, middle, high, 0]));
        let timestamp = self.time.next_timestamp()?;
        self.frame.clear();
        self.frame.extend_from_slice(frame.get(..end)?);
        *self.frame.get_mut(2)? = FLAG_SIGNED;
        let checksum = mavlink::calculate_crc(self.frame.get(1..)?, extra);
        self.frame.extend_from_slice(&checksum.to_le_bytes());
        self.frame.push(self.link_id);
        self.frame.extend_from_slice(timestamp.to_le_bytes().first_chunk::<6>()?);
        let digest = Sha256::new().chain_update(self.key.bytes()).chain_update(&self.frame).finalize();
        self.frame.extend_from_slice(digest.get(..6)?);
        Some(&self.frame)
    }

    /// Accepts a packet, or counts it under the reason why not.
    ///
    /// # Errors
    /// The reason.
    pub fn accept(&mut self, packet: &Packet) -> Result<(), SigningRefusal> {
        let accepted = self.verify(packet);
        if let Err(refusal) = accepted {
            self.refused.count(refusal);
        }
        accepted
    }

    /// What was refused so far.
    pub fn refused(&self) -> RefusedFrames {
        self.refused
    }

    /// Why timestamps can no longer be kept, once where that is so.
    pub fn take_fault(&mut self) -> Option<String> {
        self.time.take_fault()
    }

    /// By how many seconds the key's timestamps lead the clock, once where that is more than a minute.
    pub fn take_lead_s(&mut self) -> Option<f64> {
        self.time.take_lead_s()
    }

    fn verify(&mut self, packet: &Packet) -> Result<(), SigningRefusal> {
        let Some(signature) = packet.signature else {
            return Err(match (packet.id, packet.version) {
                (RADIO_STATUS, _) => SigningRefusal::Radio,
                (_, 1) => SigningRefusal::Version1,
                _ => SigningRefusal::Unsigned,
            });
        };
        let mut hash = Sha256::new().chain_update(self.key.bytes());
        packet.sent_bytes(|bytes| hash.update(bytes));
        hash.update([signature.link_id]);
        hash.update(signature.timestamp.to_le_bytes().first_chunk::<6>().map_or(&[][..], |bytes| bytes));
        let digest = hash.finalize();
        // Every byte is looked at, however early one differs: the time tells nothing of the right one.
        let differ = digest.iter().zip(signature.value).fold(0, |differ, (right, found)| differ | (right ^ found));
        if differ != 0 {
            return Err(SigningRefusal::WrongSignature);
        }
        let stream = (packet.system, packet.component, signature.link_id);
        match self.streams.get(&stream) {
            Some(newest) if signature.timestamp <= *newest => return Err(SigningRefusal::NotLater),
            Some(_) => {}
            None if signature.timestamp.saturating_add(BEHIND_MAX) < self.time.now() => return Err(SigningRefusal::Behind),
            None if self.streams.len() >= STREAMS_MAX => return Err(SigningRefusal::TooManyStreams),
            None => {}
        }
        self.streams.insert(stream, signature.timestamp);
        self.time.adopt(signature.timestamp);
        Ok(())
    }
}

#[cfg(test)]
#[path = "signing_tests.rs"]
mod tests;
