//! No bytes make the reader panic or take much memory: mutated logs, with and without checksums, and wild lengths.

use super::example::{Dice, folder, head, read_bytes, rows, write};
use std::collections::BTreeMap;
use std::io::Cursor;

fn mutations() -> usize {
    std::env::var("SIDESLIP_MUTATIONS").ok().and_then(|text| text.parse().ok()).unwrap_or(20_000)
}

fn mutate(file: &[u8], dice: &mut Dice) -> Vec<u8> {
    let mut bytes = file.to_vec();
    for _ in 0..=dice.below(4) {
        let at = dice.below(bytes.len());
        match dice.below(6) {
            0 => bytes.truncate(at + 1),
            1 => drop(bytes.drain(at..(at + dice.below(20)).min(bytes.len()))),
            2 => bytes.insert(at, dice.bits() as u8),
            3 => {
                let wild = [u64::MAX, 1 << 63, 1 << 32, u64::from(u32::MAX), 33 << 20][dice.below(5)].to_le_bytes();
                let end = (at + wild.len()).min(bytes.len());
                bytes[at..end].copy_from_slice(&wild[..end - at]);
            }
            4 => bytes[at] ^= 1 << dice.below(8),
            _ => bytes[at] = dice.bits() as u8,
        }
        if bytes.is_empty() {
            break;
        }
    }
    bytes
}

/// A log like ours without compression and checksums, so that mutations reach what is inside.
fn unguarded() -> Vec<u8> {
    let mut file = Cursor::new(Vec::new());
    let options = mcap::WriteOptions::new().compression(None).calculate_chunk_crcs(false).calculate_data_section_crc(false);
    let mut writer = options.create(&mut file).unwrap();
    let metadata = mcap::write::Metadata { name: "run".to_owned(), metadata: head().to_metadata("test") };
    writer.write_metadata(&metadata).unwrap();
    let channel_id = writer.add_channel(0, "/sample", "json", &BTreeMap::new()).unwrap();
    for sequence in 0..30 {
        let header = mcap::records::MessageHeader { channel_id, sequence, log_time: 0, publish_time: 0 };
        let payload = format!(r#"{{"time":{sequence},"p":1e-3,"fuel":null,"more":[{{"a":"\u00e4"}}],"rudder":-0.25}}"#);
        writer.write_to_known_channel(&header, payload.as_bytes()).unwrap();
        if sequence % 10 == 9 {
            writer.flush().unwrap();
        }
    }
    writer.finish().unwrap();
    drop(writer);
    file.into_inner()
}

#[test]
fn mutated_logs_are_read_as_far_as_they_go() {
    let path = folder("hostile").join("run.mcap");
    write(&path, &rows(40), 8);
    let guarded = std::fs::read(&path).unwrap();
    let unguarded = unguarded();
    for file in [&guarded, &unguarded] {
        assert!(read_bytes(file).unwrap().1.is_none());
    }
    let mut dice = Dice(97);
    let (mut opened, mut complained) = (0, 0);
    for turn in 0..mutations() {
        let file = if turn % 2 == 0 { &guarded } else { &unguarded };
        if let Some((found, losses)) = read_bytes(&mutate(file, &mut dice)) {
            opened += 1;
            complained += usize::from(!losses.is_none());
            assert!(found.len() <= 80, "{}", found.len());
        }
    }
    eprintln!("{} mutations: {opened} opened, {complained} of them with losses", mutations());
}

#[test]
fn a_record_longer_than_its_uncompressed_chunk_is_damage() {
    let file = unguarded();
    let mut at = 8;
    while file[at] != 6 {
        at += 9 + u64::from_le_bytes(file[at + 1..at + 9].try_into().unwrap()) as usize;
    }
    // Both sizes one less: the last byte of the last record is now behind the chunk's records.
    let mut shorter = file.clone();
    for size in [at + 9 + 16, at + 9 + 16 + 8 + 4 + 4] {
        shorter[size] -= 1;
    }
    let (found, losses) = read_bytes(&shorter).unwrap();
    assert_eq!(found.len(), 0, "the first chunk introduces the channel");
    assert_eq!(losses.damaged.unwrap().1, "a record is longer than the chunk that it stands in");
    assert_eq!(losses.orphans, 20);
}

#[test]
fn wild_lengths_take_no_memory() {
    let path = folder("wild").join("run.mcap");
    write(&path, &rows(20), 8);
    let file = std::fs::read(&path).unwrap();
    // At every place each wild length in turn: the reader may refuse, and must come back soon.
    let started = std::time::Instant::now();
    for at in (0..file.len() - 8).step_by(5) {
        for wild in [u64::MAX, 0xFFFF_FFFF, 1 << 40, (32 << 20) - 1] {
            let mut bytes = file.clone();
            bytes[at..at + 8].copy_from_slice(&wild.to_le_bytes());
            let _ = read_bytes(&bytes);
        }
    }
    eprintln!("{} readings in {:.1} s", file.len() / 5 * 4, started.elapsed().as_secs_f64());
}
