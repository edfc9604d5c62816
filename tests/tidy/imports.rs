//! Direction of imports: data flows one way, so a module imports only what `src/guide/imports.md` grants it.

use super::sources::{Source, built, files, none, root};
use std::collections::BTreeMap;
use std::fs;

/// What a module may import: a top-level module (`flight`), a module or a file (`realtime::estimation::record`).
type Grants = BTreeMap<String, Vec<String>>;

/// Heading of the page's other table, that of cycles.
pub(crate) const CYCLES: &str = "## Import cycles inside a folder";

/// Reads the table: rows `| module | may import |`, both cells code words.
fn grants(page: &str) -> Grants {
    let words = |cell: &str| -> Vec<String> { cell.split('`').skip(1).step_by(2).map(str::to_owned).collect() };
    let mut grants = Grants::new();
    let modules = page.lines().take_while(|&line| line != CYCLES);
    for line in modules.filter(|line| line.starts_with("| `")) {
        let cells: Vec<&str> = line.split('|').collect();
        for module in words(cells[1]) {
            grants.insert(module, words(cells[2]));
        }
    }
    grants
}

/// Whether the path lies in the module.
fn within(path: &str, module: &str) -> bool {
    path.strip_prefix(module).is_some_and(|rest| rest.is_empty() || rest.starts_with("::"))
}

/// Every path in the code that begins at the crate, whole (`["flight", "run", "RunGeometry"]`).
///
/// `module` is the file's own module path, so that `super::` can be followed.
pub(crate) fn imported(code: &str, module: &[&str]) -> Vec<Vec<String>> {
    let mut found = Vec::new();
    for (at, _) in code.match_indices("crate::") {
        if !follows_name(code, at) {
            expand(&code[at + "crate::".len()..], &[], &mut found);
        }
    }
    for (at, _) in code.match_indices("super::") {
        if follows_name(code, at) || code[..at].ends_with("super::") {
            continue;
        }
        let mut rest = &code[at..];
        let mut base = module;
        while let Some(after) = rest.strip_prefix("super::") {
            rest = after;
            base = base.split_last().map_or(&[], |(_, upper)| upper);
        }
        let base: Vec<String> = base.iter().map(|&name| name.to_owned()).collect();
        expand(rest, &base, &mut found);
    }
    found
}

fn follows_name(code: &str, at: usize) -> bool {
    code[..at].chars().next_back().is_some_and(|c| c.is_alphanumeric() || c == '_' || c == '$')
}

/// Follows a path or a tree of them in braces to its ends.
fn expand(text: &str, base: &[String], found: &mut Vec<Vec<String>>) {
    let text = text.trim_start();
    if let Some(inside) = text.strip_prefix('{') {
        let (mut depth, mut begin) = (0, 0);
        for (i, c) in inside.char_indices() {
            match c {
                '{' => depth += 1,
                '}' if depth > 0 => depth -= 1,
                ',' | '}' if depth == 0 => {
                    if !inside[begin..i].trim().is_empty() {
                        expand(&inside[begin..i], base, found);
                    }
                    begin = i + 1;
                    if c == '}' {
                        return;
                    }
                }
                _ => {}
            }
        }
        return;
    }
    let name: String = text.chars().take_while(|c| c.is_alphanumeric() || *c == '_').collect();
    let mut path = base.to_vec();
    if !name.is_empty() && name != "self" {
        path.push(name.clone());
    }
    match text[name.len()..].strip_prefix("::") {
        Some(rest) if !name.is_empty() => expand(rest, &path, found),
        _ => found.push(path),
    }
}

/// The module path of a file below src: `src/io/bus/mod.rs` is `[io, bus]`.
pub(crate) fn module_of(path: &str) -> Vec<&str> {
    let inner = path.trim_start_matches("src/").trim_end_matches(".rs");
    inner.split('/').filter(|name| !matches!(*name, "mod" | "lib" | "main")).collect()
}

/// What the file imports and may not. The row of the smallest module that the file lies in counts; a module is no concern of
/// others where it has no row of its own.
fn breaches(source: &Source, grants: &Grants) -> Vec<String> {
    let module = module_of(&source.path);
    let own = module.join("::");
    let Some(&wing) = module.first() else { return Vec::new() };
    let Some((row, may)) = grants.iter().filter(|(row, _)| within(&own, row)).max_by_key(|(row, _)| row.len()) else {
        return vec![format!("{}: {wing} is not in the table", source.path)];
    };
    if may.iter().any(|grant| grant == "everything") {
        return Vec::new();
    }
    imported(&built(&source.text), &module)
        .into_iter()
        .filter(|path| path.first().is_some_and(|first| grants.keys().any(|row| within(row, first))))
        .map(|path| path.join("::"))
        .filter(|path| !within(path, row) && !may.iter().any(|grant| within(path, grant)))
        .map(|path| format!("{}: {row} imports {path}, which it may not", source.path))
        .collect()
}

fn table() -> Grants {
    grants(&fs::read_to_string(root().join("src/guide/imports.md")).unwrap())
}

#[test]
fn every_module_imports_only_what_the_table_permits() {
    let grants = table();
    let of_tests = super::reached::of_tests();
    assert!(grants.len() > 10, "the table was read: {grants:?}");
    let findings: Vec<String> = files(&["src"], ".rs")
        .iter()
        .filter(|source| !of_tests.contains(&source.path))
        .flat_map(|source| breaches(source, &grants))
        .collect();
    none("imports against the table in src/guide/imports.md", &findings);
}

#[test]
fn every_command_has_its_row() {
    let grants = table();
    let commands = fs::read_dir(root().join("src/command")).unwrap().map(|entry| entry.unwrap());
    let folders = commands.filter(|entry| entry.file_type().unwrap().is_dir());
    let modules = folders.map(|entry| format!("command::{}", entry.file_name().to_string_lossy()));
    let missing: Vec<String> = modules.filter(|module| !grants.contains_key(module)).collect();
    none("commands without a row in src/guide/imports.md", &missing);
}

#[test]
fn the_player_knows_pace_only_and_the_firmware_only_the_core() {
    let manifest = fs::read_to_string(root().join("replay/Cargo.toml")).unwrap();
    assert!(!manifest.contains("sideslip ="), "replay depends on the library");
    let mut findings: Vec<String> = files(&["replay/src"], ".rs")
        .iter()
        .filter(|source| built(&source.text).contains("sideslip::"))
        .map(|source| format!("{}: the player imports the library", source.path))
        .collect();
    let manifest = fs::read_to_string(root().join("firmware-profile/Cargo.toml")).unwrap();
    let dependency = manifest.lines().find(|line| line.starts_with("sideslip =")).unwrap();
    assert!(dependency.contains("default-features = false") && !dependency.contains("features = [\"std\""));
    let may = table().remove("firmware-profile").unwrap();
    for source in files(&["firmware-profile/src"], ".rs") {
        let code = built(&source.text).replace("sideslip::", "crate::");
        for path in imported(&code, &[]) {
            let known = path.first().is_some_and(|first| table().contains_key(first));
            if known && !may.iter().any(|grant| within(&path.join("::"), grant)) {
                findings.push(format!("{}: imports {}", source.path, path.join("::")));
            }
        }
    }
    none("members against the table", &findings);
}

#[test]
fn a_forbidden_import_is_caught() {
    let grants = grants(
        "| `num` | |\n| `flight` | `num` |\n| `a` | `flight`, `b::record` |\n| `a::late` | `a::early::record` |\n| `b` | |\n| `c` | `everything` |\n",
    );
    let tried = |path: &str, text: &str| breaches(&Source { path: path.into(), text: text.into() }, &grants).len();
    assert_eq!(tried("src/a/x.rs", "use crate::flight::run::R;\nuse super::y;\nuse crate::b::record::{P, Q};"), 0);
    assert_eq!(tried("src/a/x.rs", "use crate::b::filter::F;"), 1, "only the published vocabulary");
    assert_eq!(tried("src/a/x.rs", "use crate::b::{record::P, filter::{F, G}, self};"), 3);
    assert_eq!(tried("src/a/x.rs", "use crate::{flight, b::record, c::z};"), 1, "a tree in braces");
    assert_eq!(tried("src/a/mod.rs", "use super::b::filter;"), 1, "out by the back door");
    assert_eq!(tried("src/a/x/y.rs", "fn f() -> super::super::super::c::Z;"), 1);
    assert_eq!(tried("src/a/x.rs", "let f = crate::c::f();"), 1, "a path in the middle of code");
    assert_eq!(tried("src/num/x.rs", "use crate::flight::unit;"), 1);
    assert_eq!(tried("src/a/late/x.rs", "use crate::a::early::record::R; use super::y;"), 0);
    assert_eq!(
        tried("src/a/late/x.rs", "use crate::a::early::{filter::F, record}; use crate::flight::run;"),
        2,
        "a module in a module"
    );
    assert_eq!(tried("src/a/x.rs", "use super::late::y;"), 0, "the row of a module covers the modules in it");
    assert_eq!(tried("src/c/x.rs", "use crate::a::x;"), 0);
    assert_eq!(tried("src/d.rs", ""), 1, "a module that the table does not know");
    assert_eq!(tried("src/a/x.rs", "// crate::c\n#[cfg(test)]\nmod tests { use crate::c::z; }"), 0);
    assert_eq!(tried("src/a/x.rs", "use other_crate::c::z;"), 0);
}
