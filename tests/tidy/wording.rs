//! Lines, taglines, names and words: what every file keeps to, whoever wrote it.

use super::sources::{Source, code, files, none, rust};

/// Longest line, characters.
const LINE: usize = 130;
/// Longest file, lines.
const FILE: usize = 450;

/// Files that are longer, and how long each may be: a number here only ever falls.
const LONGER: [(&str, usize); 0] = [];

/// Names of files and modules that say nothing.
const NAMES: [&str; 6] = ["utils", "util", concat!("hel", "pers"), concat!("hel", "per"), "common", "manager"];

/// Words that have no place in the tree, split here so that this file has none of them.
const WORDS: [&str; 11] = [
    concat!("to", "do!"),
    concat!("FIX", "ME"),
    concat!("TO", "DO"),
    concat!("HA", "CK"),
    concat!("X", "XX"),
    concat!("is", "sue"),
    concat!("is", "sues"),
    concat!("ses", "sion"),
    concat!("ses", "sions"),
    concat!("hel", "per"),
    concat!("hel", "pers"),
];

/// Places of one machine.
const PLACES: [&str; 4] = [concat!("/wo", "rk/"), concat!("/tm", "p/"), concat!("/ho", "me/"), concat!("/ro", "ot/")];

/// Methods of floating-point numbers whose result depends on the platform; the library takes `libm`'s.
const METHODS: [&str; 18] = [
    ".sin(",
    ".cos(",
    ".tan(",
    ".sin_cos(",
    ".asin(",
    ".acos(",
    ".atan(",
    ".atan2(",
    ".exp(",
    ".ln(",
    ".log10(",
    ".sqrt(",
    ".powf(",
    ".powi(",
    ".hypot(",
    ".sinh(",
    ".cosh(",
    ".tanh(",
];

/// Files that may hold `unsafe`, each with its reason beside it.
const UNSAFE: [&str; 7] = [
    "tests/support/allocations.rs",
    "firmware-profile/src/main.rs",
    "firmware-profile/src/c_interface.rs",
    "firmware-profile/src/bin/board/main.rs",
    "firmware-profile/src/bin/board/start.rs",
    "firmware-profile/src/bin/board/semihosting.rs",
    "firmware-profile/src/bin/board/instructions.rs",
];

fn in_lines(source: &Source, wrong: impl Fn(&str) -> Option<String>) -> Vec<String> {
    let lines = source.text.lines().enumerate();
    lines.filter_map(|(i, line)| wrong(line).map(|what| format!("{}:{}: {what}", source.path, i + 1))).collect()
}

/// Everything that people read: code, pages, manifests, scripts.
fn written() -> Vec<Source> {
    let mut all = rust();
    let tree = ["src", "tests", "replay", "firmware-profile", ".ci", "README.md", "Cargo.toml"];
    for ending in [".md", ".toml", "run", ".html", ".js"] {
        all.extend(files(&tree, ending));
    }
    all
}

/// Whether the word stands there on its own.
fn has_word(line: &str, word: &str) -> bool {
    let edge = |c: Option<char>| c.is_none_or(|c| !c.is_alphanumeric() && c != '_');
    line.match_indices(word).any(|(at, _)| edge(line[..at].chars().next_back()) && edge(line[at + word.len()..].chars().next()))
}

fn banned(line: &str) -> Option<String> {
    let small = line.to_lowercase();
    let is_there = |word: &&&str| {
        let shouted = word.chars().any(char::is_uppercase);
        if shouted { has_word(line, word) } else { has_word(&small, word) || (word.ends_with('!') && small.contains(**word)) }
    };
    WORDS.iter().find(is_there).map(|word| format!("the word {word}"))
}

fn place(line: &str) -> Option<String> {
    PLACES.iter().find(|place| line.contains(**place)).map(|place| format!("a path of one machine, {place}"))
}

fn tagline(source: &Source) -> Option<String> {
    let first = source.text.lines().next().unwrap_or_default();
    let says = first.strip_prefix("//! ").is_some_and(|line| line.trim().len() >= 12);
    (!says).then(|| format!("{}: does not open with a tagline (//! and a sentence)", source.path))
}

#[test]
fn every_file_opens_with_a_tagline() {
    none("taglines", &rust().iter().filter_map(tagline).collect::<Vec<_>>());
    let bare = |text: &str| tagline(&Source { path: String::new(), text: text.into() }).is_some();
    assert!(bare("use a;\n") && bare("//! x\n") && bare("") && !bare("//! What this file is for.\n"));
}

#[test]
fn lines_and_files_are_short() {
    let mut findings = Vec::new();
    for source in rust() {
        findings.extend(in_lines(&source, |line| {
            let length = line.chars().count();
            // The formatter does not break a string; whoever reads it wants it whole.
            (length > LINE && !line.contains('"')).then(|| format!("{length} characters"))
        }));
        let lines = source.text.lines().count();
        let allowed = LONGER.iter().find(|(path, _)| *path == source.path).map_or(FILE, |(_, lines)| *lines);
        if lines > allowed {
            findings.push(format!("{}: {lines} lines, {allowed} allowed", source.path));
        }
        if allowed > FILE && lines + 20 < allowed {
            findings.push(format!("{}: only {lines} lines now, so lower its {allowed} in LONGER", source.path));
        }
    }
    none("lengths", &findings);
}

#[test]
fn names_say_something() {
    let mut findings = Vec::new();
    for source in rust() {
        for part in source.path.split('/') {
            let name = part.trim_end_matches(".rs");
            if NAMES.contains(&name) {
                findings.push(format!("{}: a name that says nothing", source.path));
            }
        }
        findings.extend(in_lines(&source, |line| {
            let name = code(line).trim().trim_start_matches("pub ").strip_prefix("mod ")?.to_owned();
            let name = name.trim_end_matches([';', '{', ' ']).to_owned();
            NAMES.contains(&name.as_str()).then(|| format!("mod {name}"))
        }));
    }
    none("names", &findings);
}

#[test]
fn no_banned_words_and_no_paths_of_one_machine() {
    let mut findings = Vec::new();
    for source in written() {
        findings.extend(in_lines(&source, banned));
        findings.extend(in_lines(&source, place));
    }
    none("words", &findings);
    for line in ["x = to\u{64}o!()", "// FIX\u{4d}E later", "in the last Ses\u{73}ion", "see is\u{73}ue 3"] {
        assert!(banned(line).is_some(), "{line}");
    }
    assert!(banned("obsessions, tissue, HACKS, todos").is_none());
    assert!(place("open(\"/\u{74}mp/x\")").is_some() && place("a/work").is_none());
}

#[test]
fn the_library_takes_its_functions_from_libm() {
    let of_tests = super::reached::of_tests();
    let mut findings = Vec::new();
    for source in files(&["src"], ".rs").into_iter().filter(|source| !of_tests.contains(&source.path)) {
        let text = Source { path: source.path.clone(), text: super::sources::built(&source.text) };
        findings.extend(in_lines(&text, |line| METHODS.iter().find(|m| line.contains(**m)).map(|m| (*m).to_owned())));
    }
    none("platform-dependent functions", &findings);
}

#[test]
fn unsafe_stands_only_where_it_is_argued() {
    let token = concat!("un", "safe");
    let mut findings = Vec::new();
    for source in rust().into_iter().filter(|source| !UNSAFE.contains(&source.path.as_str())) {
        let text = Source { path: source.path.clone(), text: code(&source.text) };
        findings.extend(in_lines(&text, |line| has_word(line, token).then(|| token.to_owned())));
    }
    none("not on the list of files that may", &findings);
    assert!(has_word("let x = un\u{73}afe { y };", token) && !has_word("deny(un\u{73}afe_code)", token));
}
