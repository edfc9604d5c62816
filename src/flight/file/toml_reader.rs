//! A TOML document read table by table, every error with its line and column.
//!
//! Consumes a text; produces typed values. An error has line and column, what was expected and what was
//! found, and the nearest valid name where a name is wrong.

use std::fmt;
use std::ops::Range;
use toml::Spanned;
use toml::de::{DeTable, DeValue};

/// A wrong place in a document.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{line}:{column}: {what}")]
pub struct TomlError {
    /// Line, from 1.
    pub line: usize,
    /// Column in characters, from 1.
    pub column: usize,
    /// What was expected and what was found.
    pub what: String,
}

/// A place in the text, in bytes.
pub(crate) type TomlPlace = Range<usize>;

/// The text that places refer to.
#[derive(Clone, Copy)]
pub(crate) struct TomlText<'t>(pub(crate) &'t str);

impl<'t> TomlText<'t> {
    pub(crate) fn misread(self, place: &TomlPlace, what: impl fmt::Display) -> TomlError {
        let before = self.0.get(..place.start).unwrap_or(self.0);
        let line = before.matches('\n').count() + 1;
        let column = before.rsplit('\n').next().map_or(0, |start| start.chars().count()) + 1;
        TomlError { line, column, what: what.to_string() }
    }

    /// The document's root table.
    pub(crate) fn parse(self) -> Result<Spanned<DeTable<'t>>, TomlError> {
        let root = DeTable::parse(self.0)
            .map_err(|error| self.misread(&error.span().unwrap_or(0..0), format_args!("not TOML: {}", error.message())))?;
        Ok(root)
    }
}

pub(crate) struct TomlTable<'t> {
    text: TomlText<'t>,
    entries: &'t DeTable<'t>,
    place: TomlPlace,
    name: String,
}

/// A key with its value.
pub(crate) struct TomlEntry<'t> {
    text: TomlText<'t>,
    pub(crate) key: &'t str,
    pub(crate) key_place: TomlPlace,
    pub(crate) place: TomlPlace,
    value: &'t DeValue<'t>,
}

impl<'t> TomlTable<'t> {
    /// The root table of a parsed document.
    pub(crate) fn root(text: TomlText<'t>, root: &'t Spanned<DeTable<'t>>) -> Self {
        TomlTable { text, entries: root.get_ref(), place: 0..0, name: "the file".to_owned() }
    }

    /// An error at the table as a whole.
    pub(crate) fn misread(&self, what: impl fmt::Display) -> TomlError {
        self.text.misread(&self.place, what)
    }

    /// Every entry, in the order of the file.
    pub(crate) fn entries(&self) -> Vec<TomlEntry<'t>> {
        let mut entries: Vec<TomlEntry<'t>> = self
            .entries
            .iter()
            .map(|(key, value)| TomlEntry {
                text: self.text,
                key: key.get_ref().as_ref(),
                key_place: key.span(),
                place: value.span(),
                value: value.get_ref(),
            })
            .collect();
        entries.sort_by_key(|entry| entry.key_place.start);
        entries
    }

    pub(crate) fn find(&self, key: &str) -> Option<TomlEntry<'t>> {
        self.entries().into_iter().find(|entry| entry.key == key)
    }

    /// The entry of that key, which must be there.
    pub(crate) fn require(&self, key: &str) -> Result<TomlEntry<'t>, TomlError> {
        self.find(key).ok_or_else(|| self.misread(format_args!("{} lacks `{key}`", self.name)))
    }

    /// Refuses the first key that is none of these.
    pub(crate) fn allow_only(&self, keys: &[&str]) -> Result<(), TomlError> {
        match self.entries().into_iter().find(|entry| !keys.contains(&entry.key)) {
            Some(entry) => Err(entry.unknown_key(&format!("a key of {}", self.name), keys)),
            None => Ok(()),
        }
    }
}

impl<'t> TomlEntry<'t> {
    pub(crate) fn unknown_key(&self, expected: &str, valid: &[&str]) -> TomlError {
        self.text.misread(&self.key_place, Choice { expected, found: self.key, valid })
    }

    pub(crate) fn misread(&self, what: impl fmt::Display) -> TomlError {
        self.text.misread(&self.place, format_args!("`{}`: {what}", self.key))
    }

    /// The value as one of these names.
    pub(crate) fn choice(&self, expected: &str, valid: &[&str]) -> TomlError {
        let found = self.value.as_str().unwrap_or(self.value.type_str());
        self.text.misread(&self.place, format_args!("`{}`: {}", self.key, Choice { expected, found, valid }))
    }

    /// The value as a finite number.
    pub(crate) fn number(&self) -> Result<f64, TomlError> {
        number(self.value).map_err(|found| self.misread(format_args!("expected a finite number, found {found}")))
    }

    /// The value as a finite number that is not negative.
    pub(crate) fn not_negative(&self) -> Result<f64, TomlError> {
        match self.number()? {
            number if number >= 0.0 => Ok(number),
            number => Err(self.misread(format_args!("expected zero or more, found {number}"))),
        }
    }

    /// The value as a finite number above zero.
    pub(crate) fn positive(&self) -> Result<f64, TomlError> {
        match self.number()? {
            number if number > 0.0 => Ok(number),
            number => Err(self.misread(format_args!("expected more than zero, found {number}"))),
        }
    }

    /// The value as a whole number between two.
    pub(crate) fn whole(&self, least: f64, most: f64) -> Result<f64, TomlError> {
        match self.number()? {
            number if (least..=most).contains(&number) && libm::floor(number) >= number => Ok(number),
            number => Err(self.misread(format_args!("expected a whole number from {least} to {most}, found {number}"))),
        }
    }

    pub(crate) fn text(&self) -> Result<&'t str, TomlError> {
        self.value.as_str().ok_or_else(|| self.misread(format_args!("expected a text, found {}", self.value.type_str())))
    }

    /// The value as three finite numbers.
    pub(crate) fn vector(&self) -> Result<[f64; 3], TomlError> {
        let refuse = |found: String| self.misread(format_args!("expected three finite numbers [x, y, z], found {found}"));
        array(self.value).map_err(refuse)
    }

    /// The value as that many finite numbers.
    pub(crate) fn numbers<const N: usize>(&self) -> Result<[f64; N], TomlError> {
        array(self.value).map_err(|found| self.misread(format_args!("expected {N} finite numbers, found {found}")))
    }

    /// The value as that many texts.
    pub(crate) fn texts<const N: usize>(&self) -> Result<[&'t str; N], TomlError> {
        let refuse = |found: String| self.misread(format_args!("expected {N} names, found {found}"));
        let elements = self.value.as_array().ok_or_else(|| refuse(self.value.type_str().to_owned()))?;
        let text =
            |one: &'t Spanned<DeValue<'t>>| one.get_ref().as_str().ok_or_else(|| refuse(one.get_ref().type_str().to_owned()));
        let texts = elements.iter().map(text).collect::<Result<Vec<&str>, TomlError>>()?;
        <[&str; N]>::try_from(texts).map_err(|texts| refuse(format!("{}", texts.len())))
    }

    /// The value as pairs of finite numbers.
    pub(crate) fn pairs(&self) -> Result<Vec<[f64; 2]>, TomlError> {
        let refuse = |found: String| self.misread(format_args!("expected pairs of finite numbers, found {found}"));
        let pairs = self.value.as_array().ok_or_else(|| refuse(self.value.type_str().to_owned()))?;
        pairs.iter().map(|pair| array(pair.get_ref()).map_err(refuse)).collect()
    }

    pub(crate) fn table(&self, name: &str) -> Result<TomlTable<'t>, TomlError> {
        let entries = self
            .value
            .as_table()
            .ok_or_else(|| self.misread(format_args!("expected a table, found {}", self.value.type_str())))?;
        Ok(TomlTable { text: self.text, entries, place: self.key_place.clone(), name: name.to_owned() })
    }

    /// The value as an array of tables.
    pub(crate) fn tables(&self, name: &str) -> Result<Vec<TomlTable<'t>>, TomlError> {
        let refuse = |place: &TomlPlace, found: &str| {
            self.text.misread(place, format_args!("`{}`: expected tables, found {found}", self.key))
        };
        let array = self.value.as_array().ok_or_else(|| refuse(&self.place, self.value.type_str()))?;
        let table = |element: &'t Spanned<DeValue<'t>>| match element.get_ref().as_table() {
            Some(entries) => Ok(TomlTable { text: self.text, entries, place: element.span(), name: name.to_owned() }),
            None => Err(refuse(&element.span(), element.get_ref().type_str())),
        };
        array.iter().map(table).collect()
    }
}

/// That many finite numbers; else what was found.
fn array<const N: usize>(value: &DeValue<'_>) -> Result<[f64; N], String> {
    let elements = value.as_array().ok_or_else(|| value.type_str().to_owned())?;
    let numbers = elements.iter().map(|element| number(element.get_ref())).collect::<Result<Vec<f64>, String>>()?;
    <[f64; N]>::try_from(numbers).map_err(|numbers| format!("{} numbers", numbers.len()))
}

/// A finite number out of an integer or a float; else what was found.
fn number(value: &DeValue<'_>) -> Result<f64, String> {
    let parsed = match value {
        DeValue::Float(float) => float.as_str().parse::<f64>().ok(),
        DeValue::Integer(integer) => i64::from_str_radix(integer.as_str(), integer.radix()).ok().map(|exact| exact as f64),
        other => return Err(other.type_str().to_owned()),
    };
    match (parsed, value) {
        (Some(number), _) if number.is_finite() => Ok(number),
        (_, DeValue::Float(float)) => Err(float.as_str().to_owned()),
        (_, DeValue::Integer(integer)) => Err(integer.as_str().to_owned()),
        _ => Err("no number".to_owned()),
    }
}

/// A wrong name: what was expected, what was found, the nearest valid name, and all of them.
struct Choice<'c> {
    expected: &'c str,
    found: &'c str,
    valid: &'c [&'c str],
}

impl fmt::Display for Choice<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "expected {}, found `{}`", self.expected, self.found)?;
        match nearest(self.found, self.valid) {
            Some(name) => write!(f, "; nearest is `{name}` (of {})", self.valid.join(" ")),
            None => write!(f, " (one of {})", self.valid.join(" ")),
        }
    }
}

/// The valid name with the fewest edits from what was found.
pub(crate) fn nearest<'v>(found: &str, valid: &[&'v str]) -> Option<&'v str> {
    valid.iter().copied().min_by_key(|name| edits(found, name))
}

/// Insertions, deletions and replacements from one text to the other, letter case free (Levenshtein's distance).
fn edits(from: &str, to: &str) -> usize {
    let from: Vec<char> = from.to_lowercase().chars().collect();
    let mut row: Vec<usize> = (0..=from.len()).collect();
    for (line, wanted) in to.to_lowercase().chars().enumerate() {
        let mut diagonal = row.first().copied().unwrap_or_default();
        let mut left = line + 1;
        let mut next = vec![left];
        for (&letter, &above) in from.iter().zip(row.iter().skip(1)) {
            left = (diagonal + usize::from(letter != wanted)).min(above + 1).min(left + 1);
            diagonal = above;
            next.push(left);
        }
        row = next;
    }
    row.last().copied().unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn edits_are_those_counted_by_hand() {
        assert_eq!([edits("pedal", "pedal"), edits("", "abc"), edits("kitten", "sitting"), edits("abc", "")], [0, 3, 3, 3]);
        assert_eq!(nearest("lat_ciclic", &["pedal", "lon_cyclic", "lat_cyclic"]), Some("lat_cyclic"));
        assert_eq!(nearest("x", &[]), None);
    }

    #[test]
    fn places_are_lines_and_columns_in_characters() {
        let text = TomlText("'é' = 1\n'äö' = [1, 'x']\n");
        let root = text.parse().unwrap();
        let table = TomlTable::root(text, &root);
        let error = table.require("äö").unwrap().vector().unwrap_err();
        assert_eq!((error.line, error.column), (2, 8));
        assert!(error.what.contains("found string"), "{error}");
        let not_toml = TomlText("a = \n").parse().unwrap_err();
        assert_eq!(not_toml.line, 1, "{not_toml}");
    }

    #[test]
    fn numbers_are_finite_whatever_their_form() {
        let text = TomlText("a = 0x10\nb = 1_000\nc = inf\nd = 1e400\ne = true\nf = -2");
        let root = text.parse().unwrap();
        let of = |key: &str| TomlTable::root(text, &root).require(key).unwrap().number();
        assert_eq!((of("a"), of("b"), of("f")), (Ok(16.0), Ok(1000.0), Ok(-2.0)));
        for wrong in ["c", "d", "e"] {
            assert!(of(wrong).is_err(), "{wrong}");
        }
    }
}
