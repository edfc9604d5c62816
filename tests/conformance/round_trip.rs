//! What was logged comes back with the same bits.

use super::example::{bits, folder, head, read, rows, write};
use sideslip::io::outputs::log::log_thread::LogThread;
use sideslip::io::outputs::log::mcap_log::{LogError, McapLog};
use sideslip::io::outputs::queue::{QueuePolicy, queue};
use sideslip::io::outputs::record::{EventKind, EventRecord, Message};
use sideslip::io::telemetry::mcap::SampleReader;
use sideslip::realtime::estimation::record::EstimationEvent;
use std::fs::File;

#[test]
fn a_log_gives_back_its_head_and_the_bits_of_every_sample() {
    let path = folder("round-trip").join("run.mcap");
    let rows = rows(1000);
    let summary = write(&path, &rows, 26);
    assert_eq!((summary.lost, summary.files.as_slice(), summary.faults.len()), (0, [path.clone()].as_slice(), 0));
    assert_eq!(SampleReader::open(File::open(&path).unwrap()).unwrap().head(), &head());
    let (found, losses) = read(File::open(&path).unwrap()).unwrap();
    assert!(losses.is_none(), "{losses}");
    assert_eq!(losses.messages, summary.written);
    assert_eq!(found.len(), rows.len());
    for (found, logged) in found.iter().zip(&rows) {
        assert_eq!(bits(found), bits(logged));
    }
}

#[test]
fn through_queue_and_thread_everything_arrives_in_order() {
    let path = folder("thread").join("run.mcap");
    let rows = rows(5000);
    let log = McapLog::create(&path, head(), Box::new(|line| panic!("{line}"))).unwrap();
    let (mut sender, receiver) = queue(QueuePolicy::Lossless, 64, 2);
    let thread = LogThread::spawn(receiver, log).unwrap();
    for (sample, unknown) in &rows {
        sender.send_sample(sample, unknown);
        let kind = EventKind::Estimation(EstimationEvent::DuplicateTime);
        sender.send(&Message::Event(EventRecord { time_s: sample.time_s, kind }));
    }
    drop(sender);
    let summary = thread.join().unwrap();
    assert_eq!((summary.written, summary.lost), (10_000, 0));
    let (found, losses) = read(File::open(&path).unwrap()).unwrap();
    assert!(losses.is_none(), "{losses}");
    assert!(found.iter().map(bits).eq(rows.iter().map(bits)));
}

#[test]
fn two_columns_of_one_name_are_refused_before_a_file_is_made() {
    let path = folder("ambiguous").join("run.mcap");
    let mut head = head();
    head.channels.push(("ax".to_owned(), "g".to_owned()));
    let error = McapLog::create(&path, head, Box::new(|_| ())).map(|_| ()).unwrap_err();
    assert!(matches!(&error, LogError::AmbiguousColumn { name } if name == "ax"), "{error}");
    assert!(!path.exists());
}
