//! Dead files: every `.rs` file is reached by a `mod` from a root that Cargo builds.

use super::sources::{Source, code, files, none, root, rust};
use std::collections::{BTreeMap, BTreeSet};

/// Names of the modules that the code declares in other files, with the path that an attribute gives.
pub(crate) fn declared(text: &str) -> Vec<(String, Option<String>)> {
    let mut found = Vec::new();
    let mut path = None;
    for (line, whole) in code(text).lines().zip(text.lines()) {
        let mut line = line.trim();
        if line.starts_with("#[path") {
            path = whole.split('"').nth(1).map(str::to_owned);
            continue;
        }
        if let Some(rest) = line.strip_prefix("pub") {
            line = rest.trim_start();
            if let Some(rest) = line.strip_prefix('(') {
                line = rest.split_once(')').map_or("", |(_, rest)| rest.trim_start());
            }
        }
        if let Some(name) = line.strip_prefix("mod ").and_then(|rest| rest.strip_suffix(';')) {
            found.push((name.trim().to_owned(), path.take()));
        }
    }
    found
}

/// `a/./b/../c` as `a/c`.
fn plain(path: &str) -> String {
    let mut parts: Vec<&str> = Vec::new();
    for part in path.split('/') {
        match part {
            "." | "" => {}
            ".." => {
                parts.pop();
            }
            _ => parts.push(part),
        }
    }
    parts.join("/")
}

/// Where a declared module may stand; `beside` where the file keeps its modules beside it whatever its name: a crate's root, or a
/// file that a `#[path]` led to.
fn candidates(file: &str, beside: bool, name: &str, path: Option<&str>) -> Vec<String> {
    let (folder, own) = file.rsplit_once('/').unwrap_or(("", file));
    if let Some(path) = path {
        return vec![plain(&format!("{folder}/{path}"))];
    }
    let own = own.trim_end_matches(".rs");
    let beside = beside || own == "mod";
    let base = if beside { folder.to_owned() } else { format!("{folder}/{own}") };
    vec![format!("{base}/{name}.rs"), format!("{base}/{name}/mod.rs")]
}

/// Files that Cargo builds by itself.
fn is_root(path: &str, manifests: &str) -> bool {
    let program = path.contains("src/bin/") && path.ends_with("/main.rs");
    let by_rule = path.ends_with("src/lib.rs") || path.ends_with("src/main.rs") || path.ends_with("build.rs") || program;
    let test = match path.strip_prefix("tests/") {
        Some(below) => below.split_once('/').is_none_or(|(_, file)| file == "main.rs"),
        None => path.contains("/tests/"),
    };
    by_rule || test || path.contains("examples/") || manifests.contains(&format!("path = \"{path}\""))
}

fn unreached(sources: &[Source], manifests: &str) -> Vec<String> {
    let by_path: BTreeMap<&str, &str> = sources.iter().map(|source| (source.path.as_str(), source.text.as_str())).collect();
    let roots = by_path.keys().filter(|path| is_root(path, manifests));
    let mut open: Vec<(String, bool)> = roots.map(|&path| (path.to_owned(), true)).collect();
    let mut reached = BTreeSet::new();
    while let Some((file, beside)) = open.pop() {
        let Some(text) = by_path.get(file.as_str()) else { continue };
        if reached.insert(file.clone()) {
            for (name, path) in declared(text) {
                let found = candidates(&file, beside, &name, path.as_deref());
                open.extend(found.into_iter().map(|one| (one, path.is_some())));
            }
        }
    }
    by_path.keys().filter(|path| !reached.contains(**path)).map(|path| format!("{path}: no mod reaches it")).collect()
}

/// Files below src that are built for tests only: `#[cfg(test)] mod x;`.
pub(crate) fn of_tests() -> Vec<String> {
    let mut found = Vec::new();
    for source in files(&["src"], ".rs") {
        for after in code(&source.text).split("#[cfg(test)]").skip(1) {
            let declaration = after.trim_start().split('\n').next().unwrap_or_default();
            for (name, path) in declared(declaration) {
                let beside = source.path.ends_with("src/lib.rs") || source.path.ends_with("src/main.rs");
                found.extend(candidates(&source.path, beside, &name, path.as_deref()));
            }
        }
    }
    found
}

#[test]
fn every_file_is_reached() {
    let mut manifests = std::fs::read_to_string(root().join("Cargo.toml")).unwrap();
    // A package of its own, with its paths from its own folder.
    let fuzz = std::fs::read_to_string(root().join("tests/fuzz/Cargo.toml")).unwrap();
    manifests.push_str(&fuzz.replace("path = \"libfuzzer.rs\"", "path = \"tests/fuzz/libfuzzer.rs\""));
    none("dead files", &unreached(&rust(), &manifests));
}

#[test]
fn a_dead_file_is_caught() {
    let file = |path: &str, text: &str| Source { path: path.into(), text: text.into() };
    let sources = [
        file("src/lib.rs", "pub mod a;\n#[cfg(x)]\npub(crate) mod b;\n// mod dead;\n"),
        file("src/a/mod.rs", "mod c;\n"),
        file("src/a/c.rs", ""),
        file("src/b.rs", "mod d;"),
        file("src/b/d.rs", ""),
        file("src/dead.rs", ""),
        file("tests/x/main.rs", "#[path = \"../support/mod.rs\"]\nmod support;\n#[path = \"../kind/slow.rs\"]\nmod kind;\n"),
        file("tests/support/mod.rs", "mod s;\n"),
        file("tests/support/s.rs", ""),
        file("tests/support/t.rs", ""),
        file("tests/kind/slow.rs", "mod k;\n"),
        file("tests/kind/k.rs", ""),
        file("tests/bench/rate.rs", "mod b;\n"),
        file("tests/bench/b.rs", ""),
    ];
    let found = unreached(&sources, "path = \"tests/bench/rate.rs\"");
    assert_eq!(found, ["src/dead.rs: no mod reaches it", "tests/support/t.rs: no mod reaches it"]);
}
