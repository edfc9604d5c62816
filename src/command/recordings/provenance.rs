//! Where an answer comes from: the program's version, the call, every file read with its SHA-256, the date of each flight.
//!
//! Consumes the names of the files that a command reads and what runs say of their date; produces the same block for a JSON
//! document, the foot of a page and the head of a log. A file that cannot be read twice (a pipe) has no hash; what is no file
//! (the built-in model) is left out; of a folder its files are listed.

use crate::command::options::replace_option::ReplaceOption;
use crate::command::terminal::output_file::write_json;
use serde_json::{Value, json};
use sha2::{Digest, Sha256};
use sideslip::error::Failure;
use sideslip::io::outputs::html::page::{FOOT, escaped};
use sideslip::io::outputs::html::table::{ColumnKind, HtmlTable};
use sideslip::io::outputs::json::document_schema::DocumentSchema;
use sideslip::io::outputs::log::mcap_log::program;
use std::collections::BTreeMap;
use std::ffi::OsStr;
use std::fs::File;
use std::path::{Path, PathBuf};

/// Key of the block in every JSON document.
const KEY: &str = "provenance";

#[derive(Clone, Debug)]
struct SourceFile {
    name: PathBuf,
    /// In hexadecimal digits; none of what is no regular file.
    sha256: Option<String>,
    bytes: Option<u64>,
    recorded_at: Option<String>,
}

/// The call and the files of one answer.
#[derive(Clone, Debug, Default)]
pub(crate) struct Provenance {
    files: Vec<SourceFile>,
}

impl Provenance {
    /// Of a call that reads these files; each is listed once.
    pub(crate) fn of(files: impl IntoIterator<Item = PathBuf>) -> Self {
        let mut all = Provenance::default();
        for file in files {
            if file.is_dir() {
                let mut inside: Vec<PathBuf> =
                    std::fs::read_dir(&file).into_iter().flatten().flatten().map(|entry| entry.path()).collect();
                inside.retain(|path| path.is_file());
                inside.sort();
                inside.iter().for_each(|path| all.add(path));
            } else if file.exists() {
                all.add(&file);
            }
        }
        all
    }

    fn add(&mut self, file: &Path) {
        if self.files.iter().any(|known| known.name == file) {
            return;
        }
        let (sha256, bytes) = hashed(file).unzip();
        self.files.push(SourceFile { name: file.to_owned(), sha256, bytes, recorded_at: None });
    }

    /// Adds the date that the run of a file states; of several parts of a file, of the earliest.
    pub(crate) fn dated(mut self, file: &Path, recorded_at: Option<&str>) -> Self {
        let Some(at) = recorded_at else { return self };
        for known in self.files.iter_mut().filter(|known| known.name == file || known.name.starts_with(file)) {
            if known.recorded_at.as_deref().is_none_or(|before| at < before) {
                known.recorded_at = Some(at.to_owned());
            }
        }
        self
    }

    /// For a program; the schema names the document and gives its units.
    fn document(&self, schema: Option<DocumentSchema>) -> Value {
        let mut document = json!({ "program": program(), "command_line": command_line(), "files": self.listed() });
        if let Some(schema) = schema {
            document["schema"] = json!(schema.name());
            document["units"] = json!(schema.units());
        }
        document
    }

    fn listed(&self) -> Value {
        let one = |file: &SourceFile| {
            let name = file.name.display().to_string();
            json!({ "file": name, "sha256": file.sha256, "bytes": file.bytes, "recorded_at": file.recorded_at })
        };
        self.files.iter().map(one).collect()
    }

    /// For the head of a log, a text each.
    pub(crate) fn origin(&self) -> BTreeMap<String, String> {
        BTreeMap::from([("command_line".to_owned(), command_line()), ("files".to_owned(), self.listed().to_string())])
    }

    /// The origin of a log whose samples came from another process, whose files stay listed.
    pub(crate) fn origin_after(&self, before: &BTreeMap<String, String>) -> BTreeMap<String, String> {
        let mut origin = self.origin();
        origin.extend(before.get("files").map(|files| ("files".to_owned(), files.clone())));
        origin
    }

    /// The text of a JSON object with the block as its first key; numbers keep every digit.
    pub(crate) fn in_front_of(&self, text: &str, schema: Option<DocumentSchema>) -> String {
        let Some(rest) = text.strip_prefix('{') else { return text.to_owned() };
        let comma = if rest.trim_start().starts_with('}') { "" } else { "," };
        if rest.starts_with('\n') {
            let block = format!("{:#}", self.document(schema)).replace('\n', "\n  ");
            format!("{{\n  \"{KEY}\": {block}{comma}{rest}")
        } else {
            format!("{{\"{KEY}\":{}{comma}{rest}", self.document(schema))
        }
    }

    /// Writes a JSON document with the block in it: to standard output where the path is `-`.
    pub(crate) fn write_json(&self, path: &Path, schema: DocumentSchema, text: &str) -> Result<(), Failure> {
        write_json(path, &self.in_front_of(text, Some(schema)))
    }

    /// A page with the block at its end.
    pub(crate) fn at_the_foot_of(&self, page: &str) -> String {
        let columns = [
            ("file", ColumnKind::Words),
            ("SHA-256", ColumnKind::Words),
            ("bytes", ColumnKind::Number),
            ("date of the flight", ColumnKind::Words),
        ];
        let mut files = HtmlTable::new("Files", &columns);
        for file in &self.files {
            files.row(vec![
                file.name.display().to_string(),
                file.sha256.clone().unwrap_or_else(|| "not a regular file".to_owned()),
                file.bytes.map(|bytes| bytes.to_string()).unwrap_or_default(),
                file.recorded_at.clone().unwrap_or_else(|| "not stated".to_owned()),
            ]);
        }
        let body = page.strip_suffix(FOOT).unwrap_or(page);
        format!(
            "{body}<footer>\n<h2>Provenance</h2>\n<p>{}, called as <code>{}</code></p>\n{files}</footer>\n{FOOT}",
            escaped(&program()),
            escaped(&command_line())
        )
    }
}

/// SHA-256 and size of a regular file; `None` of any other, and of one that cannot be read.
fn hashed(file: &Path) -> Option<(String, u64)> {
    // Opening a pipe waits for who writes it, and the one that was read has none any more.
    let mut opened = file.metadata().is_ok_and(|found| found.is_file()).then(|| File::open(file).ok())??;
    let mut digest = Sha256::new();
    let mut block = vec![0; 1 << 16];
    let mut bytes = 0;
    loop {
        let count = std::io::Read::read(&mut opened, &mut block).ok()?;
        let Some(read) = block.get(..count).filter(|read| !read.is_empty()) else { break };
        digest.update(read);
        bytes += count as u64;
    }
    Some((digest.finalize().iter().map(|byte| format!("{byte:02x}")).collect(), bytes))
}

/// The call as a shell takes it, without `--force`: what stood in the place of a result has no part in it, and a rerun that
/// replaces it gives the same bytes.
fn command_line() -> String {
    let mut names_follow = false;
    let given = std::env::args_os().skip(1).filter(|word| {
        names_follow |= word == "--";
        names_follow || word != ReplaceOption::FORCE
    });
    std::iter::once("sideslip".to_owned()).chain(given.map(|word| quoted(&word))).collect::<Vec<_>>().join(" ")
}

fn quoted(word: &OsStr) -> String {
    let word = word.to_string_lossy();
    let plain = |letter: char| letter.is_alphanumeric() || "-_./:=,+@%".contains(letter);
    if !word.is_empty() && word.chars().all(plain) { word.into_owned() } else { format!("'{}'", word.replace('\'', "'\\''")) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_block_stands_first_in_a_document_of_either_form_and_changes_no_digit() {
        let provenance = Provenance::default();
        for text in ["{\n  \"x\": 0.1234567890123456789\n}\n", "{\"x\":0.1234567890123456789}\n", "{}\n"] {
            let whole = provenance.in_front_of(text, None);
            let read: Value = serde_json::from_str(&whole).unwrap();
            assert_eq!(read["provenance"]["program"], program());
            assert!(text == "{}\n" || whole.contains("0.1234567890123456789"), "{whole}");
        }
        assert_eq!(provenance.in_front_of("[1]", None), "[1]");
    }

    #[test]
    fn a_word_of_the_call_is_quoted_where_a_shell_would_part_it() {
        let cases = [("a.csv", "a.csv"), ("a b", "'a b'"), ("it's", "'it'\\''s'"), ("", "''"), ("x={1}", "'x={1}'")];
        for (word, expected) in cases {
            assert_eq!(quoted(OsStr::new(word)), expected);
        }
    }
}
