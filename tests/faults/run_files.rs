//! Broken run files: each is refused with its place, or read with the loss counted.

use sideslip::flight::channel::Channel;
use sideslip::io::telemetry::csv::{CsvRecording, LINE_MAX};
use sideslip::io::telemetry::record::{RecordingError, RecordingRow, SkipReason, SkippedByReason};
use std::io::{Cursor, Read};
use std::path::Path;

const SMALL: &str = "# run = \"1/2\"\n# blades = 4\ntime,p[deg/s],rudder,qhat\n0,1.5,0.25,7\n0.04,,-1e-3,\n0.08,nan,inf,8\n";

struct Read0 {
    rows: Vec<RecordingRow>,
    skipped: SkippedByReason,
    ends_abruptly: bool,
}

fn read(bytes: &[u8]) -> Result<Read0, RecordingError> {
    let mut recording = CsvRecording::new(Path::new("small.csv"), Box::new(Cursor::new(bytes.to_vec())))?;
    let mut rows = Vec::new();
    while let Some(row) = recording.next_row()? {
        rows.push(row.clone());
    }
    assert!(recording.next_row().unwrap().is_none(), "after the end there is only the end");
    Ok(Read0 { rows, skipped: recording.skipped().clone(), ends_abruptly: recording.ends_abruptly() })
}

/// Line, column and text of the place that is refused.
fn refused(bytes: &[u8]) -> (usize, usize, String) {
    match read(bytes) {
        Err(RecordingError::Place { place, .. }) => (place.line, place.column, place.what),
        Err(other) => panic!("expected a place, found {other}"),
        Ok(read) => panic!("expected a refusal, found {} rows", read.rows.len()),
    }
}

fn assert_refused(bytes: &[u8], line: usize, column: usize, words: &[&str]) {
    let (at, col, what) = refused(bytes);
    assert_eq!((at, col), (line, column), "{what}");
    for word in words {
        assert!(what.contains(word), "{word} is not in: {what}");
    }
}

#[test]
fn the_whole_file_is_read_as_written() {
    let read = read(SMALL.as_bytes()).unwrap();
    assert_eq!((read.rows.len(), read.skipped.rows(), read.ends_abruptly), (3, 0, false));
    let [first, second, third] = read.rows.as_slice() else { panic!() };
    assert_eq!(first.sample.get(Channel::P), Some(1.5 * (std::f64::consts::PI / 180.0)));
    assert_eq!((first.sample.get(Channel::Pedal), first.others.as_slice()), (Some(0.25), [Some(7.0)].as_slice()));
    assert_eq!((second.number, second.sample.time_s, second.sample.get(Channel::P)), (5, 0.04, None));
    assert_eq!((second.sample.get(Channel::Pedal), second.others.as_slice()), (Some(-1e-3), [None].as_slice()));
    assert!(third.sample.get(Channel::P).unwrap().is_nan(), "a value that is no number is there, for the estimator to flag");
    assert_eq!(third.sample.get(Channel::Pedal), Some(f64::INFINITY));
}

#[test]
fn cut_short_at_any_byte_it_gives_a_prefix_of_its_rows_or_a_place() {
    let whole = read(SMALL.as_bytes()).unwrap().rows;
    let (mut refusals, mut abrupt) = (0, 0);
    for length in 0..SMALL.len() {
        match read(&SMALL.as_bytes()[..length]) {
            Err(RecordingError::Place { place, .. }) => {
                assert!(place.line <= 4 && !place.what.is_empty(), "{place}");
                refusals += 1;
            }
            Err(other) => panic!("{length}: {other}"),
            Ok(read) => {
                // Every row before the last is the true one; the last may have lost digits, and then it is said.
                let certain = if read.ends_abruptly { read.rows.len().saturating_sub(1) } else { read.rows.len() };
                for (row, true_row) in read.rows.iter().zip(&whole).take(certain) {
                    assert_eq!(
                        (row.number, row.sample.present, &row.others),
                        (true_row.number, true_row.sample.present, &true_row.others)
                    );
                }
                let lines = SMALL[..length].lines().count() - 3;
                assert_eq!(read.rows.len() as u64 + read.skipped.rows(), lines as u64, "{length}");
                abrupt += usize::from(read.ends_abruptly);
            }
        }
    }
    let header_end = SMALL.find("qhat\n").unwrap() + 5;
    assert!(refusals > header_end && abrupt > 10, "{refusals} {abrupt}");
}

#[test]
fn bad_rows_are_skipped_counted_and_named() {
    let text = "time,p,q\n0,1,2\n0.1,x,2\n\n,1,2\n0.3,1\n0.4,1,2,3\n0.5,\"1\n0.6, \"1.5\" ,2\r\n0.7,1,\u{b0}\n0.8,1";
    let read = read(text.as_bytes()).unwrap();
    assert_eq!(read.rows.iter().map(|row| row.number).collect::<Vec<_>>(), [2, 9]);
    assert_eq!(read.rows[1].sample.get(Channel::P), Some(1.5));
    let found: Vec<_> = read.skipped.reasons().iter().map(|s| (s.reason, s.rows, s.first, s.example.as_str())).collect();
    assert_eq!(
        found,
        [
            (SkipReason::NotANumber, 2, 3, "column `p`: expected a number, found `x`"),
            (SkipReason::NoTime, 1, 5, "column `time`: expected the time, found an empty cell"),
            (SkipReason::CellCount, 4, 6, "expected 3 cells, found 2"),
        ]
    );
    assert!(read.ends_abruptly);
}

#[test]
fn separators_of_thousands_are_named() {
    let read = read(b"time,p\n0,1\n0.1,\"15,879.5\"\n0.2,1\n").unwrap();
    let found: Vec<_> = read.skipped.reasons().iter().map(|skipped| skipped.example.as_str()).collect();
    assert!(matches!(found[..], [only] if only.contains("no separators of thousands")), "{found:?}");
}

#[test]
fn a_file_of_bad_rows_or_of_none_is_an_error() {
    assert_refused(b"time,p\nx,y\n0\n", 2, 1, &["none in 2 lines", "`x`"]);
    assert_refused(b"# run = \"a\"\ntime,p\n", 2, 1, &["rows after the header"]);
    assert_refused(b"time,p", 1, 1, &["rows after the header"]);
    assert_refused(b"", 1, 1, &["header row"]);
    assert_refused(b"# run = \"a\"\n", 2, 1, &["header row"]);
}

#[test]
fn units_that_are_unknown_or_of_another_quantity_name_the_column() {
    assert_refused(b"# run = \"a\"\ntime,tas[furlong]\n0,1\n", 2, 6, &["`tas`", "furlong", "m/s"]);
    assert_refused(b"time,p[kn]\n0,1\n", 1, 6, &["`p`", "kn", "rad/s"]);
}

#[test]
fn columns_that_come_twice_or_not_at_all_are_named() {
    assert_refused(b"time,p,p\n0,1,1\n", 1, 8, &["`p`", "second time"]);
    assert_refused(b"p,q\n1,1\n", 1, 1, &["`time`"]);
    assert_refused(b"time,elevator,lon_cyclic\n0,1,1\n", 1, 15, &["`elevator`", "`lon_cyclic`"]);
    assert_refused(b"time,elevator,pedal\n0,1,1\n", 1, 15, &["`elevator`", "`pedal`"]);
}

#[test]
fn a_wrong_preamble_is_found_at_its_line_and_column_of_the_file() {
    assert_refused(b"# run = \"a\"\n# blades = \"four\"\ntime\n0\n", 2, 12, &["blades", "whole number"]);
    assert_refused(b"\xEF\xBB\xBF# run = 5\r\ntime\r\n0\r\n", 1, 9, &["run", "text in quotes"]);
    let (line, column, _) = refused(b"# run = \"a\"\n#\n# aircraft = = 3\ntime\n0\n");
    assert_eq!((line, column), (3, 14));
    assert_refused(b"# run = \"a\"\n# run = \"b\"\ntime\n0\n", 2, 3, &["duplicate"]);
    assert_refused(b"# run = \"\"\"abc\n# def\ntime\n0\n", 2, 6, &["string"]);
    assert_refused(b"#run = 1\ntime\n0\n", 1, 2, &["space after `#`"]);
}

#[test]
fn text_that_is_not_utf_8_is_refused_in_words_and_skipped_in_rows() {
    assert_refused(b"# aircraft = \"\xDCbung\"\ntime\n0\n", 1, 15, &["UTF-8"]);
    assert_refused(b"time,p[\xB0/s]\n0,1\n", 1, 6, &["UTF-8"]);
    let read = read(b"time,p\n0,1\n0.1,\xFF\n").unwrap();
    assert_eq!((read.rows.len(), read.skipped.rows()), (1, 1));
}

#[test]
fn byte_order_mark_line_ends_and_spaces_are_no_matter() {
    let plain = read(SMALL.as_bytes()).unwrap().rows;
    let dressed = format!("\u{feff}{}", SMALL.replace(',', " , ").replace('\n', "\r\n"));
    let dressed = read(dressed.as_bytes()).unwrap().rows;
    assert_eq!(plain[..2], dressed[..2]);
    assert_eq!(plain[2].number, dressed[2].number);
}

#[test]
fn a_line_without_end_stops_before_memory_does() {
    let endless =
        |start: &'static [u8], byte: u8| CsvRecording::new(Path::new("endless"), Box::new(start.chain(std::io::repeat(byte))));
    for (start, line) in [(b"# run = \"".as_slice(), 1), (b"time,".as_slice(), 1), (b"# blades = 4\ntime,".as_slice(), 2)] {
        match endless(start, b'x') {
            Err(RecordingError::Place { place, .. }) => {
                assert_eq!((place.line, place.what.contains("1048576 bytes")), (line, true))
            }
            _ => panic!("expected a refusal"),
        }
    }
    let mut recording = endless(b"time,p\n0,1\n", b',').unwrap();
    assert!(recording.next_row().unwrap().is_some());
    match recording.next_row() {
        Err(RecordingError::Place { place, .. }) => assert_eq!(place.line, 3),
        _ => panic!("expected a refusal"),
    }
    assert!(recording.next_row().unwrap().is_none());
}

#[test]
fn the_longest_line_that_is_allowed_is_read() {
    let mut text = b"time,p\n0,1".to_vec();
    text.resize("time,p\n".len() + LINE_MAX, b' ');
    assert_eq!(read(&text).unwrap().rows.len(), 1);
}

#[test]
fn a_failing_disk_is_told_from_a_wrong_file() {
    struct Failing;
    impl Read for Failing {
        fn read(&mut self, _: &mut [u8]) -> std::io::Result<usize> {
            Err(std::io::Error::other("disk"))
        }
    }
    let source = Cursor::new(b"time,p\n0,1\n".to_vec()).chain(Failing);
    let mut recording = CsvRecording::new(Path::new("f"), Box::new(source)).unwrap();
    assert!(recording.next_row().unwrap().is_some());
    assert!(matches!(recording.next_row(), Err(RecordingError::Io { .. })));
}
