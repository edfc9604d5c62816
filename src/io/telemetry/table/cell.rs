//! Cells of a line: quotes, numbers with a decimal point or comma.

use csv::ByteRecord;

/// Joins cells again that the separator parted within quotes; quotes that have no end part as they stand.
pub(crate) fn join_quoted(record: &mut ByteRecord, separator: u8) {
    let opens = |cell: &[u8]| {
        let cell = cell.trim_ascii();
        cell.first() == Some(&b'"') && !closes(cell.get(1..).unwrap_or_default())
    };
    if !record.iter().any(opens) {
        return;
    }
    let mut joined = ByteRecord::with_capacity(record.as_slice().len() + record.len(), record.len());
    let mut place = 0;
    while let Some(cell) = record.get(place) {
        let end = if opens(cell) { (place + 1..record.len()).find(|at| record.get(*at).is_some_and(closes)) } else { None };
        let Some(end) = end else {
            joined.push_field(cell);
            place += 1;
            continue;
        };
        let parts: Vec<&[u8]> = (place..=end).filter_map(|at| record.get(at)).collect();
        joined.push_field(&parts.join(&separator));
        place = end + 1;
    }
    *record = joined;
}

/// Whether a quote ends there; a doubled one stands for itself.
fn closes(cell: &[u8]) -> bool {
    let quotes = cell.trim_ascii().iter().rev().take_while(|byte| **byte == b'"').count();
    quotes % 2 == 1
}

/// The cell without spaces and one pair of quotes around it.
pub(crate) fn bare(cell: &[u8]) -> &[u8] {
    match cell.trim_ascii() {
        [b'"', inner @ .., b'"'] => inner.trim_ascii(),
        cell => cell,
    }
}

/// What spreadsheets write where there is no number.
const NO_NUMBER: [&str; 4] = ["#N/A", "#NV", "N/A", "NA"];

/// The number in a cell; `None` where it is empty, NaN where a spreadsheet says that there is none.
pub(crate) fn number_of(cell: &[u8], decimal: u8) -> Result<Option<f64>, ()> {
    let cell = bare(cell);
    if cell.is_empty() {
        return Ok(None);
    }
    let text = std::str::from_utf8(cell).map_err(drop)?;
    if NO_NUMBER.contains(&text) {
        return Ok(Some(f64::NAN));
    }
    let parsed = match (decimal, text.contains(',')) {
        (b',', true) if text.contains('.') => None,
        (b',', true) => text.replacen(',', ".", 1).parse().ok(),
        // A point would be one of thousands.
        (b',', false) if text.contains('.') => None,
        _ => text.parse().ok(),
    };
    parsed.map(Some).ok_or(())
}

/// The text of a header's cell; bytes that are no UTF-8 are taken as Latin-1, and whether that was so.
pub(crate) fn header_text(cell: &[u8]) -> (String, bool) {
    let cell = bare(cell);
    match std::str::from_utf8(cell) {
        Ok(text) => (text.replace("\"\"", "\""), false),
        Err(_) => (cell.iter().map(|byte| char::from(*byte)).collect(), true),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn joined(line: &str) -> Vec<String> {
        let mut record = ByteRecord::from(line.split(',').collect::<Vec<_>>());
        join_quoted(&mut record, b',');
        record.iter().map(|cell| String::from_utf8(cell.to_vec()).unwrap()).collect()
    }

    #[test]
    fn a_separator_within_quotes_parts_nothing() {
        assert_eq!(joined("a,\"b,c\",d"), ["a", "\"b,c\"", "d"]);
        assert_eq!(joined("\"Roll Rate, deg/s\",\"x\""), ["\"Roll Rate, deg/s\"", "\"x\""]);
        assert_eq!(joined("\"0,5\",\"-1,25\""), ["\"0,5\"", "\"-1,25\""]);
        assert_eq!(joined("a,\"b,c,d"), ["a", "\"b", "c", "d"], "a stray quote joins nothing");
        assert_eq!(joined("\"a \"\"b\"\", c\",d"), ["\"a \"\"b\"\", c\"", "d"]);
    }

    #[test]
    fn numbers_have_one_decimal_sign() {
        assert_eq!(number_of(b" \"-1,25\" ", b','), Ok(Some(-1.25)));
        assert_eq!(number_of(b"3", b','), Ok(Some(3.0)));
        assert_eq!(number_of(b"1.234", b','), Err(()));
        assert_eq!(number_of(b"1.234,5", b','), Err(()));
        assert_eq!(number_of(b"1,2,3", b','), Err(()));
        assert_eq!(number_of(b"1,25", b'.'), Err(()));
        assert_eq!((number_of(b"", b'.'), number_of(b"nan", b'.').map(|value| value.unwrap().is_nan())), (Ok(None), Ok(true)));
        assert!(number_of(b" \"#N/A\" ", b',').is_ok_and(|value| value.is_some_and(f64::is_nan)));
        assert_eq!(header_text(b"\"H\xF6he\""), ("H\u{f6}he".to_owned(), true));
    }
}
