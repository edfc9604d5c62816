//! The source tree as text: which files there are, and a file's code without comments, strings and its own tests.

use std::fs;
use std::path::{Path, PathBuf};

/// The package's root.
pub(crate) fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// One file.
pub(crate) struct Source {
    /// Path from the root, with `/`.
    pub(crate) path: String,
    /// All of it.
    pub(crate) text: String,
}

/// Every file below the folders (or the files themselves) whose name ends so, in order of path.
pub(crate) fn files(places: &[&str], ending: &str) -> Vec<Source> {
    let mut paths = Vec::new();
    for place in places {
        collect(&root().join(place), ending, &mut paths);
    }
    paths.sort();
    let read = |path: PathBuf| {
        let text = fs::read_to_string(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
        let path = path.strip_prefix(root()).unwrap().to_string_lossy().replace('\\', "/");
        Source { path, text }
    };
    paths.into_iter().map(read).collect()
}

fn collect(place: &Path, ending: &str, paths: &mut Vec<PathBuf>) {
    if place.is_file() {
        if place.to_string_lossy().ends_with(ending) {
            paths.push(place.to_owned());
        }
        return;
    }
    // A folder that is not there yet has no files.
    for entry in fs::read_dir(place).into_iter().flatten() {
        let path = entry.unwrap().path();
        if path.file_name().is_some_and(|name| name != "target") {
            collect(&path, ending, paths);
        }
    }
}

/// The Rust files that the project is made of.
pub(crate) fn rust() -> Vec<Source> {
    files(&["src", "tests", "replay", "firmware-profile"], ".rs")
}

/// The code alone: comments and the contents of strings blanked, line by line as before.
pub(crate) fn code(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    let mut rest = text;
    while let Some(c) = rest.chars().next() {
        let named = out.ends_with(|c: char| c.is_alphanumeric() || c == '_');
        let skipped = if rest.starts_with("//") {
            rest.find('\n').unwrap_or(rest.len())
        } else if c == '"' {
            end_of_string(rest)
        } else if rest.starts_with("r#\"") && !named {
            rest.find("\"#").map_or(rest.len(), |end| end + 2)
        } else if rest.starts_with("'\"'") {
            // A quote as a character would open a string.
            3
        } else {
            out.push(c);
            rest = &rest[c.len_utf8()..];
            continue;
        };
        if !rest.starts_with("//") {
            out.push_str("\"\"");
        }
        out.extend(rest[..skipped].chars().filter(|&c| c == '\n'));
        rest = &rest[skipped..];
    }
    out
}

/// Length of the string literal that the text begins with.
fn end_of_string(text: &str) -> usize {
    let mut escaped = false;
    for (at, c) in text.char_indices().skip(1) {
        match c {
            _ if escaped => escaped = false,
            '\\' => escaped = true,
            '"' => return at + 1,
            _ => {}
        }
    }
    text.len()
}

/// The code that is built without tests: without the items below a `#[cfg(test)]`.
pub(crate) fn built(text: &str) -> String {
    let code = code(text);
    let mut parts = code.split("#[cfg(test)]");
    let mut own = parts.next().unwrap_or_default().to_owned();
    for part in parts {
        own.push_str(part[end_of_item(part)..].trim_start_matches('\n'));
    }
    own
}

/// Length of the item that the code begins with: to its semicolon or to the end of its braces.
fn end_of_item(code: &str) -> usize {
    let mut depth = 0;
    for (at, c) in code.char_indices() {
        let is_literal = code[..at].ends_with('\'') && code[at + c.len_utf8()..].starts_with('\'');
        match c {
            _ if is_literal => {}
            '{' => depth += 1,
            '}' if depth <= 1 => return at + 1,
            '}' => depth -= 1,
            ';' if depth == 0 => return at + 1,
            _ => {}
        }
    }
    code.len()
}

/// Fails with one line for every finding.
pub(crate) fn none(rule: &str, findings: &[String]) {
    assert!(findings.is_empty(), "{rule}:\n  {}", findings.join("\n  "));
}

#[test]
fn comments_and_strings_are_no_code() {
    let text =
        "let a = \"use crate::x; // no\"; // crate::y\nlet b = '\"'; let c = r#\"a \"b\" c\"#;\n#[cfg(test)]\nmod tests {}\n";
    let own = "let a = \"\"; \nlet b = \"\"; let c = \"\";\n";
    assert_eq!(code(text), format!("{own}#[cfg(test)]\nmod tests {{}}\n"));
    assert_eq!(built(text), own);
    let between = "#[cfg(test)]\nmod x;\nlet a = 1;\n#[cfg(test)]\nmod tests { let b = ('{', ';'); { } }\nlet c = 2;\n";
    assert_eq!(built(between), "let a = 1;\nlet c = 2;\n", "only the items of tests are left out");
}

#[test]
fn the_tree_is_found() {
    let sources = rust();
    assert!(sources.iter().any(|source| source.path == "src/lib.rs"));
    assert!(sources.iter().any(|source| source.path == "tests/tidy/sources.rs"));
}
