//! Damage in recorded logs: how many messages a damaged byte costs, and how many false ones it makes.
use crate::support::program::data;
use sideslip::io::telemetry::logs::dataflash::reader::DataflashReader;
use sideslip::io::telemetry::logs::ulog::message::UlogMessage;
use sideslip::io::telemetry::logs::ulog::reader::UlogReader;
use std::collections::BTreeSet;

/// Bytes of a recording; `None`, said loudly, where it is absent.
fn recording(name: &str) -> Option<Vec<u8>> {
    data("logs", name).map(|file| std::fs::read(file).unwrap())
}

/// Where messages begin, with their names.
type Places = BTreeSet<(u64, String)>;

fn dataflash(mut bytes: &[u8]) -> Places {
    let (mut reader, mut places) = (DataflashReader::new(), Places::new());
    while !bytes.is_empty() {
        bytes = &bytes[reader.take(bytes)..];
        while let Some(message) = reader.next_message() {
            places.insert((message.at(), message.name().to_owned()));
        }
    }
    while let Some(message) = reader.last_message() {
        places.insert((message.at(), message.name().to_owned()));
    }
    places
}

fn ulog(mut bytes: &[u8]) -> Places {
    let (mut reader, mut places) = (UlogReader::new(), Places::new());
    let mut one = |message: UlogMessage<'_>| {
        if let UlogMessage::Data(data) = message {
            places.insert((data.at(), data.name().to_owned()));
        }
    };
    while !bytes.is_empty() {
        bytes = &bytes[reader.take(bytes)..];
        while let Some(message) = reader.next_message().unwrap() {
            one(message);
        }
    }
    while let Some(message) = reader.last_message().unwrap() {
        one(message);
    }
    places
}

/// Reads the log so many times with damage behind `from`; messages lost and false ones, and damaged bytes, in all.
fn damaged(clean: &[u8], from: usize, times: u64, flips: usize, read: fn(&[u8]) -> Places) -> (usize, usize, usize) {
    let original = read(clean);
    let mut state = 1_u64;
    let mut next = move || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        usize::try_from(state >> 33).unwrap()
    };
    let (mut lost, mut made) = (0, 0);
    for _ in 0..times {
        let mut bytes = clean.to_vec();
        for _ in 0..flips {
            let at = from + next() % (bytes.len() - from);
            bytes[at] ^= u8::try_from(next() % 255 + 1).unwrap();
        }
        let found = read(&bytes);
        lost += original.difference(&found).count();
        made += found.difference(&original).count();
    }
    (lost, made, usize::try_from(times).unwrap() * flips)
}

#[test]
fn a_damaged_byte_of_a_dataflash_log_costs_less_than_a_message() {
    let Some(clean) = recording("plane-3.8.2.BIN") else { return };
    // Behind the definitions, of which a damaged one costs every message of its type.
    let (lost, made, flips) = damaged(&clean, 132 * 89, 300, 20, dataflash);
    eprintln!("dataflash: {flips} bytes damaged, {lost} messages lost, {made} false");
    assert!(lost < flips / 5 && made < flips / 50, "{lost} {made} {flips}");
}

#[test]
fn a_damaged_byte_of_a_ulog_costs_less_than_a_message() {
    let Some(clean) = recording("sample_log_small.ulg") else { return };
    // Behind the definitions and the first data.
    let (lost, made, flips) = damaged(&clean, 200_000, 60, 100, ulog);
    eprintln!("ULog: {flips} bytes damaged, {lost} messages lost, {made} false");
    assert!(lost < flips / 5 && made < flips / 50, "{lost} {made} {flips}");
}
