//! The thread over the loopback: what arrives, what a link that is away costs, and that the estimator never waits.

use super::super::message::COMPONENT;
use super::super::names::SILENT;
use super::*;
use crate::flight::derivative::Axis;
use crate::io::outputs::record::{EventKind, Message};
use crate::io::telemetry::mavlink::packet::{Framer, Framing, Packet};
use crate::io::telemetry::mavlink::signing_key::SigningKey;
use crate::io::telemetry::mavlink::signing_time::SigningTime;
use crate::realtime::estimation::record::EstimationEvent;
use crate::realtime::modes::record::{ModesRecord, OscillatoryMode};
use crate::realtime::regression::record::{DerivativesRecord, EquationRecord, Status};
use std::net::{TcpListener, UdpSocket};
use std::sync::{Arc, Mutex};

const PATIENCE: Duration = Duration::from_secs(20);

fn modes(time_s: f64) -> Message {
    let dutch_roll = OscillatoryMode { real: -0.1, imag: 1.5, omega: 1.503, zeta: 0.067, std_omega: 0.01, std_zeta: 0.02 };
    let pair = Some(dutch_roll);
    let (roll, spiral, lateral_phugoid, coupled) = (None, None, None, None);
    Message::Modes(ModesRecord { time_s, status: Status::Converged, dutch_roll: pair, roll, spiral, lateral_phugoid, coupled })
}

fn derivatives(time_s: f64) -> Message {
    let equations = Axis::ALL.map(|axis| EquationRecord::empty(axis, Status::Exciting));
    Message::Derivatives(DerivativesRecord { time_s, equations, lateral: None, excited: true })
}

fn start(url: Url, signing: Option<LinkSigning>) -> (GroundStation, Arc<Mutex<Vec<String>>>) {
    let said = Arc::new(Mutex::new(Vec::new()));
    let kept = Arc::clone(&said);
    let settings = StationSettings { url, system: None, signing };
    let station = GroundStation::start(settings, Box::new(move |line| kept.lock().unwrap().push(line.to_owned()))).unwrap();
    (station, said)
}

/// Everything that has arrived at a socket.
fn arrived(socket: &UdpSocket) -> Vec<Packet> {
    socket.set_read_timeout(Some(Duration::from_millis(50))).unwrap();
    let (mut framer, mut buffer, mut packets) = (Framer::new(Framing::Bare), [0; 2048], Vec::new());
    while let Ok(count) = socket.recv(&mut buffer) {
        framer.take(&buffer[..count]);
        packets.extend(std::iter::from_fn(|| framer.next_packet()));
    }
    packets
}

/// Values by name, in the order of arrival.
fn values<'a>(packets: &'a [Packet], name: &'a str) -> impl Iterator<Item = f32> + 'a {
    let named = move |packet: &&Packet| {
        packet.id == 251 && packet.payload()[8..18].split(|byte| *byte == 0).next() == Some(name.as_bytes())
    };
    packets.iter().filter(named).map(|packet| f32::from_le_bytes(*packet.payload()[4..].first_chunk().unwrap()))
}

#[test]
fn a_run_arrives_as_of_its_vehicle_and_its_numbers_are_taken_back_at_the_end() {
    let ground = UdpSocket::bind("127.0.0.1:0").unwrap();
    let key = || SigningKey::new([7; 32]).unwrap();
    let signing = || LinkSigning::new(key(), 1, SigningTime::unrecorded(Box::new(|| 1 << 40)));
    let (station, said) = start(Url::UdpOut(ground.local_addr().unwrap().to_string()), Some(signing()));
    let mut run = station.begin_run("flight 7", ControlNames::Rotorcraft, Some(42)).unwrap();
    run.send(&modes(12.5));
    run.send(&derivatives(12.5));
    run.send(&Message::Event(EventRecord { time_s: 12.5, kind: EventKind::Estimation(EstimationEvent::SegmentRestart) }));
    std::thread::sleep(Duration::from_millis(1500));
    drop(run);
    let report = station.finish(PATIENCE).unwrap();
    let packets = arrived(&ground);
    assert_eq!((packets.len() as u64, report.refused, report.lost), (report.sent, 0, 0));
    let mut theirs = signing();
    for packet in &packets {
        assert!(StationMessage::IDS.contains(&packet.id), "{packet:?}");
        assert_eq!((packet.component, theirs.accept(packet)), (COMPONENT, Ok(())), "{packet:?}");
    }
    let of_run: Vec<_> =
        packets.iter().filter(|packet| packet.id == 251 && packet.payload()[..4] == 12_500_u32.to_le_bytes()).collect();
    assert!(of_run.len() > 8 && of_run.iter().all(|packet| packet.system == 42), "{of_run:?}");
    let frequency: Vec<f32> = values(&packets, "DR_wn").collect();
    let (last, before) = frequency.split_last().unwrap();
    assert!(
        last.is_nan() && !before.is_empty() && before.iter().all(|value| value.to_bits() == 1.503_f32.to_bits()),
        "{frequency:?}"
    );
    assert_eq!(values(&packets, "DR_zeta_se").next(), Some(0.02));
    assert_eq!(values(&packets, "DR_status").last(), Some(SILENT));
    assert!(values(&packets, "N_status").any(|code| code.to_bits() == 2.0_f32.to_bits()));
    assert_eq!(values(&packets, "N_v").count(), 0);
    let texts: String = packets
        .iter()
        .filter(|packet| packet.id == 253)
        .map(|packet| String::from_utf8_lossy(&packet.payload()[1..51]).into_owned())
        .collect();
    assert!(
        texts.contains("Sideslip: run flight 7 begins") && texts.contains("Sideslip: time runs on from an earlier instant"),
        "{texts}"
    );
    assert!(said.lock().unwrap().iter().any(|line| line.contains("as 42/191")), "{said:?}");
}

#[test]
fn a_ground_station_that_calls_hears_what_waited_and_is_not_listened_to() {
    let port = UdpSocket::bind("127.0.0.1:0").unwrap().local_addr().unwrap().port();
    let (station, _) = start(Url::UdpIn(format!("127.0.0.1:{port}")), None);
    let mut run = station.begin_run("live", ControlNames::Rotorcraft, None).unwrap();
    run.send(&modes(1.0));
    let ground = UdpSocket::bind("127.0.0.1:0").unwrap();
    ground.connect(("127.0.0.1", port)).unwrap();
    ground.set_read_timeout(Some(Duration::from_millis(100))).unwrap();
    let begun = Instant::now();
    // A command to it, which it neither takes nor answers.
    let command = crate::io::telemetry::mavlink::encode::Frames::new(crate::io::telemetry::mavlink::encode::ME)
        .frame(&mavlink::dialects::ardupilotmega::MavMessage::COMMAND_LONG(Default::default()))
        .to_vec();
    let mut packets = Vec::new();
    while values(&packets, "DR_wn").count() == 0 {
        assert!(begun.elapsed() < PATIENCE);
        let _ = ground.send(&command);
        run.send(&modes(1.0));
        packets.extend(arrived(&ground));
        // Until the port is open nothing is waited for there, and the queue is not what is tried here.
        std::thread::sleep(Duration::from_millis(50));
    }
    assert!(packets.iter().all(|packet| StationMessage::IDS.contains(&packet.id) && packet.system == 1));
    assert!(packets.iter().any(|packet| packet.id == 253), "the text of the run's beginning has waited");
    drop(run);
    assert_eq!(station.finish(PATIENCE).unwrap().lost, 0);
}

#[test]
fn a_link_that_is_away_is_said_once_and_tried_again_and_nobody_waits_for_it() {
    let server = TcpListener::bind("127.0.0.1:0").unwrap();
    let address = server.local_addr().unwrap();
    drop(server);
    let (station, said) = start(Url::Tcp(address.to_string()), None);
    let mut run = station.begin_run("live", ControlNames::Rotorcraft, None).unwrap();
    std::thread::sleep(Duration::from_millis(2500));
    let refusals = said.lock().unwrap().iter().filter(|line| line.contains("refused")).count();
    assert_eq!(refusals, 1, "{said:?}");
    let server = TcpListener::bind(address).unwrap();
    let (connection, _) = server.accept().unwrap();
    // It reads nothing: what does not fit is dropped, and sending takes no time that shows.
    let begun = Instant::now();
    for k in 0..200_000 {
        run.send(&modes(f64::from(k)));
    }
    let took = begun.elapsed();
    assert!(took < Duration::from_secs(5), "{took:?}");
    drop(connection);
    let again = Instant::now();
    while !said.lock().unwrap().iter().any(|line| line.contains("is opened again")) {
        assert!(again.elapsed() < PATIENCE, "{said:?}");
        std::thread::sleep(Duration::from_millis(10));
    }
    let (_connection, _) = server.accept().unwrap();
    let lost = run.lost();
    drop(run);
    let report = station.finish(PATIENCE).unwrap();
    assert!(report.lost == lost && report.refused >= 2 && report.sent > 0, "{report:?} {lost}");
}
