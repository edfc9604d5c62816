//! Links in pages: a link to a file of the tree points at one that is there.

use super::sources::{Source, files, none, root};

/// Targets of the page's links that are files: `[text](target)` outside code.
fn targets(page: &str) -> Vec<String> {
    let mut found = Vec::new();
    let mut fenced = false;
    for line in page.lines() {
        if line.trim_start().starts_with("```") {
            fenced = !fenced;
        }
        if fenced {
            continue;
        }
        for (at, _) in line.match_indices("](") {
            let rest = &line[at + 2..];
            let target = rest.split([')', ' ', '#']).next().unwrap_or_default();
            let elsewhere = target.is_empty() || target.contains("://") || target.starts_with("mailto:");
            // `crate::x` is a link that rustdoc resolves and checks.
            if !elsewhere && !target.contains("::") {
                found.push(target.to_owned());
            }
        }
    }
    found
}

fn broken(page: &Source) -> Vec<String> {
    let folder = root().join(&page.path).parent().unwrap().to_owned();
    let missing = |target: &String| !folder.join(target).exists();
    targets(&page.text).into_iter().filter(missing).map(|target| format!("{}: {target}", page.path)).collect()
}

#[test]
fn links_in_pages_point_at_files() {
    let pages = files(&["README.md", "src", "replay", "firmware-profile", "tests"], ".md");
    none("links to nothing", &pages.iter().flat_map(broken).collect::<Vec<_>>());
}

#[test]
fn a_broken_link_is_caught() {
    let page = |text: &str| broken(&Source { path: "src/guide/page.md".into(), text: text.into() });
    assert_eq!(
        page("see [there](nowhere.md#part) and [here](imports.md) or [web](https://x.y)"),
        ["src/guide/page.md: nowhere.md"]
    );
    assert!(page("```\n[x](nowhere)\n```\n[r](crate::num::ud)").is_empty());
}
