//! Dataflash readers on damaged, cut and hostile logs.

use super::super::encode::dataflash::{DataflashCell, DataflashWriter};
use super::error::DataflashError;
use super::reader::DataflashReader;
use super::tally::DataflashTally;

/// Names and times of all messages that are no definitions, read in pieces of that many bytes.
fn read(bytes: &[u8], piece: usize) -> (Vec<(String, Option<u64>)>, DataflashTally) {
    let mut reader = DataflashReader::new();
    let mut all = Vec::new();
    for mut piece in bytes.chunks(piece) {
        while !piece.is_empty() {
            let taken = reader.take(piece);
            piece = &piece[taken..];
            while let Some(message) = reader.next_message() {
                all.push((message.name().to_owned(), message.time_us()));
            }
        }
    }
    while let Some(message) = reader.last_message() {
        all.push((message.name().to_owned(), message.time_us()));
    }
    all.retain(|(name, _)| name != "FMT");
    (all, reader.tally().clone())
}

fn writer() -> DataflashWriter {
    let mut writer = DataflashWriter::new();
    writer.define(1, "ATT", "Qcc", "TimeUS,Roll,Pitch").unwrap();
    writer.define(2, "OLD", "If", "TimeMS,X").unwrap();
    writer
}

fn att(writer: &mut DataflashWriter, time_us: u64) {
    let angles = [DataflashCell::Number(1.0), DataflashCell::Number(-1.0)];
    writer.message(1, &[DataflashCell::Whole(time_us), angles[0], angles[1]]).unwrap();
}

fn times(count: std::ops::Range<u64>) -> Vec<(String, Option<u64>)> {
    count.map(|time| ("ATT".to_owned(), Some(time))).collect()
}

#[test]
fn garbage_between_messages_costs_the_one_before_it_at_most() {
    let mut writer = writer();
    (0..5).for_each(|time| att(&mut writer, time));
    writer.garbage(b"\xA3\x95\x01 no message of the log \xA3\x95 \xA3");
    (5..9).for_each(|time| att(&mut writer, time));
    let (found, tally) = read(writer.bytes(), 1 << 20);
    assert_eq!(found, times(0..9));
    // What looks like a header behind the fifth proves it; the garbage behind that proves nothing.
    assert_eq!((tally.doubtful, tally.resynchronised, tally.garbage_bytes), (1, 1, 30));
    let mut writer = self::writer();
    (0..5).for_each(|time| att(&mut writer, time));
    writer.garbage(&[0xFF; 40]);
    (5..9).for_each(|time| att(&mut writer, time));
    let (found, tally) = read(writer.bytes(), 1 << 20);
    assert_eq!(found, [times(0..4), times(5..9)].concat());
    assert_eq!((tally.doubtful, tally.garbage_bytes, tally.first_damage_at), (1, 40 + 15, Some(89 * 3 + 15 * 4)));
}

#[test]
fn a_message_with_missing_bytes_is_not_handed_on_and_the_next_is_not_lost() {
    let mut writer = writer();
    (0..9).for_each(|time| att(&mut writer, time));
    let fourth = 89 * 3 + 15 * 4;
    let mut bytes = writer.bytes().to_vec();
    bytes.drain(fourth + 5..fourth + 9);
    let (found, tally) = read(&bytes, 1 << 20);
    assert_eq!(found, [times(0..4), times(5..9)].concat());
    assert_eq!((tally.doubtful, tally.resynchronised, tally.garbage_bytes, tally.truncated), (1, 1, 11, None));
}

#[test]
fn pieces_of_any_size_give_the_same() {
    let mut writer = writer();
    for time in 0..200 {
        att(&mut writer, time);
        if time % 7 == 0 {
            writer.garbage(&[0xA3, 0x95, 1, 0xA3, 0x95, 77][..usize::try_from(time % 6).unwrap()]);
        }
    }
    let mut bytes = writer.bytes().to_vec();
    for at in (300..bytes.len()).step_by(131) {
        bytes[at] ^= 0x55;
    }
    bytes.truncate(bytes.len() - 4);
    let whole = read(&bytes, bytes.len());
    assert!(whole.0.len() > 100 && whole.1.garbage_bytes > 0 && whole.1.truncated.is_some(), "{whole:?}");
    for piece in [1, 2, 3, 16, 17, 100] {
        assert_eq!(read(&bytes, piece), whole, "{piece}");
    }
}

#[test]
fn every_byte_is_accounted_for() {
    let mut writer = writer();
    (0..50).for_each(|time| att(&mut writer, time));
    let clean = writer.bytes().to_vec();
    for at in 0..clean.len() {
        let mut bytes = clean.clone();
        bytes[at] ^= 0xFF;
        let (found, tally) = read(&bytes, 4096);
        // What cannot be read is ATT: its definition is damaged in a format character.
        let definitions = tally.messages - tally.unreadable - found.len() as u64;
        let used = definitions * 89
            + tally.unreadable * 15
            + found.iter().map(|(name, _)| if name == "ATT" { 15 } else { 11 }).sum::<u64>();
        let cut = tally.truncated.as_ref().map_or(0, |cut| cut.found as u64);
        assert_eq!(used + tally.garbage_bytes + cut, bytes.len() as u64, "{at}: {tally:?}");
    }
}

#[test]
fn a_definition_that_changes_is_reported_and_takes_effect() {
    let mut writer = writer();
    att(&mut writer, 1);
    writer.define(1, "ATT", "Qcc", "TimeUS,Roll,Pitch").unwrap();
    writer.define(1, "ATT2", "QB", "TimeUS,I").unwrap();
    writer.message(1, &[DataflashCell::Whole(2), DataflashCell::Whole(3)]).unwrap();
    let (found, tally) = read(writer.bytes(), 64);
    assert_eq!(found, [("ATT".to_owned(), Some(1)), ("ATT2".to_owned(), Some(2))]);
    // The FMT of FMT that every log begins with repeats what is known.
    assert_eq!((tally.redefinitions, tally.repeated_formats), (1, 2));
    assert!(matches!(&tally.complaints[..], [DataflashError::Redefined { kind: 1, at: 371, .. }]), "{:?}", tally.complaints);
}

#[test]
fn older_times_are_milliseconds_and_times_that_go_back_are_counted() {
    let mut writer = writer();
    for time in [5, u64::from(u32::MAX), 7] {
        writer.message(2, &[DataflashCell::Whole(time), DataflashCell::Number(0.0)]).unwrap();
    }
    let (found, tally) = read(writer.bytes(), 64);
    let times: Vec<_> = found.iter().filter_map(|(_, time)| *time).collect();
    assert_eq!((times, tally.backward), (vec![5000, 4_294_967_295_000, 7000], 1));
}

#[test]
fn units_and_multipliers_come_from_the_log() {
    let mut writer = DataflashWriter::new();
    writer.tables(&[('k', "deg/s"), ('s', "s")], &[('F', 1e-6), ('C', 0.001_f32.into()), ('0', 1.0)]).unwrap();
    writer.define(9, "GYR", "Qhcc", "TimeUS,X,Y,Z").unwrap();
    writer.units(9, "skk-", "FC0-").unwrap();
    let number = DataflashCell::Number;
    writer.message(9, &[DataflashCell::Whole(2_500_000), number(1234.0), number(5.0), number(0.25)]).unwrap();
    let mut reader = DataflashReader::new();
    assert_eq!(reader.take(writer.bytes()), writer.bytes().len());
    let mut found = Vec::new();
    while let Some(message) = reader.last_message() {
        if message.name() == "GYR" {
            found = message.fields().map(|field| (field.name.to_owned(), field.scaled, field.unit.map(str::to_owned))).collect();
        }
    }
    let deg = Some("deg/s".to_owned());
    let expected = [
        ("TimeUS".to_owned(), Some(2.5), Some("s".to_owned())),
        ("X".to_owned(), Some(1.234), deg.clone()),
        // MULT is about the number as it stands, 500, whatever the format character says.
        ("Y".to_owned(), Some(500.0), deg),
        ("Z".to_owned(), Some(0.25), None),
    ];
    assert_eq!(found, expected);
    assert!(matches!(&reader.tally().complaints[..], [DataflashError::Scale { field, .. }] if field == "Y"));
}

#[test]
fn noise_is_read_without_panic_and_in_time() {
    let mut state = 1_u64;
    let mut noise = || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
        (state >> 56) as u8
    };
    let bytes: Vec<u8> = (0..200_000).map(|_| noise()).collect();
    let (found, tally) = read(&bytes, 1000);
    assert_eq!((found.len(), tally.garbage_bytes), (0, 200_000));
    // Headers without end.
    let headers: Vec<u8> = [0xA3, 0x95, 0x80].iter().copied().cycle().take(200_000).collect();
    let (_, tally) = read(&headers, 1000);
    assert!(tally.complaints_total < 5000, "{tally:?}");
    // Definitions and noise mixed.
    let mut writer = writer();
    for time in 0..20_000_u64 {
        att(&mut writer, time);
        if time % 3 == 0 {
            let body: Vec<u8> = (0..86).map(|_| noise()).collect();
            writer.raw(0x80, &body);
        }
    }
    let (found, tally) = read(writer.bytes(), 4096);
    assert!(found.len() >= 19_900 && tally.complaints.len() <= 64, "{}", found.len());
}
