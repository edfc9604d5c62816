//! Import cycles: files that import each other, directly or on the way through others.
//!
//! A file imports what it names of another: in `use` lines and in the middle of code, from the crate's root, from an upper module
//! or from one that it declares itself. A name that a file only hands on (`pub use`) is imported from where it is defined; to
//! hand it on is an import too. A cycle is a strongly connected component of more than one file: across folders it is refused,
//! inside of one folder it has its row in `src/guide/imports.md`. A file's own tests are exempt.

use super::imports::{CYCLES, imported, module_of};
use super::reached::{declared, of_tests};
use super::sources::{Source, built, files, none, root};
use std::collections::{BTreeMap, BTreeSet};
use std::fs;

/// One file: its module, its folder, and what stands in it.
struct Module {
    path: String,
    folder: String,
    imports: Vec<Vec<String>>,
    /// Names handed on, each with the path that it is known by there.
    handed_on: BTreeMap<String, Vec<String>>,
}

/// Files by module path.
type Modules = BTreeMap<Vec<String>, Module>;

fn is_name(c: char) -> bool {
    c.is_alphanumeric() || c == '_'
}

/// The trees of the `use` lines, with whether they hand on what they name.
fn use_lines(code: &str) -> Vec<(bool, &str)> {
    let mut found = Vec::new();
    for (at, _) in code.match_indices("use ") {
        let line = code[..at].rsplit('\n').next().unwrap_or_default().trim();
        let public = line.starts_with("pub");
        if line.is_empty() || public && line.len() < "pub(in crate::)".len() {
            found.push((public, code[at + "use ".len()..].split(';').next().unwrap_or_default()));
        }
    }
    found
}

/// Ends of a tree of names, each a whole path from the crate: `super::a::{self, B}` in `[x, y]` is `[x, a]` and `[x, a, B]`.
fn ends(tree: &str, module: &[&str], children: &BTreeSet<String>) -> Vec<Vec<String>> {
    let first: String = tree.trim_start().chars().take_while(|&c| is_name(c)).collect();
    let whole = match first.as_str() {
        "crate" | "super" => tree.trim_start().to_owned(),
        "self" => from_own(module, tree.trim_start().trim_start_matches("self::")),
        _ if children.contains(&first) => from_own(module, tree.trim_start()),
        _ => return Vec::new(),
    };
    imported(&whole, module)
}

/// The path below this module as one from the crate.
fn from_own(module: &[&str], below: &str) -> String {
    let own: String = module.iter().flat_map(|&name| [name, "::"]).collect();
    format!("crate::{own}{below}")
}

/// Paths in the middle of code that begin at a module which the file declares: `child::f()`.
fn through_children(code: &str, module: &[&str], children: &BTreeSet<String>) -> Vec<Vec<String>> {
    let mut found = Vec::new();
    for child in children.iter().map(String::as_str).chain(["self"]) {
        for (at, _) in code.match_indices(&format!("{child}::")) {
            let before = code[..at].chars().next_back();
            if before.is_none_or(|c| !is_name(c) && c != ':') {
                found.extend(ends(&code[at..], module, children));
            }
        }
    }
    found
}

fn module(source: &Source, folders: &BTreeSet<String>) -> (Vec<String>, Module) {
    let code = built(&source.text).replace("$crate", "crate");
    let module = module_of(&source.path);
    let children: BTreeSet<String> = declared(&code).into_iter().map(|(name, _)| name).collect();
    let mut imports = imported(&code, &module);
    imports.extend(through_children(&code, &module, &children));
    let mut handed_on = BTreeMap::new();
    for (public, tree) in use_lines(&code) {
        let paths = ends(tree, &module, &children);
        if public {
            handed_on.extend(paths.iter().filter_map(|path| Some((path.last()?.clone(), path.clone()))));
        }
        imports.extend(paths);
    }
    // The modules of a file lie in its folder: `a/b.rs` and `a/b/c.rs` are one module.
    let mut folder = source.path.rsplit_once('/').map_or("", |(folder, _)| folder);
    while folders.contains(&format!("{folder}.rs")) {
        folder = folder.rsplit_once('/').map_or("", |(upper, _)| upper);
    }
    let names = module.iter().map(|&name| name.to_owned()).collect();
    (names, Module { path: source.path.clone(), folder: folder.to_owned(), imports, handed_on })
}

/// The module that defines what the path names: the longest beginning that is a file, or from where that hands the name on.
fn defined_in(path: &[String], modules: &Modules, steps: usize) -> Option<Vec<String>> {
    let length = (1..=path.len()).rev().find(|&length| modules.contains_key(&path[..length]))?;
    let (file, rest) = path.split_at(length);
    let further = rest.first().and_then(|name| modules[file].handed_on.get(name));
    match further {
        Some(further) if steps > 0 => defined_in(further, modules, steps - 1),
        _ => Some(file.to_vec()),
    }
}

/// Strongly connected components of more than one node, after Tarjan (1972).
struct Components<'a> {
    arrows: &'a [Vec<usize>],
    order: Vec<Option<usize>>,
    low: Vec<usize>,
    stack: Vec<usize>,
    visited: usize,
    found: Vec<Vec<usize>>,
}

impl Components<'_> {
    fn of(arrows: &[Vec<usize>]) -> Vec<Vec<usize>> {
        let none = vec![None; arrows.len()];
        let low = vec![0; arrows.len()];
        let mut all = Components { arrows, order: none, low, stack: Vec::new(), visited: 0, found: Vec::new() };
        for node in 0..arrows.len() {
            if all.order[node].is_none() {
                all.visit(node);
            }
        }
        all.found
    }

    fn visit(&mut self, node: usize) {
        let own = self.visited;
        self.visited += 1;
        self.order[node] = Some(own);
        self.low[node] = own;
        self.stack.push(node);
        for &next in &self.arrows[node] {
            match self.order[next] {
                None => {
                    self.visit(next);
                    self.low[node] = self.low[node].min(self.low[next]);
                }
                Some(order) if self.stack.contains(&next) => self.low[node] = self.low[node].min(order),
                Some(_) => {}
            }
        }
        if self.low[node] == own {
            let begin = self.stack.iter().position(|&other| other == node).unwrap();
            let component = self.stack.split_off(begin);
            if component.len() > 1 {
                self.found.push(component);
            }
        }
    }
}

/// A cycle: its files in order of path, and what ties them.
#[derive(Debug)]
struct Cycle {
    files: BTreeSet<String>,
    folders: BTreeSet<String>,
    ties: Vec<String>,
}

fn cycles(sources: &[Source]) -> Vec<Cycle> {
    let paths: BTreeSet<String> = sources.iter().map(|source| source.path.clone()).collect();
    let modules: Modules = sources.iter().map(|source| module(source, &paths)).collect();
    let places: BTreeMap<&Vec<String>, usize> = modules.keys().enumerate().map(|(i, module)| (module, i)).collect();
    let mut arrows = Vec::new();
    for (i, module) in modules.values().enumerate() {
        let targets = module.imports.iter().filter_map(|path| defined_in(path, &modules, 8));
        let targets: BTreeSet<usize> = targets.map(|module| places[&module]).filter(|&target| target != i).collect();
        arrows.push(targets.into_iter().collect::<Vec<_>>());
    }
    let all: Vec<&Module> = modules.values().collect();
    let described = |component: &Vec<usize>| Cycle {
        files: component.iter().map(|&i| all[i].path.clone()).collect(),
        folders: component.iter().map(|&i| all[i].folder.clone()).collect(),
        ties: component
            .iter()
            .flat_map(|&i| arrows[i].iter().map(move |&to| (i, to)))
            .filter(|(_, to)| component.contains(to))
            .map(|(from, to)| format!("    {} -> {}", all[from].path, all[to].path))
            .collect(),
    };
    Components::of(&arrows).iter().map(described).collect()
}

/// Reads the rows `| file, file | reason |` below the heading: each a set of files, from `src`.
fn listed(page: &str) -> Vec<BTreeSet<String>> {
    let table = page.split_once(CYCLES).map_or("", |(_, table)| table);
    let rows = table.lines().filter(|line| line.starts_with("| `"));
    let mut found = Vec::new();
    for row in rows {
        let cells: Vec<&str> = row.split('|').collect();
        assert!(cells.get(2).is_some_and(|reason| reason.trim().len() > 10), "a cycle without a reason: {row}");
        found.push(cells[1].split('`').skip(1).step_by(2).map(|file| format!("src/{file}")).collect());
    }
    found
}

fn findings(sources: &[Source], page: &str) -> Vec<String> {
    let listed = listed(page);
    let cycles = cycles(sources);
    let mut findings = Vec::new();
    for Cycle { files, folders, ties } in &cycles {
        let names = files.iter().map(String::as_str).collect::<Vec<_>>().join(", ");
        let ties = ties.join("\n");
        if folders.len() > 1 {
            findings.push(format!("across folders: {names}\n{ties}"));
        } else if !listed.contains(files) {
            findings.push(format!("inside of a folder and not in the table: {names}\n{ties}"));
        }
    }
    for files in listed.iter().filter(|&files| !cycles.iter().any(|cycle| cycle.files == *files)) {
        let names = files.iter().map(String::as_str).collect::<Vec<_>>().join(", ");
        findings.push(format!("in the table and no cycle: {names}"));
    }
    findings
}

#[test]
fn no_files_import_each_other_but_those_that_are_listed() {
    let of_tests = of_tests();
    let mut sources = files(&["src"], ".rs");
    sources.retain(|source| !of_tests.contains(&source.path));
    let page = fs::read_to_string(root().join("src/guide/imports.md")).unwrap();
    none("cycles of imports (src/guide/imports.md)", &findings(&sources, &page));
}

#[test]
fn a_circle_is_caught() {
    let tried = |files: &[(&str, &str)], rows: &str| {
        let source = |&(path, text): &(&str, &str)| Source { path: path.into(), text: text.into() };
        let sources: Vec<Source> = files.iter().map(source).collect();
        let found = findings(&sources, &format!("| `a` | `b` |\n{CYCLES}\n{rows}"));
        found.iter().map(|finding| finding.lines().next().unwrap().to_owned()).collect::<Vec<_>>()
    };
    let across = [("src/a/x.rs", "use crate::b::y::Y;\npub struct X;"), ("src/b/y.rs", "fn f() -> crate::a::x::X {}")];
    assert_eq!(tried(&across, ""), ["across folders: src/a/x.rs, src/b/y.rs"]);
    assert_eq!(
        tried(&across, "| `a/x.rs`, `b/y.rs` | so it is for now |"),
        ["across folders: src/a/x.rs, src/b/y.rs"],
        "no row grants a cycle across folders"
    );
    let three = [("src/a/x.rs", "use super::y::Y;"), ("src/a/y.rs", "use crate::a::{self, z};"), ("src/a/z.rs", "use super::x;")];
    let names = "src/a/x.rs, src/a/y.rs, src/a/z.rs";
    assert_eq!(tried(&three, ""), [format!("inside of a folder and not in the table: {names}")]);
    assert!(tried(&three, "| `a/x.rs`, `a/y.rs`, `a/z.rs` | one type, three files |").is_empty());
    let two_of_three = tried(&three, "| `a/x.rs`, `a/y.rs` | one type, two files |");
    assert_eq!(two_of_three.len(), 2, "the whole cycle is listed or none: {two_of_three:?}");
    let cut = [("src/a/x.rs", "use super::y::Y;"), ("src/a/y.rs", "")];
    assert!(tried(&cut, "").is_empty());
    assert_eq!(
        tried(&cut, "| `a/x.rs`, `a/y.rs` | one type, two files |"),
        ["in the table and no cycle: src/a/x.rs, src/a/y.rs"]
    );
    assert!(std::panic::catch_unwind(|| listed(&format!("{CYCLES}\n| `a/x.rs`, `a/y.rs` | |"))).is_err(), "a row has a reason");
}

#[test]
fn a_name_is_followed_to_where_it_is_defined() {
    let tried = |files: &[(&str, &str)]| {
        let source = |&(path, text): &(&str, &str)| Source { path: path.into(), text: text.into() };
        cycles(&files.iter().map(source).collect::<Vec<_>>()).len()
    };
    let face = ("src/a/mod.rs", "mod x;\nmod y;\npub(crate) use x::{X, self};\npub use y::Y;\n");
    let by_face = [face, ("src/a/x.rs", "use super::Y;\n"), ("src/a/y.rs", "")];
    assert_eq!(tried(&by_face), 0, "x imports y, though by the name that the folder hands on");
    let both = [face, ("src/a/x.rs", "use super::Y;\n"), ("src/a/y.rs", "use crate::a::X;\n")];
    assert_eq!(tried(&both), 1);
    let own = [("src/a/mod.rs", "mod x;\npub use x::X;\npub struct Own;\n"), ("src/a/x.rs", "use super::Own;\n")];
    assert_eq!(tried(&own), 1, "what a folder's own file defines and hands on");
    let called = [("src/a/mod.rs", "mod x;\nfn f() { x::g() }\npub struct Own;\n"), ("src/a/x.rs", "use super::Own;\n")];
    assert_eq!(tried(&called), 1, "a path through a module of one's own");
    let selves = [("src/a/mod.rs", "mod x;\nfn f() { self::x::g() }\npub fn h() {}\n"), ("src/a/x.rs", "use crate::a::h;\n")];
    assert_eq!(tried(&selves), 1);
    let of_macro = [("src/a/x.rs", "macro_rules! m { () => { $crate::a::y::f() } }"), ("src/a/y.rs", "use super::x::m;\n")];
    assert_eq!(tried(&of_macro), 1);
    let in_tests = [
        ("src/a/x.rs", "use super::y::Y;\n"),
        ("src/a/y.rs", "// super::x\n#[cfg(test)]\nmod tests { use crate::a::x::X; }\nfn f() {}\n"),
    ];
    assert_eq!(tried(&in_tests), 0);
    let after_tests = [("src/a/x.rs", "use super::y::Y;\n"), ("src/a/y.rs", "#[cfg(test)]\nmod t;\nuse super::x::X;\n")];
    assert_eq!(tried(&after_tests), 1, "what follows a test module is code");
    let deep = [("src/a/x.rs", "mod y;\nuse y::Y;\n"), ("src/a/x/y.rs", "use super::X;\n")];
    let source = |&(path, text): &(&str, &str)| Source { path: path.into(), text: text.into() };
    let found = cycles(&deep.iter().map(source).collect::<Vec<_>>());
    assert_eq!(found.iter().map(|cycle| cycle.folders.len()).collect::<Vec<_>>(), [1], "the modules of a file lie in its folder");
}
