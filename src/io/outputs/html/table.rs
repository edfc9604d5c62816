//! Tables of a page: a name, a note above, column heads with units, a row head each.
//!
//! Consumes texts, which may come from files; produces HTML that a screen reader can walk: `aria-label`, `scope`. The first cell
//! of a row is its head. `+-` becomes one sign. A table without rows is no text.

use super::page::{attribute, words};
use std::fmt::{self, Display, Formatter};

/// What stands in a column.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ColumnKind {
    /// Numbers, to the right.
    Number,
    /// Words, to the left.
    Words,
}

/// A table as it is filled.
#[derive(Clone, Debug)]
pub struct HtmlTable {
    name: String,
    note: String,
    columns: Vec<(&'static str, ColumnKind)>,
    rows: Vec<Vec<String>>,
}

impl HtmlTable {
    /// A table without rows; the heads of its columns carry their units.
    pub fn new(name: &str, columns: &[(&'static str, ColumnKind)]) -> Self {
        HtmlTable { name: name.to_owned(), note: String::new(), columns: columns.to_vec(), rows: Vec::new() }
    }

    /// What its columns mean, as a sentence above it.
    pub fn note(mut self, note: &str) -> Self {
        note.clone_into(&mut self.note);
        self
    }

    /// Adds a row; a cell beyond the columns is left out, a missing one is empty.
    pub fn row(&mut self, cells: Vec<String>) {
        self.rows.push(cells);
    }

    /// Whether there is no row.
    pub fn is_empty(&self) -> bool {
        self.rows.is_empty()
    }
}

impl Display for HtmlTable {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        if self.is_empty() {
            return Ok(());
        }
        let class = |kind: ColumnKind| if kind == ColumnKind::Words { " class=\"words\"" } else { "" };
        if !self.note.is_empty() {
            writeln!(f, "<p class=\"faint\">{}.</p>", words(&self.note))?;
        }
        write!(f, "<div class=\"wide\"><table aria-label=\"{}\"><thead><tr>", attribute(&self.name))?;
        for (name, kind) in &self.columns {
            write!(f, "<th scope=\"col\"{}>{}</th>", class(*kind), words(name))?;
        }
        f.write_str("</tr></thead><tbody>\n")?;
        for row in &self.rows {
            f.write_str("<tr>")?;
            for (place, (_, kind)) in self.columns.iter().enumerate() {
                let cell = words(row.get(place).map_or("", String::as_str));
                match place {
                    0 => write!(f, "<th scope=\"row\">{cell}</th>")?,
                    _ => write!(f, "<td{}>{cell}</td>", class(*kind))?,
                }
            }
            f.write_str("</tr>\n")?;
        }
        f.write_str("</tbody></table></div>\n")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_table_names_its_rows_and_columns_and_holds_text_only() {
        let mut table =
            HtmlTable::new("Derivatives", &[("name", ColumnKind::Words), ("value, 1/s", ColumnKind::Number)]).note("+- one s.e");
        assert!(table.is_empty() && table.to_string().is_empty());
        table.row(vec!["<N_r>".into(), "-0.5 +- 0.1".into(), "beyond".into()]);
        table.row(vec!["L_p".into()]);
        let text = table.to_string();
        assert!(
            text.starts_with("<p class=\"faint\">\u{b1} one s.e.</p>") && text.contains("aria-label=\"Derivatives\""),
            "{text}"
        );
        assert!(text.contains("<th scope=\"row\">&lt;N_r&gt;</th><td>-0.5 \u{b1} 0.1</td></tr>"), "{text}");
        assert!(text.contains("<th scope=\"row\">L_p</th><td></td></tr>") && !text.contains("beyond"), "{text}");
        assert_eq!(text.matches("scope=\"col\"").count(), 2);
    }
}
