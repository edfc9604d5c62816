//! Services and roots: who misses what, who is refused, what is stale; within one process, on real shared memory.

use super::stage::{left_behind, stage};
use iceoryx2::prelude::ZeroCopySend;
use sideslip::flight::derivative::Axis;
use sideslip::flight::file::log_head::LogHead;
use sideslip::flight::sample::Sample;
use sideslip::io::bus::payload::{DerivativesPayload, MessageHeader, ModesPayload, Payload, SAMPLE, SamplePayload, StatePayload};
use sideslip::io::bus::reader::{Reader, VALID_FOR};
use sideslip::io::bus::root::BusRole;
use sideslip::io::bus::run_head::{newest_head, read_head, write_head};
use sideslip::io::bus::service::Bus;
use sideslip::realtime::modes::record::ModesRecord;
use sideslip::realtime::regression::record::{DerivativesRecord, EquationRecord, Status};

fn sample(k: u32) -> SamplePayload {
    SamplePayload::new(&Sample::new(f64::from(k)), std::iter::empty(), SAMPLE)
}

#[test]
fn a_slow_reader_misses_the_oldest_and_knows_how_many() {
    let _turn = crate::alone();
    let root = stage("slow").join("root");
    let bus = Bus::enter(&root).unwrap();
    let (mut slow, mut quick) = (bus.subscriber::<StatePayload>().unwrap(), bus.subscriber::<StatePayload>().unwrap());
    let mut publisher = bus.publisher::<StatePayload>().unwrap();
    let count = 1000_u64;
    for k in 0..count {
        let header = publisher.publish(&StatePayload { fused: k, ..StatePayload::default() }, Some(7)).unwrap();
        assert_eq!((header.sequence, header.sampled_ns), (k, 7));
        assert_eq!(quick.receive().unwrap().unwrap().fused, k);
    }
    let kept: Vec<u64> = std::iter::from_fn(|| slow.receive().unwrap().map(|state| state.fused)).collect();
    let buffer = StatePayload::BUFFER as u64;
    assert_eq!(kept, (count - buffer..count).collect::<Vec<_>>(), "the newest, in order");
    // The first that it ever saw is where it begins to count.
    assert_eq!((slow.missed(), quick.missed()), (0, 0));
    for _ in 0..buffer + 3 {
        publisher.publish(&StatePayload::default(), None).unwrap();
    }
    assert!(slow.receive().unwrap().is_some());
    assert_eq!(slow.missed(), 3);
}

#[test]
fn who_comes_late_gets_the_last_samples() {
    let _turn = crate::alone();
    let root = stage("late").join("root");
    let (telemetry, estimator) = (Bus::enter(&root).unwrap(), Bus::enter(&root).unwrap());
    assert!(telemetry.root().swept() && !estimator.root().swept());
    let mut publisher = telemetry.publisher().unwrap();
    for k in 0..2000 {
        publisher.publish(&sample(k), None).unwrap();
    }
    let mut subscriber = estimator.subscriber::<SamplePayload>().unwrap();
    publisher.publish(&sample(2000), None).unwrap();
    let times: Vec<f64> = std::iter::from_fn(|| subscriber.receive().unwrap().map(|sample| sample.header.time_s)).collect();
    assert_eq!(times.len(), SamplePayload::HISTORY);
    assert_eq!(times.last(), Some(&2000.0));
    assert!(times.windows(2).all(|pair| (pair[1] - pair[0] - 1.0).abs() < 1e-9) && subscriber.missed() == 0);
}

#[test]
fn a_later_life_goes_on_and_nothing_of_an_earlier_one_is_taken_for_new() {
    let _turn = crate::alone();
    let root = stage("lives").join("root");
    let estimator = Bus::enter(&root).unwrap();
    let mut subscriber = estimator.subscriber::<SamplePayload>().unwrap();
    let first = Bus::enter(&root).unwrap();
    let mut old = first.publisher().unwrap();
    old.publish(&sample(0), None).unwrap();
    let second = Bus::enter(&root).unwrap();
    assert!(second.incarnation() > first.incarnation());
    let mut new = second.publisher().unwrap();
    new.publish(&sample(10), None).unwrap();
    let mut seen = Vec::new();
    while let Some(sample) = subscriber.receive().unwrap() {
        seen.push((sample.header.incarnation, sample.header.time_s));
    }
    assert_eq!(seen.last(), Some(&(second.incarnation(), 10.0)));
    old.publish(&sample(1), None).unwrap();
    new.publish(&sample(11), None).unwrap();
    let MessageHeader { incarnation, sequence, time_s, .. } = subscriber.receive().unwrap().unwrap().header;
    assert_eq!((incarnation, sequence, time_s), (second.incarnation(), 1, 11.0));
    assert!(subscriber.receive().unwrap().is_none() && subscriber.stale() >= 1);
}

#[test]
fn a_role_is_one_process_at_a_time() {
    let _turn = crate::alone();
    let root = stage("roles").join("root");
    let (mut one, mut other) = (Bus::enter(&root).unwrap(), Bus::enter(&root).unwrap());
    let held = one.take(BusRole::Telemetry).unwrap();
    other.take(BusRole::Estimator).unwrap();
    let said = other.take(BusRole::Telemetry).unwrap_err().to_string();
    assert!(said.contains(&format!("process {} has the role `telemetry` already", std::process::id())), "{said}");
    drop(held);
    other.take(BusRole::Telemetry).unwrap();
}

/// The state of another version of this program.
#[repr(C)]
#[derive(Clone, Copy, Debug, ZeroCopySend)]
#[type_name("sideslip.State.2")]
struct OtherState {
    header: MessageHeader,
}

impl Payload for OtherState {
    const SERVICE: &'static str = StatePayload::SERVICE;
    const SCHEMA: &'static str = "sideslip.State.2";
    const BUFFER: usize = 1;
    const HISTORY: usize = 0;
    fn header(&self) -> &MessageHeader {
        &self.header
    }
    fn header_mut(&mut self) -> &mut MessageHeader {
        &mut self.header
    }
}

#[test]
fn another_schema_under_the_same_name_is_refused_in_words() {
    let _turn = crate::alone();
    let root = stage("schema").join("root");
    let bus = Bus::enter(&root).unwrap();
    for said in [bus.publisher::<OtherState>().unwrap_err().to_string(), bus.subscriber::<OtherState>().unwrap_err().to_string()]
    {
        assert!(said.contains("service sideslip/state: expected the schema sideslip.State.2, found another"), "{said}");
    }
    bus.publisher::<StatePayload>().unwrap();
}

#[test]
fn a_root_is_private_and_left_clean() {
    let _turn = crate::alone();
    let stage = stage("root");
    // Long names and strange ones, and a user's own folders of any name.
    let root = stage.join("d\u{e9}ep".repeat(40)).join("root");
    let kept = ["runs/2026/flight.csv", "bus/stop.txt", "door"].map(|name| root.join(name));
    for file in &kept {
        std::fs::create_dir_all(file.parent().unwrap()).unwrap();
        std::fs::write(file, "the user's").unwrap();
    }
    let mode = |path: &std::path::Path, mode| {
        std::fs::set_permissions(path, std::os::unix::fs::PermissionsExt::from_mode(mode)).unwrap();
    };
    let bus = Bus::enter(&root).unwrap();
    let _publisher = bus.publisher::<StatePayload>().unwrap();
    assert!(!left_behind(&root).is_empty());
    drop((_publisher, bus));
    assert_eq!(left_behind(&root), [""; 0]);
    assert!(kept.iter().all(|file| file.exists()), "what is not ours stays");
    mode(&root, 0o777);
    let said = Bus::enter(&root).unwrap_err().to_string();
    assert!(said.contains("only this user can write, found mode 777"), "{said}");
    let file = stage.join("file");
    std::fs::write(&file, "").unwrap();
    assert!(Bus::enter(&file).unwrap_err().to_string().contains("expected a directory"));
    let private = stage.join("private");
    drop(Bus::enter_private(&private).unwrap());
    assert!(!private.exists());
}

#[test]
fn heads_are_found_by_their_telemetry_and_the_old_ones_go() {
    let _turn = crate::alone();
    let root = stage("heads").join("root");
    let bus = Bus::enter(&root).unwrap();
    let head = |k: u64| LogHead { run_toml: format!("run = \"{k}\"\n"), ..LogHead::default() };
    assert_eq!(newest_head(bus.root()).unwrap(), None);
    for k in 1..20 {
        write_head(bus.root(), k, &head(k)).unwrap();
    }
    assert_eq!(read_head(bus.root(), 19).unwrap(), Some(head(19)));
    assert_eq!(newest_head(bus.root()).unwrap(), Some(head(19)));
    assert_eq!(read_head(bus.root(), 3).unwrap(), None);
    assert_eq!(std::fs::read_dir(root.join(".sideslip/runs")).unwrap().count(), 8);
    std::fs::write(root.join(".sideslip/runs").join(format!("{:020}.json", 30)), "{}").unwrap();
    assert!(read_head(bus.root(), 30).unwrap_err().to_string().contains("expected the key"));
}

#[test]
fn the_newest_estimate_is_whole_and_grows_old() {
    let _turn = crate::alone();
    let root = stage("reader").join("root");
    let bus = Bus::enter(&root).unwrap();
    let mut reader = Reader::open(&root).unwrap();
    assert!(reader.latest().unwrap().is_none());
    let (mut derivatives, mut modes) = (bus.publisher::<DerivativesPayload>().unwrap(), bus.publisher::<ModesPayload>().unwrap());
    let status = Status::Converged;
    let mut publish = |k: u32, both: bool| {
        let time_s = f64::from(k);
        let equations = Axis::ALL.map(|axis| EquationRecord::empty(axis, status));
        let record = DerivativesRecord { time_s, equations, lateral: None, excited: true };
        derivatives.publish(&(&record).into(), None).unwrap();
        let record = ModesRecord::empty(time_s, status);
        if both {
            modes.publish(&(&record).into(), None).unwrap();
        }
    };
    (0..10).for_each(|k| publish(k, true));
    let estimate = reader.latest().unwrap().unwrap();
    assert_eq!((estimate.sequence, estimate.derivatives.time_s, estimate.modes.time_s), (9, 9.0, 9.0));
    assert!(estimate.is_valid() && estimate.status == status && estimate.age < VALID_FOR && estimate.missed == 0);
    publish(10, false);
    assert_eq!(reader.latest().unwrap().unwrap().sequence, 9, "never the derivatives of one and the modes of another");
    std::thread::sleep(VALID_FOR);
    assert!(!estimate.is_valid());
    let old = reader.latest().unwrap().unwrap();
    assert!(old.status == Status::Stale && old.age >= VALID_FOR && !old.is_valid());
}
