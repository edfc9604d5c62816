//! SVG and HTML: the markup is hashed with the numbers, what is written in it stands among the words.

use super::digest::sha256;
use super::document::worded;
use std::collections::BTreeMap;
use std::fmt::Write;

/// Bytes of a page's or drawing's own words.
const WORDS: usize = 6000;

/// A text between tags, and attributes that are read out.
fn written(markup: &str) -> (Vec<String>, Vec<String>) {
    let (mut tags, mut texts) = (Vec::new(), Vec::new());
    let mut rest = markup;
    while let Some(open) = rest.find('<') {
        texts.push(rest[..open].trim().to_owned());
        let close = rest[open..].find('>').map_or(rest.len(), |close| open + close + 1);
        let tag = &rest[open..close];
        tags.push(tag.to_owned());
        rest = &rest[close..];
        // What a style sheet or script holds is no text.
        for name in ["style", "script"] {
            if tag.starts_with(&format!("<{name}")) {
                let end = rest.find(&format!("</{name}")).unwrap_or(rest.len());
                tags.push(rest[..end].to_owned());
                rest = &rest[end..];
            }
        }
    }
    texts.push(rest.trim().to_owned());
    texts.retain(|text| !text.is_empty());
    (tags, texts)
}

/// Numbers and words of a drawing or a page. Texts without a letter, such as ticks and cells of tables, are numbers.
pub(crate) fn drawing(markup: &str) -> (String, String) {
    let (tags, texts) = written(markup);
    let name =
        |tag: &str| tag.trim_start_matches('<').split(|c: char| !c.is_alphanumeric()).next().unwrap_or_default().to_owned();
    let mut count: BTreeMap<String, usize> = BTreeMap::new();
    tags.iter().map(|tag| name(tag)).filter(|name| !name.is_empty()).for_each(|name| *count.entry(name).or_default() += 1);
    let (lettered, plain): (Vec<&String>, Vec<&String>) = texts.iter().partition(|text| text.contains(char::is_alphabetic));
    let mut numbers = format!("markup = {} tags, sha256 {}\n", tags.len(), sha256(tags.join("\n")));
    let counts: Vec<String> = count.iter().map(|(name, count)| format!("{name} {count}")).collect();
    let plain: Vec<&str> = plain.into_iter().map(String::as_str).collect();
    let _ = writeln!(numbers, "tags = {}", counts.join(", "));
    let _ = writeln!(numbers, "texts without letters = {}, sha256 {}", plain.len(), sha256(plain.join("\n")));
    let words: Vec<(String, String)> = lettered.into_iter().map(|text| ("text".to_owned(), text.clone())).collect();
    (numbers, worded(&words, WORDS))
}

#[test]
fn markup_and_texts_are_parted() {
    let page = "<p>one <b>two</b></p><style>p{x:y}</style><text x=\"1\">0.5</text>";
    let (numbers, words) = drawing(page);
    assert_eq!(words, "text = \"one\"\ntext = \"two\"\n");
    assert!(numbers.contains("texts without letters = 1,"), "{numbers}");
    assert_ne!(drawing(&page.replace("x=\"1\"", "x=\"2\"")).0, numbers);
    assert_ne!(drawing(&page.replace("0.5", "0.6")).0, numbers);
    assert_eq!(drawing(&page.replace("two", "three")).0, numbers);
    assert_ne!(drawing(&page.replace("two", "three")).1, words);
}
