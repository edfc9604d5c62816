//! A log cut off anywhere gives the messages before the cut, all those of whole chunks among them, and says that it was.

use super::example::{bits, folder, read_bytes, rows, write};

const CHUNK: usize = 20;

/// Where each chunk of a file ends, by walking its records.
fn chunk_ends(file: &[u8]) -> Vec<usize> {
    let mut ends = Vec::new();
    let mut at = 8;
    while at + 9 <= file.len() - 8 {
        let length = u64::from_le_bytes(file[at + 1..at + 9].try_into().unwrap()) as usize;
        if file[at] == 6 {
            ends.push(at + 9 + length);
        }
        at += 9 + length;
    }
    ends
}

#[test]
fn every_cut_leaves_a_prefix() {
    let path = folder("truncation").join("run.mcap");
    let rows = rows(300);
    write(&path, &rows, CHUNK);
    let file = std::fs::read(&path).unwrap();
    // The first chunk holds schemas and channels alone.
    let ends = &chunk_ends(&file)[1..];
    assert_eq!(ends.len(), 300 / CHUNK);
    let expected: Vec<_> = rows.iter().map(bits).collect();
    let mut from_cut_chunks = 0;
    for cut in (0..file.len()).step_by(97).chain(file.len() - 40..file.len()) {
        let at_least = CHUNK * ends.iter().filter(|end| **end <= cut).count();
        let Some((found, losses)) = read_bytes(&file[..cut]) else {
            assert_eq!(at_least, 0, "cut at {cut}: the head is before the first sample");
            continue;
        };
        assert!(found.len() >= at_least, "cut at {cut}: {} of at least {at_least}", found.len());
        from_cut_chunks += found.len() - at_least;
        assert!(found.iter().map(bits).eq(expected[..found.len()].iter().cloned()), "cut at {cut}");
        let said = losses.to_string();
        let start = format!("truncated after {} messages ({} samples)", losses.messages, found.len());
        assert!(said.starts_with(&start) && losses.damaged.is_none(), "cut at {cut}: {said}");
    }
    eprintln!("{} bytes, {from_cut_chunks} samples came from chunks that a cut went through", file.len());
}

#[test]
fn a_damaged_chunk_costs_its_own_samples_only() {
    let path = folder("damage").join("run.mcap");
    let rows = rows(100);
    write(&path, &rows, CHUNK);
    let mut file = std::fs::read(&path).unwrap();
    let end = chunk_ends(&file)[3];
    file[end - 30] ^= 0x10;
    let (found, losses) = read_bytes(&file).unwrap();
    let expected = rows[..2 * CHUNK].iter().chain(&rows[3 * CHUNK..]);
    assert!(found.iter().map(bits).eq(expected.map(bits)));
    assert_eq!(losses.damaged.as_ref().map(|(count, _)| *count), Some(1), "{losses}");
}
