//! Names of types: one bare name means one thing in the whole tree, so that a name can be looked up without its module.
//!
//! A struct, enum, union, trait or type alias that other files may see (`pub`, `pub(crate)`, `pub(super)`, `pub(in ...)`) shares
//! its name with no type of another file below src, firmware-profile and replay, be that one visible or private. Exempt are:
//! - two private types of two files: a reader of either file has no way to mean the other;
//! - associated types of an impl (`type Error = ...`), whose names the trait gives;
//! - types of tests, in `tests` and in a file's own tests: the test binaries publish nothing, and a stand-in is called what it
//!   stands for;
//! - names of other crates (`Result`, iceoryx2's `Config`), of which nothing is declared here.

use super::sources::{Source, built, files, none};
use std::collections::BTreeMap;

/// Where a type is declared, and whether other files may see it.
struct Declaration<'a> {
    path: &'a str,
    line: usize,
    visible: bool,
}

/// The line without its visibility, and whether it has one.
fn visibility(line: &str) -> (bool, &str) {
    let Some(rest) = line.strip_prefix("pub") else { return (false, line) };
    match rest.strip_prefix('(').and_then(|rest| rest.split_once(')')) {
        Some((_, rest)) => (true, rest.trim_start()),
        None => (true, rest.trim_start()),
    }
}

/// The name of the type that a line of code declares, and whether other files may see it.
fn declared(line: &str) -> Option<(String, bool)> {
    let (visible, rest) = visibility(line.trim_start());
    let rest = rest.strip_prefix("unsafe ").unwrap_or(rest);
    let kinds = ["struct ", "enum ", "union ", "trait "];
    let after = kinds.iter().find_map(|kind| rest.strip_prefix(kind));
    // Without visibility an indented alias is an associated type.
    let alias = rest.strip_prefix("type ").filter(|_| visible || !line.starts_with(' '));
    let name: String = after.or(alias)?.chars().take_while(|c| c.is_alphanumeric() || *c == '_').collect();
    (!name.is_empty()).then_some((name, visible))
}

/// One line for every name that is visible in one file and declared in another too.
fn doubles(sources: &[Source]) -> Vec<String> {
    let mut by_name: BTreeMap<String, Vec<Declaration<'_>>> = BTreeMap::new();
    for source in sources {
        for (number, line) in built(&source.text).lines().enumerate() {
            if let Some((name, visible)) = declared(line) {
                by_name.entry(name).or_default().push(Declaration { path: &source.path, line: number + 1, visible });
            }
        }
    }
    let in_two_files = |all: &[Declaration<'_>]| all.windows(2).any(|pair| pair[0].path != pair[1].path);
    let bad = by_name.iter().filter(|(_, all)| in_two_files(all) && all.iter().any(|one| one.visible));
    bad.map(|(name, all)| {
        let places: Vec<String> = all.iter().map(|one| format!("{}:{}", one.path, one.line)).collect();
        format!("{name}: {}", places.join(", "))
    })
    .collect()
}

#[test]
fn one_type_name_means_one_thing() {
    let of_tests = super::reached::of_tests();
    let mut sources = files(&["src", "firmware-profile", "replay"], ".rs");
    sources.retain(|source| !of_tests.contains(&source.path));
    let names = sources.iter().flat_map(|source| built(&source.text).lines().filter_map(declared).collect::<Vec<_>>()).count();
    assert!(names > 500, "only {names} types were found");
    none("type names that mean two things", &doubles(&sources));
}

#[test]
fn a_name_declared_twice_is_caught() {
    let found = |texts: &[&str]| {
        let source = |(i, text): (usize, &&str)| Source { path: format!("src/{i}.rs"), text: (*text).into() };
        doubles(&texts.iter().enumerate().map(source).collect::<Vec<_>>())
    };
    assert_eq!(found(&["pub struct Config {}\n", "use x;\npub(crate) enum Config {}\n"]), ["Config: src/0.rs:1, src/1.rs:2"]);
    let pairs = [
        ("pub struct A;", "pub(super) struct A(u8);"),
        ("pub trait A {}", "pub(in crate::x) struct A<T>(T);"),
        ("pub type A = u8;", "pub enum A {}"),
        ("pub(crate) unsafe trait A {}", "pub union A {}"),
        ("pub struct A;", "struct A;"),
        ("pub struct A;", "type A = u8;"),
        ("mod inner {\n    pub struct A;\n}", "fn f() {\n    struct A;\n}"),
    ];
    for (one, other) in pairs {
        assert_eq!(found(&[one, other]).len(), 1, "{one} beside {other}");
        assert_eq!(found(&[other, one]).len(), 1, "{other} beside {one}");
    }
    let allowed = [
        ("struct A;", "enum A {}"),
        ("pub struct A;", "pub struct AB; pub struct Ba;"),
        ("pub struct Error;", "impl T for U {\n    type Error = u8;\n}"),
        ("pub struct A;", "#[cfg(test)]\nmod tests {\n    pub struct A;\n}"),
        ("pub struct A;", "// pub struct A;\nlet a = \"\npub struct A;\";"),
        ("pub struct A;", "pub fn struct_a() -> A;\nuse x::A;"),
        ("pub struct A;", "pub const TYPE: A = A;\npub mod trait_a;"),
    ];
    for (one, other) in allowed {
        assert_eq!(found(&[one, other]), [""; 0], "{one} beside {other}");
    }
    assert_eq!(found(&["mod a { }\npub struct A;\npub enum A {}"]), [""; 0], "two of one file are the compiler's matter");
}
