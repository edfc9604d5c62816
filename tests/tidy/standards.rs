//! The page of clauses: what it says is implemented has code and a test in the tree, and every chapter has its exceptions.

use super::sources::{Source, files, none, root, rust};
use std::collections::HashSet;

const PAGE: &str = "src/guide/standards.md";

/// Cells of the rows of a section's tables, each table with its header.
fn tables(section: &str) -> Vec<Vec<Vec<String>>> {
    let mut tables: Vec<Vec<Vec<String>>> = Vec::new();
    let mut inside = false;
    for line in section.lines() {
        let Some(row) = line.strip_prefix('|').and_then(|row| row.trim_end().strip_suffix('|')) else {
            inside = false;
            continue;
        };
        if !inside {
            tables.push(Vec::new());
            inside = true;
        }
        let cells: Vec<String> = row.split('|').map(|cell| cell.trim().to_owned()).collect();
        if !cells.iter().all(|cell| cell.chars().all(|c| c == '-')) {
            tables.last_mut().unwrap().push(cells);
        }
    }
    tables
}

/// The one code word of a cell.
fn word(cell: &str) -> Option<&str> {
    cell.strip_prefix('`')?.strip_suffix('`').filter(|word| !word.is_empty() && !word.contains('`'))
}

/// Names of the functions below a `#[test]`, and of those in a block of property tests.
fn tests(sources: &[Source]) -> HashSet<String> {
    let mut names = HashSet::new();
    for source in sources {
        for after in source.text.split("#[test]").skip(1) {
            let name = after.split_once("fn ").and_then(|(_, rest)| rest.split('(').next());
            names.extend(name.map(str::to_owned));
        }
    }
    names
}

/// What is wrong with the page.
fn wrong(page: &str, is_file: impl Fn(&str) -> bool, tests: &HashSet<String>) -> Vec<String> {
    let mut findings = Vec::new();
    let mut chapters = 0;
    for section in page.split("\n## ").skip(1) {
        chapters += 1;
        let title = section.lines().next().unwrap_or_default();
        let (mut clauses, mut exceptions) = (0, 0);
        for table in tables(section) {
            let header: Vec<&str> = table[0].iter().map(String::as_str).collect();
            for row in &table[1..] {
                match (header.as_slice(), row.as_slice()) {
                    (["clause", "subject", "code", "test"], [_, subject, code, test]) => {
                        clauses += 1;
                        if !word(code).is_some_and(|file| is_file(&format!("src/io/{file}"))) {
                            findings.push(format!("{title}: {subject}: no file {code}"));
                        }
                        if !word(test).is_some_and(|name| tests.contains(name)) {
                            findings.push(format!("{title}: {subject}: no test {test}"));
                        }
                    }
                    (["exception", "reason"], [exception, reason]) => {
                        exceptions += 1;
                        if reason.split(' ').count() < 3 {
                            findings.push(format!("{title}: {exception}: no reason"));
                        }
                    }
                    _ => findings.push(format!("{title}: a row of another table: {}", row.join(" | "))),
                }
            }
        }
        if clauses == 0 || exceptions == 0 {
            findings.push(format!("{title}: {clauses} clauses and {exceptions} exceptions"));
        }
    }
    if chapters == 0 {
        findings.push("no chapter".into());
    }
    findings
}

#[test]
fn every_clause_has_its_code_and_its_test_and_every_chapter_its_exceptions() {
    let page = &files(&[PAGE], ".md")[0].text;
    let tests = tests(&rust());
    none("clauses of standards", &wrong(page, |file| root().join(file).is_file(), &tests));
    for chapter in ["Chapter 4", "Chapter 9", "Chapter 10", "MAVLink"] {
        assert!(page.lines().any(|line| line.starts_with("## ") && line.contains(chapter)), "{chapter}");
    }
}

#[test]
fn what_is_not_there_is_told() {
    let known = tests(&[Source { path: "x.rs".into(), text: "#[test]\nfn there() {}\nfn beside() {}".into() }]);
    let page = |rows: &str, exceptions: &str| {
        let text = format!(
            "# T\n\n## A\n\n| clause | subject | code | test |\n| --- | --- | --- | --- |\n{rows}\n\n| exception | reason |\n\
             | --- | --- |\n{exceptions}\n"
        );
        wrong(&text, |file| file == "src/io/a.rs", &known)
    };
    let good = "| 1 | s | `a.rs` | `there` |";
    assert_eq!(page(good, "| e | nobody has it |"), [""; 0]);
    for (rows, exceptions, word) in [
        ("| 1 | s | `b.rs` | `there` |", "| e | nobody has it |", "no file"),
        ("| 1 | s | a.rs | `there` |", "| e | nobody has it |", "no file"),
        ("| 1 | s | `a.rs` | `beside` |", "| e | nobody has it |", "no test"),
        ("| 1 | s | `a.rs` | |", "| e | nobody has it |", "no test"),
        ("| 1 | s | `a.rs` |", "| e | nobody has it |", "another table"),
        (good, "| e | |", "no reason"),
        (good, "", "0 exceptions"),
        ("", "| e | nobody has it |", "0 clauses"),
    ] {
        let found = page(rows, exceptions);
        assert!(found.len() == 1 || word == "another table", "{found:?}");
        assert!(found.iter().any(|finding| finding.contains(word)), "{rows}: {found:?}");
    }
    assert_eq!(wrong("# T\n", |_| true, &known), ["no chapter"]);
}
