//! What parts the cells of a table, and whole numbers from decimals, found out from its first lines.
//!
//! Consumes bytes; produces the lines that decide, and a [`TableLayout`]. The separator is that of `,` `;` tab `|` which
//! parts the header most often outside quotes; a decimal comma is one where cells are numbers with it, and none has a point.

use super::cell::{bare, header_text, join_quoted, number_of};
use crate::io::telemetry::channel_map::unit_text::unit_of;
use csv::ByteRecord;
use std::io::{BufRead, Read};

/// So many lines decide.
const LINES: usize = 40;
/// So many bytes at most.
const BYTES: u64 = 2 << 20;

/// How the cells of a table stand.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct TableLayout {
    pub(crate) separator: u8,
    pub(crate) decimal: u8,
}

/// The first lines, as far as there are any. What fails here fails again when the rows are read, and is said there.
pub(crate) fn first_lines(source: &mut dyn BufRead) -> Vec<u8> {
    let mut source = source.take(BYTES);
    let mut bytes = Vec::new();
    for _ in 0..LINES {
        match source.read_until(b'\n', &mut bytes) {
            Ok(count) if count > 0 => {}
            Ok(_) | Err(_) => break,
        }
    }
    bytes
}

/// The lines that are not blank, without their ends.
pub(crate) fn lines(bytes: &[u8]) -> impl Iterator<Item = &[u8]> {
    bytes.split(|byte| *byte == b'\n').filter(|line| !line.trim_ascii().is_empty())
}

/// The cells of a line.
pub(crate) fn cells(line: &[u8], separator: u8) -> ByteRecord {
    let mut record: ByteRecord = line.split(|byte| *byte == separator).collect::<Vec<_>>().into();
    join_quoted(&mut record, separator);
    record
}

impl TableLayout {
    /// That of the lines, the first of them the header; what is stated is taken.
    pub(crate) fn of(lines: &[&[u8]], separator: Option<u8>, decimal: Option<u8>) -> Self {
        let header = lines.first().copied().unwrap_or_default();
        let separator = separator.unwrap_or_else(|| separator_of(header));
        let decimal = decimal.unwrap_or_else(|| decimal_of(lines.get(1..).unwrap_or_default(), separator));
        TableLayout { separator, decimal }
    }

    /// What is not as in a run file, in words.
    pub(crate) fn words(self) -> Vec<String> {
        let separator = match self.separator {
            b',' => None,
            b'\t' => Some("cells are parted by tabs".to_owned()),
            other => Some(format!("cells are parted by `{}`", char::from(other))),
        };
        let decimal = (self.decimal == b',').then(|| "the decimal sign is a comma".to_owned());
        separator.into_iter().chain(decimal).collect()
    }
}

/// The line below the header, where it holds units and not a single number.
pub(crate) fn unit_row(lines: &[&[u8]], layout: TableLayout) -> Option<ByteRecord> {
    let record = cells(lines.get(1)?, layout.separator);
    let told = record.iter().map(header_text).filter(|(text, _)| !text.is_empty());
    let is_number = |cell: &[u8]| !bare(cell).is_empty() && number_of(cell, layout.decimal).is_ok_and(|number| number.is_some());
    let unit = |text: &str| unit_of(text.trim_matches(['[', ']', '(', ')'])).is_some();
    let units = told.filter(|(text, _)| unit(text)).count();
    // `1` is a unit of a ratio.
    let numbers = record.iter().filter(|cell| bare(cell) != b"1" && is_number(cell)).count();
    (units > 0 && numbers == 0).then_some(record)
}

fn separator_of(header: &[u8]) -> u8 {
    let mut counts = [(b',', 0_usize), (b';', 0), (b'\t', 0), (b'|', 0)];
    let mut quoted = false;
    for byte in header {
        quoted ^= *byte == b'"';
        if let Some((_, count)) = counts.iter_mut().find(|(separator, _)| separator == byte && !quoted) {
            *count += 1;
        }
    }
    // Of as many of both the comma.
    counts.into_iter().rev().max_by_key(|(_, count)| *count).map_or(b',', |(separator, _)| separator)
}

fn decimal_of(rows: &[&[u8]], separator: u8) -> u8 {
    let mut with_comma = false;
    for row in rows {
        for cell in &cells(row, separator) {
            let cell = bare(cell);
            if cell.contains(&b'.') && number_of(cell, b'.').is_ok() {
                return b'.';
            }
            with_comma |= cell.contains(&b',') && number_of(cell, b',').is_ok();
        }
    }
    if with_comma { b',' } else { b'.' }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn layout(text: &str) -> TableLayout {
        TableLayout::of(&lines(text.as_bytes()).collect::<Vec<_>>(), None, None)
    }

    #[test]
    fn separator_and_decimal_sign_are_found_out() {
        let of = |separator, decimal| TableLayout { separator, decimal };
        assert_eq!(layout("time,p\n0.1,2\n"), of(b',', b'.'));
        assert_eq!(layout("time;p\n0,1;2\n"), of(b';', b','));
        assert_eq!(layout("time;p\n0.1;2\n"), of(b';', b'.'));
        assert_eq!(layout("time\tp\n0,1\t2\n"), of(b'\t', b','));
        assert_eq!(layout("\"time\",\"p, [deg/s]\"\n\"0,1\",\"2\"\n"), of(b',', b','));
        assert_eq!(layout("\"a;b;c\",time\n1,2\n"), of(b',', b'.'));
        assert_eq!(layout("time\n1\n"), of(b',', b'.'));
        assert_eq!(layout("time,p|q\n1,2\n"), of(b',', b'.'), "of as many of both the comma");
        assert_eq!(layout("time;p;q\n0,1;2;1.5\n").decimal, b'.', "both signs: nothing is assumed");
        assert_eq!(layout("time;p\n0,1;2\n").words(), ["cells are parted by `;`", "the decimal sign is a comma"]);
    }
}
