//! ULog readers on damaged, cut, appended and hostile logs.

use super::super::encode::ulog::UlogWriter;
use super::error::{LayoutError, UlogError};
use super::message::UlogMessage;
use super::reader::UlogReader;
use super::tally::{UlogTally, UlogTruncation};

/// Names and times of data, and the words of other messages, read in pieces of that many bytes.
fn read(bytes: &[u8], piece: usize) -> Result<(Vec<String>, UlogTally), UlogError> {
    let mut reader = UlogReader::new();
    let mut all = Vec::new();
    let mut one = |message: UlogMessage<'_>| match message {
        UlogMessage::Data(data) => all.push(format!("{}{} {:?}", data.name(), data.multi_id(), data.time_us())),
        UlogMessage::Logged(line) => all.push(format!("{} {:?} {} {}", line.level, line.tag, line.time_us, line.text())),
        UlogMessage::Dropout { duration_ms } => all.push(format!("dropout {duration_ms}")),
        UlogMessage::Removed { id } => all.push(format!("removed {id}")),
        UlogMessage::DefaultParameter { types, keyed } => {
            all.push(format!("default {types} {} {}", keyed.key, keyed.value().unwrap().number()));
        }
        UlogMessage::MultiInformation { continued, keyed } => all.push(format!("{continued} {}", keyed.text().unwrap())),
        _ => {}
    };
    for mut piece in bytes.chunks(piece) {
        while !piece.is_empty() {
            let taken = reader.take(piece);
            piece = &piece[taken..];
            while let Some(message) = reader.next_message()? {
                one(message);
            }
        }
    }
    while let Some(message) = reader.last_message()? {
        one(message);
    }
    Ok((all, reader.tally().clone()))
}

fn writer() -> UlogWriter {
    let mut writer = UlogWriter::new(0);
    writer.format("gyro:uint64_t timestamp;float[3] xyz;uint8_t[4] _padding0;").unwrap();
    writer.subscribe(0, 3, "gyro").unwrap();
    writer.subscribe(1, 4, "gyro").unwrap();
    writer
}

fn gyro(writer: &mut UlogWriter, id: u16, time_us: u64) {
    writer.data(id, &[&time_us.to_le_bytes(), &[0; 12]]).unwrap();
}

fn gyros(times: std::ops::Range<u64>) -> Vec<String> {
    times.map(|time| format!("gyro0 {:?}", Some(time))).collect()
}

#[test]
fn every_kind_of_message_is_read() {
    let mut writer = writer();
    gyro(&mut writer, 4, 17);
    // With its padding, as a writer may leave it.
    writer.data(3, &[&18_u64.to_le_bytes(), &[0; 16]]).unwrap();
    writer.message(b'L', &[b"4", &9_u64.to_le_bytes(), b"low"]).unwrap();
    writer.message(b'C', &[b"6", &[1, 2], &9_u64.to_le_bytes(), "ok\u{e9}".as_bytes()]).unwrap();
    writer.dropout(250);
    writer.dropout(30);
    writer.message(b'Q', &[&[3, 10], b"float GAIN", &1.5_f32.to_le_bytes()]).unwrap();
    writer.message(b'M', &[&[1, 9], b"char[2] t", b"ab"]).unwrap();
    writer.message(b'R', &[&[4, 0]]).unwrap();
    gyro(&mut writer, 4, 18);
    gyro(&mut writer, 3, 17);
    let (found, tally) = read(writer.bytes(), 1 << 20).unwrap();
    let expected = [
        "gyro1 Some(17)",
        "gyro0 Some(18)",
        "52 None 9 low",
        "54 Some(513) 9 ok\u{e9}",
        "dropout 250",
        "dropout 30",
        "default 3 GAIN 1.5",
        "true ab",
        "removed 4",
        "gyro0 Some(17)",
    ];
    assert_eq!(found, expected);
    assert_eq!((tally.dropouts, tally.dropout_ms, tally.unsubscribed, tally.backward), (2, 280, 1, 1));
    assert_eq!((tally.garbage_bytes, tally.complaints_total), (0, 0));
}

#[test]
fn unknown_kinds_are_skipped_in_step() {
    let mut writer = writer();
    gyro(&mut writer, 3, 0);
    writer.message(b'Z', &[&[7; 300]]).unwrap();
    writer.message(b'z', &[b"more"]).unwrap();
    gyro(&mut writer, 3, 1);
    writer.message(b'Z', &[&[7; 30]]).unwrap();
    let (found, tally) = read(writer.bytes(), 11).unwrap();
    assert_eq!(found, gyros(0..2));
    assert_eq!((tally.unknown_kinds, tally.garbage_bytes, tally.truncated), (3, 0, None));
}

#[test]
fn damage_costs_the_message_that_it_is_in_and_a_false_header_the_one_before() {
    let mut writer = writer();
    (0..9).for_each(|time| gyro(&mut writer, 3, time));
    let clean = writer.bytes().to_vec();
    let fourth = clean.len() - 5 * 25;
    for (change, to, lost) in [(0, 0x94, 4..5), (2, b'X', 4..5), (3, 0x82, 4..5), (2, b'R', 3..5)] {
        let mut bytes = clean.clone();
        bytes[fourth + change] = to;
        let (found, tally) = read(&bytes, 64).unwrap();
        let kept = |time: &u64| !lost.contains(time);
        let expected: Vec<_> = (0..9).filter(kept).map(|time| format!("gyro0 {:?}", Some(time))).collect();
        assert_eq!(found, expected, "{change}: {tally:?}");
    }
    let mut bytes = clean.clone();
    bytes.drain(fourth + 9..fourth + 20);
    let (found, tally) = read(&bytes, 64).unwrap();
    assert_eq!(found, [gyros(0..4), gyros(5..9)].concat());
    assert_eq!((tally.doubtful, tally.resynchronised, tally.garbage_bytes), (1, 1, 14));
}

#[test]
fn a_size_that_is_damaged_near_the_end_does_not_swallow_the_rest() {
    let mut writer = writer();
    (0..9).for_each(|time| gyro(&mut writer, 3, time));
    let mut bytes = writer.bytes().to_vec();
    let fourth = bytes.len() - 5 * 25;
    // A line of text of 40000 bytes, it says.
    bytes[fourth..fourth + 3].copy_from_slice(&[0x40, 0x9C, b'L']);
    let (found, tally) = read(&bytes, 64).unwrap();
    assert_eq!(found, [gyros(0..4), gyros(5..9)].concat());
    assert_eq!((tally.truncated, tally.garbage_bytes), (None, 25));
}

#[test]
fn the_end_may_cut_a_message_anywhere() {
    let mut writer = writer();
    (0..3).for_each(|time| gyro(&mut writer, 3, time));
    let bytes = writer.bytes();
    for cut in 1..25 {
        let (found, tally) = read(&bytes[..bytes.len() - cut], 7).unwrap();
        assert_eq!(found, gyros(0..2));
        let at = bytes.len() as u64 - 25;
        let header = cut < 23;
        let (kind, expected) = if header { (Some(b'D'), 25) } else { (None, 0) };
        assert_eq!(tally.truncated, Some(UlogTruncation { at, kind, found: 25 - cut, expected }));
        assert_eq!(tally.garbage_bytes, 0);
    }
}

#[test]
fn appended_data_begin_at_their_offset_whatever_stands_before() {
    let mut writer = writer();
    gyro(&mut writer, 3, 0);
    gyro(&mut writer, 3, 1);
    let length = writer.bytes().len();
    writer.bytes_mut().truncate(length - 9);
    writer.append();
    gyro(&mut writer, 3, 2);
    writer.append();
    writer.message(b'L', &[b"0", &9_u64.to_le_bytes(), b"fault"]).unwrap();
    for piece in [1, 10, 1000] {
        let (found, tally) = read(writer.bytes(), piece).unwrap();
        assert_eq!(found, [gyros(0..1), gyros(2..3), vec!["48 None 9 fault".into()]].concat());
        assert_eq!((tally.appended_sections, tally.cut_at_section, tally.garbage_bytes), (2, 1, 0));
    }
    // Offsets that lie before what was read are refused.
    let mut bytes = writer.bytes().to_vec();
    bytes[16 + 3 + 16..16 + 3 + 24].copy_from_slice(&5_u64.to_le_bytes());
    let (_, tally) = read(&bytes, 100).unwrap();
    assert!(matches!(tally.complaints[..], [UlogError::Offset { offset: 5, .. }]));
}

#[test]
fn what_must_not_be_read_is_not() {
    let mut writer = writer();
    gyro(&mut writer, 3, 0);
    for (byte, bits) in [(0, 2), (0, 3), (5, 1)] {
        let mut bytes = writer.bytes().to_vec();
        bytes[16 + 3 + 8 + byte] = bits;
        let error = read(&bytes, 10).unwrap_err();
        assert!(matches!(error, UlogError::Incompatible { at: 16, index, .. } if index == byte), "{error}");
    }
    assert!(matches!(read(b"ULog\x01\x12\x36", 3).unwrap_err(), UlogError::Magic { .. }));
    // What is said of it does not depend on the pieces.
    let other = b"U, which is no log";
    assert!((1..9).all(|piece| read(other, piece).unwrap_err() == UlogError::Magic { found: other[..7].to_vec() }));
    assert_eq!(read(b"", 3).unwrap_err(), UlogError::HeaderCut { found: 0 });
    assert_eq!(read(&writer.bytes()[..15], 3).unwrap_err(), UlogError::HeaderCut { found: 15 });
}

#[test]
fn hostile_definitions_are_refused_and_the_rest_is_read() {
    let mut writer = writer();
    writer.format("a:a within;").unwrap();
    writer.format("huge:double[65535] x;").unwrap();
    writer.format("b:c[65535] x;").unwrap();
    writer.format("c:bool y;").unwrap();
    writer.format("broken").unwrap();
    writer.keyed(b'I', "float[2] short", &[0; 4]).unwrap();
    for (id, name) in [(10, "a"), (11, "huge"), (12, "none")] {
        writer.subscribe(0, id, name).unwrap();
    }
    (0..2000).for_each(|id| writer.subscribe(0, 100 + id, "b").unwrap());
    gyro(&mut writer, 3, 0);
    let (found, tally) = read(writer.bytes(), 1000).unwrap();
    assert_eq!((found, tally.refused), (gyros(0..1), 2));
    let layout = |at: usize| match &tally.complaints[at] {
        UlogError::Layout { what, .. } => what.clone(),
        other => panic!("{other}"),
    };
    assert!(matches!(tally.complaints[0], UlogError::Format { .. }) && matches!(tally.complaints[1], UlogError::Content { .. }));
    assert!(matches!(layout(2), LayoutError::Depth { .. }) && matches!(layout(3), LayoutError::Size { .. }));
    assert!(matches!(tally.complaints[4], UlogError::NoFormat { id: 12, .. }));
}

#[test]
fn pieces_of_any_size_give_the_same_of_a_damaged_log() {
    let mut writer = writer();
    for time in 0..300 {
        gyro(&mut writer, 3, time);
        if time % 50 == 0 {
            writer.sync();
            writer.garbage(&[0, 1, 2, b'D', 8, 0, b'S'][..usize::try_from(time % 7).unwrap()]);
            writer.message(b'L', &[b"4", &9_u64.to_le_bytes(), b"text"]).unwrap();
        }
    }
    let mut bytes = writer.bytes().to_vec();
    for at in (400..bytes.len()).step_by(233) {
        bytes[at] ^= 0x55;
    }
    bytes.truncate(bytes.len() - 3);
    let whole = read(&bytes, bytes.len()).unwrap();
    assert!(whole.0.len() > 200 && whole.1.garbage_bytes > 0, "{whole:?}");
    for piece in [1, 2, 3, 26, 500] {
        assert_eq!(read(&bytes, piece).unwrap(), whole, "{piece}");
    }
}

#[test]
fn noise_is_read_without_panic_and_in_time() {
    let mut state = 1_u64;
    let mut noise = || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
        (state >> 56) as u8
    };
    let mut writer = writer();
    let from = writer.bytes().len() as u64;
    writer.garbage(&(0..300_000).map(|_| noise()).collect::<Vec<_>>());
    let (found, tally) = read(writer.bytes(), 1000).unwrap();
    assert!(found.len() < 3 && tally.garbage_bytes > 299_000, "{found:?}");
    assert!(tally.first_damage_at.is_some_and(|at| at >= from - 30));
    // Headers of every kind without end.
    for kind in b"ABCDFILMOPQRSZ" {
        let mut writer = self::writer();
        writer.garbage(&[0xFF, 0x0F, *kind].repeat(60_000));
        read(writer.bytes(), 5000).unwrap();
        let mut writer = self::writer();
        writer.garbage(&[0x20, 0x20, *kind].repeat(60_000));
        read(writer.bytes(), 5000).unwrap();
    }
}
