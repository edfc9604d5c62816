//! Live telemetry over the loopback.

use super::encode::{Encoder, Frames, ME};
use super::link::{Link, LinkEvent, Url};
use super::live::{COMPONENT, LiveNotice, LiveTelemetry};
use super::mapping::MavlinkConfig;
use super::packet::{Framer, Framing};
use super::senders::Sender;
use super::signing::{LinkSigning, SigningRefusal};
use super::signing_key::SigningKey;
use super::signing_time::SigningTime;
use crate::flight::channel::{Channel, ControlNames};
use crate::flight::sample::Sample;
use mavlink::dialects::ardupilotmega as dialect;
use mavlink::dialects::ardupilotmega::MavMessage;
use std::time::Duration;

#[test]
fn a_sender_on_the_loopback_is_heard_and_hears_our_heartbeat() {
    let patience = Duration::from_millis(20);
    let mut live = LiveTelemetry::open(Url::UdpIn("127.0.0.1:0".into()), MavlinkConfig::default(), patience).unwrap();
    let address = live.link().local_address().unwrap().to_string();
    assert!(!live.heartbeat().unwrap());
    let mut sender = Link::open(Url::UdpOut(address), patience).unwrap();
    let mut encoder = Encoder::new(ME, MavlinkConfig::default(), ControlNames::Rotorcraft);
    let mut heard = Vec::new();
    for i in 0..50 {
        let mut sample = Sample::new(10.0 + 0.02 * f64::from(i));
        sample.set(Channel::R, 0.125 * f64::from(i));
        sample.set(Channel::Pedal, 0.0);
        encoder.sample(&sample, |frame| assert!(sender.send(frame).unwrap())).unwrap();
        while heard.len() < usize::try_from(i).unwrap() && live.poll(|| Some(1)).unwrap() != LinkEvent::Silence {
            heard.extend(std::iter::from_fn(|| live.next_sample()).map(|timed| timed.sample));
        }
    }
    while live.poll(|| None).unwrap() != LinkEvent::Silence {}
    heard.extend(std::iter::from_fn(|| live.next_sample()).map(|timed| timed.sample));
    assert_eq!(heard.len(), 50);
    assert_eq!(heard.last().and_then(|last| last.get(Channel::R)), Some(0.125 * 49.0));
    assert!(live.heartbeat().unwrap());
    let mut buffer = [0; 64];
    assert_eq!(sender.receive(&mut buffer).unwrap(), LinkEvent::Bytes(21));
    assert_eq!((buffer[5], buffer[6]), (1, COMPONENT));
    assert_eq!(live.stream().vehicle(), Some(ME));
}

/// One frame of motion of that sender at that boot time.
fn motion(frames: &mut Frames, time_boot_ms: u32) -> Vec<u8> {
    frames.frame(&MavMessage::ATTITUDE(dialect::ATTITUDE_DATA { time_boot_ms, ..Default::default() })).to_vec()
}

#[test]
fn a_stray_holds_no_place_and_a_vehicle_that_falls_silent_gives_way() {
    let patience = Duration::from_millis(20);
    let mut live = LiveTelemetry::open(Url::UdpIn("127.0.0.1:0".into()), MavlinkConfig::default(), patience).unwrap();
    let address = live.link().local_address().unwrap().to_string();
    let mut link = Link::open(Url::UdpOut(address), patience).unwrap();
    let [one, two] = [1, 2].map(|system| Sender { system, component: 1 });
    let (mut first, mut second) = (Frames::new(one), Frames::new(two));
    let stray = motion(&mut Frames::new(Sender { system: 9, component: 9 }), 5);
    link.send(&stray).unwrap();
    let mut found = Vec::new();
    for k in 0..800_u32 {
        if k < 200 {
            link.send(&motion(&mut first, 1000 + 20 * k)).unwrap();
        }
        if k >= 100 {
            link.send(&motion(&mut second, 500_000 + 20 * k)).unwrap();
        }
        for _ in 0..=u32::from((100..200).contains(&k)) + u32::from(k == 0) {
            let _ = live.poll(|| Some(u64::from(k) * 20_000)).unwrap();
        }
        found.extend(std::iter::from_fn(|| live.next_sample()));
    }
    let boot = |boot| found.iter().filter(|timed| timed.boot == boot).count();
    assert_eq!(boot(0), 200, "none of the first is lost");
    assert!((330..=360).contains(&boot(1)), "{}", boot(1));
    assert_eq!(live.next_notice(), Some(LiveNotice::AnotherVehicle { vehicle: one, other: two }));
    assert_eq!(live.next_notice(), Some(LiveNotice::Changed { from: one, to: two }));
    assert_eq!((live.next_notice(), live.stream().vehicle()), (None, Some(two)));
}
#[test]
fn where_a_key_is_set_only_what_is_signed_with_it_is_taken_and_our_heartbeat_is_signed() {
    let patience = Duration::from_millis(20);
    let mut live = LiveTelemetry::open(Url::UdpIn("127.0.0.1:0".into()), MavlinkConfig::default(), patience).unwrap();
    let key = || SigningKey::new([5; 32]).unwrap();
    let signing = |link_id| LinkSigning::new(key(), link_id, SigningTime::unrecorded(Box::new(|| 1 << 40)));
    live.set_signing(signing(0));
    let address = live.link().local_address().unwrap().to_string();
    let mut link = Link::open(Url::UdpOut(address), patience).unwrap();
    let (mut theirs, mut frames) = (signing(1), Frames::new(ME));
    let mut replayed = Vec::new();
    for k in 0..50 {
        let frame = motion(&mut frames, 1000 + 20 * k);
        // One in ten unsigned, one in ten twice.
        replayed.clear();
        if k % 10 == 3 {
            replayed.extend(&frame);
        } else {
            replayed.extend(theirs.sign(&frame).unwrap());
        }
        for _ in 0..=u32::from(k % 10 == 7) {
            assert!(link.send(&replayed).unwrap());
            live.poll(|| Some(1)).unwrap();
        }
    }
    while live.poll(|| None).unwrap() != LinkEvent::Silence {}
    assert_eq!(std::iter::from_fn(|| live.next_sample()).count(), 45);
    let refused: Vec<_> = live.refused().iter().collect();
    assert_eq!(refused, [(SigningRefusal::Unsigned, 5), (SigningRefusal::NotLater, 5)]);
    assert_eq!((live.accepted(), live.tally().good, live.senders().total()), (45, 55, 45));
    let notices: Vec<_> = std::iter::from_fn(|| live.next_notice()).take(2).collect();
    let once = [LiveNotice::Refused(SigningRefusal::Unsigned), LiveNotice::Refused(SigningRefusal::NotLater)];
    assert_eq!(notices, once);
    assert!(live.heartbeat().unwrap());
    let mut buffer = [0; 64];
    assert_eq!(link.receive(&mut buffer).unwrap(), LinkEvent::Bytes(34), "21 and 13 of the signature");
    let mut framer = Framer::new(Framing::Bare);
    framer.take(&buffer[..34]);
    assert_eq!(theirs.accept(&framer.next_packet().unwrap()), Ok(()));
}

#[test]
fn half_a_frame_of_a_stranger_does_not_swallow_what_the_vehicle_sends_next() {
    let patience = Duration::from_millis(20);
    let mut live = LiveTelemetry::open(Url::UdpIn("127.0.0.1:0".into()), MavlinkConfig::default(), patience).unwrap();
    let address = live.link().local_address().unwrap().to_string();
    let [mut link, mut stranger] = [(); 2].map(|()| Link::open(Url::UdpOut(address.clone()), patience).unwrap());
    let mut frames = Frames::new(ME);
    // A frame that says that it has 255 bytes, the start of one without its length, and one of the vehicle's own, cut.
    let cut = motion(&mut Frames::new(ME), 1);
    let halves: [&[u8]; 3] = [&[0xFD, 255, 0, 0, 1, 1, 1], &[0xFE], &cut[..cut.len() - 1]];
    for k in 0..60_u32 {
        stranger.send(halves[k as usize % 3]).unwrap();
        link.send(&motion(&mut frames, 1000 + 20 * k)).unwrap();
        assert_eq!(live.poll(|| Some(u64::from(k) * 20_000)).unwrap(), LinkEvent::Bytes(halves[k as usize % 3].len()));
        live.poll(|| Some(u64::from(k) * 20_000)).unwrap();
        assert_eq!(live.accepted(), u64::from(k) + 1, "at once");
    }
    let of_strangers: usize = halves.iter().map(|half| 20 * half.len()).sum();
    let tally = live.tally();
    assert_eq!((tally.good, tally.bad_checksum, tally.garbage_bytes), (60, 0, of_strangers as u64));
}

#[test]
fn a_clock_that_steps_back_is_named_and_its_time_goes_on_in_the_same_run() {
    let patience = Duration::from_millis(20);
    let mut live = LiveTelemetry::open(Url::UdpIn("127.0.0.1:0".into()), MavlinkConfig::default(), patience).unwrap();
    let address = live.link().local_address().unwrap().to_string();
    let mut link = Link::open(Url::UdpOut(address), patience).unwrap();
    let mut frames = Frames::new(ME);
    let mut found = Vec::new();
    for k in 0..1000_u32 {
        let back_ms = if k >= 500 { 1000 } else { 0 };
        link.send(&motion(&mut frames, 100_000 + 20 * k - back_ms)).unwrap();
        live.poll(|| Some(u64::from(k) * 20_000)).unwrap();
        found.extend(std::iter::from_fn(|| live.next_sample()));
    }
    while live.poll(|| None).unwrap() != LinkEvent::Silence {}
    found.extend(std::iter::from_fn(|| live.next_sample()));
    let Some(LiveNotice::SteppedBack { by_s, at_s }) = live.next_notice() else { panic!("{:?}", live.next_notice()) };
    assert!((by_s - 1.0).abs() < 1e-6 && (at_s - 109.98).abs() < 1e-6, "{by_s} {at_s}");
    assert_eq!(live.next_notice(), None);
    assert!(found.iter().all(|timed| timed.boot == 0));
    assert!(found.windows(2).all(|pair| pair[1].sample.time_s > pair[0].sample.time_s));
    // What came until it was sure has no place, and everything after it stands where this machine's clock puts it.
    assert_eq!(found.len() as u64 + live.unused().late, 1000);
    assert!((20..=40).contains(&live.unused().late), "{}", live.unused().late);
    let last_s = found.last().unwrap().sample.time_s;
    assert!((last_s - (100.0 + 0.02 * 999.0)).abs() < 1e-3, "{last_s}");
}
