//! Tables of numbers: run files and other CSV.

use super::digest::{sha256, spread};
use super::document::keys;
use std::fmt::Write;

/// Rows that are written out, and stretches of rows that are hashed each by itself.
const ROWS: usize = 5;
const STRETCHES: usize = 8;

/// A CSV: preamble, header, number of rows, hashes, and some rows; without rows where they are not ours to pass on.
pub(crate) fn table(text: &str, with_rows: bool) -> (String, String) {
    let (preamble, table): (Vec<&str>, Vec<&str>) = text.lines().partition(|line| line.starts_with('#'));
    let preamble: Vec<&str> = preamble.into_iter().map(|line| line.trim_start_matches('#')).collect();
    let (mut numbers, words) = keys(&preamble.join("\n"));
    let (header, rows) = table.split_first().map_or(("", [].as_slice()), |(header, rows)| (*header, rows));
    let _ = writeln!(numbers, "columns = {header}\nrows = {}, sha256 {}", rows.len(), sha256(rows.join("\n")));
    numbers.push_str(&stretches(rows, "rows"));
    if with_rows {
        for i in spread(rows.len(), ROWS) {
            let _ = writeln!(numbers, "row[{i}] = {}", rows[i]);
        }
    }
    (numbers, words)
}

/// A hash for each of some stretches, so that a difference can be located.
pub(crate) fn stretches(entries: &[impl AsRef<str>], name: &str) -> String {
    let size = entries.len().div_ceil(STRETCHES).max(1);
    let mut text = String::new();
    for (place, stretch) in entries.chunks(size).enumerate() {
        let whole: String = stretch.iter().flat_map(|entry| [entry.as_ref(), "\n"]).collect();
        let (from, to) = (place * size, place * size + stretch.len() - 1);
        let _ = writeln!(text, "{name} {from} to {to} = sha256 {}", sha256(whole));
    }
    text
}

#[test]
fn an_altered_digit_in_any_row_shows() {
    let rows = |altered: Option<usize>| -> String {
        (0..100).map(|i| if Some(i) == altered { format!("{i},0.51\n") } else { format!("{i},0.5\n") }).collect()
    };
    let text = |altered| table(&format!("# run = \"a b\"\n# seed = 3\ntime,x\n{}", rows(altered)), true);
    let (numbers, words) = text(None);
    assert!(numbers.starts_with("run = <words>\nseed = 3\ncolumns = time,x\nrows = 100, sha256 "), "{numbers}");
    assert_eq!(words, "run = \"a b\"\n");
    assert!((0..100).all(|i| text(Some(i)).0 != numbers));
}
