//! Signing against frames that another implementation signed, and every reason for which a frame is refused.

use super::super::encode::Frames;
use super::super::packet::{Framer, Framing};
use super::super::senders::Sender;
use super::*;
use mavlink::dialects::ardupilotmega::{ATTITUDE_DATA, HEARTBEAT_DATA, RADIO_STATUS_DATA};

/// A heartbeat of 1/191, sequence 7, by pymavlink 2.4.50: unsigned; signed with the key 1, 2, ... 32 on link 3 at 0x0123456789AB;
/// and once more; and as MAVLink 1.
const PLAIN: &str = "fd0900000701bf000000000000001208000403ed74";
const SIGNED: &str = "fd0901000701bf0000000000000012080004030a8c03ab89674523011e371a40893e";
const SIGNED_NEXT: &str = "fd0901000701bf0000000000000012080004030a8c03ac8967452301ac6495759da9";
const VERSION_1: &str = "fe090701bf0000000000120800040382fc";

const THEN: u64 = 0x0123_4567_89AB;

fn bytes(text: &str) -> Vec<u8> {
    text.as_bytes().chunks(2).map(|pair| u8::from_str_radix(std::str::from_utf8(pair).unwrap(), 16).unwrap()).collect()
}

fn key() -> SigningKey {
    SigningKey::new(std::array::from_fn(|i| 1 + i as u8)).unwrap()
}

/// Signing with that key whose clock stands there.
fn signing(key: SigningKey, now: u64) -> LinkSigning {
    LinkSigning::new(key, 3, SigningTime::unrecorded(Box::new(move || now)))
}

fn packet(frame: &[u8]) -> Packet {
    let mut framer = Framer::new(Framing::Bare);
    framer.take(frame);
    framer.last_packet().unwrap()
}

/// A frame of that sender, signed on that link at that time.
fn at(sender: Sender, link_id: u8, timestamp: u64) -> Packet {
    let mut signing = LinkSigning::new(key(), link_id, SigningTime::unrecorded(Box::new(move || timestamp)));
    let frame = Frames::new(sender).frame(&MavMessage::ATTITUDE(ATTITUDE_DATA { roll: 0.5, ..Default::default() })).to_vec();
    packet(signing.sign(&frame).unwrap())
}

const ME: Sender = Sender { system: 1, component: 1 };

#[test]
fn frames_are_signed_byte_for_byte_as_another_implementation_does() {
    let mut ours = signing(key(), THEN);
    assert_eq!(ours.sign(&bytes(PLAIN)).unwrap(), bytes(SIGNED));
    assert_eq!(ours.sign(&bytes(PLAIN)).unwrap(), bytes(SIGNED_NEXT), "one step later");
    for unfit in [&bytes(VERSION_1)[..], &bytes(SIGNED), &bytes(PLAIN)[..12], &[]] {
        assert_eq!(ours.sign(unfit), None);
    }
}

#[test]
fn a_signed_frame_is_accepted_once_and_whatever_is_changed_in_it_is_not() {
    let frame = bytes(SIGNED);
    let mut ours = signing(key(), THEN);
    assert_eq!(ours.accept(&packet(&frame)), Ok(()));
    assert_eq!(ours.accept(&packet(&frame)), Err(SigningRefusal::NotLater), "replayed");
    assert_eq!(ours.accept(&packet(&bytes(SIGNED_NEXT))), Ok(()));
    assert_eq!(ours.accept(&packet(&frame)), Err(SigningRefusal::NotLater), "out of order");
    // Link id, timestamp and signature are covered by no checksum.
    for place in frame.len() - 13..frame.len() {
        let mut changed = frame.clone();
        changed[place] ^= 0x10;
        assert_eq!(signing(key(), THEN).accept(&packet(&changed)), Err(SigningRefusal::WrongSignature), "byte {place}");
    }
    // A payload with a right checksum under the signature of another.
    let mut ours = signing(key(), THEN);
    let other =
        Frames::new(Sender { system: 1, component: 191 }).frame(&MavMessage::HEARTBEAT(HEARTBEAT_DATA::default())).to_vec();
    let mut forged = ours.sign(&other).unwrap().to_vec();
    let place = forged.len() - 13;
    forged.truncate(place);
    forged.extend(&frame[frame.len() - 13..]);
    assert_eq!(signing(key(), THEN).accept(&packet(&forged)), Err(SigningRefusal::WrongSignature));
    let wrong = SigningKey::new([9; 32]).unwrap();
    assert_eq!(signing(wrong, THEN).accept(&packet(&frame)), Err(SigningRefusal::WrongSignature));
}

#[test]
fn what_is_not_signed_is_refused_and_counted_by_reason() {
    let mut ours = signing(key(), THEN);
    assert_eq!(ours.accept(&packet(&bytes(PLAIN))), Err(SigningRefusal::Unsigned));
    assert_eq!(ours.accept(&packet(&bytes(VERSION_1))), Err(SigningRefusal::Version1));
    let radio =
        Frames::new(Sender { system: 51, component: 68 }).frame(&MavMessage::RADIO_STATUS(RADIO_STATUS_DATA::default())).to_vec();
    assert_eq!(ours.accept(&packet(&radio)), Err(SigningRefusal::Radio));
    assert_eq!(ours.accept(&packet(&bytes(PLAIN))), Err(SigningRefusal::Unsigned));
    let counted: Vec<_> = ours.refused().iter().collect();
    assert_eq!(counted, [(SigningRefusal::Version1, 1), (SigningRefusal::Unsigned, 2), (SigningRefusal::Radio, 1)]);
    assert_eq!((ours.refused().total(), ours.refused().of(SigningRefusal::NotLater)), (4, 0));
    for (place, refusal) in SigningRefusal::ALL.into_iter().enumerate() {
        assert_eq!(refusal.index(), place);
    }
}

#[test]
fn each_stream_has_a_time_of_its_own_and_a_new_one_begins_at_most_a_minute_behind() {
    let mut ours = signing(key(), THEN);
    assert_eq!(ours.accept(&at(ME, 0, THEN - BEHIND_MAX - 1)), Err(SigningRefusal::Behind));
    assert_eq!(ours.accept(&at(ME, 0, THEN - BEHIND_MAX)), Ok(()));
    // The same sender on another link, another component, another system: each later than itself.
    for (sender, link) in [(ME, 1), (Sender { component: 2, ..ME }, 0), (Sender { system: 2, ..ME }, 0)] {
        assert_eq!(ours.accept(&at(sender, link, THEN - 1000)), Ok(()));
        assert_eq!(ours.accept(&at(sender, link, THEN - 1000)), Err(SigningRefusal::NotLater));
        assert_eq!(ours.accept(&at(sender, link, THEN - 999)), Ok(()));
    }
    // A known stream goes on however far behind; one ahead takes the time of this end along.
    assert_eq!(ours.accept(&at(ME, 0, THEN - BEHIND_MAX + 1)), Ok(()));
    assert_eq!(ours.accept(&at(ME, 9, THEN + 5000)), Ok(()));
    assert_eq!(ours.accept(&at(ME, 7, THEN + 4999 - BEHIND_MAX)), Err(SigningRefusal::Behind));
    let signed = packet(ours.sign(&bytes(PLAIN)).unwrap());
    assert_eq!(signed.signature.map(|signature| signature.timestamp), Some(THEN + 5001));
}

#[test]
fn the_number_of_streams_is_bounded_and_only_rightly_signed_frames_begin_one() {
    let mut ours = signing(key(), THEN);
    let wrong = signing(SigningKey::new([9; 32]).unwrap(), THEN).sign(&bytes(PLAIN)).unwrap().to_vec();
    for _ in 0..1000 {
        assert_eq!(ours.accept(&packet(&wrong)), Err(SigningRefusal::WrongSignature));
    }
    for k in 0..STREAMS_MAX {
        let sender = Sender { system: (k / 200) as u8, component: (k % 200) as u8 };
        assert_eq!(ours.accept(&at(sender, 0, THEN)), Ok(()));
    }
    assert_eq!(ours.accept(&at(ME, 200, THEN)), Err(SigningRefusal::TooManyStreams));
    assert_eq!(ours.accept(&at(ME, 0, THEN + 1)), Ok(()), "those that are known go on");
}
