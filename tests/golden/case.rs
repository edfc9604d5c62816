//! One case: a folder, the program run in it, and what it answered as numbers and words.
//!
//! The program runs in the case's own folder, where `replay` leads to the project's recordings, models and instruments: every
//! path in a call or an answer is then short and the same on every machine.

use super::document::{Document, keys, worded};
use super::drawing::drawing;
use super::expected::{KINDS, failure};
use super::log::{Whole, log};
use super::table::table;
use crate::support::program::{folder, own};
use std::fmt::Write;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

/// Bytes for the numbers and for the words of a JSON document.
const NUMBERS: usize = 7500;
const WORDS: usize = 6000;

/// Runs a case and compares both kinds, or renews what is to be renewed.
pub(crate) fn verify(name: &str, run: fn(&mut Case)) {
    let mut case = Case::new(name);
    run(&mut case);
    if case.skipped {
        return;
    }
    let texts = [&case.numbers, &case.words];
    // Both as found, beside what was written: to look at, or to put in the expectation's place.
    for (kind, text) in KINDS.into_iter().zip(texts) {
        std::fs::write(case.folder.join(format!("found.{kind}.txt")), text).unwrap();
    }
    let failures: Vec<String> = KINDS.into_iter().zip(texts).filter_map(|(kind, text)| failure(name, kind, text)).collect();
    assert!(
        failures.is_empty(),
        "{name}:\n{}\nAll that was found stands in {}. Where the difference is intended: SIDESLIP_RENEW=numbers (or words) and \
         this test again; see tests/golden/mod.rs.",
        failures.join("\n"),
        case.folder.display()
    );
}

/// The program: the one that was built for the test, or the one that is named.
pub(crate) fn program() -> PathBuf {
    match std::env::var_os("SIDESLIP_PROGRAM") {
        Some(named) => Path::new(&named).canonicalize().unwrap(),
        None => PathBuf::from(env!("CARGO_BIN_EXE_sideslip")),
    }
}

/// A case.
pub(crate) struct Case {
    pub(crate) folder: PathBuf,
    numbers: String,
    words: String,
    skipped: bool,
}

impl Case {
    fn new(name: &str) -> Self {
        let folder = folder(&format!("golden-{name}"));
        std::os::unix::fs::symlink(own("replay"), folder.join("replay")).unwrap();
        Case { folder, numbers: String::new(), words: String::new(), skipped: false }
    }

    /// Nothing is compared: what the case needs is absent, which was said.
    pub(crate) fn skip(&mut self) {
        self.skipped = true;
    }

    fn call(&self, args: &[&str]) -> Output {
        Command::new(program()).args(args).current_dir(&self.folder).output().unwrap()
    }

    /// Runs the program for what it writes; nothing of it is compared.
    pub(crate) fn prepare(&self, line: &str) {
        let args: Vec<&str> = line.split_whitespace().collect();
        let output = self.call(&args);
        assert!(output.status.success(), "{line}: {}", String::from_utf8_lossy(&output.stderr));
    }

    /// Runs the program; its exit status and what it says are compared. Words of the call are parted by white space.
    pub(crate) fn run(&mut self, line: &str) {
        let args: Vec<&str> = line.split_whitespace().collect();
        let output = self.call(&args);
        self.title(&format!("sideslip {}", args.join(" ")));
        let _ = writeln!(self.numbers, "exit status = {}", output.status.code().unwrap());
        self.said("standard output", &output.stdout);
        self.said("standard error", &output.stderr);
    }

    /// A heading in both texts.
    pub(crate) fn title(&mut self, title: &str) {
        let _ = writeln!(self.numbers, "== {title}");
        let _ = writeln!(self.words, "== {title}");
    }

    /// A number that the case itself has counted.
    pub(crate) fn number(&mut self, name: &str, value: impl std::fmt::Display) {
        let _ = writeln!(self.numbers, "{name} = {value}");
    }

    /// What was printed, verbatim.
    pub(crate) fn said(&mut self, whence: &str, bytes: &[u8]) {
        let text = self.tidied(std::str::from_utf8(bytes).unwrap());
        if !text.is_empty() {
            let _ = write!(self.words, "-- {whence}\n{text}");
        }
    }

    /// A text without what differs from place to place: this folder, the program's version.
    fn tidied(&self, text: &str) -> String {
        let canonical = self.folder.canonicalize().unwrap();
        let text = [&canonical, &self.folder]
            .into_iter()
            .fold(text.to_owned(), |text, folder| text.replace(folder.to_str().unwrap(), "{OUT}"));
        text.replace(concat!("sideslip ", env!("CARGO_PKG_VERSION")), "sideslip {VERSION}")
    }

    fn read(&self, name: &str) -> String {
        self.tidied(&std::fs::read_to_string(self.folder.join(name)).unwrap_or_else(|error| panic!("{name}: {error}")))
    }

    fn add(&mut self, name: &str, (numbers, words): (String, String)) {
        self.title(name);
        self.numbers.push_str(&numbers);
        self.words.push_str(&words);
    }

    /// A JSON file that was written, in so many bytes.
    pub(crate) fn json_within(&mut self, name: &str, budget: usize) {
        let mut whole: serde_json::Value = serde_json::from_str(&self.read(name)).unwrap();
        // The call, its files and the schema's units, for which `conformance::provenance` stands.
        if let Some(fields) = whole.as_object_mut() {
            fields.remove("provenance");
        }
        let document = Document::new(&whole);
        self.add(name, (document.numbers(budget), worded(&document.words, WORDS)));
    }

    /// A JSON file that was written.
    pub(crate) fn json(&mut self, name: &str) {
        self.json_within(name, NUMBERS);
    }

    /// An MCAP log that was written.
    pub(crate) fn log(&mut self, name: &str, whole: Whole) {
        let bytes = std::fs::read(self.folder.join(name)).unwrap();
        let found = log(&bytes, whole, |text| self.tidied(text));
        self.add(name, found);
    }

    /// A CSV that was written.
    pub(crate) fn table(&mut self, name: &str, with_rows: bool) {
        let found = table(&self.read(name), with_rows);
        self.add(name, found);
    }

    /// A TOML file that was written.
    pub(crate) fn keys(&mut self, name: &str) {
        let found = keys(&self.read(name));
        self.add(name, found);
    }

    /// An SVG or HTML file that was written.
    pub(crate) fn drawing(&mut self, name: &str) {
        let found = drawing(&self.read(name));
        self.add(name, found);
    }

    /// A file of bytes that was written.
    pub(crate) fn bytes(&mut self, name: &str) {
        let bytes = std::fs::read(self.folder.join(name)).unwrap();
        let told = format!("bytes = {}, sha256 {}\n", bytes.len(), super::digest::sha256(&bytes));
        self.add(name, (told, String::new()));
    }
}
