//! The real program, run as a user runs it, and files to run it on.

use serde_json::Value;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

/// Runs the program to its end.
pub(crate) fn sideslip(args: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_sideslip")).args(args).output().unwrap()
}

/// What a command came to: exit status, standard output, standard error.
pub(crate) fn ended(output: &Output) -> (i32, String, String) {
    let text = |bytes: &[u8]| String::from_utf8(bytes.to_vec()).unwrap();
    (output.status.code().unwrap(), text(&output.stdout), text(&output.stderr))
}

/// The text of a document without `provenance`, its first key, which differs from call to call.
pub(crate) fn without_provenance(text: &str) -> String {
    let block = text.split_once("\n  },\n").filter(|(block, _)| block.starts_with("{\n  \"provenance\": {"));
    let rest = block.unwrap_or_else(|| panic!("expected a document that begins with its provenance, found {text:.200}")).1;
    format!("{{\n{rest}")
}

/// `replay` of one file with `--json -`: exit status, the first run of the answer, standard error.
pub(crate) fn replayed(file: &Path, more: &[&str]) -> (i32, Value, String) {
    let mut args = vec!["replay", path(file), "--json", "-"];
    args.extend(more);
    let (status, out, said) = ended(&sideslip(&args));
    let answer: Value = serde_json::from_str(&out).unwrap_or_default();
    (status, answer["runs"][0].clone(), said)
}

/// Whether any warning of a run has all of these words.
pub(crate) fn warns(run: &Value, words: &[&str]) -> bool {
    let warnings = run["warnings"].as_array().unwrap();
    warnings.iter().any(|warning| words.iter().all(|word| warning.as_str().unwrap().contains(word)))
}

/// A path as an argument.
pub(crate) fn path(path: &Path) -> &str {
    path.to_str().unwrap()
}

/// An empty folder of its own for a test.
pub(crate) fn folder(name: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
    let _ = std::fs::remove_dir_all(&folder);
    std::fs::create_dir_all(&folder).unwrap();
    folder
}

/// A file of the project.
pub(crate) fn own(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join(name)
}

/// The recording that comes with the project.
pub(crate) fn puma() -> PathBuf {
    own("replay/recordings/puma-100kn-pedal-3211.csv")
}

/// A real recording of a flight; `None`, said loudly, where it is absent.
pub(crate) fn real(name: &str) -> Option<PathBuf> {
    data("flight", name)
}

/// A file of a folder of real recordings; `None`, said loudly, where it is absent.
pub(crate) fn data(folder: &str, name: &str) -> Option<PathBuf> {
    let root = std::env::var_os("SIDESLIP_DATA").map_or_else(|| own("../shared/data"), PathBuf::from);
    let file = root.join(folder).join(name);
    if !file.is_file() {
        eprintln!("SKIPPED: no recording {}", file.display());
        return None;
    }
    Some(file)
}

/// A run file as preamble, header and rows of cells, to be damaged.
pub(crate) struct RunFile {
    pub(crate) preamble: Vec<String>,
    pub(crate) header: Vec<String>,
    pub(crate) rows: Vec<Vec<String>>,
}

impl RunFile {
    /// Reads a plain CSV.
    pub(crate) fn read(file: &Path) -> Self {
        let text = std::fs::read_to_string(file).unwrap();
        let cells = |line: &str| line.split(',').map(str::to_owned).collect::<Vec<_>>();
        let (preamble, table): (Vec<&str>, Vec<&str>) = text.lines().partition(|line| line.starts_with('#'));
        RunFile {
            preamble: preamble.into_iter().map(str::to_owned).collect(),
            header: cells(table[0]),
            rows: table[1..].iter().map(|line| cells(line)).collect(),
        }
    }

    /// The place of a column.
    pub(crate) fn place(&self, name: &str) -> usize {
        self.header.iter().position(|found| found == name).unwrap()
    }

    /// Takes a column out.
    pub(crate) fn without(mut self, name: &str) -> Self {
        let place = self.place(name);
        self.header.remove(place);
        self.rows.iter_mut().for_each(|row| drop(row.remove(place)));
        self
    }

    /// As text.
    pub(crate) fn text(&self) -> String {
        let mut text = String::new();
        for line in &self.preamble {
            text.push_str(line);
            text.push('\n');
        }
        for row in std::iter::once(&self.header).chain(&self.rows) {
            text.push_str(&row.join(","));
            text.push('\n');
        }
        text
    }

    /// Writes it.
    pub(crate) fn write(&self, file: &Path) {
        std::fs::write(file, self.text()).unwrap();
    }
}

/// The names of the files in a folder, in order.
pub(crate) fn files_in(folder: &Path) -> Vec<String> {
    let mut names: Vec<_> =
        std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect();
    names.sort();
    names
}
