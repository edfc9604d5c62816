//! JSON and TOML as lines: one `key = value` for each number, truth value and name, strings with white space apart.

use super::digest::{sha256, spread};
use serde_json::Value;
use std::fmt::Write;

/// An array of so many scalars stands on one line; a longer one is hashed, and so many of its entries written out.
const INLINE: usize = 9;
const ENTRIES: usize = 6;

/// What stands for a string in the numbers where the string itself is among the words.
pub(crate) const WORDS: &str = "<words>";

/// One object: its path, and a line for each of its scalars.
struct Section {
    path: String,
    lines: Vec<String>,
}

impl Section {
    fn text(&self) -> String {
        self.lines.iter().fold(format!("[{}]\n", self.path), |text, line| text + line + "\n")
    }
}

/// A JSON document taken apart.
#[derive(Default)]
pub(crate) struct Document {
    sections: Vec<Section>,
    /// Strings with white space, with their paths.
    pub(crate) words: Vec<(String, String)>,
}

/// Keys whose strings are no words, although a unit such as `m/(s rad)` has white space.
const UNITS: [&str; 2] = ["unit", "units"];

/// Whether a string is a sentence rather than a name.
fn is_worded(text: &str) -> bool {
    text.contains(char::is_whitespace)
}

fn quoted(text: &str) -> String {
    serde_json::to_string(text).unwrap()
}

fn below(path: &str, key: &str) -> String {
    if path.is_empty() { key.to_owned() } else { format!("{path}.{key}") }
}

impl Document {
    /// Takes a document apart.
    pub(crate) fn new(value: &Value) -> Self {
        let mut document = Document::default();
        document.node("", value);
        document
    }

    fn node(&mut self, path: &str, value: &Value) {
        let mut section = Section { path: path.to_owned(), lines: Vec::new() };
        let mut inner = Vec::new();
        match value {
            Value::Object(map) => {
                let mut keys: Vec<&String> = map.keys().collect();
                keys.sort();
                for key in keys {
                    self.entry(&mut section, &mut inner, path, key, &map[key]);
                }
            }
            other => self.entry(&mut section, &mut inner, path, "value", other),
        }
        if !section.lines.is_empty() {
            self.sections.push(section);
        }
        for (path, value) in inner {
            self.node(&path, value);
        }
    }

    fn entry<'a>(
        &mut self,
        section: &mut Section,
        inner: &mut Vec<(String, &'a Value)>,
        path: &str,
        key: &str,
        value: &'a Value,
    ) {
        match value {
            Value::Object(map) if !map.is_empty() => inner.push((below(path, key), value)),
            Value::Array(all) => {
                if all.iter().any(Value::is_object) {
                    section.lines.push(format!("{key} = {} entries", all.len()));
                    inner.extend(all.iter().enumerate().map(|(i, one)| (format!("{}[{i}]", below(path, key)), one)));
                } else if all.iter().any(Value::is_array) {
                    section.lines.push(format!("{key} = {} rows", all.len()));
                    for (i, row) in all.iter().enumerate() {
                        self.entry(section, inner, path, &format!("{key}[{i}]"), row);
                    }
                } else {
                    self.series(section, path, key, all);
                }
            }
            scalar => {
                let text = self.scalar(&below(path, key), scalar);
                section.lines.push(format!("{key} = {text}"));
            }
        }
    }

    fn series(&mut self, section: &mut Section, path: &str, key: &str, all: &[Value]) {
        let path = below(path, key);
        let texts: Vec<String> = all.iter().enumerate().map(|(i, one)| self.scalar(&format!("{path}[{i}]"), one)).collect();
        if all.len() <= INLINE {
            section.lines.push(format!("{key} = [{}]", texts.join(", ")));
            return;
        }
        section.lines.push(format!("{key} = {} values, sha256 {}", all.len(), sha256(texts.join("\n"))));
        section.lines.extend(spread(all.len(), ENTRIES).into_iter().map(|i| format!("{key}[{i}] = {}", texts[i])));
    }

    /// A scalar in its canonical form: numbers in the shortest form that reads back as the same bits.
    fn scalar(&mut self, path: &str, value: &Value) -> String {
        match value {
            Value::String(text) if is_worded(text) && !UNITS.iter().any(|unit| path.ends_with(unit)) => {
                self.words.push((path.to_owned(), text.clone()));
                WORDS.to_owned()
            }
            other => other.to_string(),
        }
    }

    /// Everything but the words, in full.
    pub(crate) fn canonical(&self) -> String {
        self.sections.iter().map(Section::text).collect()
    }

    /// Its numbers in about `budget` bytes: the hash of all, and as many objects in full as there is room for; of the objects
    /// between them the number of lines and a hash.
    pub(crate) fn numbers(&self, budget: usize) -> String {
        let all = self.canonical();
        let mut text = String::new();
        if all.len() <= budget {
            return all;
        }
        let lines: usize = self.sections.iter().map(|section| section.lines.len()).sum();
        let _ = writeln!(text, "sha256 = {} of {} objects, {lines} lines", sha256(&all), self.sections.len());
        let average = all.len() / self.sections.len().max(1);
        let shown = spread(self.sections.len(), (budget / (average + 160)).max(2));
        for (place, &at) in shown.iter().enumerate() {
            text.push_str(&self.sections[at].text());
            let next = shown.get(place + 1).copied().unwrap_or(self.sections.len());
            if let between @ [first, ..] = &self.sections[at + 1..next] {
                let whole: String = between.iter().map(Section::text).collect();
                let last = between.last().unwrap_or(first);
                let name = if between.len() == 1 { first.path.clone() } else { format!("{} ... {}", first.path, last.path) };
                let lines: usize = between.iter().map(|section| section.lines.len()).sum();
                let _ = writeln!(text, "[{name}] {lines} lines, sha256 {}", sha256(whole));
            }
        }
        text
    }
}

/// Words as lines `path = "text"`, in about `budget` bytes: where there are more, the hash of all and every Nth.
pub(crate) fn worded(words: &[(String, String)], budget: usize) -> String {
    let lines: Vec<String> = words.iter().map(|(path, text)| format!("{path} = {}\n", quoted(text))).collect();
    let all = lines.concat();
    if all.len() <= budget {
        return all;
    }
    let mut text = format!("sha256 {} of {} texts\n", sha256(&all), lines.len());
    spread(lines.len(), lines.len() * budget / all.len()).into_iter().for_each(|i| text.push_str(&lines[i]));
    text
}

/// A document of keys, one a line (TOML, or the preamble of a run file): numbers and words.
pub(crate) fn keys(text: &str) -> (String, String) {
    let (mut numbers, mut words) = (String::new(), String::new());
    for line in text.lines().map(str::trim).filter(|line| !line.is_empty()) {
        let comment = line.starts_with('#');
        let worded = line.split('"').skip(1).step_by(2).any(is_worded);
        if comment || worded {
            let _ = writeln!(words, "{line}");
        }
        if worded && !comment {
            let _ = writeln!(numbers, "{} = {WORDS}", line.split('=').next().unwrap_or_default().trim());
        } else if !comment {
            let _ = writeln!(numbers, "{line}");
        }
    }
    (numbers, words)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn document(text: &str) -> Document {
        Document::new(&serde_json::from_str(text).unwrap())
    }

    #[test]
    fn numbers_and_words_are_parted() {
        let found =
            document(r#"{"b": {"x": 0.1, "y": [1, -0.0]}, "a": "two words", "c": [{"n": null}, {"n": "name"}], "d": true}"#);
        assert_eq!(
            found.numbers(1000),
            "[]\na = <words>\nc = 2 entries\nd = true\n[b]\nx = 0.1\ny = [1, -0.0]\n[c[0]]\nn = null\n[c[1]]\nn = \"name\"\n"
        );
        assert_eq!(worded(&found.words, 1000), "a = \"two words\"\n");
    }

    /// Whatever is altered in a document that is too long to be written out shows.
    #[test]
    fn every_value_of_a_long_document_counts() {
        let text = |k: usize, value: f64| {
            let all: Vec<Value> = (0..200)
                .map(|i| serde_json::json!({"i": i, "x": if i == k { value } else { 0.25 }, "why": "no reason"}))
                .collect();
            document(&serde_json::json!({ "all": all, "series": (0..500).map(|i| if i == k { value } else { 0.5 }).collect::<Vec<f64>>() }).to_string())
                .numbers(2000)
        };
        let before = text(1000, 0.0);
        assert!(before.len() < 4000, "{}", before.len());
        assert!((0..200).all(|k| text(k, 0.250_000_000_000_000_06) != before));
    }

    #[test]
    fn keys_of_a_model_file() {
        let (numbers, words) = keys("# A comment.\nname = \"a b\"\nu = -0.5\nkind = \"linear\"\n\n[trim]\n");
        assert_eq!(numbers, "name = <words>\nu = -0.5\nkind = \"linear\"\n[trim]\n");
        assert_eq!(words, "# A comment.\nname = \"a b\"\n");
    }
}
