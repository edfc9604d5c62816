//! What a study leaves behind: a table as CSV and a picture as SVG, in `target/studies`.

use sideslip::io::outputs::charts::chart::{Marks, Panel, svg_with_marks};
use std::fmt::Write as _;
use std::path::PathBuf;

/// A table under way: a header and rows of cells.
pub(crate) struct Sheet {
    name: &'static str,
    text: String,
    columns: usize,
}

impl Sheet {
    /// An empty table; units stand in the column names.
    pub(crate) fn new(name: &'static str, columns: &[&str]) -> Self {
        Sheet { name, text: format!("{}\n", columns.join(",")), columns: columns.len() }
    }

    /// One row: words, then numbers; what is no number stays empty.
    pub(crate) fn row(&mut self, words: &[&str], numbers: &[f64]) {
        assert_eq!(words.len() + numbers.len(), self.columns, "{}: a row does not fit its header", self.name);
        let mut cells: Vec<String> = words.iter().map(|&word| word.to_owned()).collect();
        cells.extend(numbers.iter().map(|number| if number.is_finite() { format!("{number:.6}") } else { String::new() }));
        writeln!(self.text, "{}", cells.join(",")).unwrap();
    }

    /// Writes the table.
    pub(crate) fn write(&self) {
        write(&format!("{}.csv", self.name), &self.text);
    }
}

/// Draws the panels one below the other.
pub(crate) fn draw(name: &str, panels: &[(Panel, Vec<Marks>)]) {
    write(&format!("{name}.svg"), &svg_with_marks(panels).unwrap());
}

fn write(name: &str, text: &str) {
    let folder: PathBuf = [env!("CARGO_MANIFEST_DIR"), "target", "studies"].iter().collect();
    std::fs::create_dir_all(&folder).unwrap();
    std::fs::write(folder.join(name), text).unwrap();
    eprintln!("target/studies/{name}");
}
