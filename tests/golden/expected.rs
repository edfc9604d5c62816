//! The expected files: compared, or written anew where that is asked for by hand.

use super::compare::difference;
use crate::support::program::own;
use std::path::PathBuf;

/// The two kinds of expectation.
pub(crate) const KINDS: [&str; 2] = ["numbers", "words"];

fn file(name: &str, kind: &str) -> PathBuf {
    own("tests/golden/expected").join(format!("{name}.{kind}.txt"))
}

/// Whether a variable of the environment lists that kind; one that lists anything else is wrong.
fn lists(variable: &str, kind: &str) -> Option<bool> {
    let text = std::env::var(variable).ok()?;
    let kinds: Vec<&str> = text.split(',').collect();
    assert!(kinds.iter().all(|kind| KINDS.contains(kind)), "{variable}: expected numbers, words or both, found `{text}`");
    Some(kinds.contains(&kind))
}

/// What differs of one kind; nothing where it is not to be compared.
pub(crate) fn failure(name: &str, kind: &str, found: &str) -> Option<String> {
    let file = file(name, kind);
    let shown = format!("tests/golden/expected/{name}.{kind}.txt");
    if lists("SIDESLIP_RENEW", kind) == Some(true) {
        std::fs::create_dir_all(file.parent()?).unwrap();
        if std::fs::read_to_string(&file).is_ok_and(|before| before == found) {
            return None;
        }
        std::fs::write(&file, found).unwrap();
        eprintln!("RENEWED: {shown}");
        return None;
    }
    if lists("SIDESLIP_GOLDEN", kind) == Some(false) {
        return None;
    }
    let Ok(expected) = std::fs::read_to_string(&file) else { return Some(format!("{kind}: {shown} is missing")) };
    let difference = difference(&expected, found)?;
    Some(format!("{kind} differ from {shown} (-), found (+):\n{difference}"))
}

/// Fails where a file is missing, or belongs to no case.
pub(crate) fn complete(cases: &[&str]) {
    if std::env::var_os("SIDESLIP_RENEW").is_some() {
        // They are being written meanwhile.
        return;
    }
    let mut wanted: Vec<String> = cases.iter().flat_map(|name| KINDS.map(|kind| format!("{name}.{kind}.txt"))).collect();
    wanted.sort();
    let entries = std::fs::read_dir(own("tests/golden/expected")).unwrap();
    let mut found: Vec<String> = entries.map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect();
    found.sort();
    let without = |all: &[String], others: &[String]| all.iter().filter(|one| !others.contains(one)).cloned().collect::<Vec<_>>();
    let (missing, superfluous) = (without(&wanted, &found), without(&found, &wanted));
    assert!(missing.is_empty() && superfluous.is_empty(), "missing: {missing:?}, without a case: {superfluous:?}");
}
